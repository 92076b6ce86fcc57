//! Linear solvers that lie, at every solve in turn: a minimisation ends at the minimum or says that it cannot, never anywhere else.

use crate::samples::Springs;
use mechanics_core::newton::{NewtonOptions, minimise};
use mechanics_core::objective::{
    DenseCholesky, DirectionAccuracy, DirectionSolver, IncrementalPotential, Indefinite, Projecting,
    SolverError, TimeStep,
};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::sparse::{Assembly, BlockMatrix};
use mechanics_core::stage::Scheme;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::Vec3;

/// What is said instead of the solution.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lie {
    /// The solution times this number: nothing, the opposite, almost nothing, NaN.
    Times(f64),
    /// In every entry.
    Constant(f64),
    /// The solution in another order.
    Turned,
    /// The matrix is not positive definite.
    Indefinite,
    /// There is no matrix.
    NotPrepared,
}

const LIES: [Lie; 12] = [
    Lie::Times(0.0),
    Lie::Times(-1.0),
    Lie::Times(1e-30),
    Lie::Times(-1e-30),
    Lie::Times(1e30),
    Lie::Times(f64::NAN),
    Lie::Times(f64::INFINITY),
    Lie::Constant(1.0),
    Lie::Constant(1e300),
    Lie::Turned,
    Lie::Indefinite,
    Lie::NotPrepared,
];

/// Tells the truth in its first solves.
struct LyingSolver {
    truth: DenseCholesky,
    lie: Lie,
    after: u64,
    last: u64,
    solves: u64,
}

impl LyingSolver {
    fn lies(&self) -> bool {
        (self.after + 1..=self.last).contains(&self.solves)
    }
}

impl DirectionSolver for LyingSolver {
    fn prepare(&mut self, matrix: &BlockMatrix) -> Result<(), SolverError> {
        self.solves += 1;
        match self.lie {
            Lie::Indefinite if self.lies() => Err(Indefinite { block: 1 }.into()),
            _ => self.truth.prepare(matrix),
        }
    }

    fn solve_into(
        &mut self,
        b: &[f64],
        accuracy: DirectionAccuracy,
        x: &mut [f64],
    ) -> Result<u64, SolverError> {
        let iterations = self.truth.solve_into(b, accuracy, x)?;
        if self.lies() {
            match self.lie {
                Lie::Times(factor) => x.iter_mut().for_each(|x| *x *= factor),
                Lie::Constant(number) => x.fill(number),
                Lie::Turned => x.rotate_left(5),
                Lie::NotPrepared => return Err(SolverError::NotPrepared),
                Lie::Indefinite => {}
            }
        }
        Ok(iterations)
    }
}

/// A hanging chain: the minimum with a lying solver, or the error.
fn hang(lie: Lie, (after, last): (u64, u64), projecting: Projecting) -> (Vec<f64>, Result<(), String>, bool) {
    const POINTS: usize = 8;
    let x: Vec<Vec3> = (0..POINTS).map(|i| Vec3::new(i as f64, 0.1 * (i * i % 5) as f64, 0.0)).collect();
    let pairs: Vec<[u32; 2]> = (1..POINTS as u32).map(|i| [i - 1, i]).collect();
    let springs = Springs { stiffness: vec![50.0; POINTS - 1], rest_length: vec![0.8; POINTS - 1] };
    let mut springs = StencilTerm::new("springs", springs, pairs).unwrap();
    let map = PointMap::with_fixed(POINTS, &[(0, x[0]), (7, x[7])]).unwrap();
    let (mut weight, mut assembly) = (Weight(x.clone()), Assembly::new(&map));
    let mut solver = LyingSolver { truth: DenseCholesky::new(), lie, after, last, solves: 0 };
    let mut terms: [&mut dyn Potential; 2] = [&mut springs, &mut weight];
    let time_step = TimeStep { time: 0.0, step: 0.0, scheme: Scheme::statics(&x) };
    let mut objective = IncrementalPotential::new(&mut terms, &map, time_step, &mut assembly, &mut solver)
        .with_projecting(projecting);
    let mut q: Vec<f64> = x[1..7].iter().flatten().copied().collect();
    let start = q.clone();
    let options = NewtonOptions { tolerance: 1e-10, ..NewtonOptions::default() };
    let outcome = minimise(&mut objective, &mut q, &options).map(drop).map_err(|error| error.to_string());
    if outcome.is_err() {
        let bits = |q: &[f64]| q.iter().map(|q| q.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&q), bits(&start), "{lie:?}");
    }
    let told = solver.solves > after;
    (q, outcome, told)
}

/// Every point falls and is held a little where it was.
struct Weight(Vec<Vec3>);

impl Potential for Weight {
    fn name(&self) -> &'static str {
        "weight"
    }
    fn value(&self, x: &[Vec3]) -> f64 {
        x.iter().zip(&self.0).map(|(x, start)| 3.0 * x.z + 0.5 * (x - start).norm_squared()).sum()
    }
    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        for ((g, x), start) in gradient.iter_mut().zip(x).zip(&self.0) {
            *g += x - start + Vec3::z() * 3.0;
        }
    }
    fn add_hessian(
        &self,
        x: &[Vec3],
        _: mechanics_core::projection::Projection,
        hessian: &mut mechanics_core::sparse::Assembler<'_>,
    ) {
        let points: Vec<[u32; 1]> = (0..x.len() as u32).map(|i| [i]).collect();
        hessian.add(&points, |_| [[mechanics_core::tensor::Mat3::identity()]]);
    }
}

/// A solver that answers zero would end a minimisation where it begins, as converged: convergence is read off the direction, so that directions are checked to be solutions.
#[test]
fn minimisations_see_through_lying_solvers() {
    for projecting in [Projecting::Always, Projecting::OnDemand] {
        let (truth, outcome, _) = hang(Lie::Turned, (u64::MAX - 1, 0), projecting);
        outcome.unwrap();
        let (mut errors, mut survived) = (0, 0);
        for lie in LIES {
            for lasting in [1, u64::MAX / 2] {
                for after in 0.. {
                    let (q, outcome, told) = hang(lie, (after, after + lasting), projecting);
                    match outcome {
                        Err(error) => {
                            assert!(told, "{error}");
                            errors += 1;
                        }
                        Ok(()) => {
                            let far = q.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                            assert!(far < 1e-8, "{lie:?} after {after} solves is believed: {far:e} m off");
                            survived += u32::from(told);
                        }
                    }
                    if !told {
                        break;
                    }
                }
            }
        }
        println!("{projecting:?}: {errors} errors, {survived} survived");
        assert!(errors > 40, "{errors} errors, {survived} survived");
    }
}
