//! The equation that implicit Euler and BDF2 have in common, and the two ways to solve it.
//!
//! Both methods end a step at q₁ = q̂ + η w with the velocity w, where
//!
//! ∂L/∂v(q₁, w, t₁) = p̂ + η (∂L/∂q + F)(q₁, w, t₁),
//!
//! with η = h, q̂ = q₀, p̂ = p₀ for implicit Euler and, for equal steps, η = 2h/3, q̂ = (4q₁ − q₀)/3, p̂ likewise for BDF2. Written in (q, p) it
//! needs no derivative of the mass matrix along the motion, and holds for any M(q).
//!
//! **Minimisation.** If M is constant, and F integrable in w, the equation says that
//!
//! E(w) = ½ wᵀM w − p̂·w + V(q̂ + η w, t₁) − ∫₀¹ F(q̂ + η s w, s w, t₁)·η w ds
//!
//! is stationary; up to a constant its first two terms are the incremental potential's ½‖q − (q̂ + η v̂)‖²_M/η² with p̂ = M v̂,
//! and for F = −∂R/∂v the last is η (R(w) − R(0)). Its minimum is the motion: the stationary point of least
//! potential, where Newton's method on the equation alone may take any. [`mechanics_core::newton`] finds it, and
//! Newton's method on the equation then carries it to rounding.
//!
//! **Root finding.** If M depends on q, the gradient of such an E would have a term in ∂M/∂q that the equation has with
//! another factor: the equation is not the gradient of anything. It is solved by Newton's method, from w = the last
//! velocity, damped: −∂r/∂w = M + η (∂²L/∂v∂q − ∂²L/∂q∂v − ∂F/∂v) − η² (∂²L/∂q∂q + ∂F/∂q).

mod minimisation;

use crate::coordinates::{Coordinates, Phase};
use crate::dense::{factor_mass, solve_general};
use crate::error::LagrangianError;
use crate::integrator::StepReport;
use crate::integrator::canonical::Canonical;
use crate::integrator::convergence::{Convergence, Correction, Iteration, TOLERANCE, Verdict, noise_scale};
use crate::system::{Curvature, Expansion, System};

/// How the equation of an implicit step is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formulation {
    /// As the minimum of an incremental potential: the mass matrix is constant.
    Minimisation,
    /// As a root in (q, p): the mass matrix, or an applied force, makes it no gradient.
    RootFinding,
}

/// The known part of the equation.
#[derive(Clone, Debug)]
pub(super) struct Anchor<'a, C> {
    pub start: &'a Canonical<C>,
    /// q̂ − q₀.
    pub drift_q: &'a C,
    /// p̂ − p₀.
    pub drift_p: &'a C,
    pub eta: f64,
    pub h: f64,
    pub method: &'static str,
}

/// The unknown velocity, and room for what is evaluated there.
#[derive(Clone, Debug)]
pub(super) struct Backward<C: Coordinates> {
    pub velocity: C,
    /// The velocity at the start of the step.
    start_velocity: C,
    pub at: Expansion<C>,
    end: C,
    curvature: Curvature<C>,
    residual: C,
    correction: C,
    matrix: Vec<f64>,
}

impl<C: Coordinates> Anchor<'_, C> {
    /// q̂ + η w.
    fn end_into(&self, w: &[f64], q: &mut C) {
        for (j, q) in q.as_mut().iter_mut().enumerate() {
            let moved = self.start.q_lost.as_ref()[j] + (self.drift_q.as_ref()[j] + self.eta * w[j]);
            *q = self.start.q.as_ref()[j] + moved;
        }
    }

    fn end_time(&self) -> f64 {
        self.start.time + self.h
    }

    fn not_converged(&self, iterations: u64, correction: f64) -> LagrangianError {
        LagrangianError::NotConverged {
            method: self.method,
            time: self.start.time,
            step: self.h,
            iterations: iterations as u32,
            correction,
            tolerance: TOLERANCE,
        }
    }
}

