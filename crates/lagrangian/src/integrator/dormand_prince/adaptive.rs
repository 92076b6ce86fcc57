//! Integration with steps of the size that the tolerance asks for.

use super::control::Controller;
use super::{DenseStep, DenseTrajectory, DormandPrince853};
use crate::coordinates::{Coordinates, Phase};
use crate::error::LagrangianError;
use crate::integrator::event::{Event, Located, Watch};
use crate::integrator::{Outcome, Trajectory, assert_sizes};
use crate::system::System;
use std::fmt;
use std::ops::ControlFlow;

/// What an integration with step-size control took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveReport {
    /// Steps made.
    pub accepted: u64,
    /// Steps refused because their error was too large, or the equations of motion failed within them.
    pub rejected: u64,
    /// Evaluations of q̈.
    pub evaluations: u64,
    /// The smallest step made \[s\], the last one before an end time apart; infinite if there was none.
    pub smallest: f64,
    /// The largest step made \[s\].
    pub largest: f64,
    /// Why there are no more.
    pub outcome: Outcome,
}

impl Default for AdaptiveReport {
    fn default() -> Self {
        Self {
            accepted: 0,
            rejected: 0,
            evaluations: 0,
            smallest: f64::INFINITY,
            largest: 0.0,
            outcome: Outcome::Finished,
        }
    }
}

impl AdaptiveReport {
    /// Appends a later part of the same integration.
    fn append(&mut self, part: &Self) {
        self.accepted += part.accepted;
        self.rejected += part.rejected;
        self.evaluations += part.evaluations;
        self.smallest = self.smallest.min(part.smallest);
        self.largest = self.largest.max(part.largest);
        self.outcome = part.outcome;
    }
}

impl fmt::Display for AdaptiveReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} steps", self.accepted)?;
        if self.accepted > 0 {
            write!(f, " of at most {:.3e} s", self.largest)?;
        }
        write!(f, ", {} refused, {} evaluations", self.rejected, self.evaluations)?;
        f.write_str(match self.outcome {
            Outcome::Finished => "",
            Outcome::Stopped => ", stopped by the observer",
            Outcome::Event => ", stopped by an event",
        })
    }
}

/// What a caller makes of an accepted step: whether to go on, and the evaluations it took.
type Verdict = Result<(Option<Outcome>, u64), LagrangianError>;

