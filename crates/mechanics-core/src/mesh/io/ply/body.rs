//! The body: rows of numbers, as text or binary.

use super::PlyEncoding;
use super::header::{Element, Header, Kind, Number, error};
use crate::mesh::TriMesh;
use crate::mesh::io::bytes::{ByteCursor, ByteOrder};
use crate::mesh::io::error::{MeshFileError, MeshFormat, Place};
use crate::mesh::io::text::{TextCursor, parse, quoted};
use crate::tensor::Vec3;

pub(super) fn read(header: &Header<'_>, bytes: &[u8]) -> Result<TriMesh, MeshFileError> {
    let mut source = match header.encoding {
        PlyEncoding::Ascii => {
            Source::Text(TextCursor::new(MeshFormat::Ply, bytes, header.offset, header.line))
        }
        PlyEncoding::Binary(order) => {
            Source::Binary(ByteCursor::new(MeshFormat::Ply, order, bytes, header.offset), order)
        }
    };
    let vertices = header.elements.iter().find(|e| e.name == b"vertex");
    let Some(vertices) = vertices.map(|e| e.count) else {
        return Err(error(1, "no element \"vertex\"", "one"));
    };
    let (mut points, mut triangles, mut edges) = (Vec::new(), Vec::new(), Vec::new());
    for element in &header.elements {
        match element.name {
            b"vertex" => read_points(&mut source, element, &mut points)?,
            b"face" => read_faces(&mut source, element, vertices, &mut triangles)?,
            b"edge" => read_edges(&mut source, element, vertices, &mut edges)?,
            b"tristrips" => {
                return Err(MeshFileError::Unsupported {
                    format: MeshFormat::Ply,
                    place: Place::Line(element.line),
                    found: "element \"tristrips\"".into(),
                    supported: "triangles are read from element \"face\"",
                });
            }
            _ => for_each_row(&mut source, element, |_, _| Ok(()))?,
        }
    }
    TriMesh::with_codimensional(points, triangles, edges, Vec::new())
        .map_err(MeshFileError::mesh(MeshFormat::Ply))
}

fn read_points(
    source: &mut Source<'_>,
    element: &Element<'_>,
    points: &mut Vec<Vec3>,
) -> Result<(), MeshFileError> {
    let x = scalar_column(element, b"x")?;
    let y = scalar_column(element, b"y")?;
    let z = scalar_column(element, b"z")?;
    for_each_row(source, element, |source, row| {
        let point = [row.scalar(x), row.scalar(y), row.scalar(z)];
        match point.iter().find(|x| !x.is_finite()) {
            Some(bad) => Err(source.error(bad.to_string(), "a finite coordinate in the vertex before")),
            None => {
                points.push(point.into());
                Ok(())
            }
        }
    })
}

fn read_faces(
    source: &mut Source<'_>,
    element: &Element<'_>,
    vertices: u64,
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), MeshFileError> {
    let expected = "a list of integers \"vertex_indices\" or \"vertex_index\"";
    let column = element
        .position(b"vertex_indices")
        .or_else(|| element.position(b"vertex_index"))
        .filter(|&c| matches!(element.properties[c].kind, Kind::List { item, .. } if item.is_integer()))
        .ok_or_else(|| error(element.line, "element \"face\" without it", expected))?;
    for_each_row(source, element, |source, row| {
        let corners = row.list(column);
        if corners.len() < 3 {
            let found = format!("{} corners in the face before", corners.len());
            return Err(source.error(found, "at least 3"));
        }
        for k in 1..corners.len() - 1 {
            let [a, b, c] = [corners[0], corners[k], corners[k + 1]];
            let triangle =
                [index(source, a, vertices)?, index(source, b, vertices)?, index(source, c, vertices)?];
            different(source, &triangle)?;
            triangles.push(triangle);
        }
        Ok(())
    })
}

fn read_edges(
    source: &mut Source<'_>,
    element: &Element<'_>,
    vertices: u64,
    edges: &mut Vec<[u32; 2]>,
) -> Result<(), MeshFileError> {
    let first = scalar_column(element, b"vertex1")?;
    let second = scalar_column(element, b"vertex2")?;
    for_each_row(source, element, |source, row| {
        let edge =
            [index(source, row.scalar(first), vertices)?, index(source, row.scalar(second), vertices)?];
        different(source, &edge)?;
        edges.push(edge);
        Ok(())
    })
}

fn scalar_column(element: &Element<'_>, name: &'static [u8]) -> Result<usize, MeshFileError> {
    let column = element.position(name).filter(|&c| matches!(element.properties[c].kind, Kind::One(_)));
    column.ok_or_else(|| {
        let found = format!("element {} without a number {}", quoted(element.name), quoted(name));
        error(element.line, found, "that property")
    })
}

