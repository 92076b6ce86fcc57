//! Dormand and Prince's method of order 8 with step-size control.

mod adaptive;
mod coefficients;
mod control;
mod dense_output;
#[cfg(test)]
mod tests;

pub use adaptive::AdaptiveReport;
pub use control::Tolerance;
pub use dense_output::{DenseStep, DenseTrajectory};

use super::remainder::Remainder;
use super::{Cost, Integrator, Method, StepReport, Structure, admit, assert_sizes};
use crate::coordinates::{Coordinates, Phase};
use crate::error::LagrangianError;
use crate::system::System;
use coefficients::{self as tableau, Row};
use control::Controller;

/// The explicit Runge–Kutta method of order 8 with estimates of orders 5 and 3 and dense output of order 7
/// (DOP853), for q̇ = v, v̇ = a(t, q, v).
///
/// As an [`Integrator`] it makes steps of the size it is given, with 12 evaluations each. Its own
/// [`integrate`](Self::integrate), [`sample`](Self::sample), [`dense`](Self::dense) and [`locate`](Self::locate) choose the step size to
/// meet a [`Tolerance`].
///
/// **Second-order form.** A stage is V_i = v + h Σ a_ij A_j, Q_i = q + h Σ a_ij V_j with A_j = a(t + c_j h, Q_j, V_j). Inserting the first
/// into the second gives Q_i = q + c_i h v + h² Σ ā_ij A_j with ā = a·a: the same method, but its sums add small numbers to q
/// rather than velocities, and many ā vanish. The sums are taken over the differences A_j − A_1, which are smaller still, and
/// increments go to the state by compensated sums, so that errors of 1e-14 can be reached.
///
/// **Error estimate.** With e₅ and e₃ the differences to the embedded solutions, in units of the tolerance, root mean square
/// over coordinates and velocities: error = e₅² / √(e₅² + 0.01 e₃²), which falls like h⁸.
///
/// # Reference
/// Hairer, Nørsett, Wanner 1993, *Solving Ordinary Differential Equations I*, section II.10; the second-order
/// form: section II.14.
#[derive(Clone, Debug)]
pub struct DormandPrince853<C> {
    tolerance: Tolerance,
    step_limit: u64,
    largest_step: f64,
    remainder: Remainder<C>,
    controller: Controller,
    /// The size of step to try next from the state that the last step left.
    suggested: Option<f64>,
    /// A_1, then A_2 − A_1 … A_16 − A_1.
    a: [C; 16],
    /// The acceleration at the end of the step.
    a_end: C,
    /// V_1 … V_16.
    velocities: [C; 16],
    /// A stage's coordinates.
    q: C,
    /// The step's increments.
    dq: C,
    dv: C,
}

impl<C: Coordinates> DormandPrince853<C> {
    /// The method with a tolerance of 1e-10, relative and absolute, and room for the coordinates of `system`.
    pub fn new<S: System<Coordinates = C>>(system: &S) -> Self {
        let n = system.dimension();
        let stages = || std::array::from_fn(|_| C::zeros(n));
        Self {
            tolerance: Tolerance::uniform(1e-10),
            step_limit: 10_000_000,
            largest_step: f64::INFINITY,
            remainder: Remainder::new(n),
            controller: Controller::default(),
            suggested: None,
            a: stages(),
            a_end: C::zeros(n),
            velocities: stages(),
            q: C::zeros(n),
            dq: C::zeros(n),
            dv: C::zeros(n),
        }
    }

    /// The same with another tolerance.
    ///
    /// # Errors
    /// As [`Tolerance::validate`].
    pub fn with_tolerance(mut self, tolerance: Tolerance) -> Result<Self, LagrangianError> {
        self.tolerance = tolerance.validate()?;
        Ok(self)
    }

    /// The same with another limit on the steps, accepted or not, of one integration (default: ten million).
    pub fn with_step_limit(mut self, steps: u64) -> Self {
        self.step_limit = steps;
        self
    }

