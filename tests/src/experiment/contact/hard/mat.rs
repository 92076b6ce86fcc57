//! A mat whose ends are turned until it lies upon itself.

use super::{contact, detection, jitter};
use crate::experiment::contact::portrait::outcome_of;
use crate::experiment::contact::world::{Material, SolidLaw, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use ipc_contact::contact::ContactOptions;
use ipc_contact::topology::linking_number;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

/// A mat 1 × 0.008 × 1 m, E = 2e4 Pa, ν = 0.4, 1000 kg/m³, whose ends x = 0 and x = 1 turn against each other about the x axis
/// with 72° a second each; h = 0.04 s, d̂ = 1.4 mm, tolerance 0.014 m/s; the ladder is one over the number of cells along a side.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TwistedMat {
    /// How often the ends turn against each other.
    turns: Positive,
}

const SIZE: [f64; 3] = [1.0, 0.008, 1.0];
const STEP: f64 = 0.04;
/// Turns a second of the ends against each other.
const RATE: f64 = 0.4;
const MATERIAL: Material = Material { young: 2e4, poisson: 0.4, density: 1000.0 };

/// A point turned about the axis through the middle.
fn turn(x: &Vec3, angle: f64) -> Vec3 {
    let (sin, cos) = angle.sin_cos();
    let (y, z) = (x.y - 0.5 * SIZE[1], x.z - 0.5 * SIZE[2]);
    Vec3::new(x.x, 0.5 * SIZE[1] + cos * y - sin * z, 0.5 * SIZE[2] + sin * y + cos * z)
}

/// The rim z = const. of the mat as a closed chain: beyond both ends it is turned back by as much as they have been turned, and
/// closed far away. So two rims are linked as they were at the start, for ever.
fn closed_rim(rim: &[u32], rest: &[Vec3], x: &[Vec3], angle: f64) -> Vec<Vec3> {
    const PARTS: u32 = 200;
    let [Some(&first), Some(&last)] = [rim.first(), rim.last()] else { return Vec::new() };
    let unwound = |point: u32, by: f64, outwards: f64, k: u32| {
        let left = 1.0 - f64::from(k) / f64::from(PARTS);
        turn(&rest[point as usize], by * left) + Vec3::x() * (outwards * (1.0 - left))
    };
    let mut chain: Vec<Vec3> = rim.iter().map(|&p| x[p as usize]).collect();
    chain.extend((1..=PARTS).map(|k| unwound(last, -angle, 1.0, k)));
    let away = if rest[first as usize].z > 0.5 * SIZE[2] { 10.0 } else { -10.0 };
    chain.extend([2.0, -1.0].map(|end| Vec3::new(end, 0.0, away)));
    chain.extend((1..=PARTS).rev().map(|k| unwound(first, angle, -1.0, k)));
    chain
}

impl Experiment for TwistedMat {
    fn methods(&self) -> &'static [&'static str] {
        &["additive", "interval"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let cells = (1.0 / at.ladder).round() as u32;
        let mut mesh = block(&Vec3::zeros(), &Vec3::from(SIZE), [cells, 1, cells], BoxSplit::Six)
            .map_err(ExperimentError::stopped)?;
        let shift = jitter(at.seed, 1e-3);
        let inside = |p: &Vec3| (p.x * (SIZE[0] - p.x) * p.z * (SIZE[2] - p.z)).abs();
        mesh.map_points(|p| p + Vec3::new(0.0, shift.y * 16.0 * inside(p), 0.0))
            .map_err(ExperimentError::stopped)?;
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier);
        builder.add_solid(&mesh, MATERIAL, Vec3::zeros())?;
        let rest = mesh.points();
        let numbered = || (0..).zip(rest);
        let ends: Vec<(u32, Vec3)> =
            numbered().filter(|(_, x)| x.x == 0.0 || x.x == SIZE[0]).map(|(i, x)| (i, *x)).collect();
        builder.script(ends.iter().map(|(p, _)| *p));
        let rims = [0.0, SIZE[2]].map(|z| {
            let mut rim: Vec<(u32, &Vec3)> = numbered().filter(|(_, x)| x.z == z && x.y == 0.0).collect();
            rim.sort_by(|a, b| a.1.x.total_cmp(&b.1.x));
            rim.into_iter().map(|(p, _)| p).collect::<Vec<u32>>()
        });
        let options =
            ContactOptions { detection: detection(at.method), ..contact(1.4e-3, MATERIAL, SIZE[1]) };
        let mut world = builder.build(Vec3::zeros(), options, super::stepping(0.014))?;
        let steps = (self.turns.value() / (RATE * STEP)).round() as u32;
        for step in 1..=steps {
            let turned = 0.5 * TAU * RATE * STEP * f64::from(step);
            for (point, x) in &ends {
                world.move_to(*point, turn(x, if x.x == 0.0 { turned } else { -turned }))?;
            }
            world.step(STEP, clock)?;
            let chains = rims.each_ref().map(|rim| closed_rim(rim, rest, &world.state.position, turned));
            let number = linking_number(&chains[0], &chains[1]).map_err(ExperimentError::stopped)?;
            world.note_sides(1, u64::from(number != 0));
        }
        outcome_of(&world, at)
    }
}
