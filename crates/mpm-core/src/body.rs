//! A body: particles of one law, and what one step does to them.

use crate::neighbourhood::{
    DRIFT, Gift, MOST_ARENA, NODE, Places, Wanted, arena_length, block_edge, gather, scatter,
};
use crate::particles::{FREE, Layout, ParticleBlock, Particles, load, store};
use crate::{Grid, Kernel, MpmError, Transfer};
use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch};
use mechanics_core::parallel;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{Matrix3, columns, from_columns, scaled, sum};
use mpm_constitutive::{Motion, Numbers, PointLaw, Stress, TotalDeformation, Viscosity};

/// The most numbers that a strain or history has.
const MOST_NUMBERS: usize = 16;

/// What stays the same during a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepSettings {
    /// h [s].
    pub(crate) step: f64,
    /// Δx \[m\].
    pub(crate) spacing: f64,
    pub(crate) kernel: Kernel,
    pub(crate) transfer: Transfer,
}

/// What a block of particles says of its step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct BlockReport {
    /// The square of the largest speed \[m²/s²\].
    pub(crate) speed_squared: f64,
    /// The square of the largest Frobenius norm of the velocity gradient [1/s²].
    pub(crate) rate_squared: f64,
    /// The largest (2μ̂ + d λ̂)/ρ₀ \[m²/s²\].
    pub(crate) expansion_squared: f64,
    /// The largest (λ̂ + 2μ̂)/ρ₀, the square of the fastest wave \[m²/s²\].
    pub(crate) wave_squared: f64,
    /// Whether a particle has left the reach of its block.
    pub(crate) left: bool,
    /// Whether something is not finite.
    pub(crate) broken: bool,
}

impl BlockReport {
    /// The larger of everything.
    pub(crate) fn merged(self, other: Self) -> Self {
        Self {
            speed_squared: self.speed_squared.max(other.speed_squared),
            rate_squared: self.rate_squared.max(other.rate_squared),
            expansion_squared: self.expansion_squared.max(other.expansion_squared),
            wave_squared: self.wave_squared.max(other.wave_squared),
            left: self.left || other.left,
            broken: self.broken || other.broken,
        }
    }
}

/// A body of any law.
pub(crate) trait AnyBody<E: Element, const D: usize>: Send + Sync {
    fn particles(&self) -> &Particles<E, D>;
    fn particles_mut(&mut self) -> &mut Particles<E, D>;
    /// Adds mass, momentum and impulses to the arenas, one a block; finds how stiff the body is.
    fn scatter(&mut self, arenas: &mut [E], settings: &StepSettings) -> BlockReport;
    /// Takes velocities from the grid; moves and deforms the particles. `first` is the number of the body's first arena.
    fn gather(&mut self, grid: &Grid<E, D>, first: usize, settings: &StepSettings) -> BlockReport;
    /// Speed, velocity gradient and stiffness of the particles as they are.
    fn limits(&self) -> BlockReport;
    /// The first particle, by its number, whose numbers are not finite or whose strain its law refuses; `body` is this body's number.
    fn first_inadmissible(&self, body: usize) -> Option<MpmError>;
    /// The Kirchhoff stress, energy density and admissibility of the particle in a slot.
    fn point(&self, slot: usize) -> PointState;
}

/// The mechanical state of one particle, in double precision.
#[derive(Clone, Debug)]
pub(crate) struct PointState {
    pub(crate) kirchhoff: Matrix3<f64>,
    pub(crate) energy_density: f64,
    pub(crate) volume_ratio: f64,
}

/// Particles of one law.
pub(crate) struct Body<E, const D: usize, L> {
    pub(crate) law: L,
    pub(crate) particles: Particles<E, D>,
    pub(crate) reports: Vec<BlockReport>,
}

/// Whether a law changes more than its trial strain, so that the stress is made with the flow and kept.
pub(crate) fn flows<L: PointLaw>() -> bool {
    <L::History<f64> as Numbers<f64>>::COUNT > 0 || L::TOTAL_DEFORMATION == TotalDeformation::Separate
}

