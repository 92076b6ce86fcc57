use crate::samples::{Random, Springs, Volumes, grid_points, grid_tetrahedra};
use mechanics_core::derivatives::{check_objective_direction, check_objective_gradient};
use mechanics_core::newton::{NewtonCause, NewtonOptions, minimise};
use mechanics_core::objective::{
    DenseCholesky, DirectionAccuracy, DirectionSolver, IncrementalPotential, Objective, ObjectiveError,
    SolverError, TimeStep,
};
use mechanics_core::parallel::with_threads;
use mechanics_core::point_map::{PointMap, PointSource};
use mechanics_core::potential::{Changed, Potential, PotentialError, StepLimit};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::{Assembler, Assembly, BlockMatrix};
use mechanics_core::stage::{Coefficients, Moment, Scheme, Stage};
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

/// ½ c m ‖x − x̃‖² of each point, with x̃ its own.
struct Inertia {
    factor: f64,
    target: Vec<Vec3>,
}

impl Stencil<1> for Inertia {
    fn value(&self, e: usize, x: &[Vec3; 1]) -> f64 {
        0.5 * self.factor * (x[0] - self.target[e]).norm_squared()
    }
    fn gradient(&self, e: usize, x: &[Vec3; 1]) -> [Vec3; 1] {
        [(x[0] - self.target[e]) * self.factor]
    }
    fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
        [[Mat3::from_diagonal_element(self.factor)]]
    }
}

fn all_points(n: usize) -> Vec<[u32; 1]> {
    (0..n as u32).map(|i| [i]).collect()
}

fn flatten(x: &[Vec3]) -> Vec<f64> {
    x.iter().flatten().copied().collect()
}

fn statics(x: &[Vec3]) -> TimeStep<'_> {
    TimeStep { time: 0.0, step: 0.0, scheme: Scheme::statics(x) }
}

/// Two springs in line, ends fixed, the middle loaded sideways by its inertia target: the force balance in closed
/// form. Middle at height y: 2 k (l − L) y / l = w (t − y) with l = √(1 + y²).
#[test]
fn a_loaded_string_hangs_where_its_forces_balance() {
    let (k, rest, w, t) = (50.0, 0.8, 4.0, -2.0);
    let x = [Vec3::new(-1.0, 0.0, 0.0), Vec3::zeros(), Vec3::new(1.0, 0.0, 0.0)];
    let springs = Springs { stiffness: vec![k; 2], rest_length: vec![rest; 2] };
    let mut springs = StencilTerm::new("springs", springs, vec![[0, 1], [1, 2]]).unwrap();
    let pull = Inertia { factor: w, target: vec![Vec3::new(0.0, t, 0.0)] };
    let mut pull = StencilTerm::new("pull", pull, vec![[1]]).unwrap();
    let map = PointMap::with_fixed(3, &[(0, x[0]), (2, x[2])]).unwrap();
    let (mut assembly, mut solver) = (Assembly::new(&map), DenseCholesky::new());
    let mut terms: [&mut dyn Potential; 2] = [&mut springs, &mut pull];
    let mut objective = IncrementalPotential::new(&mut terms, &map, statics(&x), &mut assembly, &mut solver);
    let mut q = vec![0.0; 3];
    minimise(&mut objective, &mut q, &NewtonOptions { tolerance: 1e-12, ..Default::default() }).unwrap();
    let (y, l) = (q[1], (1.0 + q[1] * q[1]).sqrt());
    let imbalance = 2.0 * k * (l - rest) * y / l - w * (t - y);
    assert!(imbalance.abs() < 1e-10 && q[0].abs() < 1e-12 && y < -0.1, "{q:?} {imbalance:e}");
    assert!(solver.factorisation().is_some(), "the last factorisation is there for adjoints");
}

