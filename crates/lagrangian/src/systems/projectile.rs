//! A thrown stone.

use super::parameter::{finite, positive};
use crate::error::LagrangianError;
use crate::system::Lagrangian;
use mechanics_core::scalar::Scalar;

/// A projectile in a uniform field, without drag.
///
/// ```text
///   y ▲      . ─ ‾ ─ .
///     │   .             .          │ g
///     │ .                 .        ▼
///     └────────────────────.──▶ x
/// ```
///
/// T = ½ m (ẋ² + ẏ²), V = m g y. The path is a parabola; among all paths between the same two points in the same time it has the
/// least action, always. p_x = m ẋ and the energy are kept.
///
/// # Reference
/// Feynman Lectures II, chapter 19.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projectile {
    /// m \[kg\].
    pub mass: f64,
    /// g \[m/s²\], downwards.
    pub gravity: f64,
}

impl Projectile {
    /// From mass \[kg\] and gravity \[m/s²\].
    ///
    /// # Errors
    /// [`LagrangianError::Parameter`] if the mass is not positive, or one is not finite.
    pub fn new(mass: f64, gravity: f64) -> Result<Self, LagrangianError> {
        let name = "projectile";
        Ok(Self { mass: positive(name, "mass", mass)?, gravity: finite(name, "gravity", gravity)? })
    }

    /// The exact position \[m\] a time `t` \[s\] after q = `start`, q̇ = `v`.
    pub fn position(&self, start: [f64; 2], v: [f64; 2], t: f64) -> [f64; 2] {
        [start[0] + v[0] * t, start[1] + t * (v[1] - 0.5 * self.gravity * t)]
    }

    /// The action \[J s\] of the path from `start` to `end` \[m\] in the time τ = `duration` \[s\]:
    ///
    /// S = m |b − a|²/(2τ) − ½ m g τ (a_y + b_y) − m g² τ³/24.
    pub fn action_between(&self, start: [f64; 2], end: [f64; 2], duration: f64) -> f64 {
        let Self { mass, gravity } = *self;
        let distance_squared = (end[0] - start[0]).powi(2) + (end[1] - start[1]).powi(2);
        mass * (0.5 * distance_squared / duration
            - 0.5 * gravity * duration * (start[1] + end[1])
            - gravity * gravity * duration.powi(3) / 24.0)
    }
}

impl Lagrangian<2> for Projectile {
    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5 * self.mass)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[1].scale(self.mass * self.gravity)
    }
}
