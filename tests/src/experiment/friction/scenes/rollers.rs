//! A block on two rollers that turn towards each other.

use super::shots::Shots;
use super::{GRAVITY, add_body, contact, friction, mismatch, stepping};
use crate::experiment::contact::world::{Material, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::{CollisionObject, SelfContact};
use mechanics_core::mesh::{BoxSplit, CylinderEnds, TriMesh, block, cylinder_surface};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A block of width 2b = 0.1 m, 0.15 m high, E = 5 MPa, lies on two rollers of radius 0.1 m that turn towards each other, so far apart that it
/// touches them at the bite angle α from the line between their axes; the ladder is μ over tan α.
///
/// # Statics
/// A roller pushes the block up by N sin α and draws it down by μ N cos α. It bites for μ > tan α. Below, the block stays where it is.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BitingRollers {
    /// α (degrees).
    bite_degrees: Positive,
    /// Speed of the rollers' surfaces (m/s).
    speed_m_s: Positive,
    /// h (s).
    step_s: Positive,
    /// How many steps are made, unless it has been drawn through before.
    steps: Count,
}

const RADIUS: f64 = 0.1;
const HALF_WIDTH: f64 = 0.05;
const HEIGHT: f64 = 0.15;
const DEPTH: f64 = 0.1;
/// Points around a roller over six.
const RINGS: u32 = 14;
/// Edge of the block's cells (m).
const CELL: f64 = 0.025;
const ACTIVATION: f64 = 1e-3;
const SOFT: Material = Material { young: 5e6, poisson: 0.4, density: 1000.0 };
const STICK_VELOCITY: f64 = 1e-3;

/// A roller about the y axis, deeper than the block.
fn roller() -> Result<TriMesh, ExperimentError> {
    let deep = 1.4 * DEPTH;
    let mut mesh =
        cylinder_surface(RADIUS, deep, RINGS, 2, CylinderEnds::Open).map_err(ExperimentError::stopped)?;
    mesh.map_points(|p| Vec3::new(p.x, p.z - 0.5 * deep, -p.y)).map_err(ExperimentError::stopped)?;
    Ok(mesh)
}

/// `p` turned about the y axis.
fn turned(p: &Vec3, angle: f64) -> Vec3 {
    let (s, c) = angle.sin_cos();
    Vec3::new(c * p.x + s * p.z, p.y, c * p.z - s * p.x)
}

impl Experiment for BitingRollers {
    fn methods(&self) -> &'static [&'static str] {
        &["backward-euler"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let bite = self.bite_degrees.value().to_radians();
        let mu = at.ladder * bite.tan();
        let gap = 0.9 * ACTIVATION;
        let axis = HALF_WIDTH + (RADIUS + gap) * bite.cos();
        let bottom = (RADIUS + gap) * bite.sin();
        let mut builder = WorldBuilder::default();
        let low = Vec3::new(-HALF_WIDTH, -0.5 * DEPTH, bottom);
        let high = Vec3::new(HALF_WIDTH, 0.5 * DEPTH, bottom + HEIGHT);
        let mesh = block(&low, &high, [4, 4, 6], BoxSplit::Six).map_err(ExperimentError::stopped)?;
        let body = add_body(&mut builder, &mesh, SOFT)?;
        let roller = roller()?;
        let mut rollers = Vec::new();
        for side in [-1.0, 1.0] {
            let centre = Vec3::x() * (side * axis);
            let points: Vec<Vec3> = roller.points().iter().map(|p| p + centre).collect();
            let points = builder.add_obstacle(&points, |first| {
                CollisionObject::of_mesh(&roller, first).with_self_contact(SelfContact::Excluded)
            });
            rollers.push((side, centre, points));
        }
        let skins: Vec<Vec<[u32; 3]>> = rollers
            .iter()
            .map(|(.., points)| roller.triangles().iter().map(|t| t.map(|p| p + points.start)).collect())
            .collect();
        let mut world = builder.with_friction(friction(mu, STICK_VELOCITY)?).build(
            GRAVITY,
            contact(ACTIVATION, 0.5 * SOFT.young * CELL * ACTIVATION),
            // Contact is so stiff that 1 mm/s leaves 2 % of the energy unaccounted for.
            stepping(1e-5),
        )?;
        let start = body.centre(&world.state.position);
        let mut shots =
            Shots::new(at, [0.25, -1.0, 0.3], skins.iter().map(|skin| &skin[..]).chain([&body.skin[..]]));
        let h = self.step_s.value();
        let steps = self.steps.value();
        for step in 1..=steps {
            let angle = self.speed_m_s.value() / RADIUS * h * step as f64;
            for (side, centre, points) in &rollers {
                for (point, rest) in points.clone().zip(roller.points()) {
                    // The left one turns clockwise, seen along +y: its right side goes down.
                    world.move_to(point, centre + turned(rest, -side * angle))?;
                }
            }
            world.step(h, clock)?;
            let x = &world.state.position;
            if step == steps / 3 {
                shots.take(x, ("height", "m", |p| x[p].z), "on the way")?;
            }
            if body.centre(x).z < 0.0 {
                break;
            }
        }
        let x = &world.state.position;
        let sunk = start.z - body.centre(x).z;
        shots.take(x, ("height", "m", |p| x[p].z), "at the end")?;
        // Drawn through, or its lower edges have never come down to the line between the axes.
        let drawn = if body.centre(x).z < 0.0 { Some(true) } else { (sunk < bottom).then_some(false) };
        let outcome = world
            .outcome()
            .invariant("verdict against statics", mismatch(at.ladder > 1.0, drawn))
            .invariant("sunk (m)", sunk)
            .error("off the middle", (body.centre(x) - start).xy().norm() / HALF_WIDTH);
        Ok(shots.add_to(outcome))
    }
}
