//! When to stop the iteration inside an implicit step.
//!
//! An iteration that stops at a tolerance leaves an error that has a sign, and over 1e6 steps the energy drifts. So it
//! goes on until its corrections are rounding: until the *next* one, by the contraction observed, is below a tenth of
//! ε, or until they no longer fall (Hairer, Lubich, Wanner 2006, VIII.6; Hairer, McLachlan, Razakarivony 2008).

/// How large a correction of the unknown velocities is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Correction {
    /// The largest over the coordinates, each relative to its own velocity.
    pub strict: f64,
    /// In the norm of the kinetic energy, √(ΔᵀMΔ / Σ|v p|): does not see a coordinate that hardly moves.
    pub energetic: f64,
    /// The largest h|Δⱼ|/|qⱼ|.
    pub positional: f64,
}

/// What to do after a correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Iterate again.
    Continue,
    /// Solved to rounding.
    Converged,
    /// Not getting there, or not fast enough.
    Failing,
}

/// Follows the corrections of one iteration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Convergence {
    pub iterations: u32,
    /// Last correction over the one before.
    pub rate: f64,
    last: Correction,
    stalls: u32,
    limit: u32,
}

/// Corrections that no longer fall are rounding if they are this small in the norm of the kinetic energy…
const ROUNDING: f64 = 32.0 * f64::EPSILON;
/// … and if they have stalled several times, this small: with an ill-conditioned mass matrix rounding is larger.
pub(super) const TOLERANCE: f64 = 1e-10;

impl Convergence {
    /// Starts with the contraction that the last step ended with, or 1 if there was none.
    pub(super) fn new(rate: f64, limit: u32) -> Self {
        let last = Correction { strict: f64::INFINITY, energetic: f64::INFINITY, positional: f64::INFINITY };
        Self { iterations: 0, rate, last, stalls: 0, limit }
    }

    /// Judges the next correction.
    #[inline]
    pub(super) fn judge(&mut self, now: Correction) -> Verdict {
        self.iterations += 1;
        if self.iterations > 1 {
            self.rate = now.strict / self.last.strict;
        }
        let last = std::mem::replace(&mut self.last, now);
        if now.strict == 0.0 || (now.strict <= 1e-9 && self.rate * now.strict <= 0.1 * f64::EPSILON) {
            return Verdict::Converged;
        }
        self.judge_slow(now, last)
    }

    fn judge_slow(&mut self, now: Correction, last: Correction) -> Verdict {
        if !now.strict.is_finite() || !now.energetic.is_finite() {
            return Verdict::Failing;
        }
        if self.iterations > 1 && now.strict >= last.strict {
            self.stalls += 1;
            let size = now.energetic.min(0.1 * now.positional);
            if size <= ROUNDING || (self.stalls >= 3 && size <= TOLERANCE) {
                return Verdict::Converged;
            }
        }
        let hopeless = self.iterations > 1 && now.energetic > 100.0 && now.energetic > 2.0 * last.energetic;
        let slow = self.iterations >= 5 && now.energetic > 0.5 * last.energetic && now.energetic > TOLERANCE;
        if hopeless || slow || self.iterations >= self.limit { Verdict::Failing } else { Verdict::Continue }
    }

    /// The last correction, for messages.
    pub(super) fn correction(&self) -> f64 {
        self.last.energetic
    }
}
