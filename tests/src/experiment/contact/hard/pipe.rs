//! A soft ball drawn through a pipe that is narrower than it is.

use super::{contact, detection, jitter, shapes, stepping};
use crate::experiment::contact::portrait::outcome_of;
use crate::experiment::contact::watch::{Towards, Watch};
use crate::experiment::contact::world::{Material, SolidLaw, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::CollisionObject;
use ipc_contact::contact::ContactOptions;
use ipc_contact::topology::Surface;
use mechanics_core::mesh::ball;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A ball of radius 0.1 m, E = 1e5 Pa, ν = 0.4, drawn at its front through a funnel into a pipe of the ladder's radius (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NarrowPipe {
    /// How fast its front is drawn (m/s).
    speed_m_s: Positive,
    /// How many steps of 0.01 s are made.
    steps: Count,
}

const RADIUS: f64 = 0.1;
const STEP: f64 = 0.01;
const MATERIAL: Material = Material { young: 1e5, poisson: 0.4, density: 1000.0 };

impl Experiment for NarrowPipe {
    fn methods(&self) -> &'static [&'static str] {
        &["additive", "interval"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let profile = [[at.ladder, -1.0], [at.ladder, -0.5], [at.ladder, 0.0], [0.16, 0.25], [0.16, 0.5]];
        let pipe = shapes::revolved(&profile, 24).map_err(ExperimentError::stopped)?;
        let mut mesh = ball(RADIUS, 5).map_err(ExperimentError::stopped)?;
        let is_front = |x: &Vec3| x.z < -0.8 * RADIUS && x.xy().norm() < 0.4 * RADIUS;
        let front: Vec<u32> = (0..).zip(mesh.points()).filter(|(_, x)| is_front(x)).map(|(p, _)| p).collect();
        let shift = jitter(at.seed, 2e-3);
        mesh.translate(&Vec3::new(shift.x, shift.y, 0.22)).map_err(ExperimentError::stopped)?;
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier);
        let body = builder.add_solid(&mesh, MATERIAL, Vec3::zeros())?;
        builder.script(front.iter().copied());
        let wall = builder.add_obstacle(pipe.points(), |first| CollisionObject::of_mesh(&pipe, first));
        let options = ContactOptions { detection: detection(at.method), ..contact(1e-3, MATERIAL, 0.02) };
        let mut world = builder.build(Vec3::zeros(), options, stepping(1e-3))?;
        let triangles = pipe.triangles().iter().map(|t| t.map(|p| p + wall.start)).collect();
        let surface =
            Surface::new(triangles, world.state.position.len()).map_err(ExperimentError::stopped)?;
        world.watches = vec![Watch::Sight { surface, points: body.collect(), towards: Towards::Axis }];
        let drawn = Vec3::new(0.0, 0.0, -self.speed_m_s.value() * STEP);
        for _ in 0..self.steps.value() {
            for &point in &front {
                let target = world.state.position[point as usize] + drawn;
                world.move_to(point, target)?;
            }
            world.step(STEP, clock)?;
        }
        let highest = world.state.position[..mesh.points().len()].iter().map(|x| x.z);
        Ok(outcome_of(&world, at)?
            .invariant("end of the ball (m)", highest.fold(f64::NEG_INFINITY, f64::max)))
    }
}
