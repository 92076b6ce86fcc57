//! What contact did, and who is meant.

use crate::collision_mesh::{CollisionMesh, Feature};
use crate::intersection::Place;
use std::fmt;

/// Two features that are close, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct CloseFeatures {
    /// The one.
    pub first: Place,
    /// The other.
    pub second: Place,
    /// Their distance \[m\]; negative for a point behind a half-space's plane.
    pub distance: f64,
}

impl CloseFeatures {
    pub(super) fn new(mesh: &CollisionMesh, [first, second]: [Feature; 2], distance: f64) -> Self {
        let place = |feature: Feature| match feature {
            Feature::Point(point) => Place::new(mesh, feature, &[point]),
            Feature::Edge(edge) => Place::new(mesh, feature, &mesh.edges()[edge as usize]),
            Feature::Triangle(triangle) => Place::new(mesh, feature, &mesh.triangles()[triangle as usize]),
            Feature::HalfSpace(_) => Place::new(mesh, feature, &[]),
        };
        Self { first: place(first), second: place(second), distance }
    }
}

impl fmt::Display for CloseFeatures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} and {} are {:e} m apart", self.first, self.second, self.distance)
    }
}

/// How many pairs are active, by their closest features.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ContactCounts {
    /// A point and a half-space.
    pub half_spaces: usize,
    /// Two points.
    pub point_points: usize,
    /// A point and an edge.
    pub point_edges: usize,
    /// A point and a triangle.
    pub point_triangles: usize,
    /// Two edges.
    pub edge_edges: usize,
}

impl ContactCounts {
    /// All of them.
    pub fn total(&self) -> usize {
        self.half_spaces + self.point_points + self.point_edges + self.point_triangles + self.edge_edges
    }
}

/// What contact did since the start of the step, and how it stands at the end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactReport {
    /// Active pairs at the positions last accepted.
    pub contacts: ContactCounts,
    /// Their smallest distance \[m\].
    pub smallest_distance: Option<f64>,
    /// κ now.
    pub stiffness: f64,
    /// Times it was doubled.
    pub doublings: u64,
    /// Candidates known now.
    pub candidates: usize,
    /// Times candidates were searched for.
    pub searches: u64,
    /// Pairs asked for their impact, half-spaces not among them.
    pub detection_queries: u64,
    /// Contact sets built.
    pub sets: u64,
    /// The pair that limited a step last.
    pub limiting_pair: Option<[Feature; 2]>,
}
