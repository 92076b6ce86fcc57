//! The equations of a step with lagged data of the solution itself, solved as they are: for steps that lagging does not settle.
//!
//! Lagging repeats: hold data L, minimise, take L anew. What it seeks are unknowns q at which the *settled gradient*
//! R(q) = ∇E(q; L(q)) vanishes: the balance of forces with friction of the normal forces that act there. R is no gradient of anything, and its
//! Jacobian J is not symmetric: friction changes the normal force, and the normal force friction. A repetition that goes in a cycle, or
//! jumps between two minima of the lagged energies, may have a root of R in its midst all the same, which need not be a minimum of the lagged
//! energy there. Newton's method on R finds it:
//!
//! - *Direction.* J p = −R by GMRES, from the left with the factor P of the lagged Hessian at q (projected, so that it is always positive
//!   definite). P⁻¹J is the identity but for the dependence of L on q, of which the rank is at most three times the number of pairs, and for what
//!   projection changed: so few products J v are needed. A product is a difference of settled gradients, ‖δ v‖∞ = 1e-10 of the size of q.
//! - *Length.* Terms limit a step as they do in a minimisation. Then it is halved until the *simplified* Newton step from where it ends,
//!   p̄ = −J⁻¹R(q + α p) with the Jacobian of its start, is shorter than p: ‖p̄‖ ≤ (1 − α/10) ‖p‖ (natural monotonicity). That is a
//!   test of lengths of unknowns, and does not depend on how forces are weighted. ‖P⁻¹R‖ in its place needs no second GMRES, but ended half as
//!   often at a root.
//!
//! It ends at steps below the tolerance of the stepper's Newton method, or gives up.
//!
//! - *Softening.* A solution that sticks is a needle's eye where the normal turns with the way: a ridge that comes down on a ridge by z sticks
//!   within εᵥ h d/z of one place, d the gap, and everywhere else friction has no slope that would lead there. So where Newton's method gives
//!   up, laws with a kink at rest are softened ([`Potential::soften`](mechanics_core::potential::Potential::soften)) to a hundred times the fastest speed, where friction is a dashpot, and hardened
//!   again in stages, each from the solution before: by a factor of ten at first, of its root after a failure, and of more again after a
//!   success.
//!
//! All sums are in order: bits do not depend on threads.
//!
//! # Reference
//! P. Deuflhard, *Newton Methods for Nonlinear Problems*, 2004, sections 2.1.2 and 3.3 (natural monotonicity test); D. A. Knoll, D. E. Keyes,
//! *Jacobian-free Newton–Krylov methods*, J. Comput. Phys. 193, 2004; E. L. Allgower, K. Georg,
//! *Introduction to Numerical Continuation Methods*, 2003, chapter 2; Y. Saad, M. H. Schultz, *GMRES*, SIAM J. Sci. Stat. Comput. 7, 1986.

use super::StepperOptions;
use mechanics_core::linear::{Accuracy, LinearSolver, Solver};
use mechanics_core::objective::{IncrementalPotential, Objective};
use mechanics_core::potential::{Changed, PotentialError};
use mechanics_core::stage::Moment;

/// Lag iterations that go before the first attempt; the next are after twice as many, and so on.
const PASSES: u64 = 24;
/// The first softening, and the last before none, in parts of the fastest speed.
const SOFTEST: f64 = 100.0;
const HARDEST: f64 = 1e-9;
/// The largest and the smallest factor between stages, by which power it grows after a success, and how many stages are tried.
const LARGEST_RATIO: f64 = 10.0;
const SMALLEST_RATIO: f64 = 1.02;
const GROWTH: f64 = 1.5;
const STAGES: u32 = 100;
/// Newton iterations of an attempt.
const ITERATIONS: u32 = 80;
/// Halvings of a step.
const HALVINGS: u32 = 20;
/// By how much a step must shorten the next, in parts of its length.
const DECREASE: f64 = 0.1;
/// Products J v of a direction at most, and how small they must make its residual, that of a direction and that of a simplified one.
const PRODUCTS: usize = 200;
const RESIDUAL: f64 = 1e-5;
const SIMPLIFIED_RESIDUAL: f64 = 1e-3;
/// The largest entry of a difference of unknowns, in parts of the largest unknown.
const DIFFERENCE: f64 = 1e-10;

/// Whether an attempt is due after so many lag iterations.
pub(super) fn is_due(iterations: u64) -> bool {
    iterations.is_multiple_of(PASSES) && (iterations / PASSES).is_power_of_two()
}

