//! Newton's method with a line search, for any [`Objective`].
//!
//! Each iteration finds a direction `p`, asks how far along it the objective is defined ([`Objective::limit_step`]),
//! and backs away from there until the value falls enough. It ends when the step norm of `p` (`a ‖p‖∞`, metres a
//! second; metres in statics) is below the tolerance, *before* that last step is made: a start that is good enough
//! is returned as it is, with zero iterations.
//!
//! **Settling.** A direction shorter than the tolerance does not end the minimisation if a term says that it is not settled
//! ([`Objective::is_settled`]): the tolerance is one length for all, and a term may resolve shorter ones. The step is then made like any other.
//!
//! **Line search.** A step `α` is accepted if `φ(α) ≤ φ(0) + c₁ α φ'(0)` with `φ(α) = E(x + α p)`, c₁ = 1e-4 (Armijo
//! 1966); else it is halved. Close to the minimum both sides differ by less than the rounding of `E`, and the test
//! is a toss-up. So where `|φ(α) − φ(0)|` is within [`Objective::rounding`], the derivative decides instead: the
//! step is accepted if `φ'(α) ≤ (1 − 2δ) |φ'(0)|` with δ = 0.1. For a quadratic `φ` this is the Armijo condition with
//! c₁ = δ, but without subtracting nearly equal numbers (the "approximate Wolfe condition" of Hager and Zhang). If the
//! whole step should lower `E` by more than 100 roundings, and only its halving brought the difference down to
//! rounding, the other Wolfe condition is asked for too, `φ'(α) ≥ σ φ'(0)` with σ = 0.9: a step so short that not even
//! the slope changes is no progress, and a sign that the gradient is wrong.
//!
//! **Inexact directions.** With [`Forcing::EisenstatWalker`] the linear systems are solved only as well as the
//! nonlinear residual deserves. A small residual does not make a direction's soft components right, so an inexact
//! direction never decides convergence: it is solved again, exactly, first.
//!
//! **Shifted directions.** A matrix that is not positive definite may be solved with `τ` times its diagonal added,
//! which shortens the direction: by `1 + τ` where the diagonal is the stiffness, by more where the body is softer than its diagonal.
//! Convergence counts the first factor back in, and a direction whose `τ` may be larger than it need be does not decide it either:
//! it is found again with the smallest `τ` that does ([`DirectionAccuracy::Decisive`]).
//!
//! **A tolerance below rounding.** Once the quadratic model promises less than the rounding of the value, −½ gᵀp ≤
//! [`Objective::rounding`], or than what the rounding of the unknowns makes of it, ε Σ |gᵢ xᵢ|, only the gradient says whether
//! steps still help. They do as long as they shrink. Where one does not (it is not below 9/10 of the shortest since one was last cut
//! short by [`Objective::limit_step`], after which the next is about as long anyhow), the gradient is compared with its own
//! rounding: its change ‖g(x') − g(x)‖₂ where every unknown is
//! moved by one rounding, x'ᵢ = xᵢ ± ε max(|xᵢ|, mean |x|), about ε ‖|H| |x|‖. If ‖g‖₂ is no more than eight times that, x is a minimum
//! as well as it can be told: the minimisation ends, and the report says so ([`NewtonReport::at_rounding`]). If steps do not shrink for
//! 25 iterations and the gradient is larger than that, something is wrong with the directions:
//! [`NewtonCause::Stagnated`] says the step norm that was reached.
//!
//! # Reference
//! Nocedal, Wright, *Numerical Optimization*, 2nd ed., 2006, chapter 3. Hager, Zhang, *A new conjugate gradient
//! method with guaranteed descent and an efficient line search*, SIAM J. Optim. 16 (2005), section 4. Eisenstat,
//! Walker, *Choosing the forcing terms in an inexact Newton method*, SIAM J. Sci. Comput. 17 (1996), choice 2.

mod error;
mod line_search;
mod options;
mod report;
mod stagnation;

