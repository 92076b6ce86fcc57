//! One bob: on a rod in a plane, on a rod in space, on a spring.

use super::elliptic::arithmetic_geometric_mean;
use super::parameter::{finite, positive};
use crate::constraint::Holonomic;
use crate::error::LagrangianError;
use crate::system::Lagrangian;
use mechanics_core::scalar::Scalar;
use std::f64::consts::TAU;

/// The plane pendulum in its angle.
///
/// ```text
///   ────●────
///       │╲
///       │θ╲ l
///       │  ╲
///           ● m     │ g
///                   ▼
/// ```
///
/// q = (θ), from the downward vertical. T = ½ m l² θ̇², V = −m g l cos θ, so θ̈ = −(g/l) sin θ.
///
/// At rest below, θ = 0, stable with ω = √(g/l); above, θ = π, unstable with the rate √(g/l). A swing of amplitude
/// θ₀ takes 4 K(sin ½θ₀)/ω; the energy is kept.
///
/// # Reference
/// Landau, Lifshitz, Mechanics, § 11, problem 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pendulum {
    /// m \[kg\].
    pub mass: f64,
    /// l \[m\].
    pub length: f64,
    /// g \[m/s²\].
    pub gravity: f64,
}

impl Pendulum {
    /// From mass \[kg\], length \[m\] and gravity \[m/s²\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if mass or length is not positive, or one is not finite.
    pub fn new(mass: f64, length: f64, gravity: f64) -> Result<Self, LagrangianError> {
        let name = "pendulum";
        Ok(Self {
            mass: positive(name, "mass", mass)?,
            length: positive(name, "length", length)?,
            gravity: finite(name, "gravity", gravity)?,
        })
    }

    /// The frequency of small swings, √(g/l) \[rad/s\].
    pub fn frequency(&self) -> f64 {
        (self.gravity / self.length).sqrt()
    }

    /// The period of a swing to and fro of `amplitude` θ₀ \[rad\], 4 K(sin ½θ₀)/ω = 2π/(ω agm(1, cos ½θ₀)) \[s\].
    ///
    /// Infinite for θ₀ = ±π up to the rounding of π; only |θ₀| < π is a swing.
    pub fn swing_period(&self, amplitude: f64) -> f64 {
        TAU / (self.frequency() * arithmetic_geometric_mean(1.0, (0.5 * amplitude).cos().abs()))
    }

    /// The time of a full turn \[s\] if the pendulum passes the lowest point with θ̇ = `rate` \[rad/s\].
    ///
    /// Energy gives θ̇² = θ̇₀² − 4ω² sin² ½θ, hence the time ∫₀^{2π} dθ/θ̇ = (4/θ̇₀) K(2ω/θ̇₀) = 2π / agm(θ̇₀, √(θ̇₀² − 4ω²)). NaN if it
    /// does not go over the top, |θ̇₀| < 2ω.
    pub fn turn_period(&self, rate: f64) -> f64 {
        let (rate, critical) = (rate.abs(), 2.0 * self.frequency());
        TAU / arithmetic_geometric_mean(rate, ((rate - critical) * (rate + critical)).sqrt())
    }
}

impl Lagrangian<1> for Pendulum {
    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S; 1], v: &[S; 1], _: S) -> S {
        v[0].square().scale(0.5 * self.mass * self.length * self.length)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 1], _: S) -> S {
        q[0].cos().scale(-self.mass * self.gravity * self.length)
    }
}

/// The plane pendulum in Cartesian coordinates: a free mass, and a rod as a constraint.
///
/// ```text
///        y
///        ▲
///    ────●────▶ x       x =  l sin θ
///        │╲             y = −l cos θ
///        │θ╲ l
///            ● m
/// ```
///
/// T = ½ m (ẋ² + ẏ²), V = m g y, φ = ½ (x² + y² − l²) = 0. With m q̈ = −∇V + λ ∇φ the rod's tension is −λ l \[N\]: λ in N/m, positive
/// where the rod pushes.
///
/// The [`Lagrangian`] alone is that of a falling mass; the rod is the [`Holonomic`] half of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CartesianPendulum {
    /// m \[kg\].
    pub mass: f64,
    /// l \[m\].
    pub length: f64,
    /// g \[m/s²\].
    pub gravity: f64,
}

impl CartesianPendulum {
    /// From mass \[kg\], length \[m\] and gravity \[m/s²\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if mass or length is not positive, or one is not finite.
    pub fn new(mass: f64, length: f64, gravity: f64) -> Result<Self, LagrangianError> {
        let Pendulum { mass, length, gravity } = Pendulum::new(mass, length, gravity)?;
        Ok(Self { mass, length, gravity })
    }

    /// Cartesian coordinates and velocities of the angle θ and its rate.
    pub fn from_angle(&self, angle: f64, rate: f64) -> [[f64; 2]; 2] {
        let (sin, cos) = angle.sin_cos();
        let l = self.length;
        [[l * sin, -l * cos], [l * rate * cos, l * rate * sin]]
    }
}

