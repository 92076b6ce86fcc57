//! A body: particles of one material, and what one step does to them.

mod correction;

use crate::collider::Sides;
use crate::forecast::{Domain, SAFE_STIFFENING, Span};
use crate::implicit::StepLaw;
use crate::material::{CHUNK, Material, PointState, Stiffness, largest, largest_lane};
use crate::neighbourhood::{
    DRIFT, GatherScratch, Gift, Places, Wanted, arena_length, block_edge, gather, most_velocities, scatter,
    velocities_length,
};
use crate::particles::{FREE, Layout, ParticleBlock, Particles, at, load, store};
use crate::traction::{Piece, Place};
use crate::{Grid, Kernel, MpmError, Transfer, kernel};
use mechanics_core::lanes::{Element, LaneKernel, MOST_LANES, Packet, Pair, dispatch, prefetch_beyond};
use mechanics_core::parallel;
use mechanics_core::scalar::Mask;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::PointLawError;
use std::ops::Range;

/// What stays the same during a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepSettings {
    /// h \[s\].
    pub(crate) step: f64,
    /// Δx \[m\].
    pub(crate) spacing: f64,
    pub(crate) kernel: Kernel,
    pub(crate) transfer: Transfer,
}

/// What particles did in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Travel {
    /// The square of the largest speed \[m²/s²\].
    pub(crate) speed_squared: f64,
    /// The square of the largest Frobenius norm of the velocity gradient [1/s²].
    pub(crate) rate_squared: f64,
    /// Whether a particle has left the reach of its block, or is nowhere (NaN).
    pub(crate) left: bool,
}

impl Travel {
    /// The larger of everything.
    pub(crate) fn merged(self, other: Self) -> Self {
        Self {
            speed_squared: largest(self.speed_squared, other.speed_squared),
            rate_squared: largest(self.rate_squared, other.rate_squared),
            left: self.left || other.left,
        }
    }
}

/// Particles of one material.
pub(crate) struct Body<E: Element, const D: usize> {
    material: Box<dyn Material<E, D>>,
    pub(crate) particles: Particles<E, D>,
    stiffness: Vec<Stiffness>,
    travel: Vec<Travel>,
    /// Stiffness of virgin material.
    virgin: f64,
    pub(crate) pieces: Vec<Piece<D>>,
}

/// Runs a kernel's work with its width as a constant.
macro_rules! with_width {
    ($kernel:expr, $width:ident => $work:expr) => {
        match $kernel {
            Kernel::Linear => {
                const $width: usize = 2;
                $work
            }
            Kernel::Quadratic => {
                const $width: usize = 3;
                $work
            }
            Kernel::Cubic => {
                const $width: usize = 4;
                $work
            }
        }
    };
}

use with_width;

impl<E: Element, const D: usize> Body<E, D> {
    pub(crate) fn new(material: Box<dyn Material<E, D>>, particles: Particles<E, D>) -> Self {
        // All particles are virgin: the first pack tells.
        let mut stress = [E::default(); CHUNK * 9 * MOST_LANES];
        let virgin = material.stress_into(&particles.data[..particles.pack_length()], &mut stress).expansion;
        Self { material, particles, stiffness: Vec::new(), travel: Vec::new(), virgin, pieces: Vec::new() }
    }

    /// Fills the arenas of some blocks of particles, one every `stride` numbers, with mass, momentum and the impulses of stress.
    pub(crate) fn scatter(
        &mut self,
        some: Range<usize>,
        (arenas, stride): (&mut [E], usize),
        settings: &StepSettings,
    ) -> Stiffness {
        let particles = &self.particles;
        let pack = particles.pack_length();
        self.stiffness.resize(particles.blocks.len(), Stiffness::default());
        let found = &mut self.stiffness[some.clone()];
        let material = &*self.material;
        parallel::for_each_part(arenas, &arena_ends(some.len(), stride), found, |k, arena, stiffness| {
            let block = some.start + k;
            *stiffness = Stiffness::default();
            let placed = &particles.blocks[block];
            let first = if block == 0 { 0 } else { particles.ends[block - 1] };
            arena.fill(E::default());
            let mut stress = [E::default(); CHUNK * 9 * MOST_LANES];
            for (k, packs) in particles.data[first..particles.ends[block]].chunks(CHUNK * pack).enumerate() {
                *stiffness = stiffness.merged(material.stress_into(packs, &mut stress));
                let scatter = Scatter {
                    packs,
                    stress: &stress,
                    layout: &particles.layout,
                    origin: placed.origin,
                    count: placed.count - k * CHUNK * E::LANES,
                    arena,
                    settings,
                };
                with_width!(settings.kernel, W => match settings.transfer.uses_gradients() {
                    true => dispatch(ScatterOf::<E, D, W, true>(scatter)),
                    false => dispatch(ScatterOf::<E, D, W, false>(scatter)),
                });
            }
        });
        self.add_tractions(some.clone(), (arenas, stride), settings);
        self.stiffness[some].iter().fold(Stiffness::default(), |all, one| all.merged(*one))
    }

