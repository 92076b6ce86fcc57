//! The fast polar factor against the decomposition.

use crate::sample::Numbers;
use mechanics_core::decomposition::{polar, svd};
use mechanics_core::tensor::{Mat3, Matrix3};
use mpm_constitutive::elastic::nearest_rotation;
use nalgebra::Vector3;

/// R of both methods, relative to the condition of the problem, σ₀/(σ₁ + σ₂).
fn disagreement(f: &Mat3) -> f64 {
    let sigma = svd(f).sigma;
    (nearest_rotation(f) - polar(f).rotation).norm() * (sigma[1] + sigma[2]) / sigma[0]
}

#[test]
fn equals_the_polar_factor_over_twelve_decades_of_strain() {
    let mut numbers = Numbers(5);
    for exponent in -12..=0 {
        let size = 3.0 * 10_f64.powi(exponent);
        for _ in 0..50 {
            let f = numbers.deformation(size);
            assert!(disagreement(&f) < 1e-14, "{:e} at {f}", disagreement(&f));
        }
    }
}

#[test]
fn equals_the_polar_factor_for_hard_matrices() {
    let mut numbers = Numbers(6);
    for sigma in [
        [1e3, 1.0, 1e-3],
        [1.0, 1.0, 1e-9],
        [2.0, 1.0, -0.5],
        [1.0, 0.5, 0.0],
        [1e150, 1e149, 1e149],
        [1e-90, 1e-90, 3e-91],
    ] {
        let f = numbers.rotation() * Mat3::from_diagonal(&Vector3::from(sigma)) * numbers.rotation();
        let r = nearest_rotation(&f);
        assert!((r.transpose() * r - Mat3::identity()).norm() < 1e-14, "{sigma:?}");
        assert!((r.determinant() - 1.0).abs() < 1e-14, "{sigma:?}");
        assert!(disagreement(&f) < 2e-14, "{sigma:?}: {:e}", disagreement(&f));
    }
    assert!(nearest_rotation(&Mat3::repeat(f64::NAN)).iter().all(|x| x.is_nan()));
    assert!(nearest_rotation(&Mat3::repeat(f64::INFINITY)).iter().all(|x| x.is_nan()));
}

#[test]
fn single_precision_agrees_with_double() {
    let mut numbers = Numbers(7);
    for _ in 0..500 {
        let f = numbers.deformation(0.5);
        let single: Matrix3<f32> = f.map(|x| x as f32);
        let error = (nearest_rotation(&single).map(f64::from) - nearest_rotation(&f)).norm();
        assert!(error < 1.5e-6, "{error:e}");
    }
}
