//! The stage equations: residuals, the iteration with the mass matrices, and the end of the step.

use super::Tableau;
use crate::coordinates::Coordinates;
use crate::dense::{bound_momentum, factor_mass, solve_factored};
use crate::integrator::StepReport;
use crate::integrator::canonical::Canonical;
use crate::integrator::convergence::{Convergence, Correction, Iteration, ROUNDING, Verdict, noise_scale};
use crate::system::{Curvature, Expansion, Gradient, System};

/// The unknown velocities, and room for what is evaluated there.
#[derive(Clone, Debug)]
pub(super) struct Stages<const S: usize, C: Coordinates> {
    /// Vᵢ.
    pub velocities: [C; S],
    /// The velocity at the start of the step.
    pub start_velocity: C,
    /// Qᵢ.
    pub coordinates: [C; S],
    /// At (Qᵢ, Vᵢ), where they were last renewed; the masses factored.
    pub expansions: [Expansion<C>; S],
    /// ∂L/∂v at (Qᵢ, Vᵢ).
    pub momenta: [C; S],
    /// fᵢ = ∂L/∂q + F.
    pub forces: [C; S],
    /// rᵢ, then the corrections of Vᵢ.
    pub residuals: [C; S],
    /// Second derivatives at a middle stage.
    curvature: Curvature<C>,
    /// Room for (G − h K A) applied to corrections.
    coupled: [C; S],
    /// Room for the first derivatives at one stage.
    gradient: Gradient<C>,
    /// Room for an increment of the step.
    increment: C,
}

/// Whether an evaluation renews the mass matrices, which costs about half as much again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Masses {
    New,
    Kept,
}

/// Whether corrections allow for what they change in the other stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coupling {
    Neglected,
    Included,
}

/// The contraction that earlier steps saw; 1 where none did.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rates {
    neglected: f64,
    included: f64,
}

impl Rates {
    pub(super) const UNKNOWN: Self = Self { neglected: 1.0, included: 1.0 };

    /// Second derivatives cost as much as some first ones at one stage: worth it where the plain iteration contracts
    /// slowly, the sooner the more stages there are.
    fn coupling(self, stages: usize) -> Coupling {
        let slow = self.neglected < 1.0 && self.neglected * stages as f64 > 0.03;
        if slow { Coupling::Included } else { Coupling::Neglected }
    }

    fn of(self, coupling: Coupling) -> f64 {
        match coupling {
            Coupling::Neglected => self.neglected,
            Coupling::Included => self.included,
        }
    }

    fn record(&mut self, coupling: Coupling, rate: f64) {
        match coupling {
            Coupling::Neglected => self.neglected = rate,
            Coupling::Included => {
                self.included = rate;
                // Forgotten in time, so that the plain iteration is tried again now and then.
                self.neglected *= 0.99;
            }
        }
    }
}

/// The iteration with the mass matrices does not get there.
pub(super) struct TooSlow;

impl<const S: usize, C: Coordinates> Stages<S, C> {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || std::array::from_fn(|_| C::zeros(n));
        Self {
            velocities: zeros(),
            start_velocity: C::zeros(n),
            coordinates: zeros(),
            expansions: std::array::from_fn(|_| Expansion::zeros(n)),
            forces: zeros(),
            momenta: zeros(),
            residuals: zeros(),
            curvature: Curvature::zeros(n),
            coupled: zeros(),
            gradient: Gradient::zeros(n),
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
        rates: &mut Rates,
        report: &mut StepReport,
    ) -> Result<(), TooSlow> {
        let coupling = rates.coupling(S);
        let mut convergence = Convergence::new(Iteration::Simple, rates.of(coupling), 5, 60);
        let mut stalled = false;
        loop {
            // From a good prediction the mass matrices of the first iteration serve the others.
            let masses = if convergence.iterations == 0 || convergence.rate > 0.1 {
                Masses::New
            } else {
                Masses::Kept
            };
            self.evaluate(system, tableau, start, h, masses, report);
            if masses == Masses::New {
                self.factor_masses(start.time).ok_or(TooSlow)?;
            }
            if stalled && self.residuals_are_rounding(start, h) {
                rates.record(coupling, convergence.rate.min(1.0));
                return Ok(());
            }
            if coupling == Coupling::Included && convergence.iterations == 0 {
                let (q, v) = (&self.coordinates[S / 2], &self.velocities[S / 2]);
                system.curve(start.time + tableau.nodes[S / 2] * h, q, v, &mut self.curvature);
                report.curvatures += 1;
            }
            match convergence.judge(self.correct_with_mass(tableau, start, h, coupling)) {
                Verdict::Continue => {}
                Verdict::Stalled => stalled = true,
                Verdict::Converged => {
                    rates.record(coupling, convergence.rate.min(1.0));
                    if coupling == Coupling::Included {
                        self.correct_forces(tableau, h);
                    }
                    return Ok(());
                }
                Verdict::Failing => return Err(TooSlow),
            }
        }
    }

