//! Wavefront OBJ: vertices, polygons, polylines and points.
//!
//! Read are `v` (further numbers, such as colours, are checked and left out), `f`, `l` and `p` with positive or
//! negative (relative) indices and with any of the forms `v`, `v/vt`, `v//vn`, `v/vt/vn`; texture and normal
//! indices are left out. Polygons are cut into triangles in a fan from their first corner, so they should be convex.
//! Free-form curves and surfaces are refused; names, groups, materials, normals and texture coordinates are skipped.
//! A backslash at the end of a line continues it.

use super::atomic;
use super::error::{MeshFileError, MeshFormat, Place};
use super::text::{FINITE, lines, parse, parse_finite, quoted, syntax, words};
use crate::mesh::TriMesh;
use crate::tensor::Vec3;
use std::io::Write;
use std::path::Path;

const INDEX: &str = "the index of a vertex: from 1 up, or from −1 down counting back from here";

/// Reads a mesh from the bytes of an OBJ file.
///
/// # Errors
/// [`MeshFileError::Syntax`] or [`MeshFileError::Unsupported`] naming the line.
pub fn read(bytes: &[u8]) -> Result<TriMesh, MeshFileError> {
    // Faces may refer to vertices that come later, so they are counted first.
    let total = statements(bytes).filter(|s| words(&s.text).next() == Some(b"v")).count();
    let mut reader = Reader { total, ..Reader::default() };
    for statement in statements(bytes) {
        reader.statement(&statement)?;
    }
    TriMesh::with_codimensional(reader.points, reader.triangles, reader.edges, reader.free_points)
        .map_err(MeshFileError::mesh(MeshFormat::Obj))
}

/// Reads a mesh from an OBJ file.
///
/// # Errors
/// As [`read`], and [`MeshFileError::System`].
pub fn read_file(path: impl AsRef<Path>) -> Result<TriMesh, MeshFileError> {
    read(&atomic::read_bytes(path.as_ref())?)
}

/// Writes a mesh as OBJ: `v`, then `f`, `l` and `p`. Coordinates are written so that they read back bit by bit.
///
/// # Errors
/// Those of the writer.
pub fn write(mesh: &TriMesh, sink: &mut impl Write) -> Result<(), MeshFileError> {
    for p in mesh.points() {
        writeln!(sink, "v {:?} {:?} {:?}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in mesh.triangles().iter().map(|t| t.map(|i| u64::from(i) + 1)) {
        writeln!(sink, "f {a} {b} {c}")?;
    }
    for [a, b] in mesh.free_edges().iter().map(|e| e.map(|i| u64::from(i) + 1)) {
        writeln!(sink, "l {a} {b}")?;
    }
    for &p in mesh.free_points() {
        writeln!(sink, "p {}", u64::from(p) + 1)?;
    }
    Ok(())
}

/// Writes a mesh to an OBJ file.
///
/// # Errors
/// [`MeshFileError::System`]; the file is then as before.
pub fn write_file(mesh: &TriMesh, path: impl AsRef<Path>) -> Result<(), MeshFileError> {
    atomic::write_file(path.as_ref(), |sink| write(mesh, sink))
}

/// A line with its continuations, without its comment.
struct Statement<'a> {
    line: usize,
    text: std::borrow::Cow<'a, [u8]>,
}

fn statements(bytes: &[u8]) -> impl Iterator<Item = Statement<'_>> {
    let mut lines = lines(bytes);
    std::iter::from_fn(move || {
        let first = lines.next()?;
        let mut text = std::borrow::Cow::Borrowed(without_comment(first.bytes));
        while text.last() == Some(&b'\\') {
            let continued = text.to_mut();
            continued.pop();
            continued.push(b' ');
            match lines.next() {
                Some(next) => continued.extend_from_slice(without_comment(next.bytes)),
                None => break,
            }
        }
        Some(Statement { line: first.number, text })
    })
}

fn without_comment(line: &[u8]) -> &[u8] {
    line.split(|&b| b == b'#').next().unwrap_or_default().trim_ascii()
}