    /// Adds the impulses of the loaded pieces of the surface of some blocks.
    pub(crate) fn add_tractions(
        &self,
        some: Range<usize>,
        (arenas, stride): (&mut [E], usize),
        settings: &StepSettings,
    ) {
        let place = Place { kernel: settings.kernel, spacing: settings.spacing, step: settings.step };
        let first = place.first_impulse::<D>(settings.transfer);
        let blocks = &self.particles.blocks;
        let start = if some.start == 0 { 0 } else { blocks[some.start - 1].end * E::LANES };
        let slots = start..blocks[some.end - 1].end * E::LANES;
        for piece in self.pieces.iter().filter(|piece| slots.contains(&(piece.slot as usize))) {
            let slot = piece.slot as usize;
            let block = blocks.partition_point(|block| block.end * E::LANES <= slot);
            let arena = &mut arenas[(block - some.start) * stride + first..][..stride - first];
            let deformation = if piece.traction.follows() { self.total_deformation(slot) } else { None };
            let origin = &self.particles.blocks[block].origin;
            piece.add_impulse(arena, &self.position(slot), origin, deformation.as_ref(), &place);
        }
    }

    /// Sorts the particles; the pieces of the surface follow theirs.
    pub(crate) fn sort(
        &mut self,
        body: usize,
        spacing: f64,
        width: usize,
        sides: &[Sides],
    ) -> Result<(), MpmError> {
        self.particles.sort(body, spacing, width, sides)?;
        self.place_pieces();
        Ok(())
    }

    /// Finds the particles of the pieces in memory.
    pub(crate) fn place_pieces(&mut self) {
        if !self.pieces.is_empty() {
            let slots = self.particles.slots();
            for piece in &mut self.pieces {
                piece.slot = slots[piece.particle as usize];
            }
        }
    }

    /// n, where stiffness grows as J⁻ⁿ.
    pub(crate) fn stiffening(&self) -> f64 {
        self.material.stiffening()
    }

    /// The law of an implicit step.
    pub(crate) fn step_law(&self) -> &dyn StepLaw {
        self.material.step_law()
    }

    /// Where the particle in a slot is \[m\].
    pub(crate) fn position(&self, slot: usize) -> [f64; D] {
        std::array::from_fn(|axis| self.particles.number(slot, axis).into())
    }

    /// The total deformation gradient of the particle in a slot, if it is known.
    pub(crate) fn total_deformation(&self, slot: usize) -> Option<Mat3> {
        self.material.total_deformation(&|k| self.particles.number(slot, k).into())
    }

    /// Takes velocities from the grid, moves and deforms the particles. `first` is the number of the body's first arena.
    pub(crate) fn gather(&mut self, grid: &Grid<E, D>, first: usize, settings: &StepSettings) -> Travel {
        let Particles { data, ends, blocks, layout, .. } = &mut self.particles;
        let (blocks, layout) = (&*blocks, &*layout);
        self.travel.clear();
        self.travel.resize(blocks.len(), Travel::default());
        let material = &*self.material;
        parallel::for_each_part(data, ends, &mut self.travel, |block, packs, travel| {
            let mover =
                Mover { material, grid, arena: first + block, placed: &blocks[block], layout, settings };
            *travel = mover.run(packs);
        });
        self.travel.iter().fold(Travel::default(), |all, one| all.merged(*one))
    }

