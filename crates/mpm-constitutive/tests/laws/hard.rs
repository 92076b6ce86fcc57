//! Deformations that break careless code: finite answers, or a typed error.

use crate::materials::{SolidLaw, Visitor, history, numbers_of, visit_all};
use crate::sample::Numbers;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Mat3, Matrix3, trace};
use nalgebra::Vector3;

fn hard_matrices() -> Vec<Mat3> {
    let mut numbers = Numbers(21);
    let mut list = vec![Mat3::zeros(), Mat3::identity(), Mat3::repeat(1.0), Mat3::repeat(f64::NAN)];
    for sigma in [
        [1e3, 1.0, 1e-3],
        [1e6, 1.0, 1.0],
        [1.0, 1.0, 1e-6],
        [1.0, 1e-6, 1e-6],
        [1.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, -1.0],
        [2.0, 1.0, -1e-3],
        [1e-12, 1e-12, 1e-12],
        [1e12, 1e12, 1e12],
        [1e30, 1.0, 1e-30],
        [1e60, 1e60, 1e60],
        [1e200, 1e200, 1e200],
    ] {
        list.push(Mat3::from_diagonal(&Vector3::from(sigma)));
        list.push(numbers.rotation() * Mat3::from_diagonal(&Vector3::from(sigma)) * numbers.rotation());
    }
    let mut infinite = Mat3::identity();
    infinite[(1, 2)] = f64::INFINITY;
    list.push(infinite);
    list
}

struct FiniteOrRefused;

impl FiniteOrRefused {
    fn check<L: SolidLaw, S: Scalar<Mask = bool> + Into<f64>>(
        name: &str,
        law: &L,
        f: &Mat3,
        numbers: &[f64],
    ) -> bool {
        let f: Matrix3<S> = f.map(S::constant);
        let (strain, mut after) = (L::strain(&f), history::<L, S>(numbers));
        let admissible = law.check_admissible(&strain, &after);
        let stress = law.stress(&strain, &after).kirchhoff;
        assert_eq!(
            admissible.is_ok(),
            trace(&stress).is_finite(),
            "{name}: {admissible:?} for {stress:?} at {f:?}"
        );
        let (returned, stress) = law.return_map(&strain, &mut after, 1e-3);
        if admissible.is_ok() {
            // (The strain returned may be stored with too few digits for its smallest stretch: then the next step refuses it.)
            let finite = trace(&stress.kirchhoff).is_finite();
            assert!(
                finite || law.check_admissible(&returned, &after).is_err(),
                "{name}: returned from {f:?}"
            );
            assert!(!finite || L::gradient(&returned).iter().all(|x| x.is_finite()), "{name}: {f:?}");
        } else if !f.iter().all(|x| x.is_finite()) {
            assert!(!trace(&stress.kirchhoff).is_finite(), "{name}: {f:?} gives {:?}", stress.kirchhoff);
        }
        admissible.is_ok()
    }
}

impl Visitor for FiniteOrRefused {
    fn visit<L: SolidLaw>(&mut self, name: &str, law: &L, histories: &[&[f64]]) {
        let mut accepted = 0;
        for f in hard_matrices() {
            accepted += usize::from(Self::check::<L, f64>(name, law, &f, histories[0]));
            Self::check::<L, f32>(name, law, &f, histories[0]);
        }
        assert!(accepted >= 8, "{name} accepts only {accepted}");
    }
}

#[test]
fn hard_deformations_give_finite_stress_or_a_typed_error() {
    visit_all(&mut FiniteOrRefused);
}

struct HistoriesStaySound(Numbers);

impl Visitor for HistoriesStaySound {
    fn visit<L: SolidLaw>(&mut self, name: &str, law: &L, histories: &[&[f64]]) {
        for numbers in histories {
            let (mut f, mut state) = (Mat3::identity(), history::<L, f64>(numbers));
            for step in 0..400 {
                // Kneaded by 30 % a step, ten times as hard now and then.
                let size = if step % 37 == 0 { 2.0 } else { 0.3 };
                let (strain, stress) =
                    law.return_map(&L::strain(&(self.0.deformation(size) * f)), &mut state, 1e-3);
                f = L::gradient(&strain);
                if numbers_of::<L>(&state).is_empty() && law.check_admissible(&strain, &state).is_err() {
                    f = Mat3::identity();
                    continue;
                }
                assert!(stress.kirchhoff.iter().all(|x| x.is_finite()), "{name} after {step} steps");
                assert!(numbers_of::<L>(&state).iter().all(|x| x.is_finite()), "{name} after {step} steps");
            }
        }
    }
}

#[test]
fn kneaded_for_long_every_history_stays_finite() {
    visit_all(&mut HistoriesStaySound(Numbers(22)));
}
