//! A bead on a wire in Cartesian coordinates: position, reaction and constraint.

use super::reference::{number, read_json};
use super::{counted, unknown_method};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use lagrangian::constraint::{Composition, Constrained, Constraints, Holonomic, Rattle};
use lagrangian::integrator::drive;
use lagrangian::systems::Projectile;
use lagrangian::{EulerLagrange, Phase, System};
use mechanics_core::scalar::Scalar;
use mechanics_core::state::StateHash;
use schemars::JsonSchema;
use serde::Deserialize;

/// A bead of 1 kg on the parabola y = x²/2 under gravity 9.81 m/s²; the ladder is the step h (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BeadOnWire {
    /// A JSON file with samples of 32 digits, relative to the scene.
    reference: String,
}

#[derive(Deserialize)]
struct File {
    samples: Vec<Sample>,
}

#[derive(Deserialize)]
struct Sample {
    t: f64,
    #[serde(deserialize_with = "number")]
    x: f64,
    #[serde(deserialize_with = "number")]
    y: f64,
    #[serde(deserialize_with = "number")]
    vx: f64,
    #[serde(deserialize_with = "number")]
    vy: f64,
    #[serde(deserialize_with = "number")]
    lam: f64,
}

/// φ = y − x²/2.
struct Parabola;

impl Holonomic<2, 1> for Parabola {
    fn constraint<S: Scalar>(&self, [x, y]: &[S; 2], _: S) -> [S; 1] {
        [*y - x.square().scale(0.5)]
    }
}

impl Experiment for BeadOnWire {
    fn methods(&self) -> &'static [&'static str] {
        &["rattle-2", "rattle-4", "rattle-6", "rattle-8"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let composition = match at.method {
            "rattle-2" => Composition::Second,
            "rattle-4" => Composition::Fourth,
            "rattle-6" => Composition::Sixth,
            "rattle-8" => Composition::Eighth,
            other => return Err(unknown_method(other)),
        };
        let File { samples } = read_json(at.folder, &self.reference)?;
        let [first, ..] = samples.as_slice() else {
            return Err(ExperimentError::Refused {
                key: "experiment.parameters.reference".to_owned(),
                reason: "it has no samples".to_owned(),
            });
        };
        let system = EulerLagrange::new(Projectile::new(1.0, 9.81).map_err(ExperimentError::stopped)?);
        let wire = Constraints::new(Parabola);
        let mut rattle = Rattle::composed(Constraints::new(Parabola), composition);
        let mut phase = Phase::new(0.0, [first.x, first.y], [first.vx, first.vy]);
        let energy = system.energy(0.0, &phase.q, &phase.v);
        let times: Vec<f64> = samples.iter().map(|sample| sample.t).collect();
        let (found, report) = clock
            .time(|| drive::sample(&system, &mut rattle, &mut phase, &times, at.ladder))
            .map_err(ExperimentError::stopped)?;

        let (mut position, mut reaction, mut constraint, mut drift): (f64, f64, f64, f64) =
            (0.0, 0.0, 0.0, 0.0);
        let mut hash = StateHash::new();
        for (state, sample) in found.phases().zip(&samples) {
            let [x, y] = state.q;
            position = position.max((x - sample.x).abs()).max((y - sample.y).abs());
            let here = Constrained::new(&system, &wire).motion(&state).map_err(ExperimentError::stopped)?;
            reaction = reaction.max((here.multipliers[0] - sample.lam).abs());
            constraint = constraint.max((y - 0.5 * x * x).abs());
            drift = drift.max((system.energy(state.time, &state.q, &state.v) / energy - 1.0).abs());
            hash.add("q", &state.q);
            hash.add("v", &state.v);
        }
        let largest = |of: fn(&Sample) -> f64| samples.iter().map(|s| of(s).abs()).fold(0.0, f64::max);
        let mut outcome = Outcome::default()
            .error("position", position / largest(|sample| sample.x))
            .error("reaction", reaction / largest(|sample| sample.lam))
            .error("constraint", constraint)
            .error("energy", drift)
            .state(hash.value());
        outcome.simulated_seconds = times.last().copied();
        Ok(counted(outcome, &report))
    }
}
