//! The sparse grid: blocks of 64 nodes where matter is, and nothing elsewhere.
//!
//! Node i of an axis is at i · spacing; the grid has no border. Blocks are 4×4×4 nodes (8×8 in the plane), in ascending order of their
//! coordinates. A block exists if the arena of some block of particles reaches it.

use crate::neighbourhood::{DRIFT, NODE, arena_length, arena_side, block_edge};
use mechanics_core::lanes::Element;
use mechanics_core::parallel;
use std::collections::BTreeMap;
use std::ops::Range;

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

/// Whether impulses, and then changes of velocities, are kept beside the velocities: FLIP and XPIC need them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Changes {
    Kept,
    Dropped,
}

/// What arenas add to the nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Addition {
    /// Everything: nodes and changes begin at zero.
    Fresh,
    /// More momentum.
    Momentum,
    /// Nothing: the nodes have everything.
    Nothing,
}

/// Blocks of nodes and what the particles bring to them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid<E, const D: usize> {
    width: usize,
    /// What arenas share with the neighbours of their block, by neighbour.
    rows: Vec<Row>,
    row_ends: [usize; MOST_NEIGHBOURS],
    /// Coordinates of the blocks, ascending.
    blocks: Vec<[i32; D]>,
    /// Per block of particles, the blocks of nodes around it, ascending by offset.
    neighbours: Vec<[u32; MOST_NEIGHBOURS]>,
    sources: Vec<Source>,
    source_ends: Vec<usize>,
    /// Where the numbers of each block of nodes end.
    node_ends: Vec<usize>,
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

/// Consecutive nodes that a block of nodes and an arena share.
#[derive(Clone, Copy, Debug)]
struct Row {
    /// Where in the block, in numbers.
    at: u32,
    /// Where in the arena.
    from: u32,
    nodes: u32,
}

impl Row {
    fn in_block(self) -> Range<usize> {
        self.at as usize..self.at as usize + self.nodes as usize * NODE
    }

    fn in_arena(self) -> Range<usize> {
        self.from as usize..self.from as usize + self.nodes as usize * NODE
    }
}

/// The rows along the last axis that an arena shares with one neighbour of its block.
fn shared_rows<const D: usize>(neighbour: usize, width: usize) -> Vec<Row> {
    let (edge, side) = (block_edge(D), arena_side(D, width));
    let offset = offset::<D>(neighbour);
    let parts: [(usize, usize, usize); D] = std::array::from_fn(|axis| overlap(offset[axis], edge, side));
    let (from, to, start) = parts[D - 1];
    let lines = if D == 3 { parts[1] } else { (0, 1, 0) };
    let mut rows = Vec::new();
    if from == to {
        return rows;
    }
    for t in parts[0].0..parts[0].1 {
        for s in lines.0..lines.1 {
            let (a, b) = (t - parts[0].0 + parts[0].2, s - lines.0 + lines.2);
            let (line, arena_line) = if D == 3 { (t * edge + s, a * side + b) } else { (t, a) };
            rows.push(Row {
                at: ((line * edge + from) * NODE) as u32,
                from: ((arena_line * side + start) * NODE) as u32,
                nodes: (to - from) as u32,
            });
        }
    }
    rows
}

impl<E: Element, const D: usize> Grid<E, D> {
    /// An empty grid for kernels of `width` nodes.
    pub(crate) fn new(width: usize, changes: Changes) -> Self {
        let mut grid = Self { width, keeps_changes: changes == Changes::Kept, ..Self::default() };
        for neighbour in 0..3_usize.pow(D as u32) {
            grid.rows.extend(shared_rows::<D>(neighbour, width));
            grid.row_ends[neighbour] = grid.rows.len();
        }
        grid
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
        let stride = self.stride();
        self.node_ends.clear();
        self.node_ends.extend((1..=self.blocks.len()).map(|k| k * stride));
        self.nodes.clear();
        self.nodes.resize(self.blocks.len() * self.stride(), E::default());
    }

