//! What Newton's method minimises: a function of flat unknowns that can answer with a descent direction.
//!
//! A pendulum in generalised coordinates is a [`DenseObjective`]; a table cloth in contact is an
//! [`IncrementalPotential`], the sum of [`Potential`](crate::potential::Potential) terms over points seen through a
//! [`PointMap`](crate::point_map::PointMap). The minimiser ([`crate::newton`]) knows neither.

mod dense;
mod direction_solver;
mod incremental;
#[cfg(feature = "solvers")]
mod sparse_direction;

pub use dense::{DenseObjective, DenseProblem};
pub use direction_solver::{DenseCholesky, DirectionSolver, Indefinite, SolverError};
pub use incremental::{IncrementalPotential, Projecting, TermTimes, TimeStep};

use crate::potential::{Changed, PotentialError};
use crate::stage::Coefficients;
use std::error::Error;
use std::fmt;
use std::time::Duration;

/// A function of `dimension()` unknowns to be minimised, and how to descend on it.
///
/// Values are joules where unknowns are metres. `value` may be `+∞` outside the domain; NaN is treated the same way
/// during a line search, and as an error at a start.
pub trait Objective {
    /// The number of unknowns.
    fn dimension(&self) -> usize;

    /// The value at `x`.
    fn value(&mut self, x: &[f64]) -> f64;

    /// Overwrites `gradient` with the gradient at `x`.
    fn gradient_into(&mut self, x: &[f64], gradient: &mut [f64]);

    /// Overwrites `direction` with a descent direction at `x`, where the gradient is `gradient`: Newton's
    /// `−H⁻¹ g`, up to the accuracy asked for.
    ///
    /// # Errors
    /// If none could be found; the direction is then unspecified.
    fn direction_into(
        &mut self,
        x: &[f64],
        gradient: &[f64],
        accuracy: DirectionAccuracy,
        direction: &mut [f64],
    ) -> Result<DirectionReport, ObjectiveError>;

    /// Called before every iteration; answers whether the function changed at the same `x`.
    ///
    /// # Errors
    /// If `x` is not admissible.
    fn freeze(&mut self, x: &[f64]) -> Result<Changed, ObjectiveError> {
        let _ = x;
        Ok(Changed::Nothing)
    }

    /// The admissible part of the step `p` from `x`; every later `value(x + α p)` up to it is a pure function.
    ///
    /// # Errors
    /// If `x` is not admissible.
    fn limit_step(&mut self, x: &[f64], p: &[f64]) -> Result<Limit, ObjectiveError> {
        let _ = (x, p);
        Ok(Limit::default())
    }

    /// The size of a step, which convergence is measured with; the largest `|pᵢ|` unless overridden.
    fn step_norm(&self, p: &[f64]) -> f64 {
        largest(p)
    }

    /// Whether a minimisation may end at `x` though its last direction is `p`. Asked only where the step norm of `p` is below the
    /// tolerance; on a no the step is made.
    fn is_settled(&mut self, x: &[f64], p: &[f64]) -> bool {
        let _ = (x, p);
        true
    }

    /// How far the last `value` may be wrong by rounding; differences below are noise. Unless overridden,
    /// 64 ε |value|.
    fn rounding(&self, value: f64) -> f64 {
        64.0 * f64::EPSILON * value.abs()
    }

    /// Where the step `p` is largest, for messages.
    fn locate(&mut self, x: &[f64], p: &[f64]) -> Location {
        let _ = (x, p);
        Location::default()
    }

    /// What makes the value or a derivative at `x` infinite or NaN, for messages.
    fn diagnose(&mut self, x: &[f64]) -> Option<ObjectiveError> {
        let _ = x;
        None
    }
}

/// The largest magnitude in `p`; NaN if there is one.
pub(crate) fn largest(p: &[f64]) -> f64 {
    p.iter().fold(0.0, |m: f64, p| if p.abs() <= m { m } else { p.abs() + 0.0 * m })
}

/// How accurately a direction is to be found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DirectionAccuracy {
    /// As well as the solver does by itself.
    #[default]
    Full,
    /// As [`DirectionAccuracy::Full`], and shortened no more than need be: for a direction whose length decides whether the minimum is reached.
    Decisive,
    /// Until ‖g + H p‖ ≤ η ‖g‖, with this η in (0, 1).
    Relative(f64),
}

/// What finding a direction took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectionReport {
    /// Factorisations (of the matrix or of a preconditioner), failed ones included.
    pub factorisations: u64,
    /// Iterations of a linear solver, or refinement steps of a direct one.
    pub linear_iterations: u64,
    /// Diagonal shifts that had to be tried because the matrix was not positive definite.
    pub shifts: u64,
    /// The shift that the direction was found with, relative to the diagonal; zero if there was no need.
    pub shift: f64,
    /// Time to assemble the matrix.
    pub assembly_time: Duration,
    /// Time to factor and solve.
    pub solve_time: Duration,
}

/// The admissible part of a step, and who limits it.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// The part, in [0, 1].
    pub fraction: f64,
    /// Who limits it.
    pub location: Location,
}

impl Default for Limit {
    fn default() -> Self {
        Self { fraction: 1.0, location: Location::default() }
    }
}

/// A place in a model, as far as it is known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Location {
    /// The name of the term.
    pub term: Option<String>,
    /// The element of the term.
    pub element: Option<usize>,
    /// The point.
    pub point: Option<usize>,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let term = self.term.iter().map(|term| format!("term \"{term}\""));
        let element = self.element.iter().map(|element| format!("element {element}"));
        let point = self.point.iter().map(|point| format!("point {point}"));
        let parts: Vec<String> = term.chain(element).chain(point).collect();
        f.write_str(if parts.is_empty() { "unknown place" } else { "" })?;
        f.write_str(&parts.join(", "))
    }
}

/// Why an objective cannot answer.
#[derive(Debug, thiserror::Error)]
pub enum ObjectiveError {
    /// A term cannot.
    #[error(transparent)]
    Potential(#[from] PotentialError),
    /// The coefficients of the time step's scheme make no step norm.
    #[error(
        "the scheme's factors of inertia ({}) and velocity ({}) must be finite, the first not negative, the second \
         positive; is the step size?", .0.inertia, .0.velocity
    )]
    Coefficients(Coefficients),
    /// The Hessian is not positive definite, even with the largest diagonal shift tried.
    #[error(
        "the Hessian is not positive definite at {location}, even with {shift:e} of its diagonal added; project the \
         terms' Hessians, or fix the points that nothing holds"
    )]
    Indefinite {
        /// Where the factorisation broke down.
        location: Location,
        /// The largest shift tried, relative to the diagonal.
        shift: f64,
    },
    /// A function value or derivative is infinite or NaN.
    #[error("entry {index} of the {what} is {value}")]
    NonFinite {
        /// Of what.
        what: crate::potential::Quantity,
        /// Its first offending entry.
        index: usize,
        /// That entry.
        value: f64,
    },
    /// The linear solver failed for another reason.
    #[error("the linear system of a Newton step was not solved: {0}")]
    Solver(#[source] Box<dyn Error + Send + Sync>),
}