/// The sum of terms, and what is known of it at the last point.
struct Settling<'s, 'a, 'b> {
    objective: &'s mut IncrementalPotential<'a, 'b, Solver>,
    /// Of the lagged Hessian.
    solver: Solver,
    /// Of the stepper's Newton method.
    tolerance: f64,
    q: Vec<f64>,
    residual: Vec<f64>,
}

/// Moves `q` to where the gradient with lagged data of that place vanishes, and takes the data there; answers whether it could. If not, `q` is as
/// it was, and lagged data are those of `q`. `speed` is that of the fastest point at `q`.
///
/// # Errors
/// Those of terms that refuse to freeze.
pub(super) fn settle(
    objective: &mut IncrementalPotential<'_, '_, Solver>,
    options: &StepperOptions,
    speed: f64,
    q: &mut [f64],
) -> Result<bool, PotentialError> {
    let (solver, tolerance) = (Solver::new(options.method), options.newton.tolerance);
    let mut settling = Settling { objective, solver, tolerance, q: q.to_vec(), residual: vec![0.0; q.len()] };
    let mut outcome = settling.solve();
    if matches!(outcome, Ok(false)) {
        settling.q.copy_from_slice(q);
        outcome = settling.harden(speed);
    }
    if matches!(outcome, Ok(true)) {
        q.copy_from_slice(&settling.q);
    }
    objective.soften(0.0);
    let is_settled = outcome?;
    let _: Changed = objective.freeze_at(Moment::Settling, q)?;
    Ok(is_settled)
}

impl Settling<'_, '_, '_> {
    /// Follows the solution from soft laws to the laws as they are; answers whether it got there.
    fn harden(&mut self, speed: f64) -> Result<bool, PotentialError> {
        let (mut softening, mut ratio) = (SOFTEST * speed, LARGEST_RATIO);
        let mut known: Option<(f64, Vec<f64>)> = None;
        for _ in 0..STAGES {
            self.objective.soften(softening);
            if self.solve()? {
                if softening == 0.0 {
                    return Ok(true);
                }
                ratio = if known.is_some() { ratio.powf(GROWTH).min(LARGEST_RATIO) } else { ratio };
                known = Some((softening, self.q.clone()));
            } else {
                ratio = ratio.sqrt();
            }
            let Some((solved, q)) = known.as_ref().filter(|_| ratio > SMALLEST_RATIO) else { break };
            self.q.copy_from_slice(q);
            softening = if *solved > HARDEST * speed { solved / ratio } else { 0.0 };
        }
        Ok(false)
    }

    /// Newton's method from q.
    fn solve(&mut self) -> Result<bool, PotentialError> {
        self.objective.settled_gradient_into(&self.q, &mut self.residual);
        for _ in 0..ITERATIONS {
            let _: Changed = self.objective.freeze_at(Moment::Settling, &self.q)?;
            let factored = self.solver.factor(self.objective.hessian(&self.q));
            let residual = self.residual.clone();
            let direction = factored.ok().and_then(|_| self.direction(&residual, RESIDUAL));
            let Some(p) = direction else { return Ok(false) };
            if self.objective.step_norm(&p) < self.tolerance {
                return Ok(true);
            }
            if !self.make_step(&p) {
                return Ok(false);
            }
        }
        Ok(false)
    }

    /// Moves along `p` until the next step would be shorter; answers whether it could.
    fn make_step(&mut self, p: &[f64]) -> bool {
        let Ok(limit) = self.objective.limit_step(&self.q, p) else { return false };
        let (mut fraction, length) = (limit.fraction, norm(p));
        for _ in 0..HALVINGS {
            let trial: Vec<f64> = self.q.iter().zip(p).map(|(q, p)| q + fraction * p).collect();
            let mut residual = vec![0.0; trial.len()];
            self.objective.settled_gradient_into(&trial, &mut residual);
            let next = self.direction(&residual, SIMPLIFIED_RESIDUAL);
            if next.is_some_and(|next| norm(&next) <= (1.0 - DECREASE * fraction) * length) {
                (self.q, self.residual) = (trial, residual);
                return true;
            }
            fraction *= 0.5;
        }
        false
    }

    /// J v at q.
    fn product(&mut self, v: &[f64]) -> Vec<f64> {
        let delta = DIFFERENCE * largest(&self.q) / largest(v);
        let moved: Vec<f64> = self.q.iter().zip(v).map(|(q, v)| q + delta * v).collect();
        let mut product = vec![0.0; v.len()];
        self.objective.settled_gradient_into(&moved, &mut product);
        product.iter_mut().zip(&self.residual).for_each(|(moved, here)| *moved = (*moved - here) / delta);
        product
    }

    /// P⁻¹ b.
    fn preconditioned(&mut self, b: &[f64]) -> Option<Vec<f64>> {
        let mut x = vec![0.0; b.len()];
        self.solver.solve_into(b, &mut x, Accuracy::Configured).ok()?;
        x.iter().all(|x| x.is_finite()).then_some(x)
    }

    /// −J⁻¹ b, until ‖P⁻¹ (b + J p)‖ is below `residual` times ‖P⁻¹ b‖; `None` if that fails.
    fn direction(&mut self, b: &[f64], residual: f64) -> Option<Vec<f64>> {
        if !b.iter().all(|b| b.is_finite()) {
            return None;
        }
        let start = self.preconditioned(&b.iter().map(|b| -b).collect::<Vec<f64>>())?;
        let size = norm(&start);
        if size == 0.0 {
            return Some(start);
        }
        let mut krylov = Krylov::new(start, size);
        for _ in 0..PRODUCTS.min(b.len()) {
            let product = self.product(krylov.last());
            if krylov.add(self.preconditioned(&product)?) <= residual * size {
                return krylov.solution();
            }
        }
        None
    }
}

