//! Backing away along a direction until the value falls enough; the rule is derived in the parent module.

use super::report::timed;
use super::{NewtonCause, NewtonReport, dot};
use crate::objective::{Location, Objective};

/// c₁ of Armijo's condition.
const ARMIJO: f64 = 1e-4;
/// δ of the condition on slopes.
const SLOPE: f64 = 0.1;
/// σ of the condition on slopes.
const CURVATURE: f64 = 0.9;
/// A fall of this many roundings would show in the values.
const HOPELESS: f64 = 100.0;
/// 2⁻⁵² of a step changes nothing that the step itself would not.
const MAX_HALVINGS: u32 = 52;

pub(super) struct LineSearch<'a> {
    pub(super) x: &'a [f64],
    pub(super) direction: &'a [f64],
    /// The part of the direction that is tried first.
    pub(super) largest: f64,
    /// φ(0).
    pub(super) value: f64,
    /// φ'(0) < 0.
    pub(super) slope: f64,
    /// How far φ may be wrong by rounding.
    pub(super) rounding: f64,
}

/// A trial step.
pub(super) struct Trial {
    pub(super) fraction: f64,
    pub(super) x: Vec<f64>,
    pub(super) value: f64,
    /// The gradient there, if it was needed.
    pub(super) gradient: Option<Vec<f64>>,
}

impl LineSearch<'_> {
    /// Tries the largest step, then half of it, and so on; answers the first that is acceptable.
    pub(super) fn run(
        &self,
        objective: &mut dyn Objective,
        report: &mut NewtonReport,
    ) -> Result<Trial, NewtonCause> {
        let mut trial = self.trial(self.largest);
        let mut measured = Measured::default();
        for halvings in 0..=MAX_HALVINGS {
            if halvings > 0 {
                report.halvings += 1;
                trial.fraction *= 0.5;
                self.move_to(&mut trial);
            }
            trial.value = timed(&mut report.times.value, || objective.value(&trial.x));
            report.values += 1;
            if trial.value == f64::NEG_INFINITY {
                return Err(NewtonCause::Unbounded { culprit: objective.diagnose(&trial.x).map(Box::new) });
            }
            if !trial.value.is_finite() {
                continue;
            }
            if trial.value <= self.value + ARMIJO * trial.fraction * self.slope {
                return Ok(trial);
            }
            let difference = trial.value - self.value;
            if difference.abs() <= self.rounding {
                if self.accept_slope(&mut trial, objective, report) {
                    return Ok(trial);
                }
            } else {
                measured.record(difference, trial.fraction, self.rounding);
            }
        }
        let location = objective.locate(self.x, self.direction);
        if !trial.value.is_finite() {
            let culprit = objective.diagnose(&trial.x).map(Box::new);
            return Err(NewtonCause::NoFiniteValue { value: trial.value, culprit, location });
        }
        Err(self.failure(&trial, &measured, location))
    }

    fn trial(&self, fraction: f64) -> Trial {
        let mut trial = Trial { fraction, x: self.x.to_vec(), value: self.value, gradient: None };
        self.move_to(&mut trial);
        trial
    }

    fn move_to(&self, trial: &mut Trial) {
        for ((trial_x, x), p) in trial.x.iter_mut().zip(self.x).zip(self.direction) {
            *trial_x = x + trial.fraction * p;
        }
    }

    fn accept_slope(
        &self,
        trial: &mut Trial,
        objective: &mut dyn Objective,
        report: &mut NewtonReport,
    ) -> bool {
        let mut gradient = vec![0.0; trial.x.len()];
        timed(&mut report.times.gradient, || objective.gradient_into(&trial.x, &mut gradient));
        report.gradients += 1;
        let slope = dot(&gradient, self.direction);
        let small = self.largest * self.slope.abs() <= HOPELESS * self.rounding;
        let accepted =
            slope <= (2.0 * SLOPE - 1.0) * self.slope && (small || slope >= CURVATURE * self.slope);
        trial.gradient = accepted.then_some(gradient);
        report.accepted_by_slope += u64::from(accepted);
        accepted
    }

    fn failure(&self, trial: &Trial, measured: &Measured, location: Location) -> NewtonCause {
        NewtonCause::LineSearch {
            largest: self.largest,
            smallest: trial.fraction,
            slope: self.slope,
            measured: measured.rate,
            rounding: self.rounding,
            location,
        }
    }
}

/// The rate of change of φ at zero, as well as it can be told from its values.
#[derive(Default)]
struct Measured {
    rate: f64,
}

impl Measured {
    /// Shorter steps come later and have less curvature in them, until rounding takes over.
    fn record(&mut self, difference: f64, fraction: f64, rounding: f64) {
        if difference.abs() > 100.0 * rounding {
            self.rate = difference / fraction;
        }
    }
}
