//! The table-cloth trick.

use super::shots::Shots;
use super::tableware::Dish;
use super::{Body, G, GRAVITY, add_body, contact, friction, stepping};
use crate::experiment::contact::watch::Watch;
use crate::experiment::contact::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::HalfSpace;
use lagrangian::stepper::{StepReport, StepperOptions};
use mechanics_core::linear::{Method, Ordering};
use mechanics_core::mesh::{Diagonals, sheet};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::Range;

/// Tableware (E = 10 MPa, ρ = 2000 kg/m³) stands on a cloth (0.5 mm, E = 1 MPa, ρ = 400 kg/m³) on a table; the cloth is pulled by one edge. `fast`: with
/// the stated speed, at once. `slow`: with an acceleration of μ g/4 up to 0.3 m/s. The ladder is the side of the
/// cloth's cells (m).
///
/// # Closed form
/// Friction alone moves the tableware, with μ g at most. If the cloth is gone after the time T, a piece has the speed μ g T by then, slides as long again on the
/// table, and has moved by no more than μ g T² in all.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Tablecloth {
    /// How many pieces of tableware.
    pieces: Count,
    /// Rings of points from the middle of a piece to its rim.
    rings: Count,
    /// Length and width of the cloth (m).
    size_m: [Positive; 2],
    /// μ, everywhere.
    friction: Positive,
    /// Of the fast pull (m/s).
    speed_m_s: Positive,
    /// h (s).
    step_s: Positive,
    /// Steps of the fast pull, and of the slow one.
    steps: [Count; 2],
}

const CLOTH: Material = Material { young: 1e6, poisson: 0.3, density: 400.0 };
const THICKNESS: f64 = 5e-4;
const WARE: Material = Material { young: 1e7, poisson: 0.3, density: 2000.0 };
const ACTIVATION: f64 = 1e-3;
const GAP: f64 = 5e-4;
const STICK_VELOCITY: f64 = 1e-3;
/// Points of the cloth that are asked whether they are inside of a piece.
const WATCHED: usize = 40;
/// Of the slow pull (m/s).
const SLOW: f64 = 0.3;

/// What lies on the table.
struct Table {
    world: World,
    cloth: Range<u32>,
    cloth_triangles: Vec<[u32; 3]>,
    pulled: Vec<u32>,
    ware: Vec<Body>,
}

/// Where the pieces stand: rows of three.
fn places(count: usize) -> Vec<[f64; 2]> {
    let columns = count.min(3);
    let rows = count.div_ceil(columns);
    let along = |i: usize, n: usize| 0.2 * (i as f64 - 0.5 * (n as f64 - 1.0));
    (0..count).map(|k| [along(k / columns, rows), along(k % columns, columns)]).collect()
}

impl Tablecloth {
    fn lay(&self, edge: f64) -> Result<Table, ExperimentError> {
        let mut builder = WorldBuilder::default();
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        let size = self.size_m.map(Positive::value);
        let cells = size.map(|length| (length / edge).round() as u32);
        let mut mesh = sheet(size, cells, Diagonals::Alternating).map_err(ExperimentError::stopped)?;
        mesh.translate(&Vec3::new(-0.5 * size[0], -0.5 * size[1], GAP)).map_err(ExperimentError::stopped)?;
        let cloth = builder.add_cloth(&mesh, THICKNESS, CLOTH, Vec3::zeros())?;
        let is_pulled = |p: &u32| builder.rest()[*p as usize].x > 0.499 * size[0];
        let pulled: Vec<u32> = cloth.clone().filter(is_pulled).collect();
        builder.script(pulled.iter().copied());
        let mut ware = Vec::new();
        let mut load = f64::INFINITY;
        for (k, [x, y]) in places(self.pieces.value()).into_iter().enumerate() {
            let dish = Dish::SERVICE[(k + 2) % Dish::SERVICE.len()];
            let mut piece = dish.mesh(self.rings.value() as u32)?;
            let base = piece.points().iter().filter(|p| p.z == 0.0).count();
            load = load.min(WARE.density * piece.volume() * G / base as f64);
            piece.translate(&Vec3::new(x, y, 2.0 * GAP)).map_err(ExperimentError::stopped)?;
            ware.push(add_body(&mut builder, &piece, WARE)?);
        }
        // A thin body's factorisation is cheap, and conjugate gradients take more than a thousand iterations for one direction.
        let stepping =
            StepperOptions { method: Method::Cholesky { ordering: Ordering::default() }, ..stepping(2e-3) };
        let mut world = builder.with_friction(friction(self.friction.value(), STICK_VELOCITY)?).build(
            GRAVITY,
            contact(ACTIVATION, load),
            stepping,
        )?;
        let count = world.state.position.len();
        let cloth_triangles: Vec<[u32; 3]> = mesh.triangles().to_vec();
        for body in &ware {
            world.watches.push(Watch::outside(
                body.skin.clone(),
                count,
                cloth.clone().step_by(cloth.len().div_ceil(WATCHED)),
            )?);
        }
        Ok(Table { world, cloth, cloth_triangles, pulled, ware })
    }

