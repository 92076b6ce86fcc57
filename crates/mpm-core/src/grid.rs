//! The sparse grid: blocks of 64 nodes where matter is, and nothing elsewhere.
//!
//! Node i of an axis is at i · spacing; the grid has no border. Blocks are 4×4×4 nodes (8×8 in the plane), in ascending order of their
//! coordinates. A block exists if the arena of some block of particles reaches it.

use crate::neighbourhood::{DRIFT, NODE, arena_length, arena_side, block_edge};
use mechanics_core::lanes::Element;
use mechanics_core::parallel;
use std::collections::BTreeMap;

/// Blocks around a block, itself included: 3³.
pub(crate) const MOST_NEIGHBOURS: usize = 27;

/// Numbers of a block of nodes: 64 nodes in either dimension.
pub(crate) const BLOCK: usize = 64 * NODE;

/// Which part of an arena lies in which block of nodes.
#[derive(Clone, Copy, Debug)]
struct Source {
    arena: u32,
    /// Number of the block of nodes among the neighbours of the arena's block.
    neighbour: u8,
}

/// Whether changes of velocities are kept beside the velocities: FLIP needs them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Changes {
    Kept,
    Dropped,
}

/// Blocks of nodes and what the particles bring to them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid<E, const D: usize> {
    width: usize,
    /// Coordinates of the blocks, ascending.
    blocks: Vec<[i32; D]>,
    /// Per block of particles, the blocks of nodes around it, ascending by offset.
    neighbours: Vec<[u32; MOST_NEIGHBOURS]>,
    sources: Vec<Source>,
    source_ends: Vec<usize>,
    /// Whether changes of velocities are kept beside the velocities.
    keeps_changes: bool,
    /// (m, v) of every node of a block, then (0, Δv) of every node if changes are kept.
    nodes: Vec<E>,
}

/// The offset of a neighbour, −1, 0 or 1 an axis; the last axis counts fastest.
fn offset<const D: usize>(neighbour: usize) -> [i32; D] {
    std::array::from_fn(|axis| (neighbour / 3_usize.pow((D - 1 - axis) as u32) % 3) as i32 - 1)
}

/// Of one axis: the nodes of a block that lie in an arena, as range within the block, and where in the arena the first one is.
fn overlap(offset: i32, edge: usize, side: usize) -> (usize, usize, usize) {
    // Node t of the block is node edge · offset + t + DRIFT of the arena.
    let shift = edge as i32 * offset + DRIFT as i32;
    let from = (-shift).max(0);
    let to = (side as i32 - shift).min(edge as i32);
    (from as usize, to.max(from) as usize, (from + shift) as usize)
}

/// Calls `row(at in the block, at in the arena, how many numbers)` for the rows along the last axis that they share.
#[inline(always)]
fn for_each_row<const D: usize>(neighbour: usize, width: usize, mut row: impl FnMut(usize, usize, usize)) {
    let (edge, side) = (block_edge(D), arena_side(D, width));
    let offset = offset::<D>(neighbour);
    let parts: [(usize, usize, usize); D] = std::array::from_fn(|axis| overlap(offset[axis], edge, side));
    let (from, to, start) = parts[D - 1];
    let count = (to - from) * NODE;
    if count == 0 {
        return;
    }
    let lines = |t0: usize, a0: usize, row: &mut dyn FnMut(usize, usize, usize)| {
        row((t0 * edge + from) * NODE, (a0 * side + start) * NODE, count);
    };
    for t in parts[0].0..parts[0].1 {
        let a = t - parts[0].0 + parts[0].2;
        if D == 2 {
            lines(t, a, &mut row);
            continue;
        }
        for s in parts[1].0..parts[1].1 {
            let b = s - parts[1].0 + parts[1].2;
            lines(t * edge + s, a * side + b, &mut row);
        }
    }
}

impl<E: Element, const D: usize> Grid<E, D> {
    /// An empty grid for kernels of `width` nodes.
    pub(crate) fn new(width: usize, changes: Changes) -> Self {
        Self { width, keeps_changes: changes == Changes::Kept, ..Self::default() }
    }

    /// Numbers of a block.
    fn stride(&self) -> usize {
        if self.keeps_changes { 2 * BLOCK } else { BLOCK }
    }

    /// Numbers from arena to arena: the nodes, then, if changes are kept, the impulses of the same nodes.
    pub(crate) fn arena_stride(&self) -> usize {
        let length = arena_length(D, self.width);
        if self.keeps_changes { 2 * length } else { length }
    }

