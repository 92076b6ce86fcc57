//! Sand in a box, for very many steps.

use super::super::cloud::Cloud;
use super::super::method::Method;
use super::super::portrait::{Portrait, pictured};
use super::super::solver::{Solver, Watch};
use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use mechanics_core::law::Lame;
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle};
use mpm_core::{Boundary, Samples, Shape, Simulation, SimulationOptions, Surface};
use schemars::JsonSchema;
use serde::Deserialize;

/// Dry sand, 0.4 m × 0.2 m in the plane, E = 1e6 Pa, ν = 0.3, 1600 kg/m³, φ = 30°, with random velocities of up to 1 m/s in a box of 0.4 m with smooth walls; the ladder is
/// how many steps it is left there.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SettlingSand {}

const SPACING: f64 = 0.05;
const SIZE: [f64; 2] = [0.4, 0.2];
const DENSITY: f64 = 1600.0;
const GRAVITY: f64 = 9.81;

impl Experiment for SettlingSand {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::in_double(at.method, "sand")?;
        let options =
            SimulationOptions { spacing: SPACING, kernel: method.kernel, transfer: method.transfer };
        let mut simulation = Simulation::<f64, 2>::new(options).map_err(ExperimentError::stopped)?;
        simulation.set_gravity([0.0, -GRAVITY]).map_err(ExperimentError::stopped)?;
        let walls = Shape::Walls { low: [0.0; 2], high: [SIZE[0], f64::INFINITY] };
        simulation
            .add_boundary(Boundary::at_rest(walls, Surface::Separating))
            .map_err(ExperimentError::stopped)?;
        let counts = SIZE.map(|side| (side / SPACING * method.along as f64).round() as usize);
        let cloud = Cloud::cuboid([0.0; 2], SIZE, counts);
        let mut random = Random::new(at.seed);
        let velocities: Vec<_> =
            cloud.points.iter().map(|_| [random.symmetric(), random.symmetric()]).collect();
        let lame = Lame::from_young_poisson(1e6, 0.3).map_err(ExperimentError::stopped)?;
        let angle = FrictionAngle::constant(30.0_f64.to_radians()).map_err(ExperimentError::stopped)?;
        let law = DruckerPrager::new(lame, angle, 0.0).map_err(ExperimentError::stopped)?;
        let samples = Samples { positions: &cloud.points, velocities: &velocities, volumes: &cloud.volumes };
        simulation.add_body(law, DENSITY, samples).map_err(ExperimentError::stopped)?;
        let mut solver = Solver::Double(simulation);
        let mut watch = Watch::start(&solver);
        let step = 0.8 * solver.stable_step();
        // What the sand loses by falling through its own height.
        let unit = solver.totals(0).mass * GRAVITY * SIZE[1];
        let kinetic = |solver: &Solver<2>| {
            let totals = solver.totals(0);
            (totals.kinetic_energy + totals.affine_energy) / unit
        };
        let steps = at.ladder as usize;
        let [mut most, mut late] = [0.0_f64; 2];
        for k in 0..steps {
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            if k % 16 == 0 {
                let now = kinetic(&solver);
                most = most.max(now);
                if 2 * k >= steps {
                    late = late.max(now);
                }
                watch.look(&mut solver, step);
            }
        }
        let positions = solver.positions(0);
        let height = 2.0 * positions.iter().map(|x| x[1]).sum::<f64>() / positions.len() as f64;
        let outcome = Outcome::default()
            .invariant("largest kinetic energy by ρgH", most)
            .invariant("largest kinetic energy in the second half by ρgH", late)
            .invariant("height at the end by that at the start", height / SIZE[1]);
        let outcome = watch.held(solver.counted(outcome));
        pictured(outcome, at, "the sand at the end, coloured by vertical stress", || Portrait {
            positions: solver.positions(0),
            values: solver.states(0).iter().map(|state| 1e-3 * state.kirchhoff[(1, 1)]).collect(),
            radius: 0.5 * SPACING / method.along as f64,
            field: ("vertical stress", "kPa"),
            lines: vec![vec![[0.0, 0.4], [0.0, 0.0], [SIZE[0], 0.0], [SIZE[0], 0.4]]],
            label: format!("{}, {steps} steps", at.method),
            ..Portrait::default()
        })
    }
}
