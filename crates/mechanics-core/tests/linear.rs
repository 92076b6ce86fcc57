//! The linear solvers against dense factorisations and manufactured solutions.

#[path = "linear/generators.rs"]
mod generators;

use generators::{ElasticBox, Random, Triplets, dense, product, random_matrix, relative_error};
use mechanics_core::linear::{
    Accuracy, Algorithm, LinearError, LinearSolver, Method, Operand, Ordering, Preconditioner, Reason, Reuse,
    Solver, predict_factor,
};
use mechanics_core::parallel;
use mechanics_core::sparse::BlockMatrix;
use mechanics_core::tensor::Mat3;

fn conjugate_gradient(preconditioner: Preconditioner, tolerance: f64) -> Method {
    Method::ConjugateGradient { preconditioner, tolerance, max_iterations: 10_000 }
}

fn methods() -> [Method; 7] {
    methods_to(1e-13)
}

/// Every method, the iterative ones with this tolerance.
fn methods_to(tolerance: f64) -> [Method; 7] {
    [
        Method::Automatic,
        Method::Cholesky { ordering: Ordering::FewestFlops },
        Method::Cholesky { ordering: Ordering::NestedDissection },
        Method::Cholesky { ordering: Ordering::MinimumDegree },
        Method::Cholesky { ordering: Ordering::Natural },
        conjugate_gradient(Preconditioner::BlockJacobi, tolerance),
        conjugate_gradient(Preconditioner::IncompleteCholesky, tolerance),
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
            assert!(error < 1e-6, "{shape:?} {method:?}: {error:e}, {report:?}");
        }
    }
}

fn solve(method: Method, matrix: &BlockMatrix, b: &[f64]) -> Result<Vec<f64>, LinearError> {
    let mut solver = Solver::new(method);
    solver.factor(matrix)?;
    let mut x = vec![f64::NAN; b.len()];
    solver.solve_into(b, &mut x, Accuracy::Configured)?;
    Ok(x)
}

#[test]
fn the_empty_system_and_the_zero_right_hand_side_are_solved() {
    let empty = Triplets::new(0).matrix();
    let mut random = Random(3);
    let matrix = random_matrix(5, 2, &mut random).matrix();
    for method in methods() {
        assert_eq!(solve(method, &empty, &[]).unwrap(), Vec::<f64>::new());
        assert_eq!(solve(method, &matrix, &[0.0; 15]).unwrap(), vec![0.0; 15]);
    }
}

#[test]
fn hard_graphs_are_ordered_and_solved() {
    let mut random = Random(4);
    let size = 3000;
    let mut graphs = vec![("isolated", Triplets::new(size)), ("single", Triplets::new(1))];
    let mut star = Triplets::new(size);
    let mut two_stars = Triplets::new(size);
    let mut path = Triplets::new(size);
    for k in 1..size {
        star.add(k, 0, Mat3::from_fn(|_, _| random.signed()));
        two_stars.add(k, usize::from(k % 2 == 0 && k > 2), Mat3::from_fn(|_, _| random.signed()));
        path.add(k, k - 1, Mat3::from_fn(|_, _| random.signed()));
    }
    let mut clique = Triplets::new(130);
    for row in 0..130 {
        for column in 0..row {
            clique.add(row, column, Mat3::from_fn(|_, _| random.signed()));
        }
    }
    let mut hubs = random_matrix(600, 1, &mut random);
    for hub in [5, 300] {
        for k in (0..600).filter(|&k| k != hub) {
            hubs.add(k, hub, Mat3::from_fn(|_, _| random.signed()));
        }
    }
    graphs.extend([
        ("star", star),
        ("two stars", two_stars),
        ("path", path),
        ("clique", clique),
        ("hubs", hubs),
    ]);
    let separate = [ElasticBox::cube(4), ElasticBox::cube(6), ElasticBox::mat(9)];
    graphs.push(("islands", beside_each_other(&separate.map(|shape| shape.triplets()))));
    for (name, mut triplets) in graphs {
        dominate(&mut triplets);
        let matrix = triplets.matrix();
        let exact = random.vector(matrix.dimension());
        let b = product(&matrix, &exact);
        for method in methods() {
            if name.contains("star") && method == (Method::Cholesky { ordering: Ordering::Natural }) {
                continue; // The hub first: a full matrix.
            }
            let x = solve(method, &matrix, &b).unwrap_or_else(|error| panic!("{name} {method:?}: {error}"));
            assert!(relative_error(&x, &exact) < 1e-9, "{name} {method:?}: {:e}", relative_error(&x, &exact));
        }
    }
}

