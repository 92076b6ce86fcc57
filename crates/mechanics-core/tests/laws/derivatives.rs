//! P and ∂P/∂F against automatic differentiation of ψ and P.

use crate::cases::{Random, Visit, each_law, lame, special};
use mechanics_core::jet::{Jet1, Jet2};
use mechanics_core::law::{Domain, FixedCorotated, Hencky, Hyperelastic};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Mat3, Matrix3};
use nalgebra::SMatrix;

type Mat9 = SMatrix<f64, 9, 9>;

fn first_jets(f: &Mat3) -> Matrix3<Jet1<f64, 9>> {
    tensor::from_entries(|i, j| Jet1::variable(f[(i, j)], 3 * j + i))
}

fn second_jets(f: &Mat3) -> Matrix3<Jet2<f64, 9>> {
    tensor::from_entries(|i, j| Jet2::variable(f[(i, j)], 3 * j + i))
}

fn as_mat3(gradient: &[f64; 9]) -> Mat3 {
    Mat3::from_column_slice(gradient)
}

/// ∂P/∂F by automatic differentiation of P.
fn differentiated_stress<L: Hyperelastic>(law: &L, f: &Mat3) -> Mat9 {
    let p = law.first_piola(&first_jets(f));
    Mat9::from_fn(|row, column| p[(row % 3, row / 3)].gradient[column])
}

fn hessian(jet: &Jet2<f64, 9>) -> Mat9 {
    Mat9::from_fn(|i, j| jet.hessian(i, j))
}

/// P may be off by 1e-12 of itself and by what a few last digits of F change.
fn assert_stress(name: &str, f: &Mat3, p: &Mat3, expected: &Mat3, stiffness: &Mat9) {
    let allowed = 1e-12 * expected.norm() + 1e-14 * stiffness.norm() * f.norm().max(1.0);
    let error = (p - expected).norm();
    assert!(error <= allowed, "{name}: stress off by {error:e} (allowed {allowed:e}) at {f}");
}

fn assert_stiffness(name: &str, f: &Mat3, c: &Mat9, expected: &Mat9) {
    let error = (c - expected).norm() / expected.norm();
    assert!(error <= 1e-12, "{name}: stiffness off by {error:e} at {f}{c}{expected}");
}

struct Derivatives;

impl Visit for Derivatives {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
        let mut random = Random::new(1);
        let mut cases: Vec<Mat3> = (0..300).map(|_| random.moderate()).collect();
        cases.extend((0..50).map(|_| Mat3::identity() + random.matrix() * 1e-12));
        cases.extend([1e-9, 1e-6, 1e-3].map(|s| Mat3::identity() + random.matrix() * s));
        cases.extend((0..50).map(|_| random.with_stretches([1.3, 1.3, 0.7])));
        cases.extend((0..50).map(|_| random.with_stretches([1.3, 1.3 + 1e-10, 1.3])));
        cases.extend([special()[0], special()[2], special()[3], special()[10]]);
        if law.domain() == Domain::EveryDeformation {
            cases.extend((0..200).map(|_| random.matrix() * 2.0));
            cases.extend((0..50).map(|_| random.with_stretches([1.3, 0.8, 0.0])));
        }
        for f in &cases {
            let stiffness = law.stiffness(f, Projection::None).to_matrix();
            let stress = law.first_piola(f);
            let first = law.energy_density(&first_jets(f));
            let second = law.energy_density(&second_jets(f));
            assert_eq!(first.value, second.value, "{name}: values through jets of both orders");
            let energy = law.energy_density(f);
            assert!(
                (energy - first.value).abs() <= 1e-13 * energy.abs() + 1e-30,
                "{name}: value through jets"
            );
            assert_stress(name, f, &stress, &as_mat3(&first.gradient), &stiffness);
            assert_stress(name, f, &stress, &as_mat3(&second.gradient), &stiffness);
            assert_stiffness(name, f, &stiffness, &hessian(&second));
            assert_stiffness(name, f, &stiffness, &differentiated_stress(law, f));
        }
    }
}

#[test]
fn stress_and_stiffness_are_derivatives_of_the_energy() {
    each_law(&mut Derivatives);
}

/// Far from rest, relative to the size of the result alone.
struct Extremes;

impl Visit for Extremes {
    fn visit<L: Hyperelastic>(&mut self, name: &str, law: &L) {
        let mut random = Random::new(2);
        for scale in [1e-6, 1e-3, 1e3, 1e6] {
            for _ in 0..50 {
                let f = random.moderate() * scale;
                let stiffness = law.stiffness(&f, Projection::None).to_matrix();
                let expected = as_mat3(&law.energy_density(&first_jets(&f)).gradient);
                let error = (law.first_piola(&f) - expected).norm() / expected.norm();
                assert!(error <= 1e-12, "{name}: stress off by {error:e} at scale {scale:e}");
                assert_stiffness(name, &f, &stiffness, &differentiated_stress(law, &f));
            }
        }
    }
}

#[test]
fn stress_and_stiffness_are_derivatives_at_extreme_sizes() {
    each_law(&mut Extremes);
}

// Hencky and fixed corotated use a singular value decomposition and give their derivatives to jets by closed
// formulas. The following energies use none: everything is rational iterations on jets.

fn inverse<S: Scalar>(a: &Matrix3<S>) -> Matrix3<S> {
    tensor::scaled(&tensor::transpose(&tensor::cofactor(a)), tensor::determinant(a).recip())
}