    /// Qᵢ, the derivatives there, the forces, and the residuals rᵢ.
    #[inline]
    pub(super) fn evaluate<System_: System<Coordinates = C>>(
        &mut self,
        system: &System_,
        tableau: &Tableau<S>,
        start: &Canonical<C>,
        h: f64,
        masses: Masses,
        report: &mut StepReport,
    ) {
        for i in 0..S {
            let q = self.coordinates[i].as_mut();
            for j in 0..q.len() {
                let increment = h * combined(&tableau.stages[i], &self.velocities, j);
                q[j] = start.q.as_ref()[j] + (start.q_lost.as_ref()[j] + increment);
            }
            let (q, v, time) = (&self.coordinates[i], &self.velocities[i], start.time + tableau.nodes[i] * h);
            let (force, momentum) = (self.forces[i].as_mut(), &mut self.momenta[i]);
            let (slope, applied) = match masses {
                Masses::New => {
                    let at = &mut self.expansions[i];
                    system.expand(time, q, v, at);
                    momentum.clone_from(&at.momentum);
                    (&at.slope, &at.applied)
                }
                Masses::Kept => {
                    system.differentiate(time, q, v, &mut self.gradient);
                    momentum.clone_from(&self.gradient.momentum);
                    (&self.gradient.slope, &self.gradient.applied)
                }
            };
            for j in 0..force.len() {
                force[j] = slope.as_ref()[j] + applied.as_ref()[j];
            }
        }
        for i in 0..S {
            let (momentum, residual) = (self.momenta[i].as_ref(), self.residuals[i].as_mut());
            for j in 0..residual.len() {
                let increment = h * combined(&tableau.stages[i], &self.forces, j);
                residual[j] = (start.p.as_ref()[j] - momentum[j]) + (start.p_lost.as_ref()[j] + increment);
            }
        }
        report.evaluations += S as u64;
        report.iterations += 1;
    }

    /// Factors the mass matrices; `None` if one is not positive definite.
    #[inline]
    fn factor_masses(&mut self, time: f64) -> Option<()> {
        let n = self.dimension();
        self.expansions.iter_mut().try_for_each(|at| factor_mass::<C>(time, &mut at.mass, n).ok())
    }

    /// Whether every component of every rᵢ is at the rounding of the terms it is made of.
    fn residuals_are_rounding(&mut self, start: &Canonical<C>, h: f64) -> bool {
        (0..S).all(|i| {
            let (velocity, mass) = (self.velocities[i].as_ref(), &self.expansions[i].mass);
            bound_momentum::<C>(mass, velocity, self.increment.as_mut());
            (0..velocity.len()).all(|j| {
                let force = self.forces.iter().fold(0.0, |largest: f64, f| largest.max(f.as_ref()[j].abs()));
                let terms = start.p.as_ref()[j].abs() + self.increment.as_ref()[j] + h * force;
                self.residuals[i].as_ref()[j].abs() <= ROUNDING * terms
            })
        })
    }

    /// Vᵢ += Mᵢ⁻¹ rᵢ, less what that changes in the other stages.
    #[inline]
    fn correct_with_mass(
        &mut self,
        tableau: &Tableau<S>,
        start: &Canonical<C>,
        h: f64,
        coupling: Coupling,
    ) -> Correction {
        let mut work = [0.0; 2];
        let originals = self.residuals.clone();
        for (residual, at) in self.residuals.iter_mut().zip(&self.expansions) {
            solve_factored::<C>(&at.mass, residual.as_mut());
        }
        if coupling == Coupling::Included {
            self.uncouple(tableau, h);
        }
        for i in 0..S {
            let (velocity, momentum) = (self.velocities[i].as_mut(), self.momenta[i].as_ref());
            let (correction, original) = (self.residuals[i].as_ref(), originals[i].as_ref());
            for j in 0..velocity.len() {
                work[0] += (original[j] * correction[j]).abs();
                work[1] += (velocity[j] * momentum[j]).abs();
                velocity[j] += correction[j];
            }
        }
        self.measure(start, h, work)
    }

