//! The linear solid.

use crate::{Curvature, PointLaw, StiffnessBound, Stress, TotalDeformation};
use mechanics_core::law::{self, Domain, Hyperelastic, Lame};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{
    Mat3, Matrix3, difference, multiple_of_identity, norm_squared, product_transpose,
};

/// Small-strain linear elasticity, **not objective**: for small rotations, and as the limit of the others.
///
/// With ε = ½(F + Fᵀ) − I:
///
/// - ψ = μ ε:ε + ½λ tr²ε
/// - P = 2με + λ tr(ε) I, τ = P Fᵀ, which is symmetric to first order only
///
/// Stiffness, with δ = ‖F − I‖: the second derivative is 2μ‖sym GF‖² + λ tr²(GF), ‖GF‖ ≤ (1 + δ)‖G‖ and
/// tr²(GF) ≤ (|tr G| + δ‖G‖)² ≤ (1 + δ) tr²G + δ(1 + δ)‖G‖². So, for λ ≥ 0, λ̂ = λ(1 + δ) and 2μ̂ = 2μ(1 + δ)² + λδ(1 + δ). For λ < 0 the
/// lower bound tr²(GF) ≥ (1 − δ) tr²G − δ(1 + δ)‖G‖² serves likewise (tr²G ≥ 0 where δ > 1).
///
/// Domain: every F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    lame: Lame,
}

impl Linear {
    /// The solid with the given parameters.
    pub fn new(lame: Lame) -> Self {
        Self { lame }
    }
}

impl PointLaw for Linear {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = ();
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::IsTheStrain;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> S {
        law::Linear::new(self.lame).energy_density(f)
    }

    fn energy_gradient(&self, f: &Mat3, _history: &()) -> Mat3 {
        law::Linear::new(self.lame).first_piola(f)
    }

    fn energy_curvature(&self, f: &Mat3, _history: &(), projection: Projection) -> Curvature {
        Curvature::Deformation(law::Linear::new(self.lame).stiffness(f, projection), 1.0)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> Stress<S> {
        let (lambda, mu) = (self.lame.lambda(), self.lame.mu());
        let away = norm_squared(&difference(f, &multiple_of_identity(S::constant(1.0)))).sqrt();
        let beyond = away.offset(1.0);
        let uniform = if lambda >= 0.0 { beyond } else { (-away).offset(1.0).max(S::constant(0.0)) };
        Stress {
            kirchhoff: product_transpose(&law::Linear::new(self.lame).first_piola(f), f),
            stiffness: StiffnessBound {
                lambda: uniform.scale(lambda),
                mu: beyond.square().scale(mu) + (away * beyond).scale(0.5 * lambda.abs()),
            },
        }
    }

    fn domain(&self) -> Domain {
        Domain::EveryDeformation
    }
}
