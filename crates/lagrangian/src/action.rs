//! Stationary action: the path between two end points.
//!
//! Motion from q(t₁) = a to q(t₂) = b makes the action A = ∫ L(q, q̇, t) dt stationary, δA = 0 for every
//! variation that vanishes at both ends. Here paths are polynomials on `n` intervals ([`Galerkin`]), so
//! that A is a function of finitely many numbers, A = Σₖ L_d(qₖ, qₖ₊₁), and δA = 0 are the discrete Euler–Lagrange
//! equations D₂L_d(qₖ₋₁, qₖ) + D₁L_d(qₖ, qₖ₊₁) = 0, all at once. [`Action::stationary`] solves them by Newton's
//! method with the Hessian of A, which is block-tridiagonal: O(n N³) an iteration for N coordinates.
//!
//! "Least" action is a misnomer. The number of negative eigenvalues of the Hessian, the path's **Morse index**, is
//! the number of conjugate points before the end (Morse's index theorem; Milnor, *Morse Theory* (1963), theorem
//! 15.1): a path is a minimum only up to its first conjugate point, where neighbouring motions from the same start
//! meet again. For an oscillator that is half a period. Past it the path is a saddle: [`Action::descend`] leaves
//! it, and Newton's method on δA = 0 finds it.
//!
//! ```
//! use lagrangian::action::{Action, Galerkin, Extremum, Search};
//! use lagrangian::{EulerLagrange, Lagrangian};
//! use mechanics_core::scalar::Scalar;
//!
//! struct Spring;
//! impl Lagrangian<1> for Spring {
//!     fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
//!         v[0].square().scale(0.5)
//!     }
//!     fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
//!         q[0].square().scale(0.5)
//!     }
//! }
//!
//! let system = EulerLagrange::new(Spring);
//! let action = Action::new(&system, 0.0, 2.0, 20, Galerkin { degree: 3 })?;
//! let found = action.stationary(&action.straight(&[0.0], &[1.0]), &Search::default())?;
//! // A = cos 2 / (2 sin 2), and 2 s is less than half a period.
//! assert!((found.action - 2f64.cos() / (2.0 * 2f64.sin())).abs() < 1e-9);
//! assert_eq!(found.extremum(), Extremum::Minimum);
//! # Ok::<(), lagrangian::LagrangianError>(())
//! ```

mod block;
mod descent;
mod hessian;
mod homotopy;
mod newton;
mod path;
mod rule;

pub use block::Inertia;
pub use descent::{Descent, Outcome};
pub use newton::{Extremum, Search, Stationary};
pub use path::Path;
pub use rule::Galerkin;

use crate::coordinates::Coordinates;
use crate::error::{LagrangianError, Symbol};
use crate::system::{Curvature, Expansion, System};
use rule::Basis;
use std::fmt;

/// The action of a system's paths from a time to a later one, over intervals of equal length.
pub struct Action<'a, S: System> {
    system: &'a S,
    basis: Basis,
    start: f64,
    end: f64,
    intervals: usize,
}

// Not derived, for systems that are not `Debug` themselves.
impl<S: System> fmt::Debug for Action<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { system, basis, start, end, intervals } = self;
        f.debug_struct("Action")
            .field("dimension", &system.dimension())
            .field("degree", &basis.degree)
            .field("start", start)
            .field("end", end)
            .field("intervals", intervals)
            .finish()
    }
}

impl<'a, S: System> Action<'a, S> {
    /// The action from `start` to `end` \[s\] on `intervals` intervals.
    ///
    /// # Errors
    /// [`LagrangianError::Span`] if the times are not finite and increasing, or there is no interval, or they are
    /// too short to be told apart; [`LagrangianError::Degree`].
    pub fn new(
        system: &'a S,
        start: f64,
        end: f64,
        intervals: usize,
        rule: Galerkin,
    ) -> Result<Self, LagrangianError> {
        let step = (end - start) / intervals as f64;
        let smallest = 1e3 * f64::EPSILON * start.abs().max(end.abs());
        if intervals == 0 || step <= smallest || !step.is_finite() {
            return Err(LagrangianError::Span { start, end, intervals });
        }
        Ok(Self { system, basis: Basis::new(rule)?, start, end, intervals })
    }

    /// The length of an interval \[s\].
    pub fn step(&self) -> f64 {
        (self.end - self.start) / self.intervals as f64
    }

    /// The number of nodes of a path, both ends among them.
    pub fn node_count(&self) -> usize {
        self.intervals * self.basis.degree + 1
    }

    /// The time of a node \[s\].
    pub fn time(&self, node: usize) -> f64 {
        let degree = self.basis.degree;
        let (interval, inner) = (node / degree, node % degree);
        if interval == self.intervals {
            return self.end;
        }
        self.start + self.step() * (interval as f64 + self.basis.nodes[inner])
    }