    /// What the gather would do to the first particle, by its number, that it would leave in no admissible state; see the module
    /// `forecast`. `spans` are the velocities of the blocks of nodes.
    pub(crate) fn foresee(&self, trial: &Trial<'_, E, D>) -> Option<(usize, MpmError)> {
        let blocks = &self.particles.blocks;
        let risky: Vec<usize> = (0..blocks.len()).filter(|block| !self.is_safe(*block, trial)).collect();
        let found = parallel::map_chunks(risky.len(), 1, |range| {
            range.filter_map(|k| self.first_harmed(risky[k], trial)).min_by_key(|(particle, _)| *particle)
        });
        found.into_iter().flatten().min_by_key(|(particle, _)| *particle)
    }

    fn is_safe(&self, block: usize, trial: &Trial<'_, E, D>) -> bool {
        let around = trial.grid.around(trial.first + block);
        let span = around.fold(Span::default(), |all, k| all.merged(&trial.spans[k]));
        let stiffness = self.stiffness[block].expansion;
        if !(span.deforms_safely(trial.settings) && stiffness <= SAFE_STIFFENING * self.virgin) {
            return false;
        }
        let mut reach = span.reach(trial.settings.step);
        if trial.settings.transfer.position_part().is_some() {
            let stray = span.stray(&self.velocities_of(block), trial.settings.step);
            for axis in 0..D {
                reach[axis] += stray[axis];
            }
        }
        let (low, high) = self.cells_of(block, trial.settings.spacing);
        if trial.domain.holds(&low, &high, &reach) {
            return true;
        }
        let inside = |slot: usize| {
            let position = self.position(slot);
            trial.domain.holds(&position, &position, &reach)
        };
        self.slots_of(block).all(inside)
    }

    /// The corners of the space where particles of a block are until they are sorted anew \[m\].
    pub(crate) fn cells_of(&self, block: usize, spacing: f64) -> ([f64; D], [f64; D]) {
        let origin = self.particles.blocks[block].origin;
        let edge = block_edge(D) as f64;
        // Particles are up to two nodes above their lowest one.
        let margin = DRIFT as f64 + 3.0;
        let low = origin.map(|o| (f64::from(o) * edge - margin) * spacing);
        (low, origin.map(|o| ((f64::from(o) + 1.0) * edge + margin) * spacing))
    }

    /// The largest velocity components of the particles of a block \[m/s\].
    fn velocities_of(&self, block: usize) -> [f64; D] {
        let first = self.particles.layout.velocity;
        self.slots_of(block).fold([0.0; D], |most, slot| {
            std::array::from_fn(|a| largest(most[a], self.particles.number(slot, first + a).into().abs()))
        })
    }

    /// Slots of the particles of a block.
    pub(crate) fn slots_of(&self, block: usize) -> Range<usize> {
        let first = if block == 0 { 0 } else { self.particles.blocks[block - 1].end * E::LANES };
        first..first + self.particles.blocks[block].count
    }

    /// Moves a copy of a block, and answers its first particle that comes to harm.
    fn first_harmed(&self, block: usize, trial: &Trial<'_, E, D>) -> Option<(usize, MpmError)> {
        let Particles { data, ends, blocks, layout, ids, .. } = &self.particles;
        let first = if block == 0 { 0 } else { ends[block - 1] };
        let mut packs = data[first..ends[block]].to_vec();
        let Trial { grid, settings, .. } = *trial;
        let arena = trial.first + block;
        let material = &*self.material;
        let _travel =
            Mover { material, grid, arena, placed: &blocks[block], layout, settings }.run(&mut packs);
        let slots = self.slots_of(block);
        let start = slots.start;
        slots
            .filter_map(|slot| {
                let number = |k: usize| -> f64 { packs[at(layout, slot - start, k, E::LANES)].into() };
                let particle = ids[slot] as usize;
                let error = self.refused(trial.body, particle, &number).or_else(|| {
                    let position: [f64; D] = std::array::from_fn(number);
                    trial.domain.check(trial.body, particle, &position).err()
                });
                error.map(|error| (particle, error))
            })
            .min_by_key(|(particle, _)| *particle)
    }

