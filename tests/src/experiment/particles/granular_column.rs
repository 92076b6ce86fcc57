//! A column of sand that is let go, and how far it runs.

use super::cloud::Cloud;
use super::method::Method;
use super::portrait::{Portrait, filmed, pictured};
use super::solver::{Solver, Watch};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use mechanics_core::law::Lame;
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle};
use mpm_core::{Boundary, Samples, Shape, Simulation, SimulationOptions, Surface};
use schemars::JsonSchema;
use serde::Deserialize;

/// A column of dry sand in the plane, 2 L₀ wide and H = a L₀ high, free to both sides on a floor with friction; the ladder is the aspect ratio a.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GranularColumn {
    /// Of internal friction in plane flow: shear over normal stress where it slides is its tangent (°).
    friction_angle_deg: Positive,
    /// Of the floor.
    floor_coefficient: Positive,
    /// In half of the column, about: L₀ and H follow from it and a.
    cells: Count,
}

const GRAVITY: f64 = 9.81;
const DENSITY: f64 = 1600.0;
/// Half of the width \[m\].
const HALF_WIDTH: f64 = 0.1;
/// Young's modulus by ρ g H: so stiff that no strain matters but that of the flow.
const STIFFNESS: f64 = 200.0;
/// The end of time by √(H/g): fronts stop at about 3.3 of them.
const END: f64 = 6.0;
/// The part of the sand ahead of where the front is taken to be: a thin layer of single particles.
const LOOSE: f64 = 0.005;
const FRAMES: usize = 24;

/// Sand of which plane flow has the angle of friction φ. In plane flow the middle principal stress is the mean of the others, and Drucker and
/// Prager's cone through the triaxial angle φ′ has sin φ = 2√3 sin φ′/(3 − sin φ′) there.
fn sand(degrees: f64, height: f64) -> Result<DruckerPrager, ExperimentError> {
    let sine = degrees.to_radians().sin();
    let triaxial = (3.0 * sine / (2.0 * 3.0_f64.sqrt() + sine)).asin();
    let angle = FrictionAngle::constant(triaxial).map_err(ExperimentError::stopped)?;
    let lame = Lame::from_young_poisson(STIFFNESS * DENSITY * GRAVITY * height, 0.3);
    DruckerPrager::new(lame.map_err(ExperimentError::stopped)?, angle, 0.0).map_err(ExperimentError::stopped)
}

impl GranularColumn {
    /// Nodes along L₀.
    fn across(&self, aspect: f64) -> f64 {
        (self.cells.value() as f64 / aspect).sqrt().round().max(2.0)
    }

    fn start(&self, aspect: f64, method: Method) -> Result<Simulation<f64, 2>, ExperimentError> {
        let (across, height) = (self.across(aspect), aspect * HALF_WIDTH);
        let spacing = HALF_WIDTH / across;
        let options = SimulationOptions { spacing, kernel: method.kernel, transfer: method.transfer };
        let mut simulation = Simulation::new(options).map_err(ExperimentError::stopped)?;
        simulation.set_gravity([0.0, -GRAVITY]).map_err(ExperimentError::stopped)?;
        let floor = Shape::HalfSpace { point: [0.0; 2], normal: [0.0, 1.0] };
        simulation
            .add_boundary(Boundary::at_rest(floor, Surface::Friction(self.floor_coefficient.value())))
            .map_err(ExperimentError::stopped)?;
        let counts =
            [2.0 * across, aspect * across].map(|cells| (cells * method.along as f64).round() as usize);
        let cloud = Cloud::cuboid([-HALF_WIDTH, 0.0], [HALF_WIDTH, height], counts);
        let velocities = vec![[0.0; 2]; cloud.points.len()];
        let samples = Samples { positions: &cloud.points, velocities: &velocities, volumes: &cloud.volumes };
        let law = sand(self.friction_angle_deg.value(), height)?;
        simulation.add_body(law, DENSITY, samples).map_err(ExperimentError::stopped)?;
        Ok(simulation)
    }
}

/// G. Lube, H. E. Huppert, R. S. J. Sparks, A. Freundt, *Collapses of two-dimensional granular columns*, Phys. Rev. E 72 (2005): (L − L₀)/L₀
/// and H_f/L₀ by a. From memory: a band to compare with.
fn experiments(aspect: f64) -> [f64; 2] {
    let run_out = if aspect < 2.3 { 1.2 * aspect } else { 1.9 * aspect.powf(2.0 / 3.0) };
    let height = if aspect < 1.15 { aspect } else { aspect.powf(0.4) };
    [run_out, height]
}

