//! The vibrating bar: a standing wave along a bar, for many periods.

use super::cloud::Cloud;
use super::known_motion::KnownMotion;
use super::method::Method;
use super::portrait::{Portrait, pictured};
use super::solver::{Elasticity, Matter, Solver, Watch};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use mpm_core::{Boundary, Shape, Surface};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A bar of 25 m, E = 100 Pa, ρ₀ = 1 kg/m³, ν = 0, held in the middle and free at its ends, in its lowest vibration; the ladder is the
/// distance of nodes Δx (m). With ν = 0, P of fixed corotated matter is E (F − 1): the wave is exact for any amplitude.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct VibratingBar {
    /// Of the end at first (m/s).
    speed_m_s: Positive,
    /// How many.
    periods: Count,
    /// The step: this times Δx by the wave speed.
    courant_number: Positive,
    /// How it is held.
    support: Support,
}

/// How a body is held at x = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Support {
    /// Nodes at x ≤ 0 do not move.
    Nodes,
    /// By its own mirror image: the body from −L to L.
    MirrorImage,
}

const LENGTH: f64 = 25.0;
const YOUNG: f64 = 100.0;
const DENSITY: f64 = 1.0;
const WAVE_SPEED: f64 = 10.0;
const WAVE_NUMBER: f64 = FRAC_PI_2 / LENGTH;
const FREQUENCY: f64 = WAVE_NUMBER * WAVE_SPEED;
const PERIOD: f64 = TAU / FREQUENCY;

/// The velocity of the bar's centre of mass, by its amplitude, at the middles of steps.
#[derive(Default)]
struct Record {
    times: Vec<f64>,
    velocities: Vec<f64>,
}

impl Record {
    /// The root mean square of its error.
    fn error(&self) -> f64 {
        let square = |(t, v): (&f64, &f64)| (v - (FREQUENCY * t).cos()).powi(2);
        let sum: f64 = self.times.iter().zip(&self.velocities).map(square).sum();
        (sum / self.times.len() as f64).sqrt()
    }

    /// Amplitude and phase in the last `steps` of it, a period: those of its first Fourier component.
    fn last_period(&self, steps: usize) -> (f64, f64) {
        let from = self.times.len() - steps;
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (t, v) in self.times[from..].iter().zip(&self.velocities[from..]) {
            cosine += v * (FREQUENCY * t).cos();
            sine += v * (FREQUENCY * t).sin();
        }
        let scale = 2.0 / steps as f64;
        ((scale * cosine).hypot(scale * sine), sine.atan2(cosine))
    }
}

impl VibratingBar {
    fn motion(&self) -> KnownMotion {
        let amplitude = self.speed_m_s.value() / FREQUENCY;
        KnownMotion::Vibration { amplitude, wave_number: WAVE_NUMBER, frequency: FREQUENCY }
    }

    fn cloud(&self, spacing: f64, along: usize) -> Cloud<2> {
        let cells = (LENGTH / spacing).round() as usize;
        match self.support {
            Support::Nodes => Cloud::cuboid([0.0; 2], [LENGTH, spacing], [along * cells, along]),
            Support::MirrorImage => {
                Cloud::cuboid([-LENGTH, 0.0], [LENGTH, spacing], [2 * along * cells, along])
            }
        }
    }

    /// Stress over its amplitude, along the bar: of the particles and exact.
    fn portrait(&self, cloud: &Cloud<2>, solver: &Solver<2>, label: String) -> Portrait<2> {
        let amplitude = self.strain() * YOUNG;
        let exact = |x: f64| (WAVE_NUMBER * x).cos();
        let found = |p: usize, stress: f64| (cloud.points[p][0], stress / amplitude);
        let states = solver.states(0);
        let seen: Vec<(f64, f64)> = (0..states.len())
            .filter(|p| cloud.points[*p][0] > 0.0)
            .map(|p| found(p, states[p].kirchhoff[(0, 0)] / states[p].volume_ratio))
            .collect();
        let ordinate = 0.3 * LENGTH;
        let line =
            (0..=100).map(|k| 0.01 * LENGTH * f64::from(k)).map(|x| [x, ordinate * exact(x)]).collect();
        Portrait {
            positions: seen.iter().map(|(x, s)| [*x, ordinate * s]).collect(),
            values: seen.iter().map(|(x, s)| s - exact(*x)).collect(),
            radius: 0.005 * LENGTH,
            field: ("error", "1"),
            range: None,
            lines: vec![line, vec![[0.0; 2], [LENGTH, 0.0]]],
            label,
        }
    }