#[derive(Default)]
struct Reader {
    total: usize,
    points: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    edges: Vec<[u32; 2]>,
    free_points: Vec<u32>,
}

impl Reader {
    fn statement(&mut self, statement: &Statement<'_>) -> Result<(), MeshFileError> {
        let line = statement.line;
        let mut words = words(&statement.text);
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword {
            b"v" => self.vertex(line, words),
            b"f" => self.polygon(&self.corners(line, words, 3, "at least 3 corners in a polygon")?, line),
            b"l" => {
                let corners = self.corners(line, words, 2, "at least 2 points in a line")?;
                corners.windows(2).try_for_each(|w| different(w, line))?;
                self.edges.extend(corners.windows(2).map(|w| [w[0], w[1]]));
                Ok(())
            }
            b"p" => {
                let points = self.corners(line, words, 1, "at least one point")?;
                self.free_points.extend(points);
                Ok(())
            }
            b"curv" | b"curv2" | b"surf" => Err(MeshFileError::Unsupported {
                format: MeshFormat::Obj,
                place: Place::Line(line),
                found: format!("a free-form {}", quoted(keyword)),
                supported: "only polygons, lines and points are read",
            }),
            _ => Ok(()),
        }
    }

    fn vertex<'a>(
        &mut self,
        line: usize,
        words: impl Iterator<Item = &'a [u8]>,
    ) -> Result<(), MeshFileError> {
        let mut point = [0.0; 3];
        let mut count = 0;
        for word in words {
            let value = parse_finite(word).ok_or_else(|| error(line, quoted(word), FINITE))?;
            if let Some(coordinate) = point.get_mut(count) {
                *coordinate = value;
            }
            count += 1;
        }
        if count < 3 {
            return Err(error(line, format!("{count} numbers"), "3 coordinates of a vertex"));
        }
        self.points.push(point.into());
        Ok(())
    }

    fn corners<'a>(
        &self,
        line: usize,
        words: impl Iterator<Item = &'a [u8]>,
        least: usize,
        expected: &'static str,
    ) -> Result<Vec<u32>, MeshFileError> {
        let corners: Vec<u32> = words.map(|word| self.index(line, word)).collect::<Result<_, _>>()?;
        if corners.len() < least {
            return Err(error(line, corners.len().to_string(), expected));
        }
        Ok(corners)
    }

    /// The first of the indices between slashes; the others need only be integers.
    fn index(&self, line: usize, word: &[u8]) -> Result<u32, MeshFileError> {
        let mut parts = word.split(|&b| b == b'/');
        let index: i64 = parts.next().and_then(parse).ok_or_else(|| error(line, quoted(word), INDEX))?;
        let others_are_integers = parts.all(|part| part.is_empty() || parse::<i64>(part).is_some());
        let found = if index < 0 {
            (self.points.len() as i64).checked_add(index).filter(|&i| i >= 0)
        } else {
            (index > 0 && index <= self.total as i64).then_some(index - 1)
        };
        match found.and_then(|i| u32::try_from(i).ok()).filter(|_| others_are_integers) {
            Some(i) => Ok(i),
            None => {
                let found = format!("{} in a file of {} vertices", quoted(word), self.total);
                Err(error(line, found, INDEX))
            }
        }
    }

    fn polygon(&mut self, corners: &[u32], line: usize) -> Result<(), MeshFileError> {
        for k in 1..corners.len() - 1 {
            different(&[corners[0], corners[k], corners[k + 1]], line)?;
            self.triangles.push([corners[0], corners[k], corners[k + 1]]);
        }
        Ok(())
    }
}

fn different(corners: &[u32], line: usize) -> Result<(), MeshFileError> {
    for (k, corner) in corners.iter().enumerate() {
        if corners[..k].contains(corner) {
            let found = format!("vertex {} twice", u64::from(*corner) + 1);
            return Err(error(line, found, "different vertices"));
        }
    }
    Ok(())
}

fn error(line: usize, found: impl Into<String>, expected: &'static str) -> MeshFileError {
    syntax(MeshFormat::Obj, Place::Line(line), found, expected)
}
