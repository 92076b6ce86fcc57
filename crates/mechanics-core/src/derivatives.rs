//! Checking hand-written derivatives against finite differences.
//!
//! For a function `φ` along a line the central difference `(φ(ε) − φ(−ε)) / 2ε` is off by `ε² φ'''/6` (truncation)
//! and by about `δ/ε` (rounding, `δ` the rounding of `φ`). Nobody knows `φ'''` and `δ` beforehand, so the step is
//! swept over decades, each difference is refined once by Richardson extrapolation, `(4 D(ε/2) − D(ε)) / 3`, whose
//! truncation is of order `ε⁴`, and the step is taken where two neighbouring extrapolations agree best, the rounding of
//! the values over the step counted as disagreement: truncation grows to the one side of that plateau, rounding to
//! the other.
//!
//! Gradients are compared with differences of values, Hessians with differences of gradients. Errors are relative
//! to the largest entry of the same gradient, or of the same column of the Hessian, so that entries that are zero by
//! symmetry do not count their rounding as an error, while a wrong entry of ordinary size is seen. A difference that rounding alone explains is no error, so that a rest
//! state, where the whole gradient vanishes, passes.
//!
//! ```
//! use mechanics_core::derivatives::check_gradient;
//!
//! let value = |x: &[f64]| x[0].powi(2) * x[1];
//! let check = check_gradient(&[3.0, 2.0], value, |x, g| {
//!     g[0] = 2.0 * x[0] * x[1];
//!     g[1] = x[0]; // should be x²
//! });
//! assert_eq!(check.worst.row, 1);
//! assert!(check.require(1e-7).is_err());
//! ```

mod difference;
mod seams;

pub use seams::{
    StencilCheck, check_objective_direction, check_objective_gradient, check_potential_gradient,
    check_potential_hessian, check_stencil,
};

use difference::{Difference, differentiate};

/// One compared entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The entry of a gradient, or the row of a Hessian.
    pub row: usize,
    /// The unknown that was varied: the column of a Hessian, for a gradient the same as `row`.
    pub column: usize,
    /// What the hand-written derivative says.
    pub analytic: f64,
    /// What finite differences say.
    pub numeric: f64,
    /// Their difference, relative to the largest entry of the gradient or column.
    pub error: f64,
    /// The step of the finite difference.
    pub step: f64,
}

/// The outcome of a check: the worst entry of all.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub struct DerivativeCheck {
    /// Which derivative.
    pub derivative: Derivative,
    /// The entry with the largest error.
    pub worst: Entry,
    /// The largest |Hᵢⱼ − Hⱼᵢ| relative to the largest entry; zero for gradients.
    pub asymmetry: f64,
}

/// Which derivative was checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivative {
    /// The gradient, against the value.
    Gradient,
    /// The Hessian, against the gradient.
    Hessian,
    /// A Newton direction `p`: the change of the gradient along it is `−g`.
    Direction,
}

/// A derivative that is wrong.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DerivativeError {
    /// An entry differs from its finite difference.
    #[error(
        "{derivative:?} entry ({}, {}) is {:e} but finite differences with step {:e} give {:e}: relative error {:e}, \
         allowed {allowed:e}",
        .entry.row, .entry.column, .entry.analytic, .entry.step, .entry.numeric, .entry.error
    )]
    Wrong {
        /// Which derivative.
        derivative: Derivative,
        /// The worst entry.
        entry: Entry,
        /// What was allowed.
        allowed: f64,
    },
    /// A Hessian is not symmetric.
    #[error("the Hessian is not symmetric: relative difference {asymmetry:e}, allowed {allowed:e}")]
    Asymmetric {
        /// The largest relative difference.
        asymmetry: f64,
        /// What was allowed.
        allowed: f64,
    },
}

impl DerivativeCheck {
    /// Asks that every relative error be at most `allowed`. Right derivatives of smooth functions of ordinary size
    /// pass at 1e-8; a NaN never passes.
    ///
    /// # Errors
    /// The worst entry, or the lack of symmetry.
    pub fn require(&self, allowed: f64) -> Result<(), DerivativeError> {
        let &Self { derivative, worst, asymmetry } = self;
        if worst.error.is_nan() || worst.error > allowed {
            return Err(DerivativeError::Wrong { derivative, entry: worst, allowed });
        }
        if asymmetry.is_nan() || asymmetry > allowed {
            return Err(DerivativeError::Asymmetric { asymmetry, allowed });
        }
        Ok(())
    }
}

