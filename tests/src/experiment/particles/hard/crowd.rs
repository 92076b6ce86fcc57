//! Very many particles in one cell.

use super::super::cloud::Cloud;
use super::super::method::Method;
use super::super::portrait::{Portrait, pictured};
use super::super::solver::{Elasticity, Matter, Solver, Watch};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use mpm_core::Samples;
use schemars::JsonSchema;
use serde::Deserialize;

/// A square of 0.1 m that fills one cell, E = 1e5 Pa, ν = 0.3, 1000 kg/m³, turning and flying, for twelve steps; the ladder is the number of its
/// particles.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CrowdedCell {}

const SPACING: f64 = 0.1;
const STEPS: usize = 12;
const SPEED: [f64; 2] = [1.0, -0.5];
const SPIN: f64 = 3.0;

impl Experiment for CrowdedCell {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let along = at.ladder.sqrt().round().max(1.0) as usize;
        let cloud = Cloud::cuboid([0.0; 2], [SPACING; 2], [along; 2]);
        let middle = 0.5 * SPACING;
        let turning = |x: &[f64; 2]| [SPEED[0] - SPIN * (x[1] - middle), SPEED[1] + SPIN * (x[0] - middle)];
        let velocities: Vec<_> = cloud.points.iter().map(turning).collect();
        let matter = Matter::new(Elasticity::NeoHookean, (1e5, 0.3), 1000.0)?;
        let mut solver = Solver::new(method, SPACING)?;
        let samples = Samples { positions: &cloud.points, velocities: &velocities, volumes: &cloud.volumes };
        solver.add_body(&matter, samples)?;
        let mut watch = Watch::start(&solver);
        let mut duration = 0.0;
        for _ in 0..STEPS {
            let step = solver.stable_step();
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            duration += step;
        }
        watch.look(&mut solver, 0.0);
        // The centre of mass flies straight.
        let positions = solver.positions(0);
        let off = |axis: usize| {
            let mean = positions.iter().map(|x| x[axis]).sum::<f64>() / positions.len() as f64;
            (mean - middle - SPEED[axis] * duration) / SPACING
        };
        let outcome = Outcome::default().invariant("centre of mass off its way (Δx)", off(0).hypot(off(1)));
        let outcome = watch.free(solver.counted(outcome));
        pictured(outcome, at, "the square after twelve steps, coloured by speed", || Portrait {
            values: solver.velocities(0).iter().map(|v| v[0].hypot(v[1])).collect(),
            positions,
            radius: 0.5 * SPACING / along as f64,
            field: ("speed", "m/s"),
            lines: vec![vec![[0.0; 2], [SPACING, 0.0], [SPACING; 2], [0.0, SPACING], [0.0; 2]]],
            label: format!("{}, {} particles", at.method, along * along),
            ..Portrait::default()
        })
    }
}
