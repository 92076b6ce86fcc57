//! A bunny under water: Archimedes' law for a mesh.

use super::super::cloud::Cloud;
use super::super::method::Method;
use super::super::solver::Solver;
use super::obstacle::{Section, centre_of_volume, figure, inside, tray, winding};
use super::{Balance, EXPONENT, GRAVITY, Space, add_pressed, ratio_at, space};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::Image;
use mechanics_core::mesh::TriMesh;
use mechanics_core::tensor::Vec3;
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_core::{Collider, SolidMesh, Surface};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::PathBuf;

/// Water, c = 10 √(gH), at rest in a tray, and in it a mesh with y upward, 0.2 m high, that is held. The ladder is Δx (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BunnyInWater {
    /// A closed mesh in a file, relative to the scene's folder.
    mesh: PathBuf,
}

const DENSITY: f64 = 1000.0;
/// Of the water \[m\].
const HALF: f64 = 0.16;
const DEPTH: f64 = 0.28;
/// Of the bunny, and where its middle is \[m\].
const HEIGHT: f64 = 0.2;
const MIDDLE: f64 = 0.13;
/// K = 100 ρgH.
const BULK: f64 = 100.0 * DENSITY * GRAVITY * DEPTH;
/// The whole time, and from when on loads count \[s\].
const TIMES: [f64; 2] = [0.3, 0.1];

fn start(mesh: &TriMesh, method: Method, spacing: f64) -> Result<Space, ExperimentError> {
    let mut space = space(method, spacing)?;
    let gap = spacing / method.along as f64;
    let counts = [2.0 * HALF, 2.0 * HALF, DEPTH].map(|side| (side / gap).round() as usize);
    let mut cloud = Cloud::cuboid([-HALF, -HALF, 0.0], [HALF, HALF, DEPTH], counts);
    cloud.points.retain(|x| winding(mesh, &Vec3::from(*x)) < 0.5);
    cloud.volumes.truncate(cloud.points.len());
    let water = Tait::new(BULK, EXPONENT, Tension::Vanishes).map_err(ExperimentError::stopped)?;
    add_pressed(&mut space, (water, DENSITY), &cloud, |x| ratio_at(DEPTH - x[2], DENSITY, BULK))?;
    for obstacle in [&tray([HALF; 2], 1.5 * DEPTH)?, mesh] {
        let solid = SolidMesh::new(obstacle).map_err(ExperimentError::stopped)?;
        space.add_collider(Collider::at_rest(solid, Surface::Slip)).map_err(ExperimentError::stopped)?;
    }
    Ok(space)
}

impl Experiment for BunnyInWater {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (method, spacing) = (Method::in_double(at.method, "water")?, at.ladder);
        let mut mesh = figure(&at.folder.join(&self.mesh), HEIGHT)?;
        mesh.translate(&Vec3::new(0.0, 0.0, MIDDLE)).map_err(ExperimentError::stopped)?;
        let mut space = start(&mesh, method, spacing)?;
        let mut balance = Balance::start(&space);
        let mut before = None;
        while space.time() < TIMES[0] {
            let step = space.stable_step().min(TIMES[0] - space.time());
            clock.time(|| space.step(step)).map_err(ExperimentError::stopped)?;
            if space.steps().is_multiple_of(32) {
                balance.look(&space, GRAVITY);
            }
            if before.is_none() && space.time() >= TIMES[1] {
                before = Some((space.time(), space.collider_load(1).total));
            }
        }
        let (from, before) = before.unwrap_or_default();
        let load = space.collider_load(1).total;
        let force = (load.linear - before.linear) / (space.time() - from);
        let moment = (load.angular - before.angular) / (space.time() - from);
        // Each part of the bunny is carried by the weight of the water that it displaces, of which the density is that of its depth.
        let middle = centre_of_volume(&mesh);
        let density = DENSITY / ratio_at(DEPTH - middle.z, DENSITY, BULK);
        let weight = density * GRAVITY * mesh.enclosed_volume();
        let lever = moment - middle.cross(&Vec3::new(0.0, 0.0, weight));
        let (count, deepest) = inside(&mesh, space.positions(0).into_iter().map(Vec3::from));
        let outcome = Outcome::default()
            .error("buoyancy", (force.z / weight - 1.0).abs())
            .error("force sideways", force.x.hypot(force.y) / weight)
            .error("moment", lever.norm() / (weight * 0.5 * HEIGHT))
            .count("particles in the bunny", count)
            .count("buoyancy by the weight displaced (‰)", (1e3 * force.z / weight).round() as u64)
            .invariant("deepest particle in the bunny (Δx)", deepest / spacing)
            .invariant("momentum that no force gave", balance.worst)
            .invariant("change of mass", balance.worst_mass);
        let outcome = outcome.pictured(at, "cut through its middle, coloured by pressure", || {
            Ok(drawn(at, &space, &mesh, spacing / method.along as f64))
        })?;
        Ok(Solver::Double(space).counted(outcome))
    }
}

fn drawn(at: &Point<'_>, space: &Space, mesh: &TriMesh, gap: f64) -> Image {
    let pressures: Vec<f64> =
        space.states(0).iter().map(|state| -state.kirchhoff.trace() / 3.0 / state.volume_ratio).collect();
    let section = Section {
        positions: &space.positions(0),
        values: &pressures,
        meshes: std::slice::from_ref(mesh),
        front: 0.0,
        radius: 0.5 * gap,
        field: ("pressure", "Pa"),
        range: Some((0.0, DENSITY * GRAVITY * DEPTH)),
        towards: [0.25, -1.0, 0.35],
        frame: ([-HALF, 0.0, 0.0], [HALF, HALF, DEPTH]),
        label: format!("{}, t = {:.3} s", at.method, space.time()),
    };
    section.drawn((800, 500))
}
