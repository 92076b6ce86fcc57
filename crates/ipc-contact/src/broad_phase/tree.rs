//! A tree of boxes with eight children a node, laid out without pointers.
//!
//! Features are put in an order in which every aligned block of 8, 64, 512, … is compact; a node of level 1 holds the
//! boxes of eight leaf groups, a node of level 2 those of eight nodes of level 1, and so on. Motion changes the
//! boxes, not the order: a refit is one sweep over the leaves and a short one over the nodes. Boxes in nodes are
//! in `f32`, relative to an origin and rounded outwards, eight to a vector register; they decide only where to
//! look. The boxes of features are in `f64` and decide alone which pairs overlap, so neither order nor origin has
//! any influence on a result.

use super::boxes::Bounds;
use mechanics_core::lanes::{self, LaneKernel, Packet};
use mechanics_core::parallel;
use mechanics_core::scalar::Mask;
use std::ops::Range;

/// Children of a node.
pub(super) const WIDTH: usize = 8;
/// Leaf groups of a parallel part.
const CHUNK: usize = 256;
/// Items from which on halves are sorted in parallel.
const PARALLEL_SPLIT: usize = 4096;

/// Eight boxes in single precision.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Octet {
    low: [[f32; WIDTH]; 3],
    high: [[f32; WIDTH]; 3],
}

/// One box in single precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Single {
    low: [f32; 3],
    high: [f32; 3],
}

impl Octet {
    /// Eight boxes that overlap nothing, not even all of space.
    const EMPTY: Self = Self { low: [[f32::NAN; WIDTH]; 3], high: [[f32::NAN; WIDTH]; 3] };

    #[inline]
    fn set(&mut self, lane: usize, b: &Single) {
        for k in 0..3 {
            self.low[k][lane] = b.low[k];
            self.high[k][lane] = b.high[k];
        }
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Single {
        Single { low: self.low.map(|l| l[lane]), high: self.high.map(|h| h[lane]) }
    }

    /// The smallest box around all eight.
    #[inline(always)]
    fn union(&self) -> Single {
        Single {
            low: self.low.map(|l| l.into_iter().fold(f32::INFINITY, f32::min)),
            high: self.high.map(|h| h.into_iter().fold(f32::NEG_INFINITY, f32::max)),
        }
    }

    /// Bit k: box k overlaps `b`.
    #[inline(always)]
    fn overlapping<P: Packet<Element = f32>>(&self, b: &Single) -> u32 {
        let axis = |k: usize| {
            let (low, high) = (P::load(&self.low[k]), P::load(&self.high[k]));
            low.less_equal(P::splat(b.high[k])).and(P::splat(b.low[k]).less_equal(high))
        };
        let hits = axis(0).and(axis(1)).and(axis(2));
        // Each lane that is hit holds its own bit, so that the lanes' disjunction holds all.
        let bits = P::select(hits, P::load(&LANE_BITS), P::splat(0.0)).to_lanes();
        bits.as_ref().iter().fold(0, |all, bit| all | bit.to_bits())
    }
}

/// Bit k on lane k.
const LANE_BITS: [f32; WIDTH] = {
    let mut bits = [0.0; WIDTH];
    let mut lane = 0;
    while lane < WIDTH {
        bits[lane] = f32::from_bits(1 << lane);
        lane += 1;
    }
    bits
};

impl Single {
    /// The box in single precision, relative to `origin`, rounded outwards.
    ///
    /// The difference and its conversion are off by less than 2⁻²³ of it, or by less than the smallest normal number;
    /// the bound is moved by twice that. A number that is too large becomes the largest, then infinite if
    /// that is outwards.
    #[inline]
    fn around(b: &Bounds, origin: &[f64; 3]) -> Self {
        const SLACK: f32 = 2.0 * f32::EPSILON;
        let single = |x: f64| (x as f32).clamp(f32::MIN, f32::MAX);
        let low = |k: usize| single(b.low[k] - origin[k]);
        let high = |k: usize| single(b.high[k] - origin[k]);
        Self {
            low: std::array::from_fn(|k| low(k) - (low(k).abs() * SLACK + f32::MIN_POSITIVE)),
            high: std::array::from_fn(|k| high(k) + (high(k).abs() * SLACK + f32::MIN_POSITIVE)),
        }
    }

    /// Sum of the sides.
    fn extent(&self) -> f64 {
        (0..3).map(|k| f64::from(self.high[k]) - f64::from(self.low[k])).sum()
    }
}

/// Eight features of `N` points each.
#[derive(Clone, Debug)]
pub(super) struct LeafGroup<const N: usize> {
    octet: Octet,
    /// Around all eight.
    whole: Single,
    pub(super) bounds: [Bounds; WIDTH],
    pub(super) corners: [[u32; N]; WIDTH],
    pub(super) numbers: [u32; WIDTH],
    count: u8,
}

/// A tree over features of `N` points each.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree<const N: usize> {
    pub(super) leaves: Vec<LeafGroup<N>>,
    /// Level k holds, eight to a node, the boxes of level k − 1; level 0 those of the leaf groups. The last has
    /// one node.
    levels: Vec<Vec<Octet>>,
    /// Sum of the sides of all boxes of groups and nodes, less those of the features in them, when the order was
    /// found and now.
    spread_when_built: f64,
    spread: f64,
}

