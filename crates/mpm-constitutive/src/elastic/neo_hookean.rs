//! The neo-Hookean solid.

use crate::elementary;
use crate::{Curvature, PointLaw, StiffnessBound, Stress, TotalDeformation};
use mechanics_core::law::{self, Hyperelastic, Lame};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{
    Mat3, Matrix3, add_scaled, determinant, multiple_of_identity, norm_squared, product_transpose, trace,
};

/// The compressible neo-Hookean solid with a logarithm of the volume ratio; no decomposition of F.
///
/// With J = det F and B = F Fᵀ:
///
/// - ψ = ½μ(tr B − 3) − μ ln J + ½λ ln²J
/// - P = μF + (λ ln J − μ) F⁻ᵀ, hence τ = P Fᵀ = μ(B − I) + λ ln J I
///
/// Stiffness: along (I + tG)F, the second derivative of ½ tr B is ‖GF‖², that of ln J is −tr G². With |tr G²| ≤ ‖G‖² and
/// ‖GF‖² ≤ σ₀²‖G‖²
///
/// d²ψ = μ‖GF‖² + (μ − λ ln J) tr G² + λ tr²G  ≤  λ tr²G + (μσ₀² + |μ − λ ln J|) ‖G‖².
///
/// σ₀², the largest eigenvalue of B, is at most m + √(2/3)‖B − mI‖ with m = tr B/3 (equality where the two smaller ones agree).
///
/// Domain: det F > 0.
///
/// # Reference
/// Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis (2nd ed., 2008); for the eigenvalue Wolkowicz and
/// Styan, Bounds for eigenvalues using traces (1980).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean {
    lame: Lame,
}

impl NeoHookean {
    /// The solid with the given parameters.
    pub fn new(lame: Lame) -> Self {
        Self { lame }
    }
}

impl PointLaw for NeoHookean {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = ();
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::IsTheStrain;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> S {
        law::NeoHookean::new(self.lame).energy_density(f)
    }

    fn energy_gradient(&self, f: &Mat3, _history: &()) -> Mat3 {
        law::NeoHookean::new(self.lame).first_piola(f)
    }

    fn energy_curvature(&self, f: &Mat3, _history: &(), projection: Projection) -> Curvature {
        Curvature::Deformation(law::NeoHookean::new(self.lame).stiffness(f, projection), 1.0)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, f: &Matrix3<S>, _history: &()) -> Stress<S> {
        let (lambda, mu) = (self.lame.lambda(), self.lame.mu());
        let b = product_transpose(f, f);
        let volumetric = elementary::ln(determinant(f)).scale(lambda);
        let isotropic = multiple_of_identity(volumetric.offset(-mu));
        let shear = largest_eigenvalue_bound(&b).scale(mu) + (-volumetric).offset(mu).abs();
        Stress {
            kirchhoff: add_scaled(&isotropic, S::constant(mu), &b),
            stiffness: StiffnessBound { lambda: S::constant(lambda), mu: shear.scale(0.5) },
        }
    }
}

/// tr A/3 + √(2/3)‖A − (tr A/3) I‖, not less than the largest eigenvalue of the symmetric A.
#[inline(always)]
pub(super) fn largest_eigenvalue_bound<S: Scalar>(a: &Matrix3<S>) -> S {
    let mean = trace(a).scale(1.0 / 3.0);
    let deviator = add_scaled(a, S::constant(-1.0), &multiple_of_identity(mean));
    norm_squared(&deviator).scale(2.0 / 3.0).sqrt() + mean
}
