//! A chain of links.

use super::{GRAVITY, contact, jitter, shapes, stepping};
use crate::experiment::contact::portrait::outcome_of;
use crate::experiment::contact::watch::Watch;
use crate::experiment::contact::world::{Material, SolidLaw, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Count;
use ipc_contact::collision_mesh::CollisionObject;
use ipc_contact::topology::linking_number;
use lagrangian::element::Springs;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

/// Rings of radius 0.05 m, each through the next, the first held; let go slack, they fall until the chain is taut. The ladder is the
/// step (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LinkedChain {
    /// How many links.
    links: Count,
    /// How many steps are made.
    steps: Count,
}

const RADIUS: f64 = 0.05;
/// From centre to centre at the start (m).
const SPACING: f64 = 1.4 * RADIUS;
const AROUND: u32 = 16;
const ACTIVATION: f64 = 1e-3;
const RUBBER: Material = Material { young: 1e7, poisson: 0.4, density: 1000.0 };

/// A point of a ring about the z axis, where it is in the link with this number: every other one is turned.
fn placed(link: u32, p: Vec3, shift: Vec3) -> Vec3 {
    let centre = Vec3::new(shift.x, shift.y, -SPACING * f64::from(link));
    let upright = if link.is_multiple_of(2) { Vec3::new(p.x, p.z, p.y) } else { Vec3::new(p.z, p.x, p.y) };
    centre + upright
}

/// Adds a link; answers a closed line of points along it, and all its points.
fn add_link(
    builder: &mut WorldBuilder,
    method: &str,
    link: u32,
    shift: Vec3,
) -> Result<(Vec<u32>, Vec<u32>), ExperimentError> {
    if method == "solid-rings" {
        let mut mesh = shapes::ring(RADIUS, 5e-3, AROUND).map_err(ExperimentError::stopped)?;
        mesh.map_points(|p| placed(link, *p, shift)).map_err(ExperimentError::stopped)?;
        mesh.orient();
        let points = builder.add_solid(&mesh, RUBBER, Vec3::zeros())?;
        return Ok((points.clone().step_by(4).collect(), points.collect()));
    }
    let angle = |k: u32| TAU * (f64::from(k) + 0.5) / f64::from(AROUND);
    let on_circle = |k: u32| Vec3::new(RADIUS * angle(k).cos(), RADIUS * angle(k).sin(), 0.0);
    let ring: Vec<Vec3> = (0..AROUND).map(|k| placed(link, on_circle(k), shift)).collect();
    let points = builder.add_masses(&ring, 1e-3, Vec3::zeros(), |first| {
        let segments = (0..AROUND).map(|k| [first + k, first + (k + 1) % AROUND]).collect();
        CollisionObject { segments, ..CollisionObject::default() }.with_thickness(1e-3)
    });
    let across = |k: u32| [1, 2, 5, AROUND / 2].map(|d| [points.start + k, points.start + (k + d) % AROUND]);
    let springs =
        Springs::term(format!("ring {link}"), 1e4, builder.rest(), (0..AROUND).flat_map(across).collect());
    builder.add_term(springs.map_err(ExperimentError::stopped)?);
    Ok((points.clone().collect(), points.collect()))
}

impl Experiment for LinkedChain {
    fn methods(&self) -> &'static [&'static str] {
        &["rings-of-springs", "solid-rings"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier);
        let mut lines = Vec::new();
        for link in 0..self.links.value() as u32 {
            let shift = jitter(at.seed + at.seed.min(1) * 100 * u64::from(link), 0.05 * RADIUS);
            let (line, points) = add_link(&mut builder, at.method, link, shift)?;
            if link == 0 {
                builder.script(points);
            }
            lines.push(line);
        }
        let rest = builder.rest();
        let chain = |line: &[u32]| -> Vec<Vec3> { line.iter().map(|&p| rest[p as usize]).collect() };
        let (mut watches, mut unlinked) = (Vec::new(), 0);
        for (i, first) in lines.iter().enumerate() {
            for (j, second) in lines.iter().enumerate().skip(i + 1).take(3) {
                let number =
                    linking_number(&chain(first), &chain(second)).map_err(ExperimentError::stopped)?;
                unlinked += u64::from(number.abs() != i32::from(j == i + 1));
                watches.push(Watch::Linked { chains: [first.clone(), second.clone()], number });
            }
        }
        let mut world = builder.build(GRAVITY, contact(ACTIVATION, RUBBER, 5e-3), stepping(1e-3))?;
        world.watches = watches;
        for _ in 0..self.steps.value() {
            world.step(at.ladder, clock)?;
        }
        let lowest = world.state.position.iter().map(|x| x.z).fold(0.0, f64::min);
        let taut = -lowest / (2.0 * RADIUS * self.links.value() as f64);
        Ok(outcome_of(&world, at)?
            .invariant("pairs not linked as they should be at the start", unlinked as f64)
            .invariant("length over that of rings in a row", taut))
    }
}
