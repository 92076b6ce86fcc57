//! The Hencky solid.

use crate::logarithmic::LogarithmicStrain;
use crate::{PointLaw, Stress, TotalDeformation};
use mechanics_core::law::{self, Hyperelastic, Lame};
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Matrix3, product_transpose};

/// Hencky's solid: the quadratic energy of St. Venant and Kirchhoff in the logarithmic strain.
///
/// With F = U diag(σ) Vᵀ and lᵢ = ln σᵢ:
///
/// - ψ = μ Σlᵢ² + ½λ (Σlᵢ)²
/// - τ = U diag(2μlᵢ + λ Σlⱼ) Uᵀ, *without* a factor σᵢ: ∂ψ/∂lᵢ = σᵢ ∂ψ/∂σᵢ, and P = τ F⁻ᵀ
///
/// All plastic laws of [`crate::plastic`] but snow are elastic in this way, because in lᵢ their flow is additive. For stiffness and
/// domain see [`LogarithmicStrain::stiffness`](crate::plastic).
///
/// Domain: det F > 0.
///
/// # Reference
/// Hencky (1928), Über die Form des Elastizitätsgesetzes bei ideal elastischen Stoffen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hencky {
    lame: Lame,
}

impl Hencky {
    /// The solid with the given parameters.
    pub fn new(lame: Lame) -> Self {
        Self { lame }
    }
}

impl PointLaw for Hencky {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = ();
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::IsTheStrain;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> S {
        law::Hencky::new(self.lame).energy_density(f)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> Stress<S> {
        let mut stress = LogarithmicStrain::of(f).stress(self.lame);
        if S::DIFFERENTIATES {
            stress.kirchhoff = product_transpose(&law::Hencky::new(self.lame).first_piola(f), f);
        }
        stress
    }
}
