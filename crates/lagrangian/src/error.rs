//! What can go wrong, and where.

use std::fmt;

/// What a number in an error is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Symbol {
    /// Time t.
    Time,
    /// A generalised coordinate.
    Coordinate,
    /// A generalised velocity.
    Velocity,
    /// A generalised acceleration.
    Acceleration,
    /// A generalised momentum.
    Momentum,
    /// The rate of a generalised momentum without acceleration, D ∂L/∂v.
    MomentumRate,
    /// A slope of the Lagrangian, ∂L/∂q.
    Slope,
    /// An entry of the mass matrix.
    Mass,
    /// A generalised force.
    Force,
    /// A constraint's value or derivative.
    Constraint,
    /// A symmetry's generator or boundary term.
    Generator,
    /// A conserved quantity.
    Invariant,
}

impl fmt::Display for Symbol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Time => "time",
            Self::Coordinate => "coordinate",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Momentum => "momentum",
            Self::MomentumRate => "rate of momentum",
            Self::Slope => "slope of the Lagrangian",
            Self::Mass => "mass matrix entry",
            Self::Force => "generalised force",
            Self::Constraint => "constraint",
            Self::Generator => "generator",
            Self::Invariant => "invariant",
        })
    }
}

/// Which of a constraint's two equations is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConstraintLevel {
    /// φ(q, t) = 0.
    Position,
    /// ∂φ/∂q · v + ∂φ/∂t = 0.
    Velocity,
}

impl fmt::Display for ConstraintLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
        })
    }
}

