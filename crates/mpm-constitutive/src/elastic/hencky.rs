//! The Hencky solid.

use crate::logarithmic::LogarithmicStrain;
use crate::{Curvature, PointLaw, Stress, TotalDeformation};
use mechanics_core::law::{self, Hyperelastic, Lame};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Mat3, Matrix3, product_transpose};

/// Hencky's solid: the quadratic energy of St. Venant and Kirchhoff in the logarithmic strain.
///
/// With F = U diag(σ) Vᵀ and lᵢ = ln σᵢ:
///
/// - ψ = μ Σlᵢ² + ½λ (Σlᵢ)²
/// - τ = U diag(2μlᵢ + λ Σlⱼ) Uᵀ, *without* a factor σᵢ: ∂ψ/∂lᵢ = σᵢ ∂ψ/∂σᵢ, and P = τ F⁻ᵀ
///
/// All plastic laws of [`crate::plastic`] but snow are elastic in this way, because in lᵢ their flow is additive.
///
/// Stiffness: λ̂ = λ, 2μ̂ = 2μ(1 + l₀ − l₂) + max|τᵢ|. In principal axes the second derivative of ψ((I + tG)F) is Σ(2μ − τᵢ)gᵢᵢ² + λ tr²G,
/// and for each pair i, j, with x = gᵢⱼ, y = gⱼᵢ and a = (τᵢ − τⱼ)/(σᵢ² − σⱼ²), aσⱼ²x² + aσᵢ²y² + 2(aσⱼ² − τⱼ)xy. With u = lᵢ − lⱼ ≥ 0,
/// aσᵢ² = 2μu/(1 − e⁻²ᵘ) ≤ μ(1 + 2u) and 0 < aσⱼ² ≤ μ, so that a pair adds at most (2μ(1 + u) + |τⱼ|)(x² + y²).
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

    fn energy_gradient(&self, f: &Mat3, _history: &()) -> Mat3 {
        law::Hencky::new(self.lame).first_piola(f)
    }

    fn energy_curvature(&self, f: &Mat3, _history: &(), projection: Projection) -> Curvature {
        Curvature::Deformation(law::Hencky::new(self.lame).stiffness(f, projection), 1.0)
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
