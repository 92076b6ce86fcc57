//! A block that is drawn out and let go.

use super::super::cloud::Cloud;
use super::super::method::Method;
use super::super::portrait::{Portrait, filmed};
use super::super::solver::{Elasticity, Matter, Solver, Watch};
use super::energy;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use mechanics_core::tensor::Mat3;
use mpm_core::Samples;
use schemars::JsonSchema;
use serde::Deserialize;

/// A square of 1 m in the plane, E = 1e4 Pa, ν = 0.3, 1000 kg/m³, on nodes 0.1 m apart: drawn out along x and released at rest, for 3 s. The ladder
/// is how far, by its length.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StretchedAndReleased {
    /// What it is made of.
    law: Elasticity,
}

const SPACING: f64 = 0.1;
const DURATION: f64 = 3.0;
const FRAMES: usize = 30;

impl Experiment for StretchedAndReleased {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let matter = Matter::new(self.law, (1e4, 0.3), 1000.0)?;
        let counts = [(method.along as f64 / SPACING).round() as usize; 2];
        let cloud = Cloud::cuboid([-0.5; 2], [0.5; 2], counts);
        let positions: Vec<_> = cloud.points.iter().map(|x| [at.ladder * x[0], x[1]]).collect();
        let velocities = vec![[0.0; 2]; positions.len()];
        let mut solver = Solver::new(method, SPACING)?;
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &cloud.volumes };
        let body = solver.add_body(&matter, samples)?;
        let drawn = Mat3::from_diagonal(&[at.ladder, 1.0, 1.0].into());
        solver.set_deformation_gradients(body, &vec![drawn; positions.len()])?;
        let start = energy(&solver, 1);
        let mut watch = Watch::start(&solver);
        let (mut growth, mut smallest, mut film) = (0.0_f64, f64::INFINITY, Vec::new());
        let mut steps = 0_u64;
        while solver.time() < DURATION {
            let step = solver.stable_step().min(DURATION - solver.time());
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            steps += 1;
            if steps.is_multiple_of(8) {
                watch.look(&mut solver, 0.0);
                growth = growth.max(energy(&solver, 1) / start - 1.0);
                let ratios = solver.states(0).into_iter().map(|state| state.volume_ratio);
                smallest = ratios.fold(smallest, f64::min);
            }
            if at.frames.is_some() && solver.time() / DURATION * FRAMES as f64 >= film.len() as f64 {
                film.push(portrait(&solver, SPACING / method.along as f64, at.method));
            }
        }
        let reach = solver
            .positions(0)
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x[0]), high.max(x[0])]);
        let outcome = Outcome::default()
            .invariant("smallest det F on the way", smallest)
            .invariant("largest growth of energy", growth)
            .invariant("energy left", energy(&solver, 1) / start)
            .invariant("length at the end (m)", reach[1] - reach[0] + SPACING / method.along as f64);
        let outcome = watch.free(solver.counted(outcome));
        filmed(outcome, at, "the release, coloured by speed", (&film, 5.0))
    }
}

fn portrait(solver: &Solver<2>, gap: f64, method: &str) -> Portrait<2> {
    Portrait {
        positions: solver.positions(0),
        values: solver.velocities(0).iter().map(|v| v[0].hypot(v[1])).collect(),
        radius: 0.5 * gap,
        field: ("speed", "m/s"),
        range: Some((0.0, 5.0)),
        label: format!("{method}, t = {:.2} s", solver.time()),
        ..Portrait::default()
    }
}
