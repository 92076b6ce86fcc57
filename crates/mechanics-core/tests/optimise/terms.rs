use crate::samples::{Random, Springs, Volumes, grid_points, grid_tetrahedra};
use mechanics_core::parallel::{self, with_threads};
use mechanics_core::potential::{Potential, PotentialError, Quantity};
use mechanics_core::projection::Projection;
use mechanics_core::stage::Coefficients;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilError, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

fn volumes(n: usize) -> (StencilTerm<Volumes, 4>, Vec<Vec3>) {
    let tetrahedra = grid_tetrahedra(n);
    let volume = vec![1.0 / (n * n * n) as f64; tetrahedra.len()];
    let stencil = Volumes { weight: 10.0, stiffness: 0.2, volume };
    (StencilTerm::new("volumes", stencil, tetrahedra).unwrap(), grid_points(n))
}

/// Against plain loops, and bit for bit across thread counts, whether threads share the elements by where they lie or
/// compute them in batches, since they come in wild order; 10,368 elements make several batches.
#[test]
fn sums_are_those_of_plain_loops_with_the_same_bits_for_any_number_of_threads() {
    let (term, x) = volumes(12);
    check_sums(&term, &x);
    let mut shuffled = term.elements().to_vec();
    let mut random = Random(31);
    (1..shuffled.len()).for_each(|k| shuffled.swap(k, random.below(k + 1)));
    check_sums(&StencilTerm::new("shuffled", term.stencil().clone(), shuffled).unwrap(), &x);
}

fn check_sums(term: &StencilTerm<Volumes, 4>, x: &[Vec3]) {
    let at = |e: &[u32; 4]| e.map(|i| x[i as usize]);
    let stencil = term.stencil();
    let expected: f64 = term.elements().iter().enumerate().map(|(e, p)| stencil.value(e, &at(p))).sum();
    let mut gradient = vec![Vec3::zeros(); x.len()];
    for (e, points) in term.elements().iter().enumerate() {
        let local = stencil.gradient(e, &at(points));
        points.iter().zip(local).for_each(|(&i, local)| gradient[i as usize] += local);
    }
    let value = with_threads(1, || term.value(x));
    assert!((value - expected).abs() < 1e-13 * expected.abs(), "{value} {expected}");
    for threads in [1, 2, 3, 8] {
        with_threads(threads, || {
            assert_eq!(term.value(x).to_bits(), value.to_bits(), "{threads} threads");
            let mut sum = vec![Vec3::zeros(); x.len()];
            term.add_gradient(x, &mut sum);
            assert_eq!(sum, gradient, "{threads} threads: element order, so equality, not nearness");
        });
    }
}

/// A stencil that computes in runs sees all elements once, in whatever runs they come.
#[test]
fn elements_handed_over_in_runs_are_complete_and_gathered() {
    struct Runs;
    impl Stencil<1> for Runs {
        fn value(&self, _: usize, _: &[Vec3; 1]) -> f64 {
            unreachable!("overridden")
        }
        fn gradient(&self, _: usize, _: &[Vec3; 1]) -> [Vec3; 1] {
            unreachable!("overridden")
        }
        fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
            unreachable!("overridden")
        }
        fn values_into(&self, first: usize, x: &[[Vec3; 1]], values: &mut [f64]) {
            assert_eq!(x.len(), values.len());
            values.iter_mut().zip(x).zip(first..).for_each(|((v, x), e)| *v = e as f64 * x[0].x);
        }
        fn gradients_into(&self, first: usize, x: &[[Vec3; 1]], gradients: &mut [[Vec3; 1]]) {
            assert_eq!(x.len(), gradients.len());
            gradients.iter_mut().zip(first..).for_each(|(g, e)| *g = [Vec3::x() * e as f64]);
        }
    }
    let n = 5000;
    let term = StencilTerm::new("runs", Runs, (0..n).rev().map(|i| [i]).collect()).unwrap();
    let x: Vec<Vec3> = (0..n).map(|i| Vec3::x() * f64::from(i)).collect();
    // Σ e (n − 1 − e), all integers, so exactly; the sum of e(N − e) for e = 0..N with N = n − 1 is N(N² − 1)/6.
    let m = f64::from(n - 1);
    assert_eq!(term.value(&x), m * (m * m - 1.0) / 6.0);
    let mut gradient = vec![Vec3::zeros(); n as usize];
    term.add_gradient(&x, &mut gradient);
    assert!(gradient.iter().enumerate().all(|(i, g)| g.x == m - i as f64));
}

#[test]
fn errors_name_the_element() {
    let springs = Springs { stiffness: vec![1.0; 3], rest_length: vec![1.0; 3] };
    let twice = StencilTerm::new("springs", springs.clone(), vec![[0, 1], [1, 1], [2, 0]]).err();
    assert_eq!(twice, Some(StencilError::RepeatedPoint { term: "springs".into(), element: 1, point: 1 }));
    let term = StencilTerm::new("springs", springs, vec![[0, 1], [1, 2], [2, 0]]).unwrap();
    let mut x = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
    assert!(term.diagnose(&x).is_none());
    x[2] = x[1];
    match term.diagnose(&x) {
        Some(PotentialError::NonFinite {
            term, quantity: Quantity::Gradient, element: 1, points, ..
        }) => {
            assert_eq!((term.as_str(), points.as_slice()), ("springs", &[1, 2][..]));
        }
        other => panic!("coincident ends have no direction: {other:?}"),
    }
    x[0].y = f64::NAN;
    let nan = term.diagnose(&x).unwrap();
    assert!(nan.to_string().starts_with("springs: the energy of element 0 (points [0, 1]) is NaN"), "{nan}");
}

