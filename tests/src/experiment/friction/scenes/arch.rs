//! A masonry arch.

use super::shots::Shots;
use super::thrust_line::Arch;
use super::{Body, Fate, G, GRAVITY, Judgement, add_body, contact, friction, mismatch, stepping};
use crate::experiment::contact::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::HalfSpace;
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// A semicircular arch of mean radius 1 m and width 0.3 m on the floor, its stones elastic (E = 100 MPa, ρ = 2400 kg/m³), loose, and
/// 0.25 mm apart; the ladder is its thickness (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MasonryArch {
    /// How many stones.
    stones: Count,
    /// μ, where there is friction.
    friction: Positive,
    /// h (s).
    step_s: Positive,
    /// How many steps are made, unless it has fallen before.
    steps: Count,
}

const WIDTH: f64 = 0.3;
const STONE: Material = Material { young: 1e8, poisson: 0.2, density: 2400.0 };
const ACTIVATION: f64 = 5e-4;
const GAP: f64 = 2.5e-4;
const STICK_VELOCITY: f64 = 1e-3;
/// What has sunk so far (m) has fallen.
const FALLEN: f64 = 0.3;
/// What has moved less (m) stands: five times what the gaps of a half arch of 15 stones can close by.
const STANDING: f64 = 0.01;

/// A stone between two angles from the crown.
fn stone(thickness: f64, [from, to]: [f64; 2]) -> Result<TetMesh, ExperimentError> {
    let joint = 0.5 * GAP;
    let low = Vec3::new(-0.5 * thickness, -0.5 * WIDTH, from + joint);
    let high = Vec3::new(0.5 * thickness, 0.5 * WIDTH, to - joint);
    let mut mesh = block(&low, &high, [2, 1, 1], BoxSplit::Six).map_err(ExperimentError::stopped)?;
    mesh.map_points(|p| Vec3::new((1.0 + p.x) * p.z.sin(), p.y, (1.0 + p.x) * p.z.cos()))
        .map_err(ExperimentError::stopped)?;
    mesh.orient();
    Ok(mesh)
}

/// The arch and its stones.
fn build(stones: u32, thickness: f64, mu: f64) -> Result<(World, Vec<Body>), ExperimentError> {
    let mut builder = WorldBuilder::default();
    builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: -0.5 * GAP });
    let angle = |k: u32| PI * (f64::from(k) / f64::from(stones) - 0.5);
    let mut bodies = Vec::new();
    for k in 0..stones {
        bodies.push(add_body(&mut builder, &stone(thickness, [angle(k), angle(k + 1)])?, STONE)?);
    }
    if mu > 0.0 {
        builder = builder.with_friction(friction(mu, STICK_VELOCITY)?);
    }
    // A joint of two equal faces has 44 pairs; together they carry half the arch where its gap is the initial one.
    let weight = STONE.density * PI * thickness * WIDTH * G;
    Ok((builder.build(GRAVITY, contact(ACTIVATION, weight / 88.0), stepping(1e-3))?, bodies))
}

impl Experiment for MasonryArch {
    fn methods(&self) -> &'static [&'static str] {
        &["with-friction", "without-friction"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let stones = self.stones.value() as u32;
        let mu = if at.method == "with-friction" { self.friction.value() } else { 0.0 };
        let (mut world, bodies) = build(stones, at.ladder, mu)?;
        let keystone = &bodies[bodies.len() / 2];
        let mut shots = Shots::new(at, [0.35, -1.0, 0.25], bodies.iter().map(|body| &body.skin[..]));
        let judgement = Judgement { keystone, fallen: FALLEN, standing: STANDING };
        let steps = (self.steps.value(), self.step_s.value());
        let Fate { sunk, largest, stands } = judgement.watch(&mut world, steps, clock, &mut shots)?;
        let arch = Arch { stones, thickness: at.ladder };
        let outcome = world
            .outcome()
            .error("displacement where it should stand", if arch.stands(mu) { largest } else { 0.0 })
            .invariant("verdict against statics", mismatch(arch.stands(mu), stands))
            .invariant("sunk (m)", sunk)
            .invariant("least thickness by statics (m)", Arch::limit(stones, mu));
        Ok(shots.add_to(outcome))
    }
}
