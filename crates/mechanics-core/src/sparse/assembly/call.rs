//! What the assembly remembers of one element list.

use super::entries::{Entries, Entry, TRANSPOSED};
use super::pattern::SlotIndex;
use crate::parallel;
use crate::point_map::PointMap;
use crate::sparse::scatter::GROUP;

/// Columns sorted by one task.
const SORT_TASK: usize = 256;

/// One element list, and where its blocks go.
#[derive(Debug)]
pub(super) struct Call {
    corners: usize,
    points: Vec<u32>,
    entries: Entries,
    /// Whether the list was used in the assembly under way.
    current: bool,
}

impl Call {
    /// Looks up the slots of a list of elements with `corners` points each; missing slots are added to `index`.
    pub(super) fn new(corners: usize, points: &[u32], map: &PointMap, index: &mut SlotIndex) -> Self {
        let count = map.points();
        if let Some(point) = points.iter().find(|&&point| point as usize >= count) {
            panic!("an element names point {point} of {count}");
        }
        let mut blocks = ElementBlocks::new(corners, points, map);
        let slots = index.slots_of(blocks.distinct());
        blocks.assign(slots);
        let entries = blocks.into_entries(corners, points.len() / corners.max(1));
        Self { corners, points: points.to_vec(), entries, current: true }
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

    pub(super) fn entries(&self) -> &Entries {
        &self.entries
    }

    pub(super) fn slots(&self) -> impl Iterator<Item = usize> {
        self.entries.slots()
    }

    pub(super) fn renumber(&mut self, new_slot: &[u32]) {
        self.entries.renumber(new_slot);
    }
}

/// A contribution to a block.
#[derive(Clone, Copy, Debug, Default)]
struct ElementBlock {
    /// The row of the block; its slot, once that is known.
    place: u32,
    element: u32,
    /// The number of the block within its element; [`TRANSPOSED`] or not.
    local: u32,
    /// How many contributions the elements list before it.
    number: u32,
}

/// All contributions of the lower triangles of the elements' Hessians, sorted by column and row, in element order for
/// each block.
struct ElementBlocks {
    blocks: Vec<ElementBlock>,
    /// Columns, and where their contributions end.
    columns: Vec<(u32, usize)>,
    /// One for each contribution as listed by the elements, or none if all are one.
    weights: Vec<f64>,
}

impl ElementBlocks {
    /// Sorts by counting over columns, then each column by rows; a short list by comparing.
    fn new(corners: usize, points: &[u32], map: &PointMap) -> Self {
        let mut weights = Vec::new();
        if !map.is_selection() {
            for_each_block(corners, points, map, |_, _, weight| weights.push(weight));
        }
        let at_least = points.len() / corners.max(1) * (corners * (corners + 1) / 2);
        let (blocks, columns) = if at_least < map.unknowns() {
            by_comparing(corners, points, map)
        } else {
            by_counting(corners, points, map)
        };
        assert!(u32::try_from(blocks.len()).is_ok(), "an element list has fewer than 2³² contributions");
        Self { blocks, columns, weights }
    }

    /// The blocks as (column, row), each once, ascending.
    fn distinct(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let starts = std::iter::once(0).chain(self.columns.iter().map(|column| column.1));
        starts.zip(&self.columns).flat_map(|(start, &(column, end))| {
            let rows = self.blocks[start..end].chunk_by(|a, b| a.place == b.place);
            rows.map(move |same| (column, same[0].place))
        })
    }

    /// Puts the slots of the distinct blocks in the places of their rows.
    fn assign(&mut self, slots: Vec<u32>) {
        let mut slots = slots.into_iter();
        let mut start = 0;
        for &(_, end) in &self.columns {
            let rows = self.blocks[start..end].chunk_by_mut(|a, b| a.place == b.place);
            for (same, slot) in rows.zip(&mut slots) {
                same.iter_mut().for_each(|block| block.place = slot);
            }
            start = end;
        }
    }

