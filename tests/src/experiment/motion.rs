//! Motion in generalised coordinates: trajectories, long runs, constraints and stationary paths of worked systems,
//! each against a reference outside the code.

mod action;
mod chain;
mod constrained;
mod damping;
mod energy;
mod methods;
mod orbits;
mod picture;
mod reference;
mod rigid_body;
mod trajectory;

pub(super) use action::StationaryAction;
pub(super) use chain::Chain;
pub(super) use constrained::BeadOnWire;
pub(super) use damping::Damping;
pub(super) use energy::LongEnergy;
pub(super) use orbits::Orbits;
pub(super) use rigid_body::RigidBody;
pub(super) use trajectory::Trajectory;

use crate::experiment::{ExperimentError, Outcome};
use lagrangian::integrator::DriveReport;

/// `outcome` with what the steps took.
fn counted(outcome: Outcome, report: &DriveReport) -> Outcome {
    outcome
        .count("steps", report.steps)
        .count("evaluations", report.work.evaluations)
        .count("curvatures", report.work.curvatures)
        .count("iterations", report.work.iterations)
}

/// The largest difference of two arrays.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The largest magnitude.
fn size(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()))
}

/// The method's name is not one of the experiment's; scenes are checked for that before they run.
fn unknown_method(method: &str) -> ExperimentError {
    ExperimentError::Refused {
        key: "validation.methods".to_owned(),
        reason: format!("there is no method `{method}`"),
    }
}
