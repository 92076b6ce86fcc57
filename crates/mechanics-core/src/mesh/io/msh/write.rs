//! Writing MSH: one function per section, over a sink that writes a number as text or binary.

use super::{MshCells, MshMesh};
use crate::mesh::BoundingBox;
use crate::mesh::io::error::{MeshFileError, MeshFormat};
use crate::tensor::Vec3;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Which version of the format to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MshVersion {
    /// 2.2, which most programs read.
    V2_2,
    /// 4.1, the present one.
    V4_1,
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MshEncoding {
    /// Text, with all digits.
    Ascii,
    /// Binary, least significant byte first.
    Binary,
}

/// Writes numbers, separated by blanks in text.
struct Numbers<'a, W> {
    sink: &'a mut W,
    encoding: MshEncoding,
}

impl<W: Write> Numbers<'_, W> {
    fn int(&mut self, value: i32) -> io::Result<()> {
        match self.encoding {
            MshEncoding::Ascii => write!(self.sink, "{value} "),
            MshEncoding::Binary => self.sink.write_all(&value.to_le_bytes()),
        }
    }

    fn size(&mut self, value: usize) -> io::Result<()> {
        match self.encoding {
            MshEncoding::Ascii => write!(self.sink, "{value} "),
            MshEncoding::Binary => self.sink.write_all(&(value as u64).to_le_bytes()),
        }
    }

    fn point(&mut self, point: &Vec3) -> io::Result<()> {
        point.iter().try_for_each(|x| match self.encoding {
            MshEncoding::Ascii => write!(self.sink, "{x:?} "),
            MshEncoding::Binary => self.sink.write_all(&x.to_le_bytes()),
        })
    }

    /// Ends a line of text.
    fn end(&mut self) -> io::Result<()> {
        match self.encoding {
            MshEncoding::Ascii => writeln!(self.sink),
            MshEncoding::Binary => Ok(()),
        }
    }
}

/// Cells of one kind and one group.
struct Block<'a> {
    dimension: i32,
    element_type: i32,
    group: i32,
    cells: Vec<&'a [u32]>,
}

pub(super) fn write(
    mesh: &MshMesh,
    version: MshVersion,
    encoding: MshEncoding,
    sink: &mut impl Write,
) -> Result<(), MeshFileError> {
    let blocks: Vec<Block<'_>> = blocks_of(&mesh.vertices, 0, 15)
        .chain(blocks_of(&mesh.edges, 1, 1))
        .chain(blocks_of(&mesh.triangles, 2, 2))
        .chain(blocks_of(&mesh.tets, 3, 4))
        .collect();
    check(mesh, &blocks, version)?;
    write_format(version, encoding, sink)?;
    write_names(mesh, sink)?;
    let mut numbers = Numbers { sink, encoding };
    match version {
        MshVersion::V2_2 => {
            write_nodes_22(&mesh.points, &mut numbers)?;
            write_elements_22(&blocks, &mut numbers)?;
        }
        MshVersion::V4_1 => {
            if blocks.iter().any(|block| block.group != 0) {
                write_entities(mesh, &blocks, &mut numbers)?;
            }
            write_nodes_41(mesh, &blocks, &mut numbers)?;
            write_elements_41(&blocks, &mut numbers)?;
        }
    }
    Ok(())
}

fn blocks_of<const N: usize>(
    cells: &MshCells<N>,
    dimension: i32,
    element_type: i32,
) -> impl Iterator<Item = Block<'_>> {
    assert_eq!(cells.vertices.len(), cells.groups.len(), "one group for every cell");
    let mut by_group: BTreeMap<i32, Vec<&[u32]>> = BTreeMap::new();
    for (cell, &group) in cells.vertices.iter().zip(&cells.groups) {
        by_group.entry(group).or_default().push(cell);
    }
    by_group.into_iter().map(move |(group, cells)| Block { dimension, element_type, group, cells })
}

