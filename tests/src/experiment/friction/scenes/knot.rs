//! A rope with an overhand knot, pulled tight.

use super::knot_type::determinant;
use super::shots::Shots;
use super::{contact, friction, stepping};
use crate::experiment::contact::world::{Material, SolidLaw, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{NonNegative, Positive};
use ipc_contact::collision_mesh::CollisionObject;
use mechanics_core::mesh::TetMesh;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// A rope of square section, 1 cm thick, E = 1 MPa, straight at rest, laid in an overhand knot (`overhand`) or the same way with all crossings
/// one above the other, so that it is none (`unknotted`). Its ends are pulled apart. The ladder is the step (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PulledKnot {
    /// μ.
    friction: NonNegative,
    /// How fast each end is pulled (m/s).
    speed_m_s: Positive,
    /// For how long (s).
    duration_s: Positive,
}

/// Half of the thickness (m).
const HALF: f64 = 5e-3;
/// The radius of the knot's lobes is three of these (m).
const SIZE: f64 = 0.03;
/// From the knot's middle to where the rope is straight (m).
const REACH: f64 = 0.2;
/// Between sections (m).
const SPACING: f64 = 0.012;
const ACTIVATION: f64 = 1e-3;
const ROPE: Material = Material { young: 1e6, poisson: 0.3, density: 1000.0 };
const STICK_VELOCITY: f64 = 1e-3;

/// The line of an overhand knot along x: a trefoil (sin t + 2 sin 2t, cos t − 2 cos 2t, −1.3 sin 3t), opened in the middle of its lower lobe.
fn trefoil() -> Vec<Vec3> {
    const OPENING: f64 = 0.3;
    let at = |t: f64| {
        Vec3::new(t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos(), -1.3 * (3.0 * t).sin())
    };
    let [from, to] = [PI + OPENING, 3.0 * PI - OPENING];
    let knot = (0..=200).map(|k| at(from + (to - from) * f64::from(k) / 200.0));
    let tail = |side: f64| {
        let height = at(from).z;
        (0..=20).map(move |k| {
            Vec3::new(side * (REACH / SIZE) * (1.0 - f64::from(k) / 20.0), -3.0, -side * height)
        })
    };
    let mut line: Vec<Vec3> = tail(-1.0)
        .chain(knot)
        .chain(tail(1.0).collect::<Vec<_>>().into_iter().rev())
        .map(|p| p * SIZE)
        .collect();
    line = resampled(&line, 0.25 * SPACING);
    for _ in 0..60 {
        let smooth = |w: &[Vec3]| (w[0] + w[1] * 2.0 + w[2]) / 4.0;
        let inner: Vec<Vec3> = line.windows(3).map(smooth).collect();
        let count = line.len();
        line[1..count - 1].copy_from_slice(&inner);
    }
    line
}

/// Points of a polyline about `spacing` apart, evenly.
fn resampled(line: &[Vec3], spacing: f64) -> Vec<Vec3> {
    let mut along = vec![0.0];
    for w in line.windows(2) {
        along.push(along[along.len() - 1] + (w[1] - w[0]).norm());
    }
    let length = along[along.len() - 1];
    let count = (length / spacing).round();
    let at = |k: usize| {
        let s = length * k as f64 / count;
        let i = along.partition_point(|&a| a <= s).clamp(1, line.len() - 1);
        let part = ((s - along[i - 1]) / (along[i] - along[i - 1])).clamp(0.0, 1.0);
        line[i - 1] * (1.0 - part) + line[i] * part
    };
    (0..=count as usize).map(at).collect()
}

/// The middle line of the rope where it begins.
fn middle_line(method: &str) -> Vec<Vec3> {
    let mut line = trefoil();
    if method == "unknotted" {
        let height = line[0].z;
        let last = (line.len() - 1) as f64;
        for (k, p) in line.iter_mut().enumerate() {
            p.z = 1.6 * height * (1.0 - 2.0 * k as f64 / last);
        }
    }
    resampled(&line, SPACING)
}

/// The corners of the sections along a line, without twist.
fn sections(line: &[Vec3]) -> Vec<Vec3> {
    let mut across = Vec3::z();
    let mut points = Vec::new();
    for k in 0..line.len() {
        let along = (line[(k + 1).min(line.len() - 1)] - line[k.saturating_sub(1)]).normalize();
        across = (across - along * along.dot(&across)).normalize();
        let other = along.cross(&across);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        points.extend(corners.map(|[a, b]| line[k] + (across * a + other * b) * HALF));
    }
    points
}