/// What stops this crate's generalised-coordinate half. The state handed in is then as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LagrangianError {
    /// A number is infinite or NaN.
    #[error("{symbol} {index} is {value} at t = {time} s")]
    NonFinite {
        /// What the number is.
        symbol: Symbol,
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
        /// When \[s\].
        time: f64,
    },
    /// A step size is not a positive number.
    #[error("the step size is {step} s; it must be positive and finite")]
    Step {
        /// The step size \[s\].
        step: f64,
    },
    /// The mass matrix ∂²T/∂v∂v is singular, or not positive definite: motion along `null_direction` costs no
    /// kinetic energy.
    #[error(
        "the mass matrix is singular at t = {time} s: velocity along {null_direction:?} has no positive kinetic \
         energy (pivot {pivot:e})"
    )]
    SingularMass {
        /// When \[s\].
        time: f64,
        /// A velocity of length one along which there is no inertia.
        null_direction: Vec<f64>,
        /// The pivot that broke the factorisation.
        pivot: f64,
    },
    /// The equations of an implicit step were not solved.
    #[error(
        "{method}: the equations of the step from t = {time} s with h = {step} s were not solved in {iterations} \
         iterations: the last correction is {correction:e}, the tolerance {tolerance:e}; a smaller step may help"
    )]
    NotConverged {
        /// The integrator's name.
        method: &'static str,
        /// Start of the step \[s\].
        time: f64,
        /// Step size \[s\].
        step: f64,
        /// Iterations made.
        iterations: u32,
        /// The size of the last correction, relative.
        correction: f64,
        /// What it should have been.
        tolerance: f64,
    },
    /// A splitting method needs T to be free of q.
    #[error(
        "{method} needs a separable Lagrangian, T(v) − V(q, t), without dissipation: {reason}; use discrete \
         Euler–Lagrange or Gauss–Legendre"
    )]
    NotSeparable {
        /// The integrator's name.
        method: &'static str,
        /// What couples to what.
        reason: String,
    },
    /// A parameter of a worked system is out of its range.
    #[error("{system}: the {parameter} is {value}; it must be {requirement}")]
    Parameter {
        /// The system.
        system: &'static str,
        /// The parameter's name, as its field is called.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// An interval of time does not run forwards, or an end is not finite.
    #[error("cannot integrate from t = {start} s to t = {end} s: times must be finite and not decrease")]
    Interval {
        /// Where the motion is \[s\].
        start: f64,
        /// Where it should go \[s\].
        end: f64,
    },
    /// A step does not move the time any more.
    #[error(
        "the step size {step:e} s at t = {time} s is too small to be resolved: the motion may be singular there, or the \
         tolerance below what rounding allows"
    )]
    StepTooSmall {
        /// When \[s\].
        time: f64,
        /// The step size \[s\].
        step: f64,
    },
    /// A tolerance that no step can meet.
    #[error(
        "the tolerance is {relative:e} relative, {absolute:e} absolute: both must be finite and not negative, and one \
         positive"
    )]
    Tolerance {
        /// The relative part.
        relative: f64,
        /// The absolute part.
        absolute: f64,
    },
    /// Step-size control has used up its steps.
    #[error(
        "{limit} steps lead only to t = {time} s of {end} s: the tolerance may be too small, or the motion singular or \
         stiff ahead"
    )]
    TooManySteps {
        /// The limit.
        limit: u64,
        /// How far they lead \[s\].
        time: f64,
        /// Where they should lead \[s\].
        end: f64,
    },
    /// Stability, not accuracy, limits the steps of an explicit method.
    #[error(
        "the motion is stiff at t = {time} s: stability holds the step at {step:e} s; use an implicit method (Gauss–Legendre, \
         implicit Euler, BDF2)"
    )]
    Stiff {
        /// When \[s\].
        time: f64,
        /// The step size \[s\].
        step: f64,
    },
    /// An event's function has no finite value.
    #[error("the function of event {index} is {value} at t = {time} s")]
    Event {
        /// The event's index in the list.
        index: usize,
        /// When \[s\].
        time: f64,
        /// The value.
        value: f64,
    },
    /// A state that an integrator should start from is not on the constraints.
    #[error(
        "constraint {index} is violated by {value:e} at the {level} level at t = {time} s (tolerance {tolerance:e}); \
         `Constrained::project` finds the nearest state that meets all constraints"
    )]
    ConstraintViolated {
        /// Which equation.
        level: ConstraintLevel,
        /// Which constraint.
        index: usize,
        /// φ, or its rate, in the constraint's unit (per second).
        value: f64,
        /// The largest that is let through.
        tolerance: f64,
        /// When \[s\].
        time: f64,
    },
    /// A constraint follows from those before it (or contradicts them): the combination of their gradients with the
    /// coefficients `combination` is zero.
    #[error(
        "constraint {index} is redundant at t = {time} s: the gradients combined with {combination:?} give zero \
         (pivot {pivot:e}); remove it, or move away from the singular position"
    )]
    RedundantConstraint {
        /// The first constraint whose gradient depends on those before it.
        index: usize,
        /// One coefficient per constraint, of length one.
        combination: Vec<f64>,
        /// The pivot of G M⁻¹ Gᵀ that broke the factorisation.
        pivot: f64,
        /// When \[s\].
        time: f64,
    },
    /// A path needs a start before its end, and at least one interval between.
    #[error(
        "no path from t = {start} s to t = {end} s in {intervals} intervals: times must be finite and increase"
    )]
    Span {
        /// The first time \[s\].
        start: f64,
        /// The last time \[s\].
        end: f64,
        /// The number of intervals.
        intervals: usize,
    },
    /// A degree of polynomials is not provided.
    #[error("polynomials of degree {degree}: choose one from 1 to {largest}")]
    Degree {
        /// The degree.
        degree: usize,
        /// The largest one.
        largest: usize,
    },
    /// A force that no potential gives has no action.
    #[error(
        "coordinate {coordinate} is under a force that no potential gives ({force} at t = {time} s): its motion is \
         not a stationary point of ∫ L dt; integrate it from a start instead"
    )]
    NoAction {
        /// The first coordinate with such a force.
        coordinate: usize,
        /// The force Q − ∂R/∂v there.
        force: f64,
        /// When \[s\].
        time: f64,
    },
    /// An end-point problem was not solved.
    #[error(
        "an end-point problem with no solution found: {failure} after {iterations} iterations; the residual |δA| is {residual:e}, \
         where rounding would leave {rounding:e}, and largest at node {node} (t = {time} s); start from a path nearer to the \
         motion, or look for a conjugate point at the end"
    )]
    NoStationaryPath {
        /// How the search ended.
        failure: PathFailure,
        /// Iterations made.
        iterations: u32,
        /// The largest |∂A/∂q| over the nodes.
        residual: f64,
        /// What rounding alone may leave of it.
        rounding: f64,
        /// The node where it is largest.
        node: usize,
        /// When that is \[s\].
        time: f64,
    },
    /// A generator is no symmetry of the Lagrangian.
    #[error(
        "{name} is no symmetry: at t = {time} s, q = {q:?}, v = {v:?} it changes the Lagrangian at the rate {change:e}, where the \
         terms that should cancel are of size {size:e}"
    )]
    NotASymmetry {
        /// The name given to it.
        name: String,
        /// The state where it fails worst: time \[s\].
        time: f64,
        /// The coordinates there.
        q: Vec<f64>,
        /// The velocities there.
        v: Vec<f64>,
        /// δL + ξ·F − dK/dt there.
        change: f64,
        /// The sum of the magnitudes of its terms.
        size: f64,
    },
    /// A trajectory is too short for statistics.
    #[error("{samples} states are too few to tell a drift from an oscillation: give {needed} or more")]
    FewSamples {
        /// How many there are.
        samples: usize,
        /// How many there must be.
        needed: usize,
    },
    /// The times of a trajectory do not increase.
    #[error(
        "the trajectory's times must increase, but state {index} is at t = {time} s after t = {before} s"
    )]
    Unordered {
        /// The first state that is not later than the one before.
        index: usize,
        /// Its time \[s\].
        time: f64,
        /// The time before \[s\].
        before: f64,
    },
}

/// How the search for a stationary path ended without one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathFailure {
    /// Iterations were used up.
    Iterations,
    /// No part of Newton's step comes nearer to a stationary path.
    Stagnation,
    /// The action's Hessian is singular, and no path is stationary: the end is conjugate to the start.
    Conjugate,
}

impl fmt::Display for PathFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Iterations => "not converged",
            Self::Stagnation => "stagnated (no part of Newton's step comes nearer)",
            Self::Conjugate => "singular Hessian (the end is conjugate to the start)",
        })
    }
}