/// Matrices as diagonal parts of one, their nodes interleaved.
fn beside_each_other(parts: &[Triplets]) -> Triplets {
    let columns = parts.iter().map(|part| part.columns).sum();
    let mut whole = Triplets::new(columns);
    let mut first = 0;
    for part in parts {
        for &(row, column, block) in &part.blocks {
            whole.add(first + row, first + column, block);
        }
        first += part.columns;
    }
    let new = Random(11).permutation(columns);
    whole.renamed(&new)
}

/// Makes a matrix positive definite by adding the norms of each row's blocks to its diagonal.
fn dominate(triplets: &mut Triplets) {
    let mut sums = vec![1.0; triplets.columns];
    for &(row, column, block) in &triplets.blocks {
        sums[row] += block.norm();
        sums[column] += block.norm();
    }
    for (k, sum) in sums.into_iter().enumerate() {
        triplets.add(k, k, Mat3::identity() * sum);
    }
}

#[test]
fn the_solution_does_not_depend_on_the_numbering_or_the_scale() {
    let mut random = Random(5);
    let shape = ElasticBox { nodes: [6, 5, 7], stiffness: 400.0 };
    let mut triplets = shape.triplets();
    shape.add_contacts(&mut triplets, 10, 4e6, &mut random);
    let new = random.permutation(triplets.columns);
    let exact = random.vector(3 * triplets.columns);
    let mut renamed_exact = exact.clone();
    for (k, &place) in new.iter().enumerate() {
        renamed_exact[3 * place..3 * place + 3].copy_from_slice(&exact[3 * k..3 * k + 3]);
    }
    let renamed = triplets.renamed(&new).matrix();
    for scale in [1e-100, 1.0, 1e100] {
        let mut matrix = renamed.clone();
        matrix.blocks_mut().iter_mut().for_each(|block| *block *= scale);
        let b = product(&matrix, &renamed_exact);
        for method in methods() {
            let x = solve(method, &matrix, &b).unwrap();
            let error = relative_error(&x, &renamed_exact);
            assert!(error < 1e-7, "scale {scale:e}, {method:?}: {error:e}");
        }
    }
}

#[test]
fn an_indefinite_matrix_names_the_block() {
    let mut random = Random(6);
    let shape = ElasticBox { nodes: [7, 6, 5], stiffness: 400.0 };
    for culprit in [0, 57, 209] {
        let mut triplets = shape.triplets();
        // Negative beyond everything its neighbours can give it: whatever the order, this pivot is the lost one.
        triplets.add(culprit, culprit, Mat3::identity() * -1e7);
        let new = random.permutation(triplets.columns);
        let matrix = triplets.renamed(&new).matrix();
        for ordering in
            [Ordering::FewestFlops, Ordering::NestedDissection, Ordering::MinimumDegree, Ordering::Natural]
        {
            let error = Solver::new(Method::Cholesky { ordering }).factor(&matrix).unwrap_err();
            assert_eq!(error, LinearError::NotPositiveDefinite { block: new[culprit] }, "{ordering:?}");
        }
        for preconditioner in [Preconditioner::BlockJacobi, Preconditioner::IncompleteCholesky] {
            let error = Solver::new(conjugate_gradient(preconditioner, 1e-8)).factor(&matrix).unwrap_err();
            assert_eq!(error, LinearError::NotPositiveDefinite { block: new[culprit] });
        }
    }
}

