//! Fluids: pressure against volume, and Newton's viscosity.

use super::drive::{Course, Largest, STATIONS, specimens, stress_hash};
use super::{pressure, stretched};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Chart, Curve};
use crate::scene::quantity::{Count, Positive};
use mechanics_core::tensor::Mat3;
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::{Viscosity, Viscous};
use schemars::JsonSchema;
use serde::Deserialize;

/// Tait's and Newton's fluid; the ladder is the part of the path that a step covers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FluidPoint {
    /// K.
    bulk_modulus_pa: Positive,
    /// γ.
    exponent: Positive,
    /// η.
    shear_viscosity_pa_s: Positive,
    /// The largest compression, −ln J.
    compression: Positive,
    /// The same of a fluid that is hardly compressed.
    slight_compression: Positive,
    /// How long it is compressed to that, or sheared by one.
    duration_s: Positive,
    /// How many points, of which the last goes farthest.
    points: Count,
}

impl Experiment for FluidPoint {
    fn methods(&self) -> &'static [&'static str] {
        &[
            "compressed, f64",
            "compressed, f32",
            "slightly, f64",
            "slightly, f32",
            "sheared, f64",
            "sheared, f32",
        ]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (bulk, exponent) = (self.bulk_modulus_pa.value(), self.exponent.value());
        let viscosity = self.shear_viscosity_pa_s.value();
        let tait = Tait::new(bulk, exponent, Tension::Carried).map_err(ExperimentError::stopped)?;
        let newton = Viscosity::new(viscosity, 0.0).map_err(ExperimentError::stopped)?;
        let largest = match at.method.split(',').next() {
            Some("compressed") => self.compression.value(),
            Some("slightly") => self.slight_compression.value(),
            _ => 0.0,
        };
        let shears = largest == 0.0;
        let course = Course::new(self.points.value(), at.ladder, self.duration_s.value());
        let mut specimens = if shears {
            specimens(Viscous::new(tait, newton), at.method, course.points)
        } else {
            specimens(tait, at.method, course.points)
        };
        let part = |point: usize| (point + 1) as f64 / course.points as f64;
        let (mut error, mut line, mut found) = (Largest::default(), Vec::new(), Vec::new());
        course.run(
            specimens.as_mut(),
            clock,
            |point, k| {
                let way = part(point) * k as f64 / course.total() as f64;
                let mut f = stretched([-largest * way / 3.0; 3]);
                f[(0, 1)] = if shears { way } else { 0.0 };
                f
            },
            |station, point, stress, _| {
                let way = part(point) * station as f64 / STATIONS as f64;
                let log = -largest * way;
                let exact = if shears {
                    viscosity * part(point) / course.duration
                } else {
                    // −τ/J
                    bulk / exponent * (-exponent * log).exp_m1()
                };
                let value = if shears { stress[(0, 1)] } else { pressure(stress) / log.exp() };
                let rest = if shears { deviator_without(stress) } else { 0.0 };
                error.take((value - exact).hypot(rest) / exact);
                if point + 1 == course.points {
                    line.push([if shears { way } else { log }, exact]);
                    found.push([if shears { way } else { log }, value]);
                }
            },
        );
        let chart = Chart {
            title: format!("{}: {} steps", at.method, course.total()),
            x: if shears { "shear" } else { "logarithm of the volume" }.to_owned(),
            y: if shears { "shear stress [Pa]" } else { "pressure [Pa]" }.to_owned(),
            curves: vec![Curve::line("exact", line), Curve::dots("computed", found)],
        };
        let mut outcome = Outcome::default()
            .error("stress", error.0)
            .count("point updates", course.updates())
            .state(stress_hash(specimens.as_ref(), course.points));
        outcome = outcome.charted(at, "the point that goes farthest", &chart)?;
        Ok(outcome)
    }
}

/// What simple shear must not cause: every entry but those of the shear.
fn deviator_without(stress: &Mat3) -> f64 {
    let mut rest = *stress;
    rest[(0, 1)] = 0.0;
    rest[(1, 0)] -= stress[(0, 1)];
    rest.norm()
}
