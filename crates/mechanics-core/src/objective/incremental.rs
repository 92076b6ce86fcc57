//! The incremental potential: terms over points, minimised over unknowns.

use super::direction_solver::check_solved;
use super::{
    DirectionAccuracy, DirectionReport, DirectionSolver, Limit, Location, Objective, ObjectiveError,
    SolverError,
};
use crate::point_map::PointMap;
use crate::potential::{Changed, Potential, PotentialError};
use crate::projection::Projection;
use crate::sparse::{Assembly, BlockMatrix};
use crate::stage::{Moment, Scheme, Stage};
use crate::tensor::{Mat3, Vec3};
use std::time::{Duration, Instant};

/// The time step that is being made.
#[derive(Clone, Copy, Debug)]
pub struct TimeStep<'a> {
    /// Time at its end \[s\].
    pub time: f64,
    /// Its length `h` \[s\]; zero in statics.
    pub step: f64,
    /// The scheme.
    pub scheme: Scheme<'a>,
}

/// When the Hessians of elements are projected.
///
/// Projected element by element, the Hessian is positive semi-definite everywhere, but it is not the true one where an element's own is
/// indefinite, and Newton's method then converges linearly even where the sum of the true ones is definite, as in all small time steps.
///
/// # Reference
/// A. Longva, F. Löschner, J. A. Fernández-Fernández, E. Larionov, U. M. Ascher, J. Bender, *Pitfalls of projection: a study of
/// Newton-type solvers for incremental potentials*, arXiv:2311.14526, 2023, section 4 ("project-on-demand").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projecting {
    /// Always.
    #[default]
    Always,
    /// Where the sum of the true Hessians turns out not to be positive definite: at the price of a second assembly there.
    /// After n such directions in a row the next min(n, 4) are projected untried.
    OnDemand,
}

/// Where the time of one term went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TermTimes {
    /// In `value`.
    pub value: Duration,
    /// In `add_gradient`.
    pub gradient: Duration,
    /// In `add_hessian`, adding included.
    pub hessian: Duration,
    /// In `limit_step`.
    pub limit_step: Duration,
    /// In `freeze`.
    pub freeze: Duration,
}

/// `E(q) = Σ terms(x(q))` with `x(q) = W q + c`, as an [`Objective`] over the flat unknowns `q`.
///
/// Directions solve `Wᵀ H W p = −g` with the terms' Hessians, projected as [`Projecting`] says. Where that matrix is not positive definite
/// (statics of a body that nothing holds, [`Projection::None`]) the system is solved again with `τ D` added, `D` the
/// mean of each block's diagonal, `τ` = 1e-10, 1e-6, 1e-2, 1, 1e2, until it is; the report counts the attempts and says the last `τ`. This is
/// the modified Newton method of Nocedal and Wright (2006), algorithm 3.3, with a scaled identity and with its memory: every direction tries
/// `τ` = 0, but where that does not do the next `τ` is the one that the last such direction ended with, or the next smaller if that one began
/// with it too. So a `τ` may be larger than it need be, and the direction shorter; [`DirectionAccuracy::Decisive`] tries all from the smallest on.
///
/// Step sizes are `a · maxᵢ ‖Δxᵢ‖₂` over points `i`, Euclidean norms of point displacements: metres a second, or
/// metres in statics.
///
/// Assembly and solver are borrowed, so that they keep what they know from step to step, and so that the last
/// factorisation is the caller's to use afterwards.
pub struct IncrementalPotential<'a, 'b, S> {
    terms: &'a mut [&'b mut dyn Potential],
    map: &'a PointMap,
    time_step: TimeStep<'a>,
    projection: Projection,
    projecting: Projecting,
    /// Directions in a row for which the true Hessian was tried and is not positive definite.
    refused: u32,
    /// Directions to come for which it is not tried.
    untried: u32,
    /// The number of the shift to begin with where the matrix is not positive definite.
    first_shift: usize,
    assembly: &'a mut Assembly,
    solver: &'a mut S,
    x: Vec<Vec3>,
    over_points: Vec<Vec3>,
    times: Vec<TermTimes>,
    /// Σ |value of a term| at the last evaluation.
    magnitude: f64,
}

/// Shifts tried where the matrix is not positive definite, relative to its diagonal.
const SHIFTS: [f64; 5] = [1e-10, 1e-6, 1e-2, 1.0, 1e2];

/// The true Hessian is left untried for at most so many directions.
const LONGEST_UNTRIED: u32 = 4;

