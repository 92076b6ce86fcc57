//! From any path to a stationary one, where Newton's method alone gets stuck.
//!
//! Newton's method stops where the Hessian becomes singular, and between a straight line and a saddle it often
//! does. The **Newton homotopy** goes on: the curve of all (q, λ) with
//!
//! δA(q) = (1 − λ) δA(guess)
//!
//! passes through (guess, 0) and is followed in its own arc length s, along which a singular Hessian is only a
//! turning point of λ. Where it reaches λ = 1 the path is stationary. If δA is dominated by inertia for large paths
//! (bounded forces, as for pendulums), the curve cannot escape to infinity while λ stays finite, and λ = 1 is
//! reached from almost every guess, if the budget lasts.
//!
//! The curve's tangent (q′, λ′) solves H q′ + λ′ δA(guess) = 0, so that q′ = −λ′ z with H z = δA(guess). A step is
//! a prediction along the tangent t and Newton's corrections across it: with H u = δA(q) − (1 − λ) δA(guess),
//!
//! Δλ (t_λ − t_q·z) = t_q·u, Δq = −u − z Δλ.
//!
//! Both need the factors of H only. Lengths are root mean squares over the nodes, each coordinate measured by its
//! largest magnitude on the guess.
//!
//! The curve has two ends. For bounded forces inertia makes δA monotonic for large paths, so that one end is at λ →
//! −∞ and the other at λ → +∞. It is followed towards growing λ first; if that is the wrong way (λ falls below −10:
//! it turned round at the first singular Hessian), the other end is the right one.
//!
//! # Reference
//! Keller, *Global homotopies and Newton methods*, in Recent Advances in Numerical Analysis (1978). Allgower and
//! Georg, *Introduction to Numerical Continuation Methods* (2003), chapters 2, 6 and 11. Branin, *Widely convergent
//! method for finding multiple solutions of simultaneous nonlinear equations*, IBM J. Res. Develop. 16 (1972).

use super::Action;
use super::block::{BlockTridiagonal, Signs};
use super::path::Path;
use crate::system::System;

/// The first step, and the largest.
const FIRST: f64 = 0.1;
const LARGEST: f64 = 1.0;
/// A step shorter than this is stagnation.
const SHORTEST: f64 = 1e-7;
/// The λ at which the first way is taken for the wrong one, and that at which the other is given up.
const WRONG_WAY: f64 = -10.0;
const LOST: f64 = -1e3;
/// Corrections that must do, the size at which they are done, and how much each must shrink.
const CORRECTIONS: usize = 5;
const DONE: f64 = 1e-5;
const SHRINK: f64 = 0.4;
/// The least cosine of the angle between tangents of neighbouring points.
const STRAIGHT: f64 = 0.9;

/// A point of the curve: unknowns, λ, and the unit tangent there.
#[derive(Clone, Debug)]
struct Point<C> {
    path: Path<C>,
    lambda: f64,
    /// q′.
    along: Vec<f64>,
    /// λ′.
    rate: f64,
}

/// The curve from a guess.
struct Curve<'a, 'b, S: System> {
    action: &'b Action<'a, S>,
    /// δA(guess).
    start: Vec<f64>,
    /// 1/(size² count) of every unknown.
    weights: Vec<f64>,
    hessian: BlockTridiagonal,
    /// Factorisations left.
    budget: u32,
}

impl<S: System> Action<'_, S> {
    /// A path near a stationary one, on the homotopy's curve from `guess`, and what is left of the budget of
    /// factorisations.
    pub(super) fn follow(
        &self,
        guess: &Path<S::Coordinates>,
        budget: u32,
    ) -> Option<(Path<S::Coordinates>, u32)> {
        let mut curve = Curve {
            action: self,
            start: self.variation(guess).gradient,
            weights: self.weights(guess),
            hessian: BlockTridiagonal::zeros(self.blocks(), self.system.dimension()),
            budget,
        };
        let start = curve.at(guess)?;
        let other_way =
            Point { along: start.along.iter().map(|q| -q).collect(), rate: -start.rate, ..start.clone() };
        let near = curve.run(start, WRONG_WAY).or_else(|| curve.run(other_way, LOST))?;
        Some((near, curve.budget))
    }

    fn weights(&self, guess: &Path<S::Coordinates>) -> Vec<f64> {
        let dimension = self.system.dimension();
        let size = |i: usize| {
            let largest = guess.positions.iter().map(|q| q.as_ref()[i].abs()).fold(0.0, f64::max);
            if largest > 0.0 { largest } else { 1.0 }
        };
        let sizes: Vec<f64> = (0..dimension).map(size).collect();
        let count = (self.node_count() - 2) * dimension;
        (0..count).map(|j| (sizes[j % dimension].powi(2) * count as f64).recip()).collect()
    }
}