/// A vertex index; numbers of every PLY type are exact in f64.
fn index(source: &Source<'_>, value: f64, vertices: u64) -> Result<u32, MeshFileError> {
    if value >= 0.0 && value < vertices as f64 && value.fract() == 0.0 && value <= f64::from(u32::MAX) {
        return Ok(value as u32);
    }
    let found = format!("the index {value} just before, with {vertices} vertices");
    Err(source.error(found, "the index of a vertex, from 0"))
}

fn different(source: &Source<'_>, corners: &[u32]) -> Result<(), MeshFileError> {
    for (k, corner) in corners.iter().enumerate() {
        if corners[..k].contains(corner) {
            return Err(
                source.error(format!("vertex {corner} twice in the cell before"), "different vertices")
            );
        }
    }
    Ok(())
}

/// The values of one row: property k has those from `ends[k − 1]` to `ends[k]`.
#[derive(Default)]
struct Row {
    values: Vec<f64>,
    ends: Vec<usize>,
}

impl Row {
    fn list(&self, column: usize) -> &[f64] {
        let start = if column == 0 { 0 } else { self.ends[column - 1] };
        &self.values[start..self.ends[column]]
    }

    fn scalar(&self, column: usize) -> f64 {
        self.list(column)[0]
    }
}

fn for_each_row<'a>(
    source: &mut Source<'a>,
    element: &Element<'_>,
    mut visit: impl FnMut(&Source<'a>, &Row) -> Result<(), MeshFileError>,
) -> Result<(), MeshFileError> {
    let mut row = Row::default();
    for _ in 0..element.count {
        row.values.clear();
        row.ends.clear();
        for property in &element.properties {
            match property.kind {
                Kind::One(number) => row.values.push(source.value(number)?),
                Kind::List { length, item } => {
                    let length = source.value(length)?;
                    if length < 0.0 {
                        return Err(source.error(format!("a list of length {length}"), "a length from 0 up"));
                    }
                    // The length is at most 2³² − 1; every item needs a byte, so the file bounds the loop.
                    for _ in 0..length as u64 {
                        row.values.push(source.value(item)?);
                    }
                }
            }
            row.ends.push(row.values.len());
        }
        visit(source, &row)?;
    }
    Ok(())
}

enum Source<'a> {
    Text(TextCursor<'a>),
    Binary(ByteCursor<'a>, ByteOrder),
}

impl Source<'_> {
    fn value(&mut self, number: Number) -> Result<f64, MeshFileError> {
        match self {
            Self::Text(cursor) => text_value(cursor, number),
            Self::Binary(cursor, order) => binary_value(cursor, *order, number),
        }
    }

    fn error(&self, found: impl Into<String>, expected: &'static str) -> MeshFileError {
        match self {
            Self::Text(cursor) => cursor.error(found, expected),
            Self::Binary(cursor, _) => cursor.error(found, expected),
        }
    }
}

fn text_value(cursor: &mut TextCursor<'_>, number: Number) -> Result<f64, MeshFileError> {
    if !number.is_integer() {
        return cursor.number("a number");
    }
    let expected = "an integer in the range of its type";
    let token = cursor.token(expected)?;
    let range = match number {
        Number::I8 => i64::from(i8::MIN)..=i64::from(i8::MAX),
        Number::U8 => 0..=i64::from(u8::MAX),
        Number::I16 => i64::from(i16::MIN)..=i64::from(i16::MAX),
        Number::U16 => 0..=i64::from(u16::MAX),
        Number::I32 => i64::from(i32::MIN)..=i64::from(i32::MAX),
        _ => 0..=i64::from(u32::MAX),
    };
    match parse::<i64>(token).filter(|value| range.contains(value)) {
        Some(value) => Ok(value as f64),
        None => Err(cursor.error(quoted(token), expected)),
    }
}

fn binary_value(cursor: &mut ByteCursor<'_>, order: ByteOrder, number: Number) -> Result<f64, MeshFileError> {
    let taken = cursor.take(number.size(), "a value of an element")?;
    let mut bytes = [0_u8; 8];
    bytes[..taken.len()].copy_from_slice(taken);
    if order == ByteOrder::BigEndian {
        bytes[..taken.len()].reverse();
    }
    let [a, b, c, d, ..] = bytes;
    Ok(match number {
        Number::I8 => f64::from(a as i8),
        Number::U8 => f64::from(a),
        Number::I16 => f64::from(i16::from_le_bytes([a, b])),
        Number::U16 => f64::from(u16::from_le_bytes([a, b])),
        Number::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
        Number::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
        Number::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        Number::F64 => f64::from_le_bytes(bytes),
    })
}