    /// The same with steps of at most `h` \[s\], for forces that the tolerance alone would jump over.
    ///
    /// # Errors
    /// [`LagrangianError::Step`] if `h` is not positive.
    pub fn with_largest_step(mut self, h: f64) -> Result<Self, LagrangianError> {
        if h.is_nan() || h <= 0.0 {
            return Err(LagrangianError::Step { step: h });
        }
        self.largest_step = h;
        Ok(self)
    }

    /// Evaluates stage `index`.
    #[inline(always)]
    fn stage<S: System<Coordinates = C>, const V: usize, const P: usize>(
        &mut self,
        system: &S,
        phase: &Phase<C>,
        h: f64,
        index: usize,
        row: &Row<V, P>,
    ) -> Result<(), LagrangianError> {
        let drift = row.node * h;
        for i in 0..self.q.as_ref().len() {
            let v = phase.v.as_ref()[i];
            let (dq, dv) = self.increment(v, h, row, i);
            self.q.as_mut()[i] = phase.q.as_ref()[i] + dq;
            self.velocities[index].as_mut()[i] = v + dv;
        }
        system.acceleration(phase.time + drift, &self.q, &self.velocities[index], &mut self.a[index])?;
        self.subtract_first(index);
        Ok(())
    }

    /// c h v + h² (m A_1 + Σ ā_j (A_j − A_1)) and h (c A_1 + Σ a_j (A_j − A_1)) of component `i`.
    #[inline(always)]
    fn increment<const V: usize, const P: usize>(
        &self,
        v: f64,
        h: f64,
        row: &Row<V, P>,
        i: usize,
    ) -> (f64, f64) {
        let (c, first) = (row.node, self.a[0].as_ref()[i]);
        let position = row.moment * first + weigh(&self.a, &row.position, i);
        let velocity = c * first + weigh(&self.a, &row.velocity, i);
        (h * (c * v + h * position), h * velocity)
    }

    #[inline(always)]
    fn subtract_first(&mut self, index: usize) {
        for i in 0..self.q.as_ref().len() {
            self.a[index].as_mut()[i] -= self.a[0].as_ref()[i];
        }
    }

