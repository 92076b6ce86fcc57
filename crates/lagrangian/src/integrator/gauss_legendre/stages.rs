//! The stage equations: residuals, the iteration with the mass matrices, and the end of the step.

use super::Tableau;
use crate::coordinates::Coordinates;
use crate::dense::{factor_mass, solve_factored};
use crate::integrator::StepReport;
use crate::integrator::canonical::Canonical;
use crate::integrator::convergence::{Convergence, Correction, Verdict};
use crate::system::{Expansion, System};

/// The unknown velocities, and room for what is evaluated there.
#[derive(Clone, Debug)]
pub(super) struct Stages<const S: usize, C: Coordinates> {
    /// Vᵢ.
    pub velocities: [C; S],
    /// Qᵢ.
    pub coordinates: [C; S],
    /// At (Qᵢ, Vᵢ).
    pub expansions: [Expansion<C>; S],
    /// fᵢ = ∂L/∂q + F.
    pub forces: [C; S],
    /// rᵢ, then the corrections of Vᵢ.
    pub residuals: [C; S],
    /// Room for an increment of the step.
    increment: C,
}

/// The iteration with the mass matrices does not get there.
pub(super) struct TooSlow;

impl<const S: usize, C: Coordinates> Stages<S, C> {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || std::array::from_fn(|_| C::zeros(n));
        Self {
            velocities: zeros(),
            coordinates: zeros(),
            expansions: std::array::from_fn(|_| Expansion::zeros(n)),
            forces: zeros(),
            residuals: zeros(),
            increment: C::zeros(n),
        }
    }

    pub(super) fn dimension(&self) -> usize {
        self.increment.as_ref().len()
    }

    /// Vᵢ = v + cᵢ h a.
    pub(super) fn predict_linearly(&mut self, tableau: &Tableau<S>, v: &C, a: &C, h: f64) {
        self.extrapolate_linearly(&tableau.nodes, v.as_ref(), a.as_ref(), h);
    }

    pub(super) fn extrapolate_linearly(&mut self, nodes: &[f64; S], v: &[f64], a: &[f64], h: f64) {
        for (velocity, c) in self.velocities.iter_mut().zip(nodes) {
            for (j, velocity) in velocity.as_mut().iter_mut().enumerate() {
                *velocity = v[j] + c * h * a[j];
            }
        }
    }

    /// Solves the stage equations; answers the contraction at the end.
    pub(super) fn iterate<System_: System<Coordinates = C>>(
        &mut self,
        system: &System_,
        tableau: &Tableau<S>,
        start: &Canonical<C>,
        h: f64,
        rate: f64,
        report: &mut StepReport,
    ) -> Result<f64, TooSlow> {
        let mut convergence = Convergence::new(rate, 60);
        loop {
            self.evaluate(system, tableau, start, h, report);
            let correction = self.correct_with_mass(start, h).ok_or(TooSlow)?;
            match convergence.judge(correction) {
                Verdict::Continue => {}
                Verdict::Converged => return Ok(convergence.rate.min(1.0)),
                Verdict::Failing => return Err(TooSlow),
            }
        }
    }

    /// Qᵢ, the expansions there, the forces, and the residuals rᵢ.
    #[inline]
    pub(super) fn evaluate<System_: System<Coordinates = C>>(
        &mut self,
        system: &System_,
        tableau: &Tableau<S>,
        start: &Canonical<C>,
        h: f64,
        report: &mut StepReport,
    ) {
        for i in 0..S {
            let q = self.coordinates[i].as_mut();
            for j in 0..q.len() {
                let increment = h * combined(&tableau.stages[i], &self.velocities, j);
                q[j] = start.q.as_ref()[j] + (start.q_lost.as_ref()[j] + increment);
            }
            let time = start.time + tableau.nodes[i] * h;
            let at = &mut self.expansions[i];
            system.expand(time, &self.coordinates[i], &self.velocities[i], at);
            let force = self.forces[i].as_mut();
            for j in 0..force.len() {
                force[j] = at.slope.as_ref()[j] + at.applied.as_ref()[j];
            }
        }
        for i in 0..S {
            let (momentum, residual) = (self.expansions[i].momentum.as_ref(), self.residuals[i].as_mut());
            for j in 0..residual.len() {
                let increment = h * combined(&tableau.stages[i], &self.forces, j);
                residual[j] = (start.p.as_ref()[j] - momentum[j]) + (start.p_lost.as_ref()[j] + increment);
            }
        }
        report.evaluations += S as u64;
        report.iterations += 1;
    }

    /// Vᵢ += Mᵢ⁻¹ rᵢ; `None` if a mass matrix is not positive definite.
    #[inline]
    fn correct_with_mass(&mut self, start: &Canonical<C>, h: f64) -> Option<Correction> {
        let n = self.dimension();
        let mut work = [0.0; 2];
        for i in 0..S {
            let (at, residual) = (&mut self.expansions[i], self.residuals[i].as_mut());
            factor_mass::<C>(start.time, &mut at.mass, n).ok()?;
            self.increment.as_mut().copy_from_slice(residual);
            solve_factored::<C>(&at.mass, residual);
            let velocity = self.velocities[i].as_mut();
            for j in 0..n {
                work[0] += self.increment.as_ref()[j] * residual[j];
                work[1] += (velocity[j] * at.momentum.as_ref()[j]).abs();
                velocity[j] += residual[j];
            }
        }
        Some(self.measure(start, h, (work[0] / work[1]).sqrt()))
    }

    /// The size of the corrections in `residuals`, already made.
    #[inline]
    pub(super) fn measure(&self, start: &Canonical<C>, h: f64, energetic: f64) -> Correction {
        let mut correction = Correction { energetic, ..Correction::default() };
        for j in 0..self.dimension() {
            let (mut change, mut size) = (0.0_f64, 0.0_f64);
            for i in 0..S {
                let d = self.residuals[i].as_ref()[j].abs();
                // A NaN must come through, which `max` would drop.
                change = if d <= change { change } else { d };
                size = size.max(self.velocities[i].as_ref()[j].abs());
            }
            if change != 0.0 {
                let (strict, positional) = (change / size, h * change / start.q.as_ref()[j].abs());
                correction.strict = if strict <= correction.strict { correction.strict } else { strict };
                correction.positional = correction.positional.max(positional);
            }
        }
        if correction.strict == 0.0 {
            correction.energetic = 0.0;
        }
        correction
    }

    /// Moves `state` by h Σ bᵢ Vᵢ and h Σ bᵢ fᵢ.
    #[inline]
    pub(super) fn advance(&mut self, tableau: &Tableau<S>, h: f64, state: &mut Canonical<C>) {
        let summed = |terms: &[C; S], increment: &mut C| {
            for (j, increment) in increment.as_mut().iter_mut().enumerate() {
                let rest = combined(&tableau.weights_lost, terms, j);
                *increment = h * (combined(&tableau.weights, terms, j) + rest);
            }
        };
        summed(&self.velocities, &mut self.increment);
        state.add_to_q(&self.increment);
        summed(&self.forces, &mut self.increment);
        state.add_to_p(&self.increment);
        state.advance_time(h);
    }

    /// q̈ from the first expansion, whose mass is factored.
    #[inline]
    pub(super) fn end_acceleration(&self) -> C {
        let at = &self.expansions[0];
        let mut acceleration = at.slope.clone();
        let a = acceleration.as_mut();
        for j in 0..a.len() {
            a[j] += at.applied.as_ref()[j] - at.momentum_rate.as_ref()[j];
        }
        solve_factored::<C>(&at.mass, acceleration.as_mut());
        acceleration
    }
}

/// Component `j` of Σₖ factorsₖ termsₖ.
#[inline(always)]
pub(super) fn combined<const S: usize, C: Coordinates>(factors: &[f64; S], terms: &[C; S], j: usize) -> f64 {
    let mut sum = 0.0;
    for k in 0..S {
        sum += factors[k] * terms[k].as_ref()[j];
    }
    sum
}
