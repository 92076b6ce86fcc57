//! What can be wrong with contact input, by culprit.

use crate::collision_mesh::Feature;
use crate::contact::CloseFeatures;
use crate::intersection::Intersection;
use std::fmt::Display;

/// Pairs that a message lists; there may be thousands.
const LISTED: usize = 8;

fn counted(pairs: usize) -> String {
    format!("{pairs} pair{} of features", if pairs == 1 { "" } else { "s" })
}

fn listed(pairs: &[impl Display]) -> String {
    let shown: Vec<String> = pairs.iter().take(LISTED).map(ToString::to_string).collect();
    let more = if pairs.len() > LISTED { "; and more" } else { "" };
    shown.join("; ") + more
}

/// Why contact cannot be set up or evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContactError {
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
    /// Positions at which features intersect or touch already.
    #[error("{} intersect or touch at the start: {}", counted(.pairs.len()), listed(.pairs))]
    Intersecting {
        /// All of them, ascending.
        pairs: Vec<Intersection>,
    },
    /// Positions at which features do not touch, but are too close for a barrier.
    #[error(
        "{} are within the minimum separation of {minimum_separation} m, or touch up to rounding, at the start: {}",
        counted(.pairs.len()), listed(.pairs)
    )]
    TooClose {
        /// All of them.
        pairs: Vec<CloseFeatures>,
        /// The minimum separation \[m\].
        minimum_separation: f64,
    },
    /// Pairs keep their distance, but κ times their barrier is more than a number can hold.
    #[error(
        "with κ = {stiffness:e} the energy of {} is more than a number can hold; take a smaller κ: {}",
        counted(.pairs.len()), listed(.pairs)
    )]
    EnergyOverflow {
        /// Those without which the sum would be finite, or all that are infinite themselves.
        pairs: Vec<CloseFeatures>,
        /// κ.
        stiffness: f64,
    },
    /// A step leaves a part of the gap.
    #[error("the part of its gap that a step leaves every pair must lie between 0 and 1, not at {value}")]
    KeptGap {
        /// The part.
        value: f64,
    },
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
    /// A point is so far out that distances of the size of the activation distance are rounding there.
    #[error(
        "point {point} is at {position:?}: farther than {farthest:e} m from the origin the rounding of positions is no longer small \
         beside the activation distance. Move everything towards the origin, or take a larger activation distance"
    )]
    TooFar {
        /// The point.
        point: usize,
        /// Where it is \[m\].
        position: [f64; 3],
        /// How far from the origin points may be \[m\].
        farthest: f64,
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
    /// Boxes cannot be inflated by this.
    #[error("boxes cannot be inflated by {inflation} m; it must be finite and not negative")]
    BadInflation {
        /// The inflation \[m\].
        inflation: f64,
    },
    /// Nearly everything is near everything: a search is given up before it takes all memory.
    #[error(
        "more than {limit} pairs of features, of {features}, may be near each other: the positions have collapsed or exploded, or          the distance of contact is as large as the scene"
    )]
    TooManyCandidates {
        /// The number of pairs at which the search was given up.
        limit: usize,
        /// Points, edges and triangles of the mesh.
        features: usize,
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