/// Weighted unknowns: gradient against value and Hessian against gradient, through the whole chain.
#[test]
fn derivatives_hold_through_a_point_map() {
    let mut random = Random(41);
    let elements = random.elements::<4>(40, 14);
    let volumes = Volumes { weight: 2.0, stiffness: 3.0, volume: vec![0.2; 40] };
    let mut volumes = StencilTerm::new("volumes", volumes, elements).unwrap();
    let rest = random.vectors(14);
    let weights: Vec<Vec<(u32, f64)>> =
        rest.iter().map(|r| vec![(0, 1.0), (1, r.x), (2, r.y), (3, r.z)]).collect();
    let sources = weights.iter().enumerate().map(|(i, w)| match i {
        0 => PointSource::Fixed,
        1 => PointSource::Unknown(4),
        _ => PointSource::Weighted(w),
    });
    let map = PointMap::new(5, sources).unwrap();
    let (mut assembly, mut solver) = (Assembly::new(&map), DenseCholesky::new());
    let q: Vec<f64> = (0..15).map(|_| 0.3 * random.number()).collect();
    let mut terms: [&mut dyn Potential; 1] = [&mut volumes];
    let mut objective =
        IncrementalPotential::new(&mut terms, &map, statics(&rest), &mut assembly, &mut solver)
            .with_projection(Projection::None);
    check_objective_gradient(&mut objective, &q).require(1e-8).unwrap();
    check_objective_direction(&mut objective, &q).unwrap().require(1e-7).unwrap();
}

/// The whole minimisation, bit for bit, for any number of threads.
#[test]
fn minima_have_the_same_bits_for_any_number_of_threads() {
    let n = 5;
    let start = grid_points(n);
    let run = |threads: usize| {
        with_threads(threads, || {
            let tetrahedra = grid_tetrahedra(n);
            let count = start.len();
            let volume = vec![1.3 / (n * n * n) as f64; tetrahedra.len()];
            let volumes = Volumes { weight: 2e3, stiffness: 0.1, volume };
            let mut volumes = StencilTerm::new("volumes", volumes, tetrahedra).unwrap();
            let inertia = Inertia { factor: 1.0, target: start.clone() };
            let mut inertia = StencilTerm::new("inertia", inertia, all_points(count)).unwrap();
            let map = PointMap::with_fixed(count, &[(0, start[0]), (1, start[1])]).unwrap();
            let (mut assembly, mut solver) = (Assembly::new(&map), DenseCholesky::new());
            let mut q = vec![0.0; 3 * map.unknowns()];
            map.unknowns_into(&start, &mut q).unwrap();
            let mut terms: [&mut dyn Potential; 2] = [&mut inertia, &mut volumes];
            let mut objective =
                IncrementalPotential::new(&mut terms, &map, statics(&start), &mut assembly, &mut solver);
            let options = NewtonOptions { tolerance: 1e-9, ..Default::default() };
            let report = minimise(&mut objective, &mut q, &options).unwrap();
            (
                q.iter().map(|q| q.to_bits()).collect::<Vec<_>>(),
                report.iterations,
                report.halvings,
                report.shifts,
            )
        })
    };
    let one = run(1);
    assert!(one.1 > 2, "{} iterations prove something", one.1);
    for threads in [2, 3, 8] {
        assert!(run(threads) == one, "{threads} threads");
    }
}

/// Nothing holds the body: rigid motion has no stiffness. The shift makes the matrix definite, and is counted.
#[test]
fn a_free_body_in_statics_is_solved_with_a_shift() {
    let x = [Vec3::zeros(), Vec3::x() * 1.5, Vec3::y()];
    let springs = Springs { stiffness: vec![10.0; 3], rest_length: vec![1.0; 3] };
    let mut springs = StencilTerm::new("springs", springs, vec![[0, 1], [1, 2], [2, 0]]).unwrap();
    let map = PointMap::identity(3);
    let (mut assembly, mut solver) = (Assembly::new(&map), DenseCholesky::new());
    let mut q = flatten(&x);
    let mut terms: [&mut dyn Potential; 1] = [&mut springs];
    let mut objective = IncrementalPotential::new(&mut terms, &map, statics(&x), &mut assembly, &mut solver);
    let report = minimise(&mut objective, &mut q, &NewtonOptions::default()).unwrap();
    assert!(report.shifts > 0 && objective.value(&q) < 1e-10, "{report:?}");
}

