//! Snow.

use crate::elastic::{corotated_stiffness, select};
use crate::error::{Parameter, not_negative, require};
use crate::{Curvature, Numbers, PointLaw, PointLawError, Stress, TotalDeformation};
use mechanics_core::decomposition::svd;
use mechanics_core::law::{self, Hyperelastic, Lame};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{Mat3, Matrix3, determinant, product_diagonal_transpose};

/// Snow after Stomakhin: fixed corotated elasticity that yields at critical stretches and hardens when packed.
///
/// With Fᵉ = R S, Jᵉ = det Fᵉ and the plastic volume ratio Jᵖ:
///
/// - ψ = H [μ‖Fᵉ − R‖² + ½λ(Jᵉ − 1)²],  H = e^(ξ(1 − Jᵖ))
/// - τ = H [2μ(Fᵉ − R)Fᵉᵀ + λJᵉ(Jᵉ − 1) I]; in principal axes τᵢ = H [2μσᵢ(σᵢ − 1) + λJᵉ(Jᵉ − 1)]
/// - return map: σᵢ is clamped to [1 − θ_c, 1 + θ_s], in the axes of the trial; what the clamp takes out of Fᵉ goes into Fᵖ, so that
///   Jᵉ Jᵖ is kept: Jᵖ ← Jᵖ · (Jᵉ before)/(Jᵉ after)
///
/// The clamp is no projection in energy. It moves every σᵢ towards 1, which lowers the first term of ψ; but a stretch that is cut may have
/// balanced a compression, and then the second term grows, by up to ½Hλ(Jᵉ − 1)² of what is left. Packing raises H besides. Both are
/// properties of the published law.
///
/// Stiffness: that of [`FixedCorotated`](crate::elastic::FixedCorotated) times H, with σ₀² of Fᵉ.
///
/// Domain: det Fᵉ > 0 (a return map of an inverted Fᵉ would make Jᵖ negative).
///
/// # Reference
/// Stomakhin, Schroeder, Chai, Teran, Selle, A material point method for snow simulation (2013), section 5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snow {
    lame: Lame,
    smallest: f64,
    largest: f64,
    hardening: f64,
}

/// The plastic change of volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SnowHistory<S> {
    /// Jᵖ − 1: negative for packed snow.
    pub plastic_volume_change: S,
}

impl<S: Scalar> Numbers<S> for SnowHistory<S> {
    const COUNT: usize = 1;

    #[inline(always)]
    fn from_numbers(mut number: impl FnMut(usize) -> S) -> Self {
        Self { plastic_volume_change: number(0) }
    }

    #[inline(always)]
    fn number(&self, k: usize) -> S {
        [self.plastic_volume_change][k]
    }
}

impl Snow {
    /// From the elasticity at Jᵖ = 1, θ_c, θ_s and ξ.
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless 0 ≤ θ_c < 1, 0 ≤ θ_s and 0 ≤ ξ, all finite.
    pub fn new(
        lame: Lame,
        critical_compression: f64,
        critical_stretch: f64,
        hardening: f64,
    ) -> Result<Self, PointLawError> {
        require(
            Parameter::CriticalCompression,
            critical_compression,
            |value| (0.0..1.0).contains(&value),
            "at least 0 and less than 1",
        )?;
        not_negative(Parameter::CriticalStretch, critical_stretch)?;
        not_negative(Parameter::SnowHardening, hardening)?;
        Ok(Self { lame, smallest: 1.0 - critical_compression, largest: 1.0 + critical_stretch, hardening })
    }

    /// H = e^(ξ(1 − Jᵖ)).
    #[inline(always)]
    fn hardness<S: Scalar>(&self, history: &SnowHistory<S>) -> S {
        history.plastic_volume_change.scale(-self.hardening).exp()
    }

    /// The stress for signed singular values of Fᵉ and axes `u`.
    #[inline(always)]
    fn principal_stress<S: Scalar>(&self, u: &Matrix3<S>, sigma: &[S; 3], hardness: S) -> Stress<S> {
        let (lambda, mu) = (hardness.scale(self.lame.lambda()), hardness.scale(self.lame.mu()));
        let j = sigma[0] * sigma[1] * sigma[2];
        let pressure = lambda * j * j.offset(-1.0);
        let mut tau = *sigma;
        for s in &mut tau {
            *s = (mu + mu) * *s * s.offset(-1.0) + pressure;
        }
        Stress {
            kirchhoff: product_diagonal_transpose(u, &tau, u),
            stiffness: corotated_stiffness(lambda, mu, j, sigma[0].square()),
        }
    }
}

impl PointLaw for Snow {
    type Strain<S: Scalar> = Matrix3<S>;
    type History<S: Scalar> = SnowHistory<S>;
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::Separate;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>, history: &SnowHistory<S>) -> S {
        let energy = law::FixedCorotated::new(self.lame).energy_density(f) * self.hardness(history);
        let outside = determinant(f).less_equal(S::constant(0.0));
        S::select(outside, S::constant(f64::INFINITY), energy)
    }

    fn energy_gradient(&self, f: &Mat3, history: &SnowHistory<f64>) -> Mat3 {
        law::FixedCorotated::new(self.lame).first_piola(f) * self.hardness(history)
    }

    fn energy_curvature(&self, f: &Mat3, history: &SnowHistory<f64>, projection: Projection) -> Curvature {
        Curvature::Deformation(
            law::FixedCorotated::new(self.lame).stiffness(f, projection),
            self.hardness(history),
        )
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, f: &Matrix3<S>, history: &SnowHistory<S>) -> Stress<S> {
        let svd = svd(f);
        self.principal_stress(&svd.u, &admissible(svd.sigma), self.hardness(history))
    }

    #[inline(always)]
    fn return_map<S: Scalar>(
        &self,
        trial: &Matrix3<S>,
        history: &mut SnowHistory<S>,
        _step: f64,
    ) -> (Matrix3<S>, Stress<S>) {
        let svd = svd(trial);
        let sigma = admissible(svd.sigma);
        let (low, high) = (S::constant(self.smallest), S::constant(self.largest));
        let mut clamped = sigma;
        for s in &mut clamped {
            *s = S::select(s.less(low), low, S::select(high.less(*s), high, *s));
        }
        let inside = low.less_equal(sigma[2]).and(sigma[0].less_equal(high));
        let after = clamped[0] * clamped[1] * clamped[2];
        let gain = (sigma[0] * sigma[1] * sigma[2] - after) / after;
        let z = history.plastic_volume_change;
        history.plastic_volume_change = S::select(inside, z, z + z.mul_add(gain, gain));
        let stress = self.principal_stress(&svd.u, &clamped, self.hardness(history));
        let flowed = product_diagonal_transpose(&svd.u, &clamped, &svd.v);
        (select(inside, trial, &flowed), stress)
    }
}

/// σ, or NaN where det F ≤ 0.
#[inline(always)]
fn admissible<S: Scalar>(mut sigma: [S; 3]) -> [S; 3] {
    let inside = S::constant(0.0).less(sigma[2]);
    for s in &mut sigma {
        *s = S::select(inside, *s, S::constant(f64::NAN));
    }
    sigma
}
