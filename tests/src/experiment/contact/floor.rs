//! A block that comes to rest on the floor.

use super::forms::{FORMS, form, pull};
use super::world::{Material, World, WorldBuilder};
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

const SIDE: f64 = 0.1;
const GRAVITY: f64 = 9.81;
const DENSITY: f64 = 1000.0;
const CELLS: u32 = 3;

/// The part of the activation distance at which a rigid block is to rest.
const PART: f64 = 0.37;

/// A cube over a half-space, with κ for which a rigid one rests at [`PART`] of the activation distance.
struct Block {
    world: World,
    bottom: Vec<usize>,
    gap: f64,
}

impl Block {
    /// The cube at rest, `start` above the floor (m); Newton stops at `tolerance` (m/s).
    fn new(
        form: BarrierForm,
        activation: f64,
        young: f64,
        start: f64,
        tolerance: f64,
    ) -> Result<Self, ExperimentError> {
        let bottom_points = f64::from((CELLS + 1) * (CELLS + 1));
        let weight = DENSITY * SIDE.powi(3) * GRAVITY;
        let gap = PART * activation;
        let kappa = weight / bottom_points / pull(form, activation, gap);
        let (low, high) = (Vec3::new(0.0, 0.0, start), Vec3::new(SIDE, SIDE, start + SIDE));
        let mesh = block(&low, &high, [CELLS; 3], BoxSplit::Six).map_err(ExperimentError::stopped)?;
        let bottom = (0..mesh.points().len()).filter(|&i| mesh.points()[i].z == start).collect();
        let mut builder = WorldBuilder::default();
        builder.add_solid(&mesh, Material { young, poisson: 0.3, density: DENSITY }, Vec3::zeros())?;
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        let contact =
            ContactOptions { form, ..ContactOptions::new(activation, Stiffness::fixed(Scale::Kappa(kappa))) };
        let newton = NewtonOptions { tolerance, ..NewtonOptions::default() };
        let options = StepperOptions { newton, ..StepperOptions::default() };
        let world = builder.build(Vec3::new(0.0, 0.0, -GRAVITY), contact, options)?;
        Ok(Self { world, bottom, gap })
    }

    /// The largest difference of a gap from that of a rigid block, in parts of it.
    fn outcome(&self) -> Outcome {
        let heights = self.bottom.iter().map(|&i| self.world.state.position[i].z);
        let worst = heights.map(|z| (z - self.gap).abs()).fold(0.0, f64::max);
        let fastest = self.world.state.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        self.world
            .outcome()
            .error("gap", worst / self.gap)
            .invariant("fastest point at the end (m/s)", fastest)
    }
}

/// A cube of 0.1 m, 1000 kg/m³, let down on a half-space from the gap it rests at when rigid, and left there for
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

impl Experiment for BlockOnFloor {
    fn methods(&self) -> &'static [&'static str] {
        FORMS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (activation, h) = (self.activation_distance_m.value(), self.step_s.value());
        let tolerance = 1e-7 * activation / h;
        let mut block =
            Block::new(form(at.method), activation, 1.0 / at.ladder, PART * activation, tolerance)?;
        for _ in 0..self.steps.value() {
            block.world.step(h, clock)?;
        }
        Ok(block.outcome())
    }
}

/// The same cube, nearly rigid, let go at some other gap and left until it rests; the ladder is the step h (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GapForEveryStep {
    /// The distance at which contact begins (m).
    activation_distance_m: Positive,
    /// Young's modulus (Pa).
    young_modulus_pa: Positive,
    /// The gap at the start, in parts of the activation distance.
    start: Positive,
    /// For how long it is left (s).
    duration_s: Positive,
    /// But at least for so many steps.
    fewest_steps: Count,
}

impl Experiment for GapForEveryStep {
    fn methods(&self) -> &'static [&'static str] {
        FORMS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (activation, h) = (self.activation_distance_m.value(), at.ladder);
        let (young, start) = (self.young_modulus_pa.value(), self.start.value() * activation);
        let mut block = Block::new(form(at.method), activation, young, start, 1e-7 * activation / h)?;
        let steps = (self.duration_s.value() / h).ceil().max(self.fewest_steps.value() as f64);
        for _ in 0..steps as u64 {
            block.world.step(h, clock)?;
        }
        Ok(block.outcome())
    }
}
