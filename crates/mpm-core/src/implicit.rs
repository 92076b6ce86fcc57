//! Implicit steps: backward Euler as the minimum of an incremental potential over the nodes.

mod cloud;
mod conjugate_gradient;
mod constraints;
mod law;
mod nodes;
mod preconditioner;
mod problem;

pub(crate) use law::StepLaw;
pub(crate) use nodes::Nodes;

use crate::Grid;
use crate::body::{Body, StepSettings};
use crate::boundary::{Boundary, PrescribedVelocity};
use cloud::Cloud;
use constraints::{Constraints, Sources};
use mechanics_core::lanes::Element;
use mechanics_core::newton::{Forcing, NewtonCause, NewtonError, NewtonOptions, minimise};
use mechanics_core::objective::{Location, Objective, ObjectiveError};
use problem::Problem;

/// How accurately Newton's directions are solved on the way.
const FORCING: Forcing = Forcing::EisenstatWalker { first: 0.1, largest: 0.1 };

/// Solves until the inequalities of boundaries agree.
const MOST_ROUNDS: u64 = 60;

/// How an implicit step is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImplicitStep {
    /// Newton's last step, as a part of the speed that matters: the largest velocity before stress or of Newton's first step, but no more
    /// than one cell a step.
    pub tolerance: f64,
    /// Newton iterations after which not having converged is an error.
    pub max_iterations: u32,
}

impl Default for ImplicitStep {
    /// 1e-6, 100 iterations.
    fn default() -> Self {
        Self { tolerance: 1e-6, max_iterations: 100 }
    }
}

/// What an implicit step did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImplicitReport {
    /// As of an explicit step.
    pub step: crate::StepReport,
    /// Newton iterations.
    pub iterations: u64,
    /// Halvings of the line search.
    pub halvings: u64,
    /// Products of the Hessian and a vector.
    pub products: u64,
    /// Solves until the inequalities of boundaries agreed.
    pub rounds: u64,
    /// Unknown velocities.
    pub unknowns: u64,
    /// Time of all products \[s\].
    pub product_time: f64,
}

/// Why an implicit step was not made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImplicitError {
    /// The tolerance is out of range.
    #[error("the tolerance of an implicit step must be positive and finite, not {value}")]
    Tolerance {
        /// Its value.
        value: f64,
    },
    /// No start of the iteration leaves every particle admissible.
    #[error(
        "particle {particle} of body {body} would change its volume by the factor {ratio} before the first iteration: boundaries or prescribed \
         velocities turn it inside out; take a shorter step"
    )]
    Start {
        /// The body's number.
        body: usize,
        /// The particle's number within it.
        particle: usize,
        /// det(I + h∇v).
        ratio: f64,
    },
    /// The potential is not finite though every particle's energy is.
    #[error("the incremental potential is not finite: velocities or the step are too large")]
    Infinite,
    /// Newton's method did not converge.
    #[error(
        "no convergence after {iterations} Newton iterations: the last step was {reached:e} of the speed that matters, {wanted:e} is wanted; \
         it was largest at the node at {position:?} m"
    )]
    NotConverged {
        /// Iterations made.
        iterations: u32,
        /// The last step, relatively.
        reached: f64,
        /// The tolerance.
        wanted: f64,
        /// The node where the last step was largest \[m\].
        position: Vec<f64>,
    },
    /// No part of Newton's step lowers the potential.
    #[error(
        "the line search failed in iteration {iterations}: {what}; the step is largest at the node at {position:?} m. A shorter time step may help"
    )]
    LineSearch {
        /// Iterations made.
        iterations: u32,
        /// What Newton's method says.
        what: String,
        /// The node where the step was largest \[m\].
        position: Vec<f64>,
    },
    /// The linear system of a Newton step was not solved.
    #[error("a linear system was not solved in {products} products: its residual is {residual:e}, {wanted:e} is wanted")]
    LinearSystem {
        /// Products made.
        products: u64,
        /// The residual, relatively.
        residual: f64,
        /// What was wanted.
        wanted: f64,
    },
    /// Boundaries did not agree on which nodes they hold.
    #[error("after {rounds} rounds {nodes} nodes still change between held and free; take a shorter step")]
    Boundaries {
        /// Rounds made.
        rounds: u64,
        /// Conditions that changed in the last one.
        nodes: usize,
    },
}

