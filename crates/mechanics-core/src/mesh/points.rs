//! What every mesh does with its list of points.

use super::error::{CellKind, MeshError};
use crate::tensor::Vec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// The smallest coordinates \[m\].
    pub min: Vec3,
    /// The largest coordinates \[m\].
    pub max: Vec3,
}

impl BoundingBox {
    /// The smallest box around the points; `None` if there are none.
    pub fn of(points: &[Vec3]) -> Option<Self> {
        let first = *points.first()?;
        Some(
            points
                .iter()
                .fold(Self { min: first, max: first }, |b, p| Self { min: b.min.inf(p), max: b.max.sup(p) }),
        )
    }

    /// The midpoint \[m\].
    pub fn centre(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The lengths of the sides \[m\].
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }
}

/// Checks that all positions are finite and that 32 bits can number them.
pub(super) fn check_points(points: &[Vec3]) -> Result<(), MeshError> {
    check_count(points.len())?;
    match points.iter().position(|p| !is_finite(p)) {
        None => Ok(()),
        Some(point) => Err(MeshError::NonFinitePosition { point, position: points[point].into() }),
    }
}

pub(super) fn check_count(count: usize) -> Result<(), MeshError> {
    match u32::try_from(count) {
        Ok(_) => Ok(()),
        Err(_) => Err(MeshError::TooLarge { count: count as u64 }),
    }
}

fn is_finite(p: &Vec3) -> bool {
    p.iter().all(|x| x.is_finite())
}

/// Checks that every cell refers to existing points and to none of them twice.
pub(super) fn check_cells<const N: usize>(
    kind: CellKind,
    cells: &[[u32; N]],
    points: usize,
) -> Result<(), MeshError> {
    check_count(cells.len())?;
    for (cell, vertices) in cells.iter().enumerate() {
        for (k, &index) in vertices.iter().enumerate() {
            if index as usize >= points {
                return Err(MeshError::IndexOutOfRange { kind, cell, index, points });
            }
            if vertices[..k].contains(&index) {
                return Err(MeshError::RepeatedVertex { kind, cell, vertex: index });
            }
        }
    }
    Ok(())
}

/// Replaces every point by `map(point)`; leaves them all as they were if one of the images is not finite.
pub(super) fn map_points(points: &mut Vec<Vec3>, map: impl Fn(&Vec3) -> Vec3) -> Result<(), MeshError> {
    let moved: Vec<Vec3> = points.iter().map(map).collect();
    check_points(&moved)?;
    *points = moved;
    Ok(())
}

pub(super) fn check_positive(parameter: &'static str, value: f64) -> Result<(), MeshError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(MeshError::BadParameter { parameter, value, expected: "a positive, finite number" })
}

/// Which of `count` points no cell uses, ascending.
pub(super) fn unreferenced(count: usize, used: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut unused = vec![true; count];
    used.for_each(|i| unused[i as usize] = false);
    (0..count as u32).filter(|&i| unused[i as usize]).collect()
}

/// For points kept in ascending order: old index → new index, and the list of kept old indices.
pub(super) fn renumbering(count: usize, used: impl Iterator<Item = u32>) -> (Vec<u32>, Vec<u32>) {
    let mut new_index = vec![u32::MAX; count];
    used.for_each(|i| new_index[i as usize] = 0);
    let kept: Vec<u32> = (0..count as u32).filter(|&i| new_index[i as usize] == 0).collect();
    kept.iter().enumerate().for_each(|(new, &old)| new_index[old as usize] = new as u32);
    (new_index, kept)
}
