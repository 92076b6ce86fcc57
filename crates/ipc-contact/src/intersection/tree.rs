//! Pairs of overlapping boxes: a tree of eights over boxes in Morton order.
//!
//! It exists beside [`crate::broad_phase`] so that the exact check shares nothing with the code it checks.

use mechanics_core::tensor::Vec3;
use std::ops::ControlFlow;

/// Boxes in a block.
pub(super) const WIDTH: usize = 8;

/// An axis-aligned box, closed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl Bounds {
    /// Contains nothing and overlaps nothing.
    const EMPTY: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// The smallest box around the points.
    #[inline]
    pub(super) fn around<const N: usize>(points: [&Vec3; N]) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, p| {
            let p = [p.x, p.y, p.z];
            bounds.with(&Self { low: p, high: p })
        })
    }

    #[inline]
    fn with(&self, other: &Self) -> Self {
        let smaller = |a: f64, b: f64| if b < a { b } else { a };
        let larger = |a: f64, b: f64| if b > a { b } else { a };
        Self {
            low: [0, 1, 2].map(|k| smaller(self.low[k], other.low[k])),
            high: [0, 1, 2].map(|k| larger(self.high[k], other.high[k])),
        }
    }

    #[inline]
    fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }
}

/// Eight boxes, coordinate by coordinate; empty ones fill up the last block of a level.
#[derive(Clone, Debug)]
struct Block {
    low: [[f64; WIDTH]; 3],
    high: [[f64; WIDTH]; 3],
}

impl Block {
    const EMPTY: Self = Self { low: [[f64::INFINITY; WIDTH]; 3], high: [[f64::NEG_INFINITY; WIDTH]; 3] };

    fn of(boxes: impl Iterator<Item = Bounds>) -> Self {
        let mut block = Self::EMPTY;
        for (k, bounds) in boxes.enumerate() {
            for axis in 0..3 {
                block.low[axis][k] = bounds.low[axis];
                block.high[axis][k] = bounds.high[axis];
            }
        }
        block
    }

    #[inline]
    fn member(&self, k: usize) -> Bounds {
        Bounds { low: self.low.map(|row| row[k]), high: self.high.map(|row| row[k]) }
    }

    /// The box around all members.
    fn bounds(&self) -> Bounds {
        (0..WIDTH).fold(Bounds::EMPTY, |sum, k| sum.with(&self.member(k)))
    }

    /// Which members overlap a box, as bits.
    #[inline]
    fn overlapping(&self, other: &Bounds) -> u32 {
        // Integers as wide as the numbers compared: a comparison of a packet is a packet of these.
        let mut apart = [0u64; WIDTH];
        for axis in 0..3 {
            for k in 0..WIDTH {
                apart[k] |= u64::from(self.low[axis][k] > other.high[axis]);
                apart[k] |= u64::from(other.low[axis] > self.high[axis][k]);
            }
        }
        (0..WIDTH).fold(0, |bits, k| bits | (apart[k] as u32 ^ 1) << k)
    }
}

/// The positions of the ones in a word, ascending.
#[inline]
fn ones(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let lowest = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            lowest
        })
    })
}

/// A tree over boxes, named by their index.
#[derive(Clone, Debug)]
pub(super) struct BoxTree {
    /// Items in the order of the members of the lowest level.
    items: Vec<u32>,
    /// The boxes of the items, then of the blocks of the level before, up to a single block.
    levels: Vec<Vec<Block>>,
}

impl BoxTree {
    pub(super) fn new(boxes: &[Bounds]) -> Self {
        let items = morton_order(boxes);
        let block = |part: &[u32]| Block::of(part.iter().map(|&i| boxes[i as usize]));
        let mut levels = vec![items.chunks(WIDTH).map(block).collect::<Vec<_>>()];
        while let Some(below) = levels.last().filter(|level| level.len() > 1) {
            let above = below.chunks(WIDTH).map(|part| Block::of(part.iter().map(Block::bounds))).collect();
            levels.push(above);
        }
        Self { items, levels }
    }

    /// How many blocks the lowest level has.
    pub(super) fn block_count(&self) -> usize {
        self.levels[0].len()
    }

    /// The items in a block of the lowest level, at most [`WIDTH`].
    pub(super) fn items(&self, block: usize) -> &[u32] {
        &self.items[block * WIDTH..self.items.len().min((block + 1) * WIDTH)]
    }

    /// Calls `visit(k, item)` for every pair of the k-th item in a block of this tree's lowest level and an item of `other`
    /// whose boxes share a point.
    #[inline]
    pub(super) fn pairs_of_block(
        &self,
        block: usize,
        other: &Self,
        visit: &mut impl FnMut(usize, u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let ours = &self.levels[0][block];
        let all = ours.bounds();
        let members: [Bounds; WIDTH] = std::array::from_fn(|k| ours.member(k));
        let count = self.items(block).len();
        other.descend(&all, other.levels.len() - 1, 0, &mut |theirs, bounds| {
            for (k, member) in members[..count].iter().enumerate() {
                if !member.overlaps(bounds) {
                    continue;
                }
                for bit in ones(other.levels[0][theirs].overlapping(member)) {
                    visit(k, other.items[theirs * WIDTH + bit])?;
                }
            }
            ControlFlow::Continue(())
        })
    }

    /// Calls `visit` for the blocks of the lowest level, below the given block, whose box shares a point with `bounds`.
    fn descend(
        &self,
        bounds: &Bounds,
        level: usize,
        block: usize,
        visit: &mut impl FnMut(usize, &Bounds) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let Some(here) = self.levels[level].get(block) else { return ControlFlow::Continue(()) };
        if level == 0 {
            return visit(block, &here.bounds());
        }
        for bit in ones(here.overlapping(bounds)) {
            let child = block * WIDTH + bit;
            if level == 1 {
                visit(child, &here.member(bit))?;
            } else {
                self.descend(bounds, level - 1, child, visit)?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// Indices of boxes, sorted along a Morton curve through their centres. Rounding here moves a box to another leaf, never
/// out of the tree.
fn morton_order(boxes: &[Bounds]) -> Vec<u32> {
    // Halves, because the sum of two finite numbers may not be.
    let centre = |b: &Bounds| [0, 1, 2].map(|k| 0.5 * b.low[k] + 0.5 * b.high[k]);
    let all = boxes.iter().fold(Bounds::EMPTY, |sum, b| sum.with(b));
    let extent = (0..3).map(|k| 0.5 * all.high[k] - 0.5 * all.low[k]).fold(0.0, f64::max);
    let cells = f64::from(1 << 20) - 1.0;
    let mut keyed: Vec<(u64, u32)> = boxes
        .iter()
        .enumerate()
        .map(|(i, b)| {
            let c = centre(b);
            // A NaN (all boxes in one point) becomes cell 0.
            let cell = |k: usize| ((c[k] - all.low[k]) / extent * cells) as u64;
            (spread(cell(0)) | spread(cell(1)) << 1 | spread(cell(2)) << 2, i as u32)
        })
        .collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, i)| i).collect()
}

/// The lowest 21 bits of a number, two zeros between each.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x1f_0000_0000_ffff;
    let x = (x | x << 16) & 0x1f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}
