//! What a step hands to the next.

use crate::constraint::compliance::{Compliance, copy_rows};
use crate::constraint::{ConstraintSet, Rows};
use crate::coordinates::{Coordinates, Phase};

/// One step of order 2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Substep {
    /// Its size, negative in compositions \[s\].
    pub(super) h: f64,
    /// The time at its end \[s\].
    pub(super) end: f64,
}

/// A state of motion with all that is known there.
#[derive(Clone, Debug)]
pub(super) struct Track<C: ConstraintSet> {
    pub(super) phase: Phase<C::Coordinates>,
    /// What rounding has taken from q and v.
    pub(super) q_low: C::Coordinates,
    pub(super) v_low: C::Coordinates,
    /// ∂L/∂q here (separable form).
    pub(super) force: C::Coordinates,
    /// An estimate of q̈ (general form).
    pub(super) acceleration: C::Coordinates,
    /// G here.
    pub(super) jacobian: C::Jacobian,
    /// M⁻¹ ∇φₖ in row k (separable form).
    pub(super) response: C::Jacobian,
    /// λ⁺ of the last three steps, the latest first.
    pub(super) first: [C::Multipliers; 3],
    /// λ⁻ of the last step, or λ at a fresh start.
    pub(super) last: C::Multipliers,
    /// The size of the last step, and how many before it had the same.
    size: f64,
    even: u32,
}

impl<C: ConstraintSet> Track<C> {
    pub(super) fn new(
        constraints: &C,
        phase: &Phase<C::Coordinates>,
        acceleration: C::Coordinates,
        multipliers: C::Multipliers,
    ) -> Self {
        let (n, count) = constraints.shape();
        Self {
            phase: phase.clone(),
            q_low: C::Coordinates::zeros(n),
            v_low: C::Coordinates::zeros(n),
            force: C::Coordinates::zeros(n),
            acceleration,
            jacobian: C::Jacobian::zeros(count, n),
            response: C::Jacobian::zeros(count, n),
            first: std::array::from_fn(|_| C::Multipliers::zeros(count)),
            last: multipliers,
            size: 0.0,
            even: 0,
        }
    }

    /// As `clone_from`, without new memory; of G and of the responses the rows' parts that may differ from zero.
    #[inline]
    pub(super) fn copy_from(&mut self, other: &Self, constraints: &C, compliance: &Compliance<C>) {
        let n = constraints.dimension();
        copy_rows::<C>(&other.jacobian, &mut self.jacobian, |k| constraints.support(k), n);
        copy_rows::<C>(&other.response, &mut self.response, |k| compliance.reach(k, n), n);
        self.phase.time = other.phase.time;
        self.phase.q.clone_from(&other.phase.q);
        self.phase.v.clone_from(&other.phase.v);
        self.q_low.clone_from(&other.q_low);
        self.v_low.clone_from(&other.v_low);
        self.force.clone_from(&other.force);
        self.acceleration.clone_from(&other.acceleration);
        for (mine, others) in self.first.iter_mut().zip(&other.first) {
            mine.clone_from(others);
        }
        self.last.clone_from(&other.last);
        (self.size, self.even) = (other.size, other.even);
    }

    /// h/2 times a guess of λ⁺ of the next step: extrapolated through the last three steps if they have its size (off
    /// by O(h³), so that one iteration is enough), else λ⁻ of the last one (off by O(h)).
    #[inline]
    pub(super) fn guess_impulse(&self, h: f64, impulse: &mut [f64]) {
        let [a, b, c] = &self.first;
        for (k, impulse) in impulse.iter_mut().enumerate() {
            let ahead = 3.0 * (a.as_ref()[k] - b.as_ref()[k]) + c.as_ref()[k];
            let even = self.even >= 2 && self.size == h;
            *impulse = 0.5 * h * if even { ahead } else { self.last.as_ref()[k] };
        }
    }

    /// Notes the impulses h/2 λ⁺ and h/2 λ⁻ of a step that is done, and where it ended.
    #[inline]
    pub(super) fn note(&mut self, step: Substep, first: &[f64], last: &[f64]) {
        let per_impulse = 2.0 / step.h;
        self.first.rotate_right(1);
        for k in 0..first.len() {
            self.first[0].as_mut()[k] = first[k] * per_impulse;
            self.last.as_mut()[k] = last[k] * per_impulse;
        }
        self.even = if self.size == step.h { self.even.saturating_add(1) } else { 0 };
        self.size = step.h;
        self.phase.time = step.end;
    }
}

/// x + d as a rounded sum and what the rounding took.
///
/// # Reference
/// Knuth, *The Art of Computer Programming* 2, 4.2.2, theorem B.
#[inline]
pub(super) fn sum_exactly(x: f64, d: f64) -> (f64, f64) {
    let sum = x + d;
    let part = sum - x;
    (sum, (x - (sum - part)) + (d - part))
}
