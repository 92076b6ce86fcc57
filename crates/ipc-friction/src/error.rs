//! What can be wrong with friction, by culprit.

use crate::surface_motion::SurfaceMotion;

/// Why friction cannot be set up or evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FrictionError {
    /// A coefficient is negative or not finite.
    #[error("a coefficient of friction must be finite and not negative, not {value}")]
    Coefficient {
        /// As given.
        value: f64,
    },
    /// Sliding would take more force than starting to slide.
    #[error("the kinetic coefficient {sliding} is above the static one, {at_rest}")]
    KineticAboveStatic {
        /// μ_s.
        at_rest: f64,
        /// μ_k.
        sliding: f64,
    },
    /// εᵥ is not positive and finite.
    #[error("the velocity below which friction is smoothed must be positive and finite, not {value} m/s")]
    StickVelocity {
        /// As given [m/s].
        value: f64,
    },
    /// δ is not positive and finite.
    #[error(
        "the width of velocities over which friction falls from its static to its kinetic value must be positive and \
         finite, not {value} m/s"
    )]
    TransitionVelocity {
        /// As given [m/s].
        value: f64,
    },
    /// The tolerance of lagging is negative or NaN.
    #[error(
        "the tolerance of lagged friction is a part of the largest friction force, 0 or more, not {value}"
    )]
    LagTolerance {
        /// As given.
        value: f64,
    },
    /// A coefficient is given for an object that does not exist.
    #[error("a coefficient of friction names object {object}, but there are {objects}, numbered from 0")]
    ObjectOutOfRange {
        /// The object it names.
        object: u32,
        /// How many there are.
        objects: usize,
    },
    /// A coefficient is given for a half-space that does not exist.
    #[error(
        "a coefficient of friction names half-space {half_space}, but there are {half_spaces}, numbered from 0"
    )]
    HalfSpaceOutOfRange {
        /// The half-space it names.
        half_space: u32,
        /// How many there are.
        half_spaces: usize,
    },
    /// A motion is given for a half-space that does not exist.
    #[error(
        "the motion of a surface names half-space {half_space}, but there are {half_spaces}, numbered from 0"
    )]
    MotionOutOfRange {
        /// The half-space it names.
        half_space: u32,
        /// How many there are.
        half_spaces: usize,
    },
    /// A half-space's material moves with a velocity that is not finite.
    #[error("the motion of the surface of half-space {half_space} is not finite: {motion:?}")]
    Motion {
        /// The half-space.
        half_space: u32,
        /// As given.
        motion: SurfaceMotion,
    },
    /// A normal force has no size or no direction.
    #[error("the normal force on the points {points:?} has the size {magnitude} N and the normal {normal:?}")]
    NormalForce {
        /// The points of the pair.
        points: Vec<u32>,
        /// λ \[N\].
        magnitude: f64,
        /// Its direction.
        normal: [f64; 3],
    },
    /// A pair names a point twice.
    #[error("the normal force on the points {points:?} names point {point} twice")]
    RepeatedPoint {
        /// The points of the pair.
        points: Vec<u32>,
        /// The point.
        point: u32,
    },
}
