//! The step for masses that depend on the coordinates, for applied forces and for any other L.

use super::Quadratic;
use super::track::{Substep, Track, sum_exactly};
use crate::constraint::compliance::{Compliance, Met, add_transposed, largest, measure, multiply_into};
use crate::constraint::constrained::refuse_nonfinite;
use crate::constraint::linear::General;
use crate::constraint::{ConstraintExpansion, ConstraintSet, ExpansionOf, Rows};
use crate::coordinates::Coordinates;
use crate::error::{LagrangianError, Symbol};
use crate::integrator::StepReport;
use crate::system::{Curvature, Expansion, Gradient, System};

const ITERATIONS: u32 = 60;
/// Corrections below this, relative, are rounding once they no longer shrink.
const STAGNATION: f64 = 1e-12;

/// One end of the step: derivatives there, and the velocity of p½.
#[derive(Clone, Debug)]
struct End<C: Coordinates> {
    v: C,
    gradient: Gradient<C>,
    curvature: Curvature<C>,
    correction: C,
    /// Factors of the block on the diagonal of Newton's matrix.
    block: General<C>,
}

impl<C: Coordinates> End<C> {
    fn zeros(n: usize, layout: crate::constraint::Layout) -> Self {
        Self {
            v: C::zeros(n),
            gradient: Gradient::zeros(n),
            curvature: Curvature::zeros(n),
            correction: C::zeros(n),
            block: General::zeros(n, layout),
        }
    }
}

/// Memory of a step.
///
/// Newton's method solves, for (v_a, v_b, μ) with μ = h/2 λ⁺ and q₁ = q₀ + h/2 (v_a + v_b),
///
/// ```text
/// R₁ = ∂L/∂v(a) − p₀ − h/2 f(a) − G₀ᵀ μ = 0      A  = M_a − h/2 ∂f/∂v(a)
/// R₂ = ∂L/∂v(b) − ∂L/∂v(a)              = 0      B  = M_b + h/2 ∂²L/∂v∂q(b),  E = M_a − h/2 ∂²L/∂v∂q(b)
/// φ(q₁, t₁)                             = 0
/// ```
///
/// by blocks: δ_a = A⁻¹(−R₁ + G₀ᵀ δμ), δ_b = B⁻¹(−R₂ + E δ_a), and h/2 G₁ (δ_a + δ_b) = −φ, which is K equations for
/// δμ. The blocks are kept while corrections shrink tenfold.
#[derive(Clone, Debug)]
pub(super) struct Workspace<C: ConstraintSet> {
    a: End<C::Coordinates>,
    b: End<C::Coordinates>,
    at: ExpansionOf<C>,
    compliance: Compliance<C>,
    response: C::Jacobian,
    expansion: Expansion<C::Coordinates>,
    momentum: C::Coordinates,
    q: C::Coordinates,
    q_low: C::Coordinates,
    /// E.
    coupling: <C::Coordinates as Coordinates>::Matrix,
    /// δ_a and δ_b per unit of δμₖ, in row k.
    answer_a: C::Jacobian,
    answer_b: C::Jacobian,
    schur: General<C::Multipliers>,
    first: C::Multipliers,
    last: C::Multipliers,
    correction: C::Multipliers,
    scratch: C::Coordinates,
}

impl<C: ConstraintSet> Workspace<C> {
    pub(super) fn new(constraints: &C) -> Self {
        let (n, count) = constraints.shape();
        let (coordinates, multipliers) = (|| C::Coordinates::zeros(n), || C::Multipliers::zeros(count));
        let rows = || C::Jacobian::zeros(count, n);
        Self {
            a: End::zeros(n, C::LAYOUT),
            b: End::zeros(n, C::LAYOUT),
            at: ConstraintExpansion::zeros(constraints.shape()),
            compliance: Compliance::new(constraints),
            response: rows(),
            expansion: Expansion::zeros(n),
            momentum: coordinates(),
            q: coordinates(),
            q_low: coordinates(),
            coupling: C::Coordinates::zero_matrix(n),
            answer_a: rows(),
            answer_b: rows(),
            schur: General::zeros(count, C::LAYOUT),
            first: multipliers(),
            last: multipliers(),
            correction: multipliers(),
            scratch: coordinates(),
        }
    }

