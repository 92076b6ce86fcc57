//! A stack of boxes whose lowest is pulled away.

use super::shots::Shots;
use super::{Body, G, GRAVITY, add_body, contact, stepping};
use crate::experiment::contact::world::{Material, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::HalfSpace;
use ipc_friction::FrictionOptions;
use ipc_friction::coefficients::CoefficientTable;
use ipc_friction::law::{FrictionCoefficient, SmoothedCoulomb};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Four boxes of 0.1 × 0.1 × 0.05 m, E = 1 MPa, one on the other on the floor. The face of the lowest is pulled with a constant
/// acceleration, for a way of 0.02 m; the ladder is this acceleration over μ g.
///
/// # Statics
/// Only friction moves what is above: n boxes of mass m with μ n m g at most. So all go along with accelerations a ≤ μ g,
/// and above that those above the lowest move by ½ μ g t², whatever a is. They stay together because between them the coefficient is 2μ; with μ
/// there, too, they would be just about to slide on each other.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PulledStack {
    /// μ between the lowest box and what it touches.
    friction: Positive,
    /// How many steps the pull takes.
    steps: Count,
}

const SIDE: f64 = 0.1;
const HEIGHT: f64 = 0.05;
const BOXES: u32 = 4;
const BOX: Material = Material { young: 1e6, poisson: 0.3, density: 500.0 };
const ACTIVATION: f64 = 1e-3;
const GAP: f64 = 5e-4;
const STICK_VELOCITY: f64 = 1e-3;
/// How far the lowest is pulled (m).
const WAY: f64 = 0.02;
/// Each box is turned by this against the one below (rad): parallel edges that lie exactly on each other lock.
const TURN: f64 = 0.15;
/// The steps that settle the stack before (s), and how many.
const SETTLING: (f64, u32) = (0.01, 30);

/// `p` turned about the upright axis of the stack.
fn turned(p: &Vec3, angle: f64) -> Vec3 {
    let (s, c) = angle.sin_cos();
    let middle = Vec3::new(0.5 * SIDE, 0.5 * SIDE, 0.0);
    let arm = p - middle;
    middle + Vec3::new(c * arm.x - s * arm.y, s * arm.x + c * arm.y, arm.z)
}

/// μ between the lowest box and what it touches, 2μ between the others.
fn rough_above(mu: f64) -> Result<FrictionOptions, ExperimentError> {
    let coefficient = |mu| FrictionCoefficient::new(mu).map_err(ExperimentError::stopped);
    let table = CoefficientTable::uniform(coefficient(2.0 * mu)?)
        .with_objects([0, 1], coefficient(mu)?)
        .with_half_space(0, coefficient(mu)?);
    let law = SmoothedCoulomb::new(STICK_VELOCITY).map_err(ExperimentError::stopped)?;
    Ok(FrictionOptions::new(law, table))
}

impl Experiment for PulledStack {
    fn methods(&self) -> &'static [&'static str] {
        &["backward-euler"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mu = self.friction.value();
        let mut builder = WorldBuilder::default();
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        let mut boxes: Vec<Body> = Vec::new();
        for k in 0..BOXES {
            let low = Vec3::new(0.0, 0.0, GAP + f64::from(k) * (HEIGHT + GAP));
            let mut mesh = block(&low, &(low + Vec3::new(SIDE, SIDE, HEIGHT)), [3, 3, 2], BoxSplit::Six)
                .map_err(ExperimentError::stopped)?;
            mesh.map_points(|p| turned(p, TURN * f64::from(k))).map_err(ExperimentError::stopped)?;
            boxes.push(add_body(&mut builder, &mesh, BOX)?);
        }
        let is_pulled = |p: &u32| builder.rest()[*p as usize].x > 0.99 * SIDE;
        let pulled: Vec<u32> = boxes[0].points.clone().filter(is_pulled).collect();
        builder.script(pulled.iter().copied());
        let weight = BOX.density * SIDE * SIDE * HEIGHT * G;
        // Two turned faces have about 80 pairs.
        let load = weight * f64::from(BOXES - 1) / 80.0;
        let mut world = builder.with_friction(rough_above(mu)?).build(
            GRAVITY,
            contact(ACTIVATION, load),
            stepping(1e-4),
        )?;
        for _ in 0..SETTLING.1 {
            world.step(SETTLING.0, clock)?;
        }
        let start = world.state.position.clone();
        let acceleration = at.ladder * mu * G;
        let duration = (2.0 * WAY / acceleration).sqrt();
        let h = duration / self.steps.value() as f64;
        for step in 1..=self.steps.value() {
            let t = h * step as f64;
            let way = Vec3::x() * (0.5 * acceleration * t * t);
            for &point in &pulled {
                world.move_to(point, start[point as usize] + way)?;
            }
            world.step(h, clock)?;
        }
        let x = &world.state.position;
        let way = |body: &Body| (body.centre(x) - body.centre(&start)).x;
        let expected = 0.5 * acceleration.min(mu * G) * duration * duration;
        let above: Vec<f64> = boxes[1..].iter().map(way).collect();
        // Friction at its base also tips the stack back on the soft layer of contact, so that its boxes differ; their mean does not know of it.
        let mean = above.iter().sum::<f64>() / above.len() as f64;
        let mut shots = Shots::new(at, [0.35, -1.0, 0.3], boxes.iter().map(|body| &body.skin[..]));
        shots.take(x, ("way along x", "m", |p| (x[p] - start[p]).x), "at the end")?;
        let outcome = world
            .outcome()
            .error("way of the boxes above", (mean / expected - 1.0).abs())
            .invariant(
                "mean way of the boxes above over ½ μ g t²",
                mean / (0.5 * mu * G * duration * duration),
            )
            .invariant("way of the box above, over that of the pull", above[0] / WAY)
            .invariant("way of the top, over that of the pull", above[above.len() - 1] / WAY);
        Ok(shots.add_to(outcome))
    }
}