fn check(mesh: &MshMesh, blocks: &[Block<'_>], version: MshVersion) -> Result<(), MeshFileError> {
    let refuse = |what: String| Err(MeshFileError::not_representable(MeshFormat::Msh, what));
    let largest = mesh.points.len().max(blocks.iter().map(|block| block.cells.len()).sum());
    if version == MshVersion::V2_2 && largest >= i32::MAX as usize {
        return refuse(format!("{largest} points or cells in version 2.2"));
    }
    if let Some(block) = blocks.iter().find(|block| block.group < 0 || block.group == i32::MAX) {
        return refuse(format!("the physical group {}; groups are positive", block.group));
    }
    match mesh.groups.iter().find(|group| group.name.contains(['"', '\n', '\r'])) {
        Some(group) => refuse(format!("the group name {:?}", group.name)),
        None => Ok(()),
    }
}

fn write_format(version: MshVersion, encoding: MshEncoding, sink: &mut impl Write) -> io::Result<()> {
    let version = match version {
        MshVersion::V2_2 => "2.2",
        MshVersion::V4_1 => "4.1",
    };
    match encoding {
        MshEncoding::Ascii => writeln!(sink, "$MeshFormat\n{version} 0 8\n$EndMeshFormat"),
        MshEncoding::Binary => {
            writeln!(sink, "$MeshFormat\n{version} 1 8")?;
            sink.write_all(&1_i32.to_le_bytes())?;
            writeln!(sink, "\n$EndMeshFormat")
        }
    }
}

fn write_names(mesh: &MshMesh, sink: &mut impl Write) -> io::Result<()> {
    if mesh.groups.is_empty() {
        return Ok(());
    }
    writeln!(sink, "$PhysicalNames\n{}", mesh.groups.len())?;
    for group in &mesh.groups {
        writeln!(sink, "{} {} \"{}\"", group.dimension, group.number, group.name)?;
    }
    writeln!(sink, "$EndPhysicalNames")
}

fn write_nodes_22<W: Write>(points: &[Vec3], numbers: &mut Numbers<'_, W>) -> io::Result<()> {
    writeln!(numbers.sink, "$Nodes\n{}", points.len())?;
    for (tag, point) in (1..).zip(points) {
        numbers.int(tag)?;
        numbers.point(point)?;
        numbers.end()?;
    }
    end_section(numbers, "$EndNodes")
}

fn write_elements_22<W: Write>(blocks: &[Block<'_>], numbers: &mut Numbers<'_, W>) -> io::Result<()> {
    let total: usize = blocks.iter().map(|block| block.cells.len()).sum();
    writeln!(numbers.sink, "$Elements\n{total}")?;
    let mut tag = 0;
    for block in blocks {
        if numbers.encoding == MshEncoding::Binary {
            [block.element_type, block.cells.len() as i32, 2].into_iter().try_for_each(|n| numbers.int(n))?;
        }
        let entity = entity_tag(block.group, blocks);
        for cell in &block.cells {
            tag += 1;
            numbers.int(tag)?;
            if numbers.encoding == MshEncoding::Ascii {
                numbers.int(block.element_type)?;
                numbers.int(2)?;
            }
            numbers.int(block.group)?;
            numbers.int(entity)?;
            cell.iter().try_for_each(|&i| numbers.int(i as i32 + 1))?;
            numbers.end()?;
        }
    }
    end_section(numbers, "$EndElements")
}

/// Entities are numbered as the groups they stand for; cells without a group are on an entity of their own.
fn entity_tag(group: i32, blocks: &[Block<'_>]) -> i32 {
    if group > 0 { group } else { 1 + blocks.iter().map(|block| block.group).max().unwrap_or(0) }
}

fn write_entities<W: Write>(
    mesh: &MshMesh,
    blocks: &[Block<'_>],
    numbers: &mut Numbers<'_, W>,
) -> io::Result<()> {
    let origin = BoundingBox { min: Vec3::zeros(), max: Vec3::zeros() };
    let bounds = BoundingBox::of(&mesh.points).unwrap_or(origin);
    writeln!(numbers.sink, "$Entities")?;
    for dimension in 0..=3 {
        numbers.size(blocks.iter().filter(|block| block.dimension == dimension).count())?;
    }
    numbers.end()?;
    for block in blocks {
        numbers.int(entity_tag(block.group, blocks))?;
        numbers.point(&bounds.min)?;
        if block.dimension > 0 {
            numbers.point(&bounds.max)?;
        }
        numbers.size(usize::from(block.group > 0))?;
        if block.group > 0 {
            numbers.int(block.group)?;
        }
        if block.dimension > 0 {
            numbers.size(0)?;
        }
        numbers.end()?;
    }
    end_section(numbers, "$EndEntities")
}

fn write_nodes_41<W: Write>(
    mesh: &MshMesh,
    blocks: &[Block<'_>],
    numbers: &mut Numbers<'_, W>,
) -> io::Result<()> {
    let count = mesh.points.len();
    writeln!(numbers.sink, "$Nodes")?;
    [1, count, count.min(1), count].into_iter().try_for_each(|n| numbers.size(n))?;
    numbers.end()?;
    // All nodes are said to lie on the last, highest-dimensional entity.
    let (dimension, group) = blocks.last().map_or((3, 0), |block| (block.dimension, block.group));
    [dimension, entity_tag(group, blocks), 0].into_iter().try_for_each(|n| numbers.int(n))?;
    numbers.size(count)?;
    numbers.end()?;
    for tag in 1..=count {
        numbers.size(tag)?;
        numbers.end()?;
    }
    for point in &mesh.points {
        numbers.point(point)?;
        numbers.end()?;
    }
    end_section(numbers, "$EndNodes")
}

fn write_elements_41<W: Write>(blocks: &[Block<'_>], numbers: &mut Numbers<'_, W>) -> io::Result<()> {
    let total: usize = blocks.iter().map(|block| block.cells.len()).sum();
    writeln!(numbers.sink, "$Elements")?;
    [blocks.len(), total, total.min(1), total].into_iter().try_for_each(|n| numbers.size(n))?;
    numbers.end()?;
    let mut tag = 0;
    for block in blocks {
        let entity = entity_tag(block.group, blocks);
        [block.dimension, entity, block.element_type].into_iter().try_for_each(|n| numbers.int(n))?;
        numbers.size(block.cells.len())?;
        numbers.end()?;
        for cell in &block.cells {
            tag += 1;
            numbers.size(tag)?;
            cell.iter().try_for_each(|&i| numbers.size(i as usize + 1))?;
            numbers.end()?;
        }
    }
    end_section(numbers, "$EndElements")
}

fn end_section<W: Write>(numbers: &mut Numbers<'_, W>, name: &str) -> io::Result<()> {
    // Gmsh's own files have a line end between binary data and the end of the section.
    if numbers.encoding == MshEncoding::Binary {
        writeln!(numbers.sink)?;
    }
    writeln!(numbers.sink, "{name}")
}
