//! Linear elasticity.

use super::{Domain, Hyperelastic, Lame, Stiffness};
use crate::projection::Projection;
use crate::scalar::Scalar;
use crate::tensor::{Mat3, difference};
use crate::tensor::{
    Matrix3, add_scaled, constant, multiple_of_identity, norm_squared, symmetric_part, trace,
};

/// Small-strain linear elasticity.
///
/// With ε = ½(F + Fᵀ) − I:
///
/// - ψ = μ ε:ε + ½λ tr²ε
/// - P = 2με + λ tr(ε) I
/// - ∂Pᵢⱼ/∂Fₖₗ = μ(δᵢₖδⱼₗ + δᵢₗδⱼₖ) + λ δᵢⱼδₖₗ, constant and positive semi-definite: no projection changes it
///
/// **Not objective**: a rotation by θ stores energy of order θ⁴. Use it for small rotations, and as the limit that
/// the other laws are checked against.
///
/// Domain: every F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    lame: Lame,
}

impl Linear {
    /// The law with the given parameters.
    pub fn new(lame: Lame) -> Self {
        Self { lame }
    }

    #[inline(always)]
    fn strain<S: Scalar>(f: &Matrix3<S>) -> Matrix3<S> {
        symmetric_part(&difference(f, &constant(&Mat3::identity())))
    }
}

impl Hyperelastic for Linear {
    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>) -> S {
        let strain = Self::strain(f);
        norm_squared(&strain).scale(self.lame.mu()) + trace(&strain).square().scale(0.5 * self.lame.lambda())
    }

    #[inline(always)]
    fn first_piola<S: Scalar>(&self, f: &Matrix3<S>) -> Matrix3<S> {
        let strain = Self::strain(f);
        let pressure = multiple_of_identity(trace(&strain).scale(self.lame.lambda()));
        add_scaled(&pressure, S::constant(2.0 * self.lame.mu()), &strain)
    }

    #[inline(always)]
    fn stiffness<S: Scalar>(&self, _f: &Matrix3<S>, _projection: Projection) -> Stiffness<S> {
        let (lambda, mu) = (self.lame.lambda(), self.lame.mu());
        let one = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        Stiffness::from_blocks(|j, l| {
            constant(&Mat3::from_fn(|i, k| {
                mu * (one(i, k) * one(j, l) + one(i, l) * one(j, k)) + lambda * one(i, j) * one(k, l)
            }))
        })
    }

    fn domain(&self) -> Domain {
        Domain::EveryDeformation
    }
}