#[test]
fn conjugate_gradients_report_negative_curvature() {
    // Diagonal blocks positive definite, the matrix not: eigenvalues 1 ± 2.
    let mut triplets = Triplets::new(2);
    triplets.add(0, 0, Mat3::identity());
    triplets.add(1, 1, Mat3::identity());
    triplets.add(1, 0, Mat3::identity() * 2.0);
    let matrix = triplets.matrix();
    let method = conjugate_gradient(Preconditioner::BlockJacobi, 1e-8);
    let error = solve(method, &matrix, &[1.0, 0.0, 0.0, -2.0, 0.0, 0.0]).unwrap_err();
    // p = b, pᵀA p / pᵀp = (1 + 4 − 8) / 5.
    match error {
        LinearError::NegativeCurvature { iteration: 1, curvature, block: 1 } => {
            assert!((curvature + 0.6).abs() < 1e-14);
        }
        other => panic!("{other}"),
    }
    let error = solve(conjugate_gradient(Preconditioner::IncompleteCholesky, 1e-8), &matrix, &[1.0; 6]);
    assert!(matches!(error, Err(LinearError::PreconditionerBreakdown { .. })), "{error:?}");
}

#[test]
fn entries_that_are_not_finite_name_their_block() {
    let mut random = Random(8);
    let good = random_matrix(20, 3, &mut random).matrix();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for method in methods() {
            let mut matrix = good.clone();
            let slot = matrix.pattern().column(13).start;
            matrix.blocks_mut()[slot][(2, 1)] = bad;
            let error = Solver::new(method).factor(&matrix).unwrap_err();
            assert_eq!(error, LinearError::NotFinite { operand: Operand::Matrix, block: 13 });
            let mut b = vec![1.0; 60];
            b[3 * 7 + 2] = bad;
            let error = solve(method, &good, &b).unwrap_err();
            assert_eq!(error, LinearError::NotFinite { operand: Operand::RightHandSide, block: 7 });
        }
    }
}

#[test]
fn a_singular_system_is_an_error_unless_the_right_hand_side_is_in_its_range() {
    // No mass: translations are free. The nodes' forces sum to zero or they do not.
    let shape = ElasticBox { nodes: [4, 4, 4], stiffness: 400.0 };
    let mut triplets = shape.triplets();
    let rigid: Vec<f64> = (0..64).flat_map(|_| [1.0, 0.0, 0.0]).collect();
    let mass = product(&triplets.matrix(), &rigid);
    for k in 0..64 {
        triplets.add(k, k, Mat3::identity() * -mass[3 * k]);
    }
    let matrix = triplets.matrix();
    for method in [
        Method::Cholesky { ordering: Ordering::FewestFlops },
        conjugate_gradient(Preconditioner::BlockJacobi, 1e-8),
        conjugate_gradient(Preconditioner::IncompleteCholesky, 1e-8),
    ] {
        assert!(solve(method, &matrix, &rigid).is_err(), "{method:?}");
    }
    let b = product(&matrix, &Random(9).vector(192));
    let x = solve(conjugate_gradient(Preconditioner::BlockJacobi, 1e-8), &matrix, &b).unwrap();
    let residual = product(&matrix, &x).iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    assert!(residual < 1e-7 * b.iter().map(|b| b * b).sum::<f64>().sqrt());
}

#[test]
fn badly_conditioned_systems_reach_a_small_residual() {
    // Condition numbers up to 1e14: the error grows with the condition, the residual must not.
    let mut random = Random(10);
    for exponent in [2, 6, 10, 14] {
        let small = 10f64.powi(-exponent);
        let mut triplets = ElasticBox { nodes: [5, 5, 5], stiffness: 1.0 }.triplets();
        for k in 0..triplets.columns {
            triplets.add(k, k, Mat3::identity() * if k % 2 == 0 { 0.0 } else { 1.0 / small });
        }
        let matrix = triplets.matrix();
        let exact = random.vector(375);
        let b = product(&matrix, &exact);
        let mut solver = Solver::new(Method::default());
        solver.factor(&matrix).unwrap();
        let mut x = vec![0.0; 375];
        let report = solver.solve_into(&b, &mut x, Accuracy::Configured).unwrap();
        assert!(report.residual < 1e-15, "{report:?}");
        assert!(relative_error(&x, &exact) < 1e-15 * 10f64.powi(exponent) + 1e-14);
    }
}

