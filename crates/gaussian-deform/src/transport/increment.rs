//! Shapes from velocity gradients, for solvers that do not keep the total deformation.

use mechanics_core::parallel;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Mat3, Matrix3};

/// F ← (I + h ∇v) F, for every sample: total gradients after one more step of length h \[s\] of a solver that has velocity gradients \[1/s\] only.
///
/// Start from identities and lend the result to [`Transport::deform`](super::Transport::deform): half-axes are then those of [`advance_axes`], and colours turn with the rotation of
/// the whole motion. (Rotations of single steps cannot be multiplied: in a motion that shears they lead elsewhere.)
///
/// # Panics
/// If there are not as many velocity gradients as gradients.
pub fn advance_gradients(gradients: &mut [Mat3], velocity_gradients: &[Mat3], step: f64) {
    assert_eq!(gradients.len(), velocity_gradients.len(), "a velocity gradient for each sample");
    parallel::for_each_chunk(gradients, super::CHUNK, |first, part| {
        for (f, rate) in part.iter_mut().zip(&velocity_gradients[first..]) {
            *f = advance_axes(f, rate, step);
        }
    });
}

/// B ← (I + h ∇v) B: half-axes after one more step of length h.
///
/// What comes of many steps is exactly F A Fᵀ with F the product of the increments, as an explicit solver multiplies them. Its error is that of the product, of order h.
#[inline(always)]
pub fn advance_axes<S: Scalar>(axes: &Matrix3<S>, velocity_gradient: &Matrix3<S>, step: S) -> Matrix3<S> {
    tensor::add_scaled(axes, step, &tensor::product(velocity_gradient, axes))
}

/// A ← A + h (∇v A + A ∇vᵀ): a covariance (xx, xy, xz, yy, yz, zz) after one more step of length h \[s\].
///
/// The published incremental update. It drops h² ∇v A ∇vᵀ, so that a rotating Gaussian, whose A must keep its size, does not keep it quite, and A may
/// lose its definiteness: [`advance_axes`] does neither, at the same price, and the total deformation gradient is better than both.
///
/// # Reference
/// Xie et al. (2024), *PhysGaussian*, section 3.6.
#[inline(always)]
pub fn advance_covariance<S: Scalar>(
    [xx, xy, xz, yy, yz, zz]: [S; 6],
    velocity_gradient: &Matrix3<S>,
    step: S,
) -> [S; 6] {
    let a = tensor::from_columns([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    let rate = tensor::product(velocity_gradient, &a);
    let rate = tensor::sum(&rate, &tensor::transpose(&rate));
    let a = tensor::add_scaled(&a, step, &rate);
    let c = tensor::columns(&a);
    [c[0][0], c[1][0], c[2][0], c[1][1], c[2][1], c[2][2]]
}