impl<C: Coordinates> DormandPrince853<C> {
    /// Moves `phase` to time `end` \[s\], exactly.
    ///
    /// # Errors
    /// [`LagrangianError::Interval`] if `end` is before the phase's time; [`LagrangianError::NonFinite`] or
    /// [`LagrangianError::SingularMass`] if no step is small enough to avoid it; [`LagrangianError::StepTooSmall`],
    /// [`LagrangianError::TooManySteps`], [`LagrangianError::Stiff`]. `phase` is then as it was.
    pub fn integrate<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        end: f64,
    ) -> Result<AdaptiveReport, LagrangianError> {
        self.drive(system, phase, end, |_, _, _| Ok((None, 0)))
    }

    /// [`integrate`](Self::integrate) under the eyes of an observer, who sees the state after every step and may stop there.
    ///
    /// # Errors
    /// As [`integrate`](Self::integrate).
    pub fn advance<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        end: f64,
        mut observe: impl FnMut(&Phase<C>) -> ControlFlow<()>,
    ) -> Result<AdaptiveReport, LagrangianError> {
        self.drive(system, phase, end, |_, _, after| {
            Ok((observe(after).is_break().then_some(Outcome::Stopped), 0))
        })
    }

    /// Moves `phase` to the last of `times` and records the state at each. Steps end at these times, so that the states have the
    /// full order; for many close times [`dense`](Self::dense) is cheaper.
    ///
    /// # Errors
    /// As [`integrate`](Self::integrate).
    pub fn sample<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        times: &[f64],
    ) -> Result<(Trajectory<C>, AdaptiveReport), LagrangianError> {
        let start = phase.clone();
        let mut trajectory = Trajectory::with_capacity(times.len());
        let mut total = AdaptiveReport::default();
        for &time in times {
            let part = self.integrate(system, phase, time).inspect_err(|_| *phase = start.clone())?;
            total.append(&part);
            trajectory.push(phase);
        }
        Ok((trajectory, total))
    }

    /// Moves `phase` to time `end` and keeps the motion between as polynomials, one a step: three more evaluations each.
    ///
    /// # Errors
    /// As [`integrate`](Self::integrate).
    pub fn dense<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        end: f64,
    ) -> Result<(DenseTrajectory<C>, AdaptiveReport), LagrangianError> {
        let mut steps: Vec<DenseStep<C>> = Vec::new();
        let report = self.drive(system, phase, end, |method, before, after| {
            steps.push(method.dense_step(system, before, after)?);
            Ok((None, 3))
        })?;
        Ok((DenseTrajectory::new(steps), report))
    }

    /// Moves `phase` to time `end`, or to the first terminal event, and finds all events on the way, in order of time.
    ///
    /// Roots are found on the dense output, to the last digits of the time. An event that is zero at the start does not happen there.
    ///
    /// # Errors
    /// As [`integrate`](Self::integrate), and [`LagrangianError::Event`] if an event's function is not finite.
    pub fn locate<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        end: f64,
        events: &mut [Event<'_, C>],
    ) -> Result<(Vec<Located<C>>, AdaptiveReport), LagrangianError> {
        let mut watch = Watch::start(events, phase)?;
        let mut located = Vec::new();
        let report = self.drive(system, phase, end, |method, before, after| {
            let step = method.dense_step(system, before, after)?;
            let stop = watch.step(&step, after, &mut located)?;
            if let Some(at) = stop {
                *after = at;
                return Ok((Some(Outcome::Event), 3));
            }
            Ok((None, 3))
        })?;
        if report.outcome == Outcome::Finished {
            watch.finish(&mut located);
        }
        Ok((located, report))
    }

    /// The loop of all of the above. `accept` sees the states before and after each step, whose accelerations are then
    /// known; it may move the one after.
    fn drive<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        end: f64,
        accept: impl FnMut(&mut Self, &Phase<C>, &mut Phase<C>) -> Verdict,
    ) -> Result<AdaptiveReport, LagrangianError> {
        assert_sizes(system, phase, self.q.as_ref().len());
        phase.validate()?;
        if !(end.is_finite() && end >= phase.time) {
            return Err(LagrangianError::Interval { start: phase.time, end });
        }
        let kept = (phase.clone(), self.remainder.clone(), self.controller, self.suggested);
        self.run(system, phase, end, accept).inspect_err(|_| {
            (*phase, self.remainder, self.controller, self.suggested) = kept;
        })
    }

    fn run<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        end: f64,
        mut accept: impl FnMut(&mut Self, &Phase<C>, &mut Phase<C>) -> Verdict,
    ) -> Result<AdaptiveReport, LagrangianError> {
        let mut report = AdaptiveReport::default();
        if phase.time == end {
            return Ok(report);
        }
        let mut h = self.start(system, phase, &mut report)?;
        let mut stiffness = Stiffness::default();
        while phase.time < end {
            if report.accepted + report.rejected >= self.step_limit {
                return Err(LagrangianError::TooManySteps { limit: self.step_limit, time: phase.time, end });
            }
            let trial = Trial::choose(phase.time, end, h.min(self.largest_step))?;
            let mut after = self.advance_by(system, phase, &trial, &mut report);
            let factor = match &mut after {
                Ok((after, error)) => {
                    report.record(&trial, end);
                    let factor = self.controller.accept(*error);
                    stiffness.watch(self, phase, after, trial.step, report.accepted)?;
                    let (outcome, evaluations) = accept(self, phase, after)?;
                    report.evaluations += evaluations;
                    std::mem::swap(phase, after);
                    std::mem::swap(&mut self.a[0], &mut self.a_end);
                    if let Some(outcome) = outcome {
                        report.outcome = outcome;
                        self.suggested = None;
                        return Ok(report);
                    }
                    factor
                }
                Err(refusal) => {
                    report.rejected += 1;
                    let factor = self.controller.refuse(refusal.error);
                    if let (Some(cause), true) = (&refusal.cause, trial.is_smallest(phase.time, factor)) {
                        return Err(cause.clone());
                    }
                    factor
                }
            };
            // The step that lands on the end time is short for no fault of its own.
            h = if after.is_ok() && trial.end == end {
                h.max(trial.step * factor)
            } else {
                trial.step * factor
            };
        }
        self.suggested = Some(h);
        Ok(report)
    }

    /// The acceleration at the start, and the size of the first step.
    fn start<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &Phase<C>,
        report: &mut AdaptiveReport,
    ) -> Result<f64, LagrangianError> {
        system.acceleration(phase.time, &phase.q, &phase.v, &mut self.a[0])?;
        report.evaluations += 1;
        match self.suggested {
            Some(h) if self.remainder.continues(phase, 0.0) => Ok(h),
            _ => {
                self.controller = Controller::default();
                report.evaluations += 1;
                Ok(self.first_step(system, phase))
            }
        }
    }

    /// A first step such that h⁸ times the larger of the first and second derivative is a hundredth of the tolerance,
    /// the second derivative from an Euler step.
    ///
    /// # Reference
    /// Hairer, Nørsett, Wanner 1993, *Solving Ordinary Differential Equations I*, section II.4.
    fn first_step<S: System<Coordinates = C>>(&mut self, system: &S, phase: &Phase<C>) -> f64 {
        let n = self.q.as_ref().len();
        let of = self.tolerance;
        let norm = |term: &dyn Fn(usize) -> (f64, f64)| {
            let squares = (0..n).map(|i| {
                let (q, v) = (phase.q.as_ref()[i], phase.v.as_ref()[i]);
                let (x, y) = term(i);
                (x / of.scale(q, q)).powi(2) + (y / of.scale(v, v)).powi(2)
            });
            (squares.sum::<f64>() / (2 * n) as f64).sqrt()
        };
        let a = &self.a[0];
        let size = norm(&|i| (phase.q.as_ref()[i], phase.v.as_ref()[i]));
        let slope = norm(&|i| (phase.v.as_ref()[i], a.as_ref()[i]));
        let ratio = 0.01 * size / slope;
        let guess = if ratio.is_finite() && size > 1e-5 && slope > 1e-5 { ratio } else { 1e-6 };
        for i in 0..n {
            self.q.as_mut()[i] = phase.q.as_ref()[i] + guess * phase.v.as_ref()[i];
            self.velocities[1].as_mut()[i] = phase.v.as_ref()[i] + guess * a.as_ref()[i];
        }
        let [first, second, ..] = &mut self.a;
        if system.acceleration(phase.time + guess, &self.q, &self.velocities[1], second).is_err() {
            return guess;
        }
        let curvature = norm(&|i| {
            let (a, b) = (first.as_ref()[i], second.as_ref()[i]);
            (guess * a, b - a)
        }) / guess;
        let largest = slope.max(curvature);
        let h = if largest <= 1e-15 { (1e-3 * guess).max(1e-6) } else { (0.01 / largest).powf(1.0 / 8.0) };
        if h.is_finite() { h.min(100.0 * guess) } else { guess }
    }

    /// The state after the step and its error, or why it is refused. On success the acceleration at the end is known.
    #[inline]
    fn advance_by<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &Phase<C>,
        trial: &Trial,
        report: &mut AdaptiveReport,
    ) -> Result<(Phase<C>, f64), Refusal> {
        report.evaluations += 11;
        self.stages(system, phase, trial.step).map_err(Refusal::failed)?;
        let error = self.error(phase, trial.step);
        if error.is_nan() || error > 1.0 {
            return Err(Refusal { error, cause: None });
        }
        let sum = self.remainder.sum(phase, trial.step, &self.dq, &self.dv).map_err(Refusal::failed)?;
        report.evaluations += 1;
        system
            .acceleration(trial.end, &sum.phase.q, &sum.phase.v, &mut self.a_end)
            .map_err(Refusal::failed)?;
        let mut after = phase.clone();
        self.remainder.keep(sum, trial.end, &mut after);
        Ok((after, error))
    }
}

