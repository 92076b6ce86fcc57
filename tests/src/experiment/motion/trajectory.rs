//! Trajectories of worked systems against references of high precision.

use super::picture::{self, Linkage, Plane};
use super::reference::{Reference, Sample};
use super::{counted, distance, methods, size};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use lagrangian::integrator::{DormandPrince853, Tolerance, Trajectory as Path, drive};
use lagrangian::systems::{DoublePendulum, HeavyTop, Kepler, Pendulum};
use lagrangian::{EulerLagrange, LagrangianError, Phase, System};
use mechanics_core::state::StateHash;
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::ControlFlow;

/// A system integrated to the time stamps of its reference; the ladder is the step h (s), or
/// the tolerance of the method with step-size control.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Trajectory {
    /// The system.
    system: Kind,
    /// A JSON file with the system's parameters, start and samples of 32 digits, relative to the scene.
    reference: String,
}

/// The worked systems.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Pendulum,
    DoublePendulum,
    Kepler,
    HeavyTop,
}

impl Kind {
    /// The system's points (m) for pictures: angles of pendulums count from the downward vertical, those of the top
    /// are Euler's.
    fn points(self, q: &[f64], reference: &Reference) -> Vec<[f64; 3]> {
        let length = |name: &str| reference.parameter(name).unwrap_or(1.0);
        let hang = |[x, z]: [f64; 2], l: f64, angle: f64| [x + l * angle.sin(), z - l * angle.cos()];
        let upright = |[x, z]: [f64; 2]| [x, 0.0, z];
        match self {
            Self::Pendulum => vec![[0.0; 3], upright(hang([0.0; 2], length("l"), q[0]))],
            Self::DoublePendulum => {
                let knee = hang([0.0; 2], length("l1"), q[0]);
                vec![[0.0; 3], upright(knee), upright(hang(knee, length("l2"), q[1]))]
            }
            Self::Kepler => vec![[0.0; 3], [q[0], 0.0, q[1]]],
            Self::HeavyTop => {
                let ((sine, cosine), (east, north)) = (q[0].sin_cos(), q[1].sin_cos());
                let l = length("l");
                vec![[0.0; 3], [l * sine * east, -l * sine * north, l * cosine]]
            }
        }
    }

    fn plane(self) -> Plane {
        if self == Self::HeavyTop { Plane::Space } else { Plane::Upright }
    }

    fn caption(self) -> &'static str {
        match self {
            Self::Pendulum => "the path of the bob",
            Self::DoublePendulum => "the path of the lower bob",
            Self::Kepler => "the path of the planet",
            Self::HeavyTop => "the path of the top's centre of mass",
        }
    }
}

impl Experiment for Trajectory {
    fn methods(&self) -> &'static [&'static str] {
        methods::ALL
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let reference = Reference::read(at, &self.reference)?;
        let p = |name: &str| reference.parameter(name);
        match self.system {
            Kind::Pendulum => {
                follow(self.system, Pendulum::new(p("m")?, p("l")?, p("g")?), &reference, at, clock)
            }
            Kind::DoublePendulum => {
                let lagrangian = DoublePendulum::new([p("m1")?, p("m2")?], [p("l1")?, p("l2")?], p("g")?);
                follow(self.system, lagrangian, &reference, at, clock)
            }
            Kind::Kepler => follow(self.system, Kepler::new(p("m")?, p("k")?), &reference, at, clock),
            Kind::HeavyTop => follow(
                self.system,
                HeavyTop::new(p("I1")?, p("I3")?, p("m")?, p("l")?, p("g")?),
                &reference,
                at,
                clock,
            ),
        }
    }
}

