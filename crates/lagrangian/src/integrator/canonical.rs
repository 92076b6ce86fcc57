//! The state of motion in coordinates and momenta, which implicit methods step in.
//!
//! Between the steps of one motion the momentum is carried over as it is: recomputing it from the velocity would add
//! the rounding of a linear solve to every step. So are the parts of t, q and p that a sum of 1e6 small increments
//! rounds away (compensated summation; Kahan 1965; Hairer, Lubich, Wanner 2006, VIII.5).

use crate::coordinates::{Coordinates, Phase};
use crate::dense::{bound_momentum, factor_mass, solve_factored, solve_mass};
use crate::error::{LagrangianError, Symbol};
use crate::system::{Expansion, System};

/// A state (t, q, p), each number the unevaluated sum of a float and what it lost by rounding.
#[derive(Clone, Debug)]
pub(super) struct Canonical<C> {
    pub time: f64,
    pub time_lost: f64,
    pub q: C,
    pub q_lost: C,
    pub p: C,
    pub p_lost: C,
}

/// A state that an integrator's last step left, as a phase and in momenta.
#[derive(Clone, Debug)]
pub(super) struct Left<C> {
    pub phase: Phase<C>,
    pub canonical: Canonical<C>,
}

impl<C: Coordinates> Left<C> {
    /// Whether a step of size `h` from `phase` continues the one that left this state.
    #[inline]
    pub(super) fn is(&self, phase: &Phase<C>, h: f64) -> bool {
        phase.continues(&self.phase, h)
    }
}

impl<C: Coordinates> Canonical<C> {
    /// The state of `phase`, and q̈ there, by one expansion.
    pub(super) fn of_phase<S: System<Coordinates = C>>(
        system: &S,
        phase: &Phase<C>,
        at: &mut Expansion<C>,
    ) -> Result<(Self, C), LagrangianError> {
        let n = system.dimension();
        system.expand(phase.time, &phase.q, &phase.v, at);
        check_finite(Symbol::Momentum, phase.time, at.momentum.as_ref())?;
        let p = at.momentum.clone();
        let acceleration = acceleration(phase.time, at)?;
        let zeros = || C::zeros(n);
        let canonical = Self {
            time: phase.time,
            time_lost: 0.0,
            q: phase.q.clone(),
            q_lost: zeros(),
            p,
            p_lost: zeros(),
        };
        Ok((canonical, acceleration))
    }

    /// t + h.
    #[inline]
    pub(super) fn advance_time(&mut self, h: f64) {
        (self.time, self.time_lost) = sum_and_loss(self.time, self.time_lost + h);
    }

    /// Adds `increment` to q.
    #[inline]
    pub(super) fn add_to_q(&mut self, increment: &C) {
        add(self.q.as_mut(), self.q_lost.as_mut(), increment.as_ref());
    }

    /// Adds `increment` to p.
    #[inline]
    pub(super) fn add_to_p(&mut self, increment: &C) {
        add(self.p.as_mut(), self.p_lost.as_mut(), increment.as_ref());
    }

    /// Improves the velocity `v` until ∂L/∂v(q, v, t) = p, by Newton's method with M; answers the number of
    /// expansions. `at` is left near (q, v), its mass factored.
    ///
    /// One iteration is exact where T is of second degree in v. Otherwise convergence is quadratic, and a correction
    /// below √ε leaves an error below ε. A component that is nothing but rounding never gets there; then it ends where the
    /// residual is the rounding of its terms.
    pub(super) fn solve_velocity<S: System<Coordinates = C>>(
        &self,
        system: &S,
        v: &mut C,
        at: &mut Expansion<C>,
    ) -> Result<u64, VelocityNotFound> {
        const LIMIT: u64 = 30;
        let (mut residual, mut bounds) = (C::zeros(system.dimension()), C::zeros(system.dimension()));
        let mut size = f64::INFINITY;
        for iteration in 1..=LIMIT {
            system.expand(self.time, &self.q, v, at);
            let r = residual.as_mut();
            for j in 0..r.len() {
                r[j] = self.p.as_ref()[j] - at.momentum.as_ref()[j] + self.p_lost.as_ref()[j];
            }
            factor_mass::<C>(self.time, &mut at.mass, r.len()).map_err(|_| VelocityNotFound(size))?;
            bound_momentum::<C>(&at.mass, v.as_ref(), bounds.as_mut());
            let rounding = |j: usize| 4.0 * f64::EPSILON * (self.p.as_ref()[j].abs() + bounds.as_ref()[j]);
            if iteration > 1 && (0..r.len()).all(|j| r[j].abs() <= rounding(j)) {
                return Ok(iteration);
            }
            solve_factored::<C>(&at.mass, r);
            size = 0.0;
            for (v, d) in v.as_mut().iter_mut().zip(residual.as_ref()) {
                *v += d;
                size = size.max(if *v == 0.0 { 0.0 } else { (d / *v).abs() });
            }
            if size <= 1e-8 {
                return Ok(iteration);
            }
        }
        // A component that is nothing but rounding never settles relative to itself.
        let largest = |x: &C| x.as_ref().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let relative = largest(&residual) / largest(v);
        if relative <= 1e-12 { Ok(LIMIT) } else { Err(VelocityNotFound(relative)) }
    }
}

/// The velocity that belongs to a momentum was not found; the last relative correction.
#[derive(Clone, Copy, Debug)]
pub(super) struct VelocityNotFound(pub f64);

/// q̈ of an expansion, whose mass is factored on the way.
pub(super) fn acceleration<C: Coordinates>(time: f64, at: &mut Expansion<C>) -> Result<C, LagrangianError> {
    let mut acceleration = at.slope.clone();
    let a = acceleration.as_mut();
    for j in 0..a.len() {
        a[j] += at.applied.as_ref()[j] - at.momentum_rate.as_ref()[j];
    }
    check_finite(Symbol::Force, time, acceleration.as_ref())?;
    solve_mass::<C>(time, &mut at.mass, acceleration.as_mut())?;
    Ok(acceleration)
}

/// Refuses a NaN or an infinity.
#[inline]
pub(super) fn check_finite(symbol: Symbol, time: f64, values: &[f64]) -> Result<(), LagrangianError> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(LagrangianError::NonFinite { symbol, index, value: values[index], time }),
        None => Ok(()),
    }
}

/// a + b rounded, and exactly what the rounding took (Møller 1965, Knuth's two-sum).
#[inline]
pub(super) fn sum_and_loss(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

#[inline]
fn add(value: &mut [f64], lost: &mut [f64], increment: &[f64]) {
    for j in 0..value.len() {
        (value[j], lost[j]) = sum_and_loss(value[j], lost[j] + increment[j]);
    }
}
