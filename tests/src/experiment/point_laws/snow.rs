//! Snow: packed, pulled apart and packed again.

use super::drive::{Course, Largest, STATIONS, specimens, stress_hash};
use super::stretched;
use crate::experiment::solid::material::lame;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Chart, Curve};
use crate::scene::physics::Isotropic;
use crate::scene::quantity::{Count, Positive};
use mechanics_core::law::Lame;
use mechanics_core::tensor::Mat3;
use mpm_constitutive::plastic::Snow;
use schemars::JsonSchema;
use serde::Deserialize;

/// Stomakhin's snow; the ladder is the part of the path that a step covers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SnowPoint {
    constants: Isotropic,
    /// θ_c [1].
    critical_compression: Positive,
    /// θ_s [1].
    critical_stretch: Positive,
    /// ξ [1].
    hardening: Positive,
    /// The largest logarithmic compression [1].
    largest_strain: Positive,
    /// How many points, of which the last goes farthest.
    points: Count,
}

/// Strains at the turns of the path, five stations apart, in parts of the largest.
const TURNS: [f64; 6] = [0.0, -0.6, -0.2, 0.1, -1.0, -0.8];

impl Experiment for SnowPoint {
    fn methods(&self) -> &'static [&'static str] {
        &["one axis, f64", "one axis, f32", "three axes, f64", "three axes, f32"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let lame = lame(&self.constants).map_err(ExperimentError::stopped)?;
        let (compression, stretch) = (self.critical_compression.value(), self.critical_stretch.value());
        let law = Snow::new(lame, compression, stretch, self.hardening.value())
            .map_err(ExperimentError::stopped)?;
        let axes = if at.method.starts_with("one") { 1 } else { 3 };
        let course = Course::new(self.points.value(), at.ladder, 1.0);
        let young = self.constants.young_modulus_pa.value();
        // The plastic stretch along a pressed axis.
        let mut plastic = vec![1.0; course.points];
        let mut specimens = specimens(law, at.method, course.points);
        let (mut stress_error, mut volume_error) = (Largest::default(), Largest::default());
        let (mut line, mut found) = (vec![[0.0, 0.0]], vec![[0.0, 0.0]]);
        course.run(
            specimens.as_mut(),
            clock,
            |point, k| pressed(self.strain(k as f64 / course.total() as f64, point), axes),
            |station, point, stress, specimens| {
                let strain = self.strain(station as f64 / STATIONS as f64, point);
                let stretched = strain.exp();
                // Between two stations the way is monotone.
                plastic[point] =
                    f64::clamp(plastic[point], stretched / (1.0 + stretch), stretched / (1.0 - compression));
                let volume = plastic[point].powi(axes);
                let hardness = (self.hardening.value() * (1.0 - volume)).exp();
                let exact = elastic(lame, stretched / plastic[point], axes) * hardness;
                stress_error.take((stress - exact).norm() / young);
                volume_error.take(specimens.history(point, 0) - (volume - 1.0));
                if point + 1 == course.points {
                    line.push([strain, 1e-3 * exact[(0, 0)]]);
                    found.push([strain, 1e-3 * stress[(0, 0)]]);
                }
            },
        );
        let chart = Chart {
            title: format!("{}: {} steps", at.method, course.total()),
            x: "logarithm of the stretch".to_owned(),
            y: "stress along it [kPa]".to_owned(),
            curves: vec![Curve::line("exact, at the stations", line), Curve::dots("computed", found)],
        };
        let mut outcome = Outcome::default()
            .error("stress", stress_error.0)
            .error("plastic volume", volume_error.0)
            .count("point updates", course.updates())
            .state(stress_hash(specimens.as_ref(), course.points));
        outcome = outcome.charted(at, "stress against stretch of the point that goes farthest", &chart)?;
        Ok(outcome)
    }
}

impl SnowPoint {
    fn strain(&self, s: f64, point: usize) -> f64 {
        let x = s * (TURNS.len() - 1) as f64;
        let leg = (x as usize).min(TURNS.len() - 2);
        let part = TURNS[leg] + (x - leg as f64) * (TURNS[leg + 1] - TURNS[leg]);
        part * self.largest_strain.value() * (0.4 + 0.6 * (point + 1) as f64 / self.points.value() as f64)
    }
}

/// The same stretch along the first `axes`.
fn pressed(strain: f64, axes: i32) -> Mat3 {
    stretched(std::array::from_fn(|i| if (i as i32) < axes { strain } else { 0.0 }))
}

/// τᵢ = 2μ σᵢ(σᵢ − 1) + λ J (J − 1) with σ along the first `axes`, 1 along the others.
fn elastic(lame: Lame, sigma: f64, axes: i32) -> Mat3 {
    let j = sigma.powi(axes);
    let stress = |i: usize| {
        let shear = if (i as i32) < axes { 2.0 * lame.mu() * sigma * (sigma - 1.0) } else { 0.0 };
        shear + lame.lambda() * j * (j - 1.0)
    };
    Mat3::from_diagonal(&[stress(0), stress(1), stress(2)].into())
}
