//! A chain of masses and springs: the run-time size twin, against its exact normal modes.

use super::reference::Sample;
use super::reference::read_json;
use super::{counted, distance, methods, size};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::integrator::drive;
use lagrangian::systems::SpringChain;
use lagrangian::{Phase, SlicedEulerLagrange, System};
use mechanics_core::state::StateHash;
use schemars::JsonSchema;
use serde::Deserialize;

/// Equal masses between two walls, with equal springs, from a start that excites every mode; the ladder is the step h
/// (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Chain {
    /// A JSON file with mass, stiffness, start and exact states, relative to the scene.
    reference: String,
    /// The last of the reference's times to go to (s).
    duration_s: Positive,
}

#[derive(Deserialize)]
struct File {
    m: f64,
    k: f64,
    q0: Vec<f64>,
    qdot0: Vec<f64>,
    samples: Vec<Sample>,
}

impl Experiment for Chain {
    fn methods(&self) -> &'static [&'static str] {
        methods::FIXED_STEP
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let File { m, k, q0, qdot0, mut samples } = read_json(at.folder, &self.reference)?;
        samples.retain(|sample| sample.t <= self.duration_s.value());
        let chain = SpringChain::uniform(q0.len(), m, k).map_err(ExperimentError::stopped)?;
        let system = SlicedEulerLagrange::new(chain);
        let energy = system.energy(0.0, &q0, &qdot0);
        let mut integrator = methods::fixed_step(&system, at.method)?;
        let mut phase = Phase::new(0.0, q0, qdot0);
        let times: Vec<f64> = samples.iter().map(|sample| sample.t).collect();
        let (found, report) = clock
            .time(|| drive::sample(&system, integrator.as_mut(), &mut phase, &times, at.ladder))
            .map_err(ExperimentError::stopped)?;

        let (mut position, mut drift, mut largest): (f64, f64, f64) = (0.0, 0.0, 0.0);
        let mut hash = StateHash::new();
        for (state, sample) in found.phases().zip(&samples) {
            position = position.max(distance(&state.q, &sample.q));
            largest = largest.max(size(&sample.q));
            drift = drift.max((system.energy(state.time, &state.q, &state.v) / energy - 1.0).abs());
            hash.add("q", &state.q);
            hash.add("v", &state.v);
        }
        let mut outcome = Outcome::default()
            .error("position", position / largest)
            .error("energy", drift)
            .state(hash.value());
        outcome.simulated_seconds = times.last().copied();
        Ok(counted(outcome, &report))
    }
}