/// Counts the matrices that it is given.
#[derive(Default)]
struct Counting {
    solver: DenseCholesky,
    matrices: u64,
}

impl DirectionSolver for Counting {
    fn prepare(&mut self, matrix: &BlockMatrix) -> Result<(), SolverError> {
        self.matrices += 1;
        self.solver.prepare(matrix)
    }
    fn solve_into(
        &mut self,
        b: &[f64],
        accuracy: DirectionAccuracy,
        x: &mut [f64],
    ) -> Result<u64, SolverError> {
        self.solver.solve_into(b, accuracy, x)
    }
}

/// Point 0: ½ (x² + y²) + w (z² − 1)², a crest at z = 0 between valleys at ±1. Other points: ½ k (x − 100)² + ½ z², free along y.
struct Crest {
    well: f64,
    soft: f64,
}

impl Stencil<1> for Crest {
    fn value(&self, e: usize, &[x]: &[Vec3; 1]) -> f64 {
        match e {
            0 => 0.5 * (x.x * x.x + x.y * x.y) + self.well * (x.z * x.z - 1.0).powi(2),
            _ => 0.5 * (self.soft * (x.x - 100.0).powi(2) + x.z * x.z),
        }
    }
    fn gradient(&self, e: usize, &[x]: &[Vec3; 1]) -> [Vec3; 1] {
        [match e {
            0 => Vec3::new(x.x, x.y, 4.0 * self.well * x.z * (x.z * x.z - 1.0)),
            _ => Vec3::new(self.soft * (x.x - 100.0), 0.0, x.z),
        }]
    }
    fn hessian(&self, e: usize, &[x]: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
        let diagonal = match e {
            0 => Vec3::new(1.0, 1.0, 4.0 * self.well * (3.0 * x.z * x.z - 1.0)),
            _ => Vec3::new(self.soft, 0.0, 1.0),
        };
        [[Mat3::from_diagonal(&diagonal)]]
    }
}

/// From beside the crest into the valley. The crest bends by −4w, the mean of its block's diagonal is (2 − 4w)/3: with w = 1e-3 it takes
/// 0.006 of that to make the matrix definite, so that of all shifts 1e-2 is the least. Steps are then 1.5 z, twenty of them from 1e-8 to
/// where the slope turns, and about five unshifted ones to the valley. Trying shifts from the smallest on takes three a direction, sixty in all;
/// with the memory of the last it is one and two by turns.
#[test]
fn shifts_begin_where_the_last_direction_ended() {
    let start = [Vec3::z() * 1e-8];
    let crest = Crest { well: 1e-3, soft: 0.0 };
    let mut crest = StencilTerm::new("crest", crest, all_points(1)).unwrap();
    let map = PointMap::identity(1);
    let (mut assembly, mut solver) = (Assembly::new(&map), Counting::default());
    let mut q = flatten(&start);
    let mut terms: [&mut dyn Potential; 1] = [&mut crest];
    let mut objective =
        IncrementalPotential::new(&mut terms, &map, statics(&start), &mut assembly, &mut solver);
    let options = NewtonOptions { tolerance: 1e-10, ..Default::default() };
    let report = minimise(&mut objective, &mut q, &options).unwrap();
    assert!((q[2] - 1.0).abs() < 1e-9, "{q:?}");
    assert_eq!(solver.matrices, report.factorisations);
    assert!((15..25).contains(&(solver.matrices - report.shifts - 5)), "{report:?}");
    assert!((18..=36).contains(&report.shifts), "{report:?}");
}