impl<S: System> Curve<'_, '_, S> {
    fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        self.weights.iter().zip(a).zip(b).map(|((w, a), b)| w * a * b).sum()
    }

    /// H⁻¹ of several right sides at a path; none where something is not finite, or the budget is spent.
    fn solve(&mut self, path: &Path<S::Coordinates>, rights: &mut [Vec<f64>]) -> Option<()> {
        self.budget = self.budget.checked_sub(1)?;
        let factors = self.action.factors(path, &mut self.hessian).ok()?;
        rights.iter_mut().for_each(|right| factors.solve(right, Signs::Kept));
        rights.iter().flatten().all(|x| x.is_finite()).then_some(())
    }

    /// The curve's start.
    fn at(&mut self, guess: &Path<S::Coordinates>) -> Option<Point<S::Coordinates>> {
        let mut solution = [self.start.clone()];
        self.solve(guess, &mut solution)?;
        let [z] = solution;
        Some(self.tangent(guess.clone(), 0.0, z, None))
    }

    /// Follows the curve from a point in the direction of its tangent, to λ = 1; none if λ falls below `lowest`.
    fn run(&mut self, mut point: Point<S::Coordinates>, lowest: f64) -> Option<Path<S::Coordinates>> {
        let mut length = FIRST;
        while length >= SHORTEST && self.budget > 0 && point.lambda > lowest {
            let Some((next, corrections)) = self.step(&point, length) else {
                length *= 0.5;
                continue;
            };
            if next.lambda >= 1.0 {
                let part = (1.0 - point.lambda) / (next.lambda - point.lambda);
                return Some(point.path.between(&next.path, part));
            }
            point = next;
            if corrections <= 2 {
                length = (1.5 * length).min(LARGEST);
            }
        }
        None
    }

    /// The unit tangent at a point, in the direction of that at the point before; of growing λ without one.
    fn tangent(
        &self,
        path: Path<S::Coordinates>,
        lambda: f64,
        z: Vec<f64>,
        before: Option<&Point<S::Coordinates>>,
    ) -> Point<S::Coordinates> {
        let length = (1.0 + self.product(&z, &z)).sqrt();
        let ahead = before.map_or(1.0, |p| p.rate - self.product(&p.along, &z));
        let rate = 1f64.copysign(ahead) / length;
        let along = z.into_iter().map(|z| -rate * z).collect();
        Point { path, lambda, along, rate }
    }

    /// The point a step further, and how many corrections it took; none if the step is too long.
    fn step(&mut self, from: &Point<S::Coordinates>, length: f64) -> Option<(Point<S::Coordinates>, usize)> {
        let mut path = from.path.moved(&from.along, length);
        let mut lambda = from.lambda + length * from.rate;
        let mut before = f64::INFINITY;
        for corrections in 1..=CORRECTIONS {
            let here = self.action.variation(&path);
            let off =
                here.gradient.iter().zip(&self.start).map(|(g, start)| g - (1.0 - lambda) * start).collect();
            let mut solutions = [off, self.start.clone()];
            self.solve(&path, &mut solutions)?;
            let [u, z] = solutions;
            let ratio = self.product(&from.along, &u) / (from.rate - self.product(&from.along, &z));
            let change: Vec<f64> = u.iter().zip(&z).map(|(u, z)| -u - z * ratio).collect();
            let size = (self.product(&change, &change) + ratio * ratio).sqrt();
            path = path.moved(&change, 1.0);
            lambda += ratio;
            if size.is_nan() || size > SHRINK * before || size > length {
                return None;
            }
            if size <= DONE {
                let next = self.tangent(path, lambda, z, Some(from));
                let turn = self.product(&next.along, &from.along) + next.rate * from.rate;
                return (turn >= STRAIGHT).then_some((next, corrections));
            }
            before = size;
        }
        None
    }
}
