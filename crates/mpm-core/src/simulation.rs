//! Bodies, grid and time: the step of the explicit material point method.

mod colliders;
mod compiled;
mod equilibrium;
mod fields;
mod filter;
mod implicit;
mod loads;
mod nodes;
mod numbers;
mod resume;
mod samples;
mod sheets;
mod totals;

pub use equilibrium::{Equilibrium, EquilibriumReport};
pub use numbers::ParticleNumbers;
pub use resume::ResumeError;
pub use samples::Samples;
pub use totals::{DeformationBuffer, Totals};

use crate::body::{Body, StepSettings, Travel, Trial, origins};
use crate::boundary::{Boundary, PrescribedVelocity, finite};
use crate::collider::{BlockMemory, ColliderStage, PlacedCollider, Sheets, Sides};
use crate::forecast::{Domain, Span};
use crate::grid::Changes;
use crate::grip::Grip;
use crate::material::{Material, Matter, PointState, Stiffness, Tracking};
use crate::neighbourhood::block_edge;
use crate::particles::Particles;
use crate::{Grid, Kernel, MpmError, Transfer};
use mechanics_core::lanes::{Element, dispatch};
use mechanics_core::tensor::Mat3;
use mpm_constitutive::PointLaw;
use nodes::{Constraints, NodeReport, NodeUpdate};
use std::time::Instant;

/// What a simulation is made with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationOptions {
    /// Distance of nodes Δx \[m\].
    pub spacing: f64,
    /// Shape of particles on the grid.
    pub kernel: Kernel,
    /// How velocities travel.
    pub transfer: Transfer,
}

impl SimulationOptions {
    /// Quadratic kernel, MLS-APIC.
    pub fn new(spacing: f64) -> Self {
        Self { spacing, kernel: Kernel::default(), transfer: Transfer::default() }
    }
}

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// h \[s\].
    pub step: f64,
    /// Whether particles were sorted anew before the step.
    pub sorted: bool,
    /// Blocks of 64 nodes.
    pub blocks: usize,
    /// The fastest particle after the step \[m/s\].
    pub speed: f64,
    /// The fastest wave before the step \[m/s\].
    pub wave_speed: f64,
    /// Places at which a collider was asked for its distance: middles of blocks and nodes near solids, nodes hidden by sheets, particles
    /// whose path was guarded. Sorting, which finds the sides of sheets, does not count, and implicit steps do not. Zero without colliders.
    pub collider_queries: u64,
}

/// Where the time of a step went \[s\], for who wants to make it shorter. It is no part of the state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageTimes {
    /// Sorting particles and making blocks of nodes, where it was due.
    pub sort: f64,
    /// Stress, what particles give to the nodes, and its sums.
    pub scatter: f64,
    /// Velocities and boundaries of the nodes, and XPIC's further passes.
    pub nodes: f64,
    /// Looking ahead, and taking velocities, moving and deforming the particles.
    pub gather: f64,
}

/// Bytes that a simulation holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryUse {
    /// Particles, their numbers and what sorting needs.
    pub particles: usize,
    /// Nodes, and the arenas of as many blocks of particles as are taken together.
    pub nodes: usize,
}

/// What [`Simulation::advance`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdvanceReport {
    /// Steps taken.
    pub steps: u64,
    /// How often particles were sorted.
    pub sorts: u64,
    /// The shortest step \[s\].
    pub shortest: f64,
}

/// The most steps that one [`Simulation::advance`] takes.
const MOST_STEPS: u64 = 100_000_000;

/// Parts of the limits of stability that a step may use.
const OSCILLATION_PART: f64 = 0.5;
const TRAVEL_PART: f64 = 0.5;
const RATE_PART: f64 = 0.5;

/// What a block of nodes says of a step, and what it remembers from step to step.
#[derive(Clone, Debug, Default)]
struct BlockResult<const D: usize> {
    report: NodeReport<D>,
    span: Span<D>,
    /// Of the particles that see it, where not all do.
    sides: Sides,
    /// By collider; empty without any.
    memories: Vec<BlockMemory>,
    /// Places at which colliders were asked for their distance.
    collider_queries: u64,
}

