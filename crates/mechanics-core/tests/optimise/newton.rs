use crate::samples::Random;
use mechanics_core::derivatives::check_objective_gradient;
use mechanics_core::newton::{
    Forcing, NewtonCause, NewtonError, NewtonOptions, Proceed, minimise, minimise_observed,
};
use mechanics_core::objective::{
    DenseObjective, DenseProblem, DirectionAccuracy, DirectionReport, Limit, Location, Objective,
    ObjectiveError,
};
use mechanics_core::potential::{Changed, Quantity};
use mechanics_core::projection::Projection;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::SQRT_2;

type Function<R> = Box<dyn Fn(&[f64]) -> R>;
type StepLimit = Box<dyn Fn(&[f64], &[f64]) -> f64>;

/// A problem from closures.
struct Problem {
    dimension: usize,
    value: Function<f64>,
    gradient: Function<Vec<f64>>,
    hessian: Function<DMatrix<f64>>,
    limit: StepLimit,
}

impl DenseProblem for Problem {
    fn dimension(&self) -> usize {
        self.dimension
    }
    fn value(&self, x: &[f64]) -> f64 {
        (self.value)(x)
    }
    fn gradient_into(&self, x: &[f64], gradient: &mut [f64]) {
        gradient.copy_from_slice(&(self.gradient)(x));
    }
    fn hessian_into(&self, x: &[f64], hessian: &mut DMatrix<f64>) {
        hessian.copy_from(&(self.hessian)(x));
    }
    fn limit_step(&self, x: &[f64], p: &[f64]) -> f64 {
        (self.limit)(x, p)
    }
}

fn problem(
    dimension: usize,
    value: impl Fn(&[f64]) -> f64 + 'static,
    gradient: impl Fn(&[f64]) -> Vec<f64> + 'static,
    hessian: impl Fn(&[f64]) -> DMatrix<f64> + 'static,
) -> DenseObjective<Problem> {
    DenseObjective::new(Problem {
        dimension,
        value: Box::new(value),
        gradient: Box::new(gradient),
        hessian: Box::new(hessian),
        limit: Box::new(|_, _| 1.0),
    })
}

fn tolerance(tolerance: f64) -> NewtonOptions {
    NewtonOptions { tolerance, ..NewtonOptions::default() }
}

/// ½ xᵀ A x − bᵀ x with eigenvalues from 1 to `condition`.
fn quadratic(n: usize, condition: f64, seed: u64) -> (DenseObjective<Problem>, DVector<f64>) {
    let mut random = Random(seed);
    let q = DMatrix::from_fn(n, n, |_, _| random.number()).qr().q();
    let eigenvalues = DVector::from_fn(n, |i, _| condition.powf(i as f64 / (n - 1) as f64));
    let a = &q * DMatrix::from_diagonal(&eigenvalues) * q.transpose();
    let a = (&a + a.transpose()) * 0.5;
    let solution = DVector::from_fn(n, |_, _| random.number());
    let b = &a * &solution;
    let (a1, a2, b1) = (a.clone(), a.clone(), b.clone());
    let vector = |x: &[f64]| DVector::from_column_slice(x);
    let value = move |x: &[f64]| 0.5 * vector(x).dot(&(&a1 * vector(x))) - b.dot(&vector(x));
    let gradient = move |x: &[f64]| (&a2 * vector(x) - &b1).as_slice().to_vec();
    (problem(n, value, gradient, move |_| a.clone()), solution)
}

fn rosenbrock() -> DenseObjective<Problem> {
    problem(
        2,
        |x| (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2),
        |x| {
            let w = x[1] - x[0] * x[0];
            vec![-2.0 * (1.0 - x[0]) - 400.0 * x[0] * w, 200.0 * w]
        },
        |x| {
            let mixed = -400.0 * x[0];
            DMatrix::from_row_slice(2, 2, &[2.0 - 400.0 * (x[1] - 3.0 * x[0] * x[0]), mixed, mixed, 200.0])
        },
    )
}

