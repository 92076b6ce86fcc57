use super::analysis::Analysis;
use super::conjugate_gradient::{ConjugateGradient, Convergence, Limits, PreconditionerFactor};
use super::error::{LinearError, Operand};
use super::product::{RowIndex, dot, largest, to_blocks};
use super::report::{Algorithm, SolveReport};
use super::supernodal::{SupernodalFactor, SupernodalStructure};
use super::{Accuracy, Preconditioner};
use crate::sparse::BlockMatrix;
use crate::tensor::Vec3;
use std::sync::Arc;
use std::time::Instant;

/// Refinement steps of a direct solve at most.
const MAX_REFINEMENTS: usize = 10;

/// A direct solve whose residual stays above this has failed, unless rounding explains it.
const WORST_DIRECT_RESIDUAL: f64 = 1e-6;

/// A direct solve whose residual stays above this has failed, though rounding may explain it: too few digits are left.
const WORST_ROUNDED_RESIDUAL: f64 = 1e-3;

/// Rounding explains a residual of so many ε ‖|A| |x|‖₂.
const ROUNDINGS: f64 = 16.0;

/// A factored matrix: solves with any number of right-hand sides, from any number of threads.
#[derive(Debug)]
pub struct Factorization {
    pub(super) matrix: BlockMatrix,
    pub(super) rows: Arc<RowIndex>,
    pub(super) factor: Factor,
}

/// The numbers.
#[derive(Debug)]
pub(super) enum Factor {
    Complete { analysis: Arc<Analysis>, structure: Arc<SupernodalStructure>, numbers: SupernodalFactor },
    Preconditioner { preconditioner: PreconditionerFactor, limits: Limits },
}

impl Factorization {
    /// What it was factored with.
    pub fn algorithm(&self) -> Algorithm {
        match &self.factor {
            Factor::Complete { .. } => Algorithm::Cholesky,
            Factor::Preconditioner { preconditioner: PreconditionerFactor::BlockJacobi(_), .. } => {
                Algorithm::ConjugateGradient(Preconditioner::BlockJacobi)
            }
            Factor::Preconditioner { .. } => Algorithm::ConjugateGradient(Preconditioner::IncompleteCholesky),
        }
    }

    /// The matrix that was factored.
    pub fn matrix(&self) -> &BlockMatrix {
        &self.matrix
    }

    /// The block columns in the order in which a complete factorisation eliminated them.
    pub fn elimination_order(&self) -> Option<&[u32]> {
        match &self.factor {
            Factor::Complete { analysis, .. } => Some(&analysis.numbering.old),
            Factor::Preconditioner { .. } => None,
        }
    }

