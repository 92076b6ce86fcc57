//! The sparse grid: blocks of 64 nodes where matter is, and nothing elsewhere.
//!
//! Node i of an axis is at i · spacing; the grid has no border. Blocks are 4×4×4 nodes (8×8 in the plane), in ascending order of their
//! coordinates. A block exists if the arena of some block of particles reaches it.

mod field;

pub(crate) use field::Fields;

use crate::collider::{NEUTRAL, Sides};
use crate::neighbourhood::{DRIFT, NODE, arena_length, arena_side, block_edge, gathered};
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
    /// Which nodes it gives to, by bits.
    mask: u64,
}

/// All nodes of a block.
const ALL: u64 = u64::MAX;

/// A block of nodes that exists once more, for particles on some sides of sheets.
#[derive(Clone, Copy, Debug)]
struct Ghost {
    sides: Sides,
    /// Nodes that these particles see here, and not in the ordinary block.
    mask: u64,
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
    /// Mass, momentum and, where they are kept apart, impulses.
    Everything,
    /// More momentum.
    Momentum,
}

/// Numbers of the arenas that exist at a time, unless all have to: 2 MiB in `f32`, four in `f64`. Memory that is used again stays in the caches; with less of it threads
/// would wait for each other more often.
const POOL: usize = 1 << 19;

