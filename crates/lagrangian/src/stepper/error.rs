//! Why a step was not made.

use mechanics_core::newton::NewtonError;
use mechanics_core::point_map::PointMapError;
use mechanics_core::potential::PotentialError;
use std::fmt;

/// An array of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StateArray {
    /// Positions \[m\].
    Position,
    /// Velocities [m/s].
    Velocity,
}

impl fmt::Display for StateArray {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
        })
    }
}

/// Why a step was not made. The state is then as it was, bit for bit.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// A step size is positive and finite.
    #[error("the step size is {step} s; it must be positive and finite")]
    StepSize {
        /// The step size \[s\].
        step: f64,
    },
    /// The number of load steps is positive.
    #[error("an equilibrium is reached in at least one load step, not in none")]
    NoLoadSteps,
    /// A position or velocity is infinite or NaN.
    #[error("the {array} of point {point} is {value:?}, which is not finite")]
    NonFinite {
        /// Which array.
        array: StateArray,
        /// The point.
        point: usize,
        /// Its entry.
        value: [f64; 3],
    },
    /// A point that moves has no mass.
    #[error(
        "point {point} moves but has no mass (it is {mass} kg): no element gives it any; add a point mass, fix it, or \
         remove it"
    )]
    NoMass {
        /// The point.
        point: usize,
        /// Its mass \[kg\].
        mass: f64,
    },
    /// Every point is fixed, or there is none.
    #[error("there is nothing to solve: all {points} points are fixed")]
    NothingToSolve {
        /// How many points there are.
        points: usize,
    },
    /// A term demands end positions, which the scheme does not minimise over.
    #[error(
        "the implicit midpoint rule minimises over the middle of a step, so the term \"{term}\" would not guard its \
         end; choose backward Euler, BDF2 or Newmark"
    )]
    MidpointWithBarrier {
        /// The term.
        term: String,
    },
    /// An explicit scheme needs forces without a Hessian at a lumped mass.
    #[error("explicit schemes need a lumped mass, but points {} and {} are coupled", .pair[0], .pair[1])]
    ConsistentMass {
        /// The first coupled pair.
        pair: [u32; 2],
    },
    /// An explicit scheme needs points that are unknowns themselves, each another one, or fixed.
    #[error("explicit schemes need a map that makes every point an unknown of its own or none")]
    WeightedPoints,
    /// A force is infinite or NaN.
    #[error("the force on point {point} is {force:?} at t = {time} s: {}", .culprit.as_ref().map_or_else(|| "no term says why".to_owned(), ToString::to_string))]
    Force {
        /// The point.
        point: usize,
        /// The force \[N\].
        force: [f64; 3],
        /// When \[s\].
        time: f64,
        /// The element behind it, if a term knows.
        #[source]
        culprit: Option<Box<PotentialError>>,
    },
    /// The midpoint rule ends where a term is not defined.
    #[error(
        "the middle of the step at t = {time} s is sound, but at its end the energy of \"{term}\" is {value}: {}; the \
         implicit midpoint rule does not guard that: take a smaller step or another scheme",
        .culprit.as_ref().map_or_else(|| "the term does not say where".to_owned(), ToString::to_string)
    )]
    End {
        /// The term.
        term: String,
        /// Its energy at the end \[J\].
        value: f64,
        /// The middle of the step \[s\].
        time: f64,
        /// The element behind it, if the term knows.
        #[source]
        culprit: Option<Box<PotentialError>>,
    },
    /// A target was set for a point that moves freely.
    #[error("point {point} moves freely, so nothing would come of its target; fix it in the map")]
    NotFixed {
        /// The point.
        point: u32,
    },
    /// The unknowns cannot be read off the positions, or a target is wrong.
    #[error(transparent)]
    Map(#[from] PointMapError),
    /// A term does not admit the state.
    #[error("at t = {time} s: {source}")]
    Term {
        /// The time the term was asked for \[s\].
        time: f64,
        /// The term's error.
        source: PotentialError,
    },
    /// The minimisation failed.
    #[error("the step to t = {time} s with h = {step} s failed: {source}")]
    Newton {
        /// The end of the step \[s\].
        time: f64,
        /// The step size \[s\]; zero in statics.
        step: f64,
        /// Why, where, and what was done until then.
        source: Box<NewtonError>,
    },
    /// A scripted point cannot get where it should be, because something is in its way.
    #[error(
        "scripted point {point} does not reach its target {target:?} in the step to t = {time} s: {remaining:e} m remain, \
         however hard it is pulled; is something squeezed in between?{}",
        .source.as_ref().map_or_else(String::new, |source| format!(" ({source})"))
    )]
    Unreached {
        /// The point that remains farthest from its target.
        point: u32,
        /// The target \[m\].
        target: [f64; 3],
        /// How far away the point remains \[m\].
        remaining: f64,
        /// The time that terms see \[s\].
        time: f64,
        /// The minimisation that failed on the way, if one did.
        source: Option<Box<NewtonError>>,
    },
    /// Lagged data went on changing the minimum.
    #[error("the step to t = {time} s still moves after {iterations} lag iterations")]
    Lagging {
        /// The end of the step \[s\].
        time: f64,
        /// Lag iterations made.
        iterations: u64,
    },
}