/// Bodies on one sparse grid in `D` = 2 or 3 dimensions, in `f32` or `f64`.
///
/// # A step
/// 1. Particles give mass and momentum to the nodes around them, and the impulses h f of their stress.
/// 2. Nodes: v = p/m where m > 0; gravity; boundaries in their order.
/// 3. Particles take velocities from the nodes, move with Σ w v, and deform: F ← (I + h ∇v) F, return map.
///
/// Stress is updated last (USL), with the velocities that moved the particles: the symplectic Euler method. The same input gives the same
/// bits for any number of threads.
pub struct Simulation<E: Element, const D: usize> {
    options: SimulationOptions,
    gravity: [f64; D],
    domain: Domain<D>,
    prescribed: Vec<PrescribedVelocity<D>>,
    grips: Vec<Grip<D>>,
    boundaries: Vec<Boundary<D>>,
    bodies: Vec<Body<E, D>>,
    grid: Grid<E, D>,
    arenas: Vec<E>,
    colliders: Vec<PlacedCollider>,
    /// By block of nodes.
    results: Vec<BlockResult<D>>,
    /// Velocities of the blocks of nodes.
    spans: Vec<Span<D>>,
    sorted: bool,
    /// Largest of what the last step found, for the length of the next one.
    limits: Option<(Stiffness, Travel)>,
    time: f64,
    steps: u64,
    stages: StageTimes,
}

impl<E: Element, const D: usize> Simulation<E, D> {
    /// An empty space.
    ///
    /// # Errors
    /// [`MpmError`] for a spacing or a part that is out of range, and for an affine transfer with a linear kernel.
    pub fn new(options: SimulationOptions) -> Result<Self, MpmError> {
        const { assert!(D == 2 || D == 3, "two or three dimensions") };
        if !(options.spacing > 0.0 && options.spacing.is_finite()) {
            return Err(MpmError::Spacing { value: options.spacing });
        }
        options.transfer.check()?;
        if options.kernel == Kernel::Linear && options.transfer.affine_part().is_some() {
            return Err(MpmError::SingularMoment);
        }
        let changes = if options.transfer.keeps_impulses() { Changes::Kept } else { Changes::Dropped };
        let grid = Grid::new(options.kernel.width(), changes);
        Ok(Self {
            options,
            gravity: [0.0; D],
            domain: Domain::of_cells(options.spacing),
            prescribed: Vec::new(),
            grips: Vec::new(),
            boundaries: Vec::new(),
            bodies: Vec::new(),
            grid,
            arenas: Vec::new(),
            colliders: Vec::new(),
            results: Vec::new(),
            spans: Vec::new(),
            sorted: false,
            limits: None,
            time: 0.0,
            steps: 0,
            stages: StageTimes::default(),
        })
    }

    /// The acceleration of everything \[m/s²\].
    ///
    /// # Errors
    /// [`MpmError::Number`] unless it is finite.
    pub fn set_gravity(&mut self, gravity: [f64; D]) -> Result<(), MpmError> {
        finite("gravity", &gravity)?;
        self.gravity = gravity;
        Ok(())
    }

