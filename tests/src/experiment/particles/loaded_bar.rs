//! A bar that is brought to its weight: explicit steps and implicit ones, against the waves of a bar of two layers.

use super::cloud::Cloud;
use super::method::{Method, Precision};
use super::solver::{Elasticity, Matter, Solver};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Chart, Curve};
use crate::scene::quantity::Positive;
use mpm_core::{ImplicitReport, Kernel, Transfer};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::{PI, TAU};
use std::time::Duration;

/// A bar of L = 1 m with ν = 0 hangs from its mirror image; its weight ρgL = 0.05 E comes as ½(1 − cos πt/T). Its lower quarter may be of stiffer matter. The
/// ladder is Δx/L. P of fixed corotated matter is E (F − 1): the waves are exact for any load. Steps are the stable explicit one, or multiples of it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoadedBar {
    /// T in periods of the lowest vibration.
    ramp_periods: Positive,
    /// The time in all, in the same periods.
    periods: Positive,
    /// Young's modulus of the lower quarter by that of the rest.
    stiffness_ratio: Positive,
}

/// Explicit steps that an implicit one is as long as; without, explicit steps.
const METHODS: &[(&str, Option<f64>)] = &[
    ("explicit", None),
    ("implicit, 1 explicit step", Some(1.0)),
    ("implicit, 10 explicit steps", Some(10.0)),
    ("implicit, 30 explicit steps", Some(30.0)),
    ("implicit, 100 explicit steps", Some(100.0)),
    ("implicit, 300 explicit steps", Some(300.0)),
    ("implicit, 1000 explicit steps", Some(1000.0)),
    ("implicit, 3000 explicit steps", Some(3000.0)),
    ("implicit, 10000 explicit steps", Some(10_000.0)),
];

const NAMES: &[&str] = &[
    "explicit",
    "implicit, 1 explicit step",
    "implicit, 10 explicit steps",
    "implicit, 30 explicit steps",
    "implicit, 100 explicit steps",
    "implicit, 300 explicit steps",
    "implicit, 1000 explicit steps",
    "implicit, 3000 explicit steps",
    "implicit, 10000 explicit steps",
];

const LENGTH: f64 = 1.0;
/// Where the lower layer begins.
const INTERFACE: f64 = 0.75;
/// Of the upper layer.
const YOUNG: f64 = 1e4;
const DENSITY: f64 = 1000.0;
/// ρgL/E.
const LOAD: f64 = 0.05;
/// Cells across: some, so that a step is not all preparation.
const ACROSS: usize = 4;
const ALONG: usize = 2;
/// How much of the stable step is taken: the bar becomes faster.
const PART: f64 = 0.98;
/// How often the bar is compared with what it should be.
const SAMPLES: usize = 64;
/// Their amplitudes fall as n⁻⁵.
const MODES: usize = 60;

/// One vibration of the bar: φ = sin k₁X above, A cos k₂(L − X) below.
struct Mode {
    frequency: f64,
    numbers: [f64; 2],
    below: f64,
    /// g ∫φ / ∫φ² \[m/s²\].
    drive: f64,
}

impl Mode {
    /// Of the frequency ω, in a bar with these wave speeds.
    fn new(frequency: f64, speeds: [f64; 2], gravity: f64) -> Self {
        let numbers @ [upper, lower] = speeds.map(|c| frequency / c);
        let (sine, cosine) = (upper * INTERFACE).sin_cos();
        let rest = LENGTH - INTERFACE;
        let (sine_below, cosine_below) = (lower * rest).sin_cos();
        // A cos k₂ℓ and A sin k₂ℓ are known from place and force at the interface.
        let forces = upper * speeds[0].powi(2) / (lower * speeds[1].powi(2));
        let below = sine * cosine_below + forces * cosine * sine_below;
        let area = (1.0 - cosine) / upper + below * sine_below / lower;
        let square = 0.5 * (INTERFACE - sine * cosine / upper)
            + 0.5 * below * below * (rest + sine_below * cosine_below / lower);
        Self { frequency, numbers, below, drive: gravity * area / square }
    }

    /// φ at the depth X.
    fn shape(&self, depth: f64) -> f64 {
        if depth < INTERFACE {
            (self.numbers[0] * depth).sin()
        } else {
            self.below * (self.numbers[1] * (LENGTH - depth)).cos()
        }
    }

    /// What the amplitude has at time t beyond that of rest under the load of that time: of q″ + ω²q = s, s = ½(1 − cos Ωt) up to π/Ω and 1 then.
    fn beyond_rest(&self, time: f64, ramp: f64) -> f64 {
        let (omega, drive) = (self.frequency, PI / ramp);
        let scale = 0.5 * (drive / omega).powi(2) / (omega * omega - drive * drive);
        if time < ramp {
            return self.drive * scale * ((omega * time).cos() - (drive * time).cos());
        }
        let (sine, cosine) = (omega * ramp).sin_cos();
        let (later_sine, later_cosine) = (omega * (time - ramp)).sin_cos();
        self.drive * scale * ((cosine + 1.0) * later_cosine - sine * later_sine)
    }
}

