//! Entities, nodes and elements of MSH 4.1.

use super::cursor::MshCursor;
use super::reader::{Builder, node_count};
use crate::mesh::io::error::MeshFileError;
use crate::tensor::Vec3;
use std::collections::BTreeMap;

/// The first physical group of entities that have one, by dimension and tag.
#[derive(Default)]
pub(super) struct Entities {
    group: BTreeMap<(i32, i32), i32>,
}

/// Four counts, then points (tag, position, groups) and curves, surfaces, volumes (tag, box, groups, boundary).
pub(super) fn entities(cursor: &mut MshCursor<'_>) -> Result<Entities, MeshFileError> {
    let mut counts = [0_u64; 4];
    for count in &mut counts {
        *count = cursor.size("the number of entities")?;
    }
    let mut entities = Entities::default();
    for (dimension, count) in (0..).zip(counts) {
        for _ in 0..count {
            let tag = cursor.int("the tag of an entity")?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                cursor.real("a coordinate of an entity")?;
            }
            for k in 0..cursor.size("the number of physical groups")? {
                // The sign tells the orientation of the entity in the group.
                let group = cursor.int("a physical group")?.saturating_abs();
                if k == 0 {
                    entities.group.insert((dimension, tag), group);
                }
            }
            if dimension > 0 {
                for _ in 0..cursor.size("the number of bounding entities")? {
                    cursor.int("the tag of a bounding entity")?;
                }
            }
        }
    }
    Ok(entities)
}

/// Blocks of nodes: numbers first, then coordinates (and parameters on the entity, which are passed over).
pub(super) fn nodes(cursor: &mut MshCursor<'_>, builder: &mut Builder) -> Result<(), MeshFileError> {
    let [blocks, count] = section_header(cursor)?;
    let (mut tags, mut points) = (Vec::new(), Vec::new());
    for _ in 0..blocks {
        let dimension = cursor.int("the dimension of an entity")?;
        cursor.int("the tag of an entity")?;
        let parameters = match cursor.int("0, or 1 for parametric nodes")? {
            0 => 0,
            1 if (0..=3).contains(&dimension) => dimension,
            other => return Err(cursor.error(other.to_string(), "0, or 1 on an entity of dimension 0 to 3")),
        };
        let in_block = cursor.size("the number of nodes in a block")?;
        for _ in 0..in_block {
            tags.push(cursor.size("the number of a node")?);
        }
        for _ in 0..in_block {
            let mut coordinate = || cursor.real("a coordinate");
            points.push(Vec3::new(coordinate()?, coordinate()?, coordinate()?));
            (0..parameters).try_for_each(|_| coordinate().map(|_| ()))?;
        }
    }
    check_total(cursor, points.len() as u64, count)?;
    builder.set_nodes(cursor, &tags, points)
}

/// Blocks of elements of one type on one entity.
pub(super) fn elements(
    cursor: &mut MshCursor<'_>,
    builder: &mut Builder,
    entities: &Entities,
) -> Result<(), MeshFileError> {
    let [blocks, count] = section_header(cursor)?;
    let mut total = 0_u64;
    for _ in 0..blocks {
        let dimension = cursor.int("the dimension of an entity")?;
        let tag = cursor.int("the tag of an entity")?;
        let element_type = cursor.int("the type of elements")?;
        let group = entities.group.get(&(dimension, tag)).copied().unwrap_or(0);
        let in_block = cursor.size("the number of elements in a block")?;
        let mut nodes = [0_u64; 125];
        let nodes = &mut nodes[..node_count(cursor, element_type)?];
        for _ in 0..in_block {
            cursor.size("the number of an element")?;
            for node in nodes.iter_mut() {
                *node = cursor.size("the number of a node")?;
            }
            builder.add_element(cursor, element_type, group, nodes)?;
            total += 1;
        }
    }
    check_total(cursor, total, count)
}

/// The numbers of blocks and of items; the smallest and largest tag are of no use here.
fn section_header(cursor: &mut MshCursor<'_>) -> Result<[u64; 2], MeshFileError> {
    let header = [cursor.size("the number of blocks")?, cursor.size("the number of items")?];
    cursor.size("the smallest tag")?;
    cursor.size("the largest tag")?;
    Ok(header)
}

fn check_total(cursor: &MshCursor<'_>, found: u64, expected: u64) -> Result<(), MeshFileError> {
    if found == expected {
        return Ok(());
    }
    let found = format!("{found} items in the blocks where the section's first line says {expected}");
    Err(cursor.error(found, "equal numbers"))
}
