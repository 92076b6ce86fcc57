//! The step for constant masses and a potential.

use super::track::{Substep, Track, sum_exactly};
use crate::constraint::compliance::{Compliance, Met, measure, multiply_into};
use crate::constraint::constrained::refuse_nonfinite;
use crate::constraint::linear::General;
use crate::constraint::{ConstraintExpansion, ConstraintSet, ExpansionOf};
use crate::coordinates::Coordinates;
use crate::error::{LagrangianError, Symbol};
use crate::integrator::StepReport;
use crate::system::{Expansion, Gradient, System};

const ITERATIONS: u32 = 50;

/// Memory of a step.
#[derive(Clone, Debug)]
pub(super) struct Workspace<C: ConstraintSet> {
    pub(super) at: ExpansionOf<C>,
    pub(super) compliance: Compliance<C>,
    gradient: Gradient<C::Coordinates>,
    newton: General<C::Multipliers>,
    /// h/2 M⁻¹ f at the start.
    kick: C::Coordinates,
    /// v½ − v₀, then v₁ − v₀.
    gain: C::Coordinates,
    /// q₁, and what rounding took from it.
    q: C::Coordinates,
    q_low: C::Coordinates,
    /// h/2 λ⁺ and h/2 λ⁻.
    first: C::Multipliers,
    last: C::Multipliers,
    correction: C::Multipliers,
}

impl<C: ConstraintSet> Workspace<C> {
    pub(super) fn new(constraints: &C) -> Self {
        let (n, count) = constraints.shape();
        let (coordinates, multipliers) = (|| C::Coordinates::zeros(n), || C::Multipliers::zeros(count));
        Self {
            at: ConstraintExpansion::zeros(constraints.shape()),
            compliance: Compliance::new(constraints),
            gradient: Gradient::zeros(n),
            newton: General::zeros(count, C::LAYOUT),
            kick: coordinates(),
            gain: coordinates(),
            q: coordinates(),
            q_low: coordinates(),
            first: multipliers(),
            last: multipliers(),
            correction: multipliers(),
        }
    }

    /// Masses, forces and responses at a fresh start.
    pub(super) fn start<S: System<Coordinates = C::Coordinates>>(
        &mut self,
        system: &S,
        constraints: &C,
        track: &mut Track<C>,
    ) -> Result<(), LagrangianError> {
        let n = constraints.dimension();
        let mut at = Expansion::zeros(n);
        system.expand(track.phase.time, &track.phase.q, &track.phase.v, &mut at);
        self.compliance.hold_mass(track.phase.time, &at.mass, n)?;
        self.compliance.hold_jacobian(track.phase.time, constraints, &track.jacobian, &mut track.response)?;
        track.force = at.slope;
        Ok(())
    }

    #[inline]
    pub(super) fn step<S: System<Coordinates = C::Coordinates>>(
        &mut self,
        system: &S,
        constraints: &C,
        track: &mut Track<C>,
        step: Substep,
        report: &mut StepReport,
    ) -> Result<(), LagrangianError> {
        self.kick_into(&track.force, step.h);
        track.guess_impulse(step.h, self.first.as_mut());
        self.reach_constraints(constraints, track, step, report)?;

        system.differentiate(step.end, &self.q, &track.phase.v, &mut self.gradient);
        report.evaluations += 1;
        refuse_nonfinite(step.end, Symbol::Force, self.gradient.slope.as_ref())?;
        track.force.clone_from(&self.gradient.slope);
        self.kick_into(&track.force, step.h);
        for (gain, kick) in self.gain.as_mut().iter_mut().zip(self.kick.as_ref()) {
            *gain += kick;
        }
        self.reach_tangent(constraints, track, step)?;
        track.phase.q.clone_from(&self.q);
        track.q_low.clone_from(&self.q_low);
        track.note(step, self.first.as_ref(), self.last.as_ref());
        Ok(())
    }

    /// `kick` ← h/2 M⁻¹ f.
    #[inline]
    fn kick_into(&mut self, force: &C::Coordinates, h: f64) {
        self.kick.clone_from(force);
        self.compliance.divide_by_mass(self.kick.as_mut());
        for kick in self.kick.as_mut() {
            *kick *= 0.5 * h;
        }
    }

