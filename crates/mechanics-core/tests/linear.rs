//! The linear solvers against dense factorisations and manufactured solutions.

#[path = "linear/generators.rs"]
mod generators;

use generators::{ElasticBox, Random, dense, product, random_matrix, relative_error};
use mechanics_core::linear::{Accuracy, LinearSolver, Method, Ordering, Preconditioner, Solver};

fn conjugate_gradient(preconditioner: Preconditioner, tolerance: f64) -> Method {
    Method::ConjugateGradient { preconditioner, tolerance, max_iterations: 10_000 }
}

fn methods() -> [Method; 7] {
    [
        Method::Automatic,
        Method::Cholesky { ordering: Ordering::FewestFlops },
        Method::Cholesky { ordering: Ordering::NestedDissection },
        Method::Cholesky { ordering: Ordering::MinimumDegree },
        Method::Cholesky { ordering: Ordering::Natural },
        conjugate_gradient(Preconditioner::BlockJacobi, 1e-13),
        conjugate_gradient(Preconditioner::IncompleteCholesky, 1e-13),
    ]
}

#[test]
fn every_method_agrees_with_dense_cholesky() {
    let mut random = Random(1);
    for round in 0..30 {
        let columns = 1 + random.below(60);
        let matrix = random_matrix(columns, round % 4, &mut random).matrix();
        let b = random.vector(3 * columns);
        let reference = dense(&matrix).cholesky().unwrap().solve(&nalgebra::DVector::from_column_slice(&b));
        for method in methods() {
            let mut solver = Solver::new(method);
            solver.factor(&matrix).unwrap();
            let mut x = vec![0.0; b.len()];
            let report = solver.solve_into(&b, &mut x, Accuracy::Configured).unwrap();
            assert!(report.residual <= 1e-13, "{method:?} {report:?}");
            let error = relative_error(&x, reference.as_slice());
            assert!(error < 1e-10, "round {round}, {columns} columns, {method:?}: {error:e}");
        }
    }
}

#[test]
fn elasticity_with_contacts_recovers_a_manufactured_solution() {
    let mut random = Random(2);
    for shape in [ElasticBox::cube(9), ElasticBox::mat(16)] {
        let mut triplets = shape.triplets();
        shape.add_contacts(&mut triplets, 30, 4e6, &mut random);
        let matrix = triplets.matrix();
        let exact = random.vector(matrix.dimension());
        let b = product(&matrix, &exact);
        for method in methods() {
            let mut solver = Solver::new(method);
            solver.factor(&matrix).unwrap();
            let mut x = vec![0.0; b.len()];
            let report = solver.solve_into(&b, &mut x, Accuracy::Configured).unwrap();
            let error = relative_error(&x, &exact);
            println!("{shape:?} {method:?} {report:?} {error:e}");
            assert!(error < 1e-6, "{shape:?} {method:?}: {error:e}, {report:?}");
        }
    }
}
