//! Foam, paste and starch: relaxation after a sudden stretch, and steady flow.

use super::drive::{Course, Largest, STATIONS, specimens, stress_hash};
use super::{deviator, stretched};
use crate::experiment::solid::material::lame;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Chart, Curve};
use crate::scene::physics::Isotropic;
use crate::scene::quantity::{Count, Positive};
use mpm_constitutive::plastic::HerschelBulkley;
use schemars::JsonSchema;
use serde::Deserialize;

/// Herschel and Bulkley's law; the ladder is the part of the time that a step covers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FoamPoint {
    constants: Isotropic,
    yield_stress_pa: Positive,
    /// k [Pa sʰ].
    consistency_pa_s_to_index: Positive,
    /// h of the three materials that relax; the first flows too.
    flow_indices: [Positive; 3],
    /// The stress above yield from which the last point relaxes.
    overstress_pa: Positive,
    /// How long it relaxes, or flows.
    duration_s: Positive,
    /// The fastest steady rate of stretch.
    largest_rate_per_s: Positive,
    /// How many points, of which the last begins with most or flows fastest.
    points: Count,
}

impl Experiment for FoamPoint {
    fn methods(&self) -> &'static [&'static str] {
        &[
            "relaxation of the first, f64",
            "relaxation of the first, f32",
            "relaxation of the second, f64",
            "relaxation of the third, f64",
            "steady flow, f64",
            "steady flow, f32",
        ]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let flows = at.method.starts_with("steady");
        let index = match at.method {
            method if method.contains("second") => self.flow_indices[1],
            method if method.contains("third") => self.flow_indices[2],
            _ => self.flow_indices[0],
        }
        .value();
        let lame = lame(&self.constants).map_err(ExperimentError::stopped)?;
        let (yields, k) = (self.yield_stress_pa.value(), self.consistency_pa_s_to_index.value());
        let law = HerschelBulkley::new(lame, yields, k, index).map_err(ExperimentError::stopped)?;
        let stiffness = 3.0 * lame.mu();
        let course = Course::new(self.points.value(), at.ladder, self.duration_s.value());
        let mut specimens = specimens(law, at.method, course.points);
        let (mut error, mut line, mut found) = (Largest::default(), Vec::new(), Vec::new());
        course.run(
            specimens.as_mut(),
            clock,
            |point, step| {
                let time = course.duration * step as f64 / course.total() as f64;
                let strain = if flows {
                    self.rate(point) * time
                } else {
                    (yields + self.overstress(point)) / stiffness
                };
                stretched([strain, -0.5 * strain, -0.5 * strain])
            },
            |station, point, stress, _| {
                let time = course.duration * station as f64 / STATIONS as f64;
                let q = 1.5_f64.sqrt() * deviator(stress).norm();
                let exact = if flows {
                    yields + k * self.rate(point).powf(index)
                } else {
                    yields + relaxed(self.overstress(point), stiffness, [k, index], time)
                };
                // Flow is steady at the last station.
                if !flows || station == STATIONS {
                    error.take((q - exact) / self.overstress_pa.value());
                }
                if flows && station == STATIONS {
                    line.push([self.rate(point), 1e-3 * exact]);
                    found.push([self.rate(point), 1e-3 * q]);
                } else if !flows && point + 1 == course.points {
                    line.push([1e3 * time, 1e-3 * exact]);
                    found.push([1e3 * time, 1e-3 * q]);
                }
            },
        );
        let chart = Chart {
            title: format!("{}: h = {index}, {} steps", at.method, course.total()),
            x: if flows { "rate [1/s]" } else { "time [ms]" }.to_owned(),
            y: "equivalent stress [kPa]".to_owned(),
            curves: vec![Curve::line("exact", line), Curve::dots("computed", found)],
        };
        let mut outcome = Outcome::default()
            .error("stress", error.0)
            .count("point updates", course.updates())
            .state(stress_hash(specimens.as_ref(), course.points));
        outcome = outcome.charted(at, "stress against time or rate", &chart)?;
        Ok(outcome)
    }
}

impl FoamPoint {
    fn part(&self, point: usize) -> f64 {
        (point + 1) as f64 / self.points.value() as f64
    }

    fn overstress(&self, point: usize) -> f64 {
        self.overstress_pa.value() * (0.2 + 0.8 * self.part(point))
    }

    fn rate(&self, point: usize) -> f64 {
        self.largest_rate_per_s.value() * (0.2 + 0.8 * self.part(point))
    }
}

/// o(t) of o′ = −3μ (o/k)^(1/h): with m = 1/h, o^(1−m) falls or grows linearly in time; o = 0 once it is reached.
fn relaxed(start: f64, stiffness: f64, [k, index]: [f64; 2], time: f64) -> f64 {
    let m = 1.0 / index;
    if m == 1.0 {
        return start * (-stiffness / k * time).exp();
    }
    let power = start.powf(1.0 - m) - (1.0 - m) * stiffness * k.powf(-m) * time;
    power.max(0.0).powf(1.0 / (1.0 - m))
}
