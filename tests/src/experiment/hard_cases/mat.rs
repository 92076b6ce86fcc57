//! A mat that is wrung, without contact.

use super::Effort;
use super::body::{Deformation, LAWS, elastic, mass, options, skin};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::stepper::Stepper;
use mechanics_core::law::Lame;
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

/// A mat 1 × 0.008 × 1 m, E = 2e4 Pa, ν = 0.4, 1000 kg/m³, whose ends x = 0 and x = 1 turn against each other about the x axis
/// with 72° a second each; backward Euler, h = 0.04 s, tolerance 1e-3 m/s; the ladder is one over the number of cells along a
/// side.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct WrungMat {
    /// How often the ends turn against each other.
    turns: Positive,
}

const SIZE: [f64; 3] = [1.0, 0.008, 1.0];
const STEP: f64 = 0.04;
/// Turns a second of the ends against each other.
const RATE: f64 = 0.4;

impl Experiment for WrungMat {
    fn methods(&self) -> &'static [&'static str] {
        LAWS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let cells = (1.0 / at.ladder).round() as u32;
        let mesh = block(&Vec3::zeros(), &Vec3::from(SIZE), [cells, 1, cells], BoxSplit::Six)
            .map_err(ExperimentError::stopped)?;
        let lame = Lame::from_young_poisson(2e4, 0.4).map_err(ExperimentError::stopped)?;
        let mut elastic = elastic(at.method, lame, &mesh, mesh.cells())?;
        let rest = mesh.points();
        let is_end = |x: &Vec3| x.x == 0.0 || x.x == SIZE[0];
        let ends: Vec<(u32, Vec3)> =
            (0..).zip(rest).filter(|(_, x)| is_end(x)).map(|(i, x)| (i, *x)).collect();
        let map = PointMap::with_fixed(rest.len(), &ends).map_err(ExperimentError::stopped)?;
        let mut stepper = Stepper::new(mass(&mesh, 1000.0)?, map, options(at.method, 1e-3, STEP));
        let mut state = State::at_rest(rest.to_vec());
        let deformation = Deformation::of(&mesh);
        let (mut effort, mut smallest) = (Effort::default(), f64::INFINITY);
        let steps = (self.turns.value() / (RATE * STEP)).round() as u32;
        for step in 1..=steps {
            let turned = 0.5 * TAU * RATE * STEP * f64::from(step);
            for &(point, x) in &ends {
                let target = turn(&x, if x.x == 0.0 { turned } else { -turned });
                stepper.set_target(point, target).map_err(ExperimentError::stopped)?;
            }
            let report = clock
                .time(|| stepper.step(&mut state, &mut [&mut *elastic], STEP))
                .map_err(ExperimentError::stopped)?;
            effort.add(&report);
            smallest = smallest.min(deformation.smallest_determinant(&state.position));
        }
        let middle = Vec3::from(SIZE) * 0.5;
        let farthest = state.position.iter().map(|x| (x - middle).norm()).fold(0.0, f64::max);
        let outcome = Outcome::default()
            .invariant("smallest det F", smallest)
            .invariant("farthest point from the middle (m)", farthest);
        effort.finished(outcome, at, &state, &skin(&mesh)?)
    }
}

/// A point turned about the axis through the middle.
fn turn(x: &Vec3, angle: f64) -> Vec3 {
    let (sin, cos) = angle.sin_cos();
    let (y, z) = (x.y - 0.5 * SIZE[1], x.z - 0.5 * SIZE[2]);
    Vec3::new(x.x, 0.5 * SIZE[1] + cos * y - sin * z, 0.5 * SIZE[2] + sin * y + cos * z)
}
