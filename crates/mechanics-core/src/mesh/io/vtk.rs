//! VTK's XML files for ParaView: VTU (tetrahedra), VTP (triangles, free edges, free points), PVD (time series).
//!
//! Arrays are written inline, as text or as uncompressed base64 with a 64-bit length before each array, in
//! little-endian order. Points and scalar fields are `Float64`, connectivity is `Int64`.

mod array;
mod pvd;

pub use pvd::{PvdEntry, write_pvd, write_pvd_file};

use super::atomic;
use super::error::MeshFileError;
use crate::mesh::{TetMesh, TriMesh};
use crate::tensor::{Mat3, Vec3};
use array::{Arrays, escaped};
use std::io::Write;
use std::path::Path;

/// How arrays are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VtkEncoding {
    /// Text with all digits: large, for reading by eye.
    Ascii,
    /// Base64: exact and compact.
    #[default]
    Base64,
}

/// One value per point or per cell.
#[derive(Clone, Copy, Debug)]
pub enum FieldValues<'a> {
    /// Numbers.
    Scalars(&'a [f64]),
    /// Whole numbers, such as regions.
    Integers(&'a [i32]),
    /// Vectors.
    Vectors(&'a [Vec3]),
    /// Tensors, written row by row.
    Tensors(&'a [Mat3]),
}

impl FieldValues<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Scalars(values) => values.len(),
            Self::Integers(values) => values.len(),
            Self::Vectors(values) => values.len(),
            Self::Tensors(values) => values.len(),
        }
    }
}

/// A named field.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// What ParaView shows it as.
    pub name: &'a str,
    /// Its values.
    pub values: FieldValues<'a>,
}

impl<'a> Field<'a> {
    /// A field of numbers.
    pub fn scalars(name: &'a str, values: &'a [f64]) -> Self {
        Self { name, values: FieldValues::Scalars(values) }
    }

    /// A field of vectors.
    pub fn vectors(name: &'a str, values: &'a [Vec3]) -> Self {
        Self { name, values: FieldValues::Vectors(values) }
    }
}

/// The fields of a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fields<'a> {
    /// One value for each point.
    pub points: &'a [Field<'a>],
    /// One value for each cell; in a VTP file in the order free points, free edges, triangles.
    pub cells: &'a [Field<'a>],
}

impl Fields<'_> {
    fn check(&self, points: usize, cells: usize) {
        for (fields, count, what) in [(self.points, points, "points"), (self.cells, cells, "cells")] {
            for field in fields {
                let length = field.values.len();
                assert_eq!(length, count, "field {:?} has {length} values for {count} {what}", field.name);
            }
        }
    }
}

/// Writes tetrahedra with fields as VTU.
///
/// # Errors
/// Those of the writer.
///
/// # Panics
/// If a field's length is not the number of points or cells.
pub fn write_vtu(
    mesh: &TetMesh,
    fields: &Fields<'_>,
    encoding: VtkEncoding,
    sink: &mut impl Write,
) -> Result<(), MeshFileError> {
    const TETRAHEDRON: u8 = 10;
    let (points, cells) = (mesh.points().len(), mesh.cells().len());
    fields.check(points, cells);
    let mut file = Arrays::begin("UnstructuredGrid", encoding, sink)?;
    file.line(&format!("<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"))?;
    file.points(mesh.points())?;
    file.line("<Cells>")?;
    file.integers("connectivity", cells * 4, mesh.cells().iter().flatten().map(|&i| i64::from(i)))?;
    file.integers("offsets", cells, (1..=cells).map(|k| 4 * k as i64))?;
    file.bytes("types", cells, std::iter::repeat_n(TETRAHEDRON, cells))?;
    file.line("</Cells>")?;
    file.fields(fields)?;
    file.end("UnstructuredGrid")
}

/// Writes tetrahedra with fields to a VTU file.
///
/// # Errors
/// [`MeshFileError::System`]; the file is then as before.
///
/// # Panics
/// If a field's length is not the number of points or cells.
pub fn write_vtu_file(
    mesh: &TetMesh,
    fields: &Fields<'_>,
    encoding: VtkEncoding,
    path: impl AsRef<Path>,
) -> Result<(), MeshFileError> {
    atomic::write_file(path.as_ref(), |sink| write_vtu(mesh, fields, encoding, sink))
}

/// Writes free points, free edges and triangles with fields as VTP.
///
/// # Errors
/// Those of the writer.
///
/// # Panics
/// If a field's length is not the number of points, or that of free points, free edges and triangles together.
pub fn write_vtp(
    mesh: &TriMesh,
    fields: &Fields<'_>,
    encoding: VtkEncoding,
    sink: &mut impl Write,
) -> Result<(), MeshFileError> {
    let points = mesh.points().len();
    let (verts, lines, polys) = (mesh.free_points().len(), mesh.free_edges().len(), mesh.triangles().len());
    fields.check(points, verts + lines + polys);
    let mut file = Arrays::begin("PolyData", encoding, sink)?;
    file.line(&format!(
        "<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{verts}\" NumberOfLines=\"{lines}\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"{polys}\">"
    ))?;
    file.points(mesh.points())?;
    file.cells("Verts", 1, mesh.free_points())?;
    file.cells("Lines", 2, mesh.free_edges().as_flattened())?;
    file.cells("Polys", 3, mesh.triangles().as_flattened())?;
    file.fields(fields)?;
    file.end("PolyData")
}

/// Writes free points, free edges and triangles with fields to a VTP file.
///
/// # Errors
/// [`MeshFileError::System`]; the file is then as before.
///
/// # Panics
/// As [`write_vtp`].
pub fn write_vtp_file(
    mesh: &TriMesh,
    fields: &Fields<'_>,
    encoding: VtkEncoding,
    path: impl AsRef<Path>,
) -> Result<(), MeshFileError> {
    atomic::write_file(path.as_ref(), |sink| write_vtp(mesh, fields, encoding, sink))
}
