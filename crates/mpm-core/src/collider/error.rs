//! What can be wrong with the mesh of a collider.

use mechanics_core::mesh::MeshError;

/// Why a triangle mesh cannot be a collider.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ColliderError {
    /// A hole, an edge with three triangles, neighbours whose normals disagree: the error names the edge.
    #[error("the mesh is no collider: {0}")]
    Mesh(#[from] MeshError),
    /// There is nothing to collide with.
    #[error("a collider without triangles")]
    Empty,
    /// A triangle has no normal.
    #[error("triangle {triangle} has the area {area:e} m²: it has no normal")]
    Flat {
        /// Its number.
        triangle: usize,
        /// \[m²\].
        area: f64,
    },
    /// Two triangles pass through each other, or lie on each other.
    #[error("triangles {} and {} meet away from a common edge or corner: the surface intersects itself", .triangles[0], .triangles[1])]
    SelfIntersection {
        /// Their numbers.
        triangles: [usize; 2],
    },
    /// The outside of the surface is neither outside of everything else nor in a hole.
    #[error(
        "on the outer side of triangle {triangle} the winding number is {winding}: its part of the surface is inside out, or within \
         another part"
    )]
    InsideOut {
        /// The first triangle of the part.
        triangle: usize,
        /// Around how many parts the place lies.
        winding: f64,
    },
}