impl<'a, 'b, S: DirectionSolver> IncrementalPotential<'a, 'b, S> {
    /// The sum of `terms` over the points of `map`.
    ///
    /// # Panics
    /// If the scheme is not for as many points as the map has.
    pub fn new(
        terms: &'a mut [&'b mut dyn Potential],
        map: &'a PointMap,
        time_step: TimeStep<'a>,
        assembly: &'a mut Assembly,
        solver: &'a mut S,
    ) -> Self {
        let points = map.points();
        assert_eq!(time_step.scheme.velocity_origin.len(), points, "the scheme holds one position per point");
        let times = vec![TermTimes::default(); terms.len()];
        let zeros = vec![Vec3::zeros(); points];
        Self {
            terms,
            map,
            time_step,
            projection: Projection::default(),
            projecting: Projecting::default(),
            refused: 0,
            untried: 0,
            first_shift: 0,
            assembly,
            solver,
            x: zeros.clone(),
            over_points: zeros,
            times,
            magnitude: 0.0,
        }
    }

    /// The same with another projection of the terms' Hessians; [`Projection::Clamp`] unless said.
    pub fn with_projection(self, projection: Projection) -> Self {
        Self { projection, ..self }
    }

    /// The same, projecting at other times; [`Projecting::Always`] unless said.
    pub fn with_projecting(self, projecting: Projecting) -> Self {
        Self { projecting, ..self }
    }

    /// Lets every term refresh what it holds constant. The minimiser calls it at every iteration; the stepper at
    /// the start of a step and of a lag iteration. At a step's start the assembly and the solver forget what earlier
    /// steps left in them, so that the bits of a step depend on the state it is given alone.
    ///
    /// # Errors
    /// The first term's that fails.
    pub fn freeze_at(&mut self, moment: Moment, q: &[f64]) -> Result<Changed, PotentialError> {
        if moment == Moment::Step {
            self.assembly.begin_step();
            self.solver.begin_step();
        }
        self.map.points_into(q, &mut self.x);
        let TimeStep { time, step, scheme } = self.time_step;
        let stage = Stage { moment, x: &self.x, time, step, scheme };
        let mut changed = Changed::Nothing;
        for (term, times) in self.terms.iter_mut().zip(&mut self.times) {
            changed = changed.or(timed(&mut times.freeze, || term.freeze(&stage))?);
        }
        Ok(changed)
    }

    /// The gradient over unknowns at `q` with what is lagged taken there; see [`Potential::add_settled_gradient`].
    pub fn settled_gradient_into(&mut self, q: &[f64], gradient: &mut [f64]) {
        self.map.points_into(q, &mut self.x);
        self.over_points.fill(Vec3::zeros());
        let TimeStep { time, step, scheme } = self.time_step;
        let stage = Stage { moment: Moment::Settling, x: &self.x, time, step, scheme };
        for (term, times) in self.terms.iter().zip(&mut self.times) {
            timed(&mut times.gradient, || term.add_settled_gradient(&stage, &mut self.over_points));
        }
        self.map.gradient_into(&self.over_points, gradient);
    }

    /// [Softens](Potential::soften) every term.
    pub fn soften(&mut self, velocity: f64) {
        self.terms.iter_mut().for_each(|term| term.soften(velocity));
    }

    /// Where the time of each term went, since this objective was made.
    pub fn term_times(&self) -> &[TermTimes] {
        &self.times
    }

    /// The Hessian over unknowns at `q`, projected; [`Projecting::OnDemand`] directions try the true one first.
    pub fn hessian(&mut self, q: &[f64]) -> &BlockMatrix {
        self.assemble(q, self.projection)
    }

    fn assemble(&mut self, q: &[f64], projection: Projection) -> &BlockMatrix {
        self.map.points_into(q, &mut self.x);
        let mut assembler = self.assembly.begin(self.map);
        for (number, (term, times)) in self.terms.iter().zip(&mut self.times).enumerate() {
            assembler.begin_term(number);
            timed(&mut times.hessian, || term.add_hessian(&self.x, projection, &mut assembler));
        }
        assembler.finish()
    }

    /// Some point that unknown `unknown` moves.
    fn point_of(&self, unknown: usize) -> Option<usize> {
        (0..self.map.points()).find(|&point| {
            let mut found = false;
            self.map.for_each_unknown(point, |other, _| found |= other as usize == unknown);
            found
        })
    }

    /// Solves with the true Hessian; answers whether that is positive definite.
    fn solve_unprojected(
        &mut self,
        q: &[f64],
        right: &[f64],
        accuracy: DirectionAccuracy,
        p: &mut [f64],
        report: &mut DirectionReport,
    ) -> bool {
        if self.untried > 0 {
            self.untried -= 1;
            return false;
        }
        timed(&mut report.assembly_time, || {
            self.assemble(q, Projection::None);
        });
        let begin = Instant::now();
        report.factorisations += 1;
        let matrix = self.assembly.matrix();
        let solver = &mut self.solver;
        let found = solver.prepare(matrix).and_then(|()| solver.solve_into(right, accuracy, p));
        let solved = found.and_then(|iterations| check_solved(matrix, right, p).map(|()| iterations));
        report.solve_time += begin.elapsed();
        report.linear_iterations += *solved.as_ref().unwrap_or(&0);
        self.refused = if solved.is_ok() { 0 } else { self.refused + 1 };
        self.untried = self.refused.min(LONGEST_UNTRIED);
        solved.is_ok()
    }

    /// Prepares and solves with the assembled matrix, shifted where it must be.
    fn solve(
        &mut self,
        right: &[f64],
        accuracy: DirectionAccuracy,
        p: &mut [f64],
        report: &mut DirectionReport,
    ) -> Result<(), ObjectiveError> {
        let mut attempt = |solver: &mut S, matrix: &BlockMatrix, report: &mut DirectionReport| {
            report.factorisations += 1;
            solver.prepare(matrix)?;
            report.linear_iterations += solver.solve_into(right, accuracy, p)?;
            check_solved(matrix, right, p)
        };
        let mut outcome = attempt(self.solver, self.assembly.matrix(), report);
        let first = if accuracy == DirectionAccuracy::Decisive { 0 } else { self.first_shift };
        for (number, &shift) in SHIFTS.iter().enumerate().skip(first) {
            if !matches!(outcome, Err(SolverError::Indefinite(_))) {
                break;
            }
            report.shifts += 1;
            report.shift = shift;
            outcome = attempt(self.solver, &shifted(self.assembly.matrix(), shift), report);
            self.first_shift = if number == first { number.saturating_sub(1) } else { number };
        }
        outcome.map_err(|error| match error {
            SolverError::Indefinite(indefinite) => {
                let location = Location { point: self.point_of(indefinite.block), ..Default::default() };
                ObjectiveError::Indefinite { location, shift: SHIFTS[SHIFTS.len() - 1] }
            }
            SolverError::NonFinite { .. } | SolverError::NotPrepared | SolverError::Unsolved { .. } => {
                let culprit = self.terms.iter().find_map(|term| term.diagnose(&self.x));
                culprit.map_or(ObjectiveError::Solver(Box::new(error)), ObjectiveError::Potential)
            }
            SolverError::Other(source) => ObjectiveError::Solver(source),
        })
    }
}