impl Lagrangian<2> for CartesianPendulum {
    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5 * self.mass)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[1].scale(self.mass * self.gravity)
    }
}

impl Holonomic<2, 1> for CartesianPendulum {
    fn constraint<S: Scalar>(&self, [x, y]: &[S; 2], _: S) -> [S; 1] {
        [(x.square() + y.square()).offset(-self.length * self.length).scale(0.5)]
    }
}

/// The pendulum that may swing in any direction.
///
/// ```text
///        ●──────▶ x
///       ╱│╲
///      ╱ │θ╲ l          φ: angle about the vertical
///     y  │  ╲
///            ● m   ↺ φ
/// ```
///
/// q = (θ, φ), θ from the downward vertical. T = ½ m l² (θ̇² + φ̇² sin²θ), V = −m g l cos θ. φ is cyclic: p_φ = m l² sin²θ φ̇ is
/// kept, and the energy. At θ = 0 and π the coordinates are singular, M too: a bob that passes through the lowest point wants
/// other coordinates (the constraint |r| = l).
///
/// # Reference
/// Landau, Lifshitz, Mechanics, § 14, problem 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalPendulum {
    /// m \[kg\].
    pub mass: f64,
    /// l \[m\].
    pub length: f64,
    /// g \[m/s²\].
    pub gravity: f64,
}

impl SphericalPendulum {
    /// From mass \[kg\], length \[m\] and gravity \[m/s²\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if mass or length is not positive, or one is not finite.
    pub fn new(mass: f64, length: f64, gravity: f64) -> Result<Self, LagrangianError> {
        let name = "spherical pendulum";
        Ok(Self {
            mass: positive(name, "mass", mass)?,
            length: positive(name, "length", length)?,
            gravity: finite(name, "gravity", gravity)?,
        })
    }

    /// The rate φ̇ = √(g/(l cos θ)) \[rad/s\] at which the bob circles at the constant angle θ < π/2 \[rad\].
    pub fn conical_rate(&self, angle: f64) -> f64 {
        (self.gravity / (self.length * angle.cos())).sqrt()
    }
}

impl Lagrangian<2> for SphericalPendulum {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _: S) -> S {
        let around = v[1] * q[0].sin();
        (v[0].square() + around.square()).scale(0.5 * self.mass * self.length * self.length)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[0].cos().scale(-self.mass * self.gravity * self.length)
    }
}

/// The elastic pendulum: a bob on a spring that swings.
///
/// ```text
///   ────●────
///       │╲╱
///       │θ╱╲  r, relaxed l₀
///       │  ╲╱
///           ● m     │ g
///                   ▼
/// ```
///
/// q = (r, θ). T = ½ m (ṙ² + r² θ̇²), V = −m g r cos θ + ½ k (r − l₀)². It hangs at r = l₀ + mg/k, θ = 0, and oscillates there with
/// √(k/m) along the spring and √(g/r) across it. Where the first is twice the second, k = 3 m g/l₀, the energy wanders between the two.
///
/// # Reference
/// Breitenberger, Mueller 1981, J. Math. Phys. 22, 1196.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringPendulum {
    /// m \[kg\].
    pub mass: f64,
    /// k \[N/m\].
    pub stiffness: f64,
    /// l₀ \[m\].
    pub length: f64,
    /// g \[m/s²\].
    pub gravity: f64,
}

impl SpringPendulum {
    /// From mass \[kg\], stiffness \[N/m\], relaxed length \[m\] and gravity \[m/s²\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if mass, stiffness or length is not positive, or one is not finite.
    pub fn new(mass: f64, stiffness: f64, length: f64, gravity: f64) -> Result<Self, LagrangianError> {
        let name = "spring pendulum";
        Ok(Self {
            mass: positive(name, "mass", mass)?,
            stiffness: positive(name, "stiffness", stiffness)?,
            length: positive(name, "length", length)?,
            gravity: finite(name, "gravity", gravity)?,
        })
    }

    /// The length l₀ + mg/k \[m\] at which the bob hangs at rest.
    pub fn rest_length(&self) -> f64 {
        self.length + self.mass * self.gravity / self.stiffness
    }

    /// The frequencies of small oscillations \[rad/s\]: along the spring, across it.
    pub fn frequencies(&self) -> [f64; 2] {
        [(self.stiffness / self.mass).sqrt(), (self.gravity / self.rest_length()).sqrt()]
    }
}

impl Lagrangian<2> for SpringPendulum {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + (q[0] * v[1]).square()).scale(0.5 * self.mass)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        let stretch = q[0].offset(-self.length);
        stretch.square().scale(0.5 * self.stiffness) - (q[0] * q[1].cos()).scale(self.mass * self.gravity)
    }
}
