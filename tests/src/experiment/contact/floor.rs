//! A block that comes to rest on the floor.

use super::world::{Material, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::HalfSpace;
use ipc_contact::contact::{BarrierForm, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::StepperOptions;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A stiff cube of 0.1 m, 1000 kg/m³, let down on a half-space from the gap it rests at when rigid, and left there for
/// some steps; the ladder is the reciprocal of Young's modulus (1/Pa). The gap against that of a rigid block, where the forces
/// of the points under it balance its weight.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BlockOnFloor {
    /// The step (s): the gap must not depend on it.
    step_s: Positive,
    /// How many steps are made.
    steps: Count,
    /// The distance at which contact begins (m).
    activation_distance_m: Positive,
}

const SIDE: f64 = 0.1;
const GRAVITY: f64 = 9.81;
const DENSITY: f64 = 1000.0;

fn form(method: &str) -> BarrierForm {
    match method {
        "distance" => BarrierForm::Distance,
        "physical" => BarrierForm::Physical,
        _ => BarrierForm::SquaredDistance,
    }
}

/// The part of the activation distance at which a rigid block is to rest.
const PART: f64 = 0.37;

/// −∂b/∂d at the distance `d` of a barrier that begins at `a`, from the formulas of the forms.
fn pull(form: BarrierForm, a: f64, d: f64) -> f64 {
    let slope = |r: f64| 2.0 * (r - 1.0) * r.ln() + (r - 1.0).powi(2) / r;
    let squares = (d / a).powi(2);
    match form {
        BarrierForm::SquaredDistance => 2.0 * d * a * a * slope(squares),
        BarrierForm::Distance => a * slope(d / a),
        BarrierForm::Physical => 2.0 * d / a * slope(squares),
    }
}

impl Experiment for BlockOnFloor {
    fn methods(&self) -> &'static [&'static str] {
        &["squared-distance", "distance", "physical"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let form = form(at.method);
        let (activation, gap) =
            (self.activation_distance_m.value(), PART * self.activation_distance_m.value());
        let cells = 3;
        let bottom_points = f64::from((cells + 1) * (cells + 1));
        let weight = DENSITY * SIDE.powi(3) * GRAVITY;
        let kappa = weight / bottom_points / pull(form, activation, gap);
        let mesh =
            block(&Vec3::new(0.0, 0.0, gap), &Vec3::new(SIDE, SIDE, gap + SIDE), [cells; 3], BoxSplit::Six)
                .map_err(ExperimentError::stopped)?;
        let material = Material { young: 1.0 / at.ladder, poisson: 0.3, density: DENSITY };
        let mut builder = WorldBuilder::default();
        builder.add_solid(&mesh, material, Vec3::zeros())?;
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        let contact =
            ContactOptions { form, ..ContactOptions::new(activation, Stiffness::fixed(Scale::Kappa(kappa))) };
        let h = self.step_s.value();
        let newton = NewtonOptions { tolerance: 1e-7 * activation / h, ..NewtonOptions::default() };
        let options = StepperOptions { newton, ..StepperOptions::default() };
        let mut world = builder.build(Vec3::new(0.0, 0.0, -GRAVITY), contact, options)?;
        for _ in 0..self.steps.value() {
            world.step(h, clock)?;
        }
        let heights = world.state.position.iter().zip(mesh.points()).filter(|(_, rest)| rest.z == gap);
        let worst = heights.map(|(x, _)| (x.z - gap).abs()).fold(0.0, f64::max);
        let fastest = world.state.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        Ok(world.outcome().error("gap", worst / gap).invariant("fastest point at the end (m/s)", fastest))
    }
}
