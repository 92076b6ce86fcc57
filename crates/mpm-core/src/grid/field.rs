//! Fields on the nodes beside the grid's own, in double precision: four numbers a node, block by block.

use super::{BLOCK, Grid, of_node};
use crate::neighbourhood::{NODE, arena_length, gathered};
use mechanics_core::lanes::Element;

/// Which nodes arenas share: a grid without its numbers, whatever their precision.
pub(crate) trait Fields: Sync {
    /// Fills an arena of velocities with the numbers of a field around a block of particles; what no block covers is left.
    fn fill_from_field(&self, particles: usize, field: &[f64], arena: &mut [f64]);

    /// Adds what arenas, one after the other, bring to the nodes of a block, in ascending order of arenas.
    fn add_arenas(&self, block: usize, arenas: &[f64], nodes: &mut [f64]);
}

impl<E: Element, const D: usize> Fields for Grid<E, D> {
    fn fill_from_field(&self, particles: usize, field: &[f64], arena: &mut [f64]) {
        for (neighbour, &block) in self.neighbours[particles].iter().enumerate().take(3_usize.pow(D as u32)) {
            if block == u32::MAX {
                continue;
            }
            let nodes = &field[block as usize * BLOCK..][..BLOCK];
            for row in self.rows_of(neighbour) {
                let targets = arena[row.in_velocities::<D>()].chunks_exact_mut(gathered(D));
                for (target, node) in targets.zip(nodes[row.in_block()].chunks_exact(NODE)) {
                    target.copy_from_slice(of_node::<f64, D>(node));
                }
            }
        }
    }

    fn add_arenas(&self, block: usize, arenas: &[f64], nodes: &mut [f64]) {
        let length = arena_length(D, self.width);
        let first = if block == 0 { 0 } else { self.source_ends[block - 1] };
        for source in &self.sources[first..self.source_ends[block]] {
            let arena = &arenas[source.arena as usize * length..][..length];
            for row in self.rows_of(source.neighbour as usize) {
                super::add(&mut nodes[row.in_block()], &arena[row.in_arena()]);
            }
        }
    }
}

impl<E: Element, const D: usize> Grid<E, D> {
    /// Coordinates and nodes (m, v) of every block.
    pub(crate) fn nodes_by_block(&self) -> impl Iterator<Item = (&[i32; D], &[E])> {
        self.blocks.iter().zip(self.nodes.chunks_exact(self.stride())).map(|(o, nodes)| (o, &nodes[..BLOCK]))
    }

    /// Hands each block's number, nodes and changes (empty if they are not kept) to `update`.
    pub(crate) fn for_each_block(&mut self, mut update: impl FnMut(usize, &mut [E], &mut [E])) {
        let stride = self.stride();
        for (block, nodes) in self.nodes.chunks_exact_mut(stride).enumerate() {
            let (nodes, changes) = nodes.split_at_mut(BLOCK);
            update(block, nodes, changes);
        }
    }
}
