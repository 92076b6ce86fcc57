//! Two bars that meet end to end and part again, or lie end to end and are drawn apart: what a grid that both share makes of it.

use super::cloud::Cloud;
use super::method::Method;
use super::portrait::{Portrait, filmed};
use super::solver::{Elasticity, Matter, Solver};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use mpm_core::Samples;
use schemars::JsonSchema;
use serde::Deserialize;

/// Two bars of the same matter with ν = 0, E = 10 kPa, ρ₀ = 1000 kg/m³, the left one 1 m long, without momentum together; the ladder is Δx by that
/// length. P of fixed corotated matter is E (F − 1): d'Alembert's waves are exact for any speed.
///
/// They touch for 2L/c, L the shorter one, in which a step of strain ½ v/c goes through it and back; it leaves unstrained. With lengths L and βL the
/// velocity with which their centres part is v/β (Saint-Venant's coefficient of restitution).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MeetingBars {
    /// The speed of one against the other, v/c.
    speed_by_wave_speed: Positive,
    /// β, the length of the right one by that of the left one; at least 1.
    length_ratio: Positive,
    /// What they do at first.
    start: Start,
    /// The step: this times Δx by the wave speed.
    courant_number: Positive,
}

/// How bars begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Start {
    /// Some cells apart, towards each other.
    Apart,
    /// Face to face, away from each other: nothing should happen.
    Touching,
}

const LENGTH: f64 = 1.0;
const YOUNG: f64 = 1e4;
const DENSITY: f64 = 1000.0;
/// Of the faces at first, in cells: no node sees both.
const GAP: f64 = 4.0;
/// By how many cells they should be apart at the end.
const PARTED: f64 = 6.0;
/// Rows of particles that count as the face of a bar, in cells from its end.
const FACE: f64 = 1.0;
const FRAMES: usize = 48;

/// Both bars.
struct Bars {
    solver: Solver<2>,
    clouds: [Cloud<2>; 2],
    masses: [f64; 2],
}

impl Bars {
    /// The velocity of the right one's centre less that of the left one's \[m/s\].
    fn parting(&self) -> f64 {
        let [left, right] = [0, 1].map(|bar| self.solver.totals(bar).momentum.x / self.masses[bar]);
        right - left
    }

    fn momentum(&self) -> f64 {
        [0, 1].iter().map(|bar| self.solver.totals(*bar).momentum.norm()).sum()
    }

    fn energy(&self) -> f64 {
        let totals = [self.solver.totals(0), self.solver.totals(1)];
        totals.iter().map(|t| t.kinetic_energy + t.affine_energy + t.stored_energy).sum()
    }

    /// Their momenta together \[kg m/s\].
    fn drift(&self) -> f64 {
        (self.solver.totals(0).momentum + self.solver.totals(1).momentum).norm()
    }

    /// Distance of the faces less what is between them at rest: from the last particle of the left one to the first of the right one.
    fn gap(&self, spacing: f64, along: usize) -> f64 {
        let right = self.solver.positions(1).iter().fold(f64::INFINITY, |low, x| low.min(x[0]));
        let left = self.solver.positions(0).iter().fold(f64::NEG_INFINITY, |high, x| high.max(x[0]));
        right - left - spacing / along as f64
    }

    /// The largest strain of the matter at the faces.
    fn strain_of_faces(&self, spacing: f64) -> f64 {
        (0..2)
            .flat_map(|bar| {
                let states = self.solver.states(bar);
                let near = self.clouds[bar].points.iter().map(move |x| x[0].abs() < FACE * spacing);
                near.zip(states).filter(|(near, _)| *near).map(|(_, state)| (state.volume_ratio - 1.0).abs())
            })
            .fold(0.0_f64, f64::max)
    }

    /// Strains upwards, by that of the exact wave, at the particles' places.
    fn portrait(&self, scale: f64, (low, high): (f64, f64), label: String) -> Portrait<2> {
        let mut portrait = Portrait {
            radius: 0.004 * (high - low),
            field: ("velocity by that of approach", "1"),
            range: Some((-1.0, 1.0)),
            lines: vec![
                vec![[low, 0.0], [high, 0.0]],
                // The room that all frames need.
                vec![[low, -0.2 * (high - low)], [low, 0.2 * (high - low)]],
            ],
            label,
            ..Portrait::default()
        };
        for bar in 0..2 {
            let seen = self.solver.positions(bar).into_iter().zip(self.solver.states(bar));
            let height = |ratio: f64| ((ratio - 1.0) / scale).clamp(-1.8, 1.8) * 0.1 * (high - low);
            portrait.positions.extend(seen.map(|(x, state)| [x[0], height(state.volume_ratio)]));
        }
        portrait
    }
}