/// Why a step is refused.
struct Refusal {
    /// Its error in units of the tolerance; infinite if the equations of motion failed.
    error: f64,
    cause: Option<LagrangianError>,
}

impl Refusal {
    #[cold]
    fn failed(cause: LagrangianError) -> Self {
        Self { error: f64::INFINITY, cause: Some(cause) }
    }
}

impl AdaptiveReport {
    #[inline]
    fn record(&mut self, trial: &Trial, end: f64) {
        self.accepted += 1;
        self.largest = self.largest.max(trial.step);
        if trial.end < end {
            self.smallest = self.smallest.min(trial.step);
        }
    }
}

/// A step to try.
struct Trial {
    /// Its size \[s\], such that start + step = end but for rounding.
    step: f64,
    end: f64,
}

impl Trial {
    /// The step of size about `h` that leaves no tiny rest before `end`.
    #[inline]
    fn choose(start: f64, end: f64, h: f64) -> Result<Self, LagrangianError> {
        let rest = end - start;
        if 1.01 * h >= rest {
            return Ok(Self { step: rest, end });
        }
        let next = start + if 2.0 * h > rest { 0.5 * rest } else { h };
        if h.is_nan() || next - start <= 4.0 * f64::EPSILON * start.abs() {
            return Err(LagrangianError::StepTooSmall { time: start, step: h });
        }
        Ok(Self { step: next - start, end: next })
    }