    /// Stiffness and motion of the particles as they are.
    pub(crate) fn limits(&self) -> (Stiffness, Travel) {
        let layout = &self.particles.layout;
        let pack = self.particles.pack_length();
        let mut stress = [E::default(); CHUNK * 9 * MOST_LANES];
        let stiffness = self.particles.data.chunks(CHUNK * pack).fold(Stiffness::default(), |all, packs| {
            all.merged(self.material.stress_into(packs, &mut stress))
        });
        let square = |slot: usize, numbers: Range<usize>| {
            numbers.map(|k| Into::<f64>::into(self.particles.number(slot, k)).powi(2)).sum()
        };
        let travel = self.live_slots().fold(Travel::default(), |all, slot| {
            all.merged(Travel {
                speed_squared: square(slot, layout.velocity..layout.gradient),
                rate_squared: square(slot, layout.gradient..layout.strain),
                left: false,
            })
        });
        (stiffness, travel)
    }

    /// The first particle, by its number, whose numbers are not finite or whose strain its law refuses; `body` is this body's number.
    pub(crate) fn first_inadmissible(&self, body: usize) -> Option<MpmError> {
        self.live_slots()
            .filter_map(|slot| {
                let particle = self.particles.ids[slot] as usize;
                let number = |k: usize| -> f64 { self.particles.number(slot, k).into() };
                self.refused(body, particle, &number).map(|error| (particle, error))
            })
            .min_by_key(|(particle, _)| *particle)
            .map(|(_, error)| error)
    }

    /// What is wrong with a particle of these numbers.
    fn refused(&self, body: usize, particle: usize, number: &dyn Fn(usize) -> f64) -> Option<MpmError> {
        let layout = &self.particles.layout;
        let named = [
            ("position", 0..layout.velocity),
            ("velocity", layout.velocity..layout.gradient),
            ("velocity gradient", layout.gradient..layout.strain),
        ];
        for (what, numbers) in named {
            if let Some(value) = numbers.map(number).find(|x| !x.is_finite()) {
                return Some(MpmError::Particle { body, particle, what, value, wanted: "finite" });
            }
        }
        if let Err(source) = self.material.check(&number) {
            return Some(MpmError::Law { body, particle, source });
        }
        let named =
            [("stress", layout.stress..layout.mass), ("total deformation", layout.total..layout.count)];
        for (what, numbers) in named {
            if let Some(value) = numbers.map(number).find(|x| !x.is_finite()) {
                return Some(MpmError::Particle { body, particle, what, value, wanted: "finite" });
            }
        }
        None
    }

    /// Whether the law is defined where virgin material is deformed by this gradient.
    pub(crate) fn check_deformation(&self, gradient: &Mat3) -> Result<(), PointLawError> {
        let numbers = self.material.deformed(gradient);
        let number = |k: usize| numbers.iter().find(|(at, _)| *at == k).map_or(0.0, |(_, value)| *value);
        self.material.check(&number)
    }

    /// Deforms the virgin particle in a slot.
    pub(crate) fn deform(&mut self, slot: usize, gradient: &Mat3) {
        for (k, value) in self.material.deformed(gradient) {
            self.particles.set_number(slot, k, E::constant(value));
        }
    }

    /// The state of the particle in a slot.
    pub(crate) fn state(&self, slot: usize) -> PointState {
        self.material.state(&|k| self.particles.number(slot, k).into())
    }

    /// Stored energy per rest volume of the particle in a slot \[J/m³\].
    pub(crate) fn energy_density(&self, slot: usize) -> f64 {
        self.material.energy_density(&|k| self.particles.number(slot, k).into())
    }

    pub(crate) fn live_slots(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.particles.ids.len()).filter(|slot| self.particles.ids[*slot] != FREE)
    }
}

/// A step that is about to be made.
pub(crate) struct Trial<'a, E, const D: usize> {
    /// The body's number.
    pub(crate) body: usize,
    pub(crate) grid: &'a Grid<E, D>,
    /// The number of the body's first arena.
    pub(crate) first: usize,
    /// Velocities of the blocks of nodes.
    pub(crate) spans: &'a [Span<D>],
    pub(crate) domain: &'a Domain<D>,
    pub(crate) settings: &'a StepSettings,
}

/// Moves and deforms the particles of one block.
struct Mover<'a, E: Element, const D: usize> {
    material: &'a dyn Material<E, D>,
    grid: &'a Grid<E, D>,
    arena: usize,
    placed: &'a ParticleBlock<D>,
    layout: &'a Layout,
    settings: &'a StepSettings,
}

