//! `project_symmetric`, the numeric projection for stencils without a closed form.

use crate::cases::Random;
use mechanics_core::projection::{Projection, project_symmetric};
use nalgebra::{SMatrix, SVector};

/// Q Λ Qᵀ with a random orthogonal Q (Householder reflections).
fn planted<const N: usize>(random: &mut Random, values: &SVector<f64, N>) -> [SMatrix<f64, N, N>; 2] {
    let mut q = SMatrix::<f64, N, N>::identity();
    for _ in 0..N {
        let v = SVector::<f64, N>::from_fn(|_, _| random.uniform()).normalize();
        q -= v * (v.transpose() * q) * 2.0;
    }
    [q, q * SMatrix::from_diagonal(values) * q.transpose()]
}

fn sweep<const N: usize>(seed: u64) {
    let mut random = Random::new(seed);
    for case in 0..300 {
        let scale = [1.0, 1e150, 1e-150, 1e-300][case % 4];
        let mut values = SVector::<f64, N>::from_fn(|_, _| random.uniform());
        match case % 5 {
            0 => values.fill(-0.5),
            1 => values = values.map(|value| if value < 0.0 { -1.0 } else { 1.0 }),
            2 => values = values.map(|value| value.signum() * 10.0_f64.powf(-8.0 * value.abs())),
            _ => {}
        }
        let values = values * scale;
        let [q, matrix] = planted(&mut random, &values);
        for projection in [Projection::None, Projection::Clamp, Projection::Absolute] {
            let replaced = values.map(|value| match projection {
                Projection::None => value,
                Projection::Clamp => value.max(0.0),
                Projection::Absolute => value.abs(),
            });
            let expected = q * SMatrix::from_diagonal(&replaced) * q.transpose();
            let result = project_symmetric(&matrix, projection);
            let error = (result - expected).amax() / values.amax();
            assert!(
                error <= 10.0 * N as f64 * f64::EPSILON,
                "N = {N}, case {case} {projection:?}: {error:e}"
            );
            assert_eq!(result, result.transpose());
        }
    }
}

#[test]
fn planted_spectra_are_projected() {
    sweep::<1>(31);
    sweep::<2>(32);
    sweep::<6>(33);
    sweep::<9>(34);
    sweep::<12>(35);
}

#[test]
fn awkward_matrices_are_handled() {
    let zero = SMatrix::<f64, 6, 6>::zeros();
    assert_eq!(project_symmetric(&zero, Projection::Clamp), zero);
    let negative = SMatrix::<f64, 3, 3>::identity() * -f64::MAX;
    assert_eq!(project_symmetric(&negative, Projection::Clamp), SMatrix::<f64, 3, 3>::zeros());
    assert_eq!(project_symmetric(&negative, Projection::Absolute), -negative);
    let mut nan = SMatrix::<f64, 4, 4>::identity() * -1.0;
    nan[(2, 1)] = f64::NAN;
    assert!(project_symmetric(&nan, Projection::Clamp)[(1, 2)].is_nan());
    // A definite matrix comes back bit by bit.
    let definite = SMatrix::<f64, 2, 2>::new(2.0, 0.1, 0.1, 3.0);
    assert_eq!(project_symmetric(&definite, Projection::Clamp), definite);
    // Subnormal entries.
    let tiny = SMatrix::<f64, 2, 2>::new(-1e-310, 0.0, 0.0, 1e-310);
    let clamped = project_symmetric(&tiny, Projection::Clamp);
    assert_eq!(clamped[(0, 0)], 0.0);
    assert!((clamped[(1, 1)] - 1e-310).abs() < 1e-322);
}

#[test]
fn eigenvalues_keep_nan() {
    for projection in [Projection::None, Projection::Clamp, Projection::Absolute] {
        assert!(projection.apply(f64::NAN).is_nan());
    }
    assert_eq!(Projection::Clamp.apply(-2.0_f64), 0.0);
    assert_eq!(Projection::Absolute.apply(-2.0_f32), 2.0);
}
