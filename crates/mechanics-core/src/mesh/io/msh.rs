//! Gmsh MSH 2.2 and 4.1, ASCII and binary of both byte orders.
//!
//! Read are points and first-order tetrahedra, triangles, lines and points, with their physical groups and the groups'
//! names. Elements of other kinds are counted in [`MshMesh::skipped`], never dropped in silence. Node numbers may be
//! any; indices follow the order of nodes in the file. Orientation is as in the file:
//! [`TetMesh::check_orientation`] asks and [`TetMesh::orient`] repairs. Other sections are passed over.

mod cursor;
mod read22;
mod read41;
mod reader;
mod write;

pub use write::{MshEncoding, MshVersion};

use super::atomic;
use super::error::MeshFileError;
use crate::mesh::topology::{sorted, triangle_edges};
use crate::mesh::{MeshError, TetMesh, TriMesh};
use crate::tensor::Vec3;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

/// Cells of one kind, with the physical group of each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MshCells<const N: usize> {
    /// The cells, as indices of points.
    pub vertices: Vec<[u32; N]>,
    /// For each cell its physical group, 0 for none. (Of a cell that is in several, MSH 2.2 repeats the cell, MSH 4.1
    /// lists the groups and the first is taken.)
    pub groups: Vec<i32>,
}

impl<const N: usize> MshCells<N> {
    fn ungrouped(vertices: Vec<[u32; N]>) -> Self {
        let groups = vec![0; vertices.len()];
        Self { vertices, groups }
    }
}

/// The name of a physical group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MshGroup {
    /// The dimension of its cells: 3 for tetrahedra … 0 for points.
    pub dimension: u8,
    /// Its number, as in [`MshCells::groups`].
    pub number: i32,
    /// Its name.
    pub name: String,
}

/// Elements of a kind that is not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MshSkipped {
    /// Gmsh's number for the kind of element (3 quadrilateral, 5 hexahedron, 11 quadratic tetrahedron, …).
    pub element_type: i32,
    /// How many there were.
    pub count: usize,
}

/// What an MSH file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MshMesh {
    /// The points \[m\].
    pub points: Vec<Vec3>,
    /// Tetrahedra.
    pub tets: MshCells<4>,
    /// Triangles.
    pub triangles: MshCells<3>,
    /// Lines of two points.
    pub edges: MshCells<2>,
    /// Points that are elements themselves.
    pub vertices: MshCells<1>,
    /// The names of physical groups.
    pub groups: Vec<MshGroup>,
    /// Elements that were left out, by ascending type.
    pub skipped: Vec<MshSkipped>,
}

impl MshMesh {
    /// The tetrahedra with all points of the file.
    ///
    /// # Errors
    /// As [`TetMesh::new`].
    pub fn tet_mesh(&self) -> Result<TetMesh, MeshError> {
        TetMesh::new(self.points.clone(), self.tets.vertices.clone())
    }

    /// The triangles with all points of the file; lines that are not an edge of a triangle become free edges, and
    /// points that belong to neither, free points. (Gmsh also writes the curves and corners of a surface's outline,
    /// which are not parts of their own.)
    ///
    /// # Errors
    /// As [`TriMesh::with_codimensional`].
    pub fn tri_mesh(&self) -> Result<TriMesh, MeshError> {
        let triangles = &self.triangles.vertices;
        let of_triangles: BTreeSet<[u32; 2]> =
            triangles.iter().flat_map(triangle_edges).map(sorted).collect();
        let is_free = |e: &&[u32; 2]| !of_triangles.contains(&sorted(**e));
        let edges: Vec<[u32; 2]> = self.edges.vertices.iter().filter(is_free).copied().collect();
        let mut used: BTreeSet<u32> =
            triangles.iter().flatten().chain(edges.iter().flatten()).copied().collect();
        let vertices = self.vertices.vertices.iter().map(|v| v[0]).filter(|&v| used.insert(v)).collect();
        TriMesh::with_codimensional(self.points.clone(), triangles.clone(), edges, vertices)
    }
}

impl From<&TetMesh> for MshMesh {
    fn from(mesh: &TetMesh) -> Self {
        let tets = MshCells::ungrouped(mesh.cells().to_vec());
        Self { points: mesh.points().to_vec(), tets, ..Self::default() }
    }
}

impl From<&TriMesh> for MshMesh {
    fn from(mesh: &TriMesh) -> Self {
        Self {
            points: mesh.points().to_vec(),
            triangles: MshCells::ungrouped(mesh.triangles().to_vec()),
            edges: MshCells::ungrouped(mesh.free_edges().to_vec()),
            vertices: MshCells::ungrouped(mesh.free_points().iter().map(|&p| [p]).collect()),
            ..Self::default()
        }
    }
}

/// Reads the bytes of an MSH file.
///
/// # Errors
/// [`MeshFileError::Syntax`] or [`MeshFileError::Unsupported`] naming the line, or the byte in a binary file.
pub fn read(bytes: &[u8]) -> Result<MshMesh, MeshFileError> {
    reader::read(bytes)
}

/// Reads an MSH file.
///
/// # Errors
/// As [`read`], and [`MeshFileError::System`].
pub fn read_file(path: impl AsRef<Path>) -> Result<MshMesh, MeshFileError> {
    read(&atomic::read_bytes(path.as_ref())?)
}

/// Writes points, cells and groups as MSH; binary in little-endian order. The list of skipped elements is not written.
///
/// # Errors
/// [`MeshFileError::NotRepresentable`] for a negative group or a group's name with quotation marks or line ends;
/// those of the writer.
///
/// # Panics
/// If a list of groups is not as long as its list of cells.
pub fn write(
    mesh: &MshMesh,
    version: MshVersion,
    encoding: MshEncoding,
    sink: &mut impl Write,
) -> Result<(), MeshFileError> {
    write::write(mesh, version, encoding, sink)
}

/// Writes an MSH file.
///
/// # Errors
/// As [`write()`], and [`MeshFileError::System`]; the file is then as before.
///
/// # Panics
/// As [`write()`].
pub fn write_file(
    mesh: &MshMesh,
    version: MshVersion,
    encoding: MshEncoding,
    path: impl AsRef<Path>,
) -> Result<(), MeshFileError> {
    atomic::write_file(path.as_ref(), |sink| write(mesh, version, encoding, sink))
}
