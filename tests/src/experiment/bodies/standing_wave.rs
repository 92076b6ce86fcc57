//! Free vibration of a fixed–free bar of springs: the schemes against its standing waves.
//!
//! n springs of length Δx = L/n and lumped masses ρΔx, half of that at the free end, have the modes sin(kⱼ X) with
//! kⱼ = (2j − 1)π/2L and the frequencies ωⱼ = (2c/Δx) sin(½ kⱼ Δx). Springs in a line answer exactly linearly to motion along
//! it, so u = Σ aⱼ sin(kⱼ X) cos(ωⱼ t) is the solution for any amplitude, and the whole error is that of the time scheme.
//!
//! Reference: K. F. Graff, *Wave Motion in Elastic Solids*, 1975, section 2.3 for the bar; the discrete frequencies follow by
//! inserting the mode.

use super::schemes::{Mover, SCHEMES, Scheme};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Finite, Positive};
use lagrangian::element::{Mass, Springs};
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::FRAC_PI_2;

/// A bar of length 1 m and wave speed 1 m/s; the ladder is the step h (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StandingWave {
    /// Springs.
    springs: Count,
    /// Amplitudes of the first modes (m).
    amplitudes_m: Vec<Finite>,
    /// Time to go to (s).
    duration_s: Positive,
}

impl Experiment for StandingWave {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let n = self.springs.value() as u32;
        let dx = 1.0 / f64::from(n);
        let points: Vec<Vec3> = (0..=n).map(|i| Vec3::x() * (f64::from(i) * dx)).collect();
        let edges = (0..n).map(|i| [i, i + 1]).collect();
        let mut springs =
            Springs::term("springs", 1.0 / dx, &points, edges).map_err(ExperimentError::stopped)?;
        let mut mass = Mass::zeros(points.len());
        for i in 1..=n {
            let share = if i == n { 0.5 * dx } else { dx };
            mass.add_point(i, share).map_err(ExperimentError::stopped)?;
        }
        let map = PointMap::with_fixed(points.len(), &[(0, points[0])]).map_err(ExperimentError::stopped)?;
        let mut mover = Mover::new(Scheme::named(at.method)?, mass, map, 1e-10)?;
        let mut state = State::at_rest(points.iter().map(|x| x + self.displacement(x.x, 0.0)).collect());
        let steps = (self.duration_s.value() / at.ladder).round() as u64;
        clock.time(|| (0..steps).try_for_each(|_| mover.step(&mut state, &mut [&mut springs], at.ladder)))?;
        let end = at.ladder * steps as f64;
        let exact = points.iter().map(|x| x + self.displacement(x.x, end));
        let error = state.position.iter().zip(exact).map(|(x, exact)| (x - exact).norm()).fold(0.0, f64::max);
        let size: f64 = self.amplitudes_m.iter().map(|a| a.value().abs()).sum();
        Ok(mover.counted(Outcome::default().error("position", error / size), &state, clock))
    }
}

impl StandingWave {
    fn displacement(&self, x: f64, t: f64) -> Vec3 {
        let dx = 1.0 / self.springs.value() as f64;
        let mode = |(j, a): (usize, &Finite)| {
            let k = (2 * j + 1) as f64 * FRAC_PI_2;
            let omega = 2.0 / dx * (0.5 * k * dx).sin();
            a.value() * (k * x).sin() * (omega * t).cos()
        };
        Vec3::x() * self.amplitudes_m.iter().enumerate().map(mode).sum::<f64>()
    }
}
