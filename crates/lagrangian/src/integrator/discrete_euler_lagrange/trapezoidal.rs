//! The step with the trapezoidal discrete Lagrangian.

use crate::coordinates::{Coordinates, Phase};
use crate::dense::{bound_momentum, factor_mass, solve_factored, solve_general};
use crate::error::{LagrangianError, Symbol};
use crate::integrator::canonical::{Canonical, Left, check_finite};
use crate::integrator::convergence::{
    Convergence, Correction, Iteration, ROUNDING, TOLERANCE, Verdict, noise_scale,
};
use crate::integrator::{StepReport, admit, assert_sizes};
use crate::system::{Curvature, Expansion, System};

pub(super) const NAME: &str = "discrete Euler–Lagrange, trapezoidal";

#[derive(Clone, Debug)]
pub(super) struct Trapezoidal<C: Coordinates> {
    history: Option<History<C>>,
    solver: Option<Box<Solver<C>>>,
}

#[derive(Clone, Debug)]
struct History<C> {
    left: Left<C>,
    acceleration: C,
    /// The last step's w and h.
    velocity: C,
    step: f64,
    rate: f64,
}

/// The unknown w, and room for what is evaluated on the way.
#[derive(Clone, Debug)]
struct Solver<C: Coordinates> {
    velocity: C,
    start_velocity: C,
    end: C,
    at_start: Expansion<C>,
    at_end: Expansion<C>,
    residual: C,
    correction: C,
}

impl<C: Coordinates> Trapezoidal<C> {
    pub(super) fn new() -> Self {
        Self { history: None, solver: None }
    }

    pub(super) fn step<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        h: f64,
    ) -> Result<StepReport, LagrangianError> {
        let n = system.dimension();
        assert_sizes(system, phase, n);
        admit(phase, h)?;
        let mut report = StepReport::default();
        let mut solver = match self.solver.take() {
            Some(solver) if solver.velocity.as_ref().len() == n => solver,
            _ => Box::new(Solver::new(n)),
        };
        let result = self.advance(system, phase, h, &mut solver, &mut report);
        self.solver = Some(solver);
        result.map(|()| report)
    }

    fn advance<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        h: f64,
        solver: &mut Solver<C>,
        report: &mut StepReport,
    ) -> Result<(), LagrangianError> {
        solver.start_velocity.clone_from(&phase.v);
        let history = self.history.as_ref().filter(|history| history.left.is(phase, h));
        let (start, acceleration, rate) = match history {
            Some(history) => {
                solver.predict(history, phase, h);
                (history.left.canonical.clone(), history.acceleration.clone(), history.rate)
            }
            None => {
                report.evaluations += 1;
                let (start, a) = Canonical::of_phase(system, phase, &mut solver.at_start)?;
                solver.predict_linearly(phase, &a, h);
                (start, a, 1.0)
            }
        };
        let rate = match solver.iterate(system, &start, h, rate, report) {
            Some(rate) => rate,
            None => {
                solver.predict_linearly(phase, &acceleration, h);
                solver.solve_by_newton(system, &start, h, report)?
            }
        };
        let mut end = start;
        solver.advance(h, &mut end);
        // v ≈ w + h a/2.
        let mut v = solver.velocity.clone();
        for (j, v) in v.as_mut().iter_mut().enumerate() {
            *v += 0.5 * h * acceleration.as_ref()[j];
        }
        let found = end.solve_velocity(system, &mut v, &mut solver.at_end);
        report.evaluations += found.map_err(|lost| solver.not_converged(phase.time, h, report, lost.0))?;
        check_finite(Symbol::Coordinate, end.time, end.q.as_ref())?;
        check_finite(Symbol::Velocity, end.time, v.as_ref())?;
        let acceleration = solver.end_acceleration();
        *phase = Phase { time: end.time, q: end.q.clone(), v };
        let left = Left { phase: phase.clone(), canonical: end };
        self.history = Some(History { left, acceleration, velocity: solver.velocity.clone(), step: h, rate });
        Ok(())
    }
}