    /// Makes the blocks around the given blocks of particles; they keep their order as arenas.
    pub(crate) fn rebuild(&mut self, particles: impl Iterator<Item = [i32; D]> + Clone) {
        let count = 3_usize.pow(D as u32);
        self.blocks.clear();
        for origin in particles.clone() {
            for neighbour in 0..count {
                if self.is_shared(neighbour) {
                    self.blocks.push(shifted(&origin, &offset::<D>(neighbour)));
                }
            }
        }
        self.blocks.sort_unstable();
        self.blocks.dedup();
        let index: BTreeMap<[i32; D], u32> =
            self.blocks.iter().zip(0..).map(|(block, k)| (*block, k)).collect();
        self.neighbours.clear();
        let mut reached: Vec<(u32, Source)> = Vec::new();
        for (origin, arena) in particles.zip(0..) {
            let mut around = [u32::MAX; MOST_NEIGHBOURS];
            for (neighbour, entry) in around.iter_mut().enumerate().take(count) {
                let block = index.get(&shifted(&origin, &offset::<D>(neighbour)));
                if let (Some(&block), true) = (block, self.is_shared(neighbour)) {
                    *entry = block;
                    reached.push((block, Source { arena, neighbour: neighbour as u8 }));
                }
            }
            self.neighbours.push(around);
        }
        // Stable: arenas of a block stay in ascending order, which is the order of the sums.
        reached.sort_by_key(|(block, _)| *block);
        self.sources.clear();
        self.source_ends.clear();
        self.source_ends.resize(self.blocks.len(), 0);
        for (block, source) in reached {
            self.sources.push(source);
            self.source_ends[block as usize] = self.sources.len();
        }
        self.nodes.clear();
        self.nodes.resize(self.blocks.len() * self.stride(), E::default());
    }

    /// Whether an arena reaches its block's neighbour at all.
    fn is_shared(&self, neighbour: usize) -> bool {
        let mut shared = false;
        for_each_row::<D>(neighbour, self.width, |_, _, count| shared |= count > 0);
        shared
    }

    /// Numbers of the blocks of nodes around a block of particles.
    pub(crate) fn around(&self, particles: usize) -> impl Iterator<Item = usize> + '_ {
        self.neighbours[particles].iter().filter(|block| **block != u32::MAX).map(|block| *block as usize)
    }

    /// How many blocks of nodes there are.
    pub(crate) fn block_count(&self) -> usize {
        self.blocks.len()
    }

    /// Sums the arenas into the nodes, and their impulses into the changes, in ascending order of arenas; hands each block to `update`: its coordinates,
    /// nodes, changes (empty if they are not kept) and result.
    pub(crate) fn collect<R: Send>(
        &mut self,
        arenas: &[E],
        results: &mut [R],
        update: impl Fn(&[i32; D], &mut [E], &mut [E], &mut R) + Sync,
    ) {
        let (length, keeps_changes) = (self.arena_stride(), self.keeps_changes);
        let (sources, ends, blocks, width) = (&self.sources, &self.source_ends, &self.blocks, self.width);
        let block_ends: Vec<usize> = (1..=blocks.len()).map(|k| k * self.stride()).collect();
        parallel::for_each_part(&mut self.nodes, &block_ends, results, |block, nodes, result| {
            let (nodes, changes) = nodes.split_at_mut(BLOCK);
            nodes.fill(E::default());
            changes.fill(E::default());
            let first = if block == 0 { 0 } else { ends[block - 1] };
            for source in &sources[first..ends[block]] {
                let arena = &arenas[source.arena as usize * length..][..length];
                let second = arena_length(D, width);
                for_each_row::<D>(source.neighbour as usize, width, |at, from, count| {
                    add(&mut nodes[at..at + count], &arena[from..from + count]);
                    if keeps_changes {
                        add(&mut changes[at..at + count], &arena[second + from..second + from + count]);
                    }
                });
            }
            update(&blocks[block], nodes, changes, result);
        });
    }

    /// Fills an arena with the nodes around a block of particles.
    #[inline(always)]
    pub(crate) fn fill(&self, particles: usize, arena: &mut [E]) {
        self.fill_from(particles, 0, arena);
    }

    /// Fills an arena with the changes of velocities around a block of particles.
    #[inline(always)]
    pub(crate) fn fill_changes(&self, particles: usize, arena: &mut [E]) {
        self.fill_from(particles, BLOCK, arena);
    }

    #[inline(always)]
    fn fill_from(&self, particles: usize, first: usize, arena: &mut [E]) {
        for (neighbour, &block) in self.neighbours[particles].iter().enumerate().take(3_usize.pow(D as u32)) {
            if block == u32::MAX {
                continue;
            }
            let nodes = &self.nodes[block as usize * self.stride() + first..][..BLOCK];
            for_each_row::<D>(neighbour, self.width, |at, to, count| {
                arena[to..to + count].copy_from_slice(&nodes[at..at + count]);
            });
        }
    }
}

fn add<E: Element>(sums: &mut [E], parts: &[E]) {
    for (sum, part) in sums.iter_mut().zip(parts) {
        *sum += *part;
    }
}

fn shifted<const D: usize>(origin: &[i32; D], by: &[i32; D]) -> [i32; D] {
    std::array::from_fn(|axis| origin[axis] + by[axis])
}
