//! Beads that slide without friction on a given curve.

use super::parameter::{finite, positive};
use crate::constraint::Holonomic;
use crate::error::LagrangianError;
use crate::system::Lagrangian;
use mechanics_core::jet::Jet1;
use mechanics_core::scalar::Scalar;

/// A bead on a hoop that is turned about its vertical diameter.
///
/// ```text
///        │ Ω ↻
///      .─┼─.
///    ╱   │   ╲
///   │    ┼ R  │      │ g
///    ╲   │θ ╲●       ▼
///      ‾─┼─‾  m
/// ```
///
/// q = (θ), from the bottom. T = ½ m R² (θ̇² + Ω² sin²θ), V = −m g R cos θ. The motor that keeps Ω constant does work: T + V is not kept, but
/// the energy function h = ½ m R² (θ̇² − Ω² sin²θ) − m g R cos θ is.
///
/// Below the critical rate √(g/R) the bead rests at the bottom, stable; above it the bottom is unstable and the bead rests at
/// ±arccos(g/(RΩ²)).
///
/// # Reference
/// Goldstein, Classical Mechanics, chapter 2; Strogatz 1994, § 3.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeadOnHoop {
    /// m \[kg\].
    pub mass: f64,
    /// R \[m\].
    pub radius: f64,
    /// g \[m/s²\].
    pub gravity: f64,
    /// Ω \[rad/s\].
    pub rate: f64,
}

impl BeadOnHoop {
    /// From mass \[kg\], radius \[m\], gravity \[m/s²\] and rate of turning \[rad/s\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if mass or radius is not positive, or one is not finite.
    pub fn new(mass: f64, radius: f64, gravity: f64, rate: f64) -> Result<Self, LagrangianError> {
        let name = "bead on a hoop";
        Ok(Self {
            mass: positive(name, "mass", mass)?,
            radius: positive(name, "radius", radius)?,
            gravity: finite(name, "gravity", gravity)?,
            rate: finite(name, "rate", rate)?,
        })
    }

    /// The rate √(g/R) \[rad/s\] above which the bottom is unstable.
    pub fn critical_rate(&self) -> f64 {
        (self.gravity / self.radius).sqrt()
    }

    /// The stable resting angle in [0, π/2] \[rad\]. NaN for g < 0, where the bottom is the top.
    pub fn equilibrium(&self) -> f64 {
        let (critical, rate) = (self.critical_rate(), self.rate.abs());
        // Not `min`, which would lose a NaN.
        if rate <= critical { 0.0 } else { (critical / rate).powi(2).acos() }
    }

    /// The frequency \[rad/s\] of small oscillations about it: √(g/R − Ω²) below the critical rate, Ω sin θ₀ above.
    pub fn frequency(&self) -> f64 {
        let (critical, rate) = (self.critical_rate(), self.rate.abs());
        if rate <= critical {
            return ((critical - rate) * (critical + rate)).sqrt();
        }
        let cos = (critical / rate).powi(2);
        rate * ((1.0 - cos) * (1.0 + cos)).sqrt()
    }

    /// The rate √(Ω² − g/R) \[1/s\] at which the bead leaves the bottom; zero where that is stable.
    pub fn growth_rate_at_bottom(&self) -> f64 {
        let (critical, rate) = (self.critical_rate(), self.rate.abs());
        ((rate - critical) * (rate + critical)).max(0.0).sqrt()
    }
}

impl Lagrangian<1> for BeadOnHoop {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 1], v: &[S; 1], _: S) -> S {
        let around = q[0].sin().scale(self.rate);
        (v[0].square() + around.square()).scale(0.5 * self.mass * self.radius * self.radius)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 1], _: S) -> S {
        q[0].cos().scale(-self.mass * self.gravity * self.radius)
    }
}

/// The shape of a wire.
pub trait Curve: Send + Sync {
    /// y = f(x) \[m\].
    fn height<S: Scalar>(&self, x: S) -> S;
}

/// y = ½ c x².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parabola {
    /// c \[1/m\], the curvature at the bottom.
    pub curvature: f64,
}

impl Curve for Parabola {
    fn height<S: Scalar>(&self, x: S) -> S {
        x.square().scale(0.5 * self.curvature)
    }
}

/// A bead on a wire y = f(x) in a vertical plane.
///
/// ```text
///   y ▲ ╲               ╱
///     │  ● m           ╱        │ g
///     │   ╲           ╱         ▼
///     │     `-.___.-´  y = f(x)
///     └──────────────────▶ x
/// ```
///
/// q = (x). T = ½ m (ẋ² + ẏ²), V = m g f(x). Nobody need write f′: ẏ is the derivative of f along the motion, and the crate takes it by
/// running f on a [`Jet1`] over whatever number T is evaluated on. The energy is kept; small oscillations about a minimum of f have the
/// frequency √(g f″).
///
/// # Reference
/// Goldstein, Classical Mechanics, § 1.3 (constraints).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeadOnWire<C> {
    /// m \[kg\].
    pub mass: f64,
    /// g \[m/s²\].
    pub gravity: f64,
    /// y = f(x).
    pub curve: C,
}

impl<C: Curve> BeadOnWire<C> {
    /// From mass \[kg\], gravity \[m/s²\] and the wire.
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if the mass is not positive, or one is not finite.
    pub fn new(mass: f64, gravity: f64, curve: C) -> Result<Self, LagrangianError> {
        let name = "bead on a wire";
        Ok(Self { mass: positive(name, "mass", mass)?, gravity: finite(name, "gravity", gravity)?, curve })
    }
}

impl<C: Curve> Lagrangian<1> for BeadOnWire<C> {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 1], v: &[S; 1], _: S) -> S {
        let [rise] = self.curve.height(Jet1 { value: q[0], gradient: [v[0]] }).gradient;
        (v[0].square() + rise.square()).scale(0.5 * self.mass)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 1], _: S) -> S {
        self.curve.height(q[0]).scale(self.mass * self.gravity)
    }
}

/// The bead on a wire in Cartesian coordinates: a free mass, and the wire as a constraint.
///
/// q = (x, y). T = ½ m (ẋ² + ẏ²), V = m g y, φ = y − f(x) = 0. With m q̈ = −∇V + λ ∇φ, ∇φ = (−f′, 1), the wire pushes with λ √(1 + f′²) \[N\];
/// λ is its vertical part, positive upwards. This also describes what [`BeadOnWire`] cannot: the force on the wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CartesianBead<C> {
    /// m \[kg\].
    pub mass: f64,
    /// g \[m/s²\].
    pub gravity: f64,
    /// y = f(x).
    pub curve: C,
}

impl<C: Curve> CartesianBead<C> {
    /// From mass \[kg\], gravity \[m/s²\] and the wire.
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if the mass is not positive, or one is not finite.
    pub fn new(mass: f64, gravity: f64, curve: C) -> Result<Self, LagrangianError> {
        let BeadOnWire { mass, gravity, curve } = BeadOnWire::new(mass, gravity, curve)?;
        Ok(Self { mass, gravity, curve })
    }
}

impl<C: Curve> Lagrangian<2> for CartesianBead<C> {
    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5 * self.mass)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[1].scale(self.mass * self.gravity)
    }
}

impl<C: Curve> Holonomic<2, 1> for CartesianBead<C> {
    fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 1] {
        [q[1] - self.curve.height(q[0])]
    }
}
