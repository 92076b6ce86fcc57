//! Why a minimisation ended without a minimum.

use super::{NewtonReport, OptionsError, Progress};
use crate::objective::{Location, ObjectiveError};

/// A minimisation that failed: why, where it stood, and what it had done.
#[derive(Debug, thiserror::Error)]
#[error(
    "Newton's method stopped in iteration {} (value {:e}, gradient norm {:e}, step norm {:e}): {cause}",
    .progress.iteration, .progress.value, .progress.gradient_norm, .progress.step_norm
)]
pub struct NewtonError {
    /// Why.
    #[source]
    pub cause: NewtonCause,
    /// Where it stood.
    pub progress: Progress,
    /// What it had done.
    pub report: NewtonReport,
}

/// Why a minimisation failed.
#[derive(Debug, thiserror::Error)]
pub enum NewtonCause {
    /// An option is out of range.
    #[error(transparent)]
    Options(#[from] OptionsError),
    /// The start is infinite or NaN.
    #[error("unknown {index} starts at {value}")]
    Start {
        /// The unknown.
        index: usize,
        /// Its start.
        value: f64,
    },
    /// The objective failed.
    #[error(transparent)]
    Objective(#[from] ObjectiveError),
    /// A direction is infinite or NaN.
    #[error("entry {index} of the direction is {value}")]
    Direction {
        /// The entry.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The direction does not descend.
    #[error("the direction does not descend (slope {slope:e}); is the Hessian positive definite?")]
    NotDescending {
        /// gᵀp.
        slope: f64,
    },
    /// The objective limits a step to something that is not a part of it.
    #[error("the step is limited to {fraction}, which is not between 0 and 1, by {location}")]
    StepLimit {
        /// The offending limit.
        fraction: f64,
        /// Who limits it.
        location: Location,
    },
    /// No step along the direction is admissible, or only one too short to move any unknown.
    #[error("no step is admissible: {location} blocks it")]
    Blocked {
        /// Who blocks it.
        location: Location,
    },
    /// However short the step, the value does not fall enough.
    #[error(
        "no step from {largest:e} down to {smallest:e} lowers the value enough: along the direction it changes at \
         the rate {measured:e}, but the gradient says {slope:e}. If these disagree, the gradient is wrong (see \
         check_gradient); if they agree, the tolerance is below what rounding ({rounding:e}) allows. The step is largest \
         at {location}"
    )]
    LineSearch {
        /// The first step tried.
        largest: f64,
        /// The last step tried.
        smallest: f64,
        /// gᵀp.
        slope: f64,
        /// (E(x + αp) − E(x)) / α for the α whose difference is least spoilt by rounding and curvature.
        measured: f64,
        /// How far values may be wrong by rounding.
        rounding: f64,
        /// Where the step is largest.
        location: Location,
    },
    /// However short the step, the value is infinite or NaN.
    #[error(
        "the value is {value} however short the step, though it is finite at the start of it: {}; the step is largest at \
         {location}", .culprit.as_ref().map_or_else(|| "nothing says why".to_owned(), ToString::to_string)
    )]
    NoFiniteValue {
        /// The value at the shortest step.
        value: f64,
        /// What makes it so, if the objective knows.
        #[source]
        culprit: Option<Box<ObjectiveError>>,
        /// Where the step is largest.
        location: Location,
    },
    /// The value falls without bound.
    #[error(
        "the value falls to −∞: nothing bounds the objective from below{}",
        .culprit.as_ref().map_or_else(String::new, |culprit| format!(" ({culprit})"))
    )]
    Unbounded {
        /// What falls, if the objective knows.
        #[source]
        culprit: Option<Box<ObjectiveError>>,
    },
    /// Steps grow without bound.
    #[error("steps grow without bound (the first one had norm {first:e}), most at {location}")]
    Diverged {
        /// The first step norm.
        first: f64,
        /// Where the step is largest.
        location: Location,
    },
    /// The largest number of iterations was reached.
    #[error("not converged to {tolerance:e}; the step is largest at {location}")]
    NotConverged {
        /// The tolerance.
        tolerance: f64,
        /// Where the step is largest.
        location: Location,
    },
    /// Steps no longer shrink, though what they change is lost in the rounding of the value.
    #[error(
        "steps no longer shrink: the shortest has the norm {reached:e}, the tolerance is {tolerance:e}. The value does not resolve \
         them, and the gradient is more than rounding; are directions accurate? The step is largest at {location}"
    )]
    Stagnated {
        /// The tolerance.
        tolerance: f64,
        /// The smallest step norm: what can be reached.
        reached: f64,
        /// Where the step is largest.
        location: Location,
    },
    /// The observer cancelled.
    #[error("cancelled by the observer")]
    Cancelled,
}