/// Newton's iteration R ← ½(R + R⁻ᵀ), for det F > 0.
fn rotation_by_iteration<S: Scalar>(f: &Matrix3<S>) -> Matrix3<S> {
    (0..14).fold(*f, |r, _| {
        let sum = tensor::sum(&r, &tensor::transpose(&inverse(&r)));
        tensor::scaled(&sum, S::constant(0.5))
    })
}

/// ln C by inverse scaling and squaring: four square roots (Denman–Beavers), then the series of 2 artanh.
fn logarithm_by_iteration<S: Scalar>(c: &Matrix3<S>) -> Matrix3<S> {
    let identity = tensor::multiple_of_identity(S::constant(1.0));
    let root = |a: &Matrix3<S>| {
        let mut pair = (*a, identity);
        for _ in 0..12 {
            let half = |x: &Matrix3<S>, y: &Matrix3<S>| tensor::scaled(&tensor::sum(x, y), S::constant(0.5));
            pair = (half(&pair.0, &inverse(&pair.1)), half(&pair.1, &inverse(&pair.0)));
        }
        pair.0
    };
    let a = (0..4).fold(*c, |a, _| root(&a));
    let x = tensor::product(&tensor::difference(&a, &identity), &inverse(&tensor::sum(&a, &identity)));
    let square = tensor::product(&x, &x);
    let mut power = x;
    let mut series = x;
    for k in 1..14 {
        power = tensor::product(&power, &square);
        series = tensor::add_scaled(&series, S::constant(1.0 / (2 * k + 1) as f64), &power);
    }
    tensor::scaled(&series, S::constant(32.0))
}

fn corotated_energy<S: Scalar>(f: &Matrix3<S>) -> S {
    let shear = tensor::norm_squared(&tensor::difference(f, &rotation_by_iteration(f)));
    let volume = tensor::determinant(f).offset(-1.0).square();
    shear.scale(lame().mu()) + volume.scale(0.5 * lame().lambda())
}

fn hencky_energy<S: Scalar>(f: &Matrix3<S>) -> S {
    let strain = tensor::scaled(&logarithm_by_iteration(&tensor::transpose_product(f, f)), S::constant(0.5));
    tensor::norm_squared(&strain).scale(lame().mu())
        + tensor::trace(&strain).square().scale(0.5 * lame().lambda())
}

fn assert_agrees<L: Hyperelastic>(name: &str, law: &L, f: &Mat3, expected: &Jet2<f64, 9>) {
    let stiffness = law.stiffness(f, Projection::None).to_matrix();
    let energy = law.energy_density(f);
    assert!((energy - expected.value).abs() <= 1e-12 * energy.max(1e-3), "{name}: energy at {f}");
    assert_stress(name, f, &law.first_piola(f), &as_mat3(&expected.gradient), &stiffness);
    let error = (stiffness - hessian(expected)).norm() / stiffness.norm();
    assert!(error <= 1e-12, "{name}: stiffness off by {error:e} at {f}");
}

#[test]
fn laws_with_a_decomposition_agree_with_energies_without_one() {
    let mut random = Random::new(3);
    let mut cases: Vec<Mat3> = (0..100).map(|_| random.moderate()).collect();
    cases.extend((0..50).map(|_| random.with_stretches([1.3, 1.3, 0.7])));
    cases.extend((0..50).map(|_| random.with_stretches([1.3, 1.3 + 1e-9, 1.3 - 1e-12])));
    cases.extend((0..50).map(|_| Mat3::identity() + random.matrix() * 1e-12));
    cases.extend([special()[0], special()[2], special()[3], special()[10]]);
    for f in &cases {
        let jets = second_jets(f);
        assert_agrees("fixed corotated", &FixedCorotated::new(lame()), f, &corotated_energy(&jets));
        assert_agrees("Hencky", &Hencky::new(lame()), f, &hencky_energy(&jets));
    }
}

#[test]
fn inverted_fixed_corotated_agrees_with_its_principal_energy() {
    // Signed stretches from the closed-form eigenvalues of FᵀF, which differentiate well where they are distinct.
    let mut random = Random::new(4);
    for _ in 0..100 {
        let u = 1.0 + 0.1 * random.uniform();
        let f = random.with_stretches([2.0 * u, u, -0.4 * u]);
        let jets = second_jets(&f);
        let c = tensor::transpose_product(&jets, &jets);
        let mean = tensor::trace(&c).scale(1.0 / 3.0);
        let deviator = tensor::difference(&c, &tensor::multiple_of_identity(mean));
        let radius = (tensor::norm_squared(&deviator).scale(1.0 / 6.0)).sqrt();
        let cosine = tensor::determinant(&deviator) / (radius.square() * radius).scale(2.0);
        let angle = cosine.acos().scale(1.0 / 3.0);
        let third = 2.0 * std::f64::consts::FRAC_PI_3;
        let stretch = |turn: f64| (mean + radius.scale(2.0) * angle.offset(turn).cos()).sqrt();
        let trace = stretch(0.0) + stretch(-third) - stretch(third);
        let shear = tensor::norm_squared(&jets) - trace.scale(2.0);
        let volume = tensor::determinant(&jets).offset(-1.0).square();
        let energy = shear.offset(3.0).scale(lame().mu()) + volume.scale(0.5 * lame().lambda());
        assert_agrees("fixed corotated", &FixedCorotated::new(lame()), &f, &energy);
    }
}
