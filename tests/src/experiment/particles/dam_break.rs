//! Water that is let go: a column between a wall and nothing, against the front that was filmed; a long reservoir, against Ritter's solution.

use super::cloud::Cloud;
use super::method::Method;
use super::portrait::{Portrait, filmed, pictured};
use super::solver::{Solver, Watch};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use mechanics_core::tensor::Mat3;
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_core::{Boundary, Samples, Shape, Simulation, SimulationOptions, Surface};
use schemars::JsonSchema;
use serde::Deserialize;

/// Weakly compressible water, c = 10 √(2gH), on a smooth floor; the ladder is Δx by the depth H, or when, by √(H/g).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DamBreak {
    /// What is let go.
    dam: Dam,
}

/// What is let go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Dam {
    /// A column a = 57.15 mm wide and H = 2a high, as in the film of J. C. Martin and W. J. Moyce; the ladder is Δx/H.
    Column,
    /// A reservoir of depth H = 1 m, so long that its end does not matter, on nodes H/16 apart; the ladder is t √(g/H).
    Reservoir,
}

const GRAVITY: f64 = 9.81;
const DENSITY: f64 = 1000.0;
/// Of water, in its equation of state.
const EXPONENT: f64 = 7.0;
/// The width of the column \[m\].
const WIDTH: f64 = 0.057_15;
/// The reservoir's length by H t √(g/H): the hollow has come back by one of it.
const RESERVOIR: f64 = 1.25;
const RESERVOIR_SPACING: f64 = 1.0 / 16.0;
/// The measured part of the reservoir, ξ = x/(t √(gH)): its hollow's end is at −1, its front, a film thinner than any cell, at 2.
const MEASURED: [f64; 2] = [-1.0, 1.25];
const FRAMES: usize = 24;

/// J. C. Martin, W. J. Moyce, *An experimental study of the collapse of liquid columns on a rigid horizontal plane*, Phil. Trans. R. Soc. A 244
/// (1952): (t √(2g/a), x/a) of the front for H = 2a, a = 2¼ in. From memory: a band to compare with.
const FILMED: [[f64; 2]; 15] = [
    [0.41, 1.11],
    [0.84, 1.22],
    [1.19, 1.44],
    [1.43, 1.67],
    [1.63, 1.89],
    [1.83, 2.11],
    [1.98, 2.33],
    [2.20, 2.56],
    [2.32, 2.78],
    [2.51, 3.00],
    [2.65, 3.22],
    [2.83, 3.44],
    [2.98, 3.67],
    [3.11, 3.89],
    [3.33, 4.11],
];
/// The gate has gone: from here on speeds can be compared.
const GONE: usize = 4;

/// A body of water before it is let go.
struct Water {
    /// Of the box it fills \[m\].
    length: f64,
    depth: f64,
    /// How long it moves \[s\].
    duration: f64,
    /// Δx \[m\].
    spacing: f64,
}

impl Water {
    fn of(dam: Dam, ladder: f64) -> Self {
        match dam {
            Dam::Column => {
                let (depth, last) = (2.0 * WIDTH, FILMED[FILMED.len() - 1][0]);
                // Coarse fronts are late.
                let duration = 1.3 * last * (WIDTH / (2.0 * GRAVITY)).sqrt();
                Self { length: WIDTH, depth, duration, spacing: ladder * depth }
            }
            Dam::Reservoir => Self {
                length: RESERVOIR * ladder,
                depth: 1.0,
                duration: ladder / GRAVITY.sqrt(),
                spacing: RESERVOIR_SPACING,
            },
        }
    }

    /// K for c = 10 √(2gH).
    fn bulk_modulus(&self) -> f64 {
        DENSITY * 200.0 * GRAVITY * self.depth
    }

