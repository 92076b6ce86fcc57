//! A free rigid body: the flip of its intermediate axis.

use super::reference::{numbers, read_json};
use super::{counted, distance, methods, size};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use lagrangian::integrator::drive;
use lagrangian::systems::FreeBody;
use lagrangian::{EulerLagrange, Phase, System};
use mechanics_core::state::StateHash;
use schemars::JsonSchema;
use serde::Deserialize;

/// A free rigid body from the orientation 1; the ladder is the step h (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RigidBody {
    /// A JSON file with moments of inertia, angular velocity and samples of 32 digits, relative to the scene.
    reference: String,
}

#[derive(Deserialize)]
struct File {
    #[serde(rename = "I")]
    inertia: [f64; 3],
    omega0: [f64; 3],
    samples: Vec<Turned>,
}

#[derive(Deserialize)]
struct Turned {
    t: f64,
    #[serde(deserialize_with = "numbers")]
    omega_body: Vec<f64>,
    #[serde(deserialize_with = "numbers")]
    quat_wxyz: Vec<f64>,
}

impl Experiment for RigidBody {
    fn methods(&self) -> &'static [&'static str] {
        methods::FIXED_STEP
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let File { inertia, omega0, samples } = read_json(at.folder, &self.reference)?;
        let body = FreeBody::new(inertia).map_err(ExperimentError::stopped)?;
        let system = EulerLagrange::new(body);
        let q = [1.0, 0.0, 0.0, 0.0];
        let v = FreeBody::rate(&q, &omega0);
        let (energy, momentum) = (system.energy(0.0, &q, &v), body.angular_momentum(&q, &v));
        let mut integrator = methods::fixed_step(&system, at.method)?;
        let mut phase = Phase::new(0.0, q, v);
        let times: Vec<f64> = samples.iter().map(|sample| sample.t).collect();
        let (found, report) = clock
            .time(|| drive::sample(&system, integrator.as_mut(), &mut phase, &times, at.ladder))
            .map_err(ExperimentError::stopped)?;

        let (mut spin, mut orientation, mut drift, mut lost): (f64, f64, f64, f64) = (0.0, 0.0, 0.0, 0.0);
        let mut hash = StateHash::new();
        for (state, sample) in found.phases().zip(&samples) {
            let omega = FreeBody::angular_velocity(&state.q, &state.v);
            spin = spin.max(distance(&omega, &sample.omega_body));
            // q and −q are the same orientation, but both start at +1 and go the same way.
            orientation = orientation.max(distance(&state.q, &sample.quat_wxyz));
            drift = drift.max((system.energy(state.time, &state.q, &state.v) / energy - 1.0).abs());
            lost = lost.max(distance(&body.angular_momentum(&state.q, &state.v), &momentum));
            hash.add("q", &state.q);
            hash.add("v", &state.v);
        }
        let mut outcome = Outcome::default()
            .error("angular velocity", spin / size(&omega0))
            .error("orientation", orientation)
            .error("energy", drift)
            .error("angular momentum", lost / size(&momentum))
            .state(hash.value());
        outcome.simulated_seconds = times.last().copied();
        Ok(counted(outcome, &report))
    }
}