/// One direction over a crest needs a shift of 1e-2. Behind it the matrix is singular, because nothing holds point 1 along y, and 1e-10 would do; the shift
/// remembered shortens the way of point 1, which is soft, from a hundred metres to less than the tolerance.
#[test]
fn a_remembered_shift_does_not_decide_convergence() {
    let start = [Vec3::z() * 0.5, Vec3::zeros()];
    let mut crest = StencilTerm::new("crest", Crest { well: 1e-3, soft: 1e-6 }, all_points(2)).unwrap();
    let map = PointMap::identity(2);
    let (mut assembly, mut solver) = (Assembly::new(&map), DenseCholesky::new());
    let mut q = flatten(&start);
    let mut terms: [&mut dyn Potential; 1] = [&mut crest];
    let mut objective =
        IncrementalPotential::new(&mut terms, &map, statics(&start), &mut assembly, &mut solver);
    let options = NewtonOptions { tolerance: 0.2, ..Default::default() };
    let report = minimise(&mut objective, &mut q, &options).unwrap();
    assert!((q[3] - 100.0).abs() < 0.2 && (q[2] - 1.0).abs() < 0.2, "{q:?}");
    assert!(report.shifts > 3, "{report:?}");
}

/// Minus an energy is nobody's minimum: no shift of reasonable size helps.
#[test]
fn an_indefinite_matrix_is_an_error_with_a_point() {
    let x = [Vec3::zeros(), Vec3::x()];
    let maximum = Inertia { factor: -1.0, target: x.to_vec() };
    let mut maximum = StencilTerm::new("maximum", maximum, all_points(2)).unwrap();
    let saddle = Inertia { factor: 0.999, target: x.to_vec() };
    let mut saddle = StencilTerm::new("saddle", saddle, all_points(2)).unwrap();
    let map = PointMap::with_fixed(2, &[(0, x[0])]).unwrap();
    let (mut assembly, mut solver) = (Assembly::new(&map), DenseCholesky::new());
    let mut terms: [&mut dyn Potential; 2] = [&mut maximum, &mut saddle];
    let mut objective = IncrementalPotential::new(&mut terms, &map, statics(&x), &mut assembly, &mut solver);
    let mut q = [1.0, 2.0, 3.0];
    let outcome = minimise(&mut objective, &mut q, &NewtonOptions::default());
    // A shift of once the diagonal makes −H zero, a hundred times makes it definite: then the value falls for ever.
    let error = outcome.unwrap_err();
    assert!(
        matches!(error.cause, NewtonCause::Diverged { .. } | NewtonCause::NotConverged { .. }),
        "{error}"
    );
    assert!(error.report.shifts > 0);
    let nan = Inertia { factor: f64::NAN, target: x.to_vec() };
    struct BadHessian(Inertia);
    impl Stencil<1> for BadHessian {
        fn value(&self, _: usize, _: &[Vec3; 1]) -> f64 {
            1.0
        }
        fn gradient(&self, _: usize, x: &[Vec3; 1]) -> [Vec3; 1] {
            [x[0]]
        }
        fn hessian(&self, e: usize, x: &[Vec3; 1], projection: Projection) -> LocalHessian<1> {
            self.0.hessian(e, x, projection)
        }
    }
    let mut bad = StencilTerm::new("bad", BadHessian(nan), all_points(2)).unwrap();
    let mut terms: [&mut dyn Potential; 1] = [&mut bad];
    let mut objective = IncrementalPotential::new(&mut terms, &map, statics(&x), &mut assembly, &mut solver);
    let error = minimise(&mut objective, &mut q, &NewtonOptions::default()).unwrap_err();
    let named = error.to_string();
    assert!(named.contains("bad: the Hessian of element 0 (points [0]) is NaN"), "{named}");
}

/// What hooks see and when, and how their answers reach the minimiser.
struct Probe {
    moments: Vec<(Moment, f64, f64)>,
    limit: f64,
    refuse: bool,
}

impl Potential for Probe {
    fn name(&self) -> &str {
        "probe"
    }
    fn value(&self, _: &[Vec3]) -> f64 {
        0.0
    }
    fn add_gradient(&self, _: &[Vec3], _: &mut [Vec3]) {}
    fn add_hessian(&self, _: &[Vec3], _: Projection, _: &mut Assembler<'_>) {}
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        if self.refuse {
            let source = "points 3 and 4 intersect".into();
            return Err(PotentialError::Term { term: "probe".into(), source });
        }
        self.moments.push((stage.moment, stage.x[0].x, stage.scheme.velocity(0, &stage.x[0]).x));
        Ok(if stage.moment == Moment::Iteration { Changed::Nothing } else { Changed::Energy })
    }
    fn limit_step(&mut self, _: &[Vec3], _: &[Vec3]) -> Result<StepLimit, PotentialError> {
        Ok(StepLimit::by_element(self.limit, 17))
    }
}

