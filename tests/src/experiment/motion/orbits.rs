//! Long runs: what a thousand, a hundred thousand revolutions do to what should stay.

use super::reference::Reference;
use super::{counted, distance, methods, size, unknown_method};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::integrator::drive;
use lagrangian::systems::Kepler;
use lagrangian::{EulerLagrange, Phase, System};
use mechanics_core::state::StateHash;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A Kepler ellipse followed to one of the reference's time stamps; the ladder is that time (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Orbits {
    /// A JSON file with the start (mass and strength are 1) and the exact states, relative to the scene.
    reference: String,
    /// The step h of each method (s).
    steps_s: BTreeMap<String, Positive>,
}

/// The ladder holds a time at which the reference has no state.
#[derive(Debug, thiserror::Error)]
#[error("the reference trajectory has no sample at t = {time} s")]
struct TimeError {
    time: f64,
}

impl Experiment for Orbits {
    fn methods(&self) -> &'static [&'static str] {
        methods::FIXED_STEP
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let reference = Reference::read(at, &self.reference)?;
        let step = self.steps_s.get(at.method).ok_or_else(|| unknown_method(at.method))?.value();
        let sample = reference.samples.iter().find(|sample| sample.t == at.ladder);
        let sample = sample.ok_or_else(|| ExperimentError::stopped(TimeError { time: at.ladder }))?;

        let kepler = Kepler::new(1.0, 1.0).map_err(ExperimentError::stopped)?;
        let system = EulerLagrange::new(kepler);
        let (q, v) = reference.start::<2>()?;
        let (momentum, energy) = (kepler.angular_momentum(&q, &v), system.energy(0.0, &q, &v));
        let mut integrator = methods::fixed_step(&system, at.method)?;
        let mut phase = Phase::new(0.0, q, v);
        let report = clock
            .time(|| drive::integrate(&system, integrator.as_mut(), &mut phase, at.ladder, step))
            .map_err(ExperimentError::stopped)?;

        let mut hash = StateHash::new();
        hash.add("q", &phase.q);
        hash.add("v", &phase.v);
        let mut outcome = Outcome::default()
            .error("angular momentum", (kepler.angular_momentum(&phase.q, &phase.v) / momentum - 1.0).abs())
            .error("position", distance(&phase.q, &sample.q) / size(&sample.q))
            .error("energy", (system.energy(phase.time, &phase.q, &phase.v) / energy - 1.0).abs())
            .state(hash.value());
        outcome.simulated_seconds = Some(at.ladder);
        Ok(counted(outcome, &report))
    }
}
