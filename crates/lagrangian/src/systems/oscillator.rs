//! One mass, one coordinate.

use super::parameter::{finite, not_negative, positive};
use crate::error::LagrangianError;
use crate::system::Lagrangian;
use mechanics_core::scalar::Scalar;

/// A mass on a spring: the harmonic oscillator.
///
/// ```text
///   |            ┌───┐
///   |─/\/\/\/\/\─┤ m │        q = (x), from where the spring is relaxed
///   |      k     └───┘
///   ───────────────┼──▶ x
///                  0
/// ```
///
/// T = ½ m ẋ², V = ½ k x². Every motion is x₀ cos ωt + (v₀/ω) sin ωt with ω = √(k/m). The stationary path between two points
/// is a minimum of the action only for times shorter than π/ω, half a period; later it is a saddle.
///
/// # Reference
/// Landau, Lifshitz, Mechanics, § 21; its action: Feynman, Hibbs 1965, problem 2-2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassOnSpring {
    /// m \[kg\].
    pub mass: f64,
    /// k \[N/m\].
    pub stiffness: f64,
}

impl MassOnSpring {
    /// From mass \[kg\] and stiffness \[N/m\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if one is not positive and finite.
    pub fn new(mass: f64, stiffness: f64) -> Result<Self, LagrangianError> {
        let name = "mass on a spring";
        Ok(Self { mass: positive(name, "mass", mass)?, stiffness: positive(name, "stiffness", stiffness)? })
    }

    /// ω = √(k/m) \[rad/s\].
    pub fn frequency(&self) -> f64 {
        (self.stiffness / self.mass).sqrt()
    }

    /// The exact position \[m\] and velocity \[m/s\] a time `t` \[s\] after x = `x`, ẋ = `v`.
    pub fn motion(&self, x: f64, v: f64, t: f64) -> [f64; 2] {
        let omega = self.frequency();
        let (sin, cos) = (omega * t).sin_cos();
        [x * cos + v / omega * sin, v * cos - omega * x * sin]
    }

    /// The action \[J s\] of the stationary path from x = `start` to x = `end` \[m\] in the time `duration` \[s\]:
    ///
    /// S = m ω/(2 sin ωτ) ((a² + b²) cos ωτ − 2 a b).
    ///
    /// Infinite at ωτ = π, 2π, …, where only end points with b = ±a are joined, by infinitely many paths.
    pub fn action_between(&self, start: f64, end: f64, duration: f64) -> f64 {
        let omega = self.frequency();
        let (sin, cos) = (omega * duration).sin_cos();
        self.mass * omega / (2.0 * sin) * ((start * start + end * end) * cos - 2.0 * start * end)
    }
}

impl Lagrangian<1> for MassOnSpring {
    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S; 1], v: &[S; 1], _: S) -> S {
        v[0].square().scale(0.5 * self.mass)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 1], _: S) -> S {
        q[0].square().scale(0.5 * self.stiffness)
    }
}

/// Duffing's oscillator: a mass of 1 kg on a spring that hardens (β > 0) or softens, damped and driven.
///
/// ```text
///   V, α < 0 < β
///    ╲             ╱
///     ╲    ╱‾╲    ╱           ẍ + δ ẋ + α x + β x³ = γ cos ωt
///      ╲__╱   ╲__╱
///      −x₀  0  x₀   ──▶ x     x₀ = √(−α/β)
/// ```
///
/// T = ½ ẋ², V = ½ α x² + ¼ β x⁴, R = ½ δ ẋ², Q = γ cos ωt. Without drive and damping h = T + V is kept; for α < 0 < β small
/// oscillations about ±x₀ have the frequency √(−2α). With drive and damping the motion may be chaotic.
///
/// # Reference
/// Guckenheimer, Holmes 1983, § 2.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Duffing {
    /// α \[N/m\], of either sign.
    pub linear: f64,
    /// β \[N/m³\], of either sign.
    pub cubic: f64,
    /// δ \[N s/m\].
    pub damping: f64,
    /// γ \[N\].
    pub amplitude: f64,
    /// ω \[rad/s\].
    pub frequency: f64,
}

impl Duffing {
    /// From α \[N/m\], β \[N/m³\], δ \[N s/m\], γ \[N\] and ω \[rad/s\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if one is not finite, or the damping is negative.
    pub fn new(
        linear: f64,
        cubic: f64,
        damping: f64,
        amplitude: f64,
        frequency: f64,
    ) -> Result<Self, LagrangianError> {
        let name = "Duffing's oscillator";
        Ok(Self {
            linear: finite(name, "linear", linear)?,
            cubic: finite(name, "cubic", cubic)?,
            damping: not_negative(name, "damping", damping)?,
            amplitude: finite(name, "amplitude", amplitude)?,
            frequency: finite(name, "frequency", frequency)?,
        })
    }
}

impl Lagrangian<1> for Duffing {
    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S; 1], v: &[S; 1], _: S) -> S {
        v[0].square().scale(0.5)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 1], _: S) -> S {
        let square = q[0].square();
        square.scale(0.5 * self.linear) + square.square().scale(0.25 * self.cubic)
    }

    #[inline]
    fn rayleigh<S: Scalar>(&self, _: &[S; 1], v: &[S; 1], _: S) -> S {
        v[0].square().scale(0.5 * self.damping)
    }

    #[inline]
    fn force<S: Scalar>(&self, _: &[S; 1], _: &[S; 1], t: S) -> [S; 1] {
        [t.scale(self.frequency).cos().scale(self.amplitude)]
    }
}
