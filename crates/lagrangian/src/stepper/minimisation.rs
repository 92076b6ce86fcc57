//! One minimisation of the incremental potential: freezing, the way of scripted points, lag iterations.

use super::approach::{Approach, admits};
use super::settling::{is_due, settle};
use super::{Lagging, Minimum, StepError, StepReport, Stepper, StepperOptions, TermReport, Terms, report};
use mechanics_core::linear::{Algorithm, FactorReport, LinearError, LinearSolver, Solver};
use mechanics_core::newton::{Proceed, Progress, minimise_observed};
use mechanics_core::objective::{DenseCholesky, IncrementalPotential, Limit, Objective, TermTimes, TimeStep};
use mechanics_core::point_map::{PointMap, PointMapError};
use mechanics_core::potential::{Changed, Demand, Potential, PotentialError};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::{Assembly, BlockMatrix};
use mechanics_core::stage::Moment;
use mechanics_core::tensor::Vec3;

/// What is minimised over, and from where.
#[derive(Clone, Copy)]
pub(super) struct Minimisation<'a> {
    /// The map with scripted points at their targets.
    pub(super) map: &'a PointMap,
    /// Positions at the start \[m\], scripted points among them.
    pub(super) start: &'a [Vec3],
    pub(super) time_step: TimeStep<'a>,
    /// Where the unknowns may be expected at the end.
    pub(super) expected: &'a [f64],
}

/// How scripted points came to their targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Arrival {
    /// Straight there, all else where it was.
    Jumped,
    /// Pulled there, pushing what is in their way.
    Pulled,
}

impl Minimisation<'_> {
    /// Scripted points whose targets are not where they start.
    fn moving(&self, scripted: &[u32]) -> Vec<u32> {
        let moves = |&&point: &&u32| self.map.offset(point as usize) != self.start[point as usize];
        scripted.iter().filter(moves).copied().collect()
    }

    /// The map with scripted points where they start.
    fn map_at_start(&self, scripted: &[u32]) -> Result<PointMap, PointMapError> {
        let mut map = self.map.clone();
        for &point in scripted {
            map.set_offset(point as usize, self.start[point as usize])?;
        }
        Ok(map)
    }
}

impl Stepper {
    /// Minimises over the unknowns `q`, lagged data included. Terms are frozen at the start, before anything moves.
    pub(super) fn minimise(
        &mut self,
        terms: Terms<'_, '_>,
        minimisation: &Minimisation<'_>,
        q: &mut [f64],
        observer: &mut dyn FnMut(&Progress) -> Proceed,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let &Minimisation { map, time_step, expected, .. } = minimisation;
        let TimeStep { time, step, .. } = time_step;
        let refused = |source| StepError::Term { time, source };
        let moving = minimisation.moving(&self.scripted);
        let map_at_start = minimisation.map_at_start(&moving)?;
        let patterns = self.assembly.counts().pattern_changes;
        self.freeze(terms, &map_at_start, time_step, q, report).map_err(refused)?;
        self.order(terms, &map_at_start, time_step, q);
        let Self { inertia, options, assembly, solver, .. } = self;
        let mut all: Vec<&mut dyn Potential> = Vec::with_capacity(terms.len() + 1);
        all.push(inertia);
        all.extend(terms.iter_mut().map(|term| &mut **term as &mut dyn Potential));

        let approach = Approach { map, map_at_start: &map_at_start, moving: &moving, time_step, options };
        let arrival = arrive(&approach, &mut all, q, observer, report)?;

        let mut objective = incremental_potential(&mut all, map, time_step, assembly, solver, options);
        let mut iterations = 0;
        loop {
            if iterations == 0 && arrival == Arrival::Jumped {
                start_towards(expected, &mut objective, q);
            }
            let newton = minimise_observed(&mut objective, q, &options.newton, observer)
                .map_err(|source| StepError::Newton { time, step, source })?;
            report::add(&mut report.newton, &newton);
            iterations += 1;
            match options.lagging {
                Lagging::Once => break,
                Lagging::AtMost(most) if iterations >= most => break,
                Lagging::AtMost(_) | Lagging::Until(_) => {}
            }
            let changed = objective.freeze_at(Moment::Lag, q).map_err(refused)?;
            if changed == Changed::Nothing {
                break;
            }
            if let Lagging::Until(most) = options.lagging
                && iterations >= most
            {
                return Err(StepError::Lagging { time, iterations });
            }
            if is_due(iterations) {
                let speed = largest_speed(map, time_step, q);
                let is_settled = settle(&mut objective, options, speed, q).map_err(refused)?;
                report.settlings += u64::from(is_settled);
            }
        }
        add_times(&mut report.terms, objective.term_times());
        report.lag_iterations += iterations;
        report.pattern_changes += self.assembly.counts().pattern_changes - patterns;
        report.hessian_blocks = self.assembly.matrix().pattern().block_count() as u64;
        Ok(())
    }