#[test]
fn hooks_are_called_with_the_stage_and_limits_carry_their_term() {
    let h = 0.1;
    let (target, origin) = ([Vec3::x() * 2.0], [Vec3::x()]);
    let inertia = Inertia { factor: 1.0 / (h * h), target: target.to_vec() };
    let mut inertia = StencilTerm::new("inertia", inertia, all_points(1)).unwrap();
    let mut probe = Probe { moments: Vec::new(), limit: 0.5, refuse: false };
    let map = PointMap::identity(1);
    let (mut assembly, mut solver) = (Assembly::new(&map), DenseCholesky::new());
    let scheme = Scheme::new(Coefficients::backward_euler(h), &target, &origin);
    let time_step = TimeStep { time: h, step: h, scheme };
    let mut q = [1.0, 0.0, 0.0];
    let options = NewtonOptions { tolerance: 6.0, ..Default::default() };
    {
        let mut terms: [&mut dyn Potential; 2] = [&mut inertia, &mut probe];
        let mut objective =
            IncrementalPotential::new(&mut terms, &map, time_step, &mut assembly, &mut solver);
        assert_eq!(objective.freeze_at(Moment::Step, &q).unwrap(), Changed::Energy);
        // The full step is 1 m, 10 m/s: half of it is made, the rest (5 m/s) is below the tolerance.
        let report = minimise(&mut objective, &mut q, &options).unwrap();
        assert_eq!((report.iterations, report.limited_steps, q[0]), (1, 1, 1.5));
        let limit = objective.limit_step(&q, &[1.0, 0.0, 0.0]).unwrap();
        assert_eq!((limit.location.term.as_deref(), limit.location.element), (Some("probe"), Some(17)));
        assert!(objective.term_times()[0].hessian > std::time::Duration::ZERO);
    }
    let expected =
        [(Moment::Step, 1.0, 0.0), (Moment::Iteration, 1.0, 0.0), (Moment::Iteration, 1.5, 0.5 / h)];
    assert_eq!(probe.moments, expected);
    for (limit, refuse) in [(0.0, false), (f64::NAN, false), (1.0, true)] {
        (probe.limit, probe.refuse) = (limit, refuse);
        let mut terms: [&mut dyn Potential; 2] = [&mut inertia, &mut probe];
        let mut objective =
            IncrementalPotential::new(&mut terms, &map, time_step, &mut assembly, &mut solver);
        let mut q = [1.0, 0.0, 0.0];
        let cause = minimise(&mut objective, &mut q, &options).unwrap_err().cause;
        match cause {
            NewtonCause::Blocked { location } => {
                assert_eq!(location.to_string(), "term \"probe\", element 17")
            }
            NewtonCause::Objective(ObjectiveError::Potential(error)) => {
                assert!(error.to_string().starts_with("probe: "), "{error}");
            }
            other => panic!("{other}"),
        }
        assert_eq!(q, [1.0, 0.0, 0.0]);
    }
}

/// Not converging names the point that still moves and the term that pulls at it.
#[test]
fn the_culprit_of_not_converging_is_named() {
    let mut x = grid_points(1);
    x[5] *= 3.0;
    let edges: Vec<[u32; 2]> = (0..8).flat_map(|i| (0..i).map(move |j| [j, i])).collect();
    let springs = Springs { stiffness: vec![100.0; edges.len()], rest_length: vec![1.0; edges.len()] };
    let mut springs = StencilTerm::new("springs", springs, edges).unwrap();
    let mut light =
        StencilTerm::new("light", Inertia { factor: 1e-3, target: x.clone() }, all_points(8)).unwrap();
    let map = PointMap::identity(8);
    let (mut assembly, mut solver) = (Assembly::new(&map), DenseCholesky::new());
    let mut terms: [&mut dyn Potential; 2] = [&mut light, &mut springs];
    let mut objective = IncrementalPotential::new(&mut terms, &map, statics(&x), &mut assembly, &mut solver);
    let options = NewtonOptions { max_iterations: 0, ..Default::default() };
    let error = minimise(&mut objective, &mut flatten(&x), &options).unwrap_err();
    let NewtonCause::NotConverged { location, .. } = error.cause else { panic!("{error}") };
    assert_eq!((location.term.as_deref(), location.point), (Some("springs"), Some(5)));
}