/// A feature on its way to its place.
#[derive(Clone, Copy)]
struct Item {
    /// Middle of the box, relative to the origin: a rounding here costs a worse order at most.
    centre: [f32; 3],
    index: u32,
}

impl Item {
    fn new(index: usize, b: &Bounds, origin: &[f64; 3]) -> Self {
        let centre = b.centre();
        Self { centre: std::array::from_fn(|k| (centre[k] - origin[k]) as f32), index: index as u32 }
    }

    /// Ascends with the centre along an axis, then with the index.
    #[inline]
    fn key(&self, axis: usize) -> u64 {
        // The order of floats is that of their bits, reversed for negative ones and below the positive ones.
        let bits = self.centre[axis].to_bits();
        let flipped = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
        u64::from(flipped) << 32 | u64::from(self.index)
    }
}

impl<const N: usize> Tree<N> {
    /// A tree over features with these numbers and points, given the boxes of all points.
    pub(super) fn build(features: &[(u32, [u32; N])], points: &[Bounds], origin: &[f64; 3]) -> Self {
        let item =
            |(k, feature): (usize, &(u32, [u32; N]))| Item::new(k, &bounds_of(&feature.1, points), origin);
        let mut items: Vec<Item> = features.iter().enumerate().map(item).collect();
        arrange(&mut items);
        let leaves: Vec<LeafGroup<N>> =
            items.chunks(WIDTH).map(|group| leaf_group(group, features)).collect();
        let mut levels = Vec::new();
        let mut count = leaves.len();
        while count > 1 {
            count = count.div_ceil(WIDTH);
            levels.push(vec![Octet::EMPTY; count]);
        }
        let mut tree = Self { leaves, levels, spread_when_built: 0.0, spread: 0.0 };
        tree.refit(points, origin);
        tree.spread_when_built = tree.spread;
        tree
    }

    /// Have features that are neighbours in the order drifted apart since it was found?
    pub(super) fn has_degraded(&self) -> bool {
        self.spread > 1.5 * self.spread_when_built
    }

    /// Sets all boxes anew.
    pub(super) fn refit(&mut self, points: &[Bounds], origin: &[f64; 3]) {
        parallel::for_each_chunk(&mut self.leaves, CHUNK, |_, groups| {
            groups.iter_mut().for_each(|group| group.refit(points, origin));
        });
        let parts = parallel::map_chunks(self.leaves.len(), CHUNK, |range| {
            let groups = &self.leaves[range];
            let wholes: Vec<Single> = groups.iter().map(|group| group.whole).collect();
            (groups.iter().map(LeafGroup::spread).sum::<f64>(), wholes)
        });
        let mut spread: f64 = parts.iter().map(|part| part.0).sum();
        let mut below: Vec<Single> = parts.into_iter().flat_map(|part| part.1).collect();
        for level in &mut self.levels {
            for (node, children) in level.iter_mut().zip(below.chunks(WIDTH)) {
                children.iter().enumerate().for_each(|(lane, child)| node.set(lane, child));
            }
            below = level.iter().map(Octet::union).collect();
            spread += below.iter().map(Single::extent).sum::<f64>();
        }
        self.spread = spread;
    }

    /// Calls `found(group of self, lane, group of other, lane)` for all pairs of features that share no point and
    /// whose boxes overlap, for the given groups of `self`.
    pub(super) fn overlaps<const M: usize>(
        &self,
        groups: Range<usize>,
        other: &Tree<M>,
        scope: Scope,
        found: impl FnMut(&LeafGroup<N>, usize, &LeafGroup<M>, usize),
    ) {
        lanes::dispatch(Search { tree: self, groups, other, scope, found });
    }

    /// The leaf groups from `first` on whose boxes overlap `b`.
    #[inline(always)]
    fn groups_near<P: Packet<Element = f32>>(
        &self,
        b: &Single,
        first: usize,
        stack: &mut Vec<(usize, usize)>,
        near: &mut Vec<u32>,
    ) {
        near.clear();
        if self.levels.is_empty() {
            near.extend(0..self.leaves.len() as u32);
            return;
        }
        stack.push((self.levels.len() - 1, 0));
        while let Some((level, node)) = stack.pop() {
            let mut bits = self.levels[level][node].overlapping::<P>(b);
            while bits != 0 {
                let child = node * WIDTH + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                // A child of this node ends before leaf group (child + 1) 8^level.
                if ((child + 1) << (3 * level)) <= first {
                    continue;
                }
                if level == 0 {
                    near.push(child as u32);
                } else {
                    stack.push((level - 1, child));
                }
            }
        }
    }
}

/// Which pairs a search looks for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Scope {
    /// Features of one tree, or group, and of another.
    Between,
    /// Features of one tree, or group, alone, each pair once.
    Within,
}