/// The exact motion: rest under the load of each time, and the vibrations.
struct Course {
    modes: Vec<Mode>,
    /// Young's moduli by ρg.
    stiffness: [f64; 2],
    ramp: f64,
}

impl Course {
    fn new(ratio: f64, gravity: f64, ramp_periods: f64) -> Self {
        let speeds = [1.0, ratio].map(|ratio| (ratio * YOUNG / DENSITY).sqrt());
        let rest = LENGTH - INTERFACE;
        // No force at the end: E₁k₁ cos k₁L₁ cos k₂ℓ = E₂k₂ sin k₁L₁ sin k₂ℓ.
        let lacking = |omega: f64| {
            let [upper, lower] = speeds.map(|c| omega / c);
            speeds[0] * (upper * INTERFACE).cos() * (lower * rest).cos()
                - speeds[1] * (upper * INTERFACE).sin() * (lower * rest).sin()
        };
        // No whole part of the distance of roots: one that is the end of two brackets would be found twice.
        let stride = PI / (INTERFACE / speeds[0] + rest / speeds[1]) / 47.3;
        let brackets = (0..).map(|k| [stride * f64::from(k), stride * f64::from(k + 1)]);
        let roots = brackets.filter(|[low, high]| lacking(*low) * lacking(*high) <= 0.0).take(MODES);
        let modes: Vec<Mode> = roots
            .map(|[mut low, mut high]| {
                let sign = lacking(low);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if lacking(middle) * sign > 0.0 { low = middle } else { high = middle }
                }
                Mode::new(0.5 * (low + high), speeds, gravity)
            })
            .collect();
        let ramp = ramp_periods * TAU / modes[0].frequency;
        Self { modes, stiffness: [1.0, ratio].map(|ratio| ratio * YOUNG / (DENSITY * gravity)), ramp }
    }

    fn period(&self) -> f64 {
        TAU / self.modes[0].frequency
    }

    /// The load's part at a time.
    fn load(&self, time: f64) -> f64 {
        if time < self.ramp { 0.5 * (1.0 - (PI * time / self.ramp).cos()) } else { 1.0 }
    }

    /// The displacement of a depth at rest, under the whole load.
    fn at_rest(&self, depth: f64) -> f64 {
        let bent = |from: f64, to: f64| LENGTH * (to - from) - 0.5 * (to * to - from * from);
        let above = depth.min(INTERFACE);
        bent(0.0, above) / self.stiffness[0] + bent(above, depth) / self.stiffness[1]
    }

    /// Displacements at a time, of points with these displacements at rest and shapes, one a mode.
    fn displacements(&self, points: &[(f64, Vec<f64>)], time: f64) -> Vec<f64> {
        let amplitudes: Vec<f64> = self.modes.iter().map(|mode| mode.beyond_rest(time, self.ramp)).collect();
        let load = self.load(time);
        let moved = |(rest, shapes): &(f64, Vec<f64>)| {
            load * rest + shapes.iter().zip(&amplitudes).map(|(shape, q)| shape * q).sum::<f64>()
        };
        points.iter().map(moved).collect()
    }

    fn points(&self, depths: &[f64]) -> Vec<(f64, Vec<f64>)> {
        let point = |&x: &f64| (self.at_rest(x), self.modes.iter().map(|mode| mode.shape(x)).collect());
        depths.iter().map(point).collect()
    }
}

/// Both layers with their mirror images, and the step that is stable.
struct Bar {
    solver: Solver<2>,
    layers: [Cloud<2>; 2],
}

impl Bar {
    fn new(spacing: f64, ratio: f64) -> Result<Self, ExperimentError> {
        let method = Method {
            kernel: Kernel::Quadratic,
            transfer: Transfer::MlsApic,
            precision: Precision::Double,
            along: ALONG,
        };
        let cells = (2.0 * LENGTH / spacing).round() as usize;
        let wide = ACROSS as f64 * spacing;
        let whole = Cloud::cuboid([-LENGTH, 0.0], [LENGTH, wide], [ALONG * cells, ALONG * ACROSS]);
        let mut layers = [Cloud::default(), Cloud::default()];
        for (x, volume) in whole.points.iter().zip(&whole.volumes) {
            let layer = &mut layers[usize::from(x[0].abs() > INTERFACE)];
            layer.points.push(*x);
            layer.volumes.push(*volume);
        }
        let mut solver = Solver::new(method, spacing)?;
        for (layer, ratio) in layers.iter().zip([1.0, ratio]) {
            let matter = Matter::new(Elasticity::FixedCorotated, (ratio * YOUNG, 0.0), DENSITY)?;
            solver.add_cloud(&matter, layer)?;
        }
        Ok(Self { solver, layers })
    }

