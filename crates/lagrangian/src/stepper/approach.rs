//! Scripted points on their way to targets that they cannot jump to.
//!
//! A scripted point has no unknown: at the start of a step it is put to its target t, all else where it was. With a barrier that may
//! be on the other side of a body. So the jump is asked for first ([`admits`]): every term says how much of it is admissible
//! and is evaluated at its end. If a term objects, the scripted points become unknowns s for a while, drawn to their targets by
//! the augmented Lagrangian
//!
//! E(x, s) + Σᵢ ( ½ w ‖sᵢ − tᵢ‖² − λᵢ · (sᵢ − tᵢ) ),
//!
//! which is minimised as any step is, within the terms' limits, so that a plate pushes what is in its way instead of passing
//! through. Where the gradient vanishes, the terms hold sᵢ with the force λᵢ − w (sᵢ − tᵢ); with that as the next λᵢ the minimum
//! lies nearer to t, by the factor k/(k + w) where the terms resist with the stiffness k. w is the median of the unknowns'
//! stiffnesses (the means of the diagonal blocks of the Hessian at the start, inertia included, barriers not), and ten times that after
//! every minimisation which leaves more than a quarter of the way. As soon as [`REMAINDER`] of the longest jump is left and the rest
//! of the way is admissible straight, the points are put at their targets exactly, and the step's own minimisation goes on with them
//! fixed. The minimum found does not depend on w.
//!
//! # Reference
//! Li, Ferguson, Schneider, Langlois, Zorin, Panozzo, Jiang, Kaufman, *Incremental potential contact*, ACM Trans. Graph. 39 (2020),
//! supplement, section on moving boundary conditions; Nocedal, Wright, *Numerical Optimization*, 2nd ed., 2006, section 17.3.

use super::minimisation::{add_times, incremental_potential};
use super::{StepError, StepReport, StepperOptions, report};
use mechanics_core::linear::Solver;
use mechanics_core::newton::{NewtonCause, NewtonError, NewtonOptions, Proceed, Progress, minimise_observed};
use mechanics_core::objective::TimeStep;
use mechanics_core::point_map::{PointMap, PointMapError, PointSource};
use mechanics_core::potential::{Demand, Potential, PotentialError};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::{Assembler, Assembly};
use mechanics_core::tensor::{Mat3, Vec3};

/// Points are put at their targets when so much of the longest jump is left.
const REMAINDER: f64 = 1e-3;
/// The weight grows by this factor after a minimisation that was not good enough.
const GROWTH: f64 = 10.0;
/// Minimisations end at steps of so much of the rest of the way. A barrier squeezed too far opens by steps of the size of its gap:
/// with a tolerance above that it would stay shut.
const EXACTNESS: f64 = 0.1;
/// Minimisations in a row which leave more than half of the way: the target is given up. The weight is 1e6 times the first then.
const STALLED: u32 = 6;
/// Where less than this part of the longest jump is left, but it is not admissible, the target itself is not.
const HOPELESS: f64 = 1e-13;
/// Minimisations in all.
const ROUNDS: u32 = 40;

/// Whether every term admits the straight way of the points `x` by `p`, and is finite at its end.
pub(super) fn admits(
    terms: &mut [&mut dyn Potential],
    x: &[Vec3],
    p: &[Vec3],
) -> Result<bool, PotentialError> {
    for term in terms.iter_mut() {
        let part = term.limit_step(x, p)?.fraction;
        // What is no number is the minimiser's to report.
        if part.is_nan() || part < 1.0 {
            return Ok(false);
        }
    }
    let end: Vec<Vec3> = x.iter().zip(p).map(|(x, p)| x + p).collect();
    Ok(terms.iter().all(|term| term.value(&end).is_finite()))
}

/// The way of scripted points from where they start to their targets.
pub(super) struct Approach<'a> {
    /// The map with scripted points at their targets.
    pub(super) map: &'a PointMap,
    /// The map with scripted points where they start.
    pub(super) map_at_start: &'a PointMap,
    /// The scripted points that move.
    pub(super) moving: &'a [u32],
    pub(super) time_step: TimeStep<'a>,
    pub(super) options: &'a StepperOptions,
}

