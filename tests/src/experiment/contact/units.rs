//! The same scene in two systems of units.

use super::forms::form;
use super::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use ipc_contact::contact::ContactOptions;
use ipc_contact::contact_set::Weighting;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::StepperOptions;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Two soft cubes fall on each other, once in m, kg, s and once in mm, g, ms; the ladder is one over the number of steps.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Units {
    /// How fast they meet (m/s).
    speed_m_s: Positive,
    /// The step (s).
    step_s: Positive,
}

/// How many of its units make an SI unit.
struct System {
    length: f64,
    mass: f64,
    time: f64,
}

const SI: System = System { length: 1.0, mass: 1.0, time: 1.0 };
const MILLIMETRES_GRAMS_MILLISECONDS: System = System { length: 1e3, mass: 1e3, time: 1e3 };

impl System {
    fn pressure(&self) -> f64 {
        self.mass / (self.length * self.time * self.time)
    }

    fn acceleration(&self) -> f64 {
        self.length / (self.time * self.time)
    }

    fn world(&self, method: &str, speed: f64) -> Result<World, ExperimentError> {
        let cube = |low: [f64; 3], cells: u32| {
            let low = Vec3::from(low);
            let [low, high] = [low, low.add_scalar(0.1)].map(|corner| corner * self.length);
            block(&low, &high, [cells; 3], BoxSplit::Six).map_err(ExperimentError::stopped)
        };
        let velocity = self.length / self.time;
        let density = 1000.0 * self.mass / self.length.powi(3);
        let material = Material { young: 2e5 * self.pressure(), poisson: 0.4, density };
        let mut builder = WorldBuilder::default();
        builder.add_solid(&cube([0.0; 3], 3)?, material, Vec3::zeros())?;
        builder.add_solid(&cube([0.04, 0.03, 0.102], 2)?, material, Vec3::z() * (-speed * velocity))?;
        let weighting = if method.ends_with("-area") { Weighting::Area } else { Weighting::Unit };
        let load = match weighting {
            Weighting::Unit => 1.0 * self.pressure() * self.length * self.length,
            Weighting::Area => 2000.0 * self.pressure(),
        };
        let contact = ContactOptions {
            form: form(method.trim_end_matches("-area")),
            weighting,
            ..ContactOptions::new(1e-3 * self.length, Stiffness::adaptive(Scale::Load(load)))
        };
        let newton = NewtonOptions { tolerance: 1e-8 * velocity, ..NewtonOptions::default() };
        let options = StepperOptions { newton, ..StepperOptions::default() };
        builder.build(Vec3::z() * (-9.81 * self.acceleration()), contact, options)
    }
}

impl Experiment for Units {
    fn methods(&self) -> &'static [&'static str] {
        &[
            "squared-distance",
            "distance",
            "physical",
            "squared-distance-area",
            "distance-area",
            "physical-area",
        ]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let other = MILLIMETRES_GRAMS_MILLISECONDS;
        let (speed, h) = (self.speed_m_s.value(), self.step_s.value());
        let mut worlds = [SI.world(at.method, speed)?, other.world(at.method, speed)?];
        let mut iterations = [0; 2];
        let mut closest = f64::INFINITY;
        for _ in 0..(1.0 / at.ladder).round() as u64 {
            for ((world, time), count) in worlds.iter_mut().zip([SI.time, other.time]).zip(&mut iterations) {
                *count += world.step(h * time, clock)?.newton.iterations;
            }
            closest = closest.min(worlds[0].contact.report().smallest_distance.unwrap_or(f64::INFINITY));
        }
        let [si, scaled] = &worlds;
        let pairs = si.state.position.iter().zip(&scaled.state.position);
        let worst = pairs.map(|(x, y)| (x - y / other.length).norm()).fold(0.0, f64::max);
        Ok(si
            .outcome()
            .error("difference", worst / 0.1)
            .invariant("difference in Newton iterations", iterations[0].abs_diff(iterations[1]) as f64)
            .invariant("smallest distance (m)", closest))
    }
}
