//! Tetrahedral and triangle meshes: types that are valid by construction, the boundary surface with its topology,
//! quality measures, generators, and files.
//!
//! | type | holds |
//! |---|---|
//! | [`TetMesh`] | points and tetrahedra |
//! | [`TriMesh`] | points and triangles, and also the codimensional parts a contact solver knows: free edges, free points |
//! | [`Surface`] | the boundary of either: outward triangles, unique edges, map back to the points it came from |
//!
//! Every constructor checks its input and answers a [`MeshError`] that names the culprit, so code that receives a
//! mesh need not check again: all indices are in range, no cell repeats a vertex, all positions are finite.
//! Orientation is *not* part of that promise, because files and solvers legitimately hold inverted cells:
//! [`TetMesh::check_orientation`] asks, [`TetMesh::orient`] repairs and says what it changed.
//!
//! A tetrahedron `[a, b, c, d]` is positively oriented when `(b − a) × (c − a) · (d − a) > 0`: the normal
//! `(b − a) × (c − a)` of the triangle `a b c` points to the side on which `d` lies.
//!
//! Nothing here depends on the order of a hash map: the same input gives the same numbering everywhere.
//!
//! ```
//! use mechanics_core::mesh::{BoxSplit, Surface, block};
//! use mechanics_core::tensor::Vec3;
//!
//! let cube = block(&Vec3::zeros(), &Vec3::new(1.0, 1.0, 1.0), [2, 2, 2], BoxSplit::Six)?;
//! let skin = Surface::of_tets(&cube)?;
//! assert_eq!((cube.cells().len(), skin.triangles().len(), skin.edges().len()), (48, 48, 72));
//! assert_eq!(skin.euler_characteristic(), 2);
//! assert!((skin.volume() - 1.0).abs() < 1e-15);
//! # Ok::<(), mechanics_core::mesh::MeshError>(())
//! ```

mod error;
mod generate;
#[cfg(feature = "mesh-files")]
pub mod io;
mod points;
mod quality;
mod surface;
mod tet_mesh;
mod topology;
mod tri_mesh;

pub use error::{CellKind, MeshError};
pub use generate::{
    BoxSplit, CylinderEnds, Diagonals, PolylineEnds, ball, block, cylinder, cylinder_surface, height_field,
    polyline, rod, sheet, sphere, torus,
};
pub use points::BoundingBox;
pub use quality::{QualitySummary, TetQuality, TriangleQuality, Worst, tet_quality, triangle_quality};
pub use surface::{Components, Surface};
pub use tet_mesh::{TetMesh, tet_volume};
pub use tri_mesh::{TriMesh, triangle_area_vector};