/// `H + shift · D`, `D` the mean of the diagonal of each diagonal block, or of all of them where that is zero.
fn shifted(matrix: &BlockMatrix, shift: f64) -> BlockMatrix {
    let mut matrix = matrix.clone();
    let columns = matrix.pattern().columns();
    let mean = |column: usize| matrix.diagonal(column).trace().abs() / 3.0;
    let means: Vec<f64> = (0..columns).map(mean).collect();
    let overall = means.iter().sum::<f64>() / columns as f64;
    let overall = if overall > 0.0 { overall } else { 1.0 };
    for (column, mean) in means.into_iter().enumerate() {
        let slot = matrix.pattern().column_start()[column];
        let size = if mean > 0.0 { mean } else { overall };
        matrix.blocks_mut()[slot] += Mat3::from_diagonal_element(shift * size);
    }
    matrix
}

fn timed<R>(total: &mut Duration, work: impl FnOnce() -> R) -> R {
    let begin = Instant::now();
    let result = work();
    *total += begin.elapsed();
    result
}

impl<S: DirectionSolver> Objective for IncrementalPotential<'_, '_, S> {
    fn dimension(&self) -> usize {
        3 * self.map.unknowns()
    }

    fn value(&mut self, q: &[f64]) -> f64 {
        self.map.points_into(q, &mut self.x);
        let (mut sum, mut magnitude) = (0.0, 0.0);
        for (term, times) in self.terms.iter().zip(&mut self.times) {
            let value = timed(&mut times.value, || term.value(&self.x));
            if value == f64::INFINITY {
                return value;
            }
            sum += value;
            magnitude += value.abs();
        }
        self.magnitude = magnitude;
        sum
    }