    pub(super) fn step<S: System<Coordinates = C::Coordinates>>(
        &mut self,
        system: &S,
        constraints: &C,
        track: &mut Track<C>,
        step: Substep,
        quadratic: Quadratic,
        report: &mut StepReport,
    ) -> Result<(), LagrangianError> {
        system.differentiate(track.phase.time, &track.phase.q, &track.phase.v, &mut self.a.gradient);
        report.evaluations += 1;
        self.momentum.clone_from(&self.a.gradient.momentum);
        track.guess_impulse(step.h, self.first.as_mut());
        for i in 0..constraints.dimension() {
            self.a.v.as_mut()[i] = track.phase.v.as_ref()[i] + 0.5 * step.h * track.acceleration.as_ref()[i];
        }
        self.b.v.clone_from(&self.a.v);
        self.reach_constraints(system, constraints, track, step, report)?;
        self.reach_tangent(system, constraints, track, step, quadratic, report)?;

        for i in 0..constraints.dimension() {
            let change = self.b.v.as_ref()[i] - track.phase.v.as_ref()[i];
            track.acceleration.as_mut()[i] = change / step.h;
        }
        track.phase.q.clone_from(&self.q);
        track.q_low.clone_from(&self.q_low);
        track.phase.v.clone_from(&self.b.v);
        track.jacobian.clone_from(&self.at.jacobian);
        track.note(step, self.first.as_ref(), self.last.as_ref());
        Ok(())
    }

    /// v_a, v_b, λ⁺, q₁.
    fn reach_constraints<S: System<Coordinates = C::Coordinates>>(
        &mut self,
        system: &S,
        constraints: &C,
        track: &Track<C>,
        step: Substep,
        report: &mut StepReport,
    ) -> Result<(), LagrangianError> {
        let (mut size, mut previous) = (f64::INFINITY, f64::INFINITY);
        for iteration in 1..=ITERATIONS {
            report.iterations += 1;
            self.evaluate(system, constraints, track, step, report);
            let fast = iteration > 1 && size <= 0.1 * previous;
            let coarse = self.speed() + largest(track.phase.q.as_ref()) / step.h.abs();
            if !fast
                && size > STAGNATION * coarse
                && self.linearise(system, constraints, track, step, report).is_err()
            {
                break;
            }
            let (met, _) = measure(constraints, self.at.value.as_ref(), &self.at.jacobian, self.q.as_ref());
            if met == Met::Tight {
                // What is left is the rounding of q: corrections of the velocity by it over h would never end.
                self.at.value.as_mut().fill(0.0);
            }
            previous = size;
            size = self.solve(constraints, track, step.h);
            let done = size <= 2.0 * f64::EPSILON * self.speed() && met == Met::Tight;
            if done || (size <= STAGNATION * coarse && size > 0.5 * previous && met != Met::Not) {
                return Ok(());
            }
            if !size.is_finite() {
                break;
            }
            self.correct();
        }
        Err(LagrangianError::NotConverged {
            method: "RATTLE",
            time: track.phase.time,
            step: step.h,
            iterations: report.iterations as u32,
            correction: size / self.speed().max(f64::MIN_POSITIVE),
            tolerance: STAGNATION,
        })
    }

    /// Derivatives at both ends.
    fn evaluate<S: System<Coordinates = C::Coordinates>>(
        &mut self,
        system: &S,
        constraints: &C,
        track: &Track<C>,
        step: Substep,
        report: &mut StepReport,
    ) {
        for i in 0..constraints.dimension() {
            let sum = self.a.v.as_ref()[i] + self.b.v.as_ref()[i];
            let move_by = 0.5 * step.h * sum + track.q_low.as_ref()[i];
            (self.q.as_mut()[i], self.q_low.as_mut()[i]) = sum_exactly(track.phase.q.as_ref()[i], move_by);
        }
        system.differentiate(track.phase.time, &track.phase.q, &self.a.v, &mut self.a.gradient);
        system.differentiate(step.end, &self.q, &self.b.v, &mut self.b.gradient);
        constraints.expand(step.end, &self.q, &mut self.at);
        report.evaluations += 2;
    }