impl<C: Coordinates> Solver<C> {
    fn new(n: usize) -> Self {
        let zeros = || C::zeros(n);
        let (at_start, at_end) = (Expansion::zeros(n), Expansion::zeros(n));
        Self {
            velocity: zeros(),
            start_velocity: zeros(),
            end: zeros(),
            at_start,
            at_end,
            residual: zeros(),
            correction: zeros(),
        }
    }

    /// w = v + h a/2.
    fn predict_linearly(&mut self, phase: &Phase<C>, a: &C, h: f64) {
        for (j, w) in self.velocity.as_mut().iter_mut().enumerate() {
            *w = phase.v.as_ref()[j] + 0.5 * h * a.as_ref()[j];
        }
    }

    /// w at τ = h/2 on the parabola with the end velocity, the end acceleration, and the last w at τ = −k/2 (k the last
    /// step): v + τ a + c τ² with c from the last.
    fn predict(&mut self, history: &History<C>, phase: &Phase<C>, h: f64) {
        let (half, back) = (0.5 * h, 0.5 * history.step);
        for (j, w) in self.velocity.as_mut().iter_mut().enumerate() {
            let (v, a) = (phase.v.as_ref()[j], history.acceleration.as_ref()[j]);
            let bend = (history.velocity.as_ref()[j] - v + back * a) / (back * back);
            *w = v + half * (a + half * bend);
        }
    }

