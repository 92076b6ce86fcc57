use std::fmt;

/// What kind of cell an error speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellKind {
    /// A tetrahedron of a [`TetMesh`](super::TetMesh).
    Tetrahedron,
    /// A triangle.
    Triangle,
    /// A free edge of a [`TriMesh`](super::TriMesh).
    Edge,
    /// A free point of a [`TriMesh`](super::TriMesh).
    Point,
}

impl fmt::Display for CellKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Tetrahedron => "tetrahedron",
            Self::Triangle => "triangle",
            Self::Edge => "edge",
            Self::Point => "free point",
        })
    }
}

/// Why a mesh was refused, and which part of it is the culprit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// A cell names a point that does not exist.
    #[error("{kind} {cell} refers to point {index}, but there are only {points} points (numbered from 0)")]
    IndexOutOfRange {
        /// What kind of cell.
        kind: CellKind,
        /// Its position in the list of its kind.
        cell: usize,
        /// The offending index.
        index: u32,
        /// How many points there are.
        points: usize,
    },
    /// A cell names the same point twice.
    #[error("{kind} {cell} uses point {vertex} more than once")]
    RepeatedVertex {
        /// What kind of cell.
        kind: CellKind,
        /// Its position in the list of its kind.
        cell: usize,
        /// The point used twice.
        vertex: u32,
    },
    /// A position has a component that is NaN or infinite.
    #[error("point {point} is at ({}, {}, {}), which is not finite", .position[0], .position[1], .position[2])]
    NonFinitePosition {
        /// The point's index.
        point: usize,
        /// Its position.
        position: [f64; 3],
    },
    /// A tetrahedron has no positive, finite volume.
    #[error(
        "tetrahedron {tet} has the volume {volume:e}; it is inverted, flat, or its volume is not representable"
    )]
    NotPositive {
        /// The tetrahedron's index.
        tet: usize,
        /// Its signed volume \[m³\].
        volume: f64,
    },
    /// More than two tetrahedra share a face.
    #[error("tetrahedra {}, {} and {} share the face {face:?}; a face belongs to at most two", .tets[0], .tets[1], .tets[2])]
    OvercrowdedFace {
        /// The face's points in ascending order.
        face: [u32; 3],
        /// The first three tetrahedra that have it.
        tets: [u32; 3],
    },
    /// Two neighbouring tetrahedra have opposite orientations.
    #[error("tetrahedra {} and {} lie on the same side of their common face {face:?}: one of them is inverted", .tets[0], .tets[1])]
    OpposedTets {
        /// The face's points in ascending order.
        face: [u32; 3],
        /// The two tetrahedra.
        tets: [u32; 2],
    },
    /// An edge belongs to one triangle only: the surface has a hole or a rim.
    #[error("edge {edge:?} belongs to triangle {triangle} only: the surface is open there")]
    OpenEdge {
        /// The edge's points in ascending order.
        edge: [u32; 2],
        /// The triangle it belongs to.
        triangle: u32,
    },
    /// An edge belongs to more than two triangles.
    #[error("edge {edge:?} belongs to {count} triangles: the surface is not a manifold there")]
    NonManifoldEdge {
        /// The edge's points in ascending order.
        edge: [u32; 2],
        /// How many triangles have it.
        count: usize,
    },
    /// Two triangles run along their common edge in the same direction.
    #[error("triangles {} and {} run along edge {edge:?} in the same direction: their normals disagree", .triangles[0], .triangles[1])]
    OpposedTriangles {
        /// The edge's points in ascending order.
        edge: [u32; 2],
        /// The two triangles.
        triangles: [u32; 2],
    },
    /// The triangles around a vertex form more than one fan.
    #[error(
        "the triangles around point {vertex} form {fans} separate fans: the surface only touches itself there"
    )]
    NonManifoldVertex {
        /// The vertex.
        vertex: u32,
        /// How many fans meet in it.
        fans: usize,
    },
    /// A parameter of a generator or a transformation is outside its domain.
    #[error("{parameter} is {value}; expected {expected}")]
    BadParameter {
        /// The parameter's name.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// The mesh would have more points or cells than 32-bit indices can number.
    #[error("the mesh would have {count} points or cells; at most 4294967295 can be numbered")]
    TooLarge {
        /// How many.
        count: u64,
    },
}
