//! Stress is the derivative of the energy, stiffness is bounded, and neither sees a rotation.

use crate::materials::{
    LAMBDA, MU, STIFF, SolidLaw, Visitor, history, lame, numbers_of, returned, visit_all,
};
use crate::sample::{Numbers, assert_close};
use mechanics_core::jet::Jet2;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Mat3, Matrix3, from_entries};
use mpm_constitutive::elastic::{Hencky, Linear};
use mpm_constitutive::{PointLaw, StiffnessBound};
use nalgebra::SMatrix;

/// Largest logarithmic stretches.
const SIZES: [f64; 3] = [1e-3, 0.4, 1.2];

struct StressIsDerivative(Numbers);

impl Visitor for StressIsDerivative {
    fn visit<L: SolidLaw>(&mut self, name: &str, law: &L, histories: &[&[f64]]) {
        for (size, numbers) in SIZES.iter().flat_map(|size| histories.iter().map(move |h| (*size, *h))) {
            for _ in 0..20 {
                let f = self.0.deformation(size);
                check_stress(name, law, &f, numbers);
            }
        }
        // Repeated singular values.
        check_stress(name, law, &(self.0.rotation() * 1.3), histories[0]);
        check_stress(name, law, &Mat3::identity(), histories[0]);
    }
}

/// ψ(F + t D) to second order in t.
fn energy_along<L: SolidLaw>(law: &L, f: &Mat3, direction: &Mat3, numbers: &[f64]) -> Jet2<f64, 1> {
    let [t] = Jet2::variables([0.0]);
    let moved: Matrix3<Jet2<f64, 1>> = from_entries(|i, j| t.scale(direction[(i, j)]).offset(f[(i, j)]));
    law.energy_density(&L::strain(&moved), &history::<L, _>(numbers))
}

fn check_stress<L: SolidLaw>(name: &str, law: &L, f: &Mat3, numbers: &[f64]) {
    let first_piola = Mat3::from_fn(|i, j| {
        let direction = Mat3::from_fn(|a, b| if (a, b) == (i, j) { 1.0 } else { 0.0 });
        energy_along(law, f, &direction, numbers).gradient[0]
    });
    let expected = first_piola * f.transpose();
    let tau = law.stress(&L::strain(f), &history::<L, f64>(numbers)).kirchhoff;
    let error = (tau - expected).norm()
        / (STIFF * f.norm_squared().max(1.0) * f.determinant().max(1.0)).max(tau.norm());
    assert!(error < 1e-12, "{name} at {f} with {numbers:?}: relative error {error:e}");
}

#[test]
fn stress_is_the_derivative_of_the_energy() {
    let mut check = StressIsDerivative(Numbers(1));
    visit_all(&mut check);
    check.visit("linear", &Linear::new(lame()), &[&[]]);
}

struct Objective(Numbers);

impl Visitor for Objective {
    fn visit<L: SolidLaw>(&mut self, name: &str, law: &L, histories: &[&[f64]]) {
        for (size, numbers) in SIZES.iter().flat_map(|size| histories.iter().map(move |h| (*size, *h))) {
            for _ in 0..10 {
                let (f, q, r) = (self.0.deformation(size), self.0.rotation(), self.0.rotation());
                let [mut a, mut b] = [history::<L, f64>(numbers); 2];
                let (f_a, tau_a) = returned(law, &f, &mut a);
                let (f_b, tau_b) = returned(law, &(q * f * r), &mut b);
                let measure = 1e-12 * STIFF.max(tau_a.norm()) * f.norm_squared().max(1.0);
                assert!((q * tau_a * q.transpose() - tau_b).norm() < measure, "{name}: stress at {f}");
                assert!((q * f_a * r - f_b).norm() < 1e-12 * f.norm(), "{name}: strain at {f}");
                for (x, y) in numbers_of::<L>(&a).iter().zip(numbers_of::<L>(&b)) {
                    assert_close(*x, y, 1e-12, name);
                }
            }
        }
    }
}

#[test]
fn rotations_of_space_and_of_the_material_change_nothing_but_axes() {
    visit_all(&mut Objective(Numbers(2)));
}

struct Bounded(Numbers);

impl Visitor for Bounded {
    fn visit<L: SolidLaw>(&mut self, name: &str, law: &L, histories: &[&[f64]]) {
        for (size, numbers) in SIZES.iter().flat_map(|size| histories.iter().map(move |h| (*size, *h))) {
            for _ in 0..10 {
                let f = self.0.deformation(size);
                let gap = smallest_gap(law, &f, numbers);
                assert!(gap > -1e-9 * STIFF * f.norm_squared(), "{name}: {gap} at {f} with {numbers:?}");
            }
        }
    }
}

