//! What makes no thin body, and where.

use mechanics_core::law::LawError;
use mechanics_core::mesh::MeshError;
use mechanics_core::stencil::StencilError;

/// Why a sheet or a rod was refused; the message names the element and the value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ThinError {
    /// Young's modulus or Poisson's ratio is out of range.
    #[error(transparent)]
    Law(#[from] LawError),
    /// The mesh is not one that bends: an edge of three triangles, neighbours with opposite normals.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// An element names a point twice.
    #[error(transparent)]
    Stencil(#[from] StencilError),
    /// A thickness, radius, stiffness or limit is out of range.
    #[error("{parameter} is {value}; it must be {expected}")]
    Parameter {
        /// What it is.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// A rest triangle has no area, compared with its longest edge squared.
    #[error("triangle {triangle} (points {points:?}) has the rest area {area:e} m²: it is a line or a point")]
    RestArea {
        /// The triangle.
        triangle: usize,
        /// Its points.
        points: [u32; 3],
        /// Its area \[m²\].
        area: f64,
    },
    /// An edge has no length at rest, or none that is finite.
    #[error(
        "edge {edge} (points {points:?}) has the rest length {length:e} m; it must be positive and finite"
    )]
    RestLength {
        /// The edge's number.
        edge: usize,
        /// Its points.
        points: [u32; 2],
        /// Its length \[m\].
        length: f64,
    },
    /// The fibre direction is perpendicular to a triangle, so it has none within it.
    #[error("the fibre direction {direction:?} has no part in the plane of triangle {triangle}")]
    FibreDirection {
        /// The triangle.
        triangle: usize,
        /// The direction given.
        direction: [f64; 3],
    },
    /// Two triangles lie on each other at rest, so a small turn to either side looks like one by 2π.
    #[error(
        "triangles {triangles:?} are folded onto each other at rest (their angle is {angle} rad); open the fold or let \
         the sheet be flat at rest"
    )]
    RestFold {
        /// The triangles.
        triangles: [u32; 2],
        /// Their dihedral angle \[rad\].
        angle: f64,
    },
    /// The edges of a joint have turned by more than their frames can be carried along with.
    #[error(
        "the edges of the rod's joint {points:?} have turned too far since the last step for their frames to be carried \
         along; take shorter steps, or restore the twist where points were moved by hand"
    )]
    Transport {
        /// The joint and the far ends of its edges.
        points: [u32; 3],
    },
    /// A rod's turns are to be points of its mesh.
    #[error("the rod's turns cannot begin at point {first_turn}: the mesh itself has {points} points")]
    Turn {
        /// The first turn.
        first_turn: u32,
        /// The points of the mesh.
        points: usize,
    },
    /// Three or more edges of a rod meet in a point, where it has no one tangent before and one after.
    #[error("{edges} edges of the rod meet in point {point}; bending needs one before and one after")]
    Branch {
        /// The point.
        point: u32,
        /// How many edges meet there.
        edges: usize,
    },
}

/// `value` if it is positive and finite.
pub(crate) fn positive(parameter: &'static str, value: f64) -> Result<f64, ThinError> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(ThinError::Parameter { parameter, value, expected: "positive and finite" })
    }
}
