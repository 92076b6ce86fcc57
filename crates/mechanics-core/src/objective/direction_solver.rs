//! The linear systems behind Newton directions, whatever solves them.

use super::DirectionAccuracy;
use crate::sparse::BlockMatrix;
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