    /// Lets the load of a time act for the step that follows.
    fn pull(&mut self, gravity: f64, step: f64) -> Result<(), ExperimentError> {
        for (body, layer) in self.layers.iter().enumerate() {
            let pull: Vec<[f64; 2]> = layer.points.iter().map(|x| [gravity.copysign(x[0]), 0.0]).collect();
            self.solver.accelerate(body, &pull, step)?;
        }
        Ok(())
    }

    /// Depths at rest of the half x > 0, and places now.
    fn half(&self) -> Vec<[f64; 2]> {
        let now = (0..2).flat_map(|body| self.solver.positions(body));
        let rest = self.layers.iter().flat_map(|layer| &layer.points);
        rest.zip(now).filter(|(rest, _)| rest[0] > 0.0).map(|(rest, now)| [rest[0], now[0]]).collect()
    }
}

impl Experiment for LoadedBar {
    fn methods(&self) -> &'static [&'static str] {
        NAMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let found = METHODS.iter().find(|(name, _)| *name == at.method);
        let &(_, longer) = found.ok_or_else(|| ExperimentError::Refused {
            key: "validation.methods".to_owned(),
            reason: format!("there is no method `{}`", at.method),
        })?;
        let gravity = LOAD * YOUNG / (DENSITY * LENGTH);
        let course = Course::new(self.stiffness_ratio.value(), gravity, self.ramp_periods.value());
        let mut bar = Bar::new(at.ladder * LENGTH, self.stiffness_ratio.value())?;
        let end = self.periods.value() * course.period();
        let wanted = PART * longer.unwrap_or(1.0) * bar.solver.stable_step();
        let steps = (end / wanted).ceil() as usize;
        let step = end / steps as f64;
        let depths: Vec<f64> = bar.half().iter().map(|[rest, _]| *rest).collect();
        let points = course.points(&depths);
        let size = course.at_rest(LENGTH);
        let lowest = (0..depths.len()).max_by(|a, b| depths[*a].total_cmp(&depths[*b])).unwrap_or_default();
        let mut total = ImplicitReport::default();
        let (mut square, mut samples, mut longest) = (0.0, 0, 0.0_f64);
        let mut path = Vec::new();
        for k in 1..=steps {
            // Explicit forces are those of the begin, implicit ones those of the end.
            let now = if longer.is_none() { k - 1 } else { k };
            bar.pull(gravity * course.load(now as f64 * step), step)?;
            if longer.is_none() {
                clock.time(|| bar.solver.step(step)).map_err(ExperimentError::stopped)?;
            } else {
                let done = clock.time(|| bar.solver.step_implicitly(step))?;
                total.iterations += done.iterations;
                total.products += done.products;
                total.product_time += done.product_time;
            }
            if k * SAMPLES / steps > (k - 1) * SAMPLES / steps {
                let time = bar.solver.time();
                let exact = course.displacements(&points, time);
                let moved: Vec<f64> = bar.half().iter().map(|[rest, now]| now - rest).collect();
                let errors = moved.iter().zip(&exact).map(|(a, b)| ((a - b) / size).powi(2));
                square += errors.sum::<f64>() / moved.len() as f64;
                samples += 1;
                path.push([time / course.period(), moved[lowest] / size, exact[lowest] / size]);
                if longer.is_none() {
                    longest = longest.max(step / bar.solver.stable_step());
                }
            }
        }
        if longer.is_some() {
            clock.add_term("Hessian products", Duration::from_secs_f64(total.product_time));
        }
        let momenta = (0..2).map(|body| bar.solver.totals(body).momentum.norm());
        let weight = DENSITY * gravity * LENGTH * ACROSS as f64 * at.ladder * LENGTH;
        let outcome = Outcome::default()
            .error("displacement", (square / f64::from(samples)).sqrt())
            .error("displacement at the end", path.last().map_or(f64::NAN, |p| (p[1] - p[2]).abs()))
            .count("Newton iterations", total.iterations)
            .count("products", total.products)
            .invariant("momentum from nothing", momenta.sum::<f64>() / (weight * course.period()))
            .invariant("longest explicit step by the stable one", longest);
        drawn(bar.solver.counted(outcome), at, &path)
    }
}

/// `outcome` with the way of the lowest particles over time.
fn drawn(outcome: Outcome, at: &Point<'_>, path: &[[f64; 3]]) -> Result<Outcome, ExperimentError> {
    let column = |k: usize| path.iter().map(|p| [p[0], p[k]]).collect::<Vec<_>>();
    let chart = Chart {
        title: format!("The end of the bar, by its place at rest: {}", at.method),
        x: "time in periods".to_owned(),
        y: "displacement".to_owned(),
        curves: vec![Curve::line("exact", column(2)), Curve::dots("found", column(1))],
    };
    outcome.charted(at, "the way of the bar's end", &chart)
}