fn failure(objective: &mut dyn Objective, start: &[f64], options: &NewtonOptions) -> Box<NewtonError> {
    let mut x = start.to_vec();
    let error = minimise(objective, &mut x, options).unwrap_err();
    assert!(
        x.iter().zip(start).all(|(x, s)| x.to_bits() == s.to_bits()),
        "a failure leaves the start as it was"
    );
    error
}

#[test]
fn quadratics_take_one_step() {
    for (n, condition) in [(2, 1.0), (10, 1e3), (30, 1e6)] {
        let (mut objective, solution) = quadratic(n, condition, 31);
        let mut x = vec![5.0; n];
        let report = minimise(&mut objective, &mut x, &tolerance(1e-7)).unwrap();
        assert_eq!((report.iterations, report.halvings, report.directions), (1, 0, 2));
        let error = (DVector::from_vec(x) - solution).amax();
        assert!(error < 1e-15 * condition * 10.0, "{error:e}");
    }
}

#[test]
fn a_minimum_takes_no_step() {
    let (mut objective, solution) = quadratic(5, 10.0, 32);
    let mut x = solution.as_slice().to_vec();
    let report = minimise(&mut objective, &mut x, &tolerance(1e-9)).unwrap();
    assert_eq!((report.iterations, x.as_slice()), (0, solution.as_slice()));
    let mut flat =
        problem(3, |_| 0.0, |_| vec![0.0; 3], |_| unreachable!("a zero gradient needs no direction"));
    assert_eq!(minimise(&mut flat, &mut [1.0; 3], &tolerance(1e-9)).unwrap().directions, 0);
    let mut nothing = problem(0, |_| 0.0, |_| vec![], |_| DMatrix::zeros(0, 0));
    assert_eq!(minimise(&mut nothing, &mut [], &tolerance(1e-9)).unwrap().iterations, 0);
}

#[test]
fn rosenbrock_s_valley_is_followed_to_its_end() {
    for start in [[-1.2, 1.0], [0.0, 0.0], [-3.0, 7.0], [10.0, -10.0], [1.0, 1.0 + 1e-12]] {
        let mut x = start;
        let report = minimise(&mut rosenbrock(), &mut x, &tolerance(1e-10)).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-10 && (x[1] - 1.0).abs() < 1e-10, "{x:?}");
        assert!(report.iterations < 60, "{report:?}");
    }
}

/// Errors e of ln cosh-like problems: e_{k+1} / e_k² must stay bounded.
#[test]
fn convergence_is_of_order_two() {
    let mut errors = Vec::new();
    let mut objective = problem(
        1,
        |x| x[0].exp() - 2.0 * x[0],
        |x| vec![x[0].exp() - 2.0],
        |x| DMatrix::from_element(1, 1, x[0].exp()),
    );
    let mut x = [2.0];
    let mut distances = |p: &mechanics_core::newton::Progress| {
        errors.push(p.step_norm);
        Proceed::Continue
    };
    minimise_observed(&mut objective, &mut x, &tolerance(1e-12), &mut distances).unwrap();
    assert!((x[0] - 2f64.ln()).abs() < 1e-15);
    // Newton's step is the error up to higher order; orders from successive triples approach two.
    let order = |w: &[f64]| (w[2] / w[1]).ln() / (w[1] / w[0]).ln();
    let last = order(&errors[errors.len() - 3..]);
    assert!((last - 2.0).abs() < 0.1, "order {last}, steps {errors:?}");
}

/// x₀ − μ ln x₀ + …: the wall at zero is not crossed, whether the limit or only the value tells of it.
#[test]
fn barriers_are_respected() {
    for told in [true, false] {
        for mu in [1.0, 1e-3, 1e-9] {
            let mut objective = problem(
                2,
                move |x| {
                    if x[0] > 0.0 { x[0] - mu * x[0].ln() + (x[1] - x[0]).powi(2) } else { f64::INFINITY }
                },
                move |x| vec![1.0 - mu / x[0] - 2.0 * (x[1] - x[0]), 2.0 * (x[1] - x[0])],
                move |x| DMatrix::from_row_slice(2, 2, &[mu / (x[0] * x[0]) + 2.0, -2.0, -2.0, 2.0]),
            );
            if told {
                objective.problem.limit =
                    Box::new(|x, p| if p[0] < 0.0 { (-0.9 * x[0] / p[0]).min(1.0) } else { 1.0 });
            }
            let mut x = [3.0, -1.0];
            let report = minimise(&mut objective, &mut x, &tolerance(1e-16)).unwrap();
            assert!((x[0] / mu - 1.0).abs() < 1e-6 && (x[1] / mu - 1.0).abs() < 1e-6, "{x:?}");
            assert_eq!(report.limited_steps > 0, told, "{report:?}");
        }
    }
}

