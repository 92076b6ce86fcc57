//! The fixed corotated solid.

use super::nearest_rotation;
use super::neo_hookean::largest_eigenvalue_bound;
use crate::{Curvature, PointLaw, StiffnessBound, Stress, TotalDeformation};
use mechanics_core::law::{self, Domain, Hyperelastic, Lame};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{
    Mat3, Matrix3, add_scaled, determinant, difference, multiple_of_identity, product_transpose, scaled,
};

/// Fixed corotated elasticity: of F, only its rotation R is needed, by Newton's method ([`nearest_rotation`]).
///
/// With F = R S, J = det F:
///
/// - ψ = μ‖F − R‖² + ½λ(J − 1)²
/// - P = 2μ(F − R) + λ(J − 1) cof F, hence τ = 2μ(F − R)Fᵀ + λ J(J − 1) I, since (cof F) Fᵀ = J I
///
/// Stiffness: ‖F − R‖² = ‖F‖² − 2 tr S + 3, and tr S is convex along straight lines (its second derivative in the plane of axes i, j
/// is proportional to 1/(σᵢ + σⱼ), and that sum is positive for the signed singular values too). So with d²J = J(tr²G − tr G²)
///
/// d²ψ ≤ 2μ‖GF‖² + λ[J² tr²G + (J − 1)J(tr²G − tr G²)]  ≤  λJ(2J − 1) tr²G + (2μσ₀² + |λJ(J − 1)|) ‖G‖²
///
/// Domain: every F, also inverted ones.
///
/// # Reference
/// Stomakhin, Howes, Schroeder, Teran, Energetically Consistent Invertible Elasticity (SCA 2012).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedCorotated {
    lame: Lame,
}

impl FixedCorotated {
    /// The solid with the given parameters.
    pub fn new(lame: Lame) -> Self {
        Self { lame }
    }
}

/// The bound above, for S-valued parameters λ, μ, the volume ratio J, and σ₀² or more.
#[inline(always)]
pub(crate) fn corotated_stiffness<S: Scalar>(
    lambda: S,
    mu: S,
    volume_ratio: S,
    largest_stretch_squared: S,
) -> StiffnessBound<S> {
    let uniform = lambda * volume_ratio * (volume_ratio + volume_ratio).offset(-1.0);
    let volumetric = (lambda * volume_ratio * volume_ratio.offset(-1.0)).abs();
    StiffnessBound { lambda: uniform, mu: (mu * largest_stretch_squared) + volumetric.scale(0.5) }
}

impl PointLaw for FixedCorotated {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = ();
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::IsTheStrain;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> S {
        law::FixedCorotated::new(self.lame).energy_density(f)
    }

    fn energy_gradient(&self, f: &Mat3, _history: &()) -> Mat3 {
        law::FixedCorotated::new(self.lame).first_piola(f)
    }

    fn energy_curvature(&self, f: &Mat3, _history: &(), projection: Projection) -> Curvature {
        Curvature::Deformation(law::FixedCorotated::new(self.lame).stiffness(f, projection), 1.0)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> Stress<S> {
        let (lambda, mu) = (S::constant(self.lame.lambda()), S::constant(self.lame.mu()));
        let j = determinant(f);
        let largest = largest_eigenvalue_bound(&product_transpose(f, f));
        let kirchhoff = if S::DIFFERENTIATES {
            product_transpose(&law::FixedCorotated::new(self.lame).first_piola(f), f)
        } else {
            let beyond_rotation = scaled(&difference(f, &nearest_rotation(f)), mu + mu);
            let isotropic = multiple_of_identity(lambda * j * j.offset(-1.0));
            add_scaled(&isotropic, S::constant(1.0), &product_transpose(&beyond_rotation, f))
        };
        Stress { kirchhoff, stiffness: corotated_stiffness(lambda, mu, j, largest) }
    }

    fn domain(&self) -> Domain {
        Domain::EveryDeformation
    }
}