/// Compares a gradient with differences of the value, at `x`.
///
/// `gradient(x, g)` overwrites `g`.
///
/// # Panics
/// If `x` is empty.
pub fn check_gradient(
    x: &[f64],
    mut value: impl FnMut(&[f64]) -> f64,
    mut gradient: impl FnMut(&[f64], &mut [f64]),
) -> DerivativeCheck {
    assert!(!x.is_empty(), "nothing to vary");
    let mut analytic = vec![0.0; x.len()];
    gradient(x, &mut analytic);
    let mut moved = x.to_vec();
    let entries: Vec<(Entry, f64)> = (0..x.len())
        .map(|column| {
            let Difference { derivative: numeric, step, noise } = differentiate(unit(x), 1, |offset, out| {
                moved[column] = x[column] + offset;
                out[0] = value(&moved);
                moved[column] = x[column];
            });
            let analytic = analytic[column];
            (Entry { row: column, column, analytic, numeric: numeric[0], error: 0.0, step }, noise)
        })
        .collect();
    let worst = worst(relative(entries));
    DerivativeCheck { derivative: Derivative::Gradient, worst, asymmetry: 0.0 }
}

/// Compares a Hessian with differences of the gradient, at `x`.
///
/// `gradient(x, g)` overwrites `g`; `hessian(i, j)` is the entry at `x`, asked for once for every entry.
///
/// # Panics
/// If `x` is empty.
pub fn check_hessian(
    x: &[f64],
    mut gradient: impl FnMut(&[f64], &mut [f64]),
    hessian: impl Fn(usize, usize) -> f64,
) -> DerivativeCheck {
    assert!(!x.is_empty(), "nothing to vary");
    let n = x.len();
    let mut moved = x.to_vec();
    let mut worst_of_columns = Vec::with_capacity(n);
    let (mut largest, mut difference) = (0.0_f64, 0.0_f64);
    for column in 0..n {
        let Difference { derivative: numeric, step, noise } = differentiate(unit(x), n, |offset, out| {
            moved[column] = x[column] + offset;
            gradient(&moved, out);
            moved[column] = x[column];
        });
        let entry = |row: usize| Entry {
            row,
            column,
            analytic: hessian(row, column),
            numeric: numeric[row],
            error: 0.0,
            step,
        };
        let entries: Vec<Entry> = (0..n).map(entry).collect();
        for entry in &entries[column..] {
            largest = largest.max(entry.analytic.abs());
            difference = difference.max((entry.analytic - hessian(column, entry.row)).abs());
        }
        worst_of_columns.push(worst(relative(entries.into_iter().map(|entry| (entry, noise)).collect())));
    }
    let asymmetry = if largest > 0.0 { difference / largest } else { difference };
    DerivativeCheck { derivative: Derivative::Hessian, worst: worst(worst_of_columns), asymmetry }
}

/// The scale that steps are relative to.
fn unit(x: &[f64]) -> f64 {
    let size = crate::objective::largest(x);
    if size > 0.0 && size.is_finite() { size } else { 1.0 }
}

/// Fills in the errors, relative to the largest entry of all; what is within its rounding noise is none.
fn relative(entries: Vec<(Entry, f64)>) -> Vec<Entry> {
    let size = |entry: &Entry| entry.analytic.abs().max(entry.numeric.abs());
    let largest = entries.iter().fold(0.0, |m: f64, (entry, _)| m.max(size(entry)));
    let filled = entries.into_iter().map(|(entry, noise)| {
        let difference = (entry.analytic - entry.numeric).abs();
        let error = if difference <= noise { 0.0 } else { difference / largest };
        Entry { error, ..entry }
    });
    filled.collect()
}

fn worst(entries: Vec<Entry>) -> Entry {
    let badness = |entry: &Entry| if entry.error.is_nan() { f64::INFINITY } else { entry.error };
    let mut entries = entries.into_iter();
    let Some(first) = entries.next() else { unreachable!("at least one unknown was varied") };
    entries.fold(first, |worst, entry| if badness(&entry) > badness(&worst) { entry } else { worst })
}
