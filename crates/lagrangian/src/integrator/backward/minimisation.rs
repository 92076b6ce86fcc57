//! The incremental potential in the unknown velocity, for core's minimiser.

use super::Anchor;
use crate::coordinates::Coordinates;
use crate::error::LagrangianError;
use crate::integrator::StepReport;
use crate::system::{Curvature, Expansion, System};
use mechanics_core::newton::{self, NewtonOptions};
use mechanics_core::objective::{DenseObjective, DenseProblem};
use nalgebra::DMatrix;
use std::cell::Cell;

/// The minimiser goes this far, relative to the velocities; what follows is Newton's method on the gradient.
const ACCURACY: f64 = 1e-6;

/// E(w), with counts of evaluations.
struct IncrementalEnergy<'a, S: System> {
    system: &'a S,
    anchor: &'a Anchor<'a, S::Coordinates>,
    applied: bool,
    evaluations: Cell<u64>,
    curvatures: Cell<u64>,
}

/// Moves `velocity` to the minimum of the incremental potential.
pub(super) fn minimise<S: System>(
    system: &S,
    anchor: &Anchor<'_, S::Coordinates>,
    velocity: &mut S::Coordinates,
    report: &mut StepReport,
) -> Result<(), LagrangianError> {
    let applied = system.dependence(anchor.end_time(), &anchor.start.q, velocity).applied();
    let energy =
        IncrementalEnergy { system, anchor, applied, evaluations: Cell::new(0), curvatures: Cell::new(0) };
    let tolerance = energy.accuracy(velocity.as_ref());
    let mut objective = DenseObjective::new(energy);
    let options = NewtonOptions { tolerance, ..NewtonOptions::default() };
    let result = newton::minimise(&mut objective, velocity.as_mut(), &options);
    let IncrementalEnergy { evaluations, curvatures, .. } = objective.problem;
    report.evaluations += evaluations.get();
    report.curvatures += curvatures.get();
    match result {
        Ok(done) => {
            report.iterations += done.iterations;
            Ok(())
        }
        Err(error) => {
            let step = ACCURACY * error.progress.step_norm / tolerance;
            Err(anchor.not_converged(report.iterations + error.report.iterations, step))
        }
    }
}

impl<S: System> IncrementalEnergy<'_, S> {
    fn expand(&self, w: &[f64]) -> Expansion<S::Coordinates> {
        let n = w.len();
        let (mut q, mut v) = (S::Coordinates::zeros(n), S::Coordinates::zeros(n));
        v.as_mut().copy_from_slice(w);
        self.anchor.end_into(w, &mut q);
        let mut at = Expansion::zeros(n);
        self.system.expand(self.anchor.end_time(), &q, &v, &mut at);
        self.evaluations.set(self.evaluations.get() + 1);
        at
    }

    fn target(&self, j: usize) -> f64 {
        let start = self.anchor.start;
        start.p.as_ref()[j] + (start.p_lost.as_ref()[j] + self.anchor.drift_p.as_ref()[j])
    }

    /// ∫₀¹ F·η w ds by Gauss quadrature with five nodes, exact where F is a polynomial of degree 9.
    fn work(&self, w: &[f64]) -> f64 {
        const NODES: [f64; 5] = [
            -0.906_179_845_938_664,
            -0.538_469_310_105_683_1,
            0.0,
            0.538_469_310_105_683_1,
            0.906_179_845_938_664,
        ];
        const WEIGHTS: [f64; 5] = [
            0.236_926_885_056_189_1,
            0.478_628_670_499_366_5,
            0.568_888_888_888_888_9,
            0.478_628_670_499_366_5,
            0.236_926_885_056_189_1,
        ];
        let power = |x: f64| {
            let part: Vec<f64> = w.iter().map(|w| 0.5 * (1.0 + x) * w).collect();
            let at = self.expand(&part);
            at.applied.as_ref().iter().zip(w).map(|(f, w)| f * w).sum::<f64>()
        };
        let sum: f64 = NODES.iter().zip(WEIGHTS).map(|(&x, weight)| 0.5 * weight * power(x)).sum();
        self.anchor.eta * sum
    }

    /// How far the minimiser goes: a part of the velocities, but not below what rounding of the positions makes of them.
    fn accuracy(&self, w: &[f64]) -> f64 {
        let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let rounding = f64::EPSILON * largest(self.anchor.start.q.as_ref()) / self.anchor.eta;
        (ACCURACY * self.speed(w)).max(64.0 * rounding)
    }

    /// The largest |w| or η|M⁻¹ f|-like velocity: what a correction is compared with.
    fn speed(&self, w: &[f64]) -> f64 {
        let at = self.expand(w);
        let n = w.len();
        let speed = |j: usize| {
            let force = at.slope.as_ref()[j] + at.applied.as_ref()[j];
            let mass = S::Coordinates::entries(&at.mass)[j * n + j];
            w[j].abs() + (self.anchor.eta * force / mass).abs()
        };
        let largest = (0..n).map(speed).filter(|speed| speed.is_finite()).fold(0.0, f64::max);
        largest.max(f64::MIN_POSITIVE / ACCURACY)
    }
}

impl<S: System> DenseProblem for IncrementalEnergy<'_, S> {
    fn dimension(&self) -> usize {
        self.system.dimension()
    }

    fn value(&self, w: &[f64]) -> f64 {
        let at = self.expand(w);
        let known: f64 = w.iter().enumerate().map(|(j, w)| self.target(j) * w).sum();
        let work = if self.applied { self.work(w) } else { 0.0 };
        at.kinetic - known + at.potential - work
    }

    fn gradient_into(&self, w: &[f64], gradient: &mut [f64]) {
        let at = self.expand(w);
        for (j, g) in gradient.iter_mut().enumerate() {
            let force = at.slope.as_ref()[j] + at.applied.as_ref()[j];
            *g = at.momentum.as_ref()[j] - self.target(j) - self.anchor.eta * force;
        }
    }

    fn hessian_into(&self, w: &[f64], hessian: &mut DMatrix<f64>) {
        let n = w.len();
        let (mut q, mut v) = (S::Coordinates::zeros(n), S::Coordinates::zeros(n));
        v.as_mut().copy_from_slice(w);
        self.anchor.end_into(w, &mut q);
        let mut at = Curvature::zeros(n);
        self.system.curve(self.anchor.end_time(), &q, &v, &mut at);
        self.curvatures.set(self.curvatures.get() + 1);
        let eta = self.anchor.eta;
        let entries = S::Coordinates::entries;
        let entry = |k: usize| {
            let stiffness = entries(&at.qq)[k] + entries(&at.applied_q)[k];
            entries(&at.vv)[k] - eta * entries(&at.applied_v)[k] - eta * eta * stiffness
        };
        for i in 0..n {
            for j in 0..n {
                hessian[(i, j)] = 0.5 * (entry(i * n + j) + entry(j * n + i));
            }
        }
    }
}
