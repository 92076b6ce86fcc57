//! PLY, ASCII and binary in both byte orders.
//!
//! Properties are found by name, in any order and of any type: `x`, `y`, `z` of element `vertex`; the list
//! `vertex_indices` or `vertex_index` of `face`; `vertex1` and `vertex2` of `edge` (read as free edges). Other
//! properties and elements are passed over, except `tristrips`, which is refused because it holds triangles that would
//! be lost. Polygons are cut into triangles in a fan from their first corner, so they should be convex. A vertex that
//! nothing refers to stays in the list of points.

mod body;
mod header;

pub use super::bytes::ByteOrder;

use super::atomic;
use super::error::{MeshFileError, MeshFormat};
use crate::mesh::TriMesh;
use std::io::Write;
use std::path::Path;

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyEncoding {
    /// Text.
    Ascii,
    /// Binary in the stated byte order.
    Binary(ByteOrder),
}

/// Reads a mesh from the bytes of a PLY file.
///
/// # Errors
/// [`MeshFileError::Syntax`] or [`MeshFileError::Unsupported`] naming the line, or the byte in a binary body.
pub fn read(bytes: &[u8]) -> Result<TriMesh, MeshFileError> {
    let header = header::Header::read(bytes)?;
    body::read(&header, bytes)
}

/// Reads a mesh from a PLY file.
///
/// # Errors
/// As [`read`], and [`MeshFileError::System`].
pub fn read_file(path: impl AsRef<Path>) -> Result<TriMesh, MeshFileError> {
    read(&atomic::read_bytes(path.as_ref())?)
}

/// Writes a mesh as PLY: coordinates as `double`, triangles as lists of `uint`, free edges as element `edge` if there
/// are any.
///
/// # Errors
/// [`MeshFileError::NotRepresentable`] for a mesh with free points; those of the writer.
pub fn write(mesh: &TriMesh, encoding: PlyEncoding, sink: &mut impl Write) -> Result<(), MeshFileError> {
    if !mesh.free_points().is_empty() {
        return Err(MeshFileError::not_representable(MeshFormat::Ply, "free points"));
    }
    let format = match encoding {
        PlyEncoding::Ascii => "ascii",
        PlyEncoding::Binary(ByteOrder::LittleEndian) => "binary_little_endian",
        PlyEncoding::Binary(ByteOrder::BigEndian) => "binary_big_endian",
    };
    writeln!(sink, "ply\nformat {format} 1.0\nelement vertex {}", mesh.points().len())?;
    writeln!(sink, "property double x\nproperty double y\nproperty double z")?;
    writeln!(sink, "element face {}\nproperty list uchar uint vertex_indices", mesh.triangles().len())?;
    if !mesh.free_edges().is_empty() {
        let count = mesh.free_edges().len();
        writeln!(sink, "element edge {count}\nproperty uint vertex1\nproperty uint vertex2")?;
    }
    writeln!(sink, "end_header")?;
    match encoding {
        PlyEncoding::Ascii => write_text(mesh, sink),
        PlyEncoding::Binary(order) => write_binary(mesh, order, sink),
    }
}

/// Writes a mesh to a PLY file.
///
/// # Errors
/// As [`write()`], and [`MeshFileError::System`]; the file is then as before.
pub fn write_file(
    mesh: &TriMesh,
    encoding: PlyEncoding,
    path: impl AsRef<Path>,
) -> Result<(), MeshFileError> {
    atomic::write_file(path.as_ref(), |sink| write(mesh, encoding, sink))
}

fn write_text(mesh: &TriMesh, sink: &mut impl Write) -> Result<(), MeshFileError> {
    for p in mesh.points() {
        writeln!(sink, "{:?} {:?} {:?}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in mesh.triangles() {
        writeln!(sink, "3 {a} {b} {c}")?;
    }
    for [a, b] in mesh.free_edges() {
        writeln!(sink, "{a} {b}")?;
    }
    Ok(())
}

fn write_binary(mesh: &TriMesh, order: ByteOrder, sink: &mut impl Write) -> Result<(), MeshFileError> {
    let u32_bytes = |i: u32| match order {
        ByteOrder::LittleEndian => i.to_le_bytes(),
        ByteOrder::BigEndian => i.to_be_bytes(),
    };
    for &x in mesh.points().iter().flatten() {
        sink.write_all(&match order {
            ByteOrder::LittleEndian => x.to_le_bytes(),
            ByteOrder::BigEndian => x.to_be_bytes(),
        })?;
    }
    for triangle in mesh.triangles() {
        sink.write_all(&[3])?;
        triangle.iter().try_for_each(|&i| sink.write_all(&u32_bytes(i)))?;
    }
    mesh.free_edges().iter().flatten().try_for_each(|&i| sink.write_all(&u32_bytes(i)))?;
    Ok(())
}
