//! Trajectories of worked systems against references of high precision.

use super::reference::{Reference, Sample};
use super::{counted, distance, methods, size};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use lagrangian::integrator::{DormandPrince853, Tolerance, Trajectory as Path, drive};
use lagrangian::systems::{DoublePendulum, HeavyTop, Kepler, Pendulum};
use lagrangian::{EulerLagrange, LagrangianError, Phase, System};
use mechanics_core::state::StateHash;
use schemars::JsonSchema;
use serde::Deserialize;

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
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Pendulum,
    DoublePendulum,
    Kepler,
    HeavyTop,
}

impl Experiment for Trajectory {
    fn methods(&self) -> &'static [&'static str] {
        methods::ALL
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let reference = Reference::read(at, &self.reference)?;
        let p = |name: &str| reference.parameter(name);
        match self.system {
            Kind::Pendulum => follow(Pendulum::new(p("m")?, p("l")?, p("g")?), &reference, at, clock),
            Kind::DoublePendulum => {
                let lagrangian = DoublePendulum::new([p("m1")?, p("m2")?], [p("l1")?, p("l2")?], p("g")?);
                follow(lagrangian, &reference, at, clock)
            }
            Kind::Kepler => follow(Kepler::new(p("m")?, p("k")?), &reference, at, clock),
            Kind::HeavyTop => {
                follow(HeavyTop::new(p("I1")?, p("I3")?, p("m")?, p("l")?, p("g")?), &reference, at, clock)
            }
        }
    }
}

fn follow<const N: usize, L: lagrangian::Lagrangian<N> + 'static>(
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
    Ok(outcome)
}

/// With step-size control: the ladder is the tolerance.
fn adaptive<S: System>(
    system: &S,
    phase: &mut Phase<S::Coordinates>,
    times: &[f64],
    tolerance: f64,
    clock: &mut Clock,
) -> Result<(Path<S::Coordinates>, Outcome), ExperimentError> {
    let mut method = DormandPrince853::new(system)
        .with_tolerance(Tolerance::uniform(tolerance))
        .map_err(ExperimentError::stopped)?;
    let (found, report) =
        clock.time(|| method.sample(system, phase, times)).map_err(ExperimentError::stopped)?;
    let outcome = Outcome::default()
        .count("steps", report.accepted)
        .count("steps refused", report.rejected)
        .count("evaluations", report.evaluations);
    Ok((found, outcome))
}