    /// Whether a step smaller by `factor` would be too small.
    fn is_smallest(&self, start: f64, factor: f64) -> bool {
        self.step * factor <= 8.0 * f64::EPSILON * start.abs().max(f64::MIN_POSITIVE)
    }
}

/// Watches whether stability limits the step: then the product of h and the largest eigenvalue, estimated from the last two
/// stages, which lie at the same time, stays at the boundary of the stability region.
///
/// # Reference
/// Hairer, Wanner 1996, *Solving Ordinary Differential Equations II*, section IV.2.
#[derive(Default)]
struct Stiffness {
    /// Steps at the boundary since the last run of steps off it.
    at: u32,
    /// Steps off the boundary in a row.
    off: u32,
}

/// Stability region of the method along the negative real axis.
const BOUNDARY: f64 = 6.1;

impl Stiffness {
    #[inline]
    fn watch<C: Coordinates>(
        &mut self,
        method: &DormandPrince853<C>,
        before: &Phase<C>,
        after: &Phase<C>,
        h: f64,
        steps: u64,
    ) -> Result<(), LagrangianError> {
        if !steps.is_multiple_of(1000) && self.at == 0 {
            return Ok(());
        }
        let (mut slopes, mut states) = (0.0, 0.0);
        for i in 0..after.q.as_ref().len() {
            let dv = after.v.as_ref()[i] - method.velocities[11].as_ref()[i];
            let stage = method.a[0].as_ref()[i] + method.a[11].as_ref()[i];
            slopes += dv.powi(2) + (method.a_end.as_ref()[i] - stage).powi(2);
            states += dv.powi(2) + (after.q.as_ref()[i] - method.q.as_ref()[i]).powi(2);
        }
        if states > 0.0 && h * (slopes / states).sqrt() > BOUNDARY {
            self.off = 0;
            self.at += 1;
            if self.at == 15 {
                return Err(LagrangianError::Stiff { time: before.time, step: h });
            }
        } else {
            self.off += 1;
            if self.off == 6 {
                self.at = 0;
            }
        }
        Ok(())
    }
}