fn follow<const N: usize, L: lagrangian::Lagrangian<N> + 'static>(
    kind: Kind,
    lagrangian: Result<L, LagrangianError>,
    reference: &Reference,
    at: &Point<'_>,
    clock: &mut Clock,
) -> Result<Outcome, ExperimentError> {
    let system = EulerLagrange::new(lagrangian.map_err(ExperimentError::stopped)?);
    let (q, v) = reference.start::<N>()?;
    let energy = system.energy(0.0, &q, &v);
    let mut phase = Phase::new(0.0, q, v);
    let times: Vec<f64> = reference.samples.iter().map(|sample| sample.t).collect();
    let (found, outcome) = match at.method {
        methods::ADAPTIVE => adaptive(&system, &mut phase, &times, at.ladder, clock)?,
        fixed => {
            let mut integrator = methods::fixed_step(&system, fixed)?;
            let (found, report) = clock
                .time(|| drive::sample(&system, integrator.as_mut(), &mut phase, &times, at.ladder))
                .map_err(ExperimentError::stopped)?;
            (found, counted(Outcome::default(), &report))
        }
    };

    let (mut position, mut velocity, mut drift): (f64, f64, f64) = (0.0, 0.0, 0.0);
    let mut hash = StateHash::new();
    for (state, sample) in found.phases().zip(&reference.samples) {
        position = position.max(distance(&state.q, &sample.q));
        velocity = velocity.max(distance(&state.v, &sample.qdot));
        drift = drift.max((system.energy(state.time, &state.q, &state.v) - energy).abs());
        hash.add("q", &state.q);
        hash.add("v", &state.v);
    }
    let largest =
        |of: fn(&Sample) -> &[f64]| reference.samples.iter().map(|s| size(of(s))).fold(0.0, f64::max);
    let mut outcome = outcome
        .error("position", position / largest(|sample| &sample.q))
        .error("velocity", velocity / largest(|sample| &sample.qdot))
        .error("energy", drift / energy.abs())
        .state(hash.value());
    if let Some(growth) = reference.growth {
        outcome = outcome.error("position per growth", position / growth);
    }
    outcome.simulated_seconds = times.last().copied();
    if at.frames.is_some() {
        let motion = watched(&system, Phase::new(0.0, q, v), &times, at, (kind, reference))?;
        outcome = picture::pictured(outcome, at, &motion, kind.plane(), kind.caption())?;
    }
    Ok(outcome)
}

/// The motion once more, looked at after every step.
fn watched<const N: usize, S: System<Coordinates = [f64; N]> + 'static>(
    system: &S,
    mut phase: Phase<[f64; N]>,
    times: &[f64],
    at: &Point<'_>,
    (kind, reference): (Kind, &Reference),
) -> Result<Vec<Linkage>, ExperimentError> {
    let end = times.last().copied().unwrap_or(0.0);
    let mut motion = vec![Linkage { time: 0.0, points: kind.points(&phase.q, reference) }];
    let mut look = |phase: &Phase<[f64; N]>| {
        motion.push(Linkage { time: phase.time, points: kind.points(&phase.q, reference) });
        ControlFlow::Continue(())
    };
    match at.method {
        methods::ADAPTIVE => {
            let mut method = adaptive_method(system, at.ladder)?;
            method.advance(system, &mut phase, end, look).map_err(ExperimentError::stopped)?;
        }
        fixed => {
            let mut integrator = methods::fixed_step(system, fixed)?;
            let steps = (end / at.ladder).round() as u64;
            drive::advance(system, integrator.as_mut(), &mut phase, at.ladder, steps, |phase, _| look(phase))
                .map_err(ExperimentError::stopped)?;
        }
    }
    Ok(motion)
}

fn adaptive_method<S: System>(
    system: &S,
    tolerance: f64,
) -> Result<DormandPrince853<S::Coordinates>, ExperimentError> {
    DormandPrince853::new(system)
        .with_tolerance(Tolerance::uniform(tolerance))
        .map_err(ExperimentError::stopped)
}

/// With step-size control: the ladder is the tolerance.
fn adaptive<S: System>(
    system: &S,
    phase: &mut Phase<S::Coordinates>,
    times: &[f64],
    tolerance: f64,
    clock: &mut Clock,
) -> Result<(Path<S::Coordinates>, Outcome), ExperimentError> {
    let mut method = adaptive_method(system, tolerance)?;
    let (found, report) =
        clock.time(|| method.sample(system, phase, times)).map_err(ExperimentError::stopped)?;
    let outcome = Outcome::default()
        .count("steps", report.accepted)
        .count("steps refused", report.rejected)
        .count("evaluations", report.evaluations);
    Ok((found, outcome))
}