/// The sparse solvers reach the dense solver's minimum: directly, and by conjugate gradients with inexact directions,
/// with the same bits for any number of threads.
#[cfg(feature = "solvers")]
#[test]
fn sparse_solvers_reach_the_same_minimum() {
    use mechanics_core::linear::{Method, Ordering, Preconditioner, Solver};
    use mechanics_core::newton::Forcing;
    use mechanics_core::objective::DirectionSolver;

    fn solve(solver: &mut impl DirectionSolver, forcing: Forcing) -> Vec<f64> {
        let n = 4;
        let start = grid_points(n);
        let tetrahedra = grid_tetrahedra(n);
        let volume = vec![1.2 / (n * n * n) as f64; tetrahedra.len()];
        let volumes = Volumes { weight: 200.0, stiffness: 0.1, volume };
        let mut volumes = StencilTerm::new("volumes", volumes, tetrahedra).unwrap();
        let inertia = Inertia { factor: 1.0, target: start.clone() };
        let mut inertia = StencilTerm::new("inertia", inertia, all_points(start.len())).unwrap();
        let map = PointMap::with_fixed(start.len(), &[(0, start[0])]).unwrap();
        let mut assembly = Assembly::new(&map);
        let mut q = vec![0.0; 3 * map.unknowns()];
        map.unknowns_into(&start, &mut q).unwrap();
        let mut terms: [&mut dyn Potential; 2] = [&mut inertia, &mut volumes];
        let mut objective =
            IncrementalPotential::new(&mut terms, &map, statics(&start), &mut assembly, solver);
        let options = NewtonOptions { tolerance: 1e-10, forcing, ..Default::default() };
        minimise(&mut objective, &mut q, &options).unwrap();
        q
    }

    let dense = solve(&mut DenseCholesky::new(), Forcing::Exact);
    let inexact = Forcing::EisenstatWalker { first: 0.1, largest: 0.5 };
    let gradients = Method::ConjugateGradient {
        preconditioner: Preconditioner::BlockJacobi,
        tolerance: 1e-10,
        max_iterations: 1000,
    };
    let direct = Method::Cholesky { ordering: Ordering::NestedDissection };
    for (method, forcing) in [(direct, Forcing::Exact), (gradients, Forcing::Exact), (gradients, inexact)] {
        let run = |threads| with_threads(threads, || solve(&mut Solver::new(method), forcing));
        let sparse = run(1);
        let error = sparse.iter().zip(&dense).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-9, "{method:?} {forcing:?}: {error:e}");
        assert!(run(3) == sparse, "{method:?} {forcing:?}: other bits on three threads");
    }
}

/// Where only a hundred times the diagonal makes the matrix definite, the direction is a hundred times too short, and
/// its length says nothing about the distance to a minimum.
#[test]
fn a_direction_shortened_by_its_shift_does_not_decide_convergence() {
    let start = [Vec3::zeros()];
    let mut maximum =
        StencilTerm::new("maximum", Inertia { factor: -1.0, target: start.to_vec() }, all_points(1)).unwrap();
    let map = PointMap::identity(1);
    let (mut assembly, mut solver) = (Assembly::new(&map), DenseCholesky::new());
    let mut terms: [&mut dyn Potential; 1] = [&mut maximum];
    let mut objective =
        IncrementalPotential::new(&mut terms, &map, statics(&start), &mut assembly, &mut solver);
    let options = NewtonOptions { tolerance: 0.5, ..NewtonOptions::default() };
    // −½ |x|² at x = 10 m: the direction is g / 99, a tenth of a metre.
    let error = minimise(&mut objective, &mut [10.0, 0.0, 0.0], &options).unwrap_err();
    assert!(error.report.iterations > 0, "{error}");
}