/// Two points on a spring 1e11 times as stiff as what holds them: the residual is the rounding of A x, far above ε ‖b‖, and the solution
/// has the digits that the entries of A leave it. With 1e15 they leave none, and that is an error.
#[test]
fn a_residual_that_rounding_explains_is_accepted() {
    let solve_chain = |stiffness: f64| {
        let mut triplets = Triplets::new(30);
        for k in 0..30 {
            triplets.add(k, k, Mat3::identity());
        }
        for k in 0..29 {
            let block = Mat3::identity() * (stiffness * (1.0 + 0.1 * k as f64));
            triplets.add(k, k, block);
            triplets.add(k + 1, k + 1, block);
            triplets.add(k + 1, k, -block);
        }
        // The whole chain moves by one, and each point by a little more.
        solve(Method::Cholesky { ordering: Ordering::FewestFlops }, &triplets.matrix(), &Random(3).vector(90))
    };
    let mean = Random(3).vector(90).chunks(3).map(|b| b[0]).sum::<f64>() / 30.0;
    let x = solve_chain(1e11).unwrap();
    assert!(x.chunks(3).all(|x| (x[0] / mean - 1.0).abs() < 1e-3), "{mean} {x:?}");
    assert!(matches!(
        solve_chain(1e15),
        Err(LinearError::Stagnation { .. } | LinearError::NotPositiveDefinite { .. })
    ));
}

#[test]
fn failures_leave_the_solution_alone_and_the_limit_is_an_error() {
    let shape = ElasticBox::cube(8);
    let matrix = shape.triplets().matrix();
    let b = Random(12).vector(matrix.dimension());
    let method = Method::ConjugateGradient {
        preconditioner: Preconditioner::BlockJacobi,
        tolerance: 1e-12,
        max_iterations: 5,
    };
    let mut solver = Solver::new(method);
    let mut x = vec![7.0; b.len()];
    assert_eq!(solver.solve_into(&b, &mut x, Accuracy::Configured), Err(LinearError::NotFactored));
    solver.factor(&matrix).unwrap();
    match solver.solve_into(&b, &mut x, Accuracy::Configured) {
        Err(LinearError::IterationLimit { iterations: 5, residual, tolerance: 1e-12, block }) => {
            assert!(residual > 1e-12 && block < 512);
        }
        other => panic!("{other:?}"),
    }
    for tolerance in [-1.0, 1.0, f64::NAN] {
        let error = solver.solve_into(&b, &mut x, Accuracy::Relative(tolerance)).unwrap_err();
        assert!(matches!(error, LinearError::Tolerance { .. }));
    }
    assert!(x.iter().all(|&entry| entry == 7.0));
    let loose = solver.solve_into(&b, &mut x, Accuracy::Relative(0.5)).unwrap();
    assert!(loose.residual <= 0.5 && loose.iterations <= 5);
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let mut random = Random(13);
    let shape = ElasticBox { nodes: [13, 12, 11], stiffness: 400.0 };
    let mut triplets = shape.triplets();
    shape.add_contacts(&mut triplets, 20, 4e6, &mut random);
    let matrix = triplets.matrix();
    let b = random.vector(matrix.dimension());
    for method in methods_to(1e-8) {
        let reference = parallel::with_threads(1, || solve(method, &matrix, &b).unwrap());
        for threads in [2, 3, 8] {
            let x = parallel::with_threads(threads, || solve(method, &matrix, &b).unwrap());
            assert!(
                x.iter().zip(&reference).all(|(a, b)| a.to_bits() == b.to_bits()),
                "{method:?} {threads}"
            );
        }
    }
}