/// The rope, straight.
fn straight(count: usize, length: f64) -> Result<TetMesh, ExperimentError> {
    let line: Vec<Vec3> = (0..count).map(|k| Vec3::x() * (length * k as f64 / (count - 1) as f64)).collect();
    let mut cells = Vec::new();
    for k in 0..count as u32 - 1 {
        for triangle in [[0, 1, 2], [0, 2, 3]] {
            let [a, b, c] = triangle.map(|p| p + 4 * k);
            let [d, e, f] = [a, b, c].map(|p| p + 4);
            cells.extend([[a, b, c, f], [a, b, e, f], [a, d, e, f]]);
        }
    }
    let mut mesh = TetMesh::new(sections(&line), cells).map_err(ExperimentError::stopped)?;
    mesh.orient();
    Ok(mesh)
}

/// The determinant of the knot that the rope makes, closed far away.
fn knot_of(x: &[Vec3]) -> f64 {
    const FAR: f64 = 10.0;
    let mut chain: Vec<Vec3> = x.chunks_exact(4).map(|c| c.iter().sum::<Vec3>() / 4.0).collect();
    let [first, last] = [chain[0], chain[chain.len() - 1]];
    let ends = [
        Vec3::new(FAR, last.y, last.z),
        Vec3::new(FAR, -FAR, last.z),
        Vec3::new(-FAR, -FAR, first.z),
        Vec3::new(-FAR, first.y, first.z),
    ];
    chain.extend(ends);
    determinant(&chain)
}

impl Experiment for PulledKnot {
    fn methods(&self) -> &'static [&'static str] {
        &["overhand", "unknotted"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let expected = if at.method == "overhand" { 3.0 } else { 1.0 };
        let line = middle_line(at.method);
        let length: f64 = line.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        let mesh = straight(line.len(), length)?;
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier);
        let object = CollisionObject::of_tets(&mesh, 0).map_err(ExperimentError::stopped)?;
        let skin = object.triangles.clone();
        let points = builder.add_solid_that_touches(&mesh, ROPE, Vec3::zeros(), object)?;
        let ends = [points.start..points.start + 4, points.end - 4..points.end];
        builder.script(ends.iter().cloned().flatten());
        if self.friction.value() > 0.0 {
            builder = builder.with_friction(friction(self.friction.value(), STICK_VELOCITY)?);
        }
        let load = 0.5 * ROPE.young * HALF * ACTIVATION;
        let mut world = builder.build(Vec3::zeros(), contact(ACTIVATION, load), stepping(1e-2))?;
        world.state.position = sections(&line);
        let h = at.ladder;
        let steps = (self.duration_s.value() / h).round() as u32;
        let mut shots = Shots::new(at, [0.1, -0.35, 1.0], [&skin[..]]);
        let section = |x: &[Vec3], k: u32| (0..4).map(|c| x[(4 * k + c) as usize]).sum::<Vec3>() / 4.0;
        let last = line.len() as u32 - 1;
        let along = |p: usize| (p / 4) as f64 / f64::from(last);
        for step in 0..steps {
            if step % steps.div_ceil(3) == 0 {
                shots.take(&world.state.position, ("along the rope", "1", along), &format!("step {step}"))?;
            }
            for (side, end) in [-1.0, 1.0].into_iter().zip(&ends) {
                for point in end.clone() {
                    let pull = Vec3::x() * (side * self.speed_m_s.value() * h);
                    let target = world.state.position[point as usize] + pull;
                    world.move_to(point, target)?;
                }
            }
            world.step(h, clock)?;
            let is_wrong = knot_of(&world.state.position) != expected;
            world.note_sides(1, u64::from(is_wrong));
        }
        let x = &world.state.position;
        shots.take(x, ("along the rope", "1", along), "at the end")?;
        let span = (section(x, last) - section(x, 0)).norm();
        let now: f64 = (0..last).map(|k| (section(x, k + 1) - section(x, k)).norm()).sum();
        let outcome = world
            .outcome()
            .invariant("determinant of the knot", knot_of(x))
            .invariant("rope in the knot, in thicknesses", (now - span) / (2.0 * HALF))
            .error("stretch", now / length - 1.0);
        Ok(shots.add_to(outcome))
    }
}
