//! Very many steps: what they leave behind in memory.

use super::contact::portrait::world_pictured;
use super::contact::world::{Material, World, WorldBuilder};
use super::particles::portrait::{Portrait, pictured};
use super::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::runner::environment::resident_memory_bytes;
use ipc_contact::collision_mesh::CollisionObject;
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::FrictionOptions;
use lagrangian::stepper::{Lagging, StepperOptions};
use mechanics_core::law::Lame;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::tensor::Vec3;
use mpm_constitutive::elastic::FixedCorotated;
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle};
use mpm_core::sampling::{Pattern, SampledBody, sample_shape};
use mpm_core::{Boundary, Samples, Shape, Simulation, SimulationOptions, Surface};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

/// Steps of a small scene that never comes to rest; the ladder is how many.
///
/// - `contact`: a soft cube of 0.1 m and 1 kg with friction on a plate that goes round in a circle and up and down.
/// - `particles`: sand and jelly in the plane, in a box of 0.4 m; gravity turns round once in two seconds.
///
/// The resident memory at the end is compared with that after a tenth of the steps, 1000 at most.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Soak {}

const GRAVITY: f64 = 9.81;

impl Experiment for Soak {
    fn methods(&self) -> &'static [&'static str] {
        &["contact", "particles"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let steps = at.ladder as u64;
        if at.method == "contact" { rub(steps, at, clock) } else { slosh(steps, at, clock) }
    }
}

/// What is held in memory, early and at the end.
struct Memory {
    early: u64,
    at: u64,
}

impl Memory {
    /// Of so many steps.
    fn of(steps: u64) -> Self {
        Self { early: 0, at: (steps / 10).min(1000) }
    }

    fn look(&mut self, step: u64) {
        if step == self.at {
            self.early = resident_memory_bytes();
        }
    }

    /// Whole mebibytes, so that repeats agree: allocators give back in pages.
    fn growth(&self) -> f64 {
        (resident_memory_bytes().saturating_sub(self.early) >> 20) as f64
    }
}

/// The plate's circle and stroke \[m\], how often it goes round \[1/s\], and the step \[s\].
const CIRCLE: f64 = 5e-3;
const STROKE: f64 = 1e-3;
const FREQUENCY: f64 = 2.0;
const STEP: f64 = 5e-3;

/// Where the plate is.
fn plate(time: f64) -> Vec3 {
    let (sin, cos) = (TAU * FREQUENCY * time).sin_cos();
    // It starts from rest.
    let begun = 1.0 - (-time / 0.1).exp();
    Vec3::new(CIRCLE * sin, CIRCLE * (1.0 - cos), 0.5 * STROKE * (1.0 - (3.0 * TAU * FREQUENCY * time).cos()))
        * begun
}

fn rub(steps: u64, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
    let activation = 1e-3;
    let friction = FrictionOptions::uniform(0.5, 1e-3).map_err(ExperimentError::stopped)?;
    let mut builder = WorldBuilder::default().with_friction(friction);
    let low = Vec3::new(-0.05, -0.05, 0.5 * activation);
    let cube = block(&low, &low.add_scalar(0.1), [2; 3], BoxSplit::Six).map_err(ExperimentError::stopped)?;
    builder.add_solid(&cube, Material { young: 1e5, poisson: 0.3, density: 1000.0 }, Vec3::zeros())?;
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let points = builder.add_obstacle(&corners, |first| {
        CollisionObject::new([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|p| p + first)).to_vec())
    });
    let options = StepperOptions { lagging: Lagging::AtMost(3), ..StepperOptions::default() };
    let contact = ContactOptions::new(activation, Stiffness::fixed(Scale::Load(2.0)));
    let mut world = builder.build(Vec3::new(0.0, 0.0, -GRAVITY), contact, options)?;
    let mut memory = Memory::of(steps);
    let kinetic = |world: &World| world.stepper.mass().kinetic_energy(&world.state.velocity);
    let unit = world.stepper.mass().total() * (TAU * FREQUENCY * CIRCLE).powi(2);
    let mut largest = 0.0_f64;
    for step in 1..=steps {
        let place = plate(step as f64 * STEP);
        for (point, corner) in points.clone().zip(&corners) {
            world.move_to(point, corner + place)?;
        }
        world.step(STEP, clock)?;
        largest = largest.max(kinetic(&world) / unit);
        memory.look(step);
    }
    let outcome = world.outcome().invariant("growth of memory (MiB)", memory.growth());
    let outcome = outcome.invariant("largest kinetic energy by that of the plate's speed", largest);
    world_pictured(outcome, &world, at)
}