impl Approach<'_> {
    /// The points at the unknowns `q` at the start, and the jump of the scripted ones.
    pub(super) fn jump(&self, q: &[f64]) -> (Vec<Vec3>, Vec<Vec3>) {
        let mut x = vec![Vec3::zeros(); self.map.points()];
        self.map_at_start.points_into(q, &mut x);
        let p = self.rest_of_way(&x);
        (x, p)
    }

    /// From the points `x` to the targets; zero for points that are not scripted.
    fn rest_of_way(&self, x: &[Vec3]) -> Vec<Vec3> {
        let mut p = vec![Vec3::zeros(); x.len()];
        for &point in self.moving {
            p[point as usize] = self.map.offset(point as usize) - x[point as usize];
        }
        p
    }

    /// Moves the unknowns `q` until scripted points stand at their targets.
    pub(super) fn pull(
        &self,
        terms: &mut [&mut dyn Potential],
        q: &mut [f64],
        observer: &mut dyn FnMut(&Progress) -> Proceed,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let time = self.time_step.time;
        let refused = |source| StepError::Term { time, source };
        let released = self.released()?;
        let (mut x, p) = self.jump(q);
        let jump = largest(&p);
        let mut all = vec![0.0; 3 * released.unknowns()];
        released.unknowns_into(&x, &mut all)?;
        let (mut assembly, mut solver) = (Assembly::new(&released), Solver::new(self.options.method));
        let mut pull = Pull::new(self, self.median_stiffness(terms, &released, &all));
        let a = self.time_step.scheme.coefficients.velocity;
        let mut newton = NewtonOptions { tolerance: a * REMAINDER * jump, ..self.options.newton };
        let (mut nearest, mut stalled) = (jump, 0);
        for _ in 0..ROUNDS {
            let mut pulled: Vec<&mut dyn Potential> =
                terms.iter_mut().map(|term| &mut **term as &mut dyn Potential).collect();
            pulled.push(&mut pull);
            let mut objective = incremental_potential(
                &mut pulled,
                &released,
                self.time_step,
                &mut assembly,
                &mut solver,
                self.options,
            );
            let outcome = minimise_observed(&mut objective, &mut all, &newton, observer);
            // The pull comes last and has no report.
            add_times(&mut report.terms, objective.term_times());
            let done = outcome.map_err(|source| self.failure(&x, source))?;
            report::add(&mut report.newton, &done);
            report.pulls += 1;
            released.points_into(&all, &mut x);
            let rest = self.rest_of_way(&x);
            let remaining = largest(&rest);
            if remaining <= REMAINDER * jump && admits(terms, &x, &rest).map_err(refused)? {
                q.copy_from_slice(&all[..q.len()]);
                return Ok(());
            }
            pull.take_over(&x);
            if remaining > 0.25 * nearest {
                pull.weight *= GROWTH;
            }
            newton.tolerance = newton.tolerance.min(EXACTNESS * a * remaining);
            stalled = if remaining > 0.5 * nearest { stalled + 1 } else { 0 };
            nearest = nearest.min(remaining);
            if stalled == STALLED || remaining < HOPELESS * jump {
                break;
            }
        }
        Err(self.unreached(&x, None))
    }

    /// The map in which scripted points that move have unknowns, behind all others.
    fn released(&self) -> Result<PointMap, PointMapError> {
        let map = self.map;
        let mut pairs = vec![Vec::new(); map.points()];
        for (point, pairs) in pairs.iter_mut().enumerate() {
            map.for_each_unknown(point, |unknown, w| pairs.push((unknown, w)));
        }
        for (&point, unknown) in self.moving.iter().zip(map.unknowns() as u32..) {
            pairs[point as usize].push((unknown, 1.0));
        }
        let sources = pairs.iter().map(|pairs| PointSource::Weighted(pairs));
        let mut released = PointMap::new(map.unknowns() + self.moving.len(), sources)?;
        for point in 0..map.points() {
            released.set_offset(point, map.offset(point))?;
        }
        for &point in self.moving {
            released.set_offset(point as usize, Vec3::zeros())?;
        }
        Ok(released)
    }

    /// The median over unknowns of the mean of their diagonal blocks [N/m], barriers left out; one if nothing resists.
    fn median_stiffness(&self, terms: &mut [&mut dyn Potential], map: &PointMap, q: &[f64]) -> f64 {
        let lasting = terms.iter_mut().filter(|term| term.demand() == Demand::Nothing);
        let mut lasting: Vec<&mut dyn Potential> =
            lasting.map(|term| &mut **term as &mut dyn Potential).collect();
        let (mut assembly, mut solver) = (Assembly::new(map), Solver::new(self.options.method));
        let mut objective = incremental_potential(
            &mut lasting,
            map,
            self.time_step,
            &mut assembly,
            &mut solver,
            self.options,
        );
        let hessian = objective.hessian(q);
        let means = (0..map.unknowns()).map(|unknown| hessian.diagonal(unknown).trace().abs() / 3.0);
        let mut means: Vec<f64> = means.filter(|&mean| mean > 0.0 && mean.is_finite()).collect();
        means.sort_by(f64::total_cmp);
        means.get(means.len() / 2).copied().unwrap_or(1.0)
    }

    /// What to say of a minimisation that failed with the points at `x`.
    fn failure(&self, x: &[Vec3], source: Box<NewtonError>) -> StepError {
        let TimeStep { time, step, .. } = self.time_step;
        match source.cause {
            NewtonCause::Blocked { .. }
            | NewtonCause::LineSearch { .. }
            | NewtonCause::NoFiniteValue { .. }
            | NewtonCause::NotDescending { .. }
            | NewtonCause::Diverged { .. }
            | NewtonCause::Stagnated { .. }
            | NewtonCause::NotConverged { .. } => self.unreached(x, Some(source)),
            _ => StepError::Newton { time, step, source },
        }
    }

    fn unreached(&self, x: &[Vec3], source: Option<Box<NewtonError>>) -> StepError {
        let rest = self.rest_of_way(x);
        let by_rest = |a: &&u32, b: &&u32| rest[**a as usize].norm().total_cmp(&rest[**b as usize].norm());
        // There is one, else nothing would have been in its way.
        let point = self.moving.iter().max_by(by_rest).copied().unwrap_or(0);
        let target = self.map.offset(point as usize).into();
        let remaining = rest[point as usize].norm();
        StepError::Unreached { point, target, remaining, time: self.time_step.time, source }
    }
}