/// An orthonormal basis V of a Krylov space of A = P⁻¹J and A V = V₊ H, with H made triangular by rotations.
struct Krylov {
    basis: Vec<Vec<f64>>,
    /// The columns of the triangle.
    columns: Vec<Vec<f64>>,
    /// Cosine and sine of each rotation.
    rotations: Vec<[f64; 2]>,
    /// The right-hand side, rotated; the last entry is the residual.
    right: Vec<f64>,
}

impl Krylov {
    fn new(mut start: Vec<f64>, size: f64) -> Self {
        start.iter_mut().for_each(|entry| *entry /= size);
        Self { basis: vec![start], columns: Vec::new(), rotations: Vec::new(), right: vec![size] }
    }

    /// The last vector of the basis.
    fn last(&self) -> &[f64] {
        self.basis.last().map_or(&[], Vec::as_slice)
    }

    /// Takes A times the last vector in; answers the residual.
    fn add(&mut self, mut w: Vec<f64>) -> f64 {
        let mut column = vec![0.0; self.basis.len()];
        // Twice is enough (Kahan; Parlett 1980).
        for _ in 0..2 {
            for (entry, v) in column.iter_mut().zip(&self.basis) {
                let part = dot(&w, v);
                *entry += part;
                w.iter_mut().zip(v).for_each(|(w, v)| *w -= part * v);
            }
        }
        for (i, &[cos, sin]) in self.rotations.iter().enumerate() {
            let (above, below) = (column[i], column[i + 1]);
            (column[i], column[i + 1]) = (cos * above + sin * below, cos * below - sin * above);
        }
        let (size, end) = (norm(&w), column.len() - 1);
        let radius = column[end].hypot(size);
        let [cos, sin] = if radius > 0.0 { [column[end] / radius, size / radius] } else { [1.0, 0.0] };
        column[end] = radius;
        let rest = self.right[end];
        self.right[end] = cos * rest;
        self.right.push(-sin * rest);
        self.rotations.push([cos, sin]);
        self.columns.push(column);
        if size > 0.0 {
            w.iter_mut().for_each(|w| *w /= size);
        }
        self.basis.push(w);
        (sin * rest).abs()
    }

    /// The vector of the space with the least residual; `None` if the triangle is singular.
    fn solution(&self) -> Option<Vec<f64>> {
        let count = self.columns.len();
        let mut parts = self.right[..count].to_vec();
        for i in (0..count).rev() {
            parts[i] /= self.columns[i][i];
            for k in 0..i {
                parts[k] -= self.columns[i][k] * parts[i];
            }
        }
        let mut sum = vec![0.0; self.basis[0].len()];
        for (part, v) in parts.iter().zip(&self.basis) {
            sum.iter_mut().zip(v).for_each(|(sum, v)| *sum += part * v);
        }
        sum.iter().all(|x| x.is_finite()).then_some(sum)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |largest, a| a.abs().max(largest))
}