pub use error::{NewtonCause, NewtonError};
pub use options::{Forcing, NewtonOptions, OptionsError};
pub use report::{NewtonReport, NewtonTimes, Proceed, Progress};

use crate::objective::{DirectionAccuracy, Limit, Objective, ObjectiveError};
use crate::potential::{Changed, Quantity};
use line_search::{LineSearch, Trial};
use report::timed;
use stagnation::Stagnation;

/// Moves `x` to a minimum of `objective`. See [`minimise_observed`].
///
/// # Errors
/// [`NewtonError`]; `x` is then as it was.
///
/// # Panics
/// If `x` does not have the objective's dimension.
pub fn minimise(
    objective: &mut dyn Objective,
    x: &mut [f64],
    options: &NewtonOptions,
) -> Result<NewtonReport, Box<NewtonError>> {
    minimise_observed(objective, x, options, &mut |_| Proceed::Continue)
}

/// Moves `x` to a minimum of `objective`, asking `observer` before every step whether to go on.
///
/// # Errors
/// [`NewtonError`] says why, where, and what was done until then; `x` is then as it was. Reaching the largest number
/// of iterations is an error.
///
/// # Panics
/// If `x` does not have the objective's dimension.
pub fn minimise_observed(
    objective: &mut dyn Objective,
    x: &mut [f64],
    options: &NewtonOptions,
    observer: &mut dyn FnMut(&Progress) -> Proceed,
) -> Result<NewtonReport, Box<NewtonError>> {
    assert_eq!(x.len(), objective.dimension(), "one entry per unknown");
    let mut newton = Newton::new(objective, x, *options);
    match newton.run(observer) {
        Ok(()) => {
            x.copy_from_slice(&newton.x);
            Ok(newton.report)
        }
        Err(cause) => {
            let Newton { progress, report, .. } = newton;
            Err(Box::new(NewtonError { cause, progress, report }))
        }
    }
}

/// The state of a minimisation.
struct Newton<'a> {
    objective: &'a mut dyn Objective,
    options: NewtonOptions,
    x: Vec<f64>,
    gradient: Vec<f64>,
    /// Whether `gradient` is that at `x`.
    gradient_known: bool,
    direction: Vec<f64>,
    forcing: f64,
    /// The shift that the last direction was found with, relative to the diagonal.
    shift: f64,
    /// ‖g‖₂ where the last direction was found.
    last_gradient_norm: Option<f64>,
    first_step_norm: f64,
    stagnation: Stagnation,
    progress: Progress,
    report: NewtonReport,
}

impl<'a> Newton<'a> {
    fn new(objective: &'a mut dyn Objective, x: &[f64], options: NewtonOptions) -> Self {
        Self {
            objective,
            options,
            x: x.to_vec(),
            gradient: vec![0.0; x.len()],
            gradient_known: false,
            direction: vec![0.0; x.len()],
            forcing: 0.0,
            shift: 0.0,
            last_gradient_norm: None,
            first_step_norm: 0.0,
            stagnation: Stagnation::default(),
            progress: Progress::default(),
            report: NewtonReport::default(),
        }
    }

    fn run(&mut self, observer: &mut dyn FnMut(&Progress) -> Proceed) -> Result<(), NewtonCause> {
        self.options.validate()?;
        if let Some(index) = self.x.iter().position(|x| !x.is_finite()) {
            return Err(NewtonCause::Start { index, value: self.x[index] });
        }
        self.evaluate_value()?;
        loop {
            self.refreeze()?;
            self.evaluate_gradient()?;
            if self.find_direction()? {
                return Ok(());
            }
            self.check_progress()?;
            if self.is_at_rounding()? {
                return Ok(());
            }
            if observer(&self.progress) == Proceed::Cancel {
                return Err(NewtonCause::Cancelled);
            }
            match self.make_step() {
                Err(NewtonCause::LineSearch { .. })
                    if self.values_are_noise() && self.gradient_is_noise() =>
                {
                    self.report.at_rounding = 1;
                    return Ok(());
                }
                done => done?,
            }
        }
    }