    /// Adds a body of rest density `density` \[kg/m³\], undeformed at its positions; answers its number.
    ///
    /// # Errors
    /// [`MpmError`] for a density or volume that is not positive, for anything that is not finite, for a position outside of the domain,
    /// and for an empty body. Nothing is added then.
    pub fn add_body<L: PointLaw + 'static>(
        &mut self,
        law: L,
        density: f64,
        samples: Samples<'_, D>,
    ) -> Result<usize, MpmError> {
        self.add(Box::new(Matter { law, tracking: Tracking::Strain }), density, samples)
    }

    /// As [`add_body`](Self::add_body), and its particles carry the total deformation gradient beside an elastic strain: what
    /// [`deformation_samples`](Self::deformation_samples) and following tractions need of a body that flows. It costs D² numbers a particle;
    /// laws whose strain is the total deformation gradient need nothing.
    ///
    /// # Errors
    /// As `add_body`.
    pub fn add_tracked_body<L: PointLaw + 'static>(
        &mut self,
        law: L,
        density: f64,
        samples: Samples<'_, D>,
    ) -> Result<usize, MpmError> {
        self.add(Box::new(Matter { law, tracking: Tracking::Total }), density, samples)
    }

    fn add(
        &mut self,
        material: Box<dyn Material<E, D>>,
        density: f64,
        samples: Samples<'_, D>,
    ) -> Result<usize, MpmError> {
        let body = self.bodies.len();
        samples.check::<E>(body, density, &self.domain)?;
        self.check_outside(body, samples.positions)?;
        let layout = material.layout();
        let mut virgin = vec![0.0; layout.count];
        for (k, number) in material.deformed(&Mat3::identity()) {
            virgin[k] = number;
        }
        let Samples { positions, velocities, volumes } = samples;
        let particles = Particles::new(layout, positions.len(), |particle, k| {
            E::constant(match k {
                k if k < layout.velocity => positions[particle][k],
                k if k < layout.gradient => velocities[particle][k - layout.velocity],
                k if k == layout.mass => density * volumes[particle],
                k if k == layout.volume => volumes[particle],
                _ => virgin[k],
            })
        });
        self.bodies.push(Body::new(material, particles));
        self.sorted = false;
        self.limits = None;
        Ok(body)
    }

    /// Sorts every body and makes the grid's blocks.
    fn sort(&mut self) -> Result<(), MpmError> {
        let width = self.options.kernel.width();
        for (number, body) in self.bodies.iter().enumerate() {
            body.particles.check_places(number, self.options.spacing, width)?;
        }
        for number in 0..self.bodies.len() {
            let sides = self.sides_of(&self.bodies[number]);
            self.bodies[number].sort(number, self.options.spacing, width, &sides)?;
        }
        self.rebuild();
        Ok(())
    }

    /// Makes the blocks of nodes around the blocks of particles.
    fn rebuild(&mut self) {
        let before = if self.colliders.is_empty() { Vec::new() } else { self.grid.blocks().to_vec() };
        let Self { grid, bodies, colliders, options, time, .. } = &mut *self;
        let sheets = Sheets::new(colliders, (*time, *time), options.spacing, (options.kernel.width(), D));
        grid.rebuild(origins(bodies), &mut |block, sides| sheets.ghost_nodes(block, sides));
        self.carry_colliders(&before);
        // XPIC's passes read the nodes while they fill the arenas: all of them exist then.
        let count = match self.options.transfer.passes() {
            0 => self.grid.longest_wave(),
            _ => origins(&self.bodies).count(),
        };
        self.arenas.resize(count * self.grid.arena_stride(), E::default());
        self.sorted = true;
    }

    /// The longest step that is stable now \[s\]; ∞ for an empty space.
    ///
    /// With the stiffness bounds of the laws, ρ₀ and the present velocities, half of the smallest of
    /// - 2/ω, ω² = k (2μ̂ + d λ̂)/(ρ₀ Δx²): a particle alone among its nodes, which is stiffer than any of the waves of a full body;
    ///   k is 4 for quadratic kernels with MLS, 6 with true gradients;
    /// - Δx/‖v‖: nothing crosses a cell in a step;
    /// - 1/‖∇v‖: det(I + h ∇v) stays positive.
    ///
    /// Stiffness is that of the begin of the last step, and the half of 2/ω covers its growth to the fourfold. Matter of which it grows as J⁻ⁿ
    /// ([`PointLaw::stiffening`]) may not double it in a step: with n > 1 the parts of the last two are 1 − 2^(−1/n) instead of one half, because what hits
    /// something with ‖v‖ is pressed by up to h‖v‖/Δx in a step that nothing has announced. It counts where flow is nearly as fast as waves, or faster.
    pub fn stable_step(&mut self) -> f64 {
        let bodies = &self.bodies;
        let (stiffness, travel) = *self.limits.get_or_insert_with(|| {
            bodies
                .iter()
                .map(Body::limits)
                .fold(<(Stiffness, Travel)>::default(), |(s, t), (stiffness, travel)| {
                    (s.merged(stiffness), t.merged(travel))
                })
        });
        let spacing = self.options.spacing;
        let factor = self.options.transfer.stiffness_factor(self.options.kernel);
        let oscillation = 2.0 * spacing / (factor * stiffness.expansion).sqrt();
        let crossing = spacing / travel.speed_squared.sqrt();
        let rate = 1.0 / travel.rate_squared.sqrt();
        let stiffening = self.bodies.iter().fold(0.0, |most: f64, body| most.max(body.stiffening()));
        let doubled = if stiffening > 1.0 { 1.0 - 2.0_f64.powf(-1.0 / stiffening) } else { 0.5 };
        (OSCILLATION_PART * oscillation)
            .min(TRAVEL_PART.min(doubled) * crossing)
            .min(RATE_PART.min(doubled) * rate)
    }

    /// One step of h \[s\].
    ///
    /// # Errors
    /// [`MpmError::Unstable`] if it is longer than [`stable_step`](Self::stable_step), and what [`step_unchecked`](Self::step_unchecked)
    /// gives.
    pub fn step(&mut self, step: f64) -> Result<StepReport, MpmError> {
        let stable = self.stable_step();
        if stable.is_nan() {
            return Err(self.culprit(None));
        }
        if step > stable {
            return Err(MpmError::Unstable { step, stable });
        }
        self.step_unchecked(step)
    }

    /// As many equal-or-shorter stable steps as it takes to cover `duration` \[s\].
    ///
    /// # Errors
    /// [`MpmError::TooManySteps`] if stable steps are so short that they would not end, and what a step gives. Steps before the one
    /// that failed stay.
    pub fn advance(&mut self, duration: f64) -> Result<AdvanceReport, MpmError> {
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(MpmError::Step { value: duration });
        }
        let mut report = AdvanceReport { shortest: f64::INFINITY, ..AdvanceReport::default() };
        let mut left = duration;
        while left > 0.0 {
            let stable = self.stable_step();
            if stable.is_nan() {
                return Err(self.culprit(None));
            }
            if !(left / stable < MOST_STEPS as f64) {
                return Err(MpmError::TooManySteps { stable, duration, most: MOST_STEPS });
            }
            // Equal parts of what is left, so that no last step is tiny.
            let parts = (left / stable).ceil().max(1.0);
            let step = if parts == 1.0 { left } else { left / parts };
            let done = self.step_unchecked(step)?;
            left = if parts == 1.0 { 0.0 } else { left - step };
            report.steps += 1;
            report.sorts += u64::from(done.sorted);
            report.shortest = report.shortest.min(step);
        }
        Ok(report)
    }

    /// One step of h \[s\], whatever its length: a step above the stable one makes velocities grow without bound within some
    /// hundred steps, and a much longer one turns elements inside out at once.
    ///
    /// # Errors
    /// [`MpmError::Step`] unless h is positive and finite; [`MpmError::Law`] or [`MpmError::Particle`] with the first particle whose strain,
    /// velocity or position is not admissible or would not be after the step, [`MpmError::OutOfDomain`] if it would leave the domain,
    /// [`MpmError::Node`] if the velocity of a node is beyond the range of numbers. The step is not made then, not in part either.
    pub fn step_unchecked(&mut self, step: f64) -> Result<StepReport, MpmError> {
        compiled::step(self, step)
    }

    fn whole_step(&mut self, step: f64) -> Result<StepReport, MpmError> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(MpmError::Step { value: step });
        }
        let mut report = StepReport { step, ..StepReport::default() };
        let mut clock = Stopwatch::start();
        if !self.sorted {
            self.sort()?;
            report.sorted = true;
        }
        let sort = clock.lap();
        let SimulationOptions { spacing, kernel, transfer } = self.options;
        let settings = StepSettings { step, spacing, kernel, transfer };
        let stiffness = self.scatter(&mut |body, blocks, arenas| body.scatter(blocks, arenas, &settings));
        let scatter = clock.lap();
        self.update_nodes(&settings)?;
        let nodes = clock.lap();
        self.foresee(&settings)?;
        // How far anything goes.
        let reach = self.spans.iter().fold(Span::default(), |all, span| all.merged(span)).reach(step);
        let starts = self.starts_near_sheets(step, &reach);
        let mut travel = Travel::default();
        let mut first = 0;
        for body in &mut self.bodies {
            travel = travel.merged(body.gather(&self.grid, first, &settings));
            first += body.particles.blocks.len();
        }
        self.stages = StageTimes { sort, scatter, nodes, gather: clock.lap() };
        self.sorted = !travel.left;
        self.limits = Some((stiffness, travel));
        self.load_colliders();
        let guarded = self.guard_sheets(step, &starts);
        self.time += step;
        self.steps += 1;
        report.blocks = self.grid.block_count();
        report.speed = travel.speed_squared.sqrt();
        report.wave_speed = stiffness.wave.sqrt();
        report.collider_queries =
            self.results.iter().map(|result| result.collider_queries).sum::<u64>() + guarded;
        Ok(report)
    }

    /// Velocities of the nodes from their momenta.
    fn update_nodes(&mut self, settings: &StepSettings) -> Result<(), MpmError> {
        self.results.resize_with(self.grid.block_count(), BlockResult::default);
        self.filter(settings);
        let strays = settings.transfer.position_part().is_some();
        let gain = self.gravity.map(|g| g * settings.step);
        let end = self.time + settings.step;
        let middle = self.time + 0.5 * settings.step;
        let grips = self.placed_grips(middle, settings.step);
        let constraints = Constraints {
            grips: &grips,
            prescribed: &self.prescribed,
            boundaries: &self.boundaries,
            middle,
            end,
            spacing: settings.spacing,
        };
        let stage = ColliderStage::new(&self.colliders, constraints.end, settings.spacing);
        let sheets = Sheets::new(
            &self.colliders,
            (self.time, constraints.end),
            settings.spacing,
            (settings.kernel.width(), D),
        );
        for (block, result) in self.results.iter_mut().enumerate() {
            result.sides = self.grid.sides(block);
        }
        self.grid.update(&mut self.results, |origin, nodes, changes, result| {
            let BlockResult { report, span, memories, sides, collider_queries } = result;
            *report = dispatch(NodeUpdate::<E, D> { nodes, changes, gain });
            constraints.act(origin, nodes);
            *collider_queries = stage.act(origin, nodes, memories)
                + stage.act_as_sheets(&sheets, *sides, origin, nodes, memories);
            // They hold the velocities before forces.
            for (change, node) in changes.iter_mut().zip(nodes.iter()) {
                *change = *node - *change;
            }
            report.origin = *origin;
            *span = Span::of_nodes(nodes);
            if strays {
                span.note_changes(changes);
            }
        });
        self.spans.clear();
        self.spans.extend(self.results.iter().map(|result| result.span));
        match self.results.iter().find(|result| result.report.broken) {
            None => Ok(()),
            Some(result) => Err(self.culprit(Some(result.report.origin))),
        }
    }

    /// Confirms that the gather will leave every particle in an admissible state.
    fn foresee(&self, settings: &StepSettings) -> Result<(), MpmError> {
        let mut first = 0;
        for (number, body) in self.bodies.iter().enumerate() {
            let (grid, spans, domain) = (&self.grid, &self.spans[..], &self.domain);
            if let Some((_, error)) =
                body.foresee(&Trial { body: number, grid, first, spans, domain, settings })
            {
                return Err(error);
            }
            first += body.particles.blocks.len();
        }
        Ok(())
    }

    /// Why something is not finite: the first particle whose numbers are not, or else the block of nodes.
    fn culprit(&self, block: Option<[i32; D]>) -> MpmError {
        for (number, body) in self.bodies.iter().enumerate() {
            if let Some(error) = body.first_inadmissible(number) {
                return error;
            }
        }
        let edge = block_edge(D) as f64 * self.options.spacing;
        MpmError::Node { position: block.iter().flatten().map(|b| f64::from(*b) * edge).collect() }
    }

    /// Where the time of the last step went.
    pub fn stage_times(&self) -> StageTimes {
        self.stages
    }

    /// What is held in memory now.
    pub fn memory_use(&self) -> MemoryUse {
        let particles = self.bodies.iter().map(|body| body.particles.bytes()).sum();
        MemoryUse { particles, nodes: self.grid.bytes() + std::mem::size_of_val(&self.arenas[..]) }
    }

    /// Time since the start \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Steps since the start.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// How many bodies there are.
    pub fn body_count(&self) -> usize {
        self.bodies.len()
    }

    /// How many particles a body has.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn particle_count(&self, body: usize) -> usize {
        self.bodies[body].particles.count
    }

    /// Positions of the particles of a body, by their numbers \[m\].
    ///
    /// # Panics
    /// If there is no such body.
    pub fn positions(&self, body: usize) -> Vec<[f64; D]> {
        self.vectors(body, 0)
    }

    /// Velocities of the particles of a body, by their numbers \[m/s\].
    ///
    /// # Panics
    /// If there is no such body.
    pub fn velocities(&self, body: usize) -> Vec<[f64; D]> {
        self.vectors(body, D)
    }

    /// Stress, energy and volume of the particles of a body, by their numbers.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn states(&self, body: usize) -> Vec<PointState> {
        let body = &self.bodies[body];
        body.particles.slots().into_iter().map(|slot| body.state(slot as usize)).collect()
    }

    fn vectors(&self, body: usize, first: usize) -> Vec<[f64; D]> {
        let particles = &self.bodies[body].particles;
        let number = |slot: u32, axis: usize| particles.number(slot as usize, first + axis).into();
        particles.slots().into_iter().map(|slot| std::array::from_fn(|axis| number(slot, axis))).collect()
    }
}

/// Times of consecutive stages: five readings of the clock a step.
struct Stopwatch(Instant);

impl Stopwatch {
    fn start() -> Self {
        Self(Instant::now())
    }

    /// Since the last lap \[s\].
    fn lap(&mut self) -> f64 {
        let now = Instant::now();
        (now - std::mem::replace(&mut self.0, now)).as_secs_f64()
    }
}