    /// dᵢ −= Mᵢ⁻¹ h Σₖ aᵢₖ (G dₖ − h K Σₗ aₖₗ dₗ) for the corrections d in `residuals`.
    fn uncouple(&mut self, tableau: &Tableau<S>, h: f64) {
        let n = self.dimension();
        let at = &self.curvature;
        let (vq, by_v) = (C::entries(&at.vq), C::entries(&at.applied_v));
        let (qq, by_q) = (C::entries(&at.qq), C::entries(&at.applied_q));
        for k in 0..S {
            for (j, moved) in self.increment.as_mut().iter_mut().enumerate() {
                *moved = h * combined(&tableau.stages[k], &self.residuals, j);
            }
            let (d, moved) = (self.residuals[k].as_ref(), self.increment.as_ref());
            for (r, coupled) in self.coupled[k].as_mut().iter_mut().enumerate() {
                *coupled = 0.0;
                for c in 0..n {
                    let (rc, cr) = (r * n + c, c * n + r);
                    *coupled += (vq[rc] - vq[cr] - by_v[rc]) * d[c] - (qq[rc] + by_q[rc]) * moved[c];
                }
            }
        }
        for i in 0..S {
            for (j, change) in self.increment.as_mut().iter_mut().enumerate() {
                *change = h * combined(&tableau.stages[i], &self.coupled, j);
            }
            solve_factored::<C>(&self.expansions[i].mass, self.increment.as_mut());
            for (d, change) in self.residuals[i].as_mut().iter_mut().zip(self.increment.as_ref()) {
                *d -= change;
            }
        }
    }

    /// fᵢ += (∂²L/∂q∂v + ∂F/∂v) dᵢ + h K Σⱼ aᵢⱼ dⱼ for the last corrections d: the forces were evaluated before them, and
    /// that error, h fᵢ′ dᵢ in p, falls with the plain contraction only.
    fn correct_forces(&mut self, tableau: &Tableau<S>, h: f64) {
        let n = self.dimension();
        let at = &self.curvature;
        let (vq, by_v) = (C::entries(&at.vq), C::entries(&at.applied_v));
        let (qq, by_q) = (C::entries(&at.qq), C::entries(&at.applied_q));
        for i in 0..S {
            let (force, d) = (self.forces[i].as_mut(), self.residuals[i].as_ref());
            for c in 0..n {
                let moved = h * combined(&tableau.stages[i], &self.residuals, c);
                for (r, force) in force.iter_mut().enumerate() {
                    let rc = r * n + c;
                    *force += (vq[c * n + r] + by_v[rc]) * d[c] + (qq[rc] + by_q[rc]) * moved;
                }
            }
        }
    }

    /// The size of the corrections in `residuals`, already made, from w = ΔᵀMΔ and Σ|v p|.
    #[inline]
    pub(super) fn measure(&self, start: &Canonical<C>, h: f64, [work, scale]: [f64; 2]) -> Correction {
        let energetic = (work / (work + scale)).sqrt();
        let mut correction = Correction { work, energetic, ..Correction::default() };
        for j in 0..self.dimension() {
            let (mut change, mut size) = (0.0_f64, 0.0_f64);
            for i in 0..S {
                let d = self.residuals[i].as_ref()[j].abs();
                // A NaN must come through, which `max` would drop.
                change = if d <= change { change } else { d };
                size = size.max(self.velocities[i].as_ref()[j].abs());
            }
            if change != 0.0 {
                let strict = change / size;
                let (before, q) = (self.start_velocity.as_ref()[j], start.q.as_ref()[j]);
                let scale = noise_scale(size, before, q, h);
                correction.strict = if strict <= correction.strict { correction.strict } else { strict };
                correction.noise = correction.noise.max(change / scale);
            }
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
