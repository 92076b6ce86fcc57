//! Nodes and elements of MSH 2.2.

use super::cursor::{Encoding, MshCursor};
use super::reader::{Builder, node_count};
use crate::mesh::io::error::MeshFileError;
use crate::tensor::Vec3;

/// A count, then for every node its number and three coordinates.
pub(super) fn nodes(cursor: &mut MshCursor<'_>, builder: &mut Builder) -> Result<(), MeshFileError> {
    let (mut tags, mut points) = (Vec::new(), Vec::new());
    for _ in 0..cursor.text_count("the number of nodes")? {
        tags.push(cursor.int_tag("the number of a node")?);
        let mut coordinate = || cursor.real("a coordinate");
        points.push(Vec3::new(coordinate()?, coordinate()?, coordinate()?));
    }
    builder.set_nodes(cursor, &tags, points)
}

/// A count, then the elements: in text one by one, in binary in blocks of equal type and number of tags.
pub(super) fn elements(cursor: &mut MshCursor<'_>, builder: &mut Builder) -> Result<(), MeshFileError> {
    let count = cursor.text_count("the number of elements")?;
    let mut read = 0;
    while read < count {
        if cursor.encoding == Encoding::Text {
            cursor.int_tag("the number of an element")?;
            let element_type = cursor.int("the type of an element")?;
            let tag_count = length(cursor, "the number of tags")?;
            element(cursor, builder, element_type, tag_count)?;
            read += 1;
        } else {
            read += block(cursor, builder)?;
        }
    }
    if read > count {
        return Err(
            cursor.error(format!("{read} elements"), "as many elements as the section's first line says")
        );
    }
    Ok(())
}

fn block(cursor: &mut MshCursor<'_>, builder: &mut Builder) -> Result<u64, MeshFileError> {
    let element_type = cursor.int("the type of elements")?;
    let elements = length(cursor, "the number of elements in a block")?;
    let tag_count = length(cursor, "the number of tags")?;
    for _ in 0..elements {
        cursor.int("the number of an element")?;
        element(cursor, builder, element_type, tag_count)?;
    }
    Ok(elements)
}

/// Tags, the first of which is the physical group, then nodes.
fn element(
    cursor: &mut MshCursor<'_>,
    builder: &mut Builder,
    element_type: i32,
    tag_count: u64,
) -> Result<(), MeshFileError> {
    let mut group = 0;
    for k in 0..tag_count {
        let tag = cursor.int("a tag of an element")?;
        group = if k == 0 { tag } else { group };
    }
    let mut nodes = [0_u64; 125];
    let nodes = &mut nodes[..node_count(cursor, element_type)?];
    for node in nodes.iter_mut() {
        *node = cursor.int_tag("the number of a node")?;
    }
    builder.add_element(cursor, element_type, group, nodes)
}

fn length(cursor: &mut MshCursor<'_>, expected: &'static str) -> Result<u64, MeshFileError> {
    let length = cursor.int(expected)?;
    u64::try_from(length).map_err(|_| cursor.error(length.to_string(), expected))
}
