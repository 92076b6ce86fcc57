//! How well a trajectory keeps invariants.

use super::Invariant;
use crate::coordinates::Phase;
use crate::error::{LagrangianError, Symbol};
use crate::system::System;
use std::fmt;

/// Fewer states than this are too few: two for each tenth of the time.
pub const FEWEST_SAMPLES: usize = 20;

/// What became of an invariant along a trajectory; Δ is its value minus the first one.
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    /// The invariant's name.
    pub name: String,
    /// The value at the start.
    pub initial: f64,
    /// The largest |Δ|.
    pub largest: f64,
    /// The largest |Δ| over |initial|; none if that is zero.
    pub relative: Option<f64>,
    /// The slope of Δ in time, a second: the least-squares line through the means of the ten tenths.
    pub slope: f64,
    /// The standard error of the slope, from the scatter of the ten means about the line (8 degrees of freedom).
    ///
    /// States that follow each other are not independent, so the textbook formula over all of them would be far too
    /// small; means over many oscillations are (the method of batch means).
    pub slope_error: f64,
    /// The largest |Δ| in the first tenth of the states.
    pub first_tenth: f64,
    /// The largest |Δ| in the last tenth.
    pub last_tenth: f64,
    /// What it amounts to.
    pub verdict: Verdict,
}

/// What a drift amounts to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Not more than rounding: 16 ε √n times the size of the invariant's terms, for n states.
    Noise,
    /// It oscillates without getting worse.
    Bounded,
    /// It gets worse: the slope is above five standard errors and makes out a twentieth of the largest |Δ| or more,
    /// or the last tenth is worse than 1.5 times the worst of the first half (2 for a straight line). Trajectories
    /// shorter than two of their slowest oscillations may look so.
    Drifting,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Noise => "noise",
            Self::Bounded => "bounded",
            Self::Drifting => "drifting",
        })
    }
}

/// What became of several invariants along one trajectory. Displays as a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// The first time \[s\].
    pub start: f64,
    /// The last time \[s\].
    pub end: f64,
    /// The number of states.
    pub samples: usize,
    /// One for each invariant.
    pub drifts: Vec<Drift>,
}

/// Follows invariants along a trajectory.
///
/// # Errors
/// [`LagrangianError::FewSamples`] for less than [`FEWEST_SAMPLES`] states; [`LagrangianError::NonFinite`],
/// [`LagrangianError::Unordered`].
pub fn diagnose<S: System>(
    system: &S,
    trajectory: &[Phase<S::Coordinates>],
    invariants: &[Box<dyn Invariant<S>>],
) -> Result<Diagnosis, LagrangianError> {
    let samples = trajectory.len();
    if samples < FEWEST_SAMPLES {
        return Err(LagrangianError::FewSamples { samples, needed: FEWEST_SAMPLES });
    }
    trajectory.iter().try_for_each(Phase::validate)?;
    if let Some(before) = trajectory.windows(2).position(|pair| pair[1].time <= pair[0].time) {
        let (index, time) = (before + 1, trajectory[before + 1].time);
        return Err(LagrangianError::Unordered { index, time, before: trajectory[before].time });
    }
    let times: Vec<f64> = trajectory.iter().map(|phase| phase.time).collect();
    let follow = |(index, invariant): (usize, &dyn Invariant<S>)| {
        let mut values = Vec::with_capacity(samples);
        let mut size = 0.0f64;
        for phase in trajectory {
            let measured = invariant.measure(system, phase);
            if !measured.value.is_finite() {
                let (symbol, value) = (Symbol::Invariant, measured.value);
                return Err(LagrangianError::NonFinite { symbol, index, value, time: phase.time });
            }
            values.push(measured.value);
            size = size.max(measured.size);
        }
        Ok(drift(invariant.name(), &times, &values, size))
    };
    Ok(Diagnosis {
        start: times[0],
        end: times[samples - 1],
        samples,
        drifts: invariants.iter().map(AsRef::as_ref).enumerate().map(follow).collect::<Result<_, _>>()?,
    })
}

fn drift(name: String, times: &[f64], values: &[f64], size: f64) -> Drift {
    let n = values.len();
    let initial = values[0];
    let changes: Vec<f64> = values.iter().map(|value| value - initial).collect();
    let worst = |part: &[f64]| part.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let largest = worst(&changes);
    let (first_tenth, last_tenth) =
        (worst(&changes[..n.div_ceil(10)]), worst(&changes[n - n.div_ceil(10)..]));
    let (slope, slope_error) = line(times, &changes);
    let trend = slope.abs() * (times[n - 1] - times[0]);
    let significant = slope.abs() > 5.0 * slope_error && trend > 0.05 * largest;
    let verdict = if largest <= 16.0 * f64::EPSILON * size * (n as f64).sqrt() {
        Verdict::Noise
    } else if significant || last_tenth > 1.5 * worst(&changes[..n.div_ceil(2)]) {
        Verdict::Drifting
    } else {
        Verdict::Bounded
    };
    let relative = (initial != 0.0).then(|| largest / initial.abs());
    Drift { name, initial, largest, relative, slope, slope_error, first_tenth, last_tenth, verdict }
}

/// Slope and its standard error of the least-squares line through the means of ten parts of equal numbers.
fn line(times: &[f64], changes: &[f64]) -> (f64, f64) {
    let part = |k: usize| k * times.len() / 10..(k + 1) * times.len() / 10;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let points: [(f64, f64); 10] = std::array::from_fn(|k| (mean(&times[part(k)]), mean(&changes[part(k)])));
    let middle = points.iter().map(|p| p.0).sum::<f64>() / 10.0;
    let height = points.iter().map(|p| p.1).sum::<f64>() / 10.0;
    let spread: f64 = points.iter().map(|p| (p.0 - middle).powi(2)).sum();
    let slope = points.iter().map(|p| (p.0 - middle) * (p.1 - height)).sum::<f64>() / spread;
    let scatter: f64 = points.iter().map(|p| (p.1 - height - slope * (p.0 - middle)).powi(2)).sum();
    (slope, (scatter / 8.0 / spread).sqrt())
}

impl fmt::Display for Diagnosis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { start, end, samples, drifts } = self;
        writeln!(f, "{samples} states from t = {start} s to {end} s")?;
        let width = drifts.iter().map(|drift| drift.name.chars().count()).max().unwrap_or(0).max(9);
        writeln!(
            f,
            "{:width$}  {:>16}  {:>9}  {:>9}  {:>10} ± {:<9}  {:>11}  {:>10}  verdict",
            "quantity", "initial", "max |Δ|", "relative", "slope /s", "error", "first tenth", "last tenth"
        )?;
        for drift in drifts {
            let relative = drift.relative.map_or_else(|| "-".to_owned(), |r| format!("{r:.2e}"));
            writeln!(
                f,
                "{:width$}  {:>16.9e}  {:>9.2e}  {relative:>9}  {:>10.2e} ± {:<9.2e}  {:>11.2e}  {:>10.2e}  {}",
                drift.name,
                drift.initial,
                drift.largest,
                drift.slope,
                drift.slope_error,
                drift.first_tenth,
                drift.last_tenth,
                drift.verdict
            )?;
        }
        Ok(())
    }
}
