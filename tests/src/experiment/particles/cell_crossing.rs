//! A rod under uniform stress, wherever its particles are in their cells: no force should act on its inside.

use super::cloud::Cloud;
use super::method::Method;
use super::portrait::{Portrait, pictured};
use super::solver::{Elasticity, Matter, Solver};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use mechanics_core::tensor::Mat3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A stretched rod, in many places within a cell, for one step from rest: what moves its inside is an error. The ladder is the distance
/// of particles in cells; the method's particles a cell do not matter.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CellCrossing {
    /// Of the rod (1).
    stretch: Positive,
    /// Places within a cell.
    places: Count,
}

/// Of the grid: one cell is a metre.
const CELLS: f64 = 20.0;
/// From the middle of the rod: what is measured \[cells\].
const INSIDE: f64 = 4.0;
const DENSITY: f64 = 1.0;
const YOUNG: f64 = 1.0;

/// The rod in one place.
struct Rod {
    cloud: Cloud<2>,
    middle: f64,
    /// h f/m of each particle by h σ/(ρ Δx), the impulse of one side of a cell on the mass in it.
    forces: Vec<f64>,
    solver: Solver<2>,
}

impl CellCrossing {
    fn rod(&self, gap: f64, shift: f64, method: Method, clock: &mut Clock) -> Result<Rod, ExperimentError> {
        let matter = Matter::new(Elasticity::FixedCorotated, (YOUNG, 0.0), DENSITY)?;
        let stretch = self.stretch.value();
        let count = (CELLS / gap).round() as usize;
        let length = gap * count as f64;
        let mut cloud = Cloud::cuboid([shift, 0.0], [shift + length, gap], [count, 1]);
        // Rest volumes.
        cloud.volumes.iter_mut().for_each(|volume| *volume /= stretch);
        let mut solver = Solver::new(method, 1.0)?;
        let body = solver.add_cloud(&matter, &cloud)?;
        let gradient = Mat3::from_diagonal(&[stretch, 1.0, 1.0].into());
        solver.set_deformation_gradients(body, &vec![gradient; count])?;
        let step = 0.01 * solver.stable_step();
        clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
        // σ = P of a rod that keeps its width; ρ = ρ₀/l.
        let unit = step * YOUNG * (stretch - 1.0) * stretch / DENSITY;
        let forces = solver.velocities(body).iter().map(|v| v[0] / unit).collect();
        Ok(Rod { cloud, middle: shift + 0.5 * length, forces, solver })
    }
}

impl Rod {
    /// Particles far from the ends, and what pushes them.
    fn inside(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let near = |x: f64| (x - self.middle).abs() < INSIDE;
        let each = self.cloud.points.iter().zip(&self.forces).map(|(x, force)| (x[0], *force));
        each.filter(move |(x, _)| near(*x))
    }
}

impl Experiment for CellCrossing {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let places = self.places.value();
        let (mut worst, mut square, mut count) = (0.0_f64, 0.0, 0);
        let mut rods = Vec::new();
        let mut outcome = Outcome::default();
        for place in 0..places {
            // Off the nodes, where particles are on the side of either cell.
            let shift = (place as f64 + 0.37) / places as f64;
            let rod = self.rod(at.ladder, shift, method, clock)?;
            for (_, force) in rod.inside() {
                worst = worst.max(force.abs());
                square += force * force;
                count += 1;
            }
            outcome = rod.solver.counted(outcome);
            rods.push(rod);
        }
        let outcome =
            outcome.error("largest force", worst).error("force", (square / f64::from(count)).sqrt());
        let caption = format!(
            "{}: a rod in {places} places, one a row, each {:.3} of a cell further, and the force on it by stress times a cell's side; lines: nodes",
            at.method,
            1.0 / places as f64
        );
        pictured(outcome, at, &caption, || portrait(&rods, at))
    }
}

/// The insides of the rods one above the other.
fn portrait(rods: &[Rod], at: &Point<'_>) -> Portrait<2> {
    let height = 5.0 / rods.len() as f64;
    let mut seen = Portrait { radius: 0.4 * height.min(at.ladder), ..Portrait::default() };
    for (row, rod) in rods.iter().enumerate() {
        for (x, force) in rod.inside() {
            seen.positions.push([x, height * row as f64]);
            seen.values.push(force);
        }
    }
    let low = seen.positions.iter().fold(f64::INFINITY, |low, x| low.min(x[0])).ceil();
    let cells = (2.0 * INSIDE) as u32;
    seen.lines = (0..cells).map(|k| low + f64::from(k)).map(|x| vec![[x, -0.2], [x, 5.0]]).collect();
    seen.field = ("spurious force", "1");
    seen.label = format!("{}, particles {} cells apart", at.method, at.ladder);
    seen
}