    /// The contributions in element order, once their places are slots.
    fn into_entries(self, corners: usize, elements: usize) -> Entries {
        let per_element = corners * corners;
        assert!(GROUP * per_element < TRANSPOSED as usize, "a group has fewer than 2³¹ blocks");
        let mut start = vec![0; elements.div_ceil(GROUP) + 1];
        let mut entries = vec![Entry::default(); self.blocks.len()];
        for &ElementBlock { place, element, local, number } in &self.blocks {
            start[element as usize / GROUP + 1] += 1;
            let source = (element as usize % GROUP * per_element) as u32 + local;
            entries[number as usize] = Entry { slot: place, source };
        }
        (1..start.len()).for_each(|group| start[group] += start[group - 1]);
        Entries::new(elements, start, entries, self.weights)
    }
}

fn by_comparing(corners: usize, points: &[u32], map: &PointMap) -> (Vec<ElementBlock>, Vec<(u32, usize)>) {
    let mut blocks = Vec::new();
    for_each_block(corners, points, map, |column, block, _| blocks.push((column, block)));
    blocks.sort_by_key(|(column, block)| (*column, block.place));
    let mut columns = Vec::new();
    let mut end = 0;
    for same in blocks.chunk_by(|a, b| a.0 == b.0) {
        end += same.len();
        columns.push((same[0].0, end));
    }
    (blocks.into_iter().map(|(_, block)| block).collect(), columns)
}

fn by_counting(corners: usize, points: &[u32], map: &PointMap) -> (Vec<ElementBlock>, Vec<(u32, usize)>) {
    let mut cursor = vec![0; map.unknowns() + 1];
    for_each_block(corners, points, map, |column, _, _| cursor[column as usize + 1] += 1);
    (0..map.unknowns()).for_each(|column| cursor[column + 1] += cursor[column]);
    let mut blocks = vec![ElementBlock::default(); cursor[map.unknowns()]];
    for_each_block(corners, points, map, |column, block, _| {
        blocks[cursor[column as usize]] = block;
        cursor[column as usize] += 1;
    });
    // Every cursor now stands at the end of its column.
    let columns: Vec<(u32, usize)> = (0..).zip(cursor.into_iter().take(map.unknowns())).collect();
    let mut rest = blocks.as_mut_slice();
    let mut parts = Vec::with_capacity(columns.len());
    let mut start = 0;
    for &(_, end) in &columns {
        let (part, behind) = rest.split_at_mut(end - start);
        parts.push(part);
        (rest, start) = (behind, end);
    }
    parallel::for_each_chunk(&mut parts, SORT_TASK, |_, parts| {
        parts.iter_mut().for_each(|part| part.sort_by_key(|block| block.place));
    });
    (blocks, columns)
}

/// Calls `visit(column, block, weight)` for all contributions, `row ≥ column`, in element order.
///
/// Local block (i, j), i > j, stands for `H_ij` at (i, j) and for its transpose at (j, i). With point i made of
/// unknowns a (weights wₐ) and point j of unknowns b, the first lands on (a, b), the second on (b, a): one of them
/// is in the lower triangle, or both are if a = b. A diagonal block (i, i) lands on all (a, a') of its own unknowns.
#[inline(always)]
fn for_each_block(
    corners: usize,
    points: &[u32],
    map: &PointMap,
    mut visit: impl FnMut(u32, ElementBlock, f64),
) {
    let mut number = 0;
    for (element, points) in points.chunks_exact(corners.max(1)).enumerate() {
        for (i, j) in (0..corners).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let mut emit = |row: u32, column: u32, weight: f64, mark: u32| {
                let local = (i * corners + j) as u32 | mark;
                let block = ElementBlock { place: row, element: element as u32, local, number };
                number = number.wrapping_add(1);
                visit(column, block, weight);
            };
            map.for_each_unknown(points[i] as usize, |a, weight_a| {
                map.for_each_unknown(points[j] as usize, |b, weight_b| {
                    let weight = weight_a * weight_b;
                    if a >= b {
                        emit(a, b, weight, 0);
                    }
                    if i != j && a <= b {
                        emit(b, a, weight, TRANSPOSED);
                    }
                });
            });
        }
    }
}