    fn iterate<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        start: &Canonical<C>,
        h: f64,
        rate: f64,
        report: &mut StepReport,
    ) -> Option<f64> {
        let n = system.dimension();
        let mut convergence = Convergence::new(Iteration::Simple, rate, 5, 60);
        let mut stalled = false;
        loop {
            self.evaluate(system, start, h, report);
            let end_mass = C::entries(&self.at_end.mass);
            for (m, end) in C::entries_mut(&mut self.at_start.mass).iter_mut().zip(end_mass) {
                *m = 0.5 * (*m + end);
            }
            factor_mass::<C>(start.time, &mut self.at_start.mass, n).ok()?;
            if stalled && self.residual_is_rounding(start, h) {
                return Some(convergence.rate.min(1.0));
            }
            self.correction.clone_from(&self.residual);
            solve_factored::<C>(&self.at_start.mass, self.correction.as_mut());
            match convergence.judge(self.correct(start, h)) {
                Verdict::Continue => {}
                Verdict::Stalled => stalled = true,
                Verdict::Converged => return Some(convergence.rate.min(1.0)),
                Verdict::Failing => return None,
            }
        }
    }

    fn solve_by_newton<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        start: &Canonical<C>,
        h: f64,
        report: &mut StepReport,
    ) -> Result<f64, LagrangianError> {
        let n = system.dimension();
        let (mut curve_0, mut curve_1) = (Curvature::zeros(n), Curvature::zeros(n));
        let mut matrix = vec![0.0; n * n];
        let mut convergence = Convergence::new(Iteration::Newton, 1.0, 15, 30);
        loop {
            self.evaluate(system, start, h, report);
            system.curve(start.time, &start.q, &self.velocity, &mut curve_0);
            system.curve(start.time + h, &self.end, &self.velocity, &mut curve_1);
            report.curvatures += 2;
            let (vv_0, vv_1) = (C::entries(&curve_0.vv), C::entries(&curve_1.vv));
            let (vq_0, vq_1) = (C::entries(&curve_0.vq), C::entries(&curve_1.vq));
            let applied_0 = C::entries(&curve_0.applied_v);
            for i in 0..n {
                for j in 0..n {
                    let (at, transposed) = (i * n + j, j * n + i);
                    matrix[at] =
                        0.5 * (vv_0[at] + vv_1[at]) + 0.5 * h * (vq_1[at] - vq_0[transposed] - applied_0[at]);
                }
            }
            self.correction.clone_from(&self.residual);
            let verdict = match solve_general(&mut matrix, self.correction.as_mut()) {
                Some(()) => convergence.judge(self.correct(start, h)),
                None => Verdict::Failing,
            };
            match verdict {
                Verdict::Continue | Verdict::Stalled => {}
                Verdict::Converged => return Ok(1.0),
                Verdict::Failing => {
                    return Err(self.not_converged(start.time, h, report, convergence.correction()));
                }
            }
        }
    }

    /// Expansions at (q₀, w) and (q₀ + h w, w), and r.
    fn evaluate<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        start: &Canonical<C>,
        h: f64,
        report: &mut StepReport,
    ) {
        let w = self.velocity.as_ref();
        for (j, q) in self.end.as_mut().iter_mut().enumerate() {
            *q = start.q.as_ref()[j] + (start.q_lost.as_ref()[j] + h * w[j]);
        }
        system.expand(start.time, &start.q, &self.velocity, &mut self.at_start);
        system.expand(start.time + h, &self.end, &self.velocity, &mut self.at_end);
        let (first, last) = (&self.at_start, &self.at_end);
        for (j, r) in self.residual.as_mut().iter_mut().enumerate() {
            let mean = 0.5 * (first.momentum.as_ref()[j] + last.momentum.as_ref()[j]);
            let force = first.slope.as_ref()[j] + first.applied.as_ref()[j];
            *r = (start.p.as_ref()[j] - mean) + (start.p_lost.as_ref()[j] + 0.5 * h * force);
        }
        report.evaluations += 2;
        report.iterations += 1;
    }

    /// Whether every component of r is at the rounding of the terms it is made of.
    fn residual_is_rounding(&mut self, start: &Canonical<C>, h: f64) -> bool {
        bound_momentum::<C>(&self.at_start.mass, self.velocity.as_ref(), self.correction.as_mut());
        (0..self.residual.as_ref().len()).all(|j| {
            let force = self.at_start.slope.as_ref()[j].abs() + self.at_start.applied.as_ref()[j].abs();
            let terms = start.p.as_ref()[j].abs() + self.correction.as_ref()[j] + h * force;
            self.residual.as_ref()[j].abs() <= ROUNDING * terms
        })
    }

    /// w += the correction, and how large that is.
    fn correct(&mut self, start: &Canonical<C>, h: f64) -> Correction {
        let mut size = Correction::default();
        let (mut work, mut scale) = (0.0, 0.0);
        for (j, w) in self.velocity.as_mut().iter_mut().enumerate() {
            let d = self.correction.as_ref()[j];
            work += (d * self.residual.as_ref()[j]).abs();
            scale += (*w * self.at_end.momentum.as_ref()[j]).abs();
            *w += d;
            if d != 0.0 {
                let strict = (d / *w).abs();
                size.strict = if strict <= size.strict { size.strict } else { strict };
                let (before, q) = (self.start_velocity.as_ref()[j], start.q.as_ref()[j]);
                let scale = noise_scale(*w, before, q, h);
                size.noise = size.noise.max(d.abs() / scale);
            }
        }
        size.work = work;
        size.energetic = (work / (work + scale)).sqrt();
        size
    }

    /// q₁ = q₀ + h w, p₁ = p₀ + (h/2)(f₀ + f₁), which is the second equation with the first put in.
    fn advance(&mut self, h: f64, state: &mut Canonical<C>) {
        let (first, last) = (&self.at_start, &self.at_end);
        for (j, increment) in self.residual.as_mut().iter_mut().enumerate() {
            let force = |at: &Expansion<C>| at.slope.as_ref()[j] + at.applied.as_ref()[j];
            *increment = 0.5 * h * (force(first) + force(last));
        }
        state.add_to_p(&self.residual);
        for (increment, w) in self.residual.as_mut().iter_mut().zip(self.velocity.as_ref()) {
            *increment = h * w;
        }
        state.add_to_q(&self.residual);
        state.advance_time(h);
    }

    fn end_acceleration(&self) -> C {
        let at = &self.at_end;
        let mut acceleration = at.slope.clone();
        for (j, a) in acceleration.as_mut().iter_mut().enumerate() {
            *a += at.applied.as_ref()[j] - at.momentum_rate.as_ref()[j];
        }
        solve_factored::<C>(&at.mass, acceleration.as_mut());
        acceleration
    }

    fn not_converged(&self, time: f64, step: f64, report: &StepReport, correction: f64) -> LagrangianError {
        let iterations = report.iterations as u32;
        LagrangianError::NotConverged {
            method: NAME,
            time,
            step,
            iterations,
            correction,
            tolerance: TOLERANCE,
        }
    }
}
