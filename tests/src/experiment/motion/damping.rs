//! What a step does to an oscillation, against the closed forms.

use super::{methods, unknown_method};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use lagrangian::integrator::drive;
use lagrangian::systems::MassOnSpring;
use lagrangian::{EulerLagrange, Phase};
use mechanics_core::state::StateHash;
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::ControlFlow;

/// The amplitude that a step leaves of an oscillation of frequency ω; the ladder is z = ω h.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Damping {}

/// Steps until the second root of a two-step method has died out: it falls by at least two thirds a step.
const STEPS: u64 = 60;

impl Experiment for Damping {
    fn methods(&self) -> &'static [&'static str] {
        methods::FIXED_STEP
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let z = at.ladder;
        let expected = amplitude(at.method, z).ok_or_else(|| unknown_method(at.method))?;
        let oscillator = MassOnSpring::new(1.0, 1.0).map_err(ExperimentError::stopped)?;
        let system = EulerLagrange::new(oscillator);
        let mut integrator = methods::fixed_step(&system, at.method)?;
        let mut phase = Phase::new(0.0, [1.0], [0.0]);
        let mut states = Vec::new();
        clock
            .time(|| {
                drive::advance(&system, integrator.as_mut(), &mut phase, z, STEPS, |phase, _| {
                    states.push([phase.q[0], phase.v[0]]);
                    ControlFlow::Continue(())
                })
            })
            .map_err(ExperimentError::stopped)?;
        let found = determinant(&states).sqrt();
        let mut hash = StateHash::new();
        hash.add("amplitude", &[found]);
        Ok(Outcome::default()
            .error("amplitude a step", (found / expected - 1.0).abs())
            .error("amplitude lost a step", (1.0 - found).abs())
            .count("steps", STEPS)
            .state(hash.value()))
    }
}

/// The determinant of the linear map that takes each of the last states to the next: from three states uₙ in the plane,
/// det [uₙ₊₁ uₙ₊₂] / det [uₙ uₙ₊₁].
fn determinant(states: &[[f64; 2]]) -> f64 {
    let area = |i: usize| states[i][0] * states[i + 1][1] - states[i][1] * states[i + 1][0];
    let last = states.len() - 1;
    area(last - 1) / area(last - 2)
}

/// |R(i z)|: the modulus of the stability function on the imaginary axis.
///
/// Reference: Hairer, Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., 1996, sections IV.2, IV.3 and, for
/// the root ζ of (3/2 − i z) ζ² − 2ζ + ½ = 0, V.1.
fn amplitude(method: &str, z: f64) -> Option<f64> {
    match method {
        "implicit-euler" => Some(1.0 / z.hypot(1.0)),
        "bdf2" => {
            // ζ = (2 + √(1 + 2iz)) / (3 − 2iz)
            let root = (1.0_f64).hypot(2.0 * z);
            let (real, imaginary) = (((root + 1.0) / 2.0).sqrt(), ((root - 1.0) / 2.0).sqrt());
            Some((2.0 + real).hypot(imaginary) / (3.0_f64).hypot(2.0 * z))
        }
        "rk4" => Some((1.0 - z.powi(2) / 2.0 + z.powi(4) / 24.0).hypot(z - z.powi(3) / 6.0)),
        "verlet" | "midpoint" | "trapezoidal" => Some(1.0),
        _ if method.starts_with("gauss-legendre") => Some(1.0),
        _ => None,
    }
}
