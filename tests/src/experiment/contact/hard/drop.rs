//! Bodies dropped or pressed onto others: a stack, nets, points, knives, stairs.

use super::{GRAVITY, contact, detection, jitter, shapes, stepping};
use crate::experiment::contact::portrait::outcome_of;
use crate::experiment::contact::watch::Watch;
use crate::experiment::contact::world::{Material, SolidLaw, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Count;
use ipc_contact::collision_mesh::{CollisionObject, HalfSpace};
use ipc_contact::contact::ContactOptions;
use lagrangian::element::Springs;
use mechanics_core::mesh::io::msh;
use mechanics_core::mesh::{BoxSplit, MeshError, TetMesh, ball, block};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A soft body dropped or pressed onto something; the ladder is the step (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HardDrop {
    /// What is dropped onto what.
    case: Case,
    /// How many steps are made.
    steps: Count,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Case {
    /// Ten cubes of 0.1 m, one above the other, on a half-space.
    StackOfTen,
    /// A ball of radius 0.15 m on a net of springs with meshes of 0.05 m, held at its rim.
    BallOnNet,
    /// The same ball on a grid of fixed points, 0.05 m apart.
    BallOnPoints,
    /// A block whose top is driven 0.06 m towards three fixed segments.
    BlockOnKnives,
    /// The Stanford bunny, 0.2 m long, on a flight of stairs.
    BunnyOnStairs,
}

const SOFT: Material = Material { young: 2e5, poisson: 0.4, density: 1000.0 };
/// Of balls, which are to sink in.
const VERY_SOFT: Material = Material { young: 3e4, ..SOFT };

/// A world, and points that are driven down (m/s).
struct Driven {
    world: World,
    points: Vec<u32>,
    speed: f64,
}

impl Driven {
    fn free(world: World) -> Self {
        Self { world, points: Vec::new(), speed: 0.0 }
    }
}

impl Experiment for HardDrop {
    fn methods(&self) -> &'static [&'static str] {
        &["additive", "interval"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut driven = match self.case {
            Case::StackOfTen => stack(at)?,
            Case::BallOnNet => net(at)?,
            Case::BallOnPoints => points(at)?,
            Case::BlockOnKnives => knives(at)?,
            Case::BunnyOnStairs => stairs(at)?,
        };
        for _ in 0..self.steps.value() {
            for &point in &driven.points {
                let down = Vec3::new(0.0, 0.0, -driven.speed * at.ladder);
                let target = driven.world.state.position[point as usize] + down;
                driven.world.move_to(point, target)?;
            }
            driven.world.step(at.ladder, clock)?;
        }
        outcome_of(&driven.world, at)
    }
}

fn build(
    builder: WorldBuilder,
    at: &Point<'_>,
    activation: f64,
    material: Material,
    edge: f64,
) -> Result<World, ExperimentError> {
    let options = ContactOptions { detection: detection(at.method), ..contact(activation, material, edge) };
    builder.build(GRAVITY, options, stepping(1e-3))
}

fn soft() -> WorldBuilder {
    WorldBuilder::of_law(SolidLaw::Barrier)
}

/// The surface of a solid whose point 0 is point `first`.
fn skin(mesh: &TetMesh, first: u32) -> Result<Vec<[u32; 3]>, ExperimentError> {
    Ok(CollisionObject::of_tets(mesh, first).map_err(ExperimentError::stopped)?.triangles)
}

fn stack(at: &Point<'_>) -> Result<Driven, ExperimentError> {
    const SIDE: f64 = 0.1;
    const GAP: f64 = 2e-3;
    let mut builder = soft();
    builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
    let mut bodies = Vec::new();
    for number in 0..10 {
        let shift = jitter(at.seed + at.seed.min(1) * 100 * number, 0.02 * SIDE);
        let low = Vec3::new(shift.x, shift.y, GAP + (SIDE + GAP) * number as f64);
        let mesh = block(&low, &(low + Vec3::repeat(SIDE)), [2; 3], BoxSplit::Six)
            .map_err(ExperimentError::stopped)?;
        let body = builder.add_solid(&mesh, SOFT, Vec3::zeros())?;
        bodies.push((skin(&mesh, body.start)?, body));
    }
    let mut world = build(builder, at, 1e-3, SOFT, 0.5 * SIDE)?;
    let count = world.state.position.len();
    for pair in bodies.windows(2) {
        // An overhanging corner may hang below a bulging side, so that looking up would be too much to ask.
        world.watches.push(Watch::outside(pair[0].0.clone(), count, pair[1].1.clone())?);
        world.watches.push(Watch::outside(pair[1].0.clone(), count, pair[0].1.clone())?);
    }
    Ok(Driven::free(world))
}

fn soft_ball(at: &Point<'_>) -> Result<TetMesh, MeshError> {
    let mut mesh = ball(0.15, 4)?;
    let shift = jitter(at.seed, 0.01);
    mesh.translate(&Vec3::new(shift.x, shift.y, 0.17))?;
    Ok(mesh)
}

/// A square grid of (n + 1)² points of side `side` about the origin.
fn grid(side: f64, n: u32) -> Vec<Vec3> {
    let at = |i: u32| side * (f64::from(i) / f64::from(n) - 0.5);
    (0..=n).flat_map(|j| (0..=n).map(move |i| Vec3::new(at(i), at(j), 0.0))).collect()
}

fn net(at: &Point<'_>) -> Result<Driven, ExperimentError> {
    const N: u32 = 12;
    let index = |i: u32, j: u32| i + (N + 1) * j;
    let rows = (0..=N).flat_map(|j| (0..N).map(move |i| [index(i, j), index(i + 1, j)]));
    let columns = (0..=N).flat_map(|i| (0..N).map(move |j| [index(i, j), index(i, j + 1)]));
    let edges: Vec<[u32; 2]> = rows.chain(columns).collect();
    let mut builder = soft();
    let segments = edges.clone();
    let net = builder.add_masses(&grid(0.6, N), 5e-3, Vec3::zeros(), |_| {
        CollisionObject { segments, ..CollisionObject::default() }.with_thickness(2e-3)
    });
    let springs = Springs::term("net", 2e4, builder.rest(), edges).map_err(ExperimentError::stopped)?;
    builder.add_term(springs);
    let is_rim = |p: &u32| [p % (N + 1), p / (N + 1)].iter().any(|&i| i == 0 || i == N);
    builder.script(net.clone().filter(is_rim));
    let mesh = soft_ball(at).map_err(ExperimentError::stopped)?;
    let ball = builder.add_solid(&mesh, VERY_SOFT, Vec3::new(0.0, 0.0, -1.0))?;
    let mut world = build(builder, at, 1e-3, VERY_SOFT, 0.05)?;
    let count = world.state.position.len();
    world.watches = vec![Watch::outside(skin(&mesh, ball.start)?, count, net)?];
    Ok(Driven::free(world))
}

fn points(at: &Point<'_>) -> Result<Driven, ExperimentError> {
    let mut builder = soft();
    let grid = grid(0.6, 12);
    let count = grid.len() as u32;
    let nails = builder.add_obstacle(&grid, |first| {
        CollisionObject { points: (first..first + count).collect(), ..CollisionObject::default() }
            .with_thickness(2e-3)
    });
    let mesh = soft_ball(at).map_err(ExperimentError::stopped)?;
    let ball = builder.add_solid(&mesh, VERY_SOFT, Vec3::new(0.0, 0.0, -1.0))?;
    let mut world = build(builder, at, 1e-3, VERY_SOFT, 0.05)?;
    let count = world.state.position.len();
    world.watches = vec![Watch::outside(skin(&mesh, ball.start)?, count, nails)?];
    Ok(Driven::free(world))
}

fn knives(at: &Point<'_>) -> Result<Driven, ExperimentError> {
    const PARTS: u32 = 4;
    let mut builder = soft();
    let knife = |x: f64| (0..=PARTS).map(move |k| Vec3::new(x, 0.15 * (f64::from(k) - 2.0) / 2.0, 0.0));
    let blades: Vec<Vec3> = [-0.07, 0.0, 0.07].into_iter().flat_map(knife).collect();
    let knives = builder.add_obstacle(&blades, |first| {
        let along = |b: u32| (0..PARTS).map(move |k| [0, 1].map(|end| first + b * (PARTS + 1) + k + end));
        CollisionObject { segments: (0..3).flat_map(along).collect(), ..CollisionObject::default() }
            .with_thickness(1e-3)
    });
    let shift = jitter(at.seed, 0.005);
    let low = Vec3::new(-0.1 + shift.x, -0.1 + shift.y, 3e-3);
    let mesh = block(&low, &(low + Vec3::new(0.2, 0.2, 0.12)), [6, 6, 4], BoxSplit::Six)
        .map_err(ExperimentError::stopped)?;
    let body = builder.add_solid(&mesh, SOFT, Vec3::zeros())?;
    let top = (body.start..).zip(mesh.points()).filter(|(_, x)| x.z > low.z + 0.119).map(|(p, _)| p);
    let points: Vec<u32> = top.collect();
    builder.script(points.iter().copied());
    let mut world = build(builder, at, 5e-4, SOFT, 0.03)?;
    let count = world.state.position.len();
    world.watches = vec![Watch::outside(skin(&mesh, body.start)?, count, knives)?];
    Ok(Driven { world, points, speed: 0.1 })
}

fn stairs(at: &Point<'_>) -> Result<Driven, ExperimentError> {
    let path = at.folder.join("../../assets/meshes/bunny_tet.msh");
    let mut mesh = msh::read_file(&path)
        .map_err(ExperimentError::stopped)?
        .tet_mesh()
        .map_err(ExperimentError::stopped)?;
    // The file's y points up, and the bunny is about 10 long.
    mesh.map_points(|p| Vec3::new(p.x, -p.z, p.y) * 0.02).map_err(ExperimentError::stopped)?;
    let bounds =
        mesh.bounding_box().map_or(Vec3::zeros(), |b| b.centre() - Vec3::new(0.0, 0.0, 0.5 * b.size().z));
    let shift = jitter(at.seed, 0.01);
    mesh.translate(&(Vec3::new(shift.x, shift.y, 5e-3) - bounds)).map_err(ExperimentError::stopped)?;
    let (run, rise) = (0.08, 0.05);
    let mut profile = vec![[-0.3, 0.0]];
    for k in 0..6 {
        let edge = 0.02 + run * f64::from(k);
        profile.extend([[edge, -rise * f64::from(k)], [edge, -rise * f64::from(k + 1)]]);
    }
    profile.push([1.0, -rise * 6.0]);
    let steps = shapes::drawn_out(&profile, 0.4, 4).map_err(ExperimentError::stopped)?;
    let mut builder = soft();
    let stairs = builder.add_obstacle(steps.points(), |first| CollisionObject::of_mesh(&steps, first));
    let bunny = builder.add_solid(&mesh, SOFT, Vec3::new(1.0, 0.0, -1.0))?;
    let mut world = build(builder, at, 3e-4, SOFT, 0.01)?;
    let count = world.state.position.len();
    let triangles = steps.triangles().iter().map(|t| t.map(|p| p + stairs.start)).collect();
    world.watches = vec![
        Watch::above(triangles, count, bunny.clone(), 10.0)?,
        Watch::outside(skin(&mesh, bunny.start)?, count, stairs)?,
    ];
    Ok(Driven::free(world))
}