    /// Water at rest in its weight behind the dam at x = 0, the free side on the right.
    fn start(&self, method: Method) -> Result<Simulation<f64, 2>, ExperimentError> {
        let spacing = self.spacing;
        let options = SimulationOptions { spacing, kernel: method.kernel, transfer: method.transfer };
        let mut simulation = Simulation::new(options).map_err(ExperimentError::stopped)?;
        simulation.set_gravity([0.0, -GRAVITY]).map_err(ExperimentError::stopped)?;
        let walls = Shape::Walls { low: [-self.length, 0.0], high: [f64::INFINITY; 2] };
        simulation
            .add_boundary(Boundary::at_rest(walls, Surface::Separating))
            .map_err(ExperimentError::stopped)?;
        let counts =
            [self.length, self.depth].map(|side| (side / spacing * method.along as f64).round() as usize);
        let cloud = Cloud::cuboid([-self.length, 0.0], [0.0, self.depth], counts);
        // J⁻ᵞ = 1 + γ p/K at the pressure of its depth; what fills the volume V now has the rest volume V/J.
        let ratio = |y: f64| {
            let pressure = DENSITY * GRAVITY * (self.depth - y);
            (1.0 + EXPONENT * pressure / self.bulk_modulus()).powf(-1.0 / EXPONENT)
        };
        let ratios: Vec<f64> = cloud.points.iter().map(|x| ratio(x[1])).collect();
        let volumes: Vec<f64> = cloud.volumes.iter().zip(&ratios).map(|(v, j)| v / j).collect();
        let velocities = vec![[0.0; 2]; cloud.points.len()];
        let samples = Samples { positions: &cloud.points, velocities: &velocities, volumes: &volumes };
        let law =
            Tait::new(self.bulk_modulus(), EXPONENT, Tension::Vanishes).map_err(ExperimentError::stopped)?;
        let body = simulation.add_body(law, DENSITY, samples).map_err(ExperimentError::stopped)?;
        let pressed: Vec<Mat3> = ratios.iter().map(|j| Mat3::from_diagonal(&[1.0, *j, 1.0].into())).collect();
        simulation.set_deformation_gradients(body, &pressed).map_err(ExperimentError::stopped)?;
        Ok(simulation)
    }

    /// Kinetic, stored and potential energy over a floor \[J/m\].
    fn energy(&self, solver: &Solver<2>, masses: &[f64]) -> f64 {
        let totals = solver.totals(0);
        let weight: f64 = solver.positions(0).iter().zip(masses).map(|(x, m)| m * GRAVITY * x[1]).sum();
        totals.kinetic_energy + totals.affine_energy + totals.stored_energy + weight
    }
}

impl Experiment for DamBreak {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::in_double(at.method, "water")?;
        let water = Water::of(self.dam, at.ladder);
        let spacing = water.spacing;
        let mut solver = Solver::Double(water.start(method)?);
        let gap = spacing / method.along as f64;
        let count = solver.positions(0).len();
        let masses = vec![solver.totals(0).mass / count as f64; count];
        let mut watch = Watch::start(&solver);
        let start = water.energy(&solver, &masses);
        let (mut growth, mut front, mut film) = (0.0_f64, vec![[0.0, 0.0]], Vec::new());
        while solver.time() < water.duration {
            let left = water.duration - solver.time();
            let step = solver.stable_step().min(left);
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            if front.len().is_multiple_of(16) {
                watch.look(&mut solver, 0.0);
                growth = growth.max(water.energy(&solver, &masses) / start - 1.0);
            }
            let foremost = solver.positions(0).iter().fold(f64::NEG_INFINITY, |most, x| most.max(x[0]));
            front.push([solver.time(), foremost + 0.5 * gap]);
            let part = solver.time() / water.duration * FRAMES as f64;
            if at.frames.is_some() && part >= film.len() as f64 {
                film.push(self.portrait(&water, &solver, gap, at.method));
            }
        }
        let outcome = match self.dam {
            Dam::Column => against_film(&front),
            Dam::Reservoir => against_ritter(&water, &solver, spacing, count),
        };
        let lowest = solver.positions(0).iter().fold(0.0_f64, |low, x| low.min(x[1]));
        let outcome = outcome
            .invariant("largest growth of energy", growth)
            .invariant("deepest particle below the floor (Δx)", -lowest / spacing);
        let outcome = watch.held(solver.counted(outcome));
        let outcome = filmed(outcome, at, "the water, coloured by speed", (&film, 4.0))?;
        pictured(outcome, at, "at the end; line: the reference", || {
            self.portrait(&water, &solver, gap, at.method)
        })
    }
}

/// When the front, (s, m) in order of time, comes to a place \[s\].
fn arrival(front: &[[f64; 2]], place: f64) -> f64 {
    let mut passages = front.windows(2).filter(|pair| pair[0][1] < place && pair[1][1] >= place);
    passages.next().map_or(f64::NAN, |pair| {
        let [[t0, x0], [t1, x1]] = [pair[0], pair[1]];
        t0 + (t1 - t0) * (place - x0) / (x1 - x0)
    })
}

