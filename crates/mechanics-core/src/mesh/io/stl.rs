//! STL, ASCII and binary.
//!
//! STL is a list of separate triangles; points are merged where their coordinates are bitwise equal (after reading:
//! binary files hold f32, ASCII files are read as f64). Triangles two corners of which coincide are left out and
//! listed in [`StlMesh::dropped_facets`]. Normals and attribute bytes are ignored; the order of the corners says which
//! way a triangle faces.
//!
//! Many binary files begin with "solid", as ASCII files must. A file is binary if its length is exactly the 84 + 50 n
//! bytes that the count at byte 80 asks for, whatever it begins with; otherwise it is ASCII if it begins with
//! "solid".

use super::atomic;
use super::bytes::{ByteCursor, ByteOrder};
use super::error::{MeshFileError, MeshFormat, Place};
use super::text::{TextCursor, quoted, syntax};
use crate::mesh::{TriMesh, topology, triangle_area_vector};
use crate::tensor::Vec3;
use std::io::Write;
use std::path::Path;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StlEncoding {
    /// Text, with all digits of the f64 coordinates.
    Ascii,
    /// 50 bytes a triangle; coordinates are rounded to f32.
    Binary,
}

/// What an STL file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StlMesh {
    /// The triangles, over merged points in the order of their first appearance.
    pub mesh: TriMesh,
    /// The numbers (from 0, in the file) of the triangles left out because two of their corners coincide.
    pub dropped_facets: Vec<u32>,
}

/// Reads the bytes of an STL file.
///
/// # Errors
/// [`MeshFileError::Syntax`] naming the line or the byte.
pub fn read(bytes: &[u8]) -> Result<StlMesh, MeshFileError> {
    let corners = match claimed_length(bytes) {
        Some(length) if length == bytes.len() as u64 => binary_corners(bytes)?,
        _ if bytes.trim_ascii_start().get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid")) => {
            ascii_corners(bytes)?
        }
        Some(length) => {
            let found = format!("{} bytes where the count at byte 80 asks for {length}", bytes.len());
            let expected = "\"solid\", or a binary file of matching length";
            return Err(syntax(MeshFormat::Stl, Place::Byte(80), found, expected));
        }
        None => {
            let found = format!("{} bytes that do not begin with \"solid\"", bytes.len());
            return Err(syntax(MeshFormat::Stl, Place::Byte(0), found, "at least 84 bytes"));
        }
    };
    welded(&corners)
}

/// Reads an STL file.
///
/// # Errors
/// As [`read`], and [`MeshFileError::System`].
pub fn read_file(path: impl AsRef<Path>) -> Result<StlMesh, MeshFileError> {
    read(&atomic::read_bytes(path.as_ref())?)
}

/// Writes the triangles of a mesh as STL.
///
/// # Errors
/// [`MeshFileError::NotRepresentable`] for a mesh with free edges or points, or coordinates beyond f32 in a binary
/// file; those of the writer.
pub fn write(mesh: &TriMesh, encoding: StlEncoding, sink: &mut impl Write) -> Result<(), MeshFileError> {
    if !mesh.free_edges().is_empty() || !mesh.free_points().is_empty() {
        return Err(MeshFileError::not_representable(MeshFormat::Stl, "free edges and free points"));
    }
    match encoding {
        StlEncoding::Ascii => write_ascii(mesh, sink),
        StlEncoding::Binary => write_binary(mesh, sink),
    }
}

/// Writes the triangles of a mesh to an STL file.
///
/// # Errors
/// As [`write()`], and [`MeshFileError::System`]; the file is then as before.
pub fn write_file(
    mesh: &TriMesh,
    encoding: StlEncoding,
    path: impl AsRef<Path>,
) -> Result<(), MeshFileError> {
    atomic::write_file(path.as_ref(), |sink| write(mesh, encoding, sink))
}

/// The length that a binary file with the count at byte 80 has.
fn claimed_length(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(80..84)?;
    Some(84 + 50 * u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]])))
}

fn binary_corners(bytes: &[u8]) -> Result<Vec<Vec3>, MeshFileError> {
    let mut cursor = ByteCursor::new(MeshFormat::Stl, ByteOrder::LittleEndian, bytes, 84);
    let mut corners = Vec::new();
    while cursor.remaining() > 0 {
        cursor.take(12, "a normal")?;
        for _ in 0..3 {
            corners.push(binary_point(&mut cursor)?);
        }
        cursor.take(2, "an attribute")?;
    }
    Ok(corners)
}

fn binary_point(cursor: &mut ByteCursor<'_>) -> Result<Vec3, MeshFileError> {
    let mut point = Vec3::zeros();
    for coordinate in point.iter_mut() {
        let value = f32::from_le_bytes(cursor.array("a coordinate")?);
        if !value.is_finite() {
            return Err(cursor.error_back(4, value.to_string(), "a finite coordinate"));
        }
        *coordinate = f64::from(value);
    }
    Ok(point)
}

