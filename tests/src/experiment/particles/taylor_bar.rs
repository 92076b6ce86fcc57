//! Taylor's bar: a copper cylinder shot at a wall.

use super::cloud::Cloud;
use super::method::{Method, Precision};
use super::portrait::{Portrait, filmed, pictured};
use super::solver::{Solver, Watch};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use mechanics_core::law::Lame;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::plastic::{VonMises, YieldStress};
use mpm_core::{Boundary, DeformationBuffer, Samples, Shape, Simulation, SimulationOptions, Surface};
use schemars::JsonSchema;
use serde::Deserialize;

/// A copper bar of 32.4 mm and radius 3.2 mm hits a smooth wall at 227 m/s: E = 117 GPa, ν = 0.35, ρ₀ = 8930 kg/m³, σ_y = 400 MPa + 100 MPa α;
/// 80 μs. The ladder is Δx (mm).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TaylorBar {
    /// Final length, from finer grids (mm).
    length_mm: Positive,
}

const LENGTH: f64 = 32.4e-3;
const RADIUS: f64 = 3.2e-3;
const SPEED: f64 = 227.0;
const DENSITY: f64 = 8930.0;
const DURATION: f64 = 80e-6;
const FRAMES: usize = 20;

/// Final length and radius of published finite elements \[mm\], from memory: bands to compare with.
const PUBLISHED: [[f64; 2]; 2] = [[21.26, 21.47], [6.9, 7.25]];

impl TaylorBar {
    fn start(spacing: f64, method: Method) -> Result<Simulation<f32, 3>, ExperimentError> {
        if method.precision != Precision::Single {
            return Err(ExperimentError::Refused {
                key: "validation.methods".to_owned(),
                reason: "the bar is computed in single precision".to_owned(),
            });
        }
        let gap = spacing / method.along as f64;
        let section = Cloud::annulus(0.0, RADIUS, gap);
        let layers = (LENGTH / gap).round() as usize;
        let thickness = LENGTH / layers as f64;
        let (mut positions, mut volumes) = (Vec::new(), Vec::new());
        for layer in 0..layers {
            let z = thickness * (layer as f64 + 0.5);
            positions.extend(section.points.iter().map(|x| [x[0], x[1], z]));
            volumes.extend(section.volumes.iter().map(|area| area * thickness));
        }
        let velocities = vec![[0.0, 0.0, -SPEED]; positions.len()];
        let options = SimulationOptions { spacing, kernel: method.kernel, transfer: method.transfer };
        let mut simulation = Simulation::new(options).map_err(ExperimentError::stopped)?;
        let wall = Shape::HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
        simulation
            .add_boundary(Boundary::at_rest(wall, Surface::Separating))
            .map_err(ExperimentError::stopped)?;
        let lame = Lame::from_young_poisson(117e9, 0.35).map_err(ExperimentError::stopped)?;
        let yields = YieldStress::linear(400e6, 100e6).map_err(ExperimentError::stopped)?;
        let law = VonMises::new(lame, yields).map_err(ExperimentError::stopped)?;
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        simulation.add_tracked_body(law, DENSITY, samples).map_err(ExperimentError::stopped)?;
        Ok(simulation)
    }
}

/// √(2/3) ‖dev ½ ln FFᵀ‖ of each particle: the plastic strain, but for the elastic one and for what was bent back and forth.
fn strains(solver: &Solver<3>) -> Result<Vec<f64>, ExperimentError> {
    let mut buffer = DeformationBuffer::default();
    let samples = solver.deformation_samples(0, &mut buffer)?;
    let strain = |f: &Mat3| {
        let logs = (f * f.transpose()).symmetric_eigenvalues().map(|s| 0.5 * s.ln());
        let mean = logs.sum() / 3.0;
        (2.0 / 3.0 * logs.map(|l| (l - mean).powi(2)).sum()).sqrt()
    };
    Ok(samples.gradients().iter().map(strain).collect())
}

