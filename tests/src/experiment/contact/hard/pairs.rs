//! The classic degenerate pairs: spikes, wedges, holes, cracks, cliffs and edges inside a flat floor, exactly aligned.

use super::{GRAVITY, contact, jitter, shapes, stepping};
use crate::experiment::contact::portrait::outcome_of;
use crate::experiment::contact::watch::Watch;
use crate::experiment::contact::world::{Material, SolidLaw, World, WorldBuilder};
use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::ccd::Detection;
use ipc_contact::collision_mesh::CollisionObject;
use ipc_contact::contact::ContactOptions;
use lagrangian::stepper::StepperOptions;
use mechanics_core::mesh::{BoxSplit, MeshError, Surface, TetMesh, TriMesh, block};
use mechanics_core::tensor::Vec3;
use nalgebra::Rotation3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A small elastic body, E = 1e5 Pa, 1000 kg/m³, 0.1 m high, that meets a fixed obstacle with 1 m/s, feature exactly on feature
/// (seed 0) or moved and turned by 10⁻¹⁻ˢ of its size (seed s). The ladder is the distance at which contact begins (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DegeneratePair {
    /// How many steps of 0.01 s are made.
    steps: Count,
    /// The last direction of a step is shorter than this part of the ladder's distance.
    tolerance: Positive,
    /// How contact on the way is detected.
    detection: DetectionMethod,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum DetectionMethod {
    Additive,
    Interval,
}

const STEP: f64 = 0.01;
/// Half of the width of bodies, and their height (m).
pub(in crate::experiment) const HALF: f64 = 0.05;
const HEIGHT: f64 = 0.1;
/// How far above the obstacle bodies start (m).
const GAP: f64 = 5e-3;
pub(in crate::experiment) const MATERIAL: Material = Material { young: 1e5, poisson: 0.4, density: 1000.0 };

/// A body with its lowest feature at height 0, an obstacle with its surface there, and the velocity (m/s).
pub(in crate::experiment) struct Pair {
    body: TetMesh,
    obstacle: TriMesh,
    extent: Extent,
    velocity: Vec3,
}

/// How far an obstacle reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Extent {
    /// A ground, open below.
    Wide,
    /// A closed body about as wide as the one that meets it.
    FreeStanding,
}

pub(in crate::experiment) const PAIRS: &[&str] = &[
    "cliff-edges",
    "internal-edges",
    "sliding-spike",
    "sliding-wedge",
    "spike-in-crack",
    "spike-in-hole",
    "spike-on-spike",
    "spike-on-wedge",
    "wedge-in-crack",
    "wedge-on-wedge",
];

fn spike() -> Result<TetMesh, MeshError> {
    shapes::pyramid(HALF, HEIGHT, 2)
}

fn wedge(height: f64) -> Result<TetMesh, MeshError> {
    let profile = [[0.0, 0.0], [-HALF, height], [0.0, height], [HALF, height]];
    shapes::prism(&profile, &[[0, 1, 2], [0, 2, 3]], HALF, 2)
}

fn cube() -> Result<TetMesh, MeshError> {
    let (low, high) = (Vec3::new(-HALF, -HALF, 0.0), Vec3::new(HALF, HALF, HEIGHT));
    block(&low, &high, [2; 3], BoxSplit::Six)
}

fn crack() -> Result<TriMesh, MeshError> {
    shapes::drawn_out(&[[-0.2, 0.0], [-HALF, 0.0], [0.0, -HEIGHT], [HALF, 0.0], [0.2, 0.0]], 0.1, 4)
}

/// A floor whose inner edges lie every 0.05 m.
fn floor() -> Result<TriMesh, MeshError> {
    let line: Vec<[f64; 2]> = (-4..=16).map(|i| [HALF * f64::from(i), 0.0]).collect();
    shapes::drawn_out(&line, 0.2, 8)
}

fn cliff() -> Result<TriMesh, MeshError> {
    let (low, high) = (Vec3::new(-2.0 * HALF, -HALF, -HEIGHT), Vec3::new(0.0, HALF, 0.0));
    surface(&block(&low, &high, [2; 3], BoxSplit::Six)?)
}

fn surface(mesh: &TetMesh) -> Result<TriMesh, MeshError> {
    Ok(Surface::of_tets(mesh)?.into_mesh())
}