fn largest(p: &[Vec3]) -> f64 {
    p.iter().map(Vec3::norm).fold(0.0, f64::max)
}

/// Σᵢ ½ w ‖xᵢ − tᵢ‖² − λᵢ · (xᵢ − tᵢ) \[J\].
struct Pull {
    points: Vec<[u32; 1]>,
    /// t \[m\].
    targets: Vec<Vec3>,
    /// λ \[N\].
    multipliers: Vec<Vec3>,
    /// w [N/m].
    weight: f64,
}

impl Pull {
    fn new(approach: &Approach<'_>, weight: f64) -> Self {
        let targets = approach.moving.iter().map(|&point| approach.map.offset(point as usize));
        Self {
            points: approach.moving.iter().map(|&point| [point]).collect(),
            targets: targets.collect(),
            multipliers: vec![Vec3::zeros(); approach.moving.len()],
            weight,
        }
    }

    /// Makes the forces at `x` the multipliers: λᵢ − w (xᵢ − tᵢ).
    fn take_over(&mut self, x: &[Vec3]) {
        for ((&[point], target), multiplier) in
            self.points.iter().zip(&self.targets).zip(&mut self.multipliers)
        {
            *multiplier -= (x[point as usize] - target) * self.weight;
        }
    }
}

impl Potential for Pull {
    fn name(&self) -> &str {
        "pull on scripted points"
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        let own = self.points.iter().zip(&self.targets).zip(&self.multipliers);
        own.map(|((&[point], target), multiplier)| {
            let offset = x[point as usize] - target;
            0.5 * self.weight * offset.norm_squared() - multiplier.dot(&offset)
        })
        .sum()
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        for ((&[point], target), multiplier) in self.points.iter().zip(&self.targets).zip(&self.multipliers) {
            gradient[point as usize] += (x[point as usize] - target) * self.weight - multiplier;
        }
    }

    fn add_hessian(&self, _: &[Vec3], _: Projection, hessian: &mut Assembler<'_>) {
        hessian.add(&self.points, |_| [[Mat3::from_diagonal_element(self.weight)]]);
    }
}