    /// The largest strain.
    fn strain(&self) -> f64 {
        self.speed_m_s.value() / WAVE_SPEED
    }

    /// The root mean square of the error of P = σ (the bar does not become thinner) by its amplitude, when strain is largest.
    fn stress_error(&self, cloud: &Cloud<2>, solver: &Solver<2>) -> f64 {
        let states = solver.states(0);
        let square = |p: usize| {
            let stress = states[p].kirchhoff[(0, 0)] / states[p].volume_ratio;
            (stress / (YOUNG * self.strain()) - (WAVE_NUMBER * cloud.points[p][0]).cos()).powi(2)
        };
        ((0..states.len()).map(square).sum::<f64>() / states.len() as f64).sqrt()
    }
}

impl Experiment for VibratingBar {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let matter = Matter::new(Elasticity::FixedCorotated, (YOUNG, 0.0), DENSITY)?;
        let spacing = at.ladder;
        let cloud = self.cloud(spacing, method.along);
        // A multiple of four: strain is largest at a quarter of a period.
        let quarter = (0.25 * PERIOD * WAVE_SPEED / (self.courant_number.value() * spacing)).ceil() as usize;
        let step = PERIOD / (4 * quarter) as f64;
        let motion = self.motion();
        let mut solver = motion.start(&matter, &cloud, method, (spacing, step))?;
        if self.support == Support::Nodes {
            let wall = Shape::HalfSpace { point: [0.0; 2], normal: [1.0, 0.0] };
            solver.add_boundary(Boundary::at_rest(wall, Surface::Sticky))?;
        }
        let energy = |solver: &Solver<2>| {
            let totals = solver.totals(0);
            totals.kinetic_energy + totals.affine_energy + totals.stored_energy
        };
        let half: Vec<usize> = (0..cloud.points.len()).filter(|p| cloud.points[*p][0] > 0.0).collect();
        let mut watch = Watch::start(&solver);
        let before = energy(&solver);
        let mut record = Record::default();
        let mut outcome = Outcome::default();
        let steps = 4 * quarter * self.periods.value();
        for k in 1..=steps {
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            let v = solver.velocities(0);
            let mean = half.iter().map(|p| v[*p][0]).sum::<f64>() / half.len() as f64;
            record.times.push(solver.time() - 0.5 * step);
            record.velocities.push(mean * FRAC_PI_2 / self.speed_m_s.value());
            if k == steps - 3 * quarter {
                outcome = outcome.error("stress", self.stress_error(&cloud, &solver));
                let caption = format!(
                    "Stress by its amplitude along the bar, a quarter into the last of {} periods, {}; line: exact",
                    self.periods.value(),
                    at.method
                );
                outcome = pictured(outcome, at, &caption, || {
                    let label = format!("{}, Δx = {spacing:.4} m, t = {:.4} s", at.method, solver.time());
                    self.portrait(&cloud, &solver, label)
                })?;
            }
            if k % quarter == 0 {
                watch.look(&mut solver, step);
            }
        }
        let (amplitude, phase) = record.last_period(4 * quarter);
        let outcome = outcome
            .error("velocity", record.error())
            .error("amplitude", (1.0 - amplitude).abs())
            .error("phase", phase.abs())
            .error("energy", (energy(&solver) / before - 1.0).abs());
        let outcome = solver.counted(outcome);
        Ok(match self.support {
            Support::Nodes => watch.held(outcome),
            Support::MirrorImage => watch.free(outcome),
        })
    }
}