/// The numbers of a particle of law `L`.
pub(crate) fn layout<L: PointLaw>(dimension: usize) -> Layout {
    let strain = <L::Strain<f64> as Numbers<f64>>::COUNT;
    let history = <L::History<f64> as Numbers<f64>>::COUNT;
    Layout::new(dimension, strain, history, if flows::<L>() { 6 } else { 0 })
}

impl<E: Element, const D: usize, L: PointLaw> Body<E, D, L> {
    fn packs(&self, block: usize) -> (usize, &ParticleBlock<D>) {
        let first = if block == 0 { 0 } else { self.particles.blocks[block - 1].end };
        (first, &self.particles.blocks[block])
    }
}

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

impl<E: Element, const D: usize, L: PointLaw> AnyBody<E, D> for Body<E, D, L> {
    fn particles(&self) -> &Particles<E, D> {
        &self.particles
    }

    fn particles_mut(&mut self) -> &mut Particles<E, D> {
        &mut self.particles
    }

    fn scatter(&mut self, arenas: &mut [E], settings: &StepSettings) -> BlockReport {
        let mut reports = std::mem::take(&mut self.reports);
        reports.clear();
        reports.resize(self.particles.blocks.len(), BlockReport::default());
        let length = arena_length(D, settings.kernel.width());
        let ends: Vec<usize> = (1..=reports.len()).map(|k| k * length).collect();
        let body = &*self;
        parallel::for_each_part(arenas, &ends, &mut reports, |block, arena, report| {
            let (first, placed) = body.packs(block);
            let pack_length = body.particles.pack_length();
            let packs = &body.particles.data[first * pack_length..placed.end * pack_length];
            arena.fill(E::default());
            let (origin, count) = (placed.origin, placed.count);
            with_width!(settings.kernel, W => if settings.transfer.uses_gradients() {
                *report = dispatch(Scatter::<E, D, W, true, L> { law: &body.law, packs, origin, count, arena, settings });
            } else {
                *report = dispatch(Scatter::<E, D, W, false, L> { law: &body.law, packs, origin, count, arena, settings });
            });
        });
        let merged = reports.iter().fold(BlockReport::default(), |all, one| all.merged(*one));
        self.reports = reports;
        merged
    }

    fn gather(&mut self, grid: &Grid<E, D>, first: usize, settings: &StepSettings) -> BlockReport {
        let mut reports = std::mem::take(&mut self.reports);
        reports.clear();
        reports.resize(self.particles.blocks.len(), BlockReport::default());
        let (law, blocks) = (&self.law, &self.particles.blocks);
        parallel::for_each_part(
            &mut self.particles.data,
            &self.particles.ends,
            &mut reports,
            |block, packs, report| {
                let (origin, count) = (blocks[block].origin, blocks[block].count);
                let arena = first + block;
                with_width!(settings.kernel, W => if settings.transfer.uses_gradients() {
                    *report = dispatch(Gather::<E, D, W, true, L> { law, packs, origin, count, grid, arena, settings });
                } else {
                    *report = dispatch(Gather::<E, D, W, false, L> { law, packs, origin, count, grid, arena, settings });
                });
            },
        );
        let merged = reports.iter().fold(BlockReport::default(), |all, one| all.merged(*one));
        self.reports = reports;
        merged
    }

    fn limits(&self) -> BlockReport {
        let layout = &self.particles.layout;
        let square = |slot: usize, numbers: std::ops::Range<usize>| -> f64 {
            numbers.map(|k| Into::<f64>::into(self.particles.number(slot, k)).powi(2)).sum()
        };
        let mut limits = BlockReport::default();
        for slot in self.live_slots() {
            let (strain, history) = self.state(slot);
            let stiffness = self.law.stress(&strain, &history).stiffness;
            let [mass, volume]: [f64; 2] =
                [layout.mass, layout.volume].map(|k| self.particles.number(slot, k).into());
            limits = limits.merged(BlockReport {
                speed_squared: square(slot, layout.velocity..layout.gradient),
                rate_squared: square(slot, layout.gradient..layout.strain),
                expansion_squared: stiffness.uniform(D) * volume / mass,
                wave_squared: stiffness.wave_modulus() * volume / mass,
                ..BlockReport::default()
            });
        }
        limits
    }