#[test]
fn a_perturbed_pattern_keeps_the_order_and_the_same_pattern_everything() {
    let mut random = Random(14);
    let shape = ElasticBox::mat(24);
    let bare = shape.triplets();
    let mut solver = Solver::new(Method::Cholesky { ordering: Ordering::NestedDissection });
    assert_eq!(solver.factor(&bare.matrix()).unwrap().reuse, Reuse::Nothing);
    assert_eq!(solver.factor(&bare.matrix()).unwrap().reuse, Reuse::Everything);
    for round in 0..10 {
        let mut triplets = bare.clone();
        shape.add_contacts(&mut triplets, 3 + round, 4e6, &mut random);
        let matrix = triplets.matrix();
        let report = solver.factor(&matrix).unwrap();
        assert_eq!(report.reuse, Reuse::Order, "{report:?}");
        let b = random.vector(matrix.dimension());
        let (mut x, mut fresh) = (vec![0.0; b.len()], vec![0.0; b.len()]);
        solver.solve_into(&b, &mut x, Accuracy::Configured).unwrap();
        let mut other = Solver::new(Method::Cholesky { ordering: Ordering::MinimumDegree });
        other.factor(&matrix).unwrap();
        other.solve_into(&b, &mut fresh, Accuracy::Configured).unwrap();
        assert!(relative_error(&x, &fresh) < 1e-8);
    }
    // Links across the whole mat: the old order is no longer worth keeping.
    let mut triplets = bare.clone();
    for _ in 0..1500 {
        let (a, b) = (random.below(shape.count()), random.below(shape.count()));
        if a != b {
            triplets.add(a, b, Mat3::identity() * -0.1);
            triplets.add(a, a, Mat3::identity() * 0.1);
            triplets.add(b, b, Mat3::identity() * 0.1);
        }
    }
    assert_eq!(solver.factor(&triplets.matrix()).unwrap().reuse, Reuse::OrderGivenUp);
}

#[test]
fn a_factorisation_taken_out_goes_on_solving() {
    let mut random = Random(15);
    let (first, second) =
        (random_matrix(30, 2, &mut random).matrix(), random_matrix(30, 2, &mut random).matrix());
    for method in methods() {
        let mut solver = Solver::new(method);
        solver.factor(&first).unwrap();
        let taken = solver.take_factorization().unwrap();
        assert!(solver.factorization().is_none());
        solver.factor(&second).unwrap();
        for matrix in [&first, &second] {
            let exact = random.vector(90);
            let b = product(matrix, &exact);
            let mut x = vec![0.0; 90];
            if std::ptr::eq(matrix, &first) {
                taken.solve_into(&b, &mut x, Accuracy::Configured).unwrap();
            } else {
                solver.solve_into(&b, &mut x, Accuracy::Configured).unwrap();
            }
            assert!(relative_error(&x, &exact) < 1e-10);
        }
    }
}

#[test]
fn the_automatic_choice_says_why() {
    let direct = |shape: ElasticBox| {
        let mut solver = Solver::new(Method::Automatic);
        solver.factor(&shape.triplets().matrix()).unwrap()
    };
    let small = direct(ElasticBox::cube(6));
    assert_eq!((small.algorithm, small.reason), (Algorithm::Cholesky, Reason::Small { unknowns: 648 }));
    let thin = direct(ElasticBox::mat(60));
    assert!(
        matches!(thin.reason, Reason::CheapFactor { flops, iterative } if flops <= iterative),
        "{thin:?}"
    );
    assert_eq!(thin.algorithm, Algorithm::Cholesky);
    let solid = direct(ElasticBox::cube(20));
    assert!(
        matches!(solid.reason, Reason::DearFactor { flops, iterative } if flops > iterative),
        "{solid:?}"
    );
    assert_eq!(solid.algorithm, Algorithm::ConjugateGradient(Preconditioner::IncompleteCholesky));
}

#[test]
fn nested_dissection_beats_minimum_degree_on_a_solid() {
    let cube = predict_factor(ElasticBox::cube(16).triplets().matrix().pattern(), Ordering::NestedDissection);
    let degree = predict_factor(ElasticBox::cube(16).triplets().matrix().pattern(), Ordering::MinimumDegree);
    assert!(cube.flops < 0.75 * degree.flops, "{:e} against {:e}", cube.flops, degree.flops);
}