/// The largest |x| but for the loose ones, the mean of both sides.
fn front(solver: &Solver<2>) -> f64 {
    let mut across: Vec<f64> = solver.positions(0).iter().map(|x| x[0]).collect();
    across.sort_by(f64::total_cmp);
    let few = (LOOSE * across.len() as f64) as usize;
    0.5 * (across[across.len() - 1 - few] - across[few])
}

/// Kinetic, stored and potential energy over the floor \[J/m\]; all particles have the same mass.
fn energy(solver: &Solver<2>) -> f64 {
    let (totals, positions) = (solver.totals(0), solver.positions(0));
    let height = positions.iter().map(|x| x[1]).sum::<f64>() / positions.len() as f64;
    totals.kinetic_energy + totals.affine_energy + totals.stored_energy + totals.mass * GRAVITY * height
}

impl Experiment for GranularColumn {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (aspect, method) = (at.ladder, Method::in_double(at.method, "sand")?);
        let height = aspect * HALF_WIDTH;
        let spacing = HALF_WIDTH / self.across(aspect);
        let mut solver = Solver::Double(self.start(aspect, method)?);
        let mut watch = Watch::start(&solver);
        let (start, unit) = (energy(&solver), (height / GRAVITY).sqrt());
        let (mut growth, mut stopped, mut film) = (0.0_f64, f64::NAN, Vec::new());
        let mut before = front(&solver);
        let mut steps = 0_u64;
        while solver.time() < END * unit {
            let step = solver.stable_step().min(END * unit - solver.time());
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            steps += 1;
            if steps.is_multiple_of(200) {
                watch.look(&mut solver, 0.0);
                growth = growth.max(energy(&solver) / start - 1.0);
                let now = front(&solver);
                if now - before > 1e-3 * HALF_WIDTH {
                    stopped = solver.time();
                }
                before = now;
            }
            if at.frames.is_some() && solver.time() / (END * unit) * FRAMES as f64 >= film.len() as f64 {
                film.push(portrait(&solver, (spacing / method.along as f64, aspect), at.method));
            }
        }
        let run_out = front(&solver) / HALF_WIDTH - 1.0;
        let top = solver.positions(0).iter().fold(0.0_f64, |top, x| top.max(x[1]));
        let left_high = (top + 0.5 * spacing / method.along as f64) / HALF_WIDTH;
        let [lube, high] = experiments(aspect);
        let totals = solver.totals(0);
        let speed = (2.0 * totals.kinetic_energy / totals.mass).sqrt();
        let outcome = Outcome::default()
            .error("run-out by L₀", run_out)
            .error("run-out against experiments", (run_out / lube - 1.0).abs())
            .error("height left against experiments", (left_high / high - 1.0).abs())
            .invariant("run-out by that of experiments", run_out / lube)
            .invariant("height left by L₀", left_high)
            .invariant("mean speed at the end by √(gH)", speed / (GRAVITY * height).sqrt())
            .invariant("front stops at (√(H/g))", stopped / unit)
            .invariant("largest growth of energy", growth);
        let outcome = watch.held(solver.counted(outcome));
        let outcome = filmed(outcome, at, "the collapse, coloured by speed", (&film, 4.0))?;
        pictured(outcome, at, "the heap; lines: the column, and run-out and height of experiments", || {
            portrait(&solver, (spacing / method.along as f64, aspect), at.method)
        })
    }
}

fn portrait(solver: &Solver<2>, (gap, aspect): (f64, f64), method: &str) -> Portrait<2> {
    let [run_out, high] = experiments(aspect).map(|x| x * HALF_WIDTH);
    let (edge, height) = (HALF_WIDTH + run_out, aspect * HALF_WIDTH);
    let column = vec![[-HALF_WIDTH, 0.0], [-HALF_WIDTH, height], [HALF_WIDTH, height], [HALF_WIDTH, 0.0]];
    Portrait {
        positions: solver.positions(0),
        values: solver.velocities(0).iter().map(|v| v[0].hypot(v[1])).collect(),
        radius: 0.5 * gap,
        field: ("speed", "m/s"),
        range: Some((0.0, (2.0 * GRAVITY * height).sqrt())),
        lines: vec![
            vec![[-1.2 * edge, 0.0], [1.2 * edge, 0.0]],
            vec![[-edge, 0.0], [-edge, 0.1 * edge]],
            vec![[edge, 0.0], [edge, 0.1 * edge]],
            vec![[-0.1 * edge, high], [0.1 * edge, high]],
            column,
        ],
        label: format!("{method}, a = {aspect}, t = {:.3} s", solver.time()),
    }
}