    fn first_inadmissible(&self, body: usize) -> Option<MpmError> {
        let layout = &self.particles.layout;
        let mut first: Option<(usize, MpmError)> = None;
        for slot in self.live_slots() {
            let particle = self.particles.ids[slot] as usize;
            if first.as_ref().is_some_and(|(found, _)| *found < particle) {
                continue;
            }
            let named = [("position", 0..D), ("velocity", D..layout.gradient), ("velocity gradient", layout.gradient..layout.strain)];
            let unfinite = named.into_iter().find_map(|(what, numbers)| {
                let value = numbers.map(|k| self.particles.number(slot, k).into()).find(|x: &f64| !x.is_finite())?;
                Some(MpmError::Particle { body, particle, what, value, wanted: "finite" })
            });
            let (strain, history) = self.state(slot);
            let refused = || {
                let source = self.law.check_admissible(&strain, &history).err()?;
                Some(MpmError::Law { body, particle, source })
            };
            if let Some(error) = unfinite.or_else(refused) {
                first = Some((particle, error));
            }
        }
        first.map(|(_, error)| error)
    }

    fn point(&self, slot: usize) -> PointState {
        let (strain, history) = self.state(slot);
        PointState {
            kirchhoff: self.law.stress(&strain, &history).kirchhoff,
            energy_density: self.law.energy_density(&strain, &history),
            volume_ratio: mpm_constitutive::Strain::volume_ratio(&strain),
        }
    }
}

impl<E: Element, const D: usize, L: PointLaw> Body<E, D, L> {
    fn live_slots(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.particles.ids.len()).filter(|slot| self.particles.ids[*slot] != FREE)
    }

    /// Strain and history of the particle in a slot.
    fn state(&self, slot: usize) -> (L::Strain<f64>, L::History<f64>) {
        let layout = &self.particles.layout;
        let number = |k: usize| -> f64 { self.particles.number(slot, k).into() };
        let strain = L::Strain::<f64>::from_numbers(|k| number(layout.strain + k));
        (strain, L::History::<f64>::from_numbers(|k| number(layout.history + k)))
    }
}

/// Positions relative to the lowest node of the arena [cells].
#[inline(always)]
fn in_arena<P: Packet, const D: usize>(position: &[P; D], origin: &[i32; D], spacing: f64) -> [P; D] {
    let edge = block_edge(D) as f64;
    let mut cells = *position;
    for axis in 0..D {
        let lowest = f64::from(origin[axis]) * edge - DRIFT as f64;
        cells[axis] = position[axis].mul_add(P::constant(1.0 / spacing), P::constant(-lowest));
    }
    cells
}

/// A D×D matrix, by column, as the corner of a 3×3 one.
#[inline(always)]
fn embedded<P: Scalar, const D: usize>(columns: &[[P; D]; D]) -> Matrix3<P> {
    let mut full = [[P::constant(0.0); 3]; 3];
    for (column, numbers) in full.iter_mut().zip(columns) {
        column[..D].copy_from_slice(numbers);
    }
    from_columns(full)
}

/// The gradient of the velocity as it is stored: by column.
#[inline(always)]
fn stored_gradient<P: Packet, const D: usize>(pack: &[P::Element], layout: &Layout) -> [[P; D]; D] {
    let mut gradient = [[P::constant(0.0); D]; D];
    for axis in 0..D {
        gradient[axis] = load::<P, D>(pack, layout.gradient + axis * D);
    }
    gradient
}