#[test]
fn automatic_factors_where_iterating_fails() {
    // A solid, so that iterating is tried; almost without mass, so that rounding keeps the residual above 1e-8.
    let shape = ElasticBox { nodes: [20, 20, 20], stiffness: 1e9 };
    let matrix = shape.triplets().matrix();
    let b = vec![1.0; matrix.dimension()];
    let mut x = vec![0.0; b.len()];
    let mut solver = Solver::new(Method::Automatic);
    let first = solver.factor(&matrix).unwrap();
    assert_eq!(first.algorithm, Algorithm::ConjugateGradient(Preconditioner::IncompleteCholesky));
    let report = solver.solve_into(&b, &mut x, Accuracy::Configured).unwrap();
    assert_eq!(report.algorithm, Algorithm::Cholesky, "{report:?}");
    assert!(report.residual < 1e-6, "{report:?}");
    let second = solver.factor(&matrix).unwrap();
    assert_eq!((second.algorithm, second.reason), (Algorithm::Cholesky, Reason::IterationFailed));
}

/// What came before must not show: contacts come and go, with and without a base, and a new solver at the start of
/// any step continues in the same bits.
#[test]
fn a_step_depends_on_its_own_matrices_alone() {
    let shape = ElasticBox::mat(14);
    let bare = shape.triplets().matrix();
    let steps: Vec<Vec<BlockMatrix>> = (0..6)
        .map(|step| {
            let mut random = Random(100 + step);
            let contacts = [0, 40, 3, 0, 90, 20][step as usize];
            (0..3)
                .map(|iteration| {
                    let mut triplets = shape.triplets();
                    shape.add_contacts(&mut triplets, contacts + 10 * iteration, 4e3, &mut random);
                    triplets.matrix()
                })
                .collect()
        })
        .collect();
    let b = Random(16).vector(bare.dimension());
    let run = |solver: &mut Solver, matrices: &[BlockMatrix]| -> Vec<u64> {
        solver.begin_step();
        let solve = |matrix| {
            let mut x = vec![0.0; b.len()];
            solver.factor(matrix).unwrap();
            solver.solve_into(&b, &mut x, Accuracy::Relative(1e-3)).unwrap();
            x
        };
        matrices.iter().flat_map(solve).map(f64::to_bits).collect()
    };
    for method in methods() {
        for based in [false, true] {
            let new_solver = || {
                let mut solver = Solver::new(method);
                if based {
                    solver.start_from(bare.pattern());
                }
                solver
            };
            let mut one = new_solver();
            for (number, matrices) in steps.iter().enumerate() {
                let continued = run(&mut one, matrices);
                assert!(continued == run(&mut new_solver(), matrices), "{method:?} {based} step {number}");
            }
        }
    }
}

/// A base saves the ordering at the start of every step; without one it is saved while patterns start the same.
#[test]
fn a_base_is_returned_to() {
    let shape = ElasticBox::mat(24);
    let bare = shape.triplets().matrix();
    let mut touching = shape.triplets();
    shape.add_contacts(&mut touching, 8, 4e6, &mut Random(17));
    let touching = touching.matrix();
    let mut solver = Solver::new(Method::Cholesky { ordering: Ordering::NestedDissection });
    let reuse = |solver: &mut Solver, matrix: &BlockMatrix| {
        solver.begin_step();
        solver.factor(matrix).unwrap().reuse
    };
    assert_eq!(reuse(&mut solver, &touching), Reuse::Nothing);
    assert_eq!(reuse(&mut solver, &touching), Reuse::Everything);
    assert_eq!(reuse(&mut solver, &bare), Reuse::Nothing);
    solver.start_from(bare.pattern());
    for _ in 0..3 {
        assert_eq!(reuse(&mut solver, &touching), Reuse::Order);
        assert_eq!(reuse(&mut solver, &bare), Reuse::Everything);
    }
}