fn ascii_corners(bytes: &[u8]) -> Result<Vec<Vec3>, MeshFileError> {
    let mut cursor = TextCursor::new(MeshFormat::Stl, bytes, 0, 1);
    let mut corners = Vec::new();
    keyword(&mut cursor, "solid")?;
    cursor.next_line();
    loop {
        let expected = "\"facet\" or \"endsolid\"";
        let word = cursor.token(expected)?;
        if word.eq_ignore_ascii_case(b"facet") {
            facet(&mut cursor, &mut corners)?;
        } else if word.eq_ignore_ascii_case(b"endsolid") {
            cursor.next_line();
            // A file may hold several solids.
            if bytes[cursor.offset..].iter().all(u8::is_ascii_whitespace) {
                return Ok(corners);
            }
            keyword(&mut cursor, "solid")?;
            cursor.next_line();
        } else {
            return Err(cursor.error(quoted(word), expected));
        }
    }
}

fn facet(cursor: &mut TextCursor<'_>, corners: &mut Vec<Vec3>) -> Result<(), MeshFileError> {
    keyword(cursor, "normal")?;
    for _ in 0..3 {
        // Not asked to be finite: exporters write NaN as the normal of a flat triangle.
        cursor.number::<f64>("a component of the normal")?;
    }
    keyword(cursor, "outer")?;
    keyword(cursor, "loop")?;
    for _ in 0..3 {
        keyword(cursor, "vertex")?;
        corners.push(Vec3::new(cursor.finite()?, cursor.finite()?, cursor.finite()?));
    }
    keyword(cursor, "endloop")?;
    keyword(cursor, "endfacet")
}

fn keyword(cursor: &mut TextCursor<'_>, expected: &'static str) -> Result<(), MeshFileError> {
    let word = cursor.token(expected)?;
    if word.eq_ignore_ascii_case(expected.as_bytes()) {
        return Ok(());
    }
    Err(cursor.error(quoted(word), expected))
}

/// Three corners a triangle, merged where equal.
fn welded(corners: &[Vec3]) -> Result<StlMesh, MeshFileError> {
    let refuse = MeshFileError::mesh(MeshFormat::Stl);
    crate::mesh::points::check_points(corners).map_err(&refuse)?;
    let (points, index) = topology::weld(corners);
    let mut triangles = Vec::new();
    let mut dropped_facets = Vec::new();
    for (facet, corner) in (0_u32..).zip(index.chunks_exact(3)) {
        let [a, b, c] = [corner[0], corner[1], corner[2]];
        if a == b || b == c || c == a {
            dropped_facets.push(facet);
        } else {
            triangles.push([a, b, c]);
        }
    }
    Ok(StlMesh { mesh: TriMesh::new(points, triangles).map_err(&refuse)?, dropped_facets })
}

fn unit_normal(corners: &[Vec3; 3]) -> Vec3 {
    triangle_area_vector(corners).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}

fn write_ascii(mesh: &TriMesh, sink: &mut impl Write) -> Result<(), MeshFileError> {
    writeln!(sink, "solid mesh")?;
    for t in 0..mesh.triangles().len() {
        let corners = mesh.corners(t);
        let n = unit_normal(&corners);
        writeln!(sink, "facet normal {:?} {:?} {:?}\n outer loop", n.x, n.y, n.z)?;
        for p in corners {
            writeln!(sink, "  vertex {:?} {:?} {:?}", p.x, p.y, p.z)?;
        }
        writeln!(sink, " endloop\nendfacet")?;
    }
    writeln!(sink, "endsolid mesh")?;
    Ok(())
}

fn write_binary(mesh: &TriMesh, sink: &mut impl Write) -> Result<(), MeshFileError> {
    if let Some(i) = mesh.points().iter().position(|p| p.amax() > f64::from(f32::MAX)) {
        let what = format!("point {i} in binary: it lies beyond the range of f32");
        return Err(MeshFileError::not_representable(MeshFormat::Stl, what));
    }
    let mut header = [b' '; 80];
    let title = b"binary STL, metres";
    header[..title.len()].copy_from_slice(title);
    sink.write_all(&header)?;
    sink.write_all(&(mesh.triangles().len() as u32).to_le_bytes())?;
    for t in 0..mesh.triangles().len() {
        let corners = mesh.corners(t);
        for x in std::iter::once(&unit_normal(&corners)).chain(&corners).flatten() {
            sink.write_all(&(*x as f32).to_le_bytes())?;
        }
        sink.write_all(&[0; 2])?;
    }
    Ok(())
}