/// What acts on nodes in a step.
pub(crate) struct Conditions<'a, const D: usize> {
    pub(crate) prescribed: &'a [PrescribedVelocity<D>],
    pub(crate) boundaries: &'a [Boundary<D>],
    /// Begin and end of the step \[s\].
    pub(crate) begin: f64,
    pub(crate) end: f64,
    /// The velocity that gravity gives in a step \[m/s\].
    pub(crate) gain: [f64; D],
}

/// The nodes with mass of a grid that holds their velocities without stress, and their velocities at the end of the step.
pub(crate) fn solve<E: Element, const D: usize>(
    grid: &Grid<E, D>,
    bodies: &[Body<E, D>],
    settings: StepSettings,
    conditions: &Conditions<'_, D>,
    options: &ImplicitStep,
) -> Result<(Nodes<D>, Vec<f64>, ImplicitReport), ImplicitError> {
    let nodes = Nodes::new(grid, settings.spacing);
    let sources = Sources {
        prescribed: conditions.prescribed,
        boundaries: conditions.boundaries,
        begin: conditions.begin,
        end: conditions.end,
    };
    let constraints = Constraints::new(&sources, &nodes.places, &nodes.forecast);
    run(Problem::new(grid, Cloud::new(bodies, settings), nodes, constraints, settings), conditions, options)
}

/// Rounds of minimisations.
fn run<const D: usize>(
    mut problem: Problem<'_, D>,
    conditions: &Conditions<'_, D>,
    options: &ImplicitStep,
) -> Result<(Nodes<D>, Vec<f64>, ImplicitReport), ImplicitError> {
    let mut x = problem.start(&conditions.gain)?;
    let mut report = ImplicitReport { unknowns: x.len() as u64, ..ImplicitReport::default() };
    let newton = NewtonOptions {
        tolerance: options.tolerance,
        max_iterations: options.max_iterations,
        forcing: FORCING,
        ..NewtonOptions::default()
    };
    loop {
        report.rounds += 1;
        match minimise(&mut problem, &mut x, &newton) {
            Err(error) => return Err(problem_error(*error, &problem.nodes.places, options)),
            Ok(done) => {
                report.iterations += done.iterations;
                report.halvings += done.halvings;
            }
        }
        let changed = problem.revise(&x, options.tolerance);
        if changed == 0 {
            break;
        }
        if report.rounds == MOST_ROUNDS {
            return Err(ImplicitError::Boundaries { rounds: report.rounds, nodes: changed });
        }
        problem.constraints.place(&mut x);
        if !problem.value(&x).is_finite() {
            x = problem.start(&conditions.gain)?;
        }
    }
    report.products = problem.products;
    report.product_time = problem.product_time.as_secs_f64();
    let Problem { nodes, .. } = problem;
    Ok((nodes, x, report))
}

/// The error of a minimisation in the words of this crate.
fn problem_error<const D: usize>(
    error: NewtonError,
    places: &[[f64; D]],
    options: &ImplicitStep,
) -> ImplicitError {
    let NewtonError { cause, progress, .. } = error;
    let iterations = progress.iteration;
    let position = |location: &Location| {
        location.point.and_then(|point| places.get(point)).map_or(Vec::new(), |place| place.to_vec())
    };
    match &cause {
        NewtonCause::NotConverged { location, .. } | NewtonCause::Stagnated { location, .. } => {
            ImplicitError::NotConverged {
                iterations,
                reached: progress.step_norm,
                wanted: options.tolerance,
                position: position(location),
            }
        }
        NewtonCause::Objective(ObjectiveError::Solver(source)) => {
            match source.downcast_ref::<ImplicitError>() {
                Some(error) => error.clone(),
                None => ImplicitError::LineSearch { iterations, what: cause.to_string(), position: Vec::new() },
            }
        }
        NewtonCause::LineSearch { location, .. }
        | NewtonCause::NoFiniteValue { location, .. }
        | NewtonCause::Diverged { location, .. } => {
            ImplicitError::LineSearch { iterations, what: cause.to_string(), position: position(location) }
        }
        _ => ImplicitError::LineSearch { iterations, what: cause.to_string(), position: Vec::new() },
    }
}
