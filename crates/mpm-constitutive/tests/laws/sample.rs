//! Deformation gradients and the few tensors that tests need beside those of the crate.

#![allow(dead_code, reason = "each test program uses a part")]

use mechanics_core::tensor::Mat3;
use nalgebra::Rotation3;

/// Pseudo-random numbers in [−1, 1).
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn rotation(&mut self) -> Mat3 {
        let (a, b, c) = (3.0 * self.next(), 1.5 * self.next(), 3.0 * self.next());
        Rotation3::from_euler_angles(a, b, c).into_inner()
    }

    /// A gradient whose logarithmic stretches are up to `size`.
    pub(crate) fn deformation(&mut self, size: f64) -> Mat3 {
        let stretch = Mat3::from_diagonal(&nalgebra::Vector3::from_fn(|_, _| (size * self.next()).exp()));
        self.rotation() * stretch * self.rotation().transpose()
    }
}

/// ½ ln(F Fᵀ), by nalgebra's eigenvectors.
pub(crate) fn log_strain(f: &Mat3) -> Mat3 {
    let eigen = (f * f.transpose()).symmetric_eigen();
    eigen.eigenvectors
        * Mat3::from_diagonal(&eigen.eigenvalues.map(|l| 0.5 * l.ln()))
        * eigen.eigenvectors.transpose()
}

pub(crate) fn pressure(tau: &Mat3) -> f64 {
    -tau.trace() / 3.0
}

pub(crate) fn deviator(a: &Mat3) -> Mat3 {
    a - Mat3::identity() * (a.trace() / 3.0)
}

/// √(3/2)‖dev τ‖.
pub(crate) fn von_mises_stress(tau: &Mat3) -> f64 {
    1.5_f64.sqrt() * deviator(tau).norm()
}

#[track_caller]
pub(crate) fn assert_close(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!(
        (a - b).abs() <= tolerance,
        "{what}: {a} and {b} differ by {:e}, more than {tolerance:e}",
        (a - b).abs()
    );
}