    /// Freezes all terms at the start of a step or of a part of the load.
    fn freeze(
        &mut self,
        terms: Terms<'_, '_>,
        map: &PointMap,
        time_step: TimeStep<'_>,
        q: &[f64],
        report: &mut StepReport,
    ) -> Result<(), PotentialError> {
        let Self { inertia, options, assembly, solver, .. } = self;
        let mut all: Vec<&mut dyn Potential> = vec![inertia];
        all.extend(terms.iter_mut().map(|term| &mut **term as &mut dyn Potential));
        let names: Vec<String> = all.iter().map(|term| term.name().to_owned()).collect();
        let mut objective = incremental_potential(&mut all, map, time_step, assembly, solver, options);
        let _: Changed = objective.freeze_at(Moment::Step, q)?;
        let _: Changed = objective.freeze_at(Moment::Lag, q)?;
        add_terms(&mut report.terms, &names, objective.term_times());
        Ok(())
    }

    /// Orders the elimination for the pattern of the terms whose elements stay, once for the same elements. The terms are frozen
    /// already: their elements are those of this step, not of the one before.
    fn order(&mut self, terms: Terms<'_, '_>, map: &PointMap, time_step: TimeStep<'_>, q: &[f64]) {
        let mut lasting: Vec<&mut dyn Potential> = vec![&mut self.inertia];
        let lasts = |term: &&mut &mut dyn Potential| term.demand() == Demand::Nothing;
        lasting.extend(terms.iter_mut().filter(lasts).map(|term| &mut **term as &mut dyn Potential));
        let mut x = vec![Vec3::zeros(); map.points()];
        map.points_into(q, &mut x);
        let elements = self.assembly.fingerprint(|assembler| {
            for (number, term) in lasting.iter().enumerate() {
                assembler.begin_term(number);
                term.add_hessian(&x, Projection::None, assembler);
            }
        });
        if self.ordered_for == Some(elements) {
            return;
        }
        let mut assembly = Assembly::new(map);
        let mut objective =
            IncrementalPotential::new(&mut lasting, map, time_step, &mut assembly, &mut self.solver);
        let pattern = objective.hessian(q).pattern().clone();
        self.solver.start_from(&pattern);
        self.ordered_for = Some(elements);
    }

    /// Whether the true Hessian at the unknowns `q` is positive definite by more than its rounding.
    pub(super) fn verify(
        &mut self,
        terms: Terms<'_, '_>,
        minimisation: &Minimisation<'_>,
        q: &[f64],
    ) -> Minimum {
        let Self { inertia, assembly, solver, .. } = self;
        let mut all: Vec<&mut dyn Potential> = vec![inertia];
        all.extend(terms.iter_mut().map(|term| &mut **term as &mut dyn Potential));
        let &Minimisation { map, time_step, .. } = minimisation;
        let mut unused = DenseCholesky::new();
        let mut objective = IncrementalPotential::new(&mut all, map, time_step, assembly, &mut unused)
            .with_projection(Projection::None);
        let mut matrix = objective.hessian(q).clone();
        take_rounding_off(&mut matrix);
        match solver.factor(&matrix) {
            Ok(FactorReport { algorithm: Algorithm::Cholesky, .. }) => Minimum::Strict,
            Err(LinearError::NotPositiveDefinite { .. }) => Minimum::NotDefinite,
            _ => Minimum::Unverified,
        }
    }
}

