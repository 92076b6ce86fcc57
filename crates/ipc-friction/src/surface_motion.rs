//! Half-spaces whose material moves: belts, conveyors, turntables.
//!
//! A half-space stands where it is, but what it is made of may slide or turn within its plane, as the surface of a belt does. Friction
//! then acts on the velocity relative to that material: u = Tᵀ(v − vₛ(x)) with vₛ = V + ω × (x − c). vₛ is taken where the point is
//! when normal forces are, and held constant with them, so that it only moves the origin of the slip, r̂ by vₛ/a. In statics velocities are
//! displacements in a part of the load, and so is vₛ.

use mechanics_core::tensor::Vec3;

/// How the material of a half-space moves: v(x) = V + ω × (x − c). Only its part in the plane counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceMotion {
    /// V [m/s].
    pub velocity: Vec3,
    /// ω [1/s].
    pub angular_velocity: Vec3,
    /// c \[m\].
    pub centre: Vec3,
}

impl SurfaceMotion {
    /// A belt of this velocity [m/s].
    pub fn sliding(velocity: Vec3) -> Self {
        Self { velocity, ..Self::default() }
    }

    /// A turntable about `centre` \[m\] with this angular velocity [1/s].
    pub fn turning(angular_velocity: Vec3, centre: Vec3) -> Self {
        Self { velocity: Vec3::zeros(), angular_velocity, centre }
    }

    /// The velocity of the material at `x` [m/s].
    pub fn at(&self, x: &Vec3) -> Vec3 {
        self.velocity + self.angular_velocity.cross(&(x - self.centre))
    }

    /// Whether all its numbers are finite.
    pub fn is_finite(&self) -> bool {
        [self.velocity, self.angular_velocity, self.centre].iter().all(|v| v.iter().all(|c| c.is_finite()))
    }
}
