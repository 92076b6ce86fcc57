//! First and second derivatives by the strain against automatic differentiation along random directions.

use crate::materials::{SolidLaw, Visitor, history, lame, visit_all};
use crate::sample::Numbers;
use mechanics_core::jet::Jet2;
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Mat3, Matrix3, from_entries};
use mpm_constitutive::elastic::{Linear, NeoHookean};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::{PointLaw, Stress, TotalDeformation, VolumeChange};

struct Derivatives(Numbers);

impl Visitor for Derivatives {
    fn visit<L: SolidLaw>(&mut self, name: &str, law: &L, histories: &[&[f64]]) {
        for numbers in histories {
            for size in [1e-3, 0.4, 0.8] {
                let (f, d) = (self.0.deformation(size), self.0.deformation(0.7) - Mat3::identity());
                let history = history::<L, f64>(numbers);
                let along = energy_along(law, &f, &d, numbers);
                let strain = L::strain(&f);
                let gradient = L::gradient(&law.energy_gradient(&strain, &history));
                // Forces and stiffnesses of the law, as large as they get at this strain.
                let measure = law.energy_curvature(&L::strain(&f), &history, Projection::Absolute);
                let stiff = L::gradient(&measure.apply(&L::strain(&d))).norm() * d.norm();
                let slope = gradient.dot(&d);
                let error = (slope - along.gradient[0]).abs();
                assert!(error < 1e-11 * (gradient.norm() * d.norm()).max(stiff), "{name}: slope, {error:e}");
                let second = |projection| {
                    let curvature = law.energy_curvature(&strain, &history, projection);
                    L::gradient(&curvature.apply(&L::strain(&d))).dot(&d)
                };
                let error = (second(Projection::None) - along.hessian(0, 0)).abs();
                assert!(error < 1e-9 * stiff, "{name}: curvature, {error:e} of {stiff:e}");
                let clamped = second(Projection::Clamp);
                assert!(clamped >= -1e-10 * stiff && clamped >= along.hessian(0, 0) - 1e-9 * stiff, "{name}");
            }
        }
    }
}

/// ψ(F + t D) to second order in t.
fn energy_along<L: SolidLaw>(law: &L, f: &Mat3, direction: &Mat3, numbers: &[f64]) -> Jet2<f64, 1> {
    let [t] = Jet2::variables([0.0]);
    let moved: Matrix3<Jet2<f64, 1>> = from_entries(|i, j| t.scale(direction[(i, j)]).offset(f[(i, j)]));
    law.energy_density(&L::strain(&moved), &history::<L, _>(numbers))
}

#[test]
fn derivatives_by_the_strain_are_those_of_the_energy() {
    let mut check = Derivatives(Numbers(21));
    visit_all(&mut check);
    check.visit("linear", &Linear::new(lame()), &[&[]]);
}

/// A law that gives its energy and stress only.
struct EnergyAlone(NeoHookean);

impl PointLaw for EnergyAlone {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = ();
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::IsTheStrain;

    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, history: &()) -> S {
        self.0.energy_density(f, history)
    }

    fn stress<S: Scalar>(&self, f: &Matrix3<S>, history: &()) -> Stress<S> {
        self.0.stress(f, history)
    }
}

#[test]
fn a_law_of_energy_alone_has_the_same_derivatives() {
    let (law, mut numbers) = (NeoHookean::new(lame()), Numbers(22));
    let f = numbers.deformation(0.5);
    let d = numbers.deformation(0.5);
    let alone = EnergyAlone(law);
    let (a, b) = (alone.energy_gradient(&f, &()), law.energy_gradient(&f, &()));
    assert!((a - b).norm() < 1e-12 * b.norm());
    for projection in [Projection::None, Projection::Clamp] {
        let a = alone.energy_curvature(&f, &(), projection).apply(&d);
        let b = law.energy_curvature(&f, &(), projection).apply(&d);
        assert!((a - b).norm() < 1e-10 * b.norm(), "{projection:?}: {a} {b}");
    }
}

#[test]
fn a_fluid_has_the_derivatives_of_its_energy() {
    for (tension, exponent) in [(Tension::Carried, 7.0), (Tension::Carried, 1.4), (Tension::Vanishes, 7.0)] {
        let law = Tait::new(2e5, exponent, tension).unwrap();
        for z in [-0.3, -1e-3, 1e-3, 0.2] {
            let [t] = Jet2::<f64, 1>::variables([0.0]);
            let along = law.energy_density(&VolumeChange(t.offset(z)), &());
            let slope = law.energy_gradient(&VolumeChange(z), &()).0;
            let curvature = law.energy_curvature(&VolumeChange(z), &(), Projection::Clamp);
            let second = curvature.apply(&VolumeChange(1.0)).0;
            assert!((slope - along.gradient[0]).abs() < 1e-9 * 2e5 * z.abs(), "{slope}");
            assert!((second - along.hessian(0, 0)).abs() < 1e-9 * second.max(1.0), "{second}");
        }
    }
}
