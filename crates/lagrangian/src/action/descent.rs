//! Descent on the action: finds minima, leaves saddles.

use super::Action;
use super::block::{BlockTridiagonal, Signs};
use super::hessian::Variation;
use super::newton::{Search, Stationary};
use super::path::Path;
use crate::error::{LagrangianError, PathFailure};
use crate::system::System;

/// Where descent led.
#[derive(Clone, Debug)]
pub struct Descent<C> {
    /// What became of it.
    pub outcome: Outcome<C>,
    /// Steps made.
    pub iterations: u32,
    /// The action at every iteration, the start's first \[J s\]; decreasing.
    pub actions: Vec<f64>,
}

/// What became of a descent.
#[derive(Clone, Debug)]
pub enum Outcome<C> {
    /// A stationary path that descent does not leave.
    Arrived(Stationary<C>),
    /// The path grew beyond all bounds, and its action fell with it: nothing bounds the action from below.
    RanAway {
        /// The largest magnitude of a coordinate, in units of the start's.
        extent: f64,
        /// The action there \[J s\].
        action: f64,
    },
}

/// A path this many times as large as at the start has run away.
const FAR: f64 = 1e8;
/// A step must lower the action by this part of what its slope promises (Armijo).
const SUFFICIENT: f64 = 1e-4;
/// A part of a step shorter than this is stagnation.
const SHORTEST: f64 = 1e-12;

impl<S: System> Action<'_, S> {
    /// Goes down from `guess` until the action does not fall any more.
    ///
    /// The direction is −(L |D| Lᵀ)⁻¹ ∂A/∂q, where L D Lᵀ is the Hessian: Newton's step where the Hessian is
    /// positive definite, and downhill with the same lengths where it is not. Steps are halved until the action
    /// falls by 1e-4 of what the slope promises. Where a minimum exists this is as fast as
    /// [`stationary`](Self::stationary) and finds the same path. Past the first conjugate point a stationary path
    /// is no minimum, and descent leaves it: to a lower path, or without end.
    ///
    /// A guess that is stationary already is not left, whatever its index: descent has no reason to move.
    ///
    /// # Errors
    /// As [`stationary`](Self::stationary).
    ///
    /// # Panics
    /// If the path is not one of this action's.
    pub fn descend(
        &self,
        guess: &Path<S::Coordinates>,
        search: &Search,
    ) -> Result<Descent<S::Coordinates>, LagrangianError> {
        self.check(guess);
        self.refuse_non_finite(guess)?;
        self.refuse_forces(guess)?;
        let mut hessian = BlockTridiagonal::zeros(self.blocks(), self.system.dimension());
        let mut path = guess.clone();
        let mut at = self.variation(&path);
        self.refuse_non_finite_variation(&at)?;
        let mut actions = vec![at.action];
        let mut iterations = 0;
        loop {
            let factors = self.factors(&path, &mut hessian)?;
            let mut direction: Vec<f64> = at.gradient.iter().map(|g| -g).collect();
            factors.solve(&mut direction, Signs::Positive);
            let short = self.length(&path, &direction) <= search.tolerance;
            if at.is_rounding(4.0) || short && at.is_rounding(1e6) {
                // A force may vanish all along the guess, as friction does on a path at rest.
                self.refuse_forces(&path)?;
                let outcome = Outcome::Arrived(self.report(path, &at, iterations, &factors));
                return Ok(Descent { outcome, iterations, actions });
            }
            let extent = self.extent(guess, &path);
            if extent > FAR {
                let outcome = Outcome::RanAway { extent, action: at.action };
                return Ok(Descent { outcome, iterations, actions });
            }
            if short && factors.inertia.zero > 0 {
                // What is left of the slope lies in directions whose curvature is zero: the fall has no length.
                return Err(self.failure(PathFailure::Conjugate, iterations, &at));
            }
            if iterations == search.max_iterations {
                return Err(self.failure(PathFailure::Iterations, iterations, &at));
            }
            let next = self.lower(&path, &at, &direction);
            let Some(next) = next else { return Err(self.failure(PathFailure::Stagnation, iterations, &at)) };
            (path, at) = next;
            actions.push(at.action);
            iterations += 1;
        }
    }

    /// The longest part of a step that lowers the action enough, up to its rounding.
    fn lower(
        &self,
        path: &Path<S::Coordinates>,
        at: &Variation,
        direction: &[f64],
    ) -> Option<(Path<S::Coordinates>, Variation)> {
        let slope: f64 = direction.iter().zip(&at.gradient).map(|(d, g)| d * g).sum();
        let rounding = 16.0 * f64::EPSILON * at.size;
        let mut part = 1.0;
        while part >= SHORTEST {
            let trial = path.moved(direction, part);
            let there = self.variation(&trial);
            if there.is_finite() && there.action <= at.action + SUFFICIENT * part * slope + rounding {
                return Some((trial, there));
            }
            part *= 0.5;
        }
        None
    }

    /// How many times larger than at the start the path is, in the coordinate that grew most.
    fn extent(&self, start: &Path<S::Coordinates>, path: &Path<S::Coordinates>) -> f64 {
        let size = |path: &Path<S::Coordinates>, i: usize| {
            path.positions.iter().map(|q| q.as_ref()[i].abs()).fold(0.0, f64::max)
        };
        let grown = |i: usize| match size(start, i) {
            0.0 => size(path, i),
            before => size(path, i) / before,
        };
        (0..self.system.dimension()).map(grown).fold(0.0, f64::max)
    }
}