/// `count` numbers of a pack. An array, because a closure that loads packets would not be compiled for AVX2.
#[inline(always)]
fn loaded<P: Packet>(pack: &[P::Element], first: usize, count: usize) -> [P; MOST_NUMBERS] {
    let mut numbers = [P::constant(0.0); MOST_NUMBERS];
    for (k, number) in numbers.iter_mut().enumerate().take(count) {
        *number = P::load(&pack[(first + k) * P::LANES..][..P::LANES]);
    }
    numbers
}

#[inline(always)]
fn strain_of<P: Packet, L: PointLaw>(pack: &[P::Element], layout: &Layout) -> L::Strain<P> {
    let numbers = loaded(pack, layout.strain, <L::Strain<P> as Numbers<P>>::COUNT);
    L::Strain::<P>::from_numbers(|k| numbers[k])
}

#[inline(always)]
fn history_of<P: Packet, L: PointLaw>(pack: &[P::Element], layout: &Layout) -> L::History<P> {
    let numbers = loaded(pack, layout.history, <L::History<P> as Numbers<P>>::COUNT);
    L::History::<P>::from_numbers(|k| numbers[k])
}

/// Adds the particles of one block to its arena.
struct Scatter<'a, E, const D: usize, const W: usize, const GRADIENTS: bool, L> {
    law: &'a L,
    packs: &'a [E],
    origin: [i32; D],
    count: usize,
    arena: &'a mut [E],
    settings: &'a StepSettings,
}