    /// Whether an arena reaches its block's neighbour at all.
    fn is_shared(&self, neighbour: usize) -> bool {
        !self.rows_of(neighbour).is_empty()
    }

    fn rows_of(&self, neighbour: usize) -> &[Row] {
        let first = if neighbour == 0 { 0 } else { self.row_ends[neighbour - 1] };
        &self.rows[first..self.row_ends[neighbour]]
    }

    /// Numbers of the blocks of nodes around a block of particles.
    pub(crate) fn around(&self, particles: usize) -> impl Iterator<Item = usize> + '_ {
        self.neighbours[particles].iter().filter(|block| **block != u32::MAX).map(|block| *block as usize)
    }

    /// Bytes of the nodes and of what is known of their blocks.
    pub(crate) fn bytes(&self) -> usize {
        let known = std::mem::size_of_val(&self.neighbours[..]) + std::mem::size_of_val(&self.sources[..]);
        let blocks = std::mem::size_of_val(&self.blocks[..]) + std::mem::size_of_val(&self.node_ends[..]);
        std::mem::size_of_val(&self.nodes[..]) + known + blocks
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
        addition: Addition,
        results: &mut [R],
        update: impl Fn(&[i32; D], &mut [E], &mut [E], &mut R) + Sync,
    ) {
        let (length, keeps_changes) = (self.arena_stride(), self.keeps_changes);
        let (sources, ends, blocks) = (&self.sources, &self.source_ends, &self.blocks);
        let (rows, row_ends, second) = (&self.rows, &self.row_ends, arena_length(D, self.width));
        parallel::for_each_part(&mut self.nodes, &self.node_ends, results, |block, nodes, result| {
            let (nodes, changes) = nodes.split_at_mut(BLOCK);
            if addition == Addition::Fresh {
                nodes.fill(E::default());
                changes.fill(E::default());
            }
            let first = if block == 0 { 0 } else { ends[block - 1] };
            let end = if addition == Addition::Nothing { first } else { ends[block] };
            for source in &sources[first..end] {
                let arena = &arenas[source.arena as usize * length..][..length];
                let neighbour = source.neighbour as usize;
                let first = if neighbour == 0 { 0 } else { row_ends[neighbour - 1] };
                for row in &rows[first..row_ends[neighbour]] {
                    add(&mut nodes[row.in_block()], &arena[row.in_arena()]);
                    if keeps_changes && addition == Addition::Fresh {
                        add(&mut changes[row.in_block()], &arena[second..][row.in_arena()]);
                    }
                }
            }
            update(&blocks[block], nodes, changes, result);
        });
    }

    /// Fills an arena with the nodes around a block of particles.
    #[inline(always)]
    pub(crate) fn fill(&self, particles: usize, arena: &mut [E]) {
        self.fill_from(particles, 0, arena);
    }

    /// Fills an arena with the velocities around a block of particles, where the nodes have momenta.
    #[inline(always)]
    pub(crate) fn fill_divided(&self, particles: usize, arena: &mut [E]) {
        self.fill_from(particles, 0, arena);
        for node in arena.chunks_exact_mut(NODE) {
            let mass = node[0];
            if mass.less_equal(E::default()) {
                continue;
            }
            for number in &mut node[1..] {
                *number /= mass;
            }
        }
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
            for row in self.rows_of(neighbour) {
                // Node by node: rows are short, and lengths that are known need no call.
                let targets = arena[row.in_arena()].chunks_exact_mut(NODE);
                for (target, node) in targets.zip(nodes[row.in_block()].chunks_exact(NODE)) {
                    target.copy_from_slice(node);
                }
            }
        }
    }
}

fn add<E: Element>(sums: &mut [E], parts: &[E]) {
    for (sum, part) in sums.chunks_exact_mut(NODE).zip(parts.chunks_exact(NODE)) {
        for channel in 0..NODE {
            sum[channel] += part[channel];
        }
    }
}

fn shifted<const D: usize>(origin: &[i32; D], by: &[i32; D]) -> [i32; D] {
    std::array::from_fn(|axis| origin[axis] + by[axis])
}
