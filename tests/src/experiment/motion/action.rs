//! Stationary action of an oscillator between two end points: a minimum up to half a period, a saddle beyond.

use super::unknown_method;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Finite, Positive};
use lagrangian::EulerLagrange;
use lagrangian::action::{Action, Galerkin, Search};
use lagrangian::systems::MassOnSpring;
use mechanics_core::state::StateHash;
use schemars::JsonSchema;
use serde::Deserialize;

/// The path of a mass on a spring between two end points; the ladder is the length of an interval (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StationaryAction {
    /// The mass.
    mass_kg: Positive,
    /// The frequency.
    frequency_rad_per_s: Positive,
    /// Where the path begins.
    start_m: Finite,
    /// Where it ends.
    end_m: Finite,
    /// How long it takes.
    duration_s: Positive,
}

impl Experiment for StationaryAction {
    fn methods(&self) -> &'static [&'static str] {
        &["midpoint", "galerkin-2", "galerkin-3"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let rule = match at.method {
            "midpoint" => Galerkin::MIDPOINT,
            "galerkin-2" => Galerkin { degree: 2 },
            "galerkin-3" => Galerkin { degree: 3 },
            other => return Err(unknown_method(other)),
        };
        let (mass, omega) = (self.mass_kg.value(), self.frequency_rad_per_s.value());
        let oscillator = MassOnSpring::new(mass, mass * omega * omega).map_err(ExperimentError::stopped)?;
        let system = EulerLagrange::new(oscillator);
        let (a, b, duration) = (self.start_m.value(), self.end_m.value(), self.duration_s.value());
        let intervals = (duration / at.ladder).round() as usize;
        let action =
            Action::new(&system, 0.0, duration, intervals, rule).map_err(ExperimentError::stopped)?;
        let straight = action.straight(&[a], &[b]);
        let found = clock
            .time(|| action.stationary(&straight, &Search::default()))
            .map_err(ExperimentError::stopped)?;

        // Landau, Lifshitz, Mechanics, 1976, § 43, problem: the action of an oscillator between two points.
        let (sine, cosine) = (omega * duration).sin_cos();
        let exact = mass * omega / (2.0 * sine) * ((a * a + b * b) * cosine - 2.0 * a * b);
        let path = |t: f64| (a * (omega * (duration - t)).sin() + b * (omega * t).sin()) / sine;
        let worst = found.path.joints().map(|(t, q)| (q[0] - path(t)).abs()).fold(0.0, f64::max);
        let amplitude = a.abs().max(b.abs()) / sine.abs();
        let mut hash = StateHash::new();
        for (_, q) in found.path.joints() {
            hash.add("q", q);
        }
        Ok(Outcome::default()
            .error("action", (found.action / exact - 1.0).abs())
            .error("path", worst / amplitude)
            .count("intervals", intervals as u64)
            .count("iterations", u64::from(found.iterations))
            .invariant("Morse index", found.inertia.negative as f64)
            .state(hash.value()))
    }
}