    /// λ⁺ and q₁: Newton's method on φ(q₀ + h (v₀ + kick + M⁻¹G₀ᵀ μ), t₁) = 0, whose Jacobian is h G₁ M⁻¹ G₀ᵀ. The
    /// last expansion is that at q₁, which the velocities need anyway.
    #[inline]
    fn reach_constraints(
        &mut self,
        constraints: &C,
        track: &Track<C>,
        step: Substep,
        report: &mut StepReport,
    ) -> Result<(), LagrangianError> {
        let n = constraints.dimension();
        let (mut now, mut previous) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..ITERATIONS {
            for i in 0..n {
                self.gain.as_mut()[i] = self.kick.as_ref()[i] + track.v_low.as_ref()[i];
            }
            let gain = self.gain.as_mut();
            self.compliance.add_responses(constraints, &track.response, self.first.as_ref(), gain);
            for i in 0..n {
                let move_by =
                    step.h * track.phase.v.as_ref()[i] + (step.h * gain[i] + track.q_low.as_ref()[i]);
                (self.q.as_mut()[i], self.q_low.as_mut()[i]) =
                    sum_exactly(track.phase.q.as_ref()[i], move_by);
            }
            constraints.expand(step.end, &self.q, &mut self.at);
            report.iterations += 1;

            let met;
            (met, now) = measure(constraints, self.at.value.as_ref(), &self.at.jacobian, self.q.as_ref());
            if met == Met::Tight || (met == Met::Loose && now > 0.5 * previous) {
                return Ok(());
            }
            if now.is_nan() || self.correct(constraints, track, step.h).is_err() {
                break;
            }
            previous = now;
        }
        Err(LagrangianError::NotConverged {
            method: "RATTLE",
            time: track.phase.time,
            step: step.h,
            iterations: report.iterations as u32,
            correction: 64.0 * f64::EPSILON * now,
            tolerance: 64.0 * f64::EPSILON,
        })
    }

    #[inline]
    fn correct(&mut self, constraints: &C, track: &Track<C>, h: f64) -> Result<(), usize> {
        let count = constraints.count();
        let matrix = self.newton.entries_mut();
        self.compliance.couple_into(constraints, &self.at.jacobian, &track.response, h, matrix);
        self.newton.factor(count)?;
        self.correction.clone_from(&self.at.value);
        self.newton.solve(self.correction.as_mut());
        for (first, correction) in self.first.as_mut().iter_mut().zip(self.correction.as_ref()) {
            *first -= correction;
        }
        Ok(())
    }

    /// λ⁻ and v₁: (G₁ M⁻¹ G₁ᵀ) μ = −(G₁ v + ∂φ/∂t), v₁ = v + M⁻¹G₁ᵀ μ.
    #[inline]
    fn reach_tangent(
        &mut self,
        constraints: &C,
        track: &mut Track<C>,
        step: Substep,
    ) -> Result<(), LagrangianError> {
        let n = constraints.dimension();
        // What G was before is of no more use.
        std::mem::swap(&mut track.jacobian, &mut self.at.jacobian);
        self.compliance.hold_jacobian(step.end, constraints, &track.jacobian, &mut track.response)?;
        for i in 0..n {
            self.kick.as_mut()[i] = track.phase.v.as_ref()[i] + self.gain.as_ref()[i];
        }
        multiply_into(constraints, &track.jacobian, self.kick.as_ref(), self.last.as_mut());
        for (last, rate) in self.last.as_mut().iter_mut().zip(self.at.rate.as_ref()) {
            *last = -(*last + rate);
        }
        self.compliance.divide_by_compliance(self.last.as_mut());
        self.compliance.add_responses(constraints, &track.response, self.last.as_ref(), self.gain.as_mut());
        for i in 0..n {
            let (v, gain) = (track.phase.v.as_ref()[i], self.gain.as_ref()[i]);
            (track.phase.v.as_mut()[i], track.v_low.as_mut()[i]) = sum_exactly(v, gain);
        }
        refuse_nonfinite(step.end, Symbol::Velocity, track.phase.v.as_ref())
    }
}