/// A search, compiled for the processor's widest registers.
struct Search<'a, const N: usize, const M: usize, F> {
    tree: &'a Tree<N>,
    groups: Range<usize>,
    other: &'a Tree<M>,
    scope: Scope,
    found: F,
}

impl<const N: usize, const M: usize, F> LaneKernel<f32> for Search<'_, N, M, F>
where
    F: FnMut(&LeafGroup<N>, usize, &LeafGroup<M>, usize),
{
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = f32>>(mut self) {
        let (mut near, mut stack) = (Vec::new(), Vec::new());
        for g in self.groups {
            let group = &self.tree.leaves[g];
            let first = if self.scope == Scope::Within { g } else { 0 };
            self.other.groups_near::<P>(&group.whole, first, &mut stack, &mut near);
            for &h in &near {
                let scope = if h as usize == g { self.scope } else { Scope::Between };
                group.overlaps_between::<P, M>(&self.other.leaves[h as usize], scope, &mut self.found);
            }
        }
    }
}

impl<const N: usize> LeafGroup<N> {
    fn refit(&mut self, points: &[Bounds], origin: &[f64; 3]) {
        for lane in 0..usize::from(self.count) {
            self.bounds[lane] = bounds_of(&self.corners[lane], points);
            self.octet.set(lane, &Single::around(&self.bounds[lane], origin));
        }
        self.whole = self.octet.union();
    }

    /// How much larger the group's box is than the mean of its features' boxes: the sum of the sides.
    fn spread(&self) -> f64 {
        let count = usize::from(self.count);
        self.whole.extent()
            - (0..count).map(|lane| self.octet.lane(lane).extent()).sum::<f64>() / count as f64
    }

    /// The overlapping pairs between two groups, or within one.
    #[inline(always)]
    fn overlaps_between<P: Packet<Element = f32>, const M: usize>(
        &self,
        other: &LeafGroup<M>,
        scope: Scope,
        found: &mut impl FnMut(&Self, usize, &LeafGroup<M>, usize),
    ) {
        let mut mine = self.octet.overlapping::<P>(&other.whole);
        while mine != 0 {
            let lane = mine.trailing_zeros() as usize;
            mine &= mine - 1;
            let after = if scope == Scope::Within { u32::MAX << (lane + 1) } else { u32::MAX };
            let mut theirs = other.octet.overlapping::<P>(&self.octet.lane(lane)) & after;
            while theirs != 0 {
                let their = theirs.trailing_zeros() as usize;
                theirs &= theirs - 1;
                if !share_a_point(&self.corners[lane], &other.corners[their])
                    && self.bounds[lane].overlaps(&other.bounds[their])
                {
                    found(self, lane, other, their);
                }
            }
        }
    }
}

#[inline(always)]
fn share_a_point<const N: usize, const M: usize>(a: &[u32; N], b: &[u32; M]) -> bool {
    a.iter().fold(false, |shared, p| shared | b.iter().fold(false, |shared, q| shared | (p == q)))
}

fn bounds_of<const N: usize>(corners: &[u32; N], points: &[Bounds]) -> Bounds {
    let first = points[corners[0] as usize];
    corners[1..].iter().fold(first, |b, &p| b.union(&points[p as usize]))
}

fn leaf_group<const N: usize>(items: &[Item], features: &[(u32, [u32; N])]) -> LeafGroup<N> {
    let mut group = LeafGroup {
        octet: Octet::EMPTY,
        whole: Octet::EMPTY.union(),
        bounds: [Bounds::NOTHING; WIDTH],
        corners: [[u32::MAX; N]; WIDTH],
        numbers: [u32::MAX; WIDTH],
        count: items.len() as u8,
    };
    for (lane, item) in items.iter().enumerate() {
        (group.numbers[lane], group.corners[lane]) = features[item.index as usize];
    }
    group
}

/// Orders items so that all aligned blocks of 8, 64, 512, … are compact: halves them again and again along the
/// longest side of the box around their centres, at a multiple of the largest such block.
fn arrange(items: &mut [Item]) {
    let count = items.len();
    if count <= WIDTH {
        return;
    }
    let mut block = WIDTH;
    while block * WIDTH < count {
        block *= WIDTH;
    }
    let middle = (block * ((count + block) / (2 * block))).max(block);
    let axis = longest_side(items);
    items.select_nth_unstable_by_key(middle, |item| item.key(axis));
    let (left, right) = items.split_at_mut(middle);
    if count < PARALLEL_SPLIT {
        arrange(left);
        arrange(right);
    } else {
        parallel::join(|| arrange(left), || arrange(right));
    }
}

fn longest_side(items: &[Item]) -> usize {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for item in items {
        for k in 0..3 {
            // Not `min` and `max`, which look for NaN: there is none.
            let c = item.centre[k];
            low[k] = if c < low[k] { c } else { low[k] };
            high[k] = if c > high[k] { c } else { high[k] };
        }
    }
    let side = |k: usize| high[k] - low[k];
    (1..3).fold(0, |best, k| if side(k) > side(best) { k } else { best })
}
