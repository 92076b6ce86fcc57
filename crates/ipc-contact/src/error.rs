//! What can be wrong with contact input, by culprit.

use crate::collision_mesh::Feature;

/// Why contact cannot be set up or evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContactError {
    /// A triangle, segment or point names a point that does not exist.
    #[error("{feature} names point {point}, but there are {points}")]
    PointOutOfRange {
        /// The feature.
        feature: Feature,
        /// The point it names.
        point: u32,
        /// How many there are.
        points: usize,
    },
    /// A feature names a point twice.
    #[error("{feature} names point {point} twice")]
    RepeatedPoint {
        /// The feature.
        feature: Feature,
        /// The point.
        point: u32,
    },
    /// A feature is listed twice.
    #[error("{feature} is the same as {earlier}")]
    RepeatedFeature {
        /// The later one.
        feature: Feature,
        /// The earlier one.
        earlier: Feature,
    },
    /// A position is infinite or NaN.
    #[error("point {point} is at {position:?}, which is not finite")]
    NonFinite {
        /// The point.
        point: usize,
        /// Where it is \[m\].
        position: [f64; 3],
    },
    /// A stiffness κ is positive and finite.
    #[error("the barrier's stiffness must be positive and finite, not {value}")]
    Stiffness {
        /// The stiffness.
        value: f64,
    },
    /// The gap below which κ grows is a part of the activation distance.
    #[error("κ can grow below a part between 0 and 1 of the activation distance, not below {value} of it")]
    GrowthThreshold {
        /// The part.
        value: f64,
    },
    /// κ's growth has a finite limit.
    #[error("κ can grow to a finite multiple, 1 or more, of its start, not to {value} times it")]
    GrowthLimit {
        /// The multiple.
        value: f64,
    },
    /// The activation distance is positive and finite.
    #[error("the activation distance must be positive and finite, not {value} m")]
    ActivationDistance {
        /// The distance \[m\].
        value: f64,
    },
    /// The minimum separation is finite and not negative.
    #[error("the minimum separation must be finite and not negative, not {value} m")]
    MinimumSeparation {
        /// The separation \[m\].
        value: f64,
    },
    /// Features of one object that are no neighbours would be in contact at rest.
    #[error(
        "contact begins at the distance {reach} m (activation distance and minimum separation), but {edge} of an object that may \
         touch itself is {length} m long at rest: its neighbourhood would push itself apart. Take a smaller activation \
         distance, or exclude the object's contact with itself"
    )]
    ActivationBeyondEdge {
        /// Activation distance and minimum separation \[m\].
        reach: f64,
        /// The shortest edge.
        edge: Feature,
        /// Its length \[m\].
        length: f64,
    },
    /// The part of the way to contact that a step may go.
    #[error("a step may go a part between 0 and 1 of the way to contact, not {value}")]
    StepSafety {
        /// The part.
        value: f64,
    },
    /// There are not as many positions as the mesh has points.
    #[error("the collision mesh has {expected} points, but {found} positions were given")]
    PointCount {
        /// How many the mesh has.
        expected: usize,
        /// How many were given.
        found: usize,
    },
}
