//! Newton's method on δA = 0.

use super::Action;
use super::block::{BlockTridiagonal, Factors, Inertia, Signs};
use super::hessian::Variation;
use super::path::Path;
use crate::error::{LagrangianError, PathFailure, Symbol};
use crate::system::System;

/// How long and how exactly to search for a stationary path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Found when Newton's correction is below this part of the path's size, in every coordinate.
    pub tolerance: f64,
    /// Factorisations of the Hessian after which not having found a path is an error.
    pub max_iterations: u32,
}

impl Default for Search {
    /// Corrections of 1e-10 (the path is then much better still, since convergence is quadratic), 2000 iterations.
    fn default() -> Self {
        Self { tolerance: 1e-10, max_iterations: 2000 }
    }
}

/// A path whose action is stationary.
#[derive(Clone, Debug)]
pub struct Stationary<C> {
    /// The path.
    pub path: Path<C>,
    /// A \[J s\].
    pub action: f64,
    /// The largest |∂A/∂q| over the nodes that is left; \[J s\] per unit of the coordinate.
    pub residual: f64,
    /// What rounding alone may leave of it.
    pub rounding: f64,
    /// Factorisations of the Hessian that were needed beyond the first one.
    pub iterations: u32,
    /// The signs of the eigenvalues of the Hessian of A, over all unknowns of the path.
    pub inertia: Inertia,
    /// For every negative eigenvalue, the end \[s\] of the interval in which the path passes the conjugate point
    /// that brings it; increasing, exact up to two intervals.
    pub conjugate_times: Vec<f64>,
}

/// What kind of stationary point a path is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extremum {
    /// Every small variation raises the action: there is no conjugate point up to the end.
    Minimum,
    /// Some variations lower the action: conjugate points lie before the end.
    Saddle {
        /// The number of negative eigenvalues: the Morse index.
        index: usize,
    },
    /// The end is conjugate to the start: some variations leave the action as it is, up to second order and rounding.
    Degenerate {
        /// The number of negative eigenvalues.
        index: usize,
        /// The number of zero eigenvalues.
        nullity: usize,
    },
}

impl<C> Stationary<C> {
    /// The Morse index: the number of negative eigenvalues of the Hessian of A.
    pub fn index(&self) -> usize {
        self.inertia.negative
    }

    /// Minimum, saddle, or neither.
    pub fn extremum(&self) -> Extremum {
        match self.inertia {
            Inertia { zero: 0, negative: 0, .. } => Extremum::Minimum,
            Inertia { zero: 0, negative: index, .. } => Extremum::Saddle { index },
            Inertia { zero: nullity, negative: index, .. } => Extremum::Degenerate { index, nullity },
        }
    }
}

/// A part of a Newton step shorter than this is stagnation.
const SHORTEST: f64 = 1e-4;
/// Iterations of Newton's method alone.
const DIRECT: u32 = 25;

