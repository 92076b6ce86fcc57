//! Where the blocks of element Hessians go, element by element.

use crate::parallel;
use crate::sparse::scatter::{Contributions, GROUP, Scatter, Slots};
use crate::stencil::LocalHessian;
use crate::tensor::Mat3;
use std::ops::Range;

/// The top bit of a source: the transpose of the block is added.
pub(super) const TRANSPOSED: u32 = 1 << 31;

/// Entries renumbered by one task.
const RENUMBERING: usize = 1 << 16;

/// One contribution to the matrix.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entry {
    /// The slot it goes to.
    pub(super) slot: u32,
    /// The number of the block among those of its group of elements; [`TRANSPOSED`] or not.
    pub(super) source: u32,
}

/// The contributions of an element list in the order of the elements.
#[derive(Debug)]
pub(super) struct Entries {
    /// Where those of each group of elements begin.
    start: Vec<usize>,
    elements: usize,
    entries: Vec<Entry>,
    /// One per entry, or none if all are one.
    weights: Vec<f64>,
    scatter: Scatter,
}

impl Entries {
    /// Those of `elements` elements; the entries of group g are number `start[g]..start[g + 1]`.
    pub(super) fn new(elements: usize, start: Vec<usize>, entries: Vec<Entry>, weights: Vec<f64>) -> Self {
        Self { start, elements, entries, weights, scatter: Scatter::default() }
    }

    /// The slot of every contribution, as often as it is named.
    pub(super) fn slots(&self) -> impl Iterator<Item = usize> {
        self.entries.iter().map(|entry| entry.slot as usize)
    }

    /// Gives every slot a new number.
    pub(super) fn renumber(&mut self, new_slot: &[u32]) {
        parallel::for_each_chunk(&mut self.entries, RENUMBERING, |_, entries| {
            entries.iter_mut().for_each(|entry| entry.slot = new_slot[entry.slot as usize]);
        });
        self.scatter.forget();
    }

    /// Adds the Hessians that `kernel(first, hessians)` computes to their slots.
    pub(super) fn add<const N: usize>(
        &self,
        kernel: impl Fn(usize, &mut [LocalHessian<N>]) + Sync,
        values: &mut [Mat3],
    ) {
        self.scatter.accumulate(&[&Hessians::<_, N> { kernel, entries: self }], values);
    }

    fn add_group<S: Slots<Mat3>>(&self, group: usize, blocks: &[Mat3], slots: &mut S) {
        let range = self.start[group]..self.start[group + 1];
        let entries = &self.entries[range.clone()];
        if self.weights.is_empty() {
            for entry in entries {
                add_block(entry, blocks, slots, |block| *block);
            }
        } else {
            for (entry, &weight) in entries.iter().zip(&self.weights[range]) {
                add_block(entry, blocks, slots, |block| block * weight);
            }
        }
    }
}

#[inline(always)]
fn add_block<S: Slots<Mat3>>(
    entry: &Entry,
    blocks: &[Mat3],
    slots: &mut S,
    weighted: impl Fn(&Mat3) -> Mat3,
) {
    let Some(target) = slots.slot(entry.slot) else { return };
    let block = &blocks[(entry.source & !TRANSPOSED) as usize];
    if entry.source & TRANSPOSED == 0 {
        *target += weighted(block);
    } else {
        *target += weighted(&block.transpose());
    }
}

struct Hessians<'a, K, const N: usize> {
    kernel: K,
    entries: &'a Entries,
}

impl<K: Fn(usize, &mut [LocalHessian<N>]) + Sync, const N: usize> Contributions for Hessians<'_, K, N> {
    type Result = LocalHessian<N>;
    type Slot = Mat3;
    const BLANK: LocalHessian<N> = [[Mat3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0); N]; N];

    fn elements(&self) -> usize {
        self.entries.elements
    }

    fn compute(&self, first: usize, hessians: &mut [LocalHessian<N>]) {
        (self.kernel)(first, hessians);
    }

    fn add<S: Slots<Mat3>>(&self, first: usize, hessians: &[LocalHessian<N>], slots: &mut S) {
        for (k, hessians) in hessians.chunks(GROUP).enumerate() {
            self.entries.add_group(first / GROUP + k, hessians.as_flattened().as_flattened(), slots);
        }
    }

    fn for_each_slot(&self, group: Range<usize>, visit: impl FnMut(u32)) {
        let group = group.start / GROUP;
        let entries = &self.entries.entries[self.entries.start[group]..self.entries.start[group + 1]];
        entries.iter().map(|entry| entry.slot).for_each(visit);
    }
}