/// Unknowns and stiffnesses that differ by 1e12, and an energy whose minimum is far from zero, so that its
/// differences drown in rounding: the slope decides then.
#[test]
fn bad_scaling_and_rounding_are_survived() {
    let mut objective = problem(
        2,
        |x| 1e12 * (x[0].cosh() - 1.0) + (x[1] - 1.0).cosh() + 1e9,
        |x| vec![1e12 * x[0].sinh(), (x[1] - 1.0).sinh()],
        |x| DMatrix::from_row_slice(2, 2, &[1e12 * x[0].cosh(), 0.0, 0.0, (x[1] - 1.0).cosh()]),
    );
    let mut x = [0.5, -1.0];
    let report = minimise(&mut objective, &mut x, &tolerance(1e-11)).unwrap();
    assert!(x[0].abs() < 1e-11 && (x[1] - 1.0).abs() < 1e-11, "{x:?} {report:?}");
}

/// Steps whose values rise by rounding alone are accepted by their slope.
#[test]
fn noise_in_the_value_does_not_stall_convergence() {
    // 1e-9 of the value is noise that depends on the last bits of x.
    let noise = |x: f64| {
        ((x.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64 / (1 << 24) as f64 - 0.5) * 1e-9
    };
    let mut by_slope = 0;
    for k in 0..50 {
        let inner = problem(
            1,
            move |x| x[0].exp() - 2.0 * x[0] + noise(x[0]),
            |x| vec![x[0].exp() - 2.0],
            |x| DMatrix::from_element(1, 1, x[0].exp()),
        );
        let mut x = [0.1 * f64::from(k)];
        let mut noisy = Altered { inner, rounding: 1e-9, limit: 1.0 };
        by_slope += minimise(&mut noisy, &mut x, &tolerance(1e-13)).unwrap().accepted_by_slope;
        assert!((x[0] - 2f64.ln()).abs() < 1e-13);
    }
    assert!(by_slope > 10, "{by_slope} steps out of 50 runs");
}

#[test]
fn saddles_are_left() {
    // x⁴/4 − x²/2 + y²: a saddle at (0, 0), minima at (±1, 0).
    let mut objective = problem(
        2,
        |x| x[0].powi(4) / 4.0 - x[0].powi(2) / 2.0 + x[1].powi(2),
        |x| vec![x[0].powi(3) - x[0], 2.0 * x[1]],
        |x| DMatrix::from_diagonal(&DVector::from_vec(vec![3.0 * x[0].powi(2) - 1.0, 2.0])),
    );
    let mut x = [0.1, 1.0];
    let report = minimise(&mut objective, &mut x, &tolerance(1e-10)).unwrap();
    assert!((x[0] - 1.0).abs() < 1e-10 && report.shifts > 0, "{x:?} {report:?}");
    objective.projection = Projection::None;
    let error = failure(&mut objective, &[0.1, 1.0], &tolerance(1e-10));
    assert!(matches!(error.cause, NewtonCause::Objective(ObjectiveError::Indefinite { .. })), "{error}");
}

#[test]
fn values_that_are_not_numbers_are_errors_that_say_so() {
    let identity = |_: &[f64]| DMatrix::identity(2, 2);
    let mut nan = problem(2, |_| f64::NAN, |x| x.to_vec(), identity);
    let error = failure(&mut nan, &[1.0, 2.0], &tolerance(1e-6));
    let NewtonCause::Objective(ObjectiveError::NonFinite { what: Quantity::Value, .. }) = error.cause else {
        panic!("{error}");
    };
    let mut gradient = problem(2, |_| 0.0, |x| vec![x[0], f64::INFINITY], identity);
    let error = failure(&mut gradient, &[1.0, 2.0], &tolerance(1e-6));
    let NewtonCause::Objective(ObjectiveError::NonFinite { what: Quantity::Gradient, index: 1, .. }) =
        error.cause
    else {
        panic!("{error}");
    };
    let mut hessian = problem(2, |_| 0.0, |x| x.to_vec(), |_| DMatrix::from_element(2, 2, f64::NAN));
    let error = failure(&mut hessian, &[1.0, 2.0], &tolerance(1e-6));
    let NewtonCause::Objective(ObjectiveError::NonFinite { what: Quantity::Hessian, .. }) = error.cause
    else {
        panic!("{error}");
    };
    // NaN everywhere but at the start.
    let mut nowhere = problem(2, |x| if x == [1.0, 2.0] { 0.0 } else { f64::NAN }, |x| x.to_vec(), identity);
    let error = failure(&mut nowhere, &[1.0, 2.0], &tolerance(1e-6));
    assert!(matches!(error.cause, NewtonCause::NoFiniteValue { value, .. } if value.is_nan()), "{error}");
    let error = failure(&mut nowhere, &[1.0, f64::NAN], &tolerance(1e-6));
    assert!(matches!(error.cause, NewtonCause::Start { index: 1, .. }), "{error}");
    // NaN beyond a wall is backed away from, as +∞ is.
    for beyond in [f64::NAN, f64::INFINITY] {
        let mut wall = problem(
            1,
            move |x| if x[0] > -0.5 { x[0] - (x[0] + 0.5).ln() } else { beyond },
            |x| vec![1.0 - 1.0 / (x[0] + 0.5)],
            |x| DMatrix::from_element(1, 1, (x[0] + 0.5).powi(-2)),
        );
        let mut x = [5.0];
        let report = minimise(&mut wall, &mut x, &tolerance(1e-9)).unwrap();
        assert!((x[0] - 0.5).abs() < 1e-9 && report.halvings > 0);
    }
}

/// Twice the gradient is harmless to Newton's direction test by test; the wrong sign, or a wrong entry, is not.
#[test]
fn a_wrong_gradient_is_found_by_the_line_search_and_by_the_checker() {
    let wrong = |x: &[f64]| vec![2.0 * x[0], -2.0 * (x[1] - 3.0)];
    let value = |x: &[f64]| x[0].powi(2) + (x[1] - 3.0).powi(2);
    let mut objective = problem(2, value, wrong, |_| DMatrix::identity(2, 2) * 2.0);
    let error = failure(&mut objective, &[0.0, 1.0], &tolerance(1e-9));
    let NewtonCause::LineSearch { slope, measured, .. } = error.cause else { panic!("{error}") };
    // The gradient says −8 (4 · 2 · −1, direction −2); the value really rises at +8.
    assert!((slope + 8.0).abs() < 1e-12 && (measured - 8.0).abs() < 1e-3, "{error}");
    let check = check_objective_gradient(&mut objective, &[0.0, 1.0]);
    assert_eq!(check.worst.row, 1);
    assert!(check.require(1e-3).is_err());
}

#[test]
fn failures_name_their_reason() {
    let options = NewtonOptions { max_iterations: 5, ..tolerance(1e-10) };
    let error = failure(&mut rosenbrock(), &[-1.2, 1.0], &options);
    assert!(matches!(error.cause, NewtonCause::NotConverged { .. }), "{error}");
    assert_eq!((error.progress.iteration, error.report.iterations), (5, 5));
    // Falls without bound: −x has a gradient but no minimum; the made-up Hessian shrinks, so steps grow.
    let shrinking = |x: &[f64]| DMatrix::from_element(1, 1, (-x[0]).exp().max(1e-290));
    let mut falls = problem(1, |x| -x[0], |_| vec![-1.0], shrinking);
    let error = failure(&mut falls, &[0.0], &tolerance(1e-6));
    assert!(matches!(error.cause, NewtonCause::Diverged { first, .. } if first == 1.0), "{error}");
    let cliff = |x: &[f64]| if x[0] < 1.0 { -x[0] } else { f64::NEG_INFINITY };
    let mut cliff = problem(1, cliff, |_| vec![-1.0], |_| DMatrix::identity(1, 1));
    let error = failure(&mut cliff, &[0.5], &tolerance(1e-6));
    assert!(matches!(error.cause, NewtonCause::Unbounded { .. }), "{error}");
    let (mut blocked, _) = quadratic(3, 10.0, 33);
    blocked.problem.limit = Box::new(|_, _| 0.0);
    let error = failure(&mut blocked, &[9.0; 3], &tolerance(1e-6));
    assert!(matches!(&error.cause, NewtonCause::Blocked { location } if *location == Location::default()));
    blocked.problem.limit = Box::new(|_, _| f64::NAN);
    let error = failure(&mut blocked, &[9.0; 3], &tolerance(1e-6));
    assert!(matches!(error.cause, NewtonCause::Objective(ObjectiveError::NonFinite { .. })), "{error}");
}

#[test]
fn options_out_of_range_are_refused() {
    let base = NewtonOptions::default();
    for options in [
        NewtonOptions { tolerance: 0.0, ..base },
        NewtonOptions { tolerance: f64::NAN, ..base },
        NewtonOptions { divergence: 1.0, ..base },
        NewtonOptions { forcing: Forcing::Constant(1.0), ..base },
        NewtonOptions { forcing: Forcing::EisenstatWalker { first: 0.5, largest: -0.1 }, ..base },
    ] {
        let error = failure(&mut rosenbrock(), &[0.0, 0.0], &options);
        assert!(matches!(error.cause, NewtonCause::Options(_)), "{error}");
    }
}

#[test]
fn the_observer_sees_every_iteration_and_can_cancel() {
    let mut seen = Vec::new();
    let mut x = [-1.2, 1.0];
    let report = minimise_observed(&mut rosenbrock(), &mut x, &tolerance(1e-10), &mut |progress| {
        seen.push((progress.iteration, progress.value));
        Proceed::Continue
    })
    .unwrap();
    assert!(seen.iter().zip(0..).all(|(seen, k)| seen.0 == k));
    assert_eq!(seen.len() as u64, report.iterations);
    assert!(seen.windows(2).all(|pair| pair[1].1 < pair[0].1), "values fall");
    let mut x = [-1.2, 1.0];
    let cancel = |p: &mechanics_core::newton::Progress| match p.iteration {
        3 => Proceed::Cancel,
        _ => Proceed::Continue,
    };
    let error = minimise_observed(&mut rosenbrock(), &mut x, &tolerance(1e-10), &mut { cancel }).unwrap_err();
    assert!(matches!(error.cause, NewtonCause::Cancelled));
    assert_eq!((error.report.iterations, x), (3, [-1.2, 1.0]));
}

/// An objective that raises its stiffness once, at the third iteration, and one with directions of a stated error.
struct Wrapped {
    inner: DenseObjective<Problem>,
    calls: u32,
    changes_at: u32,
    worst_accuracy: f64,
}

impl Objective for Wrapped {
    fn dimension(&self) -> usize {
        self.inner.dimension()
    }
    fn value(&mut self, x: &[f64]) -> f64 {
        let factor = if self.calls > self.changes_at { 10.0 } else { 1.0 };
        self.inner.value(x) * factor
    }
    fn gradient_into(&mut self, x: &[f64], g: &mut [f64]) {
        self.inner.gradient_into(x, g);
        let factor = if self.calls > self.changes_at { 10.0 } else { 1.0 };
        g.iter_mut().for_each(|g| *g *= factor);
    }
    fn direction_into(
        &mut self,
        x: &[f64],
        g: &[f64],
        accuracy: DirectionAccuracy,
        p: &mut [f64],
    ) -> Result<DirectionReport, ObjectiveError> {
        let factor = if self.calls > self.changes_at { 10.0 } else { 1.0 };
        let g: Vec<f64> = g.iter().map(|g| g / factor).collect();
        let report = self.inner.direction_into(x, &g, accuracy, p)?;
        // Too short by η: ‖g + H p‖ = η ‖g‖ exactly.
        if let DirectionAccuracy::Relative(eta) = accuracy {
            p.iter_mut().for_each(|p| *p *= 1.0 - eta);
            self.worst_accuracy = self.worst_accuracy.max(eta);
        }
        Ok(report)
    }
    fn freeze(&mut self, _: &[f64]) -> Result<Changed, ObjectiveError> {
        self.calls += 1;
        let changed = self.calls == self.changes_at + 1;
        Ok(if changed { Changed::Energy } else { Changed::Nothing })
    }
}

#[test]
fn an_energy_that_changes_between_iterations_is_evaluated_anew() {
    // Without new evaluation, ten times the energy could never fall below the old value.
    let mut objective = Wrapped { inner: rosenbrock(), calls: 0, changes_at: 3, worst_accuracy: 0.0 };
    let mut x = [-1.2, 1.0];
    let report = minimise(&mut objective, &mut x, &tolerance(1e-10)).unwrap();
    assert_eq!(report.changes, 1);
    assert!((x[0] - 1.0).abs() < 1e-12);
}

/// f(x) = F x − c ln x, and whether short directions that are a good part of x are refused.
struct Squeezed {
    refuses: bool,
    asked: u32,
}

impl Objective for Squeezed {
    fn dimension(&self) -> usize {
        1
    }
    fn value(&mut self, x: &[f64]) -> f64 {
        if x[0] > 0.0 { 2.0 * x[0] - 6.0 * x[0].ln() } else { f64::INFINITY }
    }
    fn gradient_into(&mut self, x: &[f64], g: &mut [f64]) {
        g[0] = 2.0 - 6.0 / x[0];
    }
    fn direction_into(
        &mut self,
        x: &[f64],
        g: &[f64],
        _: DirectionAccuracy,
        p: &mut [f64],
    ) -> Result<DirectionReport, ObjectiveError> {
        p[0] = -g[0] * x[0] * x[0] / 6.0;
        Ok(DirectionReport::default())
    }
    fn is_settled(&mut self, x: &[f64], p: &[f64]) -> bool {
        self.asked += 1;
        assert!(p[0].abs() < 1e-2, "asked though the direction is long");
        !self.refuses || p[0].abs() < 0.1 * x[0]
    }
}

#[test]
fn a_short_direction_does_not_end_what_is_not_settled() {
    // Far below the minimum at 3 every step doubles x: it is far shorter than the tolerance.
    for (refuses, expected) in [(false, 1e-9), (true, 3.0)] {
        let mut objective = Squeezed { refuses, asked: 0 };
        let mut x = [1e-9];
        let report = minimise(&mut objective, &mut x, &tolerance(1e-2)).unwrap();
        assert!((x[0] / expected - 1.0).abs() < 1e-2, "{x:?}");
        // 1e-9 · 2ⁿ reaches the tolerance after 23 steps, and the minimum after 31.
        assert_eq!(report.unsettled, if refuses { 24 } else { 0 });
        assert!(u64::from(objective.asked) == report.unsettled + 1, "{report:?}");
    }
}

#[test]
fn inexact_directions_converge_and_do_not_decide_by_themselves() {
    let never = u32::MAX - 1;
    for (forcing, most) in [
        (Forcing::Constant(0.5), 60),
        (Forcing::Constant(0.1), 40),
        (Forcing::EisenstatWalker { first: 0.5, largest: 0.9 }, 60),
    ] {
        let mut objective = Wrapped { inner: rosenbrock(), calls: 0, changes_at: never, worst_accuracy: 0.0 };
        let mut x = [-1.2, 1.0];
        let options = NewtonOptions { forcing, ..tolerance(1e-10) };
        let report = minimise(&mut objective, &mut x, &options).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-9 && report.iterations <= most, "{forcing:?} {report:?}");
        assert!(objective.worst_accuracy > 0.09);
    }
    // The direction of η = 0.999 is a thousandth of Newton's, so it looks converged at once.
    let (inner, solution) = quadratic(4, 10.0, 35);
    let mut objective = Wrapped { inner, calls: 0, changes_at: never, worst_accuracy: 0.0 };
    let mut x: Vec<f64> = solution.iter().map(|x| x + 1e-3).collect();
    let options = NewtonOptions { forcing: Forcing::Constant(0.999), ..tolerance(1e-5) };
    minimise(&mut objective, &mut x, &options).unwrap();
    let error = solution.iter().zip(&x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(error < 1.1e-5, "{error:e}");
}

/// An objective with another rounding, whose element 3 limits its steps.
struct Altered {
    inner: DenseObjective<Problem>,
    rounding: f64,
    limit: f64,
}

impl Objective for Altered {
    fn dimension(&self) -> usize {
        self.inner.dimension()
    }
    fn value(&mut self, x: &[f64]) -> f64 {
        self.inner.value(x)
    }
    fn gradient_into(&mut self, x: &[f64], g: &mut [f64]) {
        self.inner.gradient_into(x, g);
    }
    fn direction_into(
        &mut self,
        x: &[f64],
        g: &[f64],
        a: DirectionAccuracy,
        p: &mut [f64],
    ) -> Result<DirectionReport, ObjectiveError> {
        self.inner.direction_into(x, g, a, p)
    }
    fn rounding(&self, _: f64) -> f64 {
        self.rounding
    }
    fn limit_step(&mut self, _: &[f64], _: &[f64]) -> Result<Limit, ObjectiveError> {
        Ok(Limit { fraction: self.limit, location: Location { element: Some(3), ..Location::default() } })
    }
}

/// ½ (1e6 x₀² + 1e-6 (x₁ − 1)²), with directions as inexact as they are allowed to be: components whose residual
/// fits into the accuracy are left out. The soft unknown is a metre off while its force is a thousandth of the total.
struct SoftAndStiff;

impl Objective for SoftAndStiff {
    fn dimension(&self) -> usize {
        2
    }
    fn value(&mut self, x: &[f64]) -> f64 {
        0.5 * (1e6 * x[0] * x[0] + 1e-6 * (x[1] - 1.0).powi(2))
    }
    fn gradient_into(&mut self, x: &[f64], g: &mut [f64]) {
        g.copy_from_slice(&[1e6 * x[0], 1e-6 * (x[1] - 1.0)]);
    }
    fn direction_into(
        &mut self,
        _: &[f64],
        g: &[f64],
        accuracy: DirectionAccuracy,
        p: &mut [f64],
    ) -> Result<DirectionReport, ObjectiveError> {
        p.copy_from_slice(&[-g[0] / 1e6, -g[1] / 1e-6]);
        if let DirectionAccuracy::Relative(part) = accuracy {
            let residual = part * g[0].hypot(g[1]);
            p.iter_mut().zip(g).filter(|(_, g)| g.abs() <= residual).for_each(|(p, _)| *p = 0.0);
        }
        Ok(DirectionReport::default())
    }
}

#[test]
fn an_inexact_direction_does_not_decide_convergence() {
    for forcing in
        [Forcing::Exact, Forcing::Constant(1e-3), Forcing::EisenstatWalker { first: 0.1, largest: 0.5 }]
    {
        let mut x = [1e-9, 0.0];
        let options = NewtonOptions { forcing, ..NewtonOptions::default() };
        minimise(&mut SoftAndStiff, &mut x, &options).unwrap();
        assert!((x[1] - 1.0).abs() < 1e-6, "{forcing:?} {x:?}");
    }
}

/// A limit beyond the whole step, or none at all, is the objective's mistake; one too short to move anything blocks.
#[test]
fn limits_that_are_no_part_of_a_step_are_errors() {
    for fraction in [f64::NAN, -0.5, 1.5, f64::INFINITY] {
        let mut objective = Altered { inner: quadratic(3, 10.0, 34).0, rounding: 1e-15, limit: fraction };
        let error = failure(&mut objective, &[9.0; 3], &tolerance(1e-6));
        let NewtonCause::StepLimit { fraction: named, location } = &error.cause else { panic!("{error}") };
        assert!(named.to_bits() == fraction.to_bits() && location.element == Some(3), "{error}");
    }
    for fraction in [0.0, 1e-300, 1e-20] {
        let mut objective = Altered { inner: quadratic(3, 10.0, 34).0, rounding: 1e-15, limit: fraction };
        let error = failure(&mut objective, &[9.0; 3], &tolerance(1e-6));
        assert!(
            matches!(&error.cause, NewtonCause::Blocked { location } if location.element == Some(3)),
            "{error}"
        );
    }
}

/// 1 + ½ x², with a Hessian that is too large by some factor: steps are too short by it, and soon change nothing in the value.
fn sluggish(factor: f64) -> DenseObjective<Problem> {
    problem(1, |x| 1.0 + 0.5 * x[0] * x[0], |x| vec![x[0]], move |_| DMatrix::from_element(1, 1, factor))
}

/// Steps that neither shrink nor change the value end the minimisation early, with the step norm that was reached.
#[test]
fn stagnation_is_an_error_that_says_what_was_reached() {
    let error = failure(&mut sluggish(1e4), &[1e-5], &tolerance(1e-12));
    let NewtonCause::Stagnated { tolerance, reached, .. } = error.cause else { panic!("{error}") };
    assert!(tolerance == 1e-12 && reached > 9e-10 && reached <= 1e-9, "{reached:e}");
    assert!(error.report.iterations < 30, "{}", error.report.iterations);
    // Slow is not stagnant: a fifth off every step gets there.
    let mut x = [1e-7];
    let report =
        minimise(&mut sluggish(5.0), &mut x, &NewtonOptions { tolerance: 1e-14, ..tolerance_of(300) });
    let report = report.unwrap();
    assert!(x[0].abs() < 1e-12 && report.at_rounding == 0, "{x:?} {report:?}");
}

fn tolerance_of(max_iterations: u32) -> NewtonOptions {
    NewtonOptions { max_iterations, ..NewtonOptions::default() }
}

/// 1e12 (x³/3 − 2x): its minimum √2 is no floating-point number, and next to it the gradient is 4e-4 or more, its rounding. A tolerance
/// below the distance of neighbouring numbers cannot be met.
#[test]
fn a_tolerance_below_the_gradient_s_rounding_ends_at_rounding() {
    for start in 0..20 {
        let mut objective = problem(
            1,
            |x| 1e12 * (x[0].powi(3) / 3.0 - 2.0 * x[0]),
            |x| vec![1e12 * (x[0] * x[0] - 2.0)],
            |x| DMatrix::from_row_slice(1, 1, &[2e12 * x[0]]),
        );
        let mut x = [1.0 + 0.1 * f64::from(start)];
        let report =
            minimise(&mut objective, &mut x, &NewtonOptions { tolerance: 1e-18, ..tolerance_of(100) });
        let report = report.unwrap();
        assert!(report.iterations < 40 && report.at_rounding == 1, "{start}: {report:?}");
        assert!((x[0] - SQRT_2).abs() < 1e-15, "{x:?}");
    }
}

/// A stiff unknown at its minimum, 1e12 (x − 1e3/3)² / 2, whose gradient is noise of 0.07, and a soft one, (y − ½)² / 2, that may go 0.01 at
/// a time: its directions barely shrink because its steps are cut short, not because rounding is all that is left. The value resolves
/// neither.
#[test]
fn steps_that_are_cut_short_are_no_sign_of_rounding() {
    let at = 1e3 / 3.0;
    let mut objective = problem(
        2,
        move |x| 1e15 + 0.5e12 * (x[0] - at).powi(2) + 0.5 * (x[1] - 0.5).powi(2),
        move |x| vec![1e12 * (x[0] - at), x[1] - 0.5],
        |_| DMatrix::from_row_slice(2, 2, &[1e12, 0.0, 0.0, 1.0]),
    );
    objective.problem.limit = Box::new(|_, p| (0.01 / p[1].abs()).min(1.0));
    let mut x = [at, 0.0];
    let report = minimise(&mut objective, &mut x, &NewtonOptions { tolerance: 1e-6, ..tolerance_of(100) });
    let report = report.unwrap();
    assert!((x[1] - 0.5).abs() < 1e-6 && report.at_rounding == 0, "{x:?} {report:?}");
}
