//! Laws with their parameters at the ends of their ranges, thrown at a wall: those that other scenes have compiled anyway, because a law costs a
//! compiler half a minute.

use super::super::cloud::Cloud;
use super::super::portrait::{Portrait, filmed};
use super::super::solver::{Solver, Watch};
use super::energy;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use mechanics_core::law::Lame;
use mpm_constitutive::PointLawError;
use mpm_constitutive::elastic::{FixedCorotated, NeoHookean};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle};
use mpm_core::{Boundary, MpmError, Samples, Shape, Simulation, SimulationOptions, Surface};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::FRAC_PI_2;

/// A disk of radius 0.2 m, E = 1e5 Pa, 1000 kg/m³, on nodes 0.05 m apart, thrown at a wall; the ladder is its speed (m/s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LawsAtLimits {}

const RADIUS: f64 = 0.2;
const SPACING: f64 = 0.05;
const DENSITY: f64 = 1000.0;
const YOUNG: f64 = 1e5;
const MOST_HALVINGS: i32 = 20;
const FRAMES: usize = 16;

const NAMES: &[&str] = &[
    "elastic, ν = −0.99",
    "elastic, ν = 0.4999",
    "fluid, γ = 1",
    "fluid, γ = 16",
    "fluid, K = 1 Pa",
    "sand, φ = 0.001",
    "sand, φ = π/2 − 0.001",
    "sand, c = 1e9 Pa",
];

/// Adds the disk, of the law that the name says.
fn add(
    name: &str,
    simulation: &mut Simulation<f64, 2>,
    samples: Samples<'_, 2>,
) -> Result<(), ExperimentError> {
    let lame = |poisson: f64| Lame::from_young_poisson(YOUNG, poisson).map_err(ExperimentError::stopped);
    let usual = lame(0.3)?;
    fn ready<L>(law: Result<L, PointLawError>) -> Result<L, ExperimentError> {
        law.map_err(ExperimentError::stopped)
    }
    let fluid = |bulk, exponent| ready(Tait::new(bulk, exponent, Tension::Carried));
    let sand =
        |angle, cohesion| ready(DruckerPrager::new(usual, ready(FrictionAngle::constant(angle))?, cohesion));
    let body = match name {
        "elastic, ν = −0.99" => simulation.add_body(FixedCorotated::new(lame(-0.99)?), DENSITY, samples),
        "elastic, ν = 0.4999" => simulation.add_body(NeoHookean::new(lame(0.4999)?), DENSITY, samples),
        "fluid, γ = 1" => simulation.add_body(fluid(YOUNG, 1.0)?, DENSITY, samples),
        "fluid, γ = 16" => simulation.add_body(fluid(YOUNG, 16.0)?, DENSITY, samples),
        "fluid, K = 1 Pa" => simulation.add_body(fluid(1.0, 7.0)?, DENSITY, samples),
        "sand, φ = 0.001" => simulation.add_body(sand(0.001, 0.0)?, DENSITY, samples),
        "sand, φ = π/2 − 0.001" => simulation.add_body(sand(FRAC_PI_2 - 0.001, 0.0)?, DENSITY, samples),
        _ => simulation.add_body(sand(0.5, 1e9)?, DENSITY, samples),
    };
    body.map(|_| ()).map_err(ExperimentError::stopped)
}

/// A step, or one of its half, quarter …: stable steps are those of the stiffness there was, and matter that stiffens by orders of magnitude within one
/// is refused what would turn it inside out. Nothing has happened then. Answers how often.
fn step_or_shorter(solver: &mut Solver<2>, step: f64) -> Result<u64, MpmError> {
    let mut halvings = 0;
    loop {
        match solver.step(step * 0.5_f64.powi(halvings)) {
            Err(MpmError::Law { .. } | MpmError::Particle { .. }) if halvings < MOST_HALVINGS => {
                halvings += 1
            }
            Err(error) => return Err(error),
            Ok(_) => return Ok(halvings as u64),
        }
    }
}

impl Experiment for LawsAtLimits {
    fn methods(&self) -> &'static [&'static str] {
        NAMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let parts = (2.0 * RADIUS / SPACING * 2.0).round() as usize;
        let mut disk = Cloud::cuboid([-RADIUS; 2], [RADIUS; 2], [parts; 2]);
        disk.points.retain(|x| x[0].hypot(x[1]) <= RADIUS);
        disk.volumes.truncate(disk.points.len());
        let positions: Vec<_> = disk.points.iter().map(|x| [x[0], x[1] + RADIUS + 0.05]).collect();
        let velocities = vec![[0.2 * at.ladder, -at.ladder]; positions.len()];
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &disk.volumes };
        let options = SimulationOptions::new(SPACING);
        let mut simulation = Simulation::new(options).map_err(ExperimentError::stopped)?;
        let floor = Shape::HalfSpace { point: [0.0; 2], normal: [0.0, 1.0] };
        simulation
            .add_boundary(Boundary::at_rest(floor, Surface::Friction(0.4)))
            .map_err(ExperimentError::stopped)?;
        add(at.method, &mut simulation, samples)?;
        let mut solver = Solver::Double(simulation);
        let mut watch = Watch::start(&solver);
        let start = energy(&solver, 1);
        let duration = 5.0 * RADIUS / at.ladder;
        let [mut growth, mut smallest] = [0.0_f64, f64::INFINITY];
        let (mut steps, mut refused, mut film) = (0_u64, 0_u64, Vec::new());
        while solver.time() < duration {
            let step = solver.stable_step().min(duration - solver.time());
            refused += clock.time(|| step_or_shorter(&mut solver, step)).map_err(ExperimentError::stopped)?;
            steps += 1;
            if steps.is_multiple_of(8) {
                watch.look(&mut solver, 0.0);
                growth = growth.max(energy(&solver, 1) / start - 1.0);
                smallest = solver.states(0).iter().fold(smallest, |m, state| m.min(state.volume_ratio));
            }
            if at.frames.is_some() && solver.time() / duration * FRAMES as f64 >= film.len() as f64 {
                film.push(Portrait {
                    positions: solver.positions(0),
                    values: solver.velocities(0).iter().map(|v| v[0].hypot(v[1])).collect(),
                    radius: 0.25 * SPACING,
                    field: ("speed", "m/s"),
                    range: Some((0.0, at.ladder)),
                    lines: vec![vec![[-0.6, 0.0], [0.6, 0.0]]],
                    label: format!("{}, {} m/s", at.method, at.ladder),
                });
            }
        }
        let outcome = Outcome::default()
            .count("steps refused and halved", refused)
            .invariant("largest growth of energy", growth)
            .invariant("energy left", energy(&solver, 1) / start)
            .invariant("smallest volume ratio on the way", smallest);
        let outcome = watch.held(solver.counted(outcome));
        filmed(outcome, at, "against the wall, coloured by speed", (&film, 3.0))
    }
}