    /// Factors A, B and the K×K matrix of δμ.
    fn linearise<S: System<Coordinates = C::Coordinates>>(
        &mut self,
        system: &S,
        constraints: &C,
        track: &Track<C>,
        step: Substep,
        report: &mut StepReport,
    ) -> Result<(), usize> {
        let (n, count) = constraints.shape();
        let half = 0.5 * step.h;
        system.curve(track.phase.time, &track.phase.q, &self.a.v, &mut self.a.curvature);
        system.curve(step.end, &self.q, &self.b.v, &mut self.b.curvature);
        report.curvatures += 2;
        let entries = C::Coordinates::entries;
        let (vv_a, vq_a) = (entries(&self.a.curvature.vv), entries(&self.a.curvature.vq));
        let (vv_b, vq_b) = (entries(&self.b.curvature.vv), entries(&self.b.curvature.vq));
        let applied = entries(&self.a.curvature.applied_v);
        let (block_a, block_b) = (self.a.block.entries_mut(), self.b.block.entries_mut());
        let coupling = C::Coordinates::entries_mut(&mut self.coupling);
        for i in 0..n {
            for j in 0..n {
                let (ij, ji) = (i * n + j, j * n + i);
                block_a[ij] = vv_a[ij] - half * (vq_a[ji] + applied[ij]);
                block_b[ij] = vv_b[ij] + half * vq_b[ij];
                coupling[ij] = vv_a[ij] - half * vq_b[ij];
            }
        }
        self.a.block.factor(n)?;
        self.b.block.factor(n)?;

        self.answer_a.clone_from(&track.jacobian);
        for k in 0..count {
            let row = k * n..(k + 1) * n;
            let answer_a = &mut self.answer_a.entries_mut()[row.clone()];
            let answer_b = &mut self.answer_b.entries_mut()[row];
            self.a.block.solve(answer_a);
            product_into(C::Coordinates::entries(&self.coupling), answer_a, answer_b);
            self.b.block.solve(answer_b);
            for i in 0..n {
                self.scratch.as_mut()[i] = half * (answer_a[i] + answer_b[i]);
            }
            multiply_into(constraints, &self.at.jacobian, self.scratch.as_ref(), self.correction.as_mut());
            for l in 0..count {
                self.schur.entries_mut()[l * count + k] = self.correction.as_ref()[l];
            }
        }
        self.schur.factor(count)
    }

    /// δ_a, δ_b, δμ for the residuals at hand; the size of the first two.
    fn solve(&mut self, constraints: &C, track: &Track<C>, h: f64) -> f64 {
        let (n, count) = constraints.shape();
        let half = 0.5 * h;
        for i in 0..n {
            let at = &self.a.gradient;
            let force = at.slope.as_ref()[i] + at.applied.as_ref()[i];
            self.a.correction.as_mut()[i] =
                self.momentum.as_ref()[i] + half * force - at.momentum.as_ref()[i];
        }
        add_transposed(constraints, &track.jacobian, self.first.as_ref(), self.a.correction.as_mut());
        self.a.block.solve(self.a.correction.as_mut());

        let coupling = C::Coordinates::entries(&self.coupling);
        product_into(coupling, self.a.correction.as_ref(), self.b.correction.as_mut());
        for i in 0..n {
            let residual = self.b.gradient.momentum.as_ref()[i] - self.a.gradient.momentum.as_ref()[i];
            self.b.correction.as_mut()[i] -= residual;
        }
        self.b.block.solve(self.b.correction.as_mut());

        for i in 0..n {
            let sum = self.a.correction.as_ref()[i] + self.b.correction.as_ref()[i];
            self.scratch.as_mut()[i] = half * sum;
        }
        multiply_into(constraints, &self.at.jacobian, self.scratch.as_ref(), self.correction.as_mut());
        for k in 0..count {
            self.correction.as_mut()[k] = -self.correction.as_ref()[k] - self.at.value.as_ref()[k];
        }
        self.schur.solve(self.correction.as_mut());
        for k in 0..count {
            let weight = self.correction.as_ref()[k];
            for i in 0..n {
                self.a.correction.as_mut()[i] += weight * self.answer_a.entries()[k * n + i];
                self.b.correction.as_mut()[i] += weight * self.answer_b.entries()[k * n + i];
            }
        }
        largest(self.a.correction.as_ref()) + largest(self.b.correction.as_ref())
    }