    fn gradient_into(&mut self, q: &[f64], gradient: &mut [f64]) {
        self.map.points_into(q, &mut self.x);
        self.over_points.fill(Vec3::zeros());
        for (term, times) in self.terms.iter().zip(&mut self.times) {
            timed(&mut times.gradient, || term.add_gradient(&self.x, &mut self.over_points));
        }
        self.map.gradient_into(&self.over_points, gradient);
    }

    fn direction_into(
        &mut self,
        q: &[f64],
        gradient: &[f64],
        accuracy: DirectionAccuracy,
        direction: &mut [f64],
    ) -> Result<DirectionReport, ObjectiveError> {
        let mut report = DirectionReport::default();
        let right: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let on_demand = self.projecting == Projecting::OnDemand && self.projection != Projection::None;
        if on_demand && self.solve_unprojected(q, &right, accuracy, direction, &mut report) {
            return Ok(report);
        }
        timed(&mut report.assembly_time, || {
            self.hessian(q);
        });
        let begin = Instant::now();
        self.solve(&right, accuracy, direction, &mut report)?;
        report.solve_time += begin.elapsed();
        Ok(report)
    }

    fn freeze(&mut self, q: &[f64]) -> Result<Changed, ObjectiveError> {
        let coefficients = self.time_step.scheme.coefficients;
        if !coefficients.are_valid() {
            return Err(ObjectiveError::Coefficients(coefficients));
        }
        Ok(self.freeze_at(Moment::Iteration, q)?)
    }

    fn limit_step(&mut self, q: &[f64], p: &[f64]) -> Result<Limit, ObjectiveError> {
        self.map.points_into(q, &mut self.x);
        self.map.displacements_into(p, &mut self.over_points);
        let mut limit = Limit::default();
        for (term, times) in self.terms.iter_mut().zip(&mut self.times) {
            let own = timed(&mut times.limit_step, || term.limit_step(&self.x, &self.over_points))?;
            if !(0.0..=1.0).contains(&own.fraction) {
                let term = term.name().to_owned();
                return Err(
                    PotentialError::StepLimit { term, element: own.element, fraction: own.fraction }.into()
                );
            }
            if own.fraction < limit.fraction {
                let location =
                    Location { term: Some(term.name().to_owned()), element: own.element, point: None };
                limit = Limit { fraction: own.fraction, location };
            }
        }
        Ok(limit)
    }

    fn step_norm(&self, p: &[f64]) -> f64 {
        let mut over_points = vec![Vec3::zeros(); self.map.points()];
        self.map.displacements_into(p, &mut over_points);
        let norms: Vec<f64> = over_points.iter().map(Vec3::norm).collect();
        self.time_step.scheme.coefficients.velocity * super::largest(&norms)
    }

    /// Whether every term is settled.
    fn is_settled(&mut self, q: &[f64], p: &[f64]) -> bool {
        self.map.points_into(q, &mut self.x);
        self.map.displacements_into(p, &mut self.over_points);
        self.terms.iter().all(|term| term.is_settled(&self.x, &self.over_points))
    }

    fn rounding(&self, value: f64) -> f64 {
        64.0 * f64::EPSILON * self.magnitude.max(value.abs())
    }

    /// The point that moves most, the term that pulls most at it, and the element of the term that does.
    fn locate(&mut self, q: &[f64], p: &[f64]) -> Location {
        self.map.points_into(q, &mut self.x);
        self.map.displacements_into(p, &mut self.over_points);
        let size = |v: &Vec3| if v.norm().is_nan() { f64::INFINITY } else { v.norm() };
        let by_size = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
        let sizes = self.over_points.iter().map(size).enumerate();
        let point = sizes.max_by(by_size).map(|(point, _)| point);
        let pull = |term: &dyn Potential, point: usize| {
            let mut gradient = vec![Vec3::zeros(); self.x.len()];
            term.add_gradient(&self.x, &mut gradient);
            size(&gradient[point])
        };
        let number = point.and_then(|point| {
            let pulls = self.terms.iter().map(|term| pull(&**term, point)).enumerate();
            pulls.max_by(by_size).map(|(number, _)| number)
        });
        let term = number.map(|number| self.terms[number].name().to_owned());
        let element = number.zip(point).and_then(|(number, point)| self.terms[number].locate(&self.x, point));
        Location { term, element, point }
    }

    fn diagnose(&mut self, q: &[f64]) -> Option<ObjectiveError> {
        self.map.points_into(q, &mut self.x);
        self.terms.iter().find_map(|term| term.diagnose(&self.x)).map(ObjectiveError::Potential)
    }
}
