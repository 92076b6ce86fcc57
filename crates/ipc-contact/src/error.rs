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
    /// An activation distance d̂ is not positive, or is beyond what a barrier can be evaluated for.
    #[error("the activation distance is {distance} m, but must lie between 1e-60 m and 1e60 m")]
    ActivationDistance {
        /// As given \[m\].
        distance: f64,
    },
    /// A minimum separation is negative or not finite.
    #[error("the minimum separation is {distance} m, but must lie between 0 and 1e60 m")]
    MinimumSeparation {
        /// As given \[m\].
        distance: f64,
    },
}
