//! Step-size control: how large the next step should be.

use crate::error::LagrangianError;

/// How large the error of one step may be: in every coordinate and velocity, `absolute` plus `relative` times its magnitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Relative to the number's magnitude.
    pub relative: f64,
    /// In the number's own unit: for coordinates and velocities alike.
    pub absolute: f64,
}

impl Tolerance {
    /// The same number for both.
    pub fn uniform(tolerance: f64) -> Self {
        Self { relative: tolerance, absolute: tolerance }
    }

    /// Refuses what no step can meet.
    ///
    /// # Errors
    /// [`LagrangianError::Tolerance`] if a number is negative or not finite, or both are zero.
    pub fn validate(self) -> Result<Self, LagrangianError> {
        let Self { relative, absolute } = self;
        let valid = |x: f64| x >= 0.0 && x.is_finite();
        if valid(relative) && valid(absolute) && relative.max(absolute) > 0.0 {
            Ok(self)
        } else {
            Err(LagrangianError::Tolerance { relative, absolute })
        }
    }

    /// The error allowed where a number goes from `before` to `after`.
    #[inline]
    pub(super) fn scale(self, before: f64, after: f64) -> f64 {
        self.absolute + self.relative * before.abs().max(after.abs())
    }
}

/// A proportional–integral controller: with the error e ≤ 1 of a step accepted and e₀ that of the step before,
///
/// ```text
/// h' = h · clamp(0.9 e^(−(1/8 − 0.75 β)) e₀^β, 1/3, 6),   β = 0.02
/// ```
///
/// A step refused shrinks by 0.9 e^(−1/8), by no more than a factor of three, and the one after it does not grow.
///
/// # Reference
/// Gustafsson 1991, "Control theoretic techniques for stepsize selection in explicit Runge–Kutta methods"; Hairer,
/// Wanner 1996, *Solving Ordinary Differential Equations II*, section IV.2, eq. (2.43c).
#[derive(Clone, Copy, Debug)]
pub(super) struct Controller {
    /// e₀ᵝ.
    before: f64,
    /// The largest factor that the next accepted step may take.
    largest: f64,
}

const SAFETY: f64 = 0.9;
const LARGEST: f64 = 6.0;
const SMALLEST: f64 = 1.0 / 3.0;
const BETA: f64 = 0.02;
const EXPONENT: f64 = 1.0 / 8.0;

impl Default for Controller {
    fn default() -> Self {
        Self { before: 1e-4_f64.powf(BETA), largest: LARGEST }
    }
}

impl Controller {
    /// The factor by which the step after one accepted with `error` is larger.
    #[inline]
    pub(super) fn accept(&mut self, error: f64) -> f64 {
        let logarithm = error.max(1e-30).ln();
        let proportional = ((0.75 * BETA - EXPONENT) * logarithm).exp();
        let factor = (SAFETY * proportional * self.before).clamp(SMALLEST, self.largest);
        self.before = (BETA * logarithm.max(1e-4_f64.ln())).exp();
        self.largest = LARGEST;
        factor
    }

    /// The factor by which to try again after a step refused with `error`, which may be infinite or NaN.
    pub(super) fn refuse(&mut self, error: f64) -> f64 {
        self.largest = 1.0;
        if error.is_finite() { (SAFETY * error.powf(-EXPONENT)).max(SMALLEST) } else { 0.1 }
    }
}