    /// `x = A⁻¹ b`; see [`LinearSolver::solve_into`](super::LinearSolver::solve_into).
    ///
    /// # Errors
    /// As [`LinearSolver::solve_into`](super::LinearSolver::solve_into), except that there is always something to
    /// solve with.
    ///
    /// # Panics
    /// If `b` or `x` does not have the matrix's dimension.
    pub fn solve_into(
        &self,
        b: &[f64],
        x: &mut [f64],
        accuracy: Accuracy,
    ) -> Result<SolveReport, LinearError> {
        let dimension = self.matrix.dimension();
        assert_eq!(b.len(), dimension, "the right-hand side has the matrix's dimension");
        assert_eq!(x.len(), dimension, "the solution has the matrix's dimension");
        let start = Instant::now();
        if let Accuracy::Relative(tolerance) = accuracy
            && !(0.0..1.0).contains(&tolerance)
        {
            return Err(LinearError::Tolerance { tolerance });
        }
        if let Some(entry) = b.iter().position(|entry| !entry.is_finite()) {
            return Err(LinearError::NotFinite { operand: Operand::RightHandSide, block: entry / 3 });
        }
        let scale = power_of_two_near(b.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs())));
        let scaled: Vec<Vec3> = to_blocks(b).into_iter().map(|block| block / scale).collect();
        let (solution, convergence) = match &self.factor {
            Factor::Complete { analysis, structure, numbers } => {
                self.solve_directly(&scaled, accuracy, |r| solve_once(analysis, structure, numbers, r))?
            }
            Factor::Preconditioner { preconditioner, limits } => {
                let mut limits = *limits;
                if let Accuracy::Relative(tolerance) = accuracy {
                    limits.tolerance = tolerance;
                }
                ConjugateGradient { matrix: &self.matrix, rows: &self.rows, preconditioner, limits }
                    .solve(&scaled)?
            }
        };
        for (x, block) in x.chunks_exact_mut(3).zip(&solution) {
            x.copy_from_slice((block * scale).as_slice());
        }
        Ok(SolveReport {
            algorithm: self.algorithm(),
            iterations: convergence.iterations,
            residual: convergence.residual,
            time: start.elapsed(),
        })
    }

    /// Iterative refinement: x ← x + (L Lᵀ)⁻¹ (b − A x) until the residual is small enough or no longer halves; the
    /// best x counts.
    ///
    /// No x that is near A⁻¹ b has a residual much below ε |A| |x|, the rounding of A x itself (Higham, *Accuracy and Stability of
    /// Numerical Algorithms*, 2nd ed., 2002, section 7.2). In a body with very stiff parts that move rigidly this is far above
    /// ε ‖b‖, and there is no better solution to be had.
    fn solve_directly(
        &self,
        b: &[Vec3],
        accuracy: Accuracy,
        solve: impl Fn(&[Vec3]) -> Result<Vec<Vec3>, LinearError>,
    ) -> Result<(Vec<Vec3>, Convergence), LinearError> {
        let (target, worst) = match accuracy {
            Accuracy::Configured => (0.0, WORST_DIRECT_RESIDUAL),
            Accuracy::Relative(tolerance) => (tolerance, tolerance.max(WORST_DIRECT_RESIDUAL)),
        };
        let norm = dot(b, b).sqrt();
        if norm == 0.0 {
            return Ok((b.to_vec(), Convergence { iterations: 0, residual: 0.0 }));
        }
        let mut x = solve(b)?;
        let mut r = vec![Vec3::zeros(); b.len()];
        let mut residual = self.residual_into(b, &x, &mut r) / norm;
        let mut iterations = 0;
        while residual > target && iterations < MAX_REFINEMENTS {
            let correction = solve(&r)?;
            let trial: Vec<Vec3> = x.iter().zip(&correction).map(|(x, c)| x + c).collect();
            let mut trial_r = vec![Vec3::zeros(); b.len()];
            let trial_residual = self.residual_into(b, &trial, &mut trial_r) / norm;
            iterations += 1;
            let halved = trial_residual < 0.5 * residual;
            if trial_residual < residual {
                (x, r, residual) = (trial, trial_r, trial_residual);
            }
            if !halved {
                break;
            }
        }
        if residual <= worst || residual * norm <= self.rounding(&x).min(WORST_ROUNDED_RESIDUAL * norm) {
            return Ok((x, Convergence { iterations, residual }));
        }
        let block = largest(&r).1;
        Err(LinearError::Stagnation { iteration: iterations, residual, tolerance: worst, block })
    }

    /// How large the rounding of A x may be.
    fn rounding(&self, x: &[Vec3]) -> f64 {
        let mut matrix = self.matrix.clone();
        matrix.blocks_mut().iter_mut().for_each(|block| *block = block.abs());
        let x: Vec<Vec3> = x.iter().map(|x| x.abs()).collect();
        let mut sum = vec![Vec3::zeros(); x.len()];
        self.rows.multiply_into(&matrix, &x, &mut sum);
        ROUNDINGS * f64::EPSILON * dot(&sum, &sum).sqrt()
    }

    fn residual_into(&self, b: &[Vec3], x: &[Vec3], r: &mut [Vec3]) -> f64 {
        self.rows.multiply_into(&self.matrix, x, r);
        for (r, b) in r.iter_mut().zip(b) {
            *r = b - *r;
        }
        dot(r, r).sqrt()
    }
}

/// One pair of triangular solves, through the new numbering and back.
fn solve_once(
    analysis: &Analysis,
    structure: &SupernodalStructure,
    numbers: &SupernodalFactor,
    r: &[Vec3],
) -> Result<Vec<Vec3>, LinearError> {
    let numbering = &analysis.numbering;
    let mut work: Vec<f64> = numbering.old.iter().flat_map(|&old| r[old as usize].data.0[0]).collect();
    numbers.solve_in_place(structure, &mut work)?;
    Ok(numbering
        .new
        .iter()
        .map(|&new| Vec3::from_column_slice(&work[3 * new as usize..3 * new as usize + 3]))
        .collect())
}

/// The power of two below `size`, by which division is exact; one for zero.
fn power_of_two_near(size: f64) -> f64 {
    if size == 0.0 { 1.0 } else { size.log2().floor().clamp(-1000.0, 1000.0).exp2() }
}
