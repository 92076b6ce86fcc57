//! An elastic bar that hits a wall.

use super::particle::{SCHEMES, scheme};
use super::press::face_at;
use super::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::HalfSpace;
use ipc_contact::contact::ContactOptions;
use ipc_contact::contact_set::Weighting;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::{StepperOptions, TimeScheme};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A bar of 1 m with ν = 0 and wave speed c = 100 m/s flies into a half-space with its axis along the normal; the ladder is the length
/// Δx (m) of its cells, and the step is tied to it. In the wave solution the end is pushed with ρ c v a unit area for the time
/// 2L/c, after which all of the bar moves with −v.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BarImpact {
    /// v/c.
    speed_ratio: Positive,
    /// Cells across; as wide as one cell of the coarsest ladder point is long.
    cells_across: Count,
    /// The width (m).
    width_m: Positive,
    /// c h / Δx.
    courant: Positive,
    /// The activation distance in parts of v Δx / c.
    activation: Positive,
}

const WAVE_SPEED: f64 = 100.0;
const DENSITY: f64 = 1000.0;
const YOUNG: f64 = DENSITY * WAVE_SPEED * WAVE_SPEED;

/// What was recorded at the ends of steps.
#[derive(Default)]
struct Record {
    /// Momentum (kg m/s), force of contact (N), energy (J).
    momentum: Vec<f64>,
    force: Vec<f64>,
    energy: Vec<f64>,
}

impl Record {
    fn add(&mut self, world: &World) {
        let mass = world.stepper.mass();
        self.momentum.push(mass.linear_momentum(&world.state.velocity).z);
        self.force.push(world.contact.forces(&world.state.position).iter().map(|f| f.z).sum());
        let (elastic, contact) = world.potential_energy();
        self.energy.push(mass.kinetic_energy(&world.state.velocity) + elastic + contact);
    }

    /// The time between the first and the last passage of the force through `level` (N), in steps.
    fn duration(&self, level: f64) -> f64 {
        let force = &self.force;
        let crossings: Vec<f64> = (1..force.len())
            .filter(|&i| (force[i - 1] < level) != (force[i] < level))
            .map(|i| (i - 1) as f64 + (level - force[i - 1]) / (force[i] - force[i - 1]))
            .collect();
        match crossings[..] {
            [first, .., last] => last - first,
            _ => f64::NAN,
        }
    }

    /// The largest residual of the scheme's own balance of momentum and force.
    fn imbalance(&self, scheme: TimeScheme, h: f64) -> f64 {
        let (p, f) = (&self.momentum, &self.force);
        let residual = |i: usize| match scheme {
            TimeScheme::Newmark => p[i] - p[i - 1] - 0.5 * h * (f[i] + f[i - 1]),
            TimeScheme::Bdf2 if i > 1 => 1.5 * p[i] - 2.0 * p[i - 1] + 0.5 * p[i - 2] - h * f[i],
            _ => p[i] - p[i - 1] - h * f[i],
        };
        (1..p.len()).map(|i| residual(i).abs()).fold(0.0, f64::max)
    }
}

impl Experiment for BarImpact {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let speed = self.speed_ratio.value() * WAVE_SPEED;
        let (dx, h) = (at.ladder, self.courant.value() * at.ladder / WAVE_SPEED);
        let activation = self.activation.value() * speed * dx / WAVE_SPEED;
        let (across, width) = (self.cells_across.value() as u32, self.width_m.value());
        let (low, high) = (Vec3::new(0.0, 0.0, activation), Vec3::new(width, width, 1.0 + activation));
        let mesh = block(&low, &high, [across, across, (1.0 / dx).round() as u32], BoxSplit::Six)
            .map_err(ExperimentError::stopped)?;
        let material = Material { young: YOUNG, poisson: 0.0, density: DENSITY };
        let mut builder = WorldBuilder::default();
        let object = face_at(&mesh, activation, 0)?;
        builder.add_solid_that_touches(&mesh, material, Vec3::z() * -speed, object)?;
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        let pressure = DENSITY * WAVE_SPEED * speed;
        let stiffness = Stiffness::fixed(Scale::Load(pressure));
        let contact =
            ContactOptions { weighting: Weighting::Area, ..ContactOptions::new(activation, stiffness) };
        let newton = NewtonOptions { tolerance: 1e-5 * speed, ..NewtonOptions::default() };
        let scheme = scheme(at.method);
        let options = StepperOptions { newton, scheme, ..StepperOptions::default() };
        let mut world = builder.build(Vec3::zeros(), contact, options)?;

        let steps = ((2.6 / WAVE_SPEED + activation / speed) / h).ceil() as u64;
        let mut record = Record::default();
        record.add(&world);
        for _ in 0..steps {
            world.step(h, clock)?;
            record.add(&world);
        }
        let (start, end) = (record.momentum[0], record.momentum[steps as usize]);
        let duration = record.duration(0.5 * pressure * width * width) * h;
        let energy = |i: usize| record.energy[i] / record.energy[0] - 1.0;
        let highest = (0..=steps as usize).map(energy).fold(0.0, f64::max);
        Ok(world
            .outcome()
            .error("separation velocity", (end / start + 1.0).abs())
            .error("contact time", (duration * WAVE_SPEED / 2.0 - 1.0).abs())
            .error("energy", energy(steps as usize).abs())
            .invariant("momentum less impulse", record.imbalance(scheme, h) / start.abs())
            .invariant("energy gained", highest))
    }
}