impl<C: Coordinates> Backward<C> {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || C::zeros(n);
        Self {
            velocity: zeros(),
            start_velocity: zeros(),
            at: Expansion::zeros(n),
            end: zeros(),
            curvature: Curvature::zeros(n),
            residual: zeros(),
            correction: zeros(),
            matrix: vec![0.0; n * n],
        }
    }

    pub(super) fn dimension(&self) -> usize {
        self.end.as_ref().len()
    }

    /// Which formulation the system admits: M constant, and ∂F/∂w symmetric (at `phase`) if there is an F.
    pub(super) fn formulation<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &Phase<C>,
        eta: f64,
        report: &mut StepReport,
    ) -> Formulation {
        let on = system.dependence(phase.time, &phase.q, &phase.v);
        let constant_mass = on.kinetic_quadratic && !on.kinetic_on_time && !on.kinetic_on_q.contains(&true);
        if !constant_mass || (on.applied() && !self.applied_is_a_gradient(system, phase, eta, report)) {
            return Formulation::RootFinding;
        }
        Formulation::Minimisation
    }

    fn applied_is_a_gradient<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &Phase<C>,
        eta: f64,
        report: &mut StepReport,
    ) -> bool {
        system.curve(phase.time, &phase.q, &phase.v, &mut self.curvature);
        report.curvatures += 1;
        let n = self.dimension();
        let (by_q, by_v) = (C::entries(&self.curvature.applied_q), C::entries(&self.curvature.applied_v));
        let entry = |i: usize, j: usize| eta * by_q[i * n + j] + by_v[i * n + j];
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (a.abs() + b.abs());
        (0..n).all(|i| (0..i).all(|j| near(entry(i, j), entry(j, i))))
    }

    /// Solves the equation from the velocity that is there, that at the start of the step.
    ///
    /// The energy of a motion that has all but died out is nothing but rounding, or underflows, and cannot be minimised; its
    /// gradient still can be solved. What is found then must be a minimum by its second derivatives.
    pub(super) fn solve<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        anchor: &Anchor<'_, C>,
        formulation: Formulation,
        report: &mut StepReport,
    ) -> Result<(), LagrangianError> {
        self.start_velocity.clone_from(&self.velocity);
        if formulation == Formulation::RootFinding {
            return self.find_root(system, anchor, report);
        }
        match minimisation::minimise(system, anchor, &mut self.velocity, report) {
            Ok(()) => self.find_root(system, anchor, report),
            Err(failure) => match self.find_root(system, anchor, report) {
                Ok(()) if self.is_minimum(system, anchor, report) => Ok(()),
                _ => Err(failure),
            },
        }
    }

    /// Whether the incremental potential's second derivative is positive definite at the solution.
    fn is_minimum<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        anchor: &Anchor<'_, C>,
        report: &mut StepReport,
    ) -> bool {
        system.curve(anchor.end_time(), &self.end, &self.velocity, &mut self.curvature);
        report.curvatures += 1;
        self.fill_jacobian(anchor.eta);
        let n = self.dimension();
        C::entries_mut(&mut self.curvature.vv).copy_from_slice(&self.matrix);
        factor_mass::<C>(anchor.end_time(), &mut self.curvature.vv, n).is_ok()
    }

    /// Newton's method, damped: along its direction every norm of r falls at first, so a step that does not lower
    /// Σ rⱼ²/Mⱼⱼ is halved.
    fn find_root<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        anchor: &Anchor<'_, C>,
        report: &mut StepReport,
    ) -> Result<(), LagrangianError> {
        let mut convergence = Convergence::new(Iteration::Newton, 1.0, 50, 60);
        let mut halvings = 0;
        self.evaluate(system, anchor, report);
        let mut defect = self.defect();
        loop {
            system.curve(anchor.end_time(), &self.end, &self.velocity, &mut self.curvature);
            report.curvatures += 1;
            self.fill_jacobian(anchor.eta);
            self.correction.clone_from(&self.residual);
            let verdict = match solve_general(&mut self.matrix, self.correction.as_mut()) {
                Some(()) => convergence.judge(self.correct(anchor)),
                None => Verdict::Failing,
            };
            match verdict {
                Verdict::Continue | Verdict::Stalled => {}
                Verdict::Converged => return Ok(()),
                Verdict::Failing => {
                    return Err(anchor.not_converged(report.iterations, convergence.correction()));
                }
            }
            self.evaluate(system, anchor, report);
            let mut new = self.defect();
            // Below this the defect may be rounding, and the method converges by itself.
            while !convergence.is_near_rounding() && (new.is_nan() || new > defect) {
                halvings += 1;
                if halvings > 100 {
                    return Err(anchor.not_converged(report.iterations, convergence.correction()));
                }
                for (w, d) in self.velocity.as_mut().iter_mut().zip(self.correction.as_mut()) {
                    *d *= 0.5;
                    *w -= *d;
                }
                self.evaluate(system, anchor, report);
                new = self.defect();
            }
            defect = new;
        }
    }

    /// Σ rⱼ²/Mⱼⱼ \[J\].
    fn defect(&self) -> f64 {
        let (n, mass) = (self.dimension(), C::entries(&self.at.mass));
        self.residual.as_ref().iter().enumerate().map(|(j, r)| r * r / mass[j * n + j]).sum()
    }

    /// The derivatives at (q̂ + η w, w), and r = p̂ + η f − ∂L/∂v.
    fn evaluate<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        anchor: &Anchor<'_, C>,
        report: &mut StepReport,
    ) {
        anchor.end_into(self.velocity.as_ref(), &mut self.end);
        system.expand(anchor.end_time(), &self.end, &self.velocity, &mut self.at);
        for (j, r) in self.residual.as_mut().iter_mut().enumerate() {
            let force = self.at.slope.as_ref()[j] + self.at.applied.as_ref()[j];
            let moved = anchor.start.p_lost.as_ref()[j] + (anchor.drift_p.as_ref()[j] + anchor.eta * force);
            *r = (anchor.start.p.as_ref()[j] - self.at.momentum.as_ref()[j]) + moved;
        }
        report.evaluations += 1;
        report.iterations += 1;
    }

    fn fill_jacobian(&mut self, eta: f64) {
        let n = self.dimension();
        let at = &self.curvature;
        let (vv, vq, qq) = (C::entries(&at.vv), C::entries(&at.vq), C::entries(&at.qq));
        let (by_q, by_v) = (C::entries(&at.applied_q), C::entries(&at.applied_v));
        for i in 0..n {
            for j in 0..n {
                let (ij, ji) = (i * n + j, j * n + i);
                let gyroscopic = vq[ij] - vq[ji] - by_v[ij];
                self.matrix[ij] = vv[ij] + eta * gyroscopic - eta * eta * (qq[ij] + by_q[ij]);
            }
        }
    }

    /// w += the correction, and how large that is.
    fn correct(&mut self, anchor: &Anchor<'_, C>) -> Correction {
        let mut size = Correction::default();
        let (mut work, mut scale) = (0.0, 0.0);
        for (j, w) in self.velocity.as_mut().iter_mut().enumerate() {
            let d = self.correction.as_ref()[j];
            work += (d * self.residual.as_ref()[j]).abs();
            scale += (*w * self.at.momentum.as_ref()[j]).abs();
            *w += d;
            if d != 0.0 {
                let strict = (d / *w).abs();
                size.strict = if strict <= size.strict { size.strict } else { strict };
                let (before, q) = (self.start_velocity.as_ref()[j], anchor.start.q.as_ref()[j]);
                let scale = noise_scale(*w, before, q, anchor.eta);
                size.noise = size.noise.max(d.abs() / scale);
            }
        }
        size.work = work;
        size.energetic = (work / (work + scale)).sqrt();
        size
    }

    /// Overwrites `increment` with η f at the solution.
    pub(super) fn impulse_into(&self, eta: f64, increment: &mut C) {
        for (j, increment) in increment.as_mut().iter_mut().enumerate() {
            *increment = eta * (self.at.slope.as_ref()[j] + self.at.applied.as_ref()[j]);
        }
    }
}