/// With a step size that is zero, negative or no number, every step norm would be below every tolerance, or none.
#[test]
fn a_scheme_without_a_positive_step_is_refused() {
    let start = [Vec3::zeros()];
    let map = PointMap::identity(1);
    for h in [0.0, -0.1, f64::INFINITY, f64::NAN, 1e-300] {
        for coefficients in
            [Coefficients::backward_euler(h), Coefficients::bdf2(h), Coefficients::average_acceleration(h)]
        {
            let mut pull =
                StencilTerm::new("pull", Inertia { factor: 1.0, target: start.to_vec() }, all_points(1))
                    .unwrap();
            let (mut assembly, mut solver) = (Assembly::new(&map), DenseCholesky::new());
            let mut terms: [&mut dyn Potential; 1] = [&mut pull];
            let time_step =
                TimeStep { time: 0.0, step: h, scheme: Scheme::new(coefficients, &start, &start) };
            let mut objective =
                IncrementalPotential::new(&mut terms, &map, time_step, &mut assembly, &mut solver);
            let mut q = [10.0, 0.0, 0.0];
            let error = minimise(&mut objective, &mut q, &NewtonOptions::default()).unwrap_err();
            assert!(
                matches!(error.cause, NewtonCause::Objective(ObjectiveError::Coefficients(_))),
                "{h} {error}"
            );
        }
    }
}

/// Rigid motion is free, and the last pivots of a sparse factorisation are rounding, of either sign.
#[cfg(feature = "solvers")]
#[test]
fn a_free_body_is_solved_with_a_shift_by_the_sparse_solvers_too() {
    use mechanics_core::linear::{Method, Solver};
    let start = grid_points(3);
    let map = PointMap::identity(start.len());
    for size in [1.0, 1e-3, 1e4] {
        let tetrahedra = grid_tetrahedra(3);
        let edges: std::collections::BTreeSet<[u32; 2]> = tetrahedra
            .iter()
            .flat_map(|t| (0..4).flat_map(move |i| (0..i).map(move |j| [t[i].min(t[j]), t[i].max(t[j])])))
            .collect();
        let edges: Vec<[u32; 2]> = edges.into_iter().collect();
        let rest: Vec<Vec3> = start.iter().map(|x| x * size).collect();
        let length = |e: &[u32; 2]| (rest[e[0] as usize] - rest[e[1] as usize]).norm();
        let springs =
            Springs { stiffness: vec![3.0; edges.len()], rest_length: edges.iter().map(length).collect() };
        let mut springs = StencilTerm::new("springs", springs, edges).unwrap();
        let mut q: Vec<f64> = flatten(&rest).iter().map(|x| 1.2 * x).collect();
        let (mut assembly, mut solver) = (Assembly::new(&map), Solver::new(Method::Automatic));
        let mut terms: [&mut dyn Potential; 1] = [&mut springs];
        let mut objective =
            IncrementalPotential::new(&mut terms, &map, statics(&rest), &mut assembly, &mut solver);
        let options = NewtonOptions { tolerance: 1e-9 * size, ..NewtonOptions::default() };
        minimise(&mut objective, &mut q, &options).unwrap();
        assert!(objective.value(&q) < 1e-16 * size * size, "{size} {:e}", objective.value(&q));
    }
}

/// Springs between whatever points are near each other: contacts that come and go as points move.
#[cfg(feature = "solvers")]
struct Nearby {
    reach: f64,
    stiffness: f64,
    pairs: Vec<[u32; 2]>,
}

#[cfg(feature = "solvers")]
impl Nearby {
    fn term(&self) -> StencilTerm<Springs, 2> {
        let springs = Springs {
            stiffness: vec![self.stiffness; self.pairs.len()],
            rest_length: vec![self.reach; self.pairs.len()],
        };
        StencilTerm::new("nearby", springs, self.pairs.clone()).unwrap()
    }
}

