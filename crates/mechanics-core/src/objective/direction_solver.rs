//! The linear systems behind Newton directions, whatever solves them.

use super::DirectionAccuracy;
use crate::sparse::BlockMatrix;
use crate::tensor::Vec3;
use nalgebra::{Cholesky, DMatrix, DVectorView, DVectorViewMut, Dyn};
use std::error::Error;

/// Solves `H p = b` for symmetric positive definite block matrices.
///
/// [`DenseCholesky`] does so for a handful of points. With the feature `solvers`, `linear::Solver` does so for any
/// number.
pub trait DirectionSolver {
    /// Forgets what earlier matrices taught, so that results depend on the matrices to come alone. Called at the
    /// start of every time step.
    fn begin_step(&mut self) {}

    /// Prepares to solve with `matrix`.
    ///
    /// # Errors
    /// [`SolverError::Indefinite`] if the matrix turns out not to be positive definite.
    fn prepare(&mut self, matrix: &BlockMatrix) -> Result<(), SolverError>;

    /// Overwrites `x` with the solution for the matrix last prepared, and answers the number of iterations.
    ///
    /// # Errors
    /// [`SolverError::Indefinite`] if the matrix turns out not to be positive definite, or the solver's own.
    fn solve_into(
        &mut self,
        b: &[f64],
        accuracy: DirectionAccuracy,
        x: &mut [f64],
    ) -> Result<u64, SolverError>;
}

/// Why a linear system was not solved.
#[derive(Debug, thiserror::Error)]
pub enum SolverError {
    /// The matrix is not positive definite.
    #[error(transparent)]
    Indefinite(#[from] Indefinite),
    /// The matrix has an entry that is infinite or NaN.
    #[error("the matrix has an entry that is not finite in block column {block}")]
    NonFinite {
        /// The block column.
        block: usize,
    },
    /// What the solver calls a solution leaves as much as it should have taken away.
    #[error("the solution found is none: its residual is {residual:e} of the right-hand side")]
    Unsolved {
        /// ‖b − H p‖ / ‖b‖.
        residual: f64,
    },
    /// The last matrix could not be prepared, or there was none.
    #[error("there is no prepared matrix to solve with")]
    NotPrepared,
    /// The solver's own reason.
    #[error(transparent)]
    Other(Box<dyn Error + Send + Sync>),
}

/// A matrix is not positive definite to working precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is not positive definite: it breaks down at block column {block}")]
pub struct Indefinite {
    /// The block column where it shows.
    pub block: usize,
}

/// A residual of so much of ‖|H| |p|‖ is rounding: 1e6 times that of one product.
const ROUNDED: f64 = 1e-10;

/// Refuses a p that is no solution of H p = b at all: ‖b − H p‖ is not below ‖b‖, and is more than rounding makes of it. Newton's method reads off p how far the minimum is, so that
/// a p of nothing would end it anywhere. One product of the matrix, a small part of any factorisation. What is not finite is left to Newton's method, which names it.
pub(super) fn check_solved(matrix: &BlockMatrix, b: &[f64], p: &[f64]) -> Result<(), SolverError> {
    let blocks = |v: &[f64]| v.chunks_exact(3).map(Vec3::from_column_slice).collect::<Vec<Vec3>>();
    let size = |v: &[Vec3]| v.iter().map(Vec3::norm_squared).sum::<f64>().sqrt();
    let (right, solution) = (blocks(b), blocks(p));
    let mut rest = vec![Vec3::zeros(); right.len()];
    matrix.multiply_into(&solution, &mut rest);
    rest.iter_mut().zip(&right).for_each(|(rest, right)| *rest = right - *rest);
    let (rest, right) = (size(&rest), size(&right));
    if rest < right || rest.is_nan() || right == 0.0 {
        return Ok(());
    }
    let mut magnitudes = matrix.clone();
    magnitudes.blocks_mut().iter_mut().for_each(|block| *block = block.abs());
    let solution: Vec<Vec3> = solution.iter().map(|v| v.abs()).collect();
    let mut sum = vec![Vec3::zeros(); solution.len()];
    magnitudes.multiply_into(&solution, &mut sum);
    if rest <= ROUNDED * size(&sum) { Ok(()) } else { Err(SolverError::Unsolved { residual: rest / right }) }
}

/// Dense Cholesky: for a handful of points, and for tests.
#[derive(Clone, Debug, Default)]
pub struct DenseCholesky {
    factor: Option<Cholesky<f64, Dyn>>,
}

impl DenseCholesky {
    /// A solver that has nothing prepared yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The last factorisation.
    pub fn factorisation(&self) -> Option<&Cholesky<f64, Dyn>> {
        self.factor.as_ref()
    }
}

impl DirectionSolver for DenseCholesky {
    fn prepare(&mut self, matrix: &BlockMatrix) -> Result<(), SolverError> {
        self.factor = None;
        let mut dense = DMatrix::zeros(matrix.dimension(), matrix.dimension());
        let pattern = matrix.pattern();
        for column in 0..pattern.columns() {
            for slot in pattern.column(column) {
                let (row, block) = (pattern.rows()[slot] as usize, &matrix.blocks()[slot]);
                if !block.iter().all(|entry| entry.is_finite()) {
                    return Err(SolverError::NonFinite { block: column });
                }
                dense.fixed_view_mut::<3, 3>(3 * row, 3 * column).copy_from(block);
            }
        }
        self.factor = Some(factor(dense).map_err(|scalar| Indefinite { block: scalar / 3 })?);
        Ok(())
    }

    fn solve_into(&mut self, b: &[f64], _: DirectionAccuracy, x: &mut [f64]) -> Result<u64, SolverError> {
        assert_eq!(b.len(), x.len(), "as many unknowns as equations");
        let factor = self.factor.as_ref().ok_or(SolverError::NotPrepared)?;
        let mut x = DVectorViewMut::from_slice(x, b.len());
        x.copy_from(&DVectorView::from_slice(b, b.len()));
        factor.solve_mut(&mut x);
        Ok(0)
    }
}

/// The Cholesky factor, from the lower triangle; or the column whose pivot is lost.
pub(super) fn factor(mut a: DMatrix<f64>) -> Result<Cholesky<f64, Dyn>, usize> {
    let n = a.nrows();
    let diagonal = a.diagonal();
    for j in 0..n {
        for k in 0..j {
            let factor = a[(j, k)];
            for i in j..n {
                a[(i, j)] -= factor * a[(i, k)];
            }
        }
        // A pivot below the rounding of its own sum says nothing about its sign.
        let pivot = a[(j, j)];
        if pivot.is_nan() || pivot <= n as f64 * f64::EPSILON * diagonal[j].abs() {
            return Err(j);
        }
        let root = pivot.sqrt();
        a.view_mut((j, j), (n - j, 1)).scale_mut(1.0 / root);
    }
    a.fill_upper_triangle(0.0, 1);
    Ok(Cholesky::pack_dirty(a))
}
