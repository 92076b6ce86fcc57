//! Two bodies collide, and nothing else acts: what is conserved.

use super::particle::{SCHEMES, scheme};
use super::portrait::world_pictured;
use super::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::StepperOptions;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Two cubes of 0.1 m, one of 1000 kg/m³ and the other `mass_ratio` times as dense, collide off their centres; the ladder is the step
/// h (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Collision {
    /// Of the second, which is at rest, to the first.
    mass_ratio: Positive,
    /// How fast the first one comes (m/s).
    speed_m_s: Positive,
    /// Young's modulus of both (Pa).
    young_modulus_pa: Positive,
    /// The distance at which contact begins (m).
    activation_distance_m: Positive,
    /// What a pair carries at half of it (N).
    load_n: Positive,
    /// Cells along a side.
    cells: Count,
    /// How long (s).
    duration_s: Positive,
}

const SIDE: f64 = 0.1;

impl Collision {
    fn world(&self, method: &str) -> Result<World, ExperimentError> {
        let activation = self.activation_distance_m.value();
        let cells = self.cells.value() as u32;
        let cube = |low: Vec3, cells: u32| {
            block(&low, &low.add_scalar(SIDE), [cells; 3], BoxSplit::Six).map_err(ExperimentError::stopped)
        };
        let first = cube(Vec3::zeros(), cells)?;
        let second = cube(Vec3::new(0.04, 0.03, SIDE + 1.05 * activation), cells + 1)?;
        let material =
            |density: f64| Material { young: self.young_modulus_pa.value(), poisson: 0.3, density };
        let mut builder = WorldBuilder::default();
        builder.add_solid(&first, material(1000.0), Vec3::z() * self.speed_m_s.value())?;
        builder.add_solid(&second, material(1000.0 * self.mass_ratio.value()), Vec3::zeros())?;
        let stiffness = Stiffness::fixed(Scale::Load(self.load_n.value()));
        let newton = NewtonOptions { tolerance: 1e-10, ..NewtonOptions::default() };
        let options = StepperOptions { newton, scheme: scheme(method), ..StepperOptions::default() };
        builder.build(Vec3::zeros(), ContactOptions::new(activation, stiffness), options)
    }
}

/// The resultant and the moment of forces about the origin, in parts of the sums of their magnitudes.
fn resultants(forces: &[Vec3], x: &[Vec3]) -> [f64; 2] {
    let sum: Vec3 = forces.iter().sum();
    let moment: Vec3 = x.iter().zip(forces).map(|(x, f)| x.cross(f)).sum();
    let size: f64 = forces.iter().map(|f| f.norm()).sum();
    let lever: f64 = x.iter().zip(forces).map(|(x, f)| x.norm() * f.norm()).sum();
    let part = |value: f64, whole: f64| if whole > 0.0 { value / whole } else { 0.0 };
    [part(sum.norm(), size), part(moment.norm(), lever)]
}

impl Experiment for Collision {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut world = self.world(at.method)?;
        let steps = (self.duration_s.value() / at.ladder).round() as u64;
        let origin = Vec3::zeros();
        let conserved = |world: &World| {
            let (mass, state) = (world.stepper.mass(), &world.state);
            let (elastic, contact) = world.potential_energy();
            (
                mass.linear_momentum(&state.velocity),
                mass.angular_momentum(&state.position, &state.velocity, &origin),
                mass.kinetic_energy(&state.velocity) + elastic + contact,
            )
        };
        let (momentum, spin, energy) = conserved(&world);
        let [mut drift, mut resultant, mut moment, mut most, mut contacts] = [0.0_f64; 5];
        for _ in 0..steps {
            world.step(at.ladder, clock)?;
            let (now, _, energy_now) = conserved(&world);
            drift = drift.max((now - momentum).norm() / momentum.norm());
            most = most.max(energy_now / energy - 1.0);
            let x = &world.state.position;
            let [r, m] = resultants(&world.contact.forces(x), x);
            (resultant, moment) = (resultant.max(r), moment.max(m));
            contacts = contacts.max(world.contact.report().contacts.total() as f64);
        }
        let (_, spin_now, energy_now) = conserved(&world);
        let outcome = world
            .outcome()
            .count("most contacts", contacts as u64)
            .error("linear momentum", drift)
            .error("angular momentum", (spin_now - spin).norm() / spin.norm())
            .error("energy", (energy_now / energy - 1.0).abs())
            .invariant("resultant of contact", resultant)
            .invariant("moment of contact", moment)
            .invariant("energy gained", most);
        world_pictured(outcome, &world, at)
    }
}