impl<S: System> Action<'_, S> {
    /// The stationary path between the ends of `guess`, by Newton's method from there, or where that gets stuck by
    /// following the Newton homotopy δA(q) = (1 − λ) δA(guess) from λ = 0 to 1.
    ///
    /// Each iteration solves H Δ = −∂A/∂q with the Hessian H of A. A part α of the step is accepted if the
    /// simplified correction from where it leads, −H⁻¹ ∂A/∂q (q + α Δ), is no longer than 1 − α/4 of Δ; else α is
    /// halved. This test does not depend on the units of A, and knows no up or down, so that it works for saddles
    /// as for minima. Lengths are largest magnitudes, each coordinate measured by its largest magnitude along the
    /// path.
    ///
    /// Where the end-point problem has many solutions (a pendulum may go round), the guess decides, and a good
    /// guess finds the solution beside it. From a bad one *some* solution is mostly found, not always: that none is
    /// found does not mean that there is none.
    ///
    /// # Errors
    /// [`LagrangianError::NoAction`] for forces that no potential gives; [`LagrangianError::NonFinite`];
    /// [`LagrangianError::NoStationaryPath`] after the largest number of iterations, on stagnation, and at a
    /// conjugate end point that has no stationary path; it says where Newton's method got stuck.
    ///
    /// # Panics
    /// If the path is not one of this action's.
    ///
    /// # Reference
    /// Deuflhard, *Newton Methods for Nonlinear Problems* (2004), section 3.3 (natural monotonicity test). For the
    /// homotopy: Keller, *Global homotopies and Newton methods* (1978).
    pub fn stationary(
        &self,
        guess: &Path<S::Coordinates>,
        search: &Search,
    ) -> Result<Stationary<S::Coordinates>, LagrangianError> {
        self.check(guess);
        self.refuse_non_finite(guess)?;
        self.refuse_forces(guess)?;
        let found = self.search(guess, search)?;
        // A force may vanish all along the guess, as friction does on a path at rest.
        self.refuse_forces(&found.path)?;
        Ok(found)
    }

    /// Newton's method, then the homotopy.
    fn search(
        &self,
        guess: &Path<S::Coordinates>,
        search: &Search,
    ) -> Result<Stationary<S::Coordinates>, LagrangianError> {
        let direct = search.max_iterations.min(DIRECT);
        let stuck = match self.newton(guess, search.tolerance, direct) {
            Err(stuck @ LagrangianError::NoStationaryPath { .. }) => stuck,
            other => return other,
        };
        let Some((near, left)) = self.follow(guess, search.max_iterations - direct) else {
            return Err(stuck);
        };
        let mut found = self.newton(&near, search.tolerance, left)?;
        found.iterations += search.max_iterations - left;
        Ok(found)
    }

    /// Newton's method from `guess`.
    fn newton(
        &self,
        guess: &Path<S::Coordinates>,
        tolerance: f64,
        most: u32,
    ) -> Result<Stationary<S::Coordinates>, LagrangianError> {
        let mut hessian = BlockTridiagonal::zeros(self.blocks(), self.system.dimension());
        let mut path = guess.clone();
        let mut at = self.variation(&path);
        self.refuse_non_finite_variation(&at)?;
        let mut iterations = 0;
        loop {
            let factors = self.factors(&path, &mut hessian)?;
            if at.is_rounding(4.0) {
                let (path, at) = self.polished(path, at, &factors);
                return Ok(self.report(path, &at, iterations, &factors));
            }
            let correction = newton_step(&factors, &at);
            let length = self.length(&path, &correction);
            if length <= tolerance {
                let full = path.moved(&correction, 1.0);
                let after = self.variation(&full);
                if after.is_rounding(1e3) {
                    let (full, after) = self.polished(full, after, &factors);
                    return Ok(self.report(full, &after, iterations, &factors));
                }
            }
            let conjugate = factors.inertia.zero > 0;
            if iterations == most {
                return Err(self.failure(PathFailure::Iterations, iterations, &at));
            }
            match self.damped(&path, &correction, length, &factors) {
                Some(next) => (path, at) = next,
                None if at.is_rounding(1e3) => return Ok(self.report(path, &at, iterations, &factors)),
                None if conjugate => return Err(self.failure(PathFailure::Conjugate, iterations, &at)),
                None => return Err(self.failure(PathFailure::Stagnation, iterations, &at)),
            }
            iterations += 1;
        }
    }

    /// Corrections with the factors at hand while each halves the one that would follow: a residual within its rounding
    /// may leave errors far above it along directions in which the action is nearly flat.
    fn polished(
        &self,
        mut path: Path<S::Coordinates>,
        mut at: Variation,
        factors: &Factors,
    ) -> (Path<S::Coordinates>, Variation) {
        if factors.inertia.zero > 0 {
            return (path, at);
        }
        let mut correction = newton_step(factors, &at);
        let mut length = self.length(&path, &correction);
        loop {
            let trial = path.moved(&correction, 1.0);
            let after = self.variation(&trial);
            let next = newton_step(factors, &after);
            let left = self.length(&trial, &next);
            // Also ends at NaN.
            if !after.is_finite() || left.is_nan() || left > 0.5 * length || length == 0.0 {
                return (path, at);
            }
            (path, at, correction, length) = (trial, after, next, left);
        }
    }

    /// The inertia of the Hessian of A at any path, stationary or not.
    ///
    /// # Errors
    /// [`LagrangianError::NonFinite`].
    ///
    /// # Panics
    /// If the path is not one of this action's.
    pub fn inertia(&self, path: &Path<S::Coordinates>) -> Result<Inertia, LagrangianError> {
        self.check(path);
        let mut hessian = BlockTridiagonal::zeros(self.blocks(), self.system.dimension());
        Ok(self.factors(path, &mut hessian)?.inertia)
    }

    /// The longest part of the step that comes nearer, and what is there.
    fn damped(
        &self,
        path: &Path<S::Coordinates>,
        correction: &[f64],
        length: f64,
        factors: &Factors,
    ) -> Option<(Path<S::Coordinates>, Variation)> {
        let mut part = 1.0;
        while part >= SHORTEST {
            let trial = path.moved(correction, part);
            let at = self.variation(&trial);
            if at.is_finite() {
                let next = self.length(path, &newton_step(factors, &at));
                if next <= (1.0 - 0.25 * part) * length {
                    return Some((trial, at));
                }
            }
            part *= 0.5;
        }
        None
    }

    /// The Hessian's factors at a path.
    pub(super) fn factors(
        &self,
        path: &Path<S::Coordinates>,
        hessian: &mut BlockTridiagonal,
    ) -> Result<Factors, LagrangianError> {
        self.hessian_into(path, hessian);
        let entries = || hessian.diagonal.iter().chain(&hessian.coupling);
        let finite = |block: &Vec<f64>| block.iter().all(|x| x.is_finite());
        match entries().position(|block| !finite(block)) {
            None => Ok(hessian.factor()),
            Some(block) => {
                let interval = block % hessian.diagonal.len();
                let value = entries().nth(block).and_then(|b| b.iter().copied().find(|x| !x.is_finite()));
                Err(LagrangianError::NonFinite {
                    symbol: Symbol::Slope,
                    index: 0,
                    value: value.unwrap_or(f64::NAN),
                    time: self.start + self.step() * interval as f64,
                })
            }
        }
    }

    /// The largest entry of a correction, each coordinate measured by its largest magnitude along the path.
    pub(super) fn length(&self, path: &Path<S::Coordinates>, correction: &[f64]) -> f64 {
        let dimension = self.system.dimension();
        let mut longest = 0.0f64;
        for i in 0..dimension {
            let size = path.positions.iter().map(|q| q.as_ref()[i].abs()).fold(0.0, f64::max);
            let moved = correction.iter().skip(i).step_by(dimension).map(|c| c.abs()).fold(0.0, f64::max);
            // A coordinate that is zero all along has no size of its own.
            longest = longest.max(if size > 0.0 { moved / size } else { moved });
        }
        longest
    }

    pub(super) fn refuse_non_finite_variation(&self, at: &Variation) -> Result<(), LagrangianError> {
        if at.is_finite() {
            return Ok(());
        }
        // Of a system without coordinates only the action itself can fail.
        let dimension = self.system.dimension().max(1);
        let entry = at.gradient.iter().position(|g| !g.is_finite());
        Err(LagrangianError::NonFinite {
            symbol: Symbol::Slope,
            index: entry.unwrap_or(0) % dimension,
            value: entry.map_or(at.action, |e| at.gradient[e]),
            time: self.time(entry.unwrap_or(0) / dimension + 1),
        })
    }

    pub(super) fn failure(&self, failure: PathFailure, iterations: u32, at: &Variation) -> LagrangianError {
        let worst = at.worst();
        let node = worst / self.system.dimension() + 1;
        LagrangianError::NoStationaryPath {
            failure,
            iterations,
            residual: at.gradient[worst].abs(),
            rounding: at.rounding[worst],
            node,
            time: self.time(node),
        }
    }

    pub(super) fn report(
        &self,
        path: Path<S::Coordinates>,
        at: &Variation,
        iterations: u32,
        factors: &Factors,
    ) -> Stationary<S::Coordinates> {
        let ends = |&block: &usize| self.time((block + 2).min(self.intervals) * self.basis.degree);
        let worst = at.worst();
        Stationary {
            path,
            action: at.action,
            residual: at.gradient.get(worst).map_or(0.0, |g| g.abs()),
            rounding: at.rounding.get(worst).copied().unwrap_or(0.0),
            iterations,
            inertia: factors.inertia,
            conjugate_times: factors.negative_in.iter().map(ends).collect(),
        }
    }
}

fn newton_step(factors: &Factors, at: &Variation) -> Vec<f64> {
    let mut step: Vec<f64> = at.gradient.iter().map(|g| -g).collect();
    factors.solve(&mut step, Signs::Kept);
    step
}