/// The second derivative of ψ((I + G)F) by G, at G = 0, from those along 45 straight lines (one variable at a time keeps the
/// code small).
fn second_derivative<L: SolidLaw>(law: &L, f: &Mat3, numbers: &[f64]) -> SMatrix<f64, 9, 9> {
    let unit = |k: usize| Mat3::from_fn(|i, j| if 3 * j + i == k { 1.0 } else { 0.0 });
    let along = |g: Mat3| energy_along(law, f, &(g * f), numbers).hessian(0, 0);
    let diagonal: Vec<f64> = (0..9).map(|k| along(unit(k))).collect();
    let mixed = |i: usize, j: usize| 0.5 * (along(unit(i) + unit(j)) - diagonal[i] - diagonal[j]);
    SMatrix::from_fn(|i, j| if i == j { diagonal[i] } else { mixed(i.min(j), i.max(j)) })
}

/// The smallest eigenvalue of λ̂ I⊗I + 2μ̂ − d²ψ.
fn smallest_gap<L: SolidLaw>(law: &L, f: &Mat3, numbers: &[f64]) -> f64 {
    let bound = law.stress(&L::strain(f), &history::<L, f64>(numbers)).stiffness;
    let identity = SMatrix::<f64, 9, 1>::from_fn(|k, _| if k % 4 == 0 { 1.0 } else { 0.0 });
    let bounding = identity * identity.transpose() * bound.lambda + SMatrix::identity() * (2.0 * bound.mu);
    (bounding - second_derivative(law, f, numbers)).symmetric_eigenvalues().min()
}

#[test]
fn stiffness_is_bounded_for_every_further_deformation() {
    let mut check = Bounded(Numbers(3));
    visit_all(&mut check);
    let mut numbers = Numbers(4);
    for _ in 0..30 {
        let f = Mat3::identity() + Mat3::from_fn(|_, _| 0.5 * numbers.next());
        let gap = smallest_gap(&Linear::new(lame()), &f, &[]);
        assert!(gap > -1e-9 * STIFF, "linear: {gap} at {f}");
        // Inverted ones too, for the law that has them.
        let f = Mat3::from_fn(|_, _| numbers.next());
        let gap = smallest_gap(&mpm_constitutive::elastic::FixedCorotated::new(lame()), &f, &[]);
        assert!(gap > -1e-7 * STIFF, "fixed corotated: {gap} at {f}");
    }
}

struct SharpAtRest;

impl Visitor for SharpAtRest {
    fn visit<L: SolidLaw>(&mut self, name: &str, law: &L, histories: &[&[f64]]) {
        let stress = law.stress(&L::strain(&Mat3::identity()), &history::<L, f64>(histories[0]));
        let StiffnessBound { lambda, mu } = stress.stiffness;
        assert!(stress.kirchhoff.norm() < 1e-12 * STIFF, "{name}");
        let gap = smallest_gap(law, &Mat3::identity(), histories[0]);
        assert!(gap.abs() < 1e-9 * STIFF, "{name}");
        if name != "snow" {
            assert_close(lambda, LAMBDA, 1e-9, name);
            assert_close(mu, MU, 1e-9, name);
        }
    }
}

#[test]
fn the_bound_is_sharp_at_rest() {
    visit_all(&mut SharpAtRest);
    SharpAtRest.visit("linear", &Linear::new(lame()), &[&[]]);
    // c = √((λ + 2μ)/ρ)
    let speed = Hencky::new(lame()).stress(&Mat3::identity(), &()).stiffness.wave_speed(1000.0);
    assert_close(speed, (STIFF / 1000.0).sqrt(), 1e-12, "wave speed");
}

/// Known elsewhere: an extra factor σ in the stress. Uniaxial stretch by 2 must give τ = (2μ + λ) ln 2.
#[test]
fn hencky_stress_has_no_factor_of_the_stretch() {
    let f = Mat3::from_diagonal(&nalgebra::Vector3::new(2.0, 1.0, 1.0));
    let tau = Hencky::new(lame()).stress(&f, &()).kirchhoff;
    assert_close(tau[(0, 0)], STIFF * 2.0_f64.ln(), 1e-8, "axial");
    assert_close(tau[(1, 1)], LAMBDA * 2.0_f64.ln(), 1e-8, "lateral");
}
