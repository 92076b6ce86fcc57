//! A particle on a plate that moves: the order of time schemes in contact.

use super::forms::pull;
use super::world::WorldBuilder;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use ipc_contact::collision_mesh::CollisionObject;
use ipc_contact::contact::{BarrierForm, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::{StepperOptions, TimeScheme};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A particle of 1 kg in gravity, in contact with a plate of two triangles that moves up and down; the ladder is the step h (s).
/// Its height against the solution of m z̈ = κ |b′(z − plate)| − m g by the classical Runge–Kutta method with steps of 2 µs.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParticleOnPlate {
    /// The distance at which contact begins (m).
    activation_distance_m: Positive,
    /// How far the plate moves (m).
    amplitude_m: Positive,
    /// How often it does (1/s).
    frequency_hz: Positive,
    /// For how long (s).
    duration_s: Positive,
}

const GRAVITY: f64 = 9.81;
const FORM: BarrierForm = BarrierForm::SquaredDistance;
const SUBSTEP: f64 = 2e-6;

pub(in crate::experiment) const SCHEMES: &[&str] = &["backward-euler", "bdf2", "newmark"];

/// The scheme that a method names.
pub(in crate::experiment) fn scheme(method: &str) -> TimeScheme {
    match method {
        "bdf2" => TimeScheme::Bdf2,
        "newmark" => TimeScheme::Newmark,
        _ => TimeScheme::BackwardEuler,
    }
}

impl ParticleOnPlate {
    /// The plate: at rest at first, with no acceleration.
    fn plate(&self, t: f64) -> f64 {
        let phase = std::f64::consts::TAU * self.frequency_hz.value() * t;
        self.amplitude_m.value() * (1.0 - phase.cos()) * (1.0 - (-phase * phase).exp())
    }

    /// κ with which the particle rests at half of the activation distance.
    fn stiffness(&self) -> f64 {
        let a = self.activation_distance_m.value();
        GRAVITY / pull(FORM, a, 0.5 * a)
    }

    fn advance(&self, [z, v]: [f64; 2], t: f64, h: f64) -> [f64; 2] {
        let (a, kappa) = (self.activation_distance_m.value(), self.stiffness());
        let rate = |t: f64, [z, v]: [f64; 2]| [v, kappa * pull(FORM, a, z - self.plate(t)) - GRAVITY];
        let ahead = |k: [f64; 2], part: f64| [z + part * k[0], v + part * k[1]];
        let substeps = (h / SUBSTEP).ceil();
        if substeps > 1.0 {
            let part = h / substeps;
            return (0..substeps as u64)
                .fold([z, v], |state, i| self.advance(state, t + i as f64 * part, part));
        }
        let k1 = rate(t, [z, v]);
        let k2 = rate(t + 0.5 * h, ahead(k1, 0.5 * h));
        let k3 = rate(t + 0.5 * h, ahead(k2, 0.5 * h));
        let k4 = rate(t + h, ahead(k3, h));
        [0, 1].map(|i| [z, v][i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }
}

impl Experiment for ParticleOnPlate {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (activation, h) = (self.activation_distance_m.value(), at.ladder);
        let mut builder = WorldBuilder::default();
        let start = Vec3::new(0.3, 0.2, 0.5 * activation);
        let particle = builder
            .add_masses(&[start], 1.0, Vec3::zeros(), |first| {
                CollisionObject { points: vec![first], ..CollisionObject::default() }
                    .with_thickness(activation)
            })
            .start;
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let plate = builder.add_obstacle(&corners, |first| {
            CollisionObject::new(
                vec![[0, 1, 2], [0, 2, 3]].into_iter().map(|t| t.map(|p| p + first)).collect(),
            )
        });
        let stiffness = Stiffness::fixed(Scale::Kappa(self.stiffness()));
        let contact = ContactOptions { form: FORM, ..ContactOptions::new(activation, stiffness) };
        let newton = NewtonOptions { tolerance: 1e-11, ..NewtonOptions::default() };
        let options = StepperOptions { newton, scheme: scheme(at.method), ..StepperOptions::default() };
        let mut world = builder.build(Vec3::new(0.0, 0.0, -GRAVITY), contact, options)?;
        let steps = (self.duration_s.value() / h).round() as u64;
        let (mut exact, mut worst) = ([start.z, 0.0], 0.0_f64);
        for step in 0..steps {
            let t = step as f64 * h;
            let height = Vec3::z() * self.plate(t + h);
            for (point, corner) in plate.clone().zip(&corners) {
                world.move_to(point, corner + height)?;
            }
            world.step(h, clock)?;
            exact = self.advance(exact, t, h);
            worst = worst.max((world.state.position[particle as usize].z - exact[0]).abs());
        }
        Ok(world.outcome().error("height", worst / activation))
    }
}
