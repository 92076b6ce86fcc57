//! One term of the incremental potential: an energy over points.

use crate::projection::Projection;
use crate::sparse::Assembler;
use crate::stage::Stage;
use crate::tensor::Vec3;
use std::error::Error;

/// A term of the incremental potential `E(x)`, in joules, over points `x` \[m\].
///
/// Elasticity, gravity, inertia, contact barriers and lagged friction are all terms. Most authors write a
/// [`Stencil`](crate::stencil::Stencil) and get the term from [`StencilTerm`](crate::stencil::StencilTerm); the
/// trait itself is for terms with their own element lists, such as contact.
///
/// Contract, relied upon by the minimiser and by the promise of equal bits for any number of threads:
/// - `value`, `add_gradient` and `add_hessian` are pure functions of `x` between two calls of [`freeze`] or
///   [`limit_step`]; sums inside them run in element order.
/// - `add_gradient` and `add_hessian` are the derivatives of `value` (see [`crate::derivatives`]), the latter up to
///   the projection asked for.
/// - `value` may be `+∞` outside the domain (an inverted element, a crossed barrier); a line search backs away. It
///   is never NaN inside the domain.
///
/// [`freeze`]: Self::freeze
/// [`limit_step`]: Self::limit_step
pub trait Potential: Send + Sync {
    /// The term's name in reports and errors.
    fn name(&self) -> &str;

    /// The energy `E(x)` \[J\].
    fn value(&self, x: &[Vec3]) -> f64;

    /// Adds `∂E/∂xᵢ` \[N\] to `gradient[i]`.
    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]);

    /// Adds the gradient at the stage's points \[N\] with what is lagged taken at these points themselves: what would be zero where a
    /// step has settled, and in general no gradient of anything. A term that lags nothing need not say more.
    fn add_settled_gradient(&self, stage: &Stage<'_>, gradient: &mut [Vec3]) {
        self.add_gradient(stage.x, gradient);
    }

    /// Smooths laws that have a kink at rest below `velocity` [m/s], where they are not smoothed below a larger one anyhow; from then on, and
    /// not at all for zero. A term without such a law has nothing to do.
    fn soften(&mut self, velocity: f64) {
        let _ = velocity;
    }

    /// Adds `∂²E/∂xᵢ∂xⱼ` [N/m], projected as asked.
    ///
    /// A term that hands over several element lists makes its calls in a fixed order and passes an empty list
    /// rather than leaving a call out: the assembler recognises a list by its position.
    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>);

    /// Refreshes what is held constant during a step, a lag iteration or a Newton iteration.
    ///
    /// Answers whether `value` changed at the same `x`; the minimiser then evaluates anew.
    ///
    /// # Errors
    /// If the points are not admissible for the term. The term is then as it was.
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        let _ = stage;
        Ok(Changed::Nothing)
    }

    /// The largest admissible part of the step from `x` to `x + p`, and the rebuilding of whatever the term must
    /// know of the swept segment, so that every later `value(x + α p)` with `α` up to that part is pure.
    ///
    /// # Errors
    /// If the points at `x` are not admissible for the term.
    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        let _ = (x, p);
        Ok(StepLimit::FULL)
    }

    /// Whether a minimisation may end at `x` as far as this term is concerned, though its last direction is `p`. Asked only where `p` is
    /// shorter than the tolerance; on a no the step is made.
    ///
    /// A tolerance is a length for all points alike. A term that resolves shorter ones objects as long as `p` changes them by
    /// a good part of themselves: a barrier that is squeezed to a gap far below the tolerance opens it by steps of the gap's size.
    fn is_settled(&self, x: &[Vec3], p: &[Vec3]) -> bool {
        let _ = (x, p);
        true
    }

    /// What the term demands of the time scheme.
    fn demand(&self) -> Demand {
        Demand::Nothing
    }

    /// The element that pulls most at `point`, for messages. Asked only after a failure, so it may be slow.
    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        let _ = (x, point);
        None
    }

    /// Which element makes the value or the gradient at `x` infinite or NaN, if any does. Asked only after a
    /// failure, so it may be slow.
    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        let _ = x;
        None
    }
}

/// Whether freezing changed an energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[must_use]
pub enum Changed {
    /// Value and derivatives at the same points are what they were.
    #[default]
    Nothing,
    /// They are not: evaluate anew.
    Energy,
}

impl Changed {
    /// `Energy` if either is.
    pub fn or(self, other: Self) -> Self {
        if self == Self::Energy { self } else { other }
    }
}

/// What a term demands of the time scheme that it is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Demand {
    /// Nothing: it may be evaluated at the middle of a step as well as at its end.
    #[default]
    Nothing,
    /// That the positions minimised over are those at the end of the step. A barrier says so: where a scheme minimises
    /// over the middle y of a step, the end 2y − x is not guarded. Its elements come and go; those of other terms are
    /// taken to stay.
    EndPositions,
}

/// The admissible part of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct StepLimit {
    /// The part, in [0, 1]: `x + α p` is admissible for every `α` up to it.
    pub fraction: f64,
    /// The element of the term that set it; `None` for a full step.
    pub element: Option<usize>,
}

impl StepLimit {
    /// No limit: the whole step is admissible.
    pub const FULL: Self = Self { fraction: 1.0, element: None };

    /// The limit `fraction` set by `element`; the full step if `fraction` is one or more.
    pub fn by_element(fraction: f64, element: usize) -> Self {
        if fraction >= 1.0 { Self::FULL } else { Self { fraction, element: Some(element) } }
    }
}

/// What was being evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// The energy.
    Value,
    /// Its gradient.
    Gradient,
    /// Its Hessian.
    Hessian,
    /// The admissible part of a step.
    StepLimit,
}

impl std::fmt::Display for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Value => "energy",
            Self::Gradient => "gradient",
            Self::Hessian => "Hessian",
            Self::StepLimit => "admissible step",
        })
    }
}

/// What is wrong with a term, and where.
#[derive(Debug, thiserror::Error)]
pub enum PotentialError {
    /// An element's value or derivative is infinite or NaN.
    #[error("{term}: the {quantity} of element {element} (points {points:?}) is {value}")]
    NonFinite {
        /// The term's name.
        term: String,
        /// What was evaluated.
        quantity: Quantity,
        /// The element.
        element: usize,
        /// The element's points.
        points: Vec<u32>,
        /// The first offending number.
        value: f64,
    },
    /// A step limit is not in [0, 1].
    #[error("{term}: element {element:?} limits the step to {fraction}, which is not between 0 and 1")]
    StepLimit {
        /// The term's name.
        term: String,
        /// The element, where known.
        element: Option<usize>,
        /// The offending limit.
        fraction: f64,
    },
    /// The term's own error, from the crate that defines the term (an intersecting pair, for example).
    #[error("{term}: {source}")]
    Term {
        /// The term's name.
        term: String,
        /// The crate's own typed error, to be downcast by whoever knows it.
        source: Box<dyn Error + Send + Sync>,
    },
}