    /// From a(phase) in the first stage: the other eleven and the increments.
    #[inline]
    fn stages<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &Phase<C>,
        h: f64,
    ) -> Result<(), LagrangianError> {
        self.stage(system, phase, h, 1, &tableau::STAGE_2)?;
        self.stage(system, phase, h, 2, &tableau::STAGE_3)?;
        self.stage(system, phase, h, 3, &tableau::STAGE_4)?;
        self.stage(system, phase, h, 4, &tableau::STAGE_5)?;
        self.stage(system, phase, h, 5, &tableau::STAGE_6)?;
        self.stage(system, phase, h, 6, &tableau::STAGE_7)?;
        self.stage(system, phase, h, 7, &tableau::STAGE_8)?;
        self.stage(system, phase, h, 8, &tableau::STAGE_9)?;
        self.stage(system, phase, h, 9, &tableau::STAGE_10)?;
        self.stage(system, phase, h, 10, &tableau::STAGE_11)?;
        self.stage(system, phase, h, 11, &tableau::STAGE_12)?;
        for i in 0..self.q.as_ref().len() {
            let (dq, dv) = self.increment(phase.v.as_ref()[i], h, &tableau::SOLUTION, i);
            self.dq.as_mut()[i] = dq;
            self.dv.as_mut()[i] = dv;
        }
        Ok(())
    }

    /// The error of the step in units of the tolerance: one is the largest allowed.
    #[inline]
    fn error(&self, phase: &Phase<C>, h: f64) -> f64 {
        let n = self.q.as_ref().len();
        let (mut fifth, mut third) = (0.0, 0.0);
        for i in 0..n {
            let (q, v) = (phase.q.as_ref()[i], phase.v.as_ref()[i]);
            let of_q = h / self.tolerance.scale(q, q + self.dq.as_ref()[i]);
            let of_v = 1.0 / self.tolerance.scale(v, v + self.dv.as_ref()[i]);
            fifth += (of_q * weigh(&self.a, &tableau::ERROR_5.position, i)).powi(2)
                + (of_v * weigh(&self.a, &tableau::ERROR_5.velocity, i)).powi(2);
            third += (of_q * weigh(&self.a, &tableau::ERROR_3.position, i)).powi(2)
                + (of_v * weigh(&self.a, &tableau::ERROR_3.velocity, i)).powi(2);
        }
        if fifth == 0.0 { 0.0 } else { h * fifth / ((fifth + 0.01 * third) * (2 * n) as f64).sqrt() }
    }

    /// The dense output of the step from `before` to `after`, whose acceleration is known: three
    /// more evaluations.
    fn dense_step<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        before: &Phase<C>,
        after: &Phase<C>,
    ) -> Result<DenseStep<C>, LagrangianError> {
        let h = after.time - before.time;
        self.velocities[12].clone_from(&after.v);
        self.a[12].clone_from(&self.a_end);
        self.subtract_first(12);
        self.stage(system, before, h, 13, &tableau::STAGE_14)?;
        self.stage(system, before, h, 14, &tableau::STAGE_15)?;
        self.stage(system, before, h, 15, &tableau::STAGE_16)?;
        for of in &mut self.velocities {
            of.as_mut().iter_mut().zip(before.v.as_ref()).for_each(|(v, first)| *v -= first);
        }
        Ok(DenseStep {
            start: before.time,
            end: after.time,
            q: interpolant([&before.q, &after.q], [&before.v, &after.v], &self.velocities, h),
            v: interpolant([&before.v, &after.v], [&self.a[0], &self.a_end], &self.a, h),
        })
    }
}

/// Σ wⱼ kⱼ of component `i`.
#[inline(always)]
fn weigh<C: Coordinates, const M: usize>(k: &[C; 16], weights: &[(usize, f64); M], i: usize) -> f64 {
    let mut sum = 0.0;
    for &(j, weight) in weights {
        sum += weight * k[j].as_ref()[i];
    }
    sum
}

/// The coefficients of the dense output from the values and slopes at both ends, and the stages' slopes less the first.
fn interpolant<C: Coordinates>(
    [before, after]: [&C; 2],
    slopes: [&C; 2],
    stages: &[C; 16],
    h: f64,
) -> [C; 8] {
    let mut r: [C; 8] = std::array::from_fn(|_| before.clone());
    for i in 0..before.as_ref().len() {
        let dy = after.as_ref()[i] - before.as_ref()[i];
        let [first, last] = slopes.map(|slope| h * slope.as_ref()[i]);
        r[1].as_mut()[i] = dy;
        r[2].as_mut()[i] = first - dy;
        r[3].as_mut()[i] = dy - last - (first - dy);
        for (row, r) in tableau::DENSE.iter().zip(&mut r[4..]) {
            r.as_mut()[i] = h * weigh(stages, row, i);
        }
    }
    r
}

impl<C: Coordinates, S: System<Coordinates = C>> Integrator<S> for DormandPrince853<C> {
    fn method(&self) -> Method {
        Method {
            name: "Dormand–Prince 8(5,3)",
            order: 8,
            structure: Structure::General,
            cost: Cost::Explicit { evaluations: 12 },
        }
    }

    fn step(&mut self, system: &S, phase: &mut Phase<C>, h: f64) -> Result<StepReport, LagrangianError> {
        assert_sizes(system, phase, self.q.as_ref().len());
        admit(phase, h)?;
        system.acceleration(phase.time, &phase.q, &phase.v, &mut self.a[0])?;
        self.stages(system, phase, h)?;
        self.remainder.add(phase, h, &self.dq, &self.dv)?;
        self.suggested = None;
        Ok(StepReport { evaluations: 12, ..StepReport::default() })
    }
}