impl<E: Element, const D: usize> Mover<'_, E, D> {
    fn run(&self, packs: &mut [E]) -> Travel {
        // Arenas on the stack, which are in the first cache, and no larger than they must be: they are filled with zeros first.
        match (D, self.settings.kernel) {
            (2, _) => self.run_in::<{ most_velocities(2) }>(packs),
            (_, Kernel::Cubic) => self.run_in::<{ most_velocities(3) }>(packs),
            _ => self.run_in::<{ velocities_length(3, 3) }>(packs),
        }
    }

    fn run_in<const ROOM: usize>(&self, packs: &mut [E]) -> Travel {
        let mut arena = [E::default(); ROOM];
        let length = velocities_length(D, self.settings.kernel.width());
        self.grid.fill(self.arena, &mut arena[..length]);
        if self.settings.transfer.flip_part().is_none() {
            return self.move_with(packs, &arena[..length], &[]);
        }
        let mut changes = [E::default(); ROOM];
        self.grid.fill_changes(self.arena, &mut changes[..length]);
        self.move_with(packs, &arena[..length], &changes[..length])
    }

    fn move_with(&self, packs: &mut [E], arena: &[E], changes: &[E]) -> Travel {
        let Self { material, placed, layout, settings, .. } = *self;
        let pack = layout.count * E::LANES;
        let mut gradients = [E::default(); CHUNK * 9 * MOST_LANES];
        let mut ratios = [E::default(); CHUNK * MOST_LANES];
        let strays = settings.transfer.position_part().is_some();
        let mut travel = Travel::default();
        for (k, packs) in packs.chunks_mut(CHUNK * pack).enumerate() {
            if strays {
                material.volume_ratios_into(packs, &mut ratios);
            }
            let gather = Gather {
                packs: &mut *packs,
                gradients: &mut gradients,
                layout,
                origin: placed.origin,
                count: placed.count - k * CHUNK * E::LANES,
                arena,
                changes,
                ratios: &ratios,
                settings,
            };
            travel =
                travel.merged(with_width!(settings.kernel, W => match settings.transfer.uses_gradients() {
                    true => dispatch(GatherOf::<E, D, W, true>(gather)),
                    false => dispatch(GatherOf::<E, D, W, false>(gather)),
                }));
            material.deform(packs, &gradients, settings.step);
        }
        travel
    }
}

/// Where each of so many arenas ends.
fn arena_ends(count: usize, stride: usize) -> Vec<usize> {
    (1..=count).map(|k| k * stride).collect()
}

/// Positions relative to the lowest node of the arena \[cells\].
#[inline(always)]
pub(crate) fn in_arena<P: Packet, const D: usize>(
    position: &[P; D],
    origin: &[i32; D],
    spacing: f64,
) -> [P; D] {
    let edge = block_edge(D) as f64;
    let mut cells = *position;
    for axis in 0..D {
        let lowest = f64::from(origin[axis]) * edge - DRIFT as f64;
        cells[axis] = position[axis].mul_add(P::constant(1.0 / spacing), P::constant(-lowest));
    }
    cells
}

/// D² numbers of a pack, by column.
#[inline(always)]
fn matrix<P: Packet, const D: usize>(pack: &[P::Element], first: usize) -> [[P; D]; D] {
    let mut matrix = [[P::constant(0.0); D]; D];
    for axis in 0..D {
        matrix[axis] = load::<P, D>(pack, first + axis * D);
    }
    matrix
}

/// Adds some packs to their block's arena.
struct Scatter<'a, E, const D: usize> {
    packs: &'a [E],
    /// τ V₀, D² numbers a pack.
    stress: &'a [E],
    layout: &'a Layout,
    origin: [i32; D],
    /// Particles from the first of these packs on.
    count: usize,
    arena: &'a mut [E],
    settings: &'a StepSettings,
}

struct ScatterOf<'a, E, const D: usize, const W: usize, const GRADIENTS: bool>(Scatter<'a, E, D>);