/// Blocks of nodes and what the particles bring to them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid<E, const D: usize> {
    width: usize,
    /// What arenas share with the neighbours of their block, by neighbour.
    rows: Vec<Row>,
    row_ends: [usize; MOST_NEIGHBOURS],
    /// Coordinates of the blocks: ordinary ones ascending, then those of the ghosts.
    blocks: Vec<[i32; D]>,
    ghosts: Vec<Ghost>,
    /// Per block of particles, the ghosts around it; empty without any.
    ghosts_around: Vec<[u32; MOST_NEIGHBOURS]>,
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

    /// Where in an arena of velocities.
    fn in_velocities<const D: usize>(self) -> Range<usize> {
        let first = self.from as usize / NODE * gathered(D);
        first..first + self.nodes as usize * gathered(D)
    }

    /// Where the nodes of a mask are in the block and in the arena.
    fn of_mask(self, mask: u64) -> impl Iterator<Item = (usize, usize)> {
        let places = (0..self.nodes as usize)
            .map(move |k| (self.at as usize + k * NODE, self.from as usize + k * NODE));
        places.filter(move |(at, _)| mask >> (at / NODE) & 1 == 1)
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

    /// Makes the blocks around the given blocks of particles; they keep their order as arenas. `unseen` tells which nodes of a block particles of
    /// some sides do not see: they get their own.
    pub(crate) fn rebuild(
        &mut self,
        particles: impl Iterator<Item = ([i32; D], Sides)> + Clone,
        unseen: &mut dyn FnMut(&[i32; D], Sides) -> u64,
    ) {
        let count = 3_usize.pow(D as u32);
        self.blocks.clear();
        for (origin, _) in particles.clone() {
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
        for ((origin, _), arena) in particles.clone().zip(0..) {
            let mut around = [u32::MAX; MOST_NEIGHBOURS];
            for (neighbour, entry) in around.iter_mut().enumerate().take(count) {
                let block = index.get(&shifted(&origin, &offset::<D>(neighbour)));
                if let (Some(&block), true) = (block, self.is_shared(neighbour)) {
                    *entry = block;
                    reached.push((block, Source { arena, neighbour: neighbour as u8, mask: ALL }));
                }
            }
            self.neighbours.push(around);
        }
        self.split(&mut reached, &particles.map(|(_, sides)| sides).collect::<Vec<_>>(), unseen);
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

    /// Gives particles with sides nodes of their own where they do not see the ordinary ones. `sides` are by arena.
    fn split(
        &mut self,
        reached: &mut Vec<(u32, Source)>,
        sides: &[Sides],
        unseen: &mut dyn FnMut(&[i32; D], Sides) -> u64,
    ) {
        self.ghosts.clear();
        self.ghosts_around.clear();
        if sides.iter().all(|sides| *sides == NEUTRAL) {
            return;
        }
        let mut masks: BTreeMap<(u32, Sides), u64> = BTreeMap::new();
        for (block, source) in reached.iter() {
            let sides = sides[source.arena as usize];
            if sides != NEUTRAL {
                masks.entry((*block, sides)).or_insert_with(|| unseen(&self.blocks[*block as usize], sides));
            }
        }
        masks.retain(|_, mask| *mask != 0);
        let numbers: BTreeMap<(u32, Sides), u32> =
            masks.keys().copied().zip(self.blocks.len() as u32..).collect();
        for ((block, sides), mask) in &masks {
            self.blocks.push(self.blocks[*block as usize]);
            self.ghosts.push(Ghost { sides: *sides, mask: *mask });
        }
        self.ghosts_around.resize(sides.len(), [u32::MAX; MOST_NEIGHBOURS]);
        let mut more = Vec::new();
        for (block, source) in reached.iter_mut() {
            let key = (*block, sides[source.arena as usize]);
            if let (Some(&mask), Some(&ghost)) = (masks.get(&key), numbers.get(&key)) {
                more.push((ghost, Source { mask, ..*source }));
                source.mask = !mask;
                self.ghosts_around[source.arena as usize][source.neighbour as usize] = ghost;
            }
        }
        reached.extend(more);
    }

    /// The sides for which a block of nodes exists.
    pub(crate) fn sides(&self, block: usize) -> Sides {
        let first = self.blocks.len() - self.ghosts.len();
        block.checked_sub(first).map_or(NEUTRAL, |ghost| self.ghosts[ghost].sides)
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
        let ghosts = self.ghosts_around.get(particles).into_iter().flatten();
        self.neighbours[particles]
            .iter()
            .chain(ghosts)
            .filter(|block| **block != u32::MAX)
            .map(|block| *block as usize)
    }

    /// Bytes of the nodes and of what is known of their blocks.
    pub(crate) fn bytes(&self) -> usize {
        let known = std::mem::size_of_val(&self.neighbours[..]) + std::mem::size_of_val(&self.sources[..]);
        let blocks = std::mem::size_of_val(&self.blocks[..]) + std::mem::size_of_val(&self.node_ends[..]);
        std::mem::size_of_val(&self.nodes[..]) + known + blocks
    }

    /// Coordinates of the ordinary blocks of nodes, ascending.
    pub(crate) fn blocks(&self) -> &[[i32; D]] {
        &self.blocks[..self.blocks.len() - self.ghosts.len()]
    }

    /// How many blocks of nodes there are.
    pub(crate) fn block_count(&self) -> usize {
        self.blocks.len()
    }

    /// Consecutive arenas that exist at a time: their sums are taken before the next ones are filled, so that arenas stay in the caches and take no memory that
    /// grows with the particles. The same for any number of threads.
    pub(crate) fn waves(&self) -> impl Iterator<Item = Range<usize>> + use<E, D> {
        let (count, wave) = (self.neighbours.len(), self.longest_wave());
        (0..count).step_by(wave).map(move |first| first..(first + wave).min(count))
    }

    /// The most arenas that exist at a time: all waves are about as long.
    pub(crate) fn longest_wave(&self) -> usize {
        let count = self.neighbours.len();
        let waves = count.div_ceil(POOL / self.arena_stride());
        count.div_ceil(waves.max(1)).max(1)
    }

    /// Empties the nodes.
    pub(crate) fn clear(&mut self) {
        parallel::for_each_chunk(&mut self.nodes, POOL, |_, nodes| nodes.fill(E::default()));
    }

    /// Adds the arenas with the numbers `wave` to the nodes, and their impulses to the changes, in ascending order. Waves in ascending order give the same sums as all arenas
    /// at once.
    pub(crate) fn add(&mut self, arenas: &[E], wave: &Range<usize>, addition: Addition) {
        let reached = self.reached(wave);
        let (length, stride) = (self.arena_stride(), self.stride());
        let impulses = self.keeps_changes && addition == Addition::Everything;
        let (sources, ends) = (&self.sources, &self.source_ends);
        let (rows, row_ends, second) = (&self.rows, &self.row_ends, arena_length(D, self.width));
        let parts = &mut self.nodes[reached.start * stride..reached.end * stride];
        let mut nothing = vec![(); reached.len()];
        parallel::for_each_part(parts, &self.node_ends[..reached.len()], &mut nothing, |k, nodes, ()| {
            let (nodes, changes) = nodes.split_at_mut(BLOCK);
            let block = reached.start + k;
            let first = if block == 0 { 0 } else { ends[block - 1] };
            let all = &sources[first..ends[block]];
            let before = all.partition_point(|source| (source.arena as usize) < wave.start);
            for source in all[before..].iter().take_while(|source| (source.arena as usize) < wave.end) {
                let arena = &arenas[(source.arena as usize - wave.start) * length..][..length];
                let neighbour = source.neighbour as usize;
                let first = if neighbour == 0 { 0 } else { row_ends[neighbour - 1] };
                let rows = &rows[first..row_ends[neighbour]];
                add_rows(nodes, arena, rows, source.mask);
                if impulses {
                    add_rows(changes, &arena[second..], rows, source.mask);
                }
            }
        });
    }

    /// The blocks of nodes from the first to the last that some arenas reach.
    fn reached(&self, wave: &Range<usize>) -> Range<usize> {
        let blocks = wave.clone().flat_map(|arena| self.around(arena));
        let (first, end) = blocks.fold((usize::MAX, 0), |(first, end), k| (first.min(k), end.max(k + 1)));
        first.min(end)..end
    }

    /// Hands each block to `update`: its coordinates, nodes, changes (empty if they are not kept) and result.
    pub(crate) fn update<R: Send>(
        &mut self,
        results: &mut [R],
        update: impl Fn(&[i32; D], &mut [E], &mut [E], &mut R) + Sync,
    ) {
        let blocks = &self.blocks;
        parallel::for_each_part(&mut self.nodes, &self.node_ends, results, |block, nodes, result| {
            let (nodes, changes) = nodes.split_at_mut(BLOCK);
            update(&blocks[block], nodes, changes, result);
        });
    }

    /// Fills an arena with the velocities around a block of particles.
    #[inline(always)]
    pub(crate) fn fill(&self, particles: usize, arena: &mut [E]) {
        self.fill_from(particles, 0, arena, |target, node| target.copy_from_slice(of_node::<E, D>(node)));
    }

    /// Fills an arena with the velocities around a block of particles, where the nodes have momenta.
    #[inline(always)]
    pub(crate) fn fill_divided(&self, particles: usize, arena: &mut [E]) {
        self.fill_from(particles, 0, arena, |target, node| {
            target.copy_from_slice(of_node::<E, D>(node));
            let mass = node[0];
            if !mass.less_equal(E::default()) {
                for number in &mut target[gathered(D) - D..] {
                    *number /= mass;
                }
            }
        });
    }

    /// Fills an arena with the changes of velocities around a block of particles.
    #[inline(always)]
    pub(crate) fn fill_changes(&self, particles: usize, arena: &mut [E]) {
        self.fill_from(particles, BLOCK, arena, |target, node| target.copy_from_slice(of_node::<E, D>(node)));
    }

    #[inline(always)]
    fn fill_from(&self, particles: usize, first: usize, arena: &mut [E], take: impl Fn(&mut [E], &[E])) {
        for (neighbour, &block) in self.neighbours[particles].iter().enumerate().take(3_usize.pow(D as u32)) {
            if block == u32::MAX {
                continue;
            }
            let nodes = &self.nodes[block as usize * self.stride() + first..][..BLOCK];
            for row in self.rows_of(neighbour) {
                // Node by node: rows are short, and lengths that are known need no call.
                let targets = arena[row.in_velocities::<D>()].chunks_exact_mut(gathered(D));
                for (target, node) in targets.zip(nodes[row.in_block()].chunks_exact(NODE)) {
                    take(target, node);
                }
            }
        }
        if let Some(ghosts) = self.ghosts_around.get(particles) {
            self.fill_from_ghosts(ghosts, first, arena, &take);
        }
    }

    #[inline(never)]
    fn fill_from_ghosts(
        &self,
        ghosts: &[u32; MOST_NEIGHBOURS],
        first: usize,
        arena: &mut [E],
        take: &dyn Fn(&mut [E], &[E]),
    ) {
        let ordinary = self.blocks().len();
        for (neighbour, &block) in ghosts.iter().enumerate().filter(|(_, block)| **block != u32::MAX) {
            let nodes = &self.nodes[block as usize * self.stride() + first..][..BLOCK];
            let mask = self.ghosts[block as usize - ordinary].mask;
            for row in self.rows_of(neighbour) {
                for (from, to) in row.of_mask(mask) {
                    let to = to / NODE * gathered(D);
                    take(&mut arena[to..to + gathered(D)], &nodes[from..from + NODE]);
                }
            }
        }
    }
}

/// What is gathered of a node.
#[inline(always)]
fn of_node<E, const D: usize>(node: &[E]) -> &[E] {
    &node[1 + D - gathered(D)..=D]
}

/// Adds the nodes of a mask; whole rows where it holds all.
fn add_rows<E: Element>(nodes: &mut [E], arena: &[E], rows: &[Row], mask: u64) {
    for row in rows {
        if mask == ALL {
            add(&mut nodes[row.in_block()], &arena[row.in_arena()]);
            continue;
        }
        for (to, from) in row.of_mask(mask) {
            add(&mut nodes[to..to + NODE], &arena[from..from + NODE]);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of blocks whose arenas overlap, with numbers of very different sizes: in waves of any length the sums have the same bits.
    #[test]
    fn waves_sum_in_the_order_of_all_arenas() {
        let blocks = [[0, 0], [0, 1], [0, 3], [1, 1], [2, 0]];
        let sums = |wave: usize| {
            let mut grid = Grid::<f64, 2>::new(3, Changes::Kept);
            grid.rebuild(blocks.iter().map(|block| (*block, NEUTRAL)), &mut |_, _| 0);
            let stride = grid.arena_stride();
            let number =
                |k: usize| (k as f64 * 0.618_033_988_749_894_9).fract() * 10_f64.powi((k % 17) as i32);
            let arenas: Vec<f64> = (0..blocks.len() * stride).map(number).collect();
            grid.clear();
            for first in (0..blocks.len()).step_by(wave) {
                let some = first..(first + wave).min(blocks.len());
                let arenas = &arenas[some.start * stride..some.end * stride];
                grid.add(arenas, &some, Addition::Everything);
            }
            grid.nodes
        };
        let together = sums(blocks.len());
        assert!(together.iter().filter(|number| **number > 0.0).count() > 1000);
        for wave in 1..blocks.len() {
            assert!(sums(wave) == together, "waves of {wave}");
        }
    }
}
