//! Rigid motions of colliders: where they are, and how fast.

use crate::MpmError;
use crate::boundary::finite;
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::Rotation3;

/// A steady rigid motion: a centre that moves straight, and a rotation about it.
///
/// A point that is at X when the motion begins is at c + v t + exp(t\[ω\])(X − c) after t, with the velocity v + ω × (x − c − v t).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    /// c, where the centre is when the motion begins \[m\].
    pub centre: [f64; 3],
    /// v \[m/s\].
    pub velocity: [f64; 3],
    /// ω, in space \[rad/s\].
    pub angular_velocity: [f64; 3],
}

impl RigidMotion {
    /// None.
    pub const REST: Self = Self { centre: [0.0; 3], velocity: [0.0; 3], angular_velocity: [0.0; 3] };

    /// Without rotation.
    pub fn translation(velocity: [f64; 3]) -> Self {
        Self { velocity, ..Self::REST }
    }

    /// About a centre that stands still.
    pub fn rotation(centre: [f64; 3], angular_velocity: [f64; 3]) -> Self {
        Self { centre, angular_velocity, ..Self::REST }
    }

    pub(super) fn check(&self) -> Result<(), MpmError> {
        finite("the centre of a collider's motion", &self.centre)?;
        finite("the velocity of a collider", &self.velocity)?;
        finite("the angular velocity of a collider", &self.angular_velocity)
    }

    /// Whether anything moves.
    pub(super) fn is_rest(&self) -> bool {
        self.velocity == [0.0; 3] && self.angular_velocity == [0.0; 3]
    }
}

/// Where a collider is: its point X is at R X + T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// R.
    pub rotation: Mat3,
    /// T \[m\].
    pub translation: Vec3,
}

impl Placement {
    /// Where the mesh was given.
    pub(super) fn identity() -> Self {
        Self { rotation: Mat3::identity(), translation: Vec3::zeros() }
    }

    /// Where a point of the collider is.
    pub fn place(&self, point: &Vec3) -> Vec3 {
        self.rotation * point + self.translation
    }

    /// Which point of the collider is at a place.
    pub fn point_at(&self, place: &Vec3) -> Vec3 {
        self.rotation.tr_mul(&(place - self.translation))
    }

    /// After `time` of a motion.
    pub(super) fn moved(&self, motion: &RigidMotion, time: f64) -> Self {
        if motion.is_rest() || time == 0.0 {
            return *self;
        }
        let centre = Vec3::from(motion.centre);
        let turn = Rotation3::from_scaled_axis(Vec3::from(motion.angular_velocity) * time);
        let translation = centre + Vec3::from(motion.velocity) * time + turn * (self.translation - centre);
        Self { rotation: turn.matrix() * self.rotation, translation }
    }
}

/// Where a collider is at one moment, and how it moves then.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    pub(super) placement: Placement,
    centre: Vec3,
    velocity: Vec3,
    angular_velocity: Vec3,
}

impl Moment {
    pub(super) fn new(placement: &Placement, motion: &RigidMotion, time: f64) -> Self {
        let velocity = Vec3::from(motion.velocity);
        Self {
            placement: placement.moved(motion, time),
            centre: Vec3::from(motion.centre) + velocity * time,
            velocity,
            angular_velocity: Vec3::from(motion.angular_velocity),
        }
    }

    /// The velocity of the collider at a place.
    pub(super) fn velocity_at(&self, place: &Vec3) -> Vec3 {
        self.velocity + self.angular_velocity.cross(&(place - self.centre))
    }
}
