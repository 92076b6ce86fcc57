//! Two bodies rub against each other, and nothing else acts.

use super::surfaces::{ACTIVATION, friction, stepping};
use crate::experiment::contact::particle::{SCHEMES, scheme};
use crate::experiment::contact::portrait::world_pictured;
use crate::experiment::contact::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::basis::relative_velocity;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Two cubes of 0.1 m and 1 kg: the upper comes down on the lower and across it. The ladder is the step h (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GlancingBlow {
    friction_coefficient: Positive,
    /// Where friction reaches all of its bound (m/s).
    stick_velocity_m_s: Positive,
    /// Young's modulus of both (Pa).
    young_modulus_pa: Positive,
    /// What a pair carries at half of the activation distance (N).
    load_n: Positive,
    /// Cells along a side.
    cells: Count,
    /// How long (s).
    duration_s: Positive,
}

const SIDE: f64 = 0.1;

/// What is read after each step, by other means than the forces were made by.
#[derive(Default)]
struct Readings {
    /// Resultant of friction, relative to its sum of magnitudes.
    resultant: f64,
    /// ‖β/‖β‖ + û‖ of pairs that slide, with û from the points' velocities and the normals anew.
    direction: f64,
    /// ‖β‖/(μ λ) of pairs that slide, less one, with λ anew, weighted by what the pair carries of all.
    cone: f64,
    sliding: u64,
}

impl Readings {
    fn add(&mut self, world: &World, mu: f64, stick_velocity: f64) {
        let Some(both) = world.contact.friction() else { return };
        let (x, v) = (&world.state.position, &world.state.velocity);
        let forces = both.friction().forces(x);
        let sum: f64 = forces.iter().map(Vec3::norm).sum();
        if sum > 0.0 {
            self.resultant = self.resultant.max(forces.iter().sum::<Vec3>().norm() / sum);
        }
        let normals = both.contact().normal_forces(x);
        let largest = normals.iter().map(|normal| normal.magnitude).fold(0.0, f64::max);
        for pair in both.pairs(x) {
            let Some(anew) = normals.iter().find(|normal| normal.points() == pair.points()) else { continue };
            let velocity = relative_velocity(anew, v);
            let slip = velocity - anew.normal * anew.normal.dot(&velocity);
            if slip.norm() < 2.0 * stick_velocity || anew.magnitude < 0.01 * largest {
                continue;
            }
            self.sliding += 1;
            self.direction = self.direction.max((pair.force.normalize() + slip.normalize()).norm());
            let beyond = (pair.force.norm() - mu * anew.magnitude).abs() / (mu * largest);
            self.cone = self.cone.max(beyond);
        }
    }
}

impl GlancingBlow {
    fn world(&self, method: &str) -> Result<World, ExperimentError> {
        let cells = [self.cells.value() as u32; 3];
        let cube = |low: Vec3| {
            block(&low, &low.add_scalar(SIDE), cells, BoxSplit::Six).map_err(ExperimentError::stopped)
        };
        let mu = self.friction_coefficient.value();
        let law = friction(mu, mu, self.stick_velocity_m_s.value())?;
        let mut builder = WorldBuilder::default().with_friction(law);
        let material = Material { young: self.young_modulus_pa.value(), poisson: 0.3, density: 1000.0 };
        builder.add_solid(&cube(Vec3::zeros())?, material, Vec3::zeros())?;
        let above = Vec3::new(0.02, 0.01, SIDE + 1.5 * ACTIVATION);
        builder.add_solid(&cube(above)?, material, Vec3::new(0.8, 0.3, -0.7))?;
        let stiffness = Stiffness::fixed(Scale::Load(self.load_n.value()));
        let contact = ContactOptions::new(ACTIVATION, stiffness);
        builder.build(Vec3::zeros(), contact, stepping(1e-9, scheme(method)))
    }
}

impl Experiment for GlancingBlow {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut world = self.world(at.method)?;
        let (mu, stick_velocity) = (self.friction_coefficient.value(), self.stick_velocity_m_s.value());
        let momentum = |world: &World| world.stepper.mass().linear_momentum(&world.state.velocity);
        let before = momentum(&world);
        let (mut drift, mut readings) = (0.0_f64, Readings::default());
        for _ in 0..(self.duration_s.value() / at.ladder).round() as u64 {
            world.step(at.ladder, clock)?;
            drift = drift.max((momentum(&world) - before).norm() / before.norm());
            readings.add(&world, mu, stick_velocity);
        }
        let energy = &world.energy;
        let outcome = world
            .outcome()
            .count("pairs that slide, read", readings.sliding)
            .error("momentum", drift)
            .error("action and reaction", readings.resultant)
            .error("direction", readings.direction)
            .error("cone", readings.cone)
            .invariant("dissipated by friction (J)", energy.friction)
            .invariant("taken by the scheme (J)", energy.numerical);
        world_pictured(outcome, &world, at)
    }
}
