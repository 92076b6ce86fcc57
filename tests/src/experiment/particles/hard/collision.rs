//! Disks that collide with each other or with a wall, one parameter driven to extremes.

use super::super::cloud::Cloud;
use super::super::method::{Method, Precision};
use super::super::portrait::{Portrait, filmed};
use super::super::solver::{Elasticity, Matter, Solver};
use super::energy;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use mpm_core::{Boundary, Kernel, Samples, Shape, Surface, Transfer};
use schemars::JsonSchema;
use serde::Deserialize;

/// Disks of radius 0.2 m, E = 1e4 Pa, ν = 0.3, 1000 kg/m³, on nodes 0.05 m apart; the ladder is what is varied.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HardCollision {
    /// What the ladder is.
    varied: Varied,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Varied {
    /// E of the second of two disks by the first one's 1 kPa; they meet with 1 m/s each.
    StiffnessRatio,
    /// ν of both; they meet with 1 m/s each.
    PoissonRatio,
    /// How fast one disk of 1 MPa, in which waves run at 37 m/s, hits a wall (m/s).
    Speed,
}

const LAWS: &[(&str, Elasticity)] = &[
    ("fixed-corotated", Elasticity::FixedCorotated),
    ("hencky", Elasticity::Hencky),
    ("neo-hookean", Elasticity::NeoHookean),
];
const RADIUS: f64 = 0.2;
const SPACING: f64 = 0.05;
const DENSITY: f64 = 1000.0;
const FRAMES: usize = 24;

/// One set-up.
struct Case {
    matters: Vec<Matter>,
    /// Of the first; the second comes with the opposite.
    speed: f64,
    duration: f64,
    walled: bool,
}

impl HardCollision {
    fn case(&self, law: Elasticity, value: f64) -> Result<Case, ExperimentError> {
        let matter = |young: f64, poisson: f64| Matter::new(law, (young, poisson), DENSITY);
        Ok(match self.varied {
            Varied::StiffnessRatio => Case {
                matters: vec![matter(1e3, 0.3)?, matter(1e3 * value, 0.3)?],
                speed: 1.0,
                duration: 0.6,
                walled: false,
            },
            Varied::PoissonRatio => {
                Case { matters: vec![matter(1e4, value)?; 2], speed: 1.0, duration: 0.6, walled: false }
            }
            // Through its own diameter four times.
            Varied::Speed => Case {
                matters: vec![matter(1e6, 0.3)?],
                speed: value,
                duration: 8.0 * RADIUS / value,
                walled: true,
            },
        })
    }
}

impl Case {
    fn start(&self) -> Result<Solver<2>, ExperimentError> {
        let method = Method {
            kernel: Kernel::Quadratic,
            transfer: Transfer::MlsApic,
            precision: Precision::Double,
            along: 2,
        };
        let parts = (2.0 * RADIUS / SPACING * 2.0).round() as usize;
        let mut disk = Cloud::cuboid([-RADIUS; 2], [RADIUS; 2], [parts; 2]);
        disk.points.retain(|x| x[0].hypot(x[1]) <= RADIUS);
        disk.volumes.truncate(disk.points.len());
        let mut solver = Solver::new(method, SPACING)?;
        // A little off the axis.
        for (matter, (sign, off)) in self.matters.iter().zip([(1.0, 0.0), (-1.0, 0.06)]) {
            let positions: Vec<_> =
                disk.points.iter().map(|x| [x[0] - sign * (RADIUS + 0.075), x[1] + off]).collect();
            let velocities = vec![[sign * self.speed, 0.0]; positions.len()];
            solver.add_body(
                matter,
                Samples { positions: &positions, velocities: &velocities, volumes: &disk.volumes },
            )?;
        }
        if self.walled {
            let wall = Shape::HalfSpace { point: [0.0; 2], normal: [-1.0, 0.0] };
            solver.add_boundary(Boundary::at_rest(wall, Surface::Separating))?;
        }
        Ok(solver)
    }
}

/// Σ m v of all bodies, and √(2 M K), which is at least Σ m ‖v‖.
fn momentum(solver: &Solver<2>, bodies: usize) -> ([f64; 2], f64) {
    let totals: Vec<_> = (0..bodies).map(|body| solver.totals(body)).collect();
    let sum = |axis: usize| totals.iter().map(|t| t.momentum[axis]).sum();
    let (mass, kinetic) = totals.iter().fold((0.0, 0.0), |(m, k), t| (m + t.mass, k + t.kinetic_energy));
    ([sum(0), sum(1)], (2.0_f64 * mass * kinetic).sqrt())
}

impl Experiment for HardCollision {
    fn methods(&self) -> &'static [&'static str] {
        &["fixed-corotated", "hencky", "neo-hookean"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let law =
            LAWS.iter().find(|(name, _)| *name == at.method).map_or(Elasticity::NeoHookean, |(_, law)| *law);
        let case = self.case(law, at.ladder)?;
        let bodies = case.matters.len();
        let mut solver = case.start()?;
        let (start, (before, size)) = (energy(&solver, bodies), momentum(&solver, bodies));
        let [mut growth, mut drift, mut smallest] = [0.0_f64, 0.0, f64::INFINITY];
        let (mut steps, mut film) = (0_u64, Vec::new());
        while solver.time() < case.duration {
            let step = solver.stable_step().min(case.duration - solver.time());
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            steps += 1;
            if steps.is_multiple_of(16) {
                growth = growth.max(energy(&solver, bodies) / start - 1.0);
                let (now, _) = momentum(&solver, bodies);
                drift = drift.max((now[0] - before[0]).hypot(now[1] - before[1]) / size);
                let states = (0..bodies).flat_map(|body| solver.states(body));
                smallest = states.fold(smallest, |m, state| m.min(state.volume_ratio));
            }
            if at.frames.is_some() && solver.time() / case.duration * FRAMES as f64 >= film.len() as f64 {
                film.push(portrait(&solver, bodies, case.speed, at.method));
            }
        }
        let mut outcome = Outcome::default()
            .invariant("smallest det F on the way", smallest)
            .invariant("largest growth of energy", growth)
            .invariant("energy left", energy(&solver, bodies) / start);
        if !case.walled {
            outcome = outcome.invariant("momentum that no force gave", drift);
        }
        filmed(solver.counted(outcome), at, "the encounter, coloured by speed", (&film, 4.0))
    }
}

fn portrait(solver: &Solver<2>, bodies: usize, speed: f64, method: &str) -> Portrait<2> {
    let mut seen = Portrait {
        radius: 0.25 * SPACING,
        field: ("speed", "m/s"),
        range: Some((0.0, 2.0 * speed)),
        label: format!("{method}, t = {:.3e} s", solver.time()),
        ..Portrait::default()
    };
    for body in 0..bodies {
        seen.positions.extend(solver.positions(body));
        seen.values.extend(solver.velocities(body).iter().map(|v| v[0].hypot(v[1])));
    }
    seen
}