impl<E: Element, const D: usize, const W: usize, const GRADIENTS: bool> LaneKernel<E>
    for ScatterOf<'_, E, D, W, GRADIENTS>
{
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        let Scatter { packs, stress, layout, origin, count, arena, settings } = self.0;
        let moment = settings.kernel.second_moment().unwrap_or(f64::INFINITY);
        // The impulse of stress: by true gradients per cell, or in the affine momentum by moving least squares.
        let impulse = if GRADIENTS { 1.0 } else { 1.0 / moment };
        let impulse = P::constant(-settings.step * impulse / settings.spacing);
        let packs = packs.chunks_exact(layout.count * P::LANES);
        for (k, (pack, stress)) in packs.zip(stress.chunks_exact(D * D * P::LANES)).enumerate() {
            prefetch_beyond(pack, CHUNK * pack.len());
            let position = load::<P, D>(pack, 0);
            let velocity = load::<P, D>(pack, layout.velocity);
            let [mass] = load::<P, 1>(pack, layout.mass);
            let places = Places::<P, D, W>::new(&in_arena(&position, &origin, settings.spacing));
            let mut impulses = matrix::<P, D>(stress, 0);
            for axis in 0..D {
                for a in 0..D {
                    impulses[axis][a] *= impulse;
                }
            }
            let mut affine = [[P::constant(0.0); D]; D];
            if let Some(symmetric) = settings.transfer.affine_part() {
                affine = affine_momentum(pack, layout, mass.scale(settings.spacing), symmetric);
            }
            if !GRADIENTS {
                for axis in 0..D {
                    for a in 0..D {
                        affine[axis][a] += impulses[axis][a];
                    }
                }
            }
            let mut momentum = [P::constant(0.0); D];
            for a in 0..D {
                momentum[a] = mass * velocity[a];
                for axis in 0..D {
                    momentum[a] = (-places.fraction[axis]).mul_add(affine[axis][a], momentum[a]);
                }
            }
            let alive = count - k * P::LANES;
            let impulses = if GRADIENTS { Some(impulses) } else { None };
            // Moving least squares keep nothing apart.
            if GRADIENTS && settings.transfer.keeps_impulses() {
                // Momenta before forces, and impulses, apart: their difference is what particles take.
                let (before, after) = arena.split_at_mut(arena_length(D, W));
                scatter(before, &places, &Gift { mass, momentum, affine, impulses: None }, alive);
                let zero = P::constant(0.0);
                let (momentum, affine) = ([zero; D], [[zero; D]; D]);
                scatter(after, &places, &Gift { mass: zero, momentum, affine, impulses }, alive);
            } else {
                scatter(arena, &places, &Gift { mass, momentum, affine, impulses }, alive);
            }
        }
    }
}

/// By column, `factor` · (C + (s − 1) sym C) = `factor` · (½(1 + s) C + ½(s − 1) Cᵀ).
#[inline(always)]
fn affine_momentum<P: Packet, const D: usize>(
    pack: &[P::Element],
    layout: &Layout,
    factor: P,
    symmetric: f64,
) -> [[P; D]; D] {
    let c = matrix::<P, D>(pack, layout.gradient);
    let (plain, turned) = (factor.scale(0.5 + 0.5 * symmetric), factor.scale(0.5 * symmetric - 0.5));
    let mut affine = c;
    for axis in 0..D {
        for a in 0..D {
            affine[axis][a] = plain.mul_add(c[axis][a], turned * c[a][axis]);
        }
    }
    affine
}

/// J below this is matter under compression, which moves with the grid: the threshold of Fei et al. (2021), ln J < −0.001.
const COMPRESSED: f64 = 0.999;

/// Moves some packs with the velocities of their block's arena.
struct Gather<'a, E, const D: usize> {
    packs: &'a mut [E],
    /// ∇v, D² numbers a pack: what laws read.
    gradients: &'a mut [E],
    layout: &'a Layout,
    origin: [i32; D],
    /// Particles from the first of these packs on.
    count: usize,
    arena: &'a [E],
    changes: &'a [E],
    /// J, a number a pack, where particles move with velocities of their own.
    ratios: &'a [E],
    settings: &'a StepSettings,
}

struct GatherOf<'a, E, const D: usize, const W: usize, const GRADIENTS: bool>(Gather<'a, E, D>);

