//! What a step of the nodal schemes does to an oscillation and to free fall, against the closed forms.

use super::schemes::{Mover, SCHEMES, Scheme};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use lagrangian::element::{DeadLoad, Mass, Springs};
use lagrangian::stepper::{ExplicitScheme, TimeScheme};
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A mass on a spring element, and the same mass in free fall; the ladder is z = ω h with ω = 1.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NodalDamping {}

/// Steps in free fall.
const STEPS: i32 = 60;
/// Steps until the second root of BDF2 has died out against the first, by a third a step; few enough that backward Euler
/// leaves something to measure.
const SWINGS: i32 = 30;
/// Rest length of the spring (m): long, so that the mass never passes the other end.
const LENGTH: f64 = 2.0;
/// Newton's (m/s). Both problems are quadratic along the line of motion: the first iteration is exact but for rounding.
const TOLERANCE: f64 = 1e-9;
/// [m/s²]
const GRAVITY: f64 = 9.81;

impl Experiment for NodalDamping {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let scheme = Scheme::named(at.method)?;
        let h = at.ladder;
        let found = clock.time(|| oscillation(scheme, h))?;
        let expected = amplitude(scheme, h);
        let (mover, fallen) = clock.time(|| fall(scheme, h))?;
        let t = h * f64::from(STEPS);
        let exact = 0.5 * GRAVITY * t * t + offset(scheme, h);
        let position = (-fallen.position[0].z / exact - 1.0).abs();
        let velocity = (-fallen.velocity[0].z / (GRAVITY * t) - 1.0).abs();
        let gap = (found / expected - 1.0).abs();
        let outcome = Outcome::default()
            .invariant("gaps of amplitude and fall", gap.max(position).max(velocity))
            .error("amplitude a step", gap)
            .error("amplitude lost a step", (1.0 - found).abs())
            .error("free fall", position.max(velocity));
        Ok(mover.counted(outcome, &fallen, clock))
    }
}

/// √ of the determinant of the map of a step: from three states uₙ in the plane, det [uₙ₊₁ uₙ₊₂] / det [uₙ uₙ₊₁].
fn oscillation(scheme: Scheme, h: f64) -> Result<f64, ExperimentError> {
    let points = vec![Vec3::zeros(), Vec3::x() * LENGTH];
    let mut spring = Springs::term("spring", 1.0, &points, vec![[0, 1]]).map_err(ExperimentError::stopped)?;
    let mut mass = Mass::zeros(2);
    mass.add_point(1, 1.0).map_err(ExperimentError::stopped)?;
    let map = PointMap::with_fixed(2, &[(0, points[0])]).map_err(ExperimentError::stopped)?;
    let mut mover = Mover::new(scheme, mass, map, TOLERANCE)?;
    let mut state = State::at_rest(points);
    state.position[1].x += 1.0;
    let mut states = Vec::new();
    for _ in 0..SWINGS {
        mover.step(&mut state, &mut [&mut spring], h)?;
        states.push([state.position[1].x - LENGTH, state.velocity[1].x]);
    }
    let area = |i: usize| states[i][0] * states[i + 1][1] - states[i][1] * states[i + 1][0];
    let last = states.len() - 1;
    Ok((area(last - 1) / area(last - 2)).sqrt())
}

fn fall(scheme: Scheme, h: f64) -> Result<(Mover, State), ExperimentError> {
    let mut mass = Mass::zeros(1);
    mass.add_point(0, 0.3).map_err(ExperimentError::stopped)?;
    let mut gravity =
        DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -GRAVITY)).map_err(ExperimentError::stopped)?;
    let mut mover = Mover::new(scheme, mass, PointMap::identity(1), TOLERANCE)?;
    let mut state = State::at_rest(vec![Vec3::zeros()]);
    for _ in 0..STEPS {
        mover.step(&mut state, &mut [&mut gravity], h)?;
    }
    Ok((mover, state))
}

/// |ζ| of the principal root on the imaginary axis.
///
/// Reference: Hairer, Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., 1996, section IV.3 and, for the root
/// of (3/2 − i z) ζ² − 2ζ + ½ = 0, V.1. The explicit schemes are symplectic: their map has determinant 1.
fn amplitude(scheme: Scheme, z: f64) -> f64 {
    match scheme {
        Scheme::Implicit(TimeScheme::BackwardEuler) => 1.0 / z.hypot(1.0),
        Scheme::Implicit(TimeScheme::Bdf2) => {
            // ζ = (2 + √(1 + 2iz)) / (3 − 2iz)
            let root = 1.0_f64.hypot(2.0 * z);
            let (real, imaginary) = (((root + 1.0) / 2.0).sqrt(), ((root - 1.0) / 2.0).sqrt());
            (2.0 + real).hypot(imaginary) / 3.0_f64.hypot(2.0 * z)
        }
        Scheme::Implicit(TimeScheme::Newmark | TimeScheme::ImplicitMidpoint) | Scheme::Explicit(_) => 1.0,
    }
}

/// How much farther than ½gt² a body falls. The first-order schemes move with the velocity at the end of a step: ½ght.
/// BDF2 is exact on parabolas, so the error ½gh² of its first step, one of backward Euler, follows
/// e₊ = (4e − e₋)/3, which gives ¾gh²(1 − 3⁻ⁿ).
fn offset(scheme: Scheme, h: f64) -> f64 {
    match scheme {
        Scheme::Implicit(TimeScheme::BackwardEuler) | Scheme::Explicit(ExplicitScheme::SymplecticEuler) => {
            0.5 * GRAVITY * h * h * f64::from(STEPS)
        }
        Scheme::Implicit(TimeScheme::Bdf2) => 0.75 * GRAVITY * h * h * (1.0 - 3.0_f64.powi(-STEPS)),
        Scheme::Implicit(TimeScheme::Newmark | TimeScheme::ImplicitMidpoint)
        | Scheme::Explicit(ExplicitScheme::CentralDifferences) => 0.0,
    }
}
