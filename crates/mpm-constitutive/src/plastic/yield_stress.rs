//! The yield stress as a function of plastic strain.

use crate::PointLawError;
use crate::error::{Parameter, not_negative, positive};
use mechanics_core::scalar::Scalar;

/// The uniaxial yield stress σ_y(α) = σ₀ + Hα + (σ∞ − σ₀)(1 − e^(−δα)) \[Pa\] of the equivalent plastic strain α.
///
/// H ≥ 0 is linear hardening; the last term approaches a saturation σ∞ at the rate δ: hardening after Voce if σ∞ > σ₀, softening
/// to a residual strength if σ∞ < σ₀. σ_y stays positive.
///
/// # Reference
/// Voce (1948), The relationship between stress and strain for homogeneous deformation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YieldStress {
    initial: f64,
    modulus: f64,
    /// σ∞ − σ₀.
    change: f64,
    rate: f64,
}

impl YieldStress {
    /// σ_y = σ₀ \[Pa\]: perfect plasticity.
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless 0 < σ₀ < ∞.
    pub fn perfect(initial: f64) -> Result<Self, PointLawError> {
        positive(Parameter::YieldStress, initial)?;
        Ok(Self { initial, modulus: 0.0, change: 0.0, rate: 0.0 })
    }

    /// σ_y = σ₀ + Hα \[Pa\].
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless 0 < σ₀ < ∞, 0 ≤ H < ∞.
    pub fn linear(initial: f64, hardening_modulus: f64) -> Result<Self, PointLawError> {
        not_negative(Parameter::HardeningModulus, hardening_modulus)?;
        Ok(Self { modulus: hardening_modulus, ..Self::perfect(initial)? })
    }

    /// This law with an approach to the saturation stress σ∞ \[Pa\] at the rate δ added. σ∞ < σ₀ softens.
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless σ∞ and δ are positive and finite.
    pub fn saturating(self, saturation: f64, rate: f64) -> Result<Self, PointLawError> {
        positive(Parameter::SaturationStress, saturation)?;
        positive(Parameter::SaturationRate, rate)?;
        Ok(Self { change: saturation - self.initial, rate, ..self })
    }

    /// σ_y(α) \[Pa\].
    #[inline(always)]
    pub fn at<S: Scalar>(&self, plastic_strain: S) -> S {
        let linear = plastic_strain.mul_add(S::constant(self.modulus), S::constant(self.initial));
        if self.is_linear() {
            return linear;
        }
        linear - plastic_strain.scale(-self.rate).exp_m1().scale(self.change)
    }

    /// −dσ_y/dα where it is largest, at α = 0 \[Pa\]; negative for hardening.
    pub(super) fn steepest_fall(&self) -> f64 {
        -self.modulus - self.rate * self.change
    }

    #[inline(always)]
    pub(super) fn is_linear(&self) -> bool {
        self.change == 0.0
    }

    #[inline(always)]
    pub(super) fn modulus(&self) -> f64 {
        self.modulus
    }
}