/// How much earlier than in the film the front comes to its places, in the mean; and how its speed compares.
fn against_film(front: &[[f64; 2]]) -> Outcome {
    let unit = (2.0 * GRAVITY / WIDTH).sqrt();
    // From the dam at x = 0; the film counts from the wall.
    let arrivals: Vec<f64> = FILMED.iter().map(|[_, z]| unit * arrival(front, (z - 1.0) * WIDTH)).collect();
    let ahead = FILMED.iter().zip(&arrivals).map(|([t, _], found)| t - found).sum::<f64>();
    let last = FILMED.len() - 1;
    let speed = |times: [f64; 2]| (FILMED[last][1] - FILMED[GONE][1]) / (times[1] - times[0]);
    let (found, filmed) =
        (speed([arrivals[GONE], arrivals[last]]), speed([FILMED[GONE][0], FILMED[last][0]]));
    Outcome::default()
        .error("front ahead of the film", (ahead / FILMED.len() as f64).abs())
        .error("front's speed against the film's", (found / filmed - 1.0).abs())
}

/// The depth of Ritter's solution by H: (2 − ξ)²/9.
fn ritter(xi: f64) -> f64 {
    (2.0 - xi.clamp(-1.0, 2.0)).powi(2) / 9.0
}

/// Water between the places: its area by H, in columns of two cells.
fn against_ritter(water: &Water, solver: &Solver<2>, spacing: f64, count: usize) -> Outcome {
    let reach = solver.time() * (GRAVITY * water.depth).sqrt();
    let [low, high] = MEASURED.map(|xi| xi * reach);
    let columns = ((high - low) / (2.0 * spacing)).round() as usize;
    let width = (high - low) / columns as f64;
    let each = water.length * water.depth / count as f64;
    let mut areas = vec![0.0; columns];
    let mut discharged = 0.0;
    for x in solver.positions(0) {
        if x[0] >= low && x[0] < high {
            areas[((x[0] - low) / width) as usize % columns] += each;
        }
        if x[0] >= 0.0 {
            discharged += each;
        }
    }
    let off = |(k, area): (usize, &f64)| {
        let xi = (low + width * (k as f64 + 0.5)) / reach;
        (area / width / water.depth - ritter(xi)).abs()
    };
    let depth = areas.iter().enumerate().map(off).sum::<f64>() / columns as f64;
    // Through the dam flows 8/27 H √(gH) t.
    let outflow = discharged / (8.0 / 27.0 * water.depth * reach);
    let foremost = solver.positions(0).iter().fold(0.0_f64, |most, x| most.max(x[0]));
    Outcome::default()
        .error("depth", depth)
        .error("outflow", (outflow - 1.0).abs())
        .invariant("front by Ritter's", foremost / (2.0 * reach))
}

impl DamBreak {
    fn portrait(&self, water: &Water, solver: &Solver<2>, gap: f64, method: &str) -> Portrait<2> {
        let time = solver.time();
        let mut lines = vec![];
        let right = match self.dam {
            Dam::Column => {
                // Where the film's front is now.
                let now = time * (2.0 * GRAVITY / WIDTH).sqrt();
                let front =
                    FILMED.iter().filter(|[t, _]| *t <= now).map(|[_, z]| (z - 1.0) * WIDTH).next_back();
                lines.extend(front.map(|x| vec![[x, 0.0], [x, 0.3 * water.depth]]));
                4.0 * WIDTH
            }
            Dam::Reservoir => {
                let reach = time * (GRAVITY * water.depth).sqrt();
                let xi = |k: i32| -1.0 + 0.03 * f64::from(k);
                let surface = (0..=100).map(|k| [xi(k) * reach, water.depth * ritter(xi(k))]);
                lines.push(std::iter::once([-water.length, water.depth]).chain(surface).collect());
                2.0 / RESERVOIR * water.length
            }
        };
        lines.push(vec![[-water.length, water.depth], [-water.length, 0.0], [right, 0.0]]);
        Portrait {
            positions: solver.positions(0),
            values: solver.velocities(0).iter().map(|v| v[0].hypot(v[1])).collect(),
            radius: 0.5 * gap,
            field: ("speed", "m/s"),
            range: Some((0.0, 2.0 * (GRAVITY * water.depth).sqrt())),
            lines,
            label: format!("{method}, t = {time:.3} s"),
        }
    }
}
