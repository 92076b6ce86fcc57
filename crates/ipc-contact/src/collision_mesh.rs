//! What may touch: triangles, segments and single points of one or more objects, and which of them may not.

use mechanics_core::tensor::Vec3;

/// A feature of a collision mesh, by its number in the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Feature {
    /// Point, by its number among all points.
    Point(u32),
    /// Edge.
    Edge(u32),
    /// Triangle.
    Triangle(u32),
    /// Analytic half-space.
    HalfSpace(u32),
}

impl std::fmt::Display for Feature {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Point(n) => write!(f, "point {n}"),
            Self::Edge(n) => write!(f, "edge {n}"),
            Self::Triangle(n) => write!(f, "triangle {n}"),
            Self::HalfSpace(n) => write!(f, "half-space {n}"),
        }
    }
}

/// The features of all objects that may touch, over the points of the incremental potential.
///
/// Numbers of points are those of the potential's `x`; the points of a mesh need not be all of them. Every feature
/// belongs to an object, in the order they were added.
#[derive(Clone, Debug)]
pub struct CollisionMesh {
    /// How many points the potential has.
    point_count: usize,
    /// Points that take part, ascending.
    vertices: Vec<u32>,
    /// Edges of triangles and segments, lower point first, ascending, each once.
    edges: Vec<[u32; 2]>,
    triangles: Vec<[u32; 3]>,
    /// Edge k joins corners k and k + 1 (mod 3).
    triangle_edges: Vec<[u32; 3]>,
    /// Per point: the object it belongs to.
    object_of_point: Vec<u32>,
    /// Per point (m²), per edge (m²): rest areas, see the area-weighted barrier.
    point_area: Vec<f64>,
    edge_area: Vec<f64>,
    /// Rest positions.
    rest: Vec<Vec3>,
}

impl CollisionMesh {
    /// How many points the potential has; feature numbers of points are below it.
    pub fn point_count(&self) -> usize {
        self.point_count
    }

    /// Points that take part, ascending.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Edges, lower point first, ascending.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// Triangles, as they were given.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The edges of each triangle: edge k joins its corners k and k + 1 (mod 3).
    pub fn triangle_edges(&self) -> &[[u32; 3]] {
        &self.triangle_edges
    }

    /// The object that a point belongs to.
    pub fn object_of(&self, point: u32) -> u32 {
        self.object_of_point[point as usize]
    }

    /// Rest area that a point stands for \[m²\].
    pub fn point_area(&self, point: u32) -> f64 {
        self.point_area[point as usize]
    }

    /// Rest area that an edge stands for \[m²\].
    pub fn edge_area(&self, edge: u32) -> f64 {
        self.edge_area[edge as usize]
    }

    /// Rest positions of all points \[m\].
    pub fn rest(&self) -> &[Vec3] {
        &self.rest
    }
}