const SPACING: f64 = 0.05;
const BOX: f64 = 0.4;

fn sloshing() -> Result<Simulation<f64, 2>, ExperimentError> {
    let mut simulation =
        Simulation::<f64, 2>::new(SimulationOptions::new(SPACING)).map_err(ExperimentError::stopped)?;
    let walls = Shape::Walls { low: [0.0; 2], high: [BOX; 2] };
    let boundary = Boundary::at_rest(walls, Surface::Separating);
    simulation.add_boundary(boundary).map_err(ExperimentError::stopped)?;
    let lame = Lame::from_young_poisson(1e5, 0.3).map_err(ExperimentError::stopped)?;
    let angle = FrictionAngle::constant(30.0_f64.to_radians()).map_err(ExperimentError::stopped)?;
    let sand = DruckerPrager::new(lame, angle, 0.0).map_err(ExperimentError::stopped)?;
    let sample = |centre: [f64; 2]| {
        let shape = Shape::Cuboid { centre, half: [0.15, 0.05] };
        sample_shape(&shape, Pattern::regular(SPACING, 2), 1).map_err(ExperimentError::stopped)
    };
    let SampledBody { positions, volumes } = sample([0.2, 0.05])?;
    let velocities = vec![[0.0; 2]; positions.len()];
    let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
    simulation.add_body(sand, 1600.0, samples).map_err(ExperimentError::stopped)?;
    let SampledBody { positions, volumes } = sample([0.2, 0.3])?;
    let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
    simulation.add_body(FixedCorotated::new(lame), 1000.0, samples).map_err(ExperimentError::stopped)?;
    Ok(simulation)
}

fn slosh(steps: u64, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
    let mut simulation = sloshing()?;
    let mass: f64 = (0..2).map(|body| simulation.totals(body).mass).sum();
    let mut memory = Memory::of(steps);
    let mut largest = 0.0_f64;
    for step in 1..=steps {
        let (sin, cos) = (0.5 * TAU * simulation.time()).sin_cos();
        simulation.set_gravity([GRAVITY * sin, -GRAVITY * cos]).map_err(ExperimentError::stopped)?;
        let h = 0.9 * simulation.stable_step();
        clock.time(|| simulation.step(h)).map_err(ExperimentError::stopped)?;
        if step % 64 == 0 {
            let kinetic = |body: usize| {
                let totals = simulation.totals(body);
                totals.kinetic_energy + totals.affine_energy
            };
            largest = largest.max((kinetic(0) + kinetic(1)) / (mass * GRAVITY * BOX));
        }
        memory.look(step);
    }
    let mut outcome = Outcome::default()
        .count("steps", simulation.steps())
        .invariant("growth of memory (MiB)", memory.growth())
        .invariant("largest kinetic energy by mgL", largest)
        .state(simulation.state_hash());
    outcome.simulated_seconds = Some(simulation.time());
    pictured(outcome, at, "sand and jelly at the end, coloured by speed", || {
        let bodies = || 0..simulation.body_count();
        let speed = |v: &[f64; 2]| v[0].hypot(v[1]);
        Portrait {
            positions: bodies().flat_map(|body| simulation.positions(body)).collect(),
            values: bodies()
                .flat_map(|body| simulation.velocities(body).iter().map(speed).collect::<Vec<_>>())
                .collect(),
            radius: 0.25 * SPACING,
            field: ("speed", "m/s"),
            lines: vec![vec![[0.0, 0.0], [BOX, 0.0], [BOX, BOX], [0.0, BOX], [0.0, 0.0]]],
            label: format!("{steps} steps"),
            ..Portrait::default()
        }
    })
}
