//! Pairs of overlapping boxes: a tree of eights and twos over boxes in Morton order.
//!
//! It exists beside [`crate::broad_phase`] so that the exact check shares nothing with the code it checks.

use mechanics_core::tensor::Vec3;
use std::ops::ControlFlow;

/// Boxes in a leaf.
pub(super) const LEAF: usize = 8;

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

/// Eight boxes, coordinate by coordinate; empty ones fill up the last leaf.
#[derive(Clone, Debug)]
struct Leaf {
    low: [[f64; LEAF]; 3],
    high: [[f64; LEAF]; 3],
}

impl Leaf {
    fn of(boxes: &[Bounds], items: &[u32]) -> Self {
        let item = |k: usize| items.get(k).map_or(Bounds::EMPTY, |&i| boxes[i as usize]);
        let members: [Bounds; LEAF] = std::array::from_fn(item);
        let table =
            |entry: &dyn Fn(&Bounds) -> [f64; 3]| [0, 1, 2].map(|k| members.each_ref().map(|b| entry(b)[k]));
        Self { low: table(&|b| b.low), high: table(&|b| b.high) }
    }

    #[inline]
    fn member(&self, k: usize) -> Bounds {
        Bounds { low: self.low.map(|row| row[k]), high: self.high.map(|row| row[k]) }
    }

    /// Which members overlap a box, as bits.
    #[inline]
    fn overlapping(&self, other: &Bounds) -> u32 {
        let mut apart = [false; LEAF];
        for axis in 0..3 {
            for k in 0..LEAF {
                apart[k] |= self.low[axis][k] > other.high[axis];
                apart[k] |= other.low[axis] > self.high[axis][k];
            }
        }
        (0..LEAF).fold(0, |bits, k| bits | u32::from(!apart[k]) << k)
    }
}

/// A tree over boxes, named by their index.
#[derive(Clone, Debug)]
pub(super) struct BoxTree {
    /// Items in the order of the leaves.
    items: Vec<u32>,
    leaves: Vec<Leaf>,
    /// Boxes of the leaves, then of pairs of boxes of the level before, up to a single one.
    levels: Vec<Vec<Bounds>>,
}

impl BoxTree {
    pub(super) fn new(boxes: &[Bounds]) -> Self {
        let items = morton_order(boxes);
        let leaves: Vec<Leaf> = items.chunks(LEAF).map(|part| Leaf::of(boxes, part)).collect();
        let union = |part: &[u32]| part.iter().fold(Bounds::EMPTY, |sum, &i| sum.with(&boxes[i as usize]));
        let mut levels = vec![items.chunks(LEAF).map(union).collect::<Vec<_>>()];
        while let Some(below) = levels.last().filter(|level| level.len() > 1) {
            let above = below.chunks(2).map(|pair| pair.iter().fold(Bounds::EMPTY, |sum, b| sum.with(b)));
            let above = above.collect();
            levels.push(above);
        }
        Self { items, leaves, levels }
    }

    pub(super) fn leaf_count(&self) -> usize {
        self.leaves.len()
    }

    /// Calls `visit` for every pair of an item in leaf `leaf` of this tree and an item of `other` whose boxes share a point.
    #[inline]
    pub(super) fn pairs_of_leaf(
        &self,
        leaf: usize,
        other: &Self,
        visit: &mut impl FnMut(u32, u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let items = &self.items[leaf * LEAF..self.items.len().min((leaf + 1) * LEAF)];
        other.leaves_overlapping(&self.levels[0][leaf], &mut |theirs| {
            for (k, &item) in items.iter().enumerate() {
                let member = self.leaves[leaf].member(k);
                if !member.overlaps(&other.levels[0][theirs]) {
                    continue;
                }
                let mut bits = other.leaves[theirs].overlapping(&member);
                while bits != 0 {
                    visit(item, other.items[theirs * LEAF + bits.trailing_zeros() as usize])?;
                    bits &= bits - 1;
                }
            }
            ControlFlow::Continue(())
        })
    }

    #[inline]
    fn leaves_overlapping(
        &self,
        bounds: &Bounds,
        visit: &mut impl FnMut(usize) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        // Two children a level, of at most 32 levels.
        let mut stack = [(0u32, 0u32); 64];
        stack[0] = (self.levels.len() as u32 - 1, 0);
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (level, index) = (stack[height].0 as usize, stack[height].1 as usize);
            if !self.levels[level].get(index).is_some_and(|b| b.overlaps(bounds)) {
                continue;
            }
            if level == 0 {
                visit(index)?;
                continue;
            }
            for child in [2 * index + 1, 2 * index] {
                stack[height] = (level as u32 - 1, child as u32);
                height += 1;
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