impl<E: Element, const D: usize, const W: usize, const GRADIENTS: bool, L: PointLaw> LaneKernel<E>
    for Scatter<'_, E, D, W, GRADIENTS, L>
{
    type Output = BlockReport;

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> BlockReport {
        let layout = layout::<L>(D);
        let settings = self.settings;
        let step = P::constant(settings.step);
        let moment = settings.kernel.second_moment().unwrap_or(f64::INFINITY);
        let affine_part = settings.transfer.affine_part();
        let (mut expansion, mut wave) = (P::constant(0.0), P::constant(0.0));
        for (k, pack) in self.packs.chunks_exact(layout.count * P::LANES).enumerate() {
            let position = load::<P, D>(pack, 0);
            let velocity = load::<P, D>(pack, layout.velocity);
            let gradient = stored_gradient::<P, D>(pack, &layout);
            let [mass, volume] = load::<P, 2>(pack, layout.mass);
            let stress = self.stress(pack, &layout, &gradient);
            let density = mass / volume;
            expansion = expansion.max(stress.stiffness.uniform(D) / density);
            wave = wave.max(stress.stiffness.wave_modulus() / density);
            let tau = columns(&stress.kirchhoff);
            let places = Places::<P, D, W>::new(&in_arena(&position, &self.origin, settings.spacing));
            // By axis: m C Δx, damped; with moving least squares less the impulse h V₀ τ D⁻¹ Δx of the stress.
            let mut affine = [[P::constant(0.0); D]; D];
            if let Some(symmetric) = affine_part {
                let (plain, turned) = (0.5 + 0.5 * symmetric, 0.5 * symmetric - 0.5);
                let momentum = mass.scale(settings.spacing);
                for axis in 0..D {
                    for a in 0..D {
                        // C + (s − 1) sym C = ½(1 + s) C + ½(s − 1) Cᵀ.
                        let c = if symmetric == 1.0 {
                            gradient[axis][a]
                        } else {
                            gradient[axis][a].scale(plain) + gradient[a][axis].scale(turned)
                        };
                        affine[axis][a] = momentum * c;
                    }
                }
            }
            let impulse = volume * step;
            let mut impulses = None;
            if GRADIENTS {
                let factor = impulse.scale(-1.0 / settings.spacing);
                let mut pushes = [[P::constant(0.0); D]; D];
                for axis in 0..D {
                    for a in 0..D {
                        pushes[axis][a] = factor * tau[axis][a];
                    }
                }
                impulses = Some(pushes);
            } else {
                let factor = impulse.scale(-1.0 / (moment * settings.spacing));
                for axis in 0..D {
                    for a in 0..D {
                        affine[axis][a] = factor.mul_add(tau[axis][a], affine[axis][a]);
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
            let gift = Gift { mass, momentum, affine, impulses };
            scatter(self.arena, &places, &gift, self.count - k * P::LANES);
        }
        BlockReport {
            expansion_squared: largest(expansion),
            wave_squared: largest(wave),
            ..BlockReport::default()
        }
    }
}

impl<E: Element, const D: usize, const W: usize, const GRADIENTS: bool, L: PointLaw>
    Scatter<'_, E, D, W, GRADIENTS, L>
{
    /// The stress: kept from the last step if the law flows, else made from the strain.
    #[inline(always)]
    fn stress<P: Packet<Element = E>>(&self, pack: &[E], layout: &Layout, gradient: &[[P; D]; D]) -> Stress<P> {
        let strain = strain_of::<P, L>(pack, layout);
        let history = history_of::<P, L>(pack, layout);
        if flows::<L>() {
            let [xx, yy, zz, yz, zx, xy] = load::<P, 6>(pack, layout.stress);
            let kirchhoff = from_columns([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]);
            // The bound at rest; plastic laws stay near it.
            let stiffness = self.law.stress(&strain, &history).stiffness;
            return Stress { kirchhoff, stiffness };
        }
        let mut stress = self.law.stress(&strain, &history);
        let viscosity = self.law.viscosity();
        if viscosity != Viscosity::NONE {
            let ratio = mpm_constitutive::Strain::volume_ratio(&strain);
            let viscous = viscosity.kirchhoff(ratio, &embedded(gradient));
            stress.kirchhoff = sum(&stress.kirchhoff, &viscous);
        }
        stress
    }
}

/// Moves and deforms the particles of one block.
struct Gather<'a, E, const D: usize, const W: usize, const GRADIENTS: bool, L> {
    law: &'a L,
    packs: &'a mut [E],
    origin: [i32; D],
    count: usize,
    grid: &'a Grid<E, D>,
    arena: usize,
    settings: &'a StepSettings,
}

impl<E: Element, const D: usize, const W: usize, const GRADIENTS: bool, L: PointLaw> LaneKernel<E>
    for Gather<'_, E, D, W, GRADIENTS, L>
{
    type Output = BlockReport;

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> BlockReport {
        let layout = layout::<L>(D);
        let settings = self.settings;
        let mut arena = [E::default(); MOST_ARENA];
        let arena = &mut arena[..arena_length(D, W)];
        self.grid.fill(self.arena, arena);
        let flip = settings.transfer.flip_part();
        let mut changes = [E::default(); MOST_ARENA];
        let changes = &mut changes[..arena_length(D, W)];
        if flip.is_some() {
            self.grid.fill_changes(self.arena, changes);
        }
        let step = P::constant(settings.step);
        let to_gradient = 1.0 / (settings.kernel.second_moment().unwrap_or(f64::INFINITY) * settings.spacing);
        let wanted = if GRADIENTS { Wanted::Slopes } else { Wanted::Moments };
        let (mut speed, mut rate) = (P::constant(0.0), P::constant(0.0));
        let (mut left, mut broken) = (false, false);
        let reach = P::constant((block_edge(D) - 1 + 2 * DRIFT) as f64);
        for (k, pack) in self.packs.chunks_exact_mut(layout.count * P::LANES).enumerate() {
            let alive = self.count - k * P::LANES;
            let mut position = load::<P, D>(pack, 0);
            let mut velocity = load::<P, D>(pack, layout.velocity);
            let places = Places::<P, D, W>::new(&in_arena(&position, &self.origin, settings.spacing));
            let sums = gather(arena, &places, wanted, alive);
            // C by column (axis), from moments about the particle.
            let mut affine = [[P::constant(0.0); D]; D];
            for axis in 0..D {
                for a in 0..D {
                    let moment = (-places.fraction[axis]).mul_add(sums.velocity[a], sums.moments[axis][a]);
                    affine[axis][a] = moment.scale(to_gradient);
                }
            }
            let mut gradient = affine;
            if GRADIENTS {
                for axis in 0..D {
                    for a in 0..D {
                        gradient[axis][a] = sums.slopes[axis][a].scale(1.0 / settings.spacing);
                    }
                }
            }
            for a in 0..D {
                position[a] = step.mul_add(sums.velocity[a], position[a]);
            }
            if let Some(part) = flip {
                let change = gather(changes, &places, Wanted::Velocity, alive).velocity;
                for a in 0..D {
                    velocity[a] = (velocity[a] + change[a]).scale(part) + sums.velocity[a].scale(1.0 - part);
                }
            } else {
                velocity = sums.velocity;
            }
            store(pack, 0, &position);
            store(pack, layout.velocity, &velocity);
            let kept = if settings.transfer.affine_part().is_some() { &affine } else { &gradient };
            for axis in 0..D {
                store(pack, layout.gradient + axis * D, &kept[axis]);
            }
            deform::<P, L, D>(self.law, pack, &layout, &gradient, settings.step);
            let mut squares = (P::constant(0.0), P::constant(0.0));
            for a in 0..D {
                squares.0 = velocity[a].mul_add(velocity[a], squares.0);
                for axis in 0..D {
                    squares.1 = gradient[axis][a].mul_add(gradient[axis][a], squares.1);
                }
            }
            speed = speed.max(squares.0);
            rate = rate.max(squares.1);
            broken |= !squares.0.is_finite().and(squares.1.is_finite()).all();
            let moved = in_arena(&position, &self.origin, settings.spacing);
            for axis in 0..D {
                let lowest = crate::kernel::lowest_node::<P, W>(moved[axis]);
                left |= !P::constant(0.0).less_equal(lowest).and(lowest.less_equal(reach)).all();
            }
        }
        let (speed_squared, rate_squared) = (largest(speed), largest(rate));
        BlockReport { speed_squared, rate_squared, left, broken, ..BlockReport::default() }
    }
}

/// Strain, history and, if the law flows, the stress after the step.
#[inline(always)]
fn deform<P: Packet, L: PointLaw, const D: usize>(
    law: &L,
    pack: &mut [P::Element],
    layout: &Layout,
    gradient: &[[P; D]; D],
    step: f64,
) {
    let strain = strain_of::<P, L>(pack, layout);
    let velocity_gradient = embedded(gradient);
    let strain = if flows::<L>() {
        let mut history = history_of::<P, L>(pack, layout);
        let (strain, stress) = law.advance(&strain, &mut history, &Motion { velocity_gradient, step });
        for k in 0..<L::History<P> as Numbers<P>>::COUNT {
            history.number(k).store(&mut pack[(layout.history + k) * P::LANES..][..P::LANES]);
        }
        let tau = columns(&stress.kirchhoff);
        let six = [tau[0][0], tau[1][1], tau[2][2], tau[1][2], tau[2][0], tau[0][1]];
        store(pack, layout.stress, &six);
        strain
    } else {
        mpm_constitutive::Strain::advanced(&strain, &scaled(&velocity_gradient, P::constant(step)))
    };
    for k in 0..<L::Strain<P> as Numbers<P>>::COUNT {
        strain.number(k).store(&mut pack[(layout.strain + k) * P::LANES..][..P::LANES]);
    }
}

/// The largest lane.
#[inline(always)]
fn largest<P: Packet>(packet: P) -> f64 {
    packet.to_lanes().as_ref().iter().fold(0.0, |most, lane| f64::max(most, (*lane).into()))
}

const _: () = assert!(NODE == 4 && MOST_NUMBERS >= 9);
