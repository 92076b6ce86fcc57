//! What the assembly remembers of one element list.

use super::pattern::SlotIndex;
use crate::point_map::PointMap;
use crate::sparse::scatter::MARK;
use crate::sparse::{Contribution, ScatterMap};

/// One element list, and where its blocks go.
#[derive(Debug)]
pub(super) struct Call {
    corners: usize,
    points: Vec<u32>,
    scatter: ScatterMap,
    /// Whether the list was used in the assembly under way.
    current: bool,
}

impl Call {
    /// Looks up the slots of a list of elements with `corners` points each; missing slots are added to `index`.
    pub(super) fn new(
        corners: usize,
        points: &[u32],
        batch: usize,
        map: &PointMap,
        index: &mut SlotIndex,
    ) -> Self {
        let count = map.points();
        if let Some(point) = points.iter().find(|&&point| point as usize >= count) {
            panic!("an element names point {point} of {count}");
        }
        let blocks = sorted_by_block(element_blocks(corners, points, map), map.unknowns());
        let distinct = blocks.chunk_by(|a, b| a.block() == b.block()).map(|same| same[0].block());
        let slots = index.slots_of(distinct);
        let same_block = blocks.chunk_by(|a, b| a.block() == b.block());
        let contributions: Vec<Contribution> = same_block
            .zip(slots)
            .flat_map(|(same, slot)| {
                same.iter().map(move |block| Contribution { slot, ..block.contribution })
            })
            .collect();
        let elements = points.len() / corners.max(1);
        let scatter = ScatterMap::new(elements, corners * corners, batch, &contributions);
        Self { corners, points: points.to_vec(), scatter, current: true }
    }

    pub(super) fn is_for(&self, corners: usize, points: &[u32]) -> bool {
        self.corners == corners && self.points == points
    }

    pub(super) fn is_current(&self) -> bool {
        self.current
    }

    pub(super) fn renew(&mut self) {
        self.current = true;
    }

    pub(super) fn retire(&mut self) {
        self.current = false;
    }

    pub(super) fn scatter_map(&self) -> &ScatterMap {
        &self.scatter
    }

    pub(super) fn slots(&self) -> impl Iterator<Item = usize> {
        self.scatter.slots()
    }

    pub(super) fn renumber(&mut self, new_slot: &[u32]) {
        self.scatter.renumber(new_slot);
    }
}

/// A contribution to the block of a row and a column, `row ≥ column`; its slot is not known yet.
#[derive(Clone, Copy, Debug)]
struct ElementBlock {
    column: u32,
    row: u32,
    contribution: Contribution,
}

impl ElementBlock {
    fn block(&self) -> (u32, u32) {
        (self.column, self.row)
    }
}

/// All contributions of the lower triangles of the elements' Hessians, in element order.
///
/// Local block (i, j), i > j, stands for `H_ij` at (i, j) and for its transpose at (j, i). With point i made of
/// unknowns a (weights wₐ) and point j of unknowns b, the first lands on (a, b), the second on (b, a): one of them
/// is in the lower triangle, or both are if a = b. A diagonal block (i, i) lands on all (a, a') of its own unknowns.
fn element_blocks(corners: usize, points: &[u32], map: &PointMap) -> Vec<ElementBlock> {
    let per_element = corners * (corners + 1) / 2;
    let mut blocks = Vec::with_capacity(points.len() / corners.max(1) * per_element);
    for (element, points) in points.chunks_exact(corners.max(1)).enumerate() {
        for (i, j) in (0..corners).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let mut push = |row: u32, column: u32, weight: f64, mark: u32| {
                let local = (i * corners + j) as u32 | mark;
                let contribution = Contribution { slot: 0, element: element as u32, local, weight };
                blocks.push(ElementBlock { column, row, contribution });
            };
            map.for_each_unknown(points[i] as usize, |a, weight_a| {
                map.for_each_unknown(points[j] as usize, |b, weight_b| {
                    let weight = weight_a * weight_b;
                    if a >= b {
                        push(a, b, weight, 0);
                    }
                    if i != j && a <= b {
                        push(b, a, weight, MARK);
                    }
                });
            });
        }
    }
    blocks
}

/// Sorts by (column, row) and keeps the order within: counting over columns, then each column by rows.
fn sorted_by_block(blocks: Vec<ElementBlock>, columns: usize) -> Vec<ElementBlock> {
    if blocks.len() < columns {
        let mut blocks = blocks;
        blocks.sort_by_key(ElementBlock::block);
        return blocks;
    }
    let mut start = vec![0; columns + 1];
    blocks.iter().for_each(|block| start[block.column as usize + 1] += 1);
    (0..columns).for_each(|column| start[column + 1] += start[column]);
    let mut cursor = start.clone();
    let mut sorted = blocks.clone();
    for block in blocks {
        let at = &mut cursor[block.column as usize];
        sorted[*at] = block;
        *at += 1;
    }
    for column in start.windows(2) {
        sorted[column[0]..column[1]].sort_by_key(|block| block.row);
    }
    sorted
}
