//! What both versions share: sections, the node numbers, the kinds of elements.

use super::cursor::{Encoding, MshCursor};
use super::{MshCells, MshGroup, MshMesh, MshSkipped, read22, read41};
use crate::mesh::io::bytes::ByteOrder;
use crate::mesh::io::error::MeshFileError;
use crate::mesh::io::text::{parse, quoted, words};
use crate::tensor::Vec3;
use std::collections::BTreeMap;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    V2,
    V41,
}

pub(super) fn read(bytes: &[u8]) -> Result<MshMesh, MeshFileError> {
    let mut cursor = MshCursor::new(bytes);
    let version = read_format(&mut cursor)?;
    let mut builder = Builder::default();
    let mut entities = read41::Entities::default();
    while let Some(name) = next_section(&mut cursor)? {
        match (name, version) {
            (b"$PhysicalNames", _) => read_names(&mut cursor, &mut builder.groups)?,
            (b"$Nodes", Version::V2) => read22::nodes(&mut cursor, &mut builder)?,
            (b"$Nodes", Version::V41) => read41::nodes(&mut cursor, &mut builder)?,
            (b"$Elements", Version::V2) => read22::elements(&mut cursor, &mut builder)?,
            (b"$Elements", Version::V41) => read41::elements(&mut cursor, &mut builder, &entities)?,
            (b"$Entities", Version::V41) => entities = read41::entities(&mut cursor)?,
            (b"$ParametricNodes", _) => {
                let found = "a section of parametric nodes in version 2.2";
                return Err(cursor.unsupported(found, "have Gmsh save without Mesh.SaveParametric"));
            }
            _ => {
                skip_section(&mut cursor, name)?;
                continue;
            }
        }
        let end = cursor.word("the end of the section")?;
        if end.strip_prefix(b"$End") != Some(&name[1..]) {
            return Err(cursor.error(quoted(end), "the end of the section"));
        }
    }
    builder.finish(&cursor)
}

fn read_format(cursor: &mut MshCursor<'_>) -> Result<Version, MeshFileError> {
    let expected = "\"$MeshFormat\"";
    let word = cursor.word(expected)?;
    if word != b"$MeshFormat" {
        return Err(cursor.error(quoted(word), expected));
    }
    let word = cursor.word("the version")?;
    let version = match word {
        b"2" | b"2.0" | b"2.1" | b"2.2" => Version::V2,
        b"4.1" => Version::V41,
        _ => return Err(cursor.unsupported(format!("version {}", quoted(word)), "2.2 and 4.1 are")),
    };
    let file_type: i32 = cursor.text.number("0 for text or 1 for binary")?;
    let size_bytes: usize = cursor.text.number("the size of numbers, 4 or 8")?;
    cursor.end_line()?;
    match file_type {
        0 => {}
        1 if size_bytes == 4 || size_bytes == 8 => cursor.encoding = marked_encoding(cursor, size_bytes)?,
        1 => return Err(cursor.error(size_bytes.to_string(), "the size of numbers, 4 or 8")),
        other => return Err(cursor.error(other.to_string(), "0 for text or 1 for binary")),
    }
    let end = cursor.word("\"$EndMeshFormat\"")?;
    if end != b"$EndMeshFormat" {
        return Err(cursor.error(quoted(end), "\"$EndMeshFormat\""));
    }
    Ok(version)
}

/// The byte order in which the next four bytes are the number 1.
fn marked_encoding(cursor: &mut MshCursor<'_>, size_bytes: usize) -> Result<Encoding, MeshFileError> {
    let marker = cursor.bytes.get(cursor.text.offset..cursor.text.offset + 4).unwrap_or_default();
    let order = match marker {
        [1, 0, 0, 0] => ByteOrder::LittleEndian,
        [0, 0, 0, 1] => ByteOrder::BigEndian,
        _ => return Err(cursor.error(quoted(marker), "the number 1 in four bytes, to tell the byte order")),
    };
    cursor.text.offset += 4;
    Ok(Encoding::Binary { order, size_bytes })
}

/// The name of the next section, with its "$"; `None` at the end of the file.
fn next_section<'a>(cursor: &mut MshCursor<'a>) -> Result<Option<&'a [u8]>, MeshFileError> {
    // Stops at the first byte that is not blank: a scan to the file's end for every section would be quadratic.
    if cursor.bytes[cursor.text.offset..].iter().all(u8::is_ascii_whitespace) {
        return Ok(None);
    }
    let name = cursor.word("a section")?;
    if name.len() < 2 || name[0] != b'$' {
        return Err(cursor.error(quoted(name), "the beginning of a section, \"$…\""));
    }
    cursor.end_line()?;
    Ok(Some(name))
}

fn skip_section(cursor: &mut MshCursor<'_>, name: &[u8]) -> Result<(), MeshFileError> {
    let end: Vec<u8> = [b"$End", &name[1..]].concat();
    // In text the end stands at the start of a line; binary data may hold line ends, but hardly "\n$EndName".
    while let Some(line) = cursor.text.next_line() {
        if line.bytes.trim_ascii() == end {
            return Ok(());
        }
    }
    Err(cursor.error(format!("no {}", quoted(&end)), "the end of a section"))
}