/// What rounding makes of a Hessian's diagonal, relative to it, is less: some hundred times ε, since an entry is the sum of a few
/// dozen products, and a pivot what is left of it.
const ROUNDING: f64 = 1e-13;

/// Takes [`ROUNDING`] of its size off every entry of the diagonal. What a body can do without resistance has a positive pivot by
/// chance of rounding, and none after this.
fn take_rounding_off(matrix: &mut BlockMatrix) {
    for column in 0..matrix.pattern().columns() {
        let slot = matrix.pattern().column_start()[column];
        let block = &mut matrix.blocks_mut()[slot];
        (0..3).for_each(|k| block[(k, k)] -= ROUNDING * block[(k, k)].abs());
    }
}

/// The sum of terms as the stepper's options want it minimised.
pub(super) fn incremental_potential<'a, 'b>(
    terms: &'a mut [&'b mut dyn Potential],
    map: &'a PointMap,
    time_step: TimeStep<'a>,
    assembly: &'a mut Assembly,
    solver: &'a mut Solver,
    options: &StepperOptions,
) -> IncrementalPotential<'a, 'b, Solver> {
    IncrementalPotential::new(terms, map, time_step, assembly, solver)
        .with_projection(options.projection)
        .with_projecting(options.projecting)
}

/// Brings scripted points to their targets, and with them the unknowns `q` that are in the way.
fn arrive(
    approach: &Approach<'_>,
    terms: &mut [&mut dyn Potential],
    q: &mut [f64],
    observer: &mut dyn FnMut(&Progress) -> Proceed,
    report: &mut StepReport,
) -> Result<Arrival, StepError> {
    if approach.moving.is_empty() {
        return Ok(Arrival::Jumped);
    }
    let time = approach.time_step.time;
    let (x, p) = approach.jump(q);
    if admits(terms, &x, &p).map_err(|source| StepError::Term { time, source })? {
        return Ok(Arrival::Jumped);
    }
    approach.pull(terms, q, observer, report)?;
    Ok(Arrival::Pulled)
}

/// Moves `q` towards where it is expected, as far as the terms allow, if the value is lower there. In free flight, where that is
/// where inertia alone takes it, it is the minimum already; the step limit keeps the way there admissible.
fn start_towards(expected: &[f64], objective: &mut dyn Objective, q: &mut [f64]) {
    let p: Vec<f64> = expected.iter().zip(&*q).map(|(expected, q)| expected - q).collect();
    if p.iter().all(|&p| p == 0.0) {
        return;
    }
    // A start that is not admissible is the minimiser's to report.
    let Ok(Limit { fraction, .. }) = objective.limit_step(q, &p) else { return };
    let trial: Vec<f64> = q.iter().zip(&p).map(|(q, p)| q + fraction * p).collect();
    let start = objective.value(q);
    if start.is_finite() && objective.value(&trial) < start {
        q.copy_from_slice(&trial);
    }
}

/// The speed of the fastest point with the unknowns `q` [m/s].
fn largest_speed(map: &PointMap, time_step: TimeStep<'_>, q: &[f64]) -> f64 {
    let mut x = vec![Vec3::zeros(); map.points()];
    map.points_into(q, &mut x);
    let speeds = x.iter().enumerate().map(|(point, x)| time_step.scheme.velocity(point, x).norm());
    speeds.fold(0.0, f64::max)
}

/// Adds the times of terms to their reports, which are made if there are none.
pub(super) fn add_terms(reports: &mut Vec<TermReport>, names: &[String], times: &[TermTimes]) {
    if reports.is_empty() {
        reports
            .extend(names.iter().map(|name| TermReport { name: name.clone(), times: TermTimes::default() }));
    }
    add_times(reports, times);
}

/// Adds the times of terms to their reports; those of terms without one are dropped.
pub(super) fn add_times(reports: &mut [TermReport], times: &[TermTimes]) {
    for (report, times) in reports.iter_mut().zip(times) {
        report.times.value += times.value;
        report.times.gradient += times.gradient;
        report.times.hessian += times.hessian;
        report.times.limit_step += times.limit_step;
        report.times.freeze += times.freeze;
    }
}
