//! Many steps: to an end time, to given times, under the eyes of an observer.

use super::{Integrator, StepReport, Trajectory};
use crate::coordinates::Phase;
use crate::error::LagrangianError;
use crate::system::System;
use std::fmt;
use std::ops::ControlFlow;

/// Why an integration has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// All of it is done.
    #[default]
    Finished,
    /// The observer has stopped it, after a whole step.
    Stopped,
    /// A terminal event has stopped it.
    Event,
}

/// What many steps took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DriveReport {
    /// Steps made.
    pub steps: u64,
    /// The sum over all steps.
    pub work: StepReport,
    /// Why there are no more.
    pub outcome: Outcome,
}

impl fmt::Display for DriveReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} steps, {} evaluations", self.steps, self.work.evaluations)?;
        if self.work.curvatures > 0 {
            write!(f, ", {} curvatures", self.work.curvatures)?;
        }
        if self.work.iterations > 0 {
            write!(f, ", {} iterations", self.work.iterations)?;
        }
        f.write_str(match self.outcome {
            Outcome::Finished => "",
            Outcome::Stopped => ", stopped by the observer",
            Outcome::Event => ", stopped by an event",
        })
    }
}

/// Makes `steps` steps of size `h`. After step n the time is t₀ + n h, rounded once, however many steps there are.
///
/// `observe` sees the state after each step and may stop there: that is no error.
///
/// ```
/// use lagrangian::integrator::{RungeKutta4, drive};
/// use lagrangian::{EulerLagrange, Lagrangian, Phase};
/// use mechanics_core::scalar::Scalar;
/// use std::ops::ControlFlow;
///
/// struct Oscillator;
/// impl Lagrangian<1> for Oscillator {
///     fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
///         v[0].square().scale(0.5)
///     }
///     fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
///         q[0].square().scale(0.5)
///     }
/// }
///
/// let system = EulerLagrange::new(Oscillator);
/// let mut method = RungeKutta4::new(&system);
/// let mut phase = Phase::new(0.0, [1.0], [0.0]);
/// let mut highest = 0.0_f64;
/// let report = drive::advance(&system, &mut method, &mut phase, 0.01, 100, |phase, _| {
///     highest = highest.max(phase.v[0].abs());
///     ControlFlow::Continue(())
/// })?;
/// assert!((phase.q[0] - 1.0_f64.cos()).abs() < 1e-10);
/// assert!((highest - 1.0_f64.sin()).abs() < 1e-10);
/// assert_eq!(report.to_string(), "100 steps, 400 evaluations");
/// # Ok::<(), lagrangian::LagrangianError>(())
/// ```
///
/// # Errors
/// The first error of a step; `phase` is then as it was before all of them.
pub fn advance<S: System, I: Integrator<S> + ?Sized>(
    system: &S,
    integrator: &mut I,
    phase: &mut Phase<S::Coordinates>,
    h: f64,
    steps: u64,
    mut observe: impl FnMut(&Phase<S::Coordinates>, StepReport) -> ControlFlow<()>,
) -> Result<DriveReport, LagrangianError> {
    let start = phase.clone();
    let mut report = DriveReport::default();
    for n in 1..=steps {
        let work = integrator.step(system, phase, h).inspect_err(|_| *phase = start.clone())?;
        phase.time = start.time + n as f64 * h;
        report.steps = n;
        report.work += work;
        if observe(phase, work).is_break() {
            report.outcome = Outcome::Stopped;
            break;
        }
    }
    Ok(report)
}

/// Moves `phase` to time `end`, exactly, in equal steps: of size `h` if that divides the interval up to rounding, else of the
/// largest smaller size that does.
///
/// # Errors
/// [`LagrangianError::Interval`] if `end` is before the phase's time or not finite; the first error of a step. `phase` is
/// then as it was.
pub fn integrate<S: System, I: Integrator<S> + ?Sized>(
    system: &S,
    integrator: &mut I,
    phase: &mut Phase<S::Coordinates>,
    end: f64,
    h: f64,
) -> Result<DriveReport, LagrangianError> {
    let (steps, h) = divide(phase.time, end, h)?;
    let report = advance(system, integrator, phase, h, steps, |_, _| ControlFlow::Continue(()))?;
    phase.time = end;
    Ok(report)
}

/// Moves `phase` to the last of `times` and records the state at each of them; every interval is divided as
/// [`integrate`] does. The first of `times` may be the phase's own.
///
/// # Errors
/// [`LagrangianError::Interval`] if times decrease, start before the phase's or are not finite; the first error of a step. `phase` is
/// then as it was.
pub fn sample<S: System, I: Integrator<S> + ?Sized>(
    system: &S,
    integrator: &mut I,
    phase: &mut Phase<S::Coordinates>,
    times: &[f64],
    h: f64,
) -> Result<(Trajectory<S::Coordinates>, DriveReport), LagrangianError> {
    let start = phase.clone();
    let mut trajectory = Trajectory::with_capacity(times.len());
    let mut total = DriveReport::default();
    for &time in times {
        let report = integrate(system, integrator, phase, time, h).inspect_err(|_| *phase = start.clone())?;
        total.steps += report.steps;
        total.work += report.work;
        trajectory.push(phase);
    }
    Ok((trajectory, total))
}

/// The number and size of the equal steps from `start` to `end` that are at most `h`.
fn divide(start: f64, end: f64, h: f64) -> Result<(u64, f64), LagrangianError> {
    if !(h > 0.0 && h.is_finite()) {
        return Err(LagrangianError::Step { step: h });
    }
    if !(end >= start && end.is_finite() && start.is_finite()) {
        return Err(LagrangianError::Interval { start, end });
    }
    let length = end - start;
    // What rounding of the two times and of n h can make of a length that h divides.
    let rounding = 2.0 * f64::EPSILON * (start.abs() + end.abs() + length);
    let nearest = (length / h).round();
    let (steps, h) = if (nearest * h - length).abs() <= rounding {
        (nearest, h)
    } else {
        let steps = (length / h).ceil();
        (steps, length / steps)
    };
    if steps > 0.0 && (start + h == start || end - h == end) {
        return Err(LagrangianError::StepTooSmall { time: start, step: h });
    }
    Ok((steps as u64, h))
}