    /// How far the edge has been pulled at a time.
    fn way(&self, method: &str, t: f64) -> f64 {
        if method == "fast" {
            return self.speed_m_s.value() * t;
        }
        let acceleration = 0.25 * self.friction.value() * G;
        let ramp = SLOW / acceleration;
        if t < ramp { 0.5 * acceleration * t * t } else { SLOW * (t - 0.5 * ramp) }
    }
}

/// The times of the steps, by what they were for (s).
#[derive(Default)]
struct Split([f64; 7]);

impl Split {
    const NAMES: [&'static str; 7] =
        ["value", "gradient", "assembly", "solve", "limit step", "freeze", "everything"];

    fn add(&mut self, report: &StepReport) {
        let times = report.newton.times;
        let all = [
            times.value,
            times.gradient,
            times.assembly,
            times.solve,
            times.limit_step,
            times.freeze,
            report.time,
        ];
        for (sum, time) in self.0.iter_mut().zip(all) {
            *sum += time.as_secs_f64();
        }
    }
}

/// The angle of a piece's axis from upright (rad): by its rim against the middle of its base.
fn tilt(body: &Body, start: &[Vec3], x: &[Vec3]) -> f64 {
    let middle = body.points.start as usize;
    let arm = |at: &[Vec3]| body.centre(at) - at[middle];
    arm(x).angle(&arm(start))
}

impl Experiment for Tablecloth {
    fn methods(&self) -> &'static [&'static str] {
        &["fast", "slow"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let Table { mut world, cloth, cloth_triangles, pulled, ware } = self.lay(at.ladder)?;
        let start = world.state.position.clone();
        let skins = ware.iter().map(|body| &body.skin[..]).chain([&cloth_triangles[..]]);
        let mut shots = Shots::new(at, [0.4, -1.0, 0.5], skins);
        let h = self.step_s.value();
        let is_fast = at.method == "fast";
        let steps = self.steps[usize::from(!is_fast)].value();
        let mut split = Split::default();
        for step in 1..=steps {
            let way = Vec3::x() * self.way(at.method, h * step as f64);
            for &point in &pulled {
                world.move_to(point, start[point as usize] + way)?;
            }
            split.add(&world.step(h, clock)?);
            let x = &world.state.position;
            if step == 3 || step % steps.div_ceil(3) == 0 {
                shots.take(x, ("height", "m", |p| x[p].z), &format!("step {step}"))?;
            }
        }
        let x = &world.state.position;
        shots.take(x, ("height", "m", |p| x[p].z), "at the end")?;
        for (name, seconds) in Split::NAMES.into_iter().zip(split.0) {
            clock.add_term(name, std::time::Duration::from_secs_f64(seconds));
        }
        let ways: Vec<f64> =
            ware.iter().map(|body| (body.centre(x) - body.centre(&start)).xy().norm()).collect();
        let farthest = ways.iter().copied().fold(0.0, f64::max);
        let nearest = ways.iter().copied().fold(f64::INFINITY, f64::min);
        let pulled_way = self.way(at.method, h * steps as f64);
        let largest_tilt = ware.iter().map(|body| tilt(body, &start, x)).fold(0.0, f64::max).to_degrees();
        // The last of the cloth leaves the last piece when it has gone half of its length and half of that of the tableware.
        let reach =
            ware.iter().flat_map(|body| body.points.clone()).map(|p| start[p as usize].x).fold(0.0, f64::max);
        let gone = (0.5 * self.size_m[0].value() + reach) / self.speed_m_s.value() + h;
        let bound = self.friction.value() * G * gone * gone;
        let error = if is_fast {
            farthest / bound
        } else {
            (nearest / pulled_way - 1.0).abs().max((farthest / pulled_way - 1.0).abs())
        };
        let outcome = world
            .outcome()
            .count("points", x.len() as u64)
            .count("points of the cloth", u64::from(cloth.end - cloth.start))
            .error("way of the tableware", error)
            .invariant("tilt of the tableware (degrees)", largest_tilt)
            .invariant("farthest way of a piece (m)", farthest)
            .invariant("way of the cloth (m)", pulled_way);
        Ok(shots.add_to(outcome))
    }
}