#[test]
fn the_step_limit_is_the_smallest_and_names_its_element() {
    struct Walls;
    impl Stencil<1> for Walls {
        fn value(&self, _: usize, _: &[Vec3; 1]) -> f64 {
            0.0
        }
        fn gradient(&self, _: usize, _: &[Vec3; 1]) -> [Vec3; 1] {
            [Vec3::zeros()]
        }
        fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
            [[Mat3::zeros()]]
        }
        /// A wall at x = 1.
        fn limit_step(&self, _: usize, x: &[Vec3; 1], p: &[Vec3; 1]) -> f64 {
            if p[0].x > 0.0 { (1.0 - x[0].x) / p[0].x } else { 1.0 }
        }
    }
    let mut term = StencilTerm::new("walls", Walls, (0..2000).map(|i| [i]).collect()).unwrap();
    let x = vec![Vec3::zeros(); 2000];
    let mut p = vec![Vec3::x() * 0.5; 2000];
    let full = term.limit_step(&x, &p).unwrap();
    assert_eq!((full.fraction, full.element), (1.0, None));
    p[1234].x = 4.0;
    let limited = term.limit_step(&x, &p).unwrap();
    assert_eq!((limited.fraction, limited.element), (0.25, Some(1234)));
    p[700].x = f64::INFINITY;
    assert_eq!(term.limit_step(&x, &p).unwrap().element, Some(700));
    let beyond = vec![Vec3::x() * 2.0; 2000];
    let error = term.limit_step(&beyond, &p).unwrap_err();
    assert!(matches!(error, PotentialError::StepLimit { element: Some(_), .. }), "{error}");
    let mut none = StencilTerm::new("none", Walls, Vec::new()).unwrap();
    assert_eq!(none.limit_step(&x, &p).unwrap().fraction, 1.0);
    assert_eq!(none.value(&x), 0.0);
}

/// c and a of each scheme from its definition: a fall under constant acceleration g. The end position of
/// ½c(x − x̃)² − g x is x̃ + g/c, and the end velocity a(x − x̂); both must be those of the recurrence.
#[test]
fn schemes_reproduce_their_recurrences() {
    let (h, g, x0, v0) = (0.01, -9.81, 2.0, 3.0);
    let end = |c: Coefficients, target: f64, origin: f64| {
        let x = target + g / c.inertia;
        (x, c.velocity * (x - origin))
    };
    let near = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).abs() < 1e-14 && (a.1 - b.1).abs() < 1e-12;
    let euler = end(Coefficients::backward_euler(h), x0 + h * v0, x0);
    assert!(near(euler, (x0 + h * (v0 + h * g), v0 + h * g)));
    // Average acceleration and BDF2 are of second order: exact for a parabola.
    let exact = |t: f64| (x0 + v0 * t + 0.5 * g * t * t, v0 + g * t);
    let newmark =
        end(Coefficients::average_acceleration(h), x0 + h * v0 + 0.25 * h * h * g, x0 + 0.5 * h * v0);
    assert!(near(newmark, exact(h)), "{newmark:?}");
    let ((x1, v1), two) = (exact(h), Coefficients::bdf2(h));
    let mean = |now: f64, before: f64| (4.0 * now - before) / 3.0;
    let bdf2 = end(two, mean(x1, x0) + 2.0 / 3.0 * h * mean(v1, v0), mean(x1, x0));
    assert!(near(bdf2, exact(2.0 * h)), "{bdf2:?} {:?}", exact(2.0 * h));
}

#[test]
fn a_random_mesh_has_positive_volumes() {
    let x = grid_points(3);
    for e in grid_tetrahedra(3) {
        let [a, b, c, d] = e.map(|i| x[i as usize]);
        assert!((b - a).dot(&(c - a).cross(&(d - a))) > 0.0);
    }
    let mut random = Random(1);
    assert!((0..1000).all(|_| (-1.0..1.0).contains(&random.number())));
}

/// A term is `Sync`: many threads may ask for its gradient at once, the first time too, when it is found out how its elements lie. A
/// thread that waits for its helpers there must not be given the same question to answer while it holds the answer's lock.
#[test]
fn many_threads_ask_for_the_first_gradient_at_once() {
    struct Weights;
    impl Stencil<1> for Weights {
        fn value(&self, e: usize, x: &[Vec3; 1]) -> f64 {
            e as f64 * x[0].x
        }
        fn gradient(&self, e: usize, _: &[Vec3; 1]) -> [Vec3; 1] {
            [Vec3::x() * e as f64]
        }
        fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
            [[Mat3::zeros()]]
        }
    }
    let (done, finished) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let n = 100_000;
        let x = vec![Vec3::zeros(); n as usize];
        with_threads(6, || {
            for _ in 0..8 {
                let term = StencilTerm::new("weights", Weights, (0..n).map(|i| [i]).collect()).unwrap();
                let mut sums = vec![vec![Vec3::zeros(); x.len()]; 16];
                parallel::for_each_chunk(&mut sums, 1, |_, sums| term.add_gradient(&x, &mut sums[0]));
                let right = |sum: &Vec<Vec3>| sum.iter().enumerate().all(|(e, g)| g.x == e as f64);
                assert!(sums.iter().all(right));
            }
        });
        done.send(()).unwrap();
    });
    let limit = std::time::Duration::from_secs(60);
    assert!(finished.recv_timeout(limit).is_ok(), "threads wait for each other, or a sum is wrong");
}
