//! What the grid does not return to particles, given to it again: one of XPIC's passes.

use super::{Body, StepSettings, arena_ends, in_arena, with_width};
use crate::neighbourhood::{
    GatherScratch, Gift, Places, Wanted, arena_length, gather, most_velocities, scatter, velocities_length,
};
use crate::particles::{Layout, load};
use crate::{Grid, Kernel};
use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch};
use mechanics_core::parallel;

impl<E: Element, const D: usize> Body<E, D> {
    /// Fills the momenta of the arenas with Σ w m (v − Σ w u), u the velocities of the grid, whose nodes have momenta; `first` is the number of the body's first
    /// arena. The impulses stay.
    pub(crate) fn correct(&self, arenas: &mut [E], grid: &Grid<E, D>, first: usize, settings: &StepSettings) {
        let particles = &self.particles;
        let count = particles.blocks.len();
        let (ends, mut nothing) = (arena_ends(count, grid.arena_stride()), vec![(); count]);
        parallel::for_each_part(arenas, &ends, &mut nothing, |block, arena, ()| {
            let placed = &particles.blocks[block];
            let start = if block == 0 { 0 } else { particles.ends[block - 1] };
            let correction = Correction {
                packs: &particles.data[start..particles.ends[block]],
                layout: &particles.layout,
                origin: placed.origin,
                count: placed.count,
                grid,
                number: first + block,
                arena,
                settings,
            };
            // Arenas on the stack are no larger than they must be, as where particles are moved.
            if D == 2 {
                correction.run_in::<{ most_velocities(2) }>();
            } else {
                correction.run_in::<{ most_velocities(3) }>();
            }
        });
    }
}

/// A block of particles and its arena.
struct Correction<'a, E, const D: usize> {
    packs: &'a [E],
    layout: &'a Layout,
    origin: [i32; D],
    count: usize,
    grid: &'a Grid<E, D>,
    /// The number of the arena.
    number: usize,
    arena: &'a mut [E],
    settings: &'a StepSettings,
}

impl<E: Element, const D: usize> Correction<'_, E, D> {
    fn run_in<const ROOM: usize>(self) {
        let mut velocities = [E::default(); ROOM];
        let width = self.settings.kernel.width();
        let velocities = &mut velocities[..velocities_length(D, width)];
        self.grid.fill_divided(self.number, velocities);
        self.arena[..arena_length(D, width)].fill(E::default());
        with_width!(self.settings.kernel, W => dispatch(CorrectionOf::<E, D, W> { work: self, velocities }));
    }
}

struct CorrectionOf<'a, E, const D: usize, const W: usize> {
    work: Correction<'a, E, D>,
    velocities: &'a [E],
}

impl<E: Element, const D: usize, const W: usize> LaneKernel<E> for CorrectionOf<'_, E, D, W> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        let Correction { packs, layout, origin, count, arena, settings, .. } = self.work;
        let arena = &mut arena[..arena_length(D, W)];
        let mut scratch = GatherScratch::<P, W>::new();
        let zero = P::constant(0.0);
        for (k, pack) in packs.chunks_exact(layout.count * P::LANES).enumerate() {
            let alive = count.saturating_sub(k * P::LANES);
            let velocity = load::<P, D>(pack, layout.velocity);
            let [mass] = load::<P, 1>(pack, layout.mass);
            let places = Places::<P, D, W>::new(&in_arena(&load(pack, 0), &origin, settings.spacing));
            let found = gather(self.velocities, &places, Wanted::Velocity, alive, &mut scratch).velocity;
            let mut momentum = [zero; D];
            for a in 0..D {
                momentum[a] = mass * (velocity[a] - found[a]);
            }
            let gift = Gift { mass: zero, momentum, affine: [[zero; D]; D], impulses: None };
            scatter(arena, &places, &gift, alive);
        }
    }
}