pub(in crate::experiment) fn pair(name: &str) -> Result<Pair, MeshError> {
    let falling = Vec3::new(0.0, 0.0, -1.0);
    let sliding = Vec3::new(1.0, 0.0, -0.5);
    let extent = match name {
        "cliff-edges" | "spike-on-spike" | "spike-on-wedge" | "wedge-on-wedge" => Extent::FreeStanding,
        _ => Extent::Wide,
    };
    let (body, obstacle, velocity) = match name {
        "cliff-edges" => (cube()?, cliff()?, falling),
        "internal-edges" => (cube()?, floor()?, sliding),
        "sliding-spike" => (spike()?, floor()?, sliding),
        "sliding-wedge" => (wedge(HEIGHT)?, floor()?, sliding),
        "spike-in-crack" => (spike()?, crack()?, falling),
        "spike-in-hole" => (spike()?, shapes::pit(HALF, HEIGHT, 0.2)?, falling),
        "spike-on-spike" => (spike()?, surface(&shapes::pyramid(HALF, -HEIGHT, 2)?)?, falling),
        "spike-on-wedge" => (spike()?, surface(&wedge(-HEIGHT)?)?, falling),
        "wedge-in-crack" => (wedge(HEIGHT)?, crack()?, falling),
        _ => (wedge(HEIGHT)?, surface(&wedge(-HEIGHT)?)?, falling),
    };
    Ok(Pair { body, obstacle, extent, velocity })
}

impl Pair {
    /// Puts the body where it starts: above the obstacle's surface, or above the bottom of a hole that it fits into.
    pub(in crate::experiment) fn place(&mut self, name: &str, seed: u64) -> Result<(), MeshError> {
        let size = HEIGHT * 10.0_f64.powi(-1 - seed as i32);
        if seed > 0 {
            let angle = Random::new(seed + 1000).symmetric() * size / HEIGHT;
            self.body.rotate(&Rotation3::from_axis_angle(&Vec3::z_axis(), angle))?;
        }
        let lowest = if name.ends_with("in-crack") || name == "spike-in-hole" { -HEIGHT } else { 0.0 };
        let shift = jitter(seed, size);
        self.body.translate(&(Vec3::new(0.0, 0.0, lowest + GAP) + Vec3::new(shift.x, shift.y, 0.0)))
    }

    /// Body and obstacle, with whatever `builder` has already.
    pub(in crate::experiment) fn world(
        &self,
        mut builder: WorldBuilder,
        options: ContactOptions,
        stepper: StepperOptions,
    ) -> Result<World, ExperimentError> {
        let body = builder.add_solid(&self.body, MATERIAL, self.velocity)?;
        let obstacle = builder
            .add_obstacle(self.obstacle.points(), |first| CollisionObject::of_mesh(&self.obstacle, first));
        let mut world = builder.build(GRAVITY, options, stepper)?;
        let count = world.state.position.len();
        let of = |first: u32, triangles: &[[u32; 3]]| -> Vec<[u32; 3]> {
            triangles.iter().map(|t| t.map(|p| p + first)).collect()
        };
        let skin = CollisionObject::of_tets(&self.body, body.start).map_err(ExperimentError::stopped)?;
        world.watches = vec![
            Watch::above(of(obstacle.start, self.obstacle.triangles()), count, body, 10.0)?,
            Watch::outside(skin.triangles, count, obstacle)?,
        ];
        Ok(world)
    }

    /// In a world of steps `h` that has only this pair: where a step carries the body farther than a free-standing obstacle is wide, it has to be
    /// outside of the obstacle, not above it. Newton's way to the end of such a step, on which no features ever meet, may lead around it.
    pub(in crate::experiment) fn allow_ways_around(
        &self,
        world: &mut World,
        h: f64,
    ) -> Result<(), ExperimentError> {
        let way = self.velocity.norm() * h - GRAVITY.z * h * h;
        if self.extent == Extent::FreeStanding && way > HALF {
            let (bodies, count) = (self.body.points().len() as u32, world.state.position.len());
            let skin = self.obstacle.triangles().iter().map(|t| t.map(|p| p + bodies)).collect();
            world.watches[0] = Watch::outside(skin, count, 0..bodies)?;
        }
        Ok(())
    }
}

impl Experiment for DegeneratePair {
    fn methods(&self) -> &'static [&'static str] {
        PAIRS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut pair = pair(at.method).map_err(ExperimentError::stopped)?;
        pair.place(at.method, at.seed).map_err(ExperimentError::stopped)?;
        let detection = match self.detection {
            DetectionMethod::Additive => Detection::Additive,
            DetectionMethod::Interval => Detection::Interval,
        };
        let options = ContactOptions { detection, ..contact(at.ladder, MATERIAL, HALF) };
        let builder = WorldBuilder::of_law(SolidLaw::Barrier);
        let mut world = pair.world(builder, options, stepping(self.tolerance.value() * at.ladder / STEP))?;
        for _ in 0..self.steps.value() {
            world.step(STEP, clock)?;
        }
        outcome_of(&world, at)
    }
}
