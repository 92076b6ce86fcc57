//! What particles give to the nodes: in waves, and for XPIC again what the grid does not yet return to them; see [`Transfer`](crate::Transfer).

use super::Simulation;
use crate::body::{Body, StepSettings};
use crate::grid::Addition;
use crate::material::Stiffness;
use mechanics_core::lanes::Element;
use std::ops::Range;

/// Fills the arenas, one every so many numbers, of some blocks of a body's particles.
pub(super) type Fill<'a, E, const D: usize> =
    dyn FnMut(&mut Body<E, D>, Range<usize>, (&mut [E], usize)) -> Stiffness + 'a;

impl<E: Element, const D: usize> Simulation<E, D> {
    /// Sums what `fill` makes of all particles into the nodes, in ascending order of their blocks.
    pub(super) fn scatter(&mut self, fill: &mut Fill<'_, E, D>) -> Stiffness {
        let stride = self.grid.arena_stride();
        let mut stiffness = Stiffness::default();
        self.grid.clear();
        for wave in self.grid.waves() {
            let mut first = 0;
            for body in &mut self.bodies {
                let count = body.particles.blocks.len();
                let some = wave.start.max(first)..wave.end.min(first + count);
                if !some.is_empty() {
                    let arenas = (some.start - wave.start) * stride..(some.end - wave.start) * stride;
                    let blocks = some.start - first..some.end - first;
                    stiffness = stiffness.merged(fill(body, blocks, (&mut self.arenas[arenas], stride)));
                }
                first += count;
            }
            self.grid.add(&self.arenas, &wave, Addition::Everything);
        }
        stiffness
    }

    /// Makes the momenta of the nodes those of v*, where the transfer takes more than one pass.
    pub(super) fn filter(&mut self, settings: &StepSettings) {
        let stride = self.grid.arena_stride();
        for _ in 0..settings.transfer.passes() {
            let mut first = 0;
            for body in &self.bodies {
                let count = body.particles.blocks.len();
                let arenas = &mut self.arenas[first * stride..(first + count) * stride];
                body.correct(arenas, &self.grid, first, settings);
                first += count;
            }
            self.grid.add(&self.arenas, &(0..first), Addition::Momentum);
        }
    }
}
