//! Bodies, grid and time: the step of the explicit material point method.

use crate::body::{AnyBody, BlockReport, Body, StepSettings, flows, layout};
use crate::grid::BLOCK;
use crate::neighbourhood::{NODE, arena_length, block_edge};
use crate::particles::Particles;
use crate::{Grid, Kernel, MpmError, Transfer};
use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch};
use mechanics_core::scalar::Scalar;
use mpm_constitutive::{Numbers, PointLaw, Strain};

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

/// What a step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Whether particles were sorted anew before the step.
    pub sorted: bool,
    /// Blocks of 64 nodes.
    pub blocks: usize,
    /// The fastest particle after the step \[m/s\].
    pub speed: f64,
    /// The fastest wave before the step \[m/s\].
    pub wave_speed: f64,
}

/// Bodies on one sparse grid in `D` = 2 or 3 dimensions, in `f32` or `f64`.
pub struct Simulation<E: Element, const D: usize> {
    options: SimulationOptions,
    gravity: [f64; D],
    bodies: Vec<Box<dyn AnyBody<E, D>>>,
    grid: Grid<E, D>,
    arenas: Vec<E>,
    results: Vec<BlockReport>,
    sorted: bool,
    time: f64,
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
        match options.transfer {
            Transfer::Flip { flip: value } if !(0.0..=1.0).contains(&value) => {
                return Err(MpmError::Part { what: "FLIP's part", value });
            }
            Transfer::Apic { damping: value } if !(0.0..=1.0).contains(&value) => {
                return Err(MpmError::Part { what: "the damping of APIC", value });
            }
            _ => {}
        }
        if options.kernel == Kernel::Linear && options.transfer.affine_part().is_some() {
            return Err(MpmError::SingularMoment);
        }
        let grid = Grid::new(options.kernel.width(), options.transfer.flip_part().is_some());
        Ok(Self {
            options,
            gravity: [0.0; D],
            bodies: Vec::new(),
            grid,
            arenas: Vec::new(),
            results: Vec::new(),
            sorted: false,
            time: 0.0,
        })
    }

    /// The acceleration of everything \[m/s²\].
    pub fn set_gravity(&mut self, gravity: [f64; D]) {
        self.gravity = gravity;
    }

    /// Adds a body at rest in its shape; answers its number.
    pub fn add_body<L: PointLaw + 'static>(
        &mut self,
        law: L,
        density: f64,
        positions: &[[f64; D]],
        velocities: &[[f64; D]],
        volumes: &[f64],
    ) -> Result<usize, MpmError> {
        let layout = layout::<L>(D);
        let undeformed = <L::Strain<f64> as Strain<f64>>::undeformed();
        let strains = <L::Strain<f64> as Numbers<f64>>::COUNT;
        if positions.is_empty() {
            return Err(MpmError::EmptyBody);
        }
        let particles = Particles::new(layout, positions.len(), |particle, k| {
            E::constant(match k {
                k if k < layout.velocity => positions[particle][k],
                k if k < layout.gradient => velocities[particle][k - layout.velocity],
                k if k >= layout.strain && k < layout.strain + strains => undeformed.number(k - layout.strain),
                k if k == layout.mass => density * volumes[particle],
                k if k == layout.volume => volumes[particle],
                _ => 0.0,
            })
        });
        let _ = flows::<L>();
        self.bodies.push(Box::new(Body { law, particles, reports: Vec::new() }));
        self.sorted = false;
        Ok(self.bodies.len() - 1)
    }

    fn sort(&mut self) -> Result<(), MpmError> {
        for (number, body) in self.bodies.iter_mut().enumerate() {
            body.particles_mut().sort(number, self.options.spacing, self.options.kernel.width())?;
        }
        let origins: Vec<[i32; D]> = self
            .bodies
            .iter()
            .flat_map(|body| body.particles().blocks.iter().map(|block| block.origin))
            .collect();
        self.grid.rebuild(origins.iter().copied());
        self.arenas.resize(origins.len() * arena_length(D, self.options.kernel.width()), E::default());
        self.sorted = true;
        Ok(())
    }

    /// One step of h \[s\], whatever its length.
    ///
    /// # Errors
    /// See [`MpmError`].
    pub fn step_unchecked(&mut self, step: f64) -> Result<StepReport, MpmError> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(MpmError::Step { value: step });
        }
        let mut report = StepReport::default();
        if !self.sorted {
            self.sort()?;
            report.sorted = true;
        }
        let SimulationOptions { spacing, kernel, transfer } = self.options;
        let settings = StepSettings { step, spacing, kernel, transfer };
        let length = arena_length(D, kernel.width());
        let mut stiff = BlockReport::default();
        let mut first = 0;
        for body in &mut self.bodies {
            let count = body.particles().blocks.len();
            let arenas = &mut self.arenas[first * length..(first + count) * length];
            stiff = stiff.merged(body.scatter(arenas, &settings));
            first += count;
        }
        self.update_grid(&settings);
        let mut moved = BlockReport::default();
        let mut first = 0;
        for body in &mut self.bodies {
            moved = moved.merged(body.gather(&self.grid, first, &settings));
            first += body.particles().blocks.len();
        }
        self.sorted = !moved.left;
        self.time += step;
        report.blocks = self.grid.block_count();
        report.speed = moved.speed_squared.sqrt();
        report.wave_speed = stiff.wave_squared.sqrt();
        Ok(report)
    }

    fn update_grid(&mut self, settings: &StepSettings) {
        self.results.clear();
        self.results.resize(self.grid.block_count(), BlockReport::default());
        let gain = self.gravity.map(|g| g * settings.step);
        self.grid.collect(&self.arenas, &mut self.results, |origin, nodes, changes, report| {
            let _ = origin;
            *report = dispatch(NodeUpdate::<E, D> { nodes, changes, gain });
        });
    }

    /// Time since the start \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Positions of the particles of a body, by their numbers \[m\].
    pub fn positions(&self, body: usize) -> Vec<[f64; D]> {
        let particles = self.bodies[body].particles();
        let slots = particles.slots();
        slots.iter().map(|slot| std::array::from_fn(|axis| particles.number(*slot as usize, axis).into())).collect()
    }
}

/// Momenta become velocities; gravity acts.
struct NodeUpdate<'a, E, const D: usize> {
    nodes: &'a mut [E],
    changes: &'a mut [E],
    gain: [f64; D],
}

impl<E: Element, const D: usize> LaneKernel<E> for NodeUpdate<'_, E, D> {
    type Output = BlockReport;

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> BlockReport {
        for node in self.nodes.chunks_exact_mut(NODE) {
            let mass = node[0];
            if E::default().less(mass) {
                for axis in 0..D {
                    node[1 + axis] = node[1 + axis] / mass + E::constant(self.gain[axis]);
                }
            }
        }
        let _ = (self.changes, BLOCK, block_edge(D));
        BlockReport::default()
    }
}
