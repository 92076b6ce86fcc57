//! Compensated sums: what rounding takes from a step is given back to the next.

use crate::coordinates::{Coordinates, Phase};
use crate::error::{LagrangianError, Symbol};

/// The rounding errors of the sums q + Δq and v + Δv of the steps so far, with the state that the last of them left.
///
/// n steps of a plain sum lose O(n ε), or O(√n ε) if errors are random; with the remainder of each sum carried to the next
/// one the loss is O(ε) + O(n h ε), the second part that of the increments themselves.
///
/// # Reference
/// Møller 1965, "Quasi double-precision in floating point addition"; Hairer, Lubich, Wanner 2006, *Geometric Numerical
/// Integration*, section VIII.5. The exact error of a sum: Knuth, *The Art of Computer Programming* 2, section 4.2.2.
#[derive(Clone, Debug)]
pub(super) struct Remainder<C> {
    left: Option<Phase<C>>,
    q: C,
    v: C,
}

/// A rounded sum and what rounding took: `a + b = sum + remainder` exactly.
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let from_b = sum - a;
    (sum, (a - (sum - from_b)) + (b - from_b))
}

/// `base[i] + (remainder[i] + increment[i])` for all i, as sums and remainders, or the index of the first sum that is not finite.
#[inline]
fn add_all<C: Coordinates>(base: &C, remainder: &C, increment: &C) -> Result<(C, C), (usize, f64)> {
    let (mut sums, mut rests) = (base.clone(), remainder.clone());
    for i in 0..base.as_ref().len() {
        let (sum, rest) = two_sum(base.as_ref()[i], remainder.as_ref()[i] + increment.as_ref()[i]);
        if !sum.is_finite() {
            return Err((i, sum));
        }
        sums.as_mut()[i] = sum;
        rests.as_mut()[i] = rest;
    }
    Ok((sums, rests))
}

impl<C: Coordinates> Remainder<C> {
    pub(super) fn new(dimension: usize) -> Self {
        Self { left: None, q: C::zeros(dimension), v: C::zeros(dimension) }
    }

    /// Whether a step of size h from `phase` continues the last one.
    #[inline]
    pub(super) fn continues(&self, phase: &Phase<C>, h: f64) -> bool {
        self.left.as_ref().is_some_and(|left| phase.continues(left, h))
    }

    /// The state that a step (h, Δq, Δv) from `phase` leads to, at time t + h.
    ///
    /// # Errors
    /// [`LagrangianError::NonFinite`].
    #[inline]
    pub(super) fn sum(&self, phase: &Phase<C>, h: f64, dq: &C, dv: &C) -> Result<Sum<C>, LagrangianError> {
        let time = phase.time + h;
        let dimension = dq.as_ref().len();
        let (before_q, before_v) = if self.continues(phase, h) {
            (self.q.clone(), self.v.clone())
        } else {
            (C::zeros(dimension), C::zeros(dimension))
        };
        let refusal =
            |symbol| move |(index, value)| LagrangianError::NonFinite { symbol, index, value, time };
        let (q, q_rest) = add_all(&phase.q, &before_q, dq).map_err(refusal(Symbol::Coordinate))?;
        let (v, v_rest) = add_all(&phase.v, &before_v, dv).map_err(refusal(Symbol::Velocity))?;
        Ok(Sum { phase: Phase { time, q, v }, q_rest, v_rest })
    }

    /// Makes `sum` the state that the last step left, at a time that may differ from t + h by rounding.
    #[inline]
    pub(super) fn keep(&mut self, sum: Sum<C>, time: f64, phase: &mut Phase<C>) {
        (self.q, self.v) = (sum.q_rest, sum.v_rest);
        *phase = sum.phase;
        phase.time = time;
        match &mut self.left {
            Some(left) => left.clone_from(phase),
            None => self.left = Some(phase.clone()),
        }
    }

    /// Makes `phase` the state that the last step left, with nothing lost by rounding.
    pub(super) fn restart(&mut self, phase: &Phase<C>) {
        self.q.as_mut().fill(0.0);
        self.v.as_mut().fill(0.0);
        self.left = Some(phase.clone());
    }

    /// Moves `phase` on by (h, Δq, Δv).
    ///
    /// # Errors
    /// [`LagrangianError::NonFinite`]; nothing has changed then.
    #[inline]
    pub(super) fn add(
        &mut self,
        phase: &mut Phase<C>,
        h: f64,
        dq: &C,
        dv: &C,
    ) -> Result<(), LagrangianError> {
        let sum = self.sum(phase, h, dq, dv)?;
        let time = sum.phase.time;
        self.keep(sum, time, phase);
        Ok(())
    }
}

/// A state and what rounding took from it.
pub(super) struct Sum<C> {
    pub(super) phase: Phase<C>,
    q_rest: C,
    v_rest: C,
}