impl MeetingBars {
    fn start(&self, spacing: f64, method: Method, speed: f64) -> Result<Bars, ExperimentError> {
        let matter = Matter::new(Elasticity::FixedCorotated, (YOUNG, 0.0), DENSITY)?;
        let mut solver = Solver::new(method, spacing)?;
        let ratio = self.length_ratio.value();
        let (gap, sign) = match self.start {
            Start::Apart => (GAP * spacing, 1.0),
            Start::Touching => (0.0, -1.0),
        };
        let lengths = [LENGTH, ratio * LENGTH];
        // Without momentum together.
        let velocities = [sign * speed * ratio / (1.0 + ratio), -sign * speed / (1.0 + ratio)];
        let mut clouds = Vec::new();
        for (bar, side) in [-1.0, 1.0].into_iter().enumerate() {
            let rows = method.along * (lengths[bar] / spacing).round() as usize;
            let ends = [0.0, side * lengths[bar]];
            let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            let cloud = Cloud::cuboid([low, 0.0], [high, spacing], [rows, method.along]);
            let positions: Vec<_> = cloud.points.iter().map(|x| [x[0] + 0.5 * side * gap, x[1]]).collect();
            let moving = vec![[velocities[bar], 0.0]; positions.len()];
            let samples = Samples { positions: &positions, velocities: &moving, volumes: &cloud.volumes };
            solver.add_body(&matter, samples)?;
            clouds.push(cloud);
        }
        let masses = [0, 1].map(|bar| solver.totals(bar).mass);
        let [left, right] = [clouds.swap_remove(0), clouds.swap_remove(0)];
        Ok(Bars { solver, clouds: [left, right], masses })
    }
}

impl Experiment for MeetingBars {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let ratio = self.length_ratio.value();
        if ratio < 1.0 {
            return Err(ExperimentError::Refused {
                key: "experiment.parameters.length_ratio".to_owned(),
                reason: format!("{ratio} is not allowed: the left bar is the shorter one, so at least 1"),
            });
        }
        let method = Method::named(at.method)?;
        let wave_speed = (YOUNG / DENSITY).sqrt();
        let speed = self.speed_by_wave_speed.value() * wave_speed;
        let spacing = at.ladder * LENGTH;
        let mut bars = self.start(spacing, method, speed)?;
        // Until they touch, while they do, and until they should have parted.
        let (touch, contact, parting) = match self.start {
            Start::Apart => (GAP * spacing / speed, 2.0 * LENGTH / wave_speed, speed / ratio),
            Start::Touching => (0.0, 0.0, speed),
        };
        let end = touch + contact + PARTED * spacing / parting;
        let steps = (end * wave_speed / (self.courant_number.value() * spacing)).ceil() as usize;
        let step = end / steps as f64;
        let (before, size) = (bars.energy(), bars.momentum());
        let (mut fastest, mut drift, mut growth, mut longest) =
            (f64::NEG_INFINITY, 0.0_f64, 0.0_f64, 0.0_f64);
        let mut square = 0.0;
        let mut film = Vec::new();
        let reach = ratio * LENGTH + 0.5 * GAP * spacing;
        for k in 1..=steps {
            clock.time(|| bars.solver.step(step)).map_err(ExperimentError::stopped)?;
            let time = bars.solver.time();
            let now = bars.parting();
            fastest = fastest.max(now);
            // The force is constant while they touch.
            let exact = match self.start {
                Start::Apart => -speed + ((time - touch) / contact).clamp(0.0, 1.0) * (speed + parting),
                Start::Touching => speed,
            };
            square += ((now - exact) / speed).powi(2);
            drift = drift.max(bars.drift() / size);
            growth = growth.max(bars.energy() / before - 1.0);
            if k % steps.div_ceil(16) == 0 {
                longest = longest.max(step / bars.solver.stable_step());
            }
            if at.frames.is_some() && k * FRAMES / steps > (k - 1) * FRAMES / steps {
                let label =
                    format!("{}: strain upwards, t = {:.2} L/c", at.method, time * wave_speed / LENGTH);
                let scale = 0.5 * speed / wave_speed;
                let mut seen = bars.portrait(scale, (-LENGTH - 0.5 * GAP * spacing, reach), label);
                for bar in 0..2 {
                    seen.values.extend(bars.solver.velocities(bar).iter().map(|v| v[0] / speed));
                }
                film.push(seen);
            }
        }
        let found = bars.parting();
        let outcome = Outcome::default()
            .error("velocity of parting", (found - parting).abs() / speed)
            .error("drawn back", (fastest - found) / speed)
            .error("strain of faces", bars.strain_of_faces(spacing) * wave_speed / speed)
            .error("history", (square / steps as f64).sqrt())
            .error("energy lost", 1.0 - bars.energy() / before)
            .invariant("coefficient of restitution", found / speed)
            .invariant("gap at the end (Δx)", bars.gap(spacing, method.along) / spacing)
            .invariant("momentum from nothing", drift)
            .invariant("largest growth of energy", growth)
            .invariant("longest step by the stable one", longest);
        let outcome = bars.solver.counted(outcome);
        filmed(outcome, at, "the encounter: strain upwards, coloured by velocity", (&film, 6.0))
    }
}
