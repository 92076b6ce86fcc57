//! Weakly compressible fluids.

use crate::error::{Parameter, positive};
use crate::{Curvature, PointLaw, PointLawError, StiffnessBound, Stress, TotalDeformation, VolumeChange};
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::multiple_of_identity;

/// What a fluid does when it is pulled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tension {
    /// Negative pressure, as the equation of state has it.
    Carried,
    /// No pressure beyond the rest volume: a free surface breaks into drops.
    Vanishes,
}

/// The equation of state of Murnaghan, which for water goes by the names of Tait and Cole.
///
/// With the volume ratio J and K = dp/d ln ρ at rest:
///
/// - p = (K/γ) (J⁻ᵞ − 1)
/// - ψ = −∫ p dJ = (K/γ) [ (J¹⁻ᵞ − 1)/(γ − 1) + J − 1 ], for γ = 1: K (J − 1 − ln J)
/// - τ = −p J I
/// - K(J) = −J² dp/dJ = K J¹⁻ᵞ, per rest volume: with J ← (1 + tr G) J the energy's second derivative is K J¹⁻ᵞ tr²G
///   exactly, so λ̂ = K J¹⁻ᵞ and μ̂ = 0. The sound speed is c = √(K J¹⁻ᵞ/ρ₀).
///
/// The pressure is a difference of numbers near one. With z = J − 1 (which is what is stored) and r = 1/J it is evaluated without
/// cancellation: for an integer γ, J⁻ᵞ − 1 = −z r (1 + r + … + rᵞ⁻¹), which is also fast; otherwise as expm1(−γ ln1p z). The energy
/// keeps an absolute error of ε K |z|.
///
/// Domain: J > 0.
///
/// # Reference
/// Murnaghan (1944), The compressibility of media under extreme pressures; Cole, Underwater Explosions (1948), with γ = 7 for
/// water; Monaghan, Simulating free surface flows with SPH (1994), for its use with a reduced K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tait {
    bulk: f64,
    exponent: f64,
    tension: Tension,
}

/// Integer exponents up to here take the factorised polynomial.
const LARGEST_INTEGER_EXPONENT: f64 = 16.0;

impl Tait {
    /// From the bulk modulus K \[Pa\] and the exponent γ (7 for water).
    ///
    /// K = ρ₀c² for a speed of sound c. In a flow with speeds up to v, c = 10 v keeps changes of density near 1 %.
    ///
    /// # Errors
    /// [`PointLawError::OutOfRange`] unless both are positive and finite.
    pub fn new(bulk_modulus: f64, exponent: f64, tension: Tension) -> Result<Self, PointLawError> {
        positive(Parameter::BulkModulus, bulk_modulus)?;
        positive(Parameter::StiffeningExponent, exponent)?;
        Ok(Self { bulk: bulk_modulus, exponent, tension })
    }

    /// The exponent, if it is a small integer.
    #[inline(always)]
    fn integer_exponent(&self) -> Option<i32> {
        let small = self.exponent <= LARGEST_INTEGER_EXPONENT && self.exponent.fract() == 0.0;
        small.then_some(self.exponent as i32)
    }

    /// p \[Pa\] and K J¹⁻ᵞ \[Pa\] for z = J − 1 > −1.
    #[inline(always)]
    fn pressure_and_stiffness<S: Scalar>(&self, z: S) -> (S, S) {
        let factor = self.bulk / self.exponent;
        if let Some(exponent) = self.integer_exponent() {
            let r = z.offset(1.0).recip();
            let (mut sum, mut power) = (S::constant(1.0), S::constant(1.0));
            for _ in 1..exponent {
                sum = sum.mul_add(r, S::constant(1.0));
                power *= r;
            }
            return ((z * r * sum).scale(-factor), power.scale(self.bulk));
        }
        let log = z.ln_1p();
        let pressure = log.scale(-self.exponent).exp_m1().scale(factor);
        (pressure, log.scale(1.0 - self.exponent).exp().scale(self.bulk))
    }

    /// ∫₀ᶻ ((1 + s)⁻ᵞ − 1)/γ ds, negated.
    #[inline(always)]
    fn energy_per_bulk<S: Scalar>(&self, z: S) -> S {
        let log = z.ln_1p();
        if self.exponent == 1.0 {
            return z - log;
        }
        let lower = 1.0 - self.exponent;
        (log.scale(lower).exp_m1().scale(-1.0 / lower) + z).scale(1.0 / self.exponent)
    }
}

impl PointLaw for Tait {
    type Strain<S: Scalar> = VolumeChange<S>;
    type History<S: Scalar> = ();
    const TOTAL_DEFORMATION: TotalDeformation = TotalDeformation::Meaningless;

    #[inline(always)]
    fn energy_density<S: Scalar>(&self, strain: &VolumeChange<S>, _history: &()) -> S {
        let (z, zero) = (strain.0, S::constant(0.0));
        let energy = self.energy_per_bulk(z).scale(self.bulk);
        let loose = match self.tension {
            Tension::Carried => energy,
            Tension::Vanishes => S::select(zero.less(z), zero, energy),
        };
        S::select(z.less_equal(S::constant(-1.0)), S::constant(f64::INFINITY), loose)
    }

    fn energy_gradient(&self, strain: &VolumeChange<f64>, _history: &()) -> VolumeChange<f64> {
        let z = strain.0;
        let loose = self.tension == Tension::Vanishes && z > 0.0;
        VolumeChange(if loose { 0.0 } else { -self.pressure_and_stiffness(z).0 })
    }

    /// −dp/dJ = K J⁻ᵞ⁻¹, never negative: nothing to project.
    fn energy_curvature(&self, strain: &VolumeChange<f64>, _history: &(), _: Projection) -> Curvature {
        let z = strain.0;
        let loose = self.tension == Tension::Vanishes && z > 0.0;
        Curvature::Volume(if loose { 0.0 } else { self.pressure_and_stiffness(z).1 / z.offset(1.0).square() })
    }

    /// γ − 1, as K(J) = K J¹⁻ᵞ.
    fn stiffening(&self) -> f64 {
        (self.exponent - 1.0).max(0.0)
    }

    #[inline(always)]
    fn stress<S: Scalar>(&self, strain: &VolumeChange<S>, _history: &()) -> Stress<S> {
        let z = S::select(S::constant(-1.0).less(strain.0), strain.0, S::constant(f64::NAN));
        let (pressure, stiffness) = self.pressure_and_stiffness(z);
        let pressure = match self.tension {
            Tension::Carried => pressure,
            Tension::Vanishes => S::select(S::constant(0.0).less(z), S::constant(0.0), pressure),
        };
        Stress {
            kirchhoff: multiple_of_identity(-(pressure * z.offset(1.0))),
            stiffness: StiffnessBound { lambda: stiffness, mu: S::constant(0.0) },
        }
    }
}
