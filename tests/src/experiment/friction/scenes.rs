//! Structures that friction holds, and what it drags along: arches, houses of cards, stacks, table cloths. Each is judged by statics
//! or by a bound in closed form, and after every step nothing may intersect and everything has to be on its side.

mod arch;
mod cards;
mod funnel;
mod knot;
mod knot_type;
mod rollers;
mod shots;
mod stack;
mod tablecloth;
mod tableware;
mod thrust_line;

pub(in crate::experiment) use arch::MasonryArch;
pub(in crate::experiment) use cards::CardHouse;
pub(in crate::experiment) use funnel::Funnel;
pub(in crate::experiment) use knot::PulledKnot;
pub(in crate::experiment) use rollers::BitingRollers;
pub(in crate::experiment) use stack::PulledStack;
pub(in crate::experiment) use tablecloth::Tablecloth;

use crate::experiment::contact::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, ExperimentError};
use ipc_contact::collision_mesh::{CollisionObject, SelfContact};
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::FrictionOptions;
use lagrangian::stepper::{Lagging, StepperOptions};
use mechanics_core::mesh::TetMesh;
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use shots::Shots;
use std::ops::Range;

const G: f64 = 9.81;
const GRAVITY: Vec3 = Vec3::new(0.0, 0.0, -G);
/// At most so many lag iterations a step.
const LAGS: u64 = 8;

/// A solid of the scene.
struct Body {
    points: Range<u32>,
    /// Its surface, outward normals, in the numbers of all points.
    skin: Vec<[u32; 3]>,
}

impl Body {
    /// The mean of its points at the positions `x`.
    fn centre(&self, x: &[Vec3]) -> Vec3 {
        self.points.clone().map(|p| x[p as usize]).sum::<Vec3>() / self.points.len() as f64
    }
}

/// Adds a solid that is too stiff ever to touch itself.
fn add_body(builder: &mut WorldBuilder, mesh: &TetMesh, material: Material) -> Result<Body, ExperimentError> {
    let first = builder.rest().len() as u32;
    let object = CollisionObject::of_tets(mesh, first).map_err(ExperimentError::stopped)?;
    let object = object.with_self_contact(SelfContact::Excluded);
    let skin = object.triangles.clone();
    let points = builder.add_solid_that_touches(mesh, material, Vec3::zeros(), object)?;
    Ok(Body { points, skin })
}

/// What becomes of a structure that is left to itself.
struct Fate {
    /// How far the body that says it has sunk \[m\].
    sunk: f64,
    /// The largest displacement of any point \[m\].
    largest: f64,
    /// Whether it stands, where that is clear.
    stands: Option<bool>,
}

/// When a structure is said to have fallen, and when to stand.
struct Judgement<'a> {
    /// The body that sinks if the structure falls.
    keystone: &'a Body,
    /// What has sunk so far has fallen \[m\].
    fallen: f64,
    /// What has moved less stands \[m\].
    standing: f64,
}

impl Judgement<'_> {
    /// Makes `steps` steps of `step` \[s\] unless the structure has fallen before; takes a picture of where it is then.
    fn watch(
        &self,
        world: &mut World,
        (steps, step): (usize, f64),
        clock: &mut Clock,
        shots: &mut Shots<'_>,
    ) -> Result<Fate, ExperimentError> {
        let start = world.state.position.clone();
        let sunk = |x: &[Vec3]| self.keystone.centre(&start).z - self.keystone.centre(x).z;
        for _ in 0..steps {
            world.step(step, clock)?;
            if sunk(&world.state.position) > self.fallen {
                break;
            }
        }
        let x = &world.state.position;
        let moved = |p: usize| (x[p] - start[p]).norm();
        let largest = (0..x.len()).map(moved).fold(0.0, f64::max);
        shots.take(x, ("displacement", "m", moved), "at the end")?;
        let has_fallen = sunk(x) > self.fallen;
        let stands = if has_fallen { Some(false) } else { (largest < self.standing).then_some(true) };
        Ok(Fate { sunk: sunk(x), largest, stands })
    }
}

/// Contact below `activation` (m) of which a pair carries `load` (N) at half of it.
fn contact(activation: f64, load: f64) -> ContactOptions {
    ContactOptions::new(activation, Stiffness::adaptive(Scale::Load(load)))
}

/// One coefficient for all, smoothed below `stick_velocity` (m/s).
fn friction(coefficient: f64, stick_velocity: f64) -> Result<FrictionOptions, ExperimentError> {
    FrictionOptions::uniform(coefficient, stick_velocity).map_err(ExperimentError::stopped)
}

/// Steps that end at Newton directions below `tolerance` (m/s), with friction lagged until it has settled.
fn stepping(tolerance: f64) -> StepperOptions {
    let newton = NewtonOptions { tolerance, max_iterations: 1000, ..NewtonOptions::default() };
    StepperOptions { newton, lagging: Lagging::AtMost(LAGS), ..StepperOptions::default() }
}

/// 1 where what happened is not what should have, as an invariant.
#[allow(clippy::fn_params_excessive_bools, reason = "a verdict is one")]
fn mismatch(expected: bool, found: Option<bool>) -> f64 {
    f64::from(u8::from(found != Some(expected)))
}
