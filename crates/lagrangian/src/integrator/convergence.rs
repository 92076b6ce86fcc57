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
    /// In the norm of the kinetic energy, √(w / (w + Σ|v p|)) with w = ΔᵀMΔ: does not see a coordinate that hardly moves.
    pub energetic: f64,
    /// w = ΔᵀMΔ \[J\].
    pub work: f64,
    /// The largest over the coordinates, each relative to what its rounding grows with: the velocities |vⱼ| at hand and
    /// at the start of the step, and |qⱼ|/h, which moves a position by its rounding. Unlike `strict`, this keeps its scale
    /// where a velocity, or a coordinate, passes through zero.
    pub noise: f64,
}

/// Whose corrections these are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Iteration {
    /// A contraction, as fast as the step is short. It may stand still without being near the solution.
    Simple,
    /// Newton's: where it stands still, and is near, it is at rounding.
    Newton,
}

/// What to do after a correction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Iterate again.
    Continue,
    /// Iterate again, unless every residual is at the rounding of its own terms.
    Stalled,
    /// Solved to rounding.
    Converged,
    /// Not getting there, or not fast enough.
    Failing,
}

/// Follows the corrections of one iteration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Convergence {
    pub iterations: u32,
    /// The largest contraction seen in this step before rounding, or what earlier steps saw.
    pub rate: f64,
    observed: f64,
    last: Correction,
    /// ΔᵀMΔ of the first correction.
    first: f64,
    stalls: u32,
    iteration: Iteration,
    /// Iterations before slowness is held against it.
    patience: u32,
    limit: u32,
}

/// The next correction may be this part of ε.
const LEFT: f64 = 0.01;
/// Relative corrections above this are not rounding.
const NOISE: f64 = 1e-13;
/// Corrections that no longer fall are rounding if each is this small on its own coordinate's scale…
pub(super) const ROUNDING: f64 = 32.0 * f64::EPSILON;
/// … and, of Newton's method, if they have stalled several times, this small in the norm of the kinetic energy: with an
/// ill-conditioned mass matrix rounding is larger. (Of a simple iteration the same may be a stiff coordinate that is
/// nearly at rest, and just begins to run away.)
pub(super) const TOLERANCE: f64 = 1e-10;

/// On what scale a correction of a velocity is rounding, from the velocities at hand and at the start of the step, and the
/// position. Nothing is told apart among numbers that underflow.
#[inline]
pub(super) fn noise_scale(velocity: f64, start_velocity: f64, position: f64, h: f64) -> f64 {
    let underflow = f64::MIN_POSITIVE / f64::EPSILON;
    velocity.abs().max(start_velocity.abs()) + position.abs() / h + underflow
}

impl Convergence {
    /// Starts with the contraction that the last step ended with, or 1 if there was none; fails if it is slow after
    /// `patience` iterations, or not done after `limit`.
    pub(super) fn new(iteration: Iteration, rate: f64, patience: u32, limit: u32) -> Self {
        let never = f64::INFINITY;
        let last = Correction { strict: never, energetic: never, work: never, noise: never };
        Self { iterations: 0, rate, observed: 0.0, last, first: 0.0, stalls: 0, iteration, patience, limit }
    }

    /// Judges the next correction.
    #[inline]
    pub(super) fn judge(&mut self, now: Correction) -> Verdict {
        self.iterations += 1;
        if self.iterations > 1 {
            self.observe(now.strict / self.last.strict);
        }
        let last = std::mem::replace(&mut self.last, now);
        if now.strict == 0.0 || (now.strict <= 1e-9 && self.rate * now.strict <= LEFT * f64::EPSILON) {
            return Verdict::Converged;
        }
        self.judge_slow(now, last)
    }

    /// The contraction differs between directions, and the first ratio may be a lucky one: so what earlier steps saw is
    /// forgotten only slowly, and ratios of rounding errors say nothing.
    #[inline]
    fn observe(&mut self, ratio: f64) {
        if self.last.strict > NOISE {
            self.observed = self.observed.max(ratio.min(1.0));
            self.rate = self.observed.max(if self.rate < 1.0 { 0.7 * self.rate } else { 0.0 });
        }
    }

    fn judge_slow(&mut self, now: Correction, last: Correction) -> Verdict {
        if now.strict.is_nan() || !now.work.is_finite() {
            return Verdict::Failing;
        }
        // Newton's method without quadratic convergence solves for what rounding of the position has made of the forces.
        let expected = if self.iteration == Iteration::Newton { 0.1 } else { 0.9 };
        if self.iterations > 1 && now.noise <= ROUNDING && now.strict >= expected * last.strict {
            return Verdict::Converged;
        }
        // A constant correction of some ulps makes the relative one creep.
        if self.iterations > 1 && now.strict >= 0.9 * last.strict {
            self.stalls += 1;
            if self.stalls >= 3 && now.energetic <= TOLERANCE {
                return match self.iteration {
                    Iteration::Simple => Verdict::Failing,
                    Iteration::Newton => Verdict::Converged,
                };
            }
        }
        let stalled = self.iterations > 1 && now.strict >= 0.9 * last.strict;
        if stalled && self.iteration == Iteration::Simple && now.energetic <= ROUNDING {
            return Verdict::Stalled;
        }
        if self.iterations == 1 {
            self.first = now.work;
        }
        let hopeless = now.work > 1e6 * self.first && now.work > last.work;
        let slow = self.iterations >= self.patience
            && now.energetic > TOLERANCE
            && now.energetic > 0.5 * last.energetic;
        if hopeless || slow || self.iterations >= self.limit { Verdict::Failing } else { Verdict::Continue }
    }

    /// Whether the last correction is so small that residuals before and after it may differ by rounding alone.
    pub(super) fn is_near_rounding(&self) -> bool {
        self.last.energetic <= 1e-6 || self.last.noise <= 1e-10
    }

    /// The last correction, for messages.
    pub(super) fn correction(&self) -> f64 {
        self.last.energetic
    }
}
