//! The unknowns: velocities of the nodes with mass, D numbers each, in the order of the grid.

use crate::Grid;
use crate::grid::{BLOCK, Fields};
use crate::neighbourhood::{NODE, block_edge};
use mechanics_core::lanes::Element;
use mechanics_core::parallel;

/// The nodes with mass.
pub(crate) struct Nodes<const D: usize> {
    /// \[kg\].
    pub(super) masses: Vec<f64>,
    /// v̂, the velocities without stress and without boundaries, D numbers a node.
    pub(super) forecast: Vec<f64>,
    /// Where they are \[m\].
    pub(crate) places: Vec<[f64; D]>,
    /// Where their numbers are in their block.
    at: Vec<u16>,
    /// Ends of the blocks among the unknowns.
    ends: Vec<usize>,
    field: Vec<f64>,
    field_ends: Vec<usize>,
    unit: Vec<()>,
}

impl<const D: usize> Nodes<D> {
    /// From the masses and velocities of a grid.
    pub(super) fn new<E: Element>(grid: &Grid<E, D>, spacing: f64) -> Self {
        let count = grid.block_count();
        let mut nodes = Self {
            masses: Vec::new(),
            forecast: Vec::new(),
            places: Vec::new(),
            at: Vec::new(),
            ends: Vec::new(),
            field: vec![0.0; count * BLOCK],
            field_ends: (1..=count).map(|k| k * BLOCK).collect(),
            unit: vec![(); count],
        };
        let edge = block_edge(D);
        for (origin, block) in grid.nodes_by_block() {
            for (k, node) in block.chunks_exact(NODE).enumerate() {
                let mass: f64 = node[0].into();
                if mass > 0.0 {
                    nodes.masses.push(mass);
                    nodes.forecast.extend(node[1..=D].iter().map(|v| Into::<f64>::into(*v)));
                    nodes.at.push((k * NODE) as u16);
                    nodes.places.push(std::array::from_fn(|axis| {
                        let local = k / edge.pow((D - 1 - axis) as u32) % edge;
                        (f64::from(origin[axis]) * edge as f64 + local as f64) * spacing
                    }));
                }
            }
            nodes.ends.push(nodes.masses.len() * D);
        }
        nodes
    }

    /// How many nodes there are.
    pub(super) fn count(&self) -> usize {
        self.masses.len()
    }

    fn first(&self, block: usize) -> usize {
        if block == 0 { 0 } else { self.ends[block - 1] / D }
    }

    /// The velocities as a field on the grid.
    pub(super) fn expanded(&mut self, velocities: &[f64]) -> &[f64] {
        let (mut field, mut unit) = (std::mem::take(&mut self.field), std::mem::take(&mut self.unit));
        parallel::for_each_part(&mut field, &self.field_ends, &mut unit, |block, nodes, ()| {
            for k in self.first(block)..self.ends[block] / D {
                let at = usize::from(self.at[k]) + 1;
                nodes[at..at + D].copy_from_slice(&velocities[k * D..(k + 1) * D]);
            }
        });
        (self.field, self.unit) = (field, unit);
        &self.field
    }

    /// Adds what arenas bring to the nodes.
    pub(super) fn add_arenas(&mut self, grid: &dyn Fields, arenas: &[f64], vector: &mut [f64]) {
        let mut unit = std::mem::take(&mut self.unit);
        parallel::for_each_part(vector, &self.ends, &mut unit, |block, part, ()| {
            let mut sums = [0.0; BLOCK];
            grid.add_arenas(block, arenas, &mut sums);
            let active = &self.at[self.first(block)..self.ends[block] / D];
            for (target, at) in part.chunks_exact_mut(D).zip(active) {
                for axis in 0..D {
                    target[axis] += sums[usize::from(*at) + 1 + axis];
                }
            }
        });
        self.unit = unit;
    }

    /// All four numbers that arenas bring to each node.
    pub(super) fn sums(&self, grid: &dyn Fields, arenas: &[f64]) -> Vec<[f64; NODE]> {
        let parts = parallel::map_chunks(self.ends.len(), 1, |blocks| {
            let mut found = Vec::new();
            for block in blocks {
                let mut sums = [0.0; BLOCK];
                grid.add_arenas(block, arenas, &mut sums);
                for at in &self.at[self.first(block)..self.ends[block] / D] {
                    found.push(std::array::from_fn(|c| sums[usize::from(*at) + c]));
                }
            }
            found
        });
        parts.into_iter().flatten().collect()
    }

    /// Gives the velocities to the nodes of the grid; what is kept beside them becomes the change from it.
    pub(crate) fn write<E: Element>(&self, grid: &mut Grid<E, D>, velocities: &[f64]) {
        grid.for_each_block(|block, nodes, changes| {
            for k in self.first(block)..self.ends[block] / D {
                let at = usize::from(self.at[k]) + 1;
                for axis in 0..D {
                    nodes[at + axis] = E::constant(velocities[k * D + axis]);
                }
            }
            for (change, node) in changes.iter_mut().zip(nodes.iter()) {
                *change = *node - *change;
            }
        });
    }
}