    fn evaluate_value(&mut self) -> Result<(), NewtonCause> {
        let value = timed(&mut self.report.times.value, || self.objective.value(&self.x));
        self.report.values += 1;
        self.progress.value = value;
        if value.is_finite() { Ok(()) } else { Err(self.non_finite(Quantity::Value, &[value])) }
    }

    fn refreeze(&mut self) -> Result<(), NewtonCause> {
        let changed = timed(&mut self.report.times.freeze, || self.objective.freeze(&self.x))?;
        if changed == Changed::Energy {
            self.report.changes += 1;
            self.gradient_known = false;
            self.evaluate_value()?;
        }
        Ok(())
    }

    fn evaluate_gradient(&mut self) -> Result<(), NewtonCause> {
        if !self.gradient_known {
            let gradient = &mut self.gradient;
            timed(&mut self.report.times.gradient, || self.objective.gradient_into(&self.x, gradient));
            self.report.gradients += 1;
            self.gradient_known = true;
        }
        self.progress.gradient_norm = norm(&self.gradient);
        if self.gradient.iter().all(|g| g.is_finite()) {
            return Ok(());
        }
        let gradient = std::mem::take(&mut self.gradient);
        Err(self.non_finite(Quantity::Gradient, &gradient))
    }

    /// Finds a direction; answers whether the minimum is reached.
    fn find_direction(&mut self) -> Result<bool, NewtonCause> {
        self.forcing = self
            .options
            .forcing
            .next(self.forcing, self.last_gradient_norm.map(|last| self.progress.gradient_norm / last));
        self.last_gradient_norm = Some(self.progress.gradient_norm);
        if self.gradient.iter().all(|&g| g == 0.0) {
            self.progress.step_norm = 0.0;
            return Ok(true);
        }
        let forcing = self.forcing;
        self.solve(if forcing > 0.0 {
            DirectionAccuracy::Relative(forcing)
        } else {
            DirectionAccuracy::Full
        })?;
        if self.is_short() && (forcing > 0.0 || self.shift > 0.0) {
            self.forcing = 0.0;
            self.solve(DirectionAccuracy::Decisive)?;
        }
        if !self.is_short() {
            return Ok(false);
        }
        let settled = self.objective.is_settled(&self.x, &self.direction);
        self.report.unsettled += u64::from(!settled);
        Ok(settled)
    }

    /// Whether the direction is shorter than the tolerance.
    fn is_short(&self) -> bool {
        (1.0 + self.shift) * self.progress.step_norm < self.options.tolerance
    }

    fn solve(&mut self, accuracy: DirectionAccuracy) -> Result<(), NewtonCause> {
        let done = self.objective.direction_into(&self.x, &self.gradient, accuracy, &mut self.direction)?;
        self.report.add_direction(&done);
        self.shift = done.shift;
        if let Some(index) = self.direction.iter().position(|p| !p.is_finite()) {
            return Err(NewtonCause::Direction { index, value: self.direction[index] });
        }
        self.progress.step_norm = self.objective.step_norm(&self.direction);
        self.progress.slope = dot(&self.gradient, &self.direction);
        Ok(())
    }

    /// Refuses to go on where it would be in vain.
    fn check_progress(&mut self) -> Result<(), NewtonCause> {
        let Progress { step_norm, slope, iteration, .. } = self.progress;
        if slope.is_nan() || slope >= 0.0 {
            return Err(NewtonCause::NotDescending { slope });
        }
        if iteration == 0 {
            self.first_step_norm = step_norm;
        }
        let largest = self.options.divergence * self.first_step_norm.max(self.options.tolerance);
        let location = |newton: &mut Self| newton.objective.locate(&newton.x, &newton.direction);
        if step_norm.is_nan() || step_norm > largest {
            return Err(NewtonCause::Diverged { first: self.first_step_norm, location: location(self) });
        }
        if iteration == self.options.max_iterations {
            let tolerance = self.options.tolerance;
            return Err(NewtonCause::NotConverged { tolerance, location: location(self) });
        }
        Ok(())
    }

