//! Weakly compressible fluids.

use crate::error::{Parameter, positive};
use crate::{PointLaw, PointLawError, StiffnessBound, Stress, TotalDeformation, VolumeChange};
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
/// Pressures are differences of numbers near one. With z = J − 1 (which is what is stored) and r = 1/J they are evaluated without
/// cancellation: for an integer γ, J⁻ᵞ − 1 = −z r (1 + r + … + rᵞ⁻¹); otherwise expm1(−γ ln1p z).
/// The energy is second order in z: for an integer γ ≥ 2, (J¹⁻ᵞ − 1)/(γ − 1) + z = z² r Σ_{k=1}^{γ−1} … is left as
/// −∫p by the factorised polynomial below.
///
/// Domain: J > 0.
///
/// # Reference
/// Murnaghan (1944), The compressibility of media under extreme pressures; Cole, Underwater Explosions (1948), for water γ = 7.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tait {
    bulk: f64,
    exponent: f64,
    tension: Tension,
}