impl<E: Element, const D: usize, const W: usize, const GRADIENTS: bool> LaneKernel<E>
    for GatherOf<'_, E, D, W, GRADIENTS>
{
    type Output = Travel;

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> Travel {
        let Gather { packs, gradients, layout, origin, count, arena, changes, ratios, settings } = self.0;
        let step = P::constant(settings.step);
        let to_affine = 1.0 / (settings.kernel.second_moment().unwrap_or(f64::INFINITY) * settings.spacing);
        let keeps_affine = settings.transfer.affine_part().is_some();
        let wanted = if GRADIENTS { Wanted::Slopes } else { Wanted::Moments };
        let reach = P::constant((block_edge(D) - 1 + 2 * DRIFT) as f64);
        let (mut speed, mut rate) = (P::constant(0.0), P::constant(0.0));
        let mut left = false;
        let mut scratch = GatherScratch::<P, W>::new();
        let packs = packs.chunks_exact_mut(layout.count * P::LANES);
        for (k, (pack, gradient)) in packs.zip(gradients.chunks_exact_mut(D * D * P::LANES)).enumerate() {
            prefetch_beyond(pack, CHUNK * pack.len());
            let alive = count - k * P::LANES;
            let mut position = load::<P, D>(pack, 0);
            let places = Places::<P, D, W>::new(&in_arena(&position, &origin, settings.spacing));
            let sums = gather(arena, &places, wanted, alive, &mut scratch);
            let mut velocity = sums.velocity;
            if let Some(part) = settings.transfer.flip_part().filter(|_| GRADIENTS) {
                let before = load::<P, D>(pack, layout.velocity);
                let change = gather(changes, &places, Wanted::Velocity, alive, &mut scratch).velocity;
                for a in 0..D {
                    velocity[a] = (before[a] + change[a]).scale(part) + velocity[a].scale(1.0 - part);
                }
                if let Some(part) = settings.transfer.position_part() {
                    let ratio = P::load(&ratios[k * P::LANES..][..P::LANES]);
                    let mut expansion = P::constant(0.0);
                    for a in 0..D {
                        expansion += sums.slopes[a][a];
                    }
                    let after =
                        ratio * expansion.mul_add(step.scale(1.0 / settings.spacing), P::constant(1.0));
                    let compressed = after.less(P::constant(COMPRESSED));
                    let part = P::select(compressed, P::constant(0.0), step.scale(part));
                    for a in 0..D {
                        position[a] = part.mul_add(velocity[a] - sums.velocity[a], position[a]);
                    }
                }
            }
            for axis in 0..D {
                position[axis] = step.mul_add(sums.velocity[axis], position[axis]);
            }
            let (mut square, mut norm) = (P::constant(0.0), P::constant(0.0));
            for axis in 0..D {
                square = velocity[axis].mul_add(velocity[axis], square);
                for a in 0..D {
                    // C, from moments about the particle; or the true gradient.
                    let moment = (-places.fraction[axis]).mul_add(sums.velocity[a], sums.moments[axis][a]);
                    let affine = moment.scale(to_affine);
                    let slope =
                        if GRADIENTS { sums.slopes[axis][a].scale(1.0 / settings.spacing) } else { affine };
                    let kept = if keeps_affine { affine } else { slope };
                    norm = slope.mul_add(slope, norm);
                    slope.store(&mut gradient[(axis * D + a) * P::LANES..][..P::LANES]);
                    kept.store(&mut pack[(layout.gradient + axis * D + a) * P::LANES..][..P::LANES]);
                }
            }
            store(pack, 0, &position);
            store(pack, layout.velocity, &velocity);
            speed = speed.max(square);
            rate = rate.max(norm);
            let moved = in_arena(&position, &origin, settings.spacing);
            for axis in 0..D {
                let lowest = kernel::lowest_node::<P, W>(moved[axis]);
                left |= !P::constant(0.0).less_equal(lowest).and(lowest.less_equal(reach)).all();
            }
        }
        // Free lanes hold a copy of a particle that was not moved: they are left where they were, which is within reach.
        Travel {
            speed_squared: largest_lane(Pair(speed, speed)),
            rate_squared: largest_lane(Pair(rate, rate)),
            left,
        }
    }
}

/// Blocks of particles, as the grid sees them.
pub(crate) fn origins<'a, E: Element, const D: usize>(
    bodies: &'a [Body<E, D>],
) -> impl Iterator<Item = ([i32; D], Sides)> + Clone + 'a {
    let block = |block: &ParticleBlock<D>| (block.origin, block.sides);
    bodies.iter().flat_map(move |body| body.particles.blocks.iter().map(block))
}