    /// The larger velocity of the two ends.
    fn speed(&self) -> f64 {
        largest(self.a.v.as_ref()).max(largest(self.b.v.as_ref()))
    }

    fn correct(&mut self) {
        add(self.a.correction.as_ref(), self.a.v.as_mut());
        add(self.b.correction.as_ref(), self.b.v.as_mut());
        add(self.correction.as_ref(), self.first.as_mut());
    }

    /// λ⁻ and v₁ from p½: Newton's method on ∂L/∂v(t₁, q₁, v) = p½ + h/2 f(b) + G₁ᵀ μ, G₁ v + ∂φ/∂t = 0, which is
    /// linear where T is quadratic in v. Leaves v₁ in `b.v`.
    fn reach_tangent<S: System<Coordinates = C::Coordinates>>(
        &mut self,
        system: &S,
        constraints: &C,
        track: &Track<C>,
        step: Substep,
        quadratic: Quadratic,
        report: &mut StepReport,
    ) -> Result<(), LagrangianError> {
        let n = constraints.dimension();
        for i in 0..n {
            let at = &self.b.gradient;
            let force = at.slope.as_ref()[i] + at.applied.as_ref()[i];
            self.momentum.as_mut()[i] = at.momentum.as_ref()[i] + 0.5 * step.h * force;
        }
        self.last.as_mut().fill(0.0);
        let (mut size, mut previous) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..ITERATIONS {
            system.expand(step.end, &self.q, &self.b.v, &mut self.expansion);
            report.evaluations += 1;
            self.compliance.hold_mass(step.end, &self.expansion.mass, n)?;
            self.compliance.hold_jacobian(step.end, constraints, &self.at.jacobian, &mut self.response)?;
            size = self.correct_tangent(constraints);
            refuse_nonfinite(step.end, Symbol::Velocity, self.b.v.as_ref())?;
            let rounding = size <= 2.0 * f64::EPSILON || (size <= STAGNATION && size > 0.5 * previous);
            if quadratic == Quadratic::Yes || rounding {
                return Ok(());
            }
            previous = size;
        }
        Err(LagrangianError::NotConverged {
            method: "RATTLE (velocity from momentum)",
            time: track.phase.time,
            step: step.h,
            iterations: ITERATIONS,
            correction: size,
            tolerance: STAGNATION,
        })
    }

    /// One iteration; the relative size of its correction.
    fn correct_tangent(&mut self, constraints: &C) -> f64 {
        let shift = self.b.correction.as_mut();
        for (i, shift) in shift.iter_mut().enumerate() {
            *shift = self.momentum.as_ref()[i] - self.expansion.momentum.as_ref()[i];
        }
        add_transposed(constraints, &self.at.jacobian, self.last.as_ref(), shift);
        self.compliance.divide_by_mass(shift);
        self.scratch.clone_from(&self.b.v);
        add(shift, self.scratch.as_mut());
        multiply_into(constraints, &self.at.jacobian, self.scratch.as_ref(), self.correction.as_mut());
        for (speed, rate) in self.correction.as_mut().iter_mut().zip(self.at.rate.as_ref()) {
            *speed = -(*speed + rate);
        }
        self.compliance.divide_by_compliance(self.correction.as_mut());
        self.compliance.add_responses(constraints, &self.response, self.correction.as_ref(), shift);
        add(self.correction.as_ref(), self.last.as_mut());
        add(shift, self.b.v.as_mut());
        largest(shift) / largest(self.b.v.as_ref()).max(f64::MIN_POSITIVE)
    }
}

/// y += x.
fn add(x: &[f64], y: &mut [f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += x);
}

/// `out` ← A x.
fn product_into(a: &[f64], x: &[f64], out: &mut [f64]) {
    for (i, out) in out.iter_mut().enumerate() {
        *out = a[i * x.len()..].iter().zip(x).map(|(a, x)| a * x).sum();
    }
}