    /// The path in a straight line, at constant velocity, from `from` to `to`.
    ///
    /// # Panics
    /// If an end does not have the system's dimension.
    pub fn straight(&self, from: &S::Coordinates, to: &S::Coordinates) -> Path<S::Coordinates> {
        let (from, to) = (from.as_ref(), to.as_ref());
        let dimension = self.system.dimension();
        assert!(from.len() == dimension && to.len() == dimension, "one number per coordinate at both ends");
        self.path(|t| {
            let part = (t - self.start) / (self.end - self.start);
            let mut q = S::Coordinates::zeros(dimension);
            for i in 0..dimension {
                q.as_mut()[i] = from[i] * (1.0 - part) + to[i] * part;
            }
            q
        })
    }

    /// The path through the positions that `position` gives for the nodes' times; its ends are the end points.
    ///
    /// # Panics
    /// If a position does not have the system's dimension.
    pub fn path(&self, position: impl FnMut(f64) -> S::Coordinates) -> Path<S::Coordinates> {
        let times: Vec<f64> = (0..self.node_count()).map(|node| self.time(node)).collect();
        let positions: Vec<S::Coordinates> = times.iter().copied().map(position).collect();
        let dimension = self.system.dimension();
        assert!(positions.iter().all(|q| q.as_ref().len() == dimension), "one number per coordinate");
        Path { basis: self.basis.clone(), times, positions }
    }

    /// A \[J s\]. NaN where L is.
    ///
    /// # Panics
    /// If the path is not one of this action's.
    pub fn value(&self, path: &Path<S::Coordinates>) -> f64 {
        self.check(path);
        let mut at = Expansion::zeros(self.system.dimension());
        let mut total = 0.0;
        for interval in 0..self.intervals {
            for point in 0..self.basis.points.len() {
                let (t, q, v) = self.state(path, interval, point);
                self.system.expand(t, &q, &v, &mut at);
                total += self.step() * self.basis.points[point].weight * (at.kinetic - at.potential);
            }
        }
        total
    }

    /// ∂A/∂q of the nodes between the ends, N numbers for each of them in turn.
    ///
    /// # Panics
    /// If the path is not one of this action's.
    pub fn gradient(&self, path: &Path<S::Coordinates>) -> Vec<f64> {
        self.check(path);
        self.variation(path).gradient
    }

    fn check(&self, path: &Path<S::Coordinates>) {
        assert_eq!(path.positions.len(), self.node_count(), "a path with this action's nodes");
    }

    /// Time, position and velocity at a point of the quadrature.
    fn state(
        &self,
        path: &Path<S::Coordinates>,
        interval: usize,
        point: usize,
    ) -> (f64, S::Coordinates, S::Coordinates) {
        let point = &self.basis.points[point];
        let first = interval * self.basis.degree;
        let t = self.start + self.step() * (interval as f64 + point.time);
        let (q, v) = path.blend(first, &point.values, &point.slopes, self.step());
        (t, q, v)
    }

    /// Refuses systems under forces that no potential gives, as far as the forces or their derivatives show along
    /// `path`.
    fn refuse_forces(&self, path: &Path<S::Coordinates>) -> Result<(), LagrangianError> {
        let (time, q, v) = self.state(path, 0, 0);
        if !self.system.dependence(time, &q, &v).applied() {
            return Ok(());
        }
        // The formulas mention a force, but it may be switched off, as by a damping of zero.
        let dimension = self.system.dimension();
        let (mut at, mut curvature) = (Expansion::zeros(dimension), Curvature::zeros(dimension));
        for (interval, point) in (0..self.intervals).flat_map(|k| (0..self.basis.degree).map(move |i| (k, i)))
        {
            let (time, q, v) = self.state(path, interval, point);
            self.system.expand(time, &q, &v, &mut at);
            self.system.curve(time, &q, &v, &mut curvature);
            let rows = |matrix| S::Coordinates::entries(matrix).chunks(dimension);
            let mut slopes = rows(&curvature.applied_q).zip(rows(&curvature.applied_v));
            let applied = at.applied.as_ref();
            let acts = slopes.position(|(q, v)| q.iter().chain(v).any(|&slope| slope != 0.0));
            if let Some(coordinate) = applied.iter().position(|&force| force != 0.0).or(acts) {
                return Err(LagrangianError::NoAction { coordinate, force: applied[coordinate], time });
            }
        }
        Ok(())
    }

    /// Refuses paths with a NaN or an infinity.
    fn refuse_non_finite(&self, path: &Path<S::Coordinates>) -> Result<(), LagrangianError> {
        for (node, q) in path.positions.iter().enumerate() {
            if let Some(index) = q.as_ref().iter().position(|x| !x.is_finite()) {
                let (symbol, value) = (Symbol::Coordinate, q.as_ref()[index]);
                return Err(LagrangianError::NonFinite { symbol, index, value, time: self.time(node) });
            }
        }
        Ok(())
    }
}