#[cfg(feature = "solvers")]
impl Potential for Nearby {
    fn name(&self) -> &str {
        "nearby"
    }
    fn value(&self, x: &[Vec3]) -> f64 {
        self.term().value(x)
    }
    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.term().add_gradient(x, gradient);
    }
    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.term().add_hessian(x, projection, hessian);
    }
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        let near = |i: usize, j: usize| (stage.x[i] - stage.x[j]).norm() < self.reach;
        let count = stage.x.len();
        let pairs = (0..count).flat_map(|i| (0..i).map(move |j| (i, j))).filter(|&(i, j)| near(i, j));
        self.pairs = pairs.map(|(i, j)| [i as u32, j as u32]).collect();
        Ok(Changed::Energy)
    }
}

/// One backward Euler step of a shaken, crumpling block.
#[cfg(feature = "solvers")]
fn crumple(
    state: &mut (Vec<Vec3>, Vec<Vec3>),
    number: usize,
    assembly: &mut Assembly,
    solver: &mut mechanics_core::linear::Solver,
    map: &PointMap,
) -> u64 {
    let (x, v) = state;
    let h = 0.05;
    let push = |x: &Vec3| Vec3::new(-x.x, (3.0 * x.x + number as f64).sin(), -0.7 * x.z) * 4.0;
    let target: Vec<Vec3> = x.iter().zip(v.iter()).map(|(x, v)| x + (v + push(x) * h) * h).collect();
    let coefficients = Coefficients::backward_euler(h);
    let inertia = Inertia { factor: coefficients.inertia, target: target.clone() };
    let mut inertia = StencilTerm::new("inertia", inertia, all_points(x.len())).unwrap();
    let mut nearby = Nearby { reach: 0.4, stiffness: 60.0, pairs: Vec::new() };
    let start = x.clone();
    let time_step = TimeStep { time: 0.0, step: h, scheme: Scheme::new(coefficients, &target, &start) };
    let mut terms: [&mut dyn Potential; 2] = [&mut inertia, &mut nearby];
    let mut objective = IncrementalPotential::new(&mut terms, map, time_step, assembly, solver);
    let mut q = flatten(x);
    let _ = objective.freeze_at(Moment::Step, &q).unwrap();
    let options = NewtonOptions { tolerance: 1e-3, max_iterations: 60, ..NewtonOptions::default() };
    let iterations = minimise(&mut objective, &mut q, &options).unwrap().iterations;
    map.points_into(&q, x);
    for ((v, x), start) in v.iter_mut().zip(x.iter()).zip(&start) {
        *v = (x - start) / h;
    }
    iterations
}

/// A step's bits depend on the state given in alone: not on what assembly and solver remember of earlier steps.
#[cfg(feature = "solvers")]
#[test]
fn a_run_resumed_with_new_objects_repeats_the_original_bit_for_bit() {
    use mechanics_core::linear::{Method, Ordering, Solver};
    let start = grid_points(4);
    let map = PointMap::identity(start.len());
    for method in [
        Method::Automatic,
        Method::Cholesky { ordering: Ordering::NestedDissection },
        Method::Cholesky { ordering: Ordering::MinimumDegree },
    ] {
        let (mut assembly, mut solver) = (Assembly::new(&map), Solver::new(method));
        let mut state = (start.clone(), vec![Vec3::zeros(); start.len()]);
        let (mut iterations, mut patterns) = (0, std::collections::BTreeSet::new());
        for number in 0..12 {
            let mut copy = state.clone();
            iterations += crumple(&mut state, number, &mut assembly, &mut solver, &map);
            crumple(&mut copy, number, &mut Assembly::new(&map), &mut Solver::new(method), &map);
            assert!(copy == state, "{method:?}: step {number} remembers");
            patterns.insert(assembly.matrix().pattern().rows().to_vec());
        }
        assert!(
            iterations > 20 && patterns.len() > 5,
            "{iterations} iterations, {} patterns",
            patterns.len()
        );
    }
}