    /// Whether the model promises less than the rounding of the value, or than what the rounding of the unknowns makes of it.
    fn values_are_noise(&self) -> bool {
        let rounding = self.objective.rounding(self.progress.value);
        let of_unknowns: f64 = self.gradient.iter().zip(&self.x).map(|(g, x)| (g * x).abs()).sum();
        -0.5 * self.progress.slope <= rounding.max(f64::EPSILON * of_unknowns)
    }

    /// Whether rounding keeps the minimum from being told any better.
    fn is_at_rounding(&mut self) -> Result<bool, NewtonCause> {
        if !self.values_are_noise() {
            self.stagnation = Stagnation::default();
            return Ok(false);
        }
        self.stagnation.record((1.0 + self.shift) * self.progress.step_norm);
        if self.stagnation.is_suspected() && self.gradient_is_noise() {
            self.report.at_rounding = 1;
            return Ok(true);
        }
        if self.stagnation.is_certain() {
            let (tolerance, reached) = (self.options.tolerance, self.stagnation.shortest);
            let location = self.objective.locate(&self.x, &self.direction);
            return Err(NewtonCause::Stagnated { tolerance, reached, location });
        }
        Ok(false)
    }

    /// Whether the gradient is no more than what rounding makes of it.
    fn gradient_is_noise(&mut self) -> bool {
        let moved = stagnation::moved_by_rounding(&self.x);
        let mut gradient = vec![0.0; self.x.len()];
        timed(&mut self.report.times.gradient, || self.objective.gradient_into(&moved, &mut gradient));
        self.report.gradients += 1;
        gradient.iter_mut().zip(&self.gradient).for_each(|(moved, g)| *moved -= g);
        self.progress.gradient_norm <= stagnation::ROUNDINGS * norm(&gradient)
    }

    fn make_step(&mut self) -> Result<(), NewtonCause> {
        let limit =
            timed(&mut self.report.times.limit_step, || self.objective.limit_step(&self.x, &self.direction))?;
        let Limit { fraction, location } = limit;
        if !(0.0..=1.0).contains(&fraction) {
            return Err(NewtonCause::StepLimit { fraction, location });
        }
        if fraction == 0.0 {
            return Err(NewtonCause::Blocked { location });
        }
        if fraction < 1.0 {
            self.report.limited_steps += 1;
            // The next step is about as long because this one is cut short: that is no sign of rounding.
            self.stagnation = Stagnation::default();
        }
        let search = LineSearch {
            x: &self.x,
            direction: &self.direction,
            largest: fraction,
            value: self.progress.value,
            slope: self.progress.slope,
            rounding: self.objective.rounding(self.progress.value),
        };
        let accepted = search.run(self.objective, &mut self.report)?;
        if fraction < 1.0 && accepted.x == self.x {
            return Err(NewtonCause::Blocked { location });
        }
        let Trial { x, value, fraction, gradient } = accepted;
        (self.x, self.progress.value, self.progress.fraction) = (x, value, fraction);
        self.gradient_known = gradient.is_some();
        self.gradient = gradient.unwrap_or_else(|| std::mem::take(&mut self.gradient));
        self.progress.iteration += 1;
        self.report.iterations += 1;
        Ok(())
    }

    /// What to say of a quantity that is infinite or NaN at `x`: the culprit if the objective knows it.
    fn non_finite(&mut self, what: Quantity, entries: &[f64]) -> NewtonCause {
        let first = entries.iter().position(|entry| !entry.is_finite()).unwrap_or(0);
        let unknown = ObjectiveError::NonFinite { what, index: first, value: entries[first] };
        NewtonCause::Objective(self.objective.diagnose(&self.x).unwrap_or(unknown))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