/// Length and largest radius \[m\].
fn shape(solver: &Solver<3>, gap: f64) -> [f64; 2] {
    let (mut low, mut high, mut radius) = (f64::INFINITY, 0.0_f64, 0.0_f64);
    for x in solver.positions(0) {
        low = low.min(x[2]);
        high = high.max(x[2]);
        radius = radius.max(x[0].hypot(x[1]));
    }
    // The last layer is as thick as at the start, the first one next to nothing.
    [high - low + 0.5 * gap, radius + 0.5 * gap]
}

fn energy(solver: &Solver<3>) -> f64 {
    let totals = solver.totals(0);
    totals.kinetic_energy + totals.affine_energy + totals.stored_energy
}

impl Experiment for TaylorBar {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let spacing = 1e-3 * at.ladder;
        let gap = spacing / method.along as f64;
        let mut solver = Solver::Single(Self::start(spacing, method)?);
        let mut watch = Watch::start(&solver);
        let start = energy(&solver);
        let (mut growth, mut film) = (0.0_f64, Vec::new());
        let mut steps = 0_u64;
        while solver.time() < DURATION {
            let step = solver.stable_step().min(DURATION - solver.time());
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            steps += 1;
            if steps.is_multiple_of(64) {
                watch.look(&mut solver, 0.0);
                growth = growth.max(energy(&solver) / start - 1.0);
            }
            if at.frames.is_some() && solver.time() / DURATION * FRAMES as f64 >= film.len() as f64 {
                film.push(portrait(&solver, gap, at.method)?);
            }
        }
        let [length, radius] = shape(&solver, gap).map(|x| 1e3 * x);
        let strain = strains(&solver)?.into_iter().fold(0.0, f64::max);
        let momentum = solver.totals(0).momentum;
        let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
        let outcome = Outcome::default()
            .error("length", (length / self.length_mm.value() - 1.0).abs())
            .error("length against published", (length / middle(PUBLISHED[0]) - 1.0).abs())
            .error("radius against published", (radius / middle(PUBLISHED[1]) - 1.0).abs())
            .invariant("length (mm)", length)
            .invariant("radius (mm)", radius)
            .invariant("largest equivalent strain", strain)
            .invariant("energy left", energy(&solver) / start)
            .invariant("largest growth of energy", growth)
            .invariant(
                "momentum across the axis",
                momentum.x.hypot(momentum.y) / (SPEED * solver.totals(0).mass),
            );
        let outcome = watch.held(solver.counted(outcome));
        let outcome = filmed(outcome, at, "the impact, coloured by equivalent strain", (&film, 3.0))?;
        let last = portrait(&solver, gap, at.method)?;
        pictured(outcome, at, "half of the bar at the end; lines: published length and radius", || last)
    }
}

/// The half of the bar behind a plane through its axis.
fn portrait(solver: &Solver<3>, gap: f64, method: &str) -> Result<Portrait<3>, ExperimentError> {
    let strains = strains(solver)?;
    let (mut positions, mut values) = (Vec::new(), Vec::new());
    for (x, strain) in solver.positions(0).into_iter().zip(strains).filter(|(x, _)| x[1] > -0.25 * gap) {
        positions.push(x);
        values.push(strain);
    }
    let [length, radius] = PUBLISHED.map(|[low, high]| 0.5e-3 * (low + high));
    let line = |from: [f64; 2], to: [f64; 2]| vec![[from[0], -RADIUS, from[1]], [to[0], -RADIUS, to[1]]];
    Ok(Portrait {
        positions,
        values,
        radius: 0.5 * gap,
        field: ("equivalent strain", "1"),
        range: Some((0.0, 2.0)),
        lines: vec![
            line([-2.0 * radius, 0.0], [2.0 * radius, 0.0]),
            line([-RADIUS, length], [RADIUS, length]),
            line([radius, 0.0], [radius, 0.3 * RADIUS]),
            line([-radius, 0.0], [-radius, 0.3 * RADIUS]),
        ],
        label: format!("{method}, t = {:.1} μs", 1e6 * solver.time()),
    })
}
