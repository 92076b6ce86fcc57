//! Polar decomposition.

use super::svd;
use crate::scalar::Scalar;
use crate::tensor::{self, Matrix3};

/// F = R S. See [`polar`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polar<S> {
    /// R, a rotation: det R = +1.
    pub rotation: Matrix3<S>,
    /// S, symmetric.
    pub stretch: Matrix3<S>,
}

impl<S: Scalar> Polar<S> {
    /// The decomposition of the identity.
    #[inline(always)]
    pub fn identity() -> Self {
        let identity = tensor::multiple_of_identity(S::constant(1.0));
        Self { rotation: identity, stretch: identity }
    }
}

/// The polar decomposition F = R S with det R = +1 always and S symmetric.
///
/// R is the rotation nearest to F in the Frobenius norm. S = V diag(σ) Vᵀ with the signed singular values of
/// [`svd`]: positive semi-definite where det F ≥ 0; for an inverted F its smallest eigenvalue in magnitude is negative. R is unique unless
/// σ₁ + σ₂ = 0 (rank one and zero, and mirrors whose two smallest singular values agree); then it is one of the
/// nearest rotations. The error of R is ε σ₀ / (σ₁ + σ₂), the condition of the problem.
#[inline(always)]
pub fn polar<S: Scalar>(f: &Matrix3<S>) -> Polar<S> {
    let svd = svd(f);
    Polar {
        rotation: tensor::product_transpose(&svd.u, &svd.v),
        // Rounding leaves the two halves different.
        stretch: tensor::symmetric_part(&tensor::product_diagonal_transpose(&svd.v, &svd.sigma, &svd.v)),
    }
}