fn read_names(cursor: &mut MshCursor<'_>, groups: &mut Vec<MshGroup>) -> Result<(), MeshFileError> {
    let expected = "a dimension from 0 to 3, a number and a name in quotation marks";
    for _ in 0..cursor.text_count("the number of names")? {
        let line = cursor.text.next_line().map_or(&b""[..], |line| line.bytes);
        let parsed = || {
            let mut words = words(line);
            let dimension = words.next().and_then(parse).filter(|&d: &u8| d <= 3)?;
            let number = words.next().and_then(parse)?;
            let quote = line.iter().position(|&b| b == b'"')?;
            let name = line[quote + 1..].trim_ascii_end().strip_suffix(b"\"")?;
            Some(MshGroup { dimension, number, name: String::from_utf8_lossy(name).into_owned() })
        };
        groups.push(parsed().ok_or_else(|| cursor.error(quoted(line), expected))?);
    }
    Ok(())
}

/// Collects nodes, then elements.
#[derive(Default)]
pub(super) struct Builder {
    nodes: Option<Nodes>,
    groups: Vec<MshGroup>,
    tets: MshCells<4>,
    triangles: MshCells<3>,
    edges: MshCells<2>,
    vertices: MshCells<1>,
    skipped: BTreeMap<i32, usize>,
}

struct Nodes {
    points: Vec<Vec3>,
    /// Tags in ascending order with their points; `None` if point i has the tag i + 1.
    by_tag: Option<Vec<(u64, u32)>>,
}

impl Builder {
    /// Takes the nodes, in the order of the file.
    pub(super) fn set_nodes(
        &mut self,
        cursor: &MshCursor<'_>,
        tags: &[u64],
        points: Vec<Vec3>,
    ) -> Result<(), MeshFileError> {
        if self.nodes.is_some() {
            return Err(cursor.error("a second section of nodes", "one"));
        }
        if u32::try_from(points.len()).is_err() {
            return Err(cursor.error(format!("{} nodes", points.len()), "at most 4294967295"));
        }
        let consecutive = tags.iter().zip(1..).all(|(&tag, expected)| tag == expected);
        let by_tag = if consecutive { None } else { Some(sorted_tags(cursor, tags)?) };
        self.nodes = Some(Nodes { points, by_tag });
        Ok(())
    }

    /// The index of the point with this tag.
    fn point(&self, cursor: &MshCursor<'_>, tag: u64) -> Result<u32, MeshFileError> {
        let Some(nodes) = &self.nodes else {
            return Err(cursor.error("elements", "the section of nodes before them"));
        };
        let index = match &nodes.by_tag {
            None => tag.checked_sub(1).filter(|&i| i < nodes.points.len() as u64).map(|i| i as u32),
            Some(tags) => tags.binary_search_by_key(&tag, |&(tag, _)| tag).ok().map(|k| tags[k].1),
        };
        index.ok_or_else(|| cursor.error(format!("the node {tag} in an element"), "the number of a node"))
    }

    /// Takes one element with the tags of its nodes.
    pub(super) fn add_element(
        &mut self,
        cursor: &MshCursor<'_>,
        element_type: i32,
        group: i32,
        tags: &[u64],
    ) -> Result<(), MeshFileError> {
        let mut corners = [0_u32; 4];
        if ![1, 2, 4, 15].contains(&element_type) {
            *self.skipped.entry(element_type).or_default() += 1;
            return Ok(());
        }
        for (k, &tag) in tags.iter().enumerate() {
            let point = self.point(cursor, tag)?;
            if corners[..k].contains(&point) {
                return Err(cursor.error(format!("the node {tag} twice in an element"), "different nodes"));
            }
            corners[k] = point;
        }
        let [a, b, c, d] = corners;
        match element_type {
            4 => self.tets.push([a, b, c, d], group),
            2 => self.triangles.push([a, b, c], group),
            1 => self.edges.push([a, b], group),
            _ => self.vertices.push([a], group),
        }
        Ok(())
    }

    fn finish(self, cursor: &MshCursor<'_>) -> Result<MshMesh, MeshFileError> {
        let Some(nodes) = self.nodes else {
            return Err(cursor.error("the end of the file", "a section \"$Nodes\""));
        };
        let skipped = self.skipped.into_iter();
        Ok(MshMesh {
            points: nodes.points,
            tets: self.tets,
            triangles: self.triangles,
            edges: self.edges,
            vertices: self.vertices,
            groups: self.groups,
            skipped: skipped.map(|(element_type, count)| MshSkipped { element_type, count }).collect(),
        })
    }
}

impl<const N: usize> MshCells<N> {
    fn push(&mut self, cell: [u32; N], group: i32) {
        self.vertices.push(cell);
        self.groups.push(group);
    }
}

fn sorted_tags(cursor: &MshCursor<'_>, tags: &[u64]) -> Result<Vec<(u64, u32)>, MeshFileError> {
    let mut sorted: Vec<(u64, u32)> = tags.iter().copied().zip(0..).collect();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => {
            Err(cursor.error(format!("two nodes with the number {}", pair[0].0), "different numbers"))
        }
        None => Ok(sorted),
    }
}

/// How many nodes an element of Gmsh's type has.
pub(super) fn node_count(cursor: &MshCursor<'_>, element_type: i32) -> Result<usize, MeshFileError> {
    const COUNTS: [usize; 31] = [
        2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4, 5, 6, 20,
        35, 56,
    ];
    let count = match element_type {
        92 => Some(64),
        93 => Some(125),
        _ => usize::try_from(element_type).ok().and_then(|t| COUNTS.get(t.wrapping_sub(1)).copied()),
    };
    count.ok_or_else(|| {
        cursor.unsupported(format!("the element type {element_type}"), "known are 1 to 31, 92 and 93")
    })
}
