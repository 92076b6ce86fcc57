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
    /// A segment is listed twice, or is the edge of a triangle.
    #[error("the segment of points {} and {} is listed twice, or is the edge of a triangle", .points[0], .points[1])]
    RepeatedSegment {
        /// Its points.
        points: [u32; 2],
    },
    /// A loose point is a corner of another feature.
    #[error("loose point {point} is already a corner of {feature}")]
    LoosePointInUse {
        /// The point.
        point: u32,
        /// The feature.
        feature: Feature,
    },
    /// A point belongs to two objects.
    #[error("point {point} belongs to objects {} and {}; a point belongs to one object only", .objects[0], .objects[1])]
    PointOfTwoObjects {
        /// The point.
        point: u32,
        /// The objects.
        objects: [u32; 2],
    },
    /// A filter names an object that does not exist.
    #[error("object {object} does not exist: there are {objects}, numbered from 0")]
    ObjectOutOfRange {
        /// The object it names.
        object: u32,
        /// How many there are.
        objects: usize,
    },
    /// A filter names a half-space that does not exist.
    #[error("half-space {half_space} does not exist: there are {half_spaces}, numbered from 0")]
    HalfSpaceOutOfRange {
        /// The half-space it names.
        half_space: u32,
        /// How many there are.
        half_spaces: usize,
    },
    /// A half-space has no normal of length one, or an offset that is not finite.
    #[error(
        "half-space {half_space} has the normal {normal:?} and the offset {offset}; the normal must have length 1"
    )]
    BadHalfSpace {
        /// The half-space.
        half_space: u32,
        /// Its normal.
        normal: [f64; 3],
        /// Its offset \[m\].
        offset: f64,
    },
    /// An object's thickness is not positive, or is missing although it has loose segments or loose points.
    #[error("object {object} has the thickness {thickness:?}; loose segments and points need a positive one")]
    BadThickness {
        /// The object.
        object: u32,
        /// Its thickness \[m\].
        thickness: Option<f64>,
    },
    /// An edge has no length at rest, or a triangle or point no area, or more than a number can hold.
    #[error("{feature} has the size {size:e} at rest; it must be positive and finite")]
    ZeroSize {
        /// The feature.
        feature: Feature,
        /// Its length \[m\] (edge) or area \[m²\].
        size: f64,
    },
    /// A position that is asked about is infinite or NaN.
    #[error("the position {position:?} is not finite")]
    NonFiniteQuery {
        /// The position \[m\].
        position: [f64; 3],
    },
    /// A surface that should be closed has a rim, or two triangles of contrary orientation.
    #[error(
        "the surface is not closed at the edge of points {} and {}: as many triangles must pass it one way as the other",
        .edge[0], .edge[1]
    )]
    OpenSurface {
        /// The edge.
        edge: [u32; 2],
    },
    /// A point whose side is asked about is on the surface.
    #[error("the position {position:?} is on triangle {triangle}, and so on no side of the surface")]
    OnSurface {
        /// The triangle.
        triangle: u32,
        /// The position \[m\].
        position: [f64; 3],
    },
    /// Two chains that should be apart share a point.
    #[error("segment {} of the first chain touches segment {} of the second", .segments[0], .segments[1])]
    ChainsTouch {
        /// The segments, each by the number of its first point.
        segments: [u32; 2],
    },
}
