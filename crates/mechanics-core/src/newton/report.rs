//! What was done.

use crate::objective::DirectionReport;
use std::time::{Duration, Instant};

/// What a minimisation did: integers that repeat exactly, and times apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NewtonReport {
    /// Steps made.
    pub iterations: u64,
    /// Times a step was halved.
    pub halvings: u64,
    /// Steps that [`limit_step`](crate::objective::Objective::limit_step) shortened.
    pub limited_steps: u64,
    /// Steps accepted by their slope, because their values differed by rounding only.
    pub accepted_by_slope: u64,
    /// 1 if the minimisation ended because its gradient is rounding, though the step norm is not below the tolerance.
    pub at_rounding: u64,
    /// Directions shorter than the tolerance that were gone because the objective was not settled.
    pub unsettled: u64,
    /// Evaluations of the value.
    pub values: u64,
    /// Evaluations of the gradient.
    pub gradients: u64,
    /// Directions found, each from one Hessian.
    pub directions: u64,
    /// Factorisations of a matrix or a preconditioner.
    pub factorisations: u64,
    /// Iterations of the linear solver.
    pub linear_iterations: u64,
    /// Diagonal shifts tried on matrices that were not positive definite.
    pub shifts: u64,
    /// Times that freezing changed the energy.
    pub changes: u64,
    /// Where the time went.
    pub times: NewtonTimes,
}

/// Where the time of a minimisation went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NewtonTimes {
    /// Evaluating values.
    pub value: Duration,
    /// Evaluating gradients.
    pub gradient: Duration,
    /// Assembling Hessians.
    pub assembly: Duration,
    /// Solving linear systems.
    pub solve: Duration,
    /// Limiting steps.
    pub limit_step: Duration,
    /// Freezing.
    pub freeze: Duration,
}

impl NewtonReport {
    pub(super) fn add_direction(&mut self, direction: &DirectionReport) {
        self.directions += 1;
        self.factorisations += direction.factorisations;
        self.linear_iterations += direction.linear_iterations;
        self.shifts += direction.shifts;
        self.times.assembly += direction.assembly_time;
        self.times.solve += direction.solve_time;
    }
}

/// Where a minimisation stands, before its next step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Steps made so far.
    pub iteration: u32,
    /// The value now.
    pub value: f64,
    /// ‖g‖₂ now.
    pub gradient_norm: f64,
    /// The step norm of the direction found.
    pub step_norm: f64,
    /// gᵀp.
    pub slope: f64,
    /// The part of the last direction that was gone; zero before the first step.
    pub fraction: f64,
}

/// What an observer answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proceed {
    /// Go on.
    Continue,
    /// Stop; the minimisation ends with an error and leaves its start as it was.
    Cancel,
}

pub(super) fn timed<R>(total: &mut Duration, work: impl FnOnce() -> R) -> R {
    let begin = Instant::now();
    let result = work();
    *total += begin.elapsed();
    result
}
