use super::error::LinearError;
use super::incomplete_cholesky::{IncompleteCholesky, inverse_of_pivot};
use super::product::{RowIndex, dot, largest};
use crate::sparse::BlockMatrix;
use crate::tensor::{Mat3, Vec3};

/// Iterations in which the residual must at least halve.
const PATIENCE: usize = 1000;

/// How often the recurrence's residual may disagree with the true one at the end.
const RESTARTS: usize = 4;

/// What M⁻¹ is.
#[derive(Debug)]
pub(super) enum PreconditionerFactor {
    BlockJacobi(Vec<Mat3>),
    IncompleteCholesky(Box<IncompleteCholesky>),
}

impl PreconditionerFactor {
    /// The inverses of the diagonal blocks.
    pub(super) fn block_jacobi(matrix: &BlockMatrix) -> Result<Self, LinearError> {
        let invert = |block| {
            let diagonal = matrix.diagonal(block);
            inverse_of_pivot(diagonal, diagonal).ok_or(LinearError::NotPositiveDefinite { block })
        };
        (0..matrix.pattern().columns()).map(invert).collect::<Result<_, _>>().map(Self::BlockJacobi)
    }

    fn apply_into(&self, r: &[Vec3], work: &mut [Vec3], z: &mut [Vec3]) {
        match self {
            Self::BlockJacobi(inverses) => {
                for ((z, r), inverse) in z.iter_mut().zip(r).zip(inverses) {
                    *z = inverse * r;
                }
            }
            Self::IncompleteCholesky(factor) => factor.apply_into(r, work, z),
        }
    }
}

/// What a solve reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct Convergence {
    pub(super) iterations: usize,
    pub(super) residual: f64,
}

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) tolerance: f64,
    pub(super) max_iterations: usize,
}

/// Preconditioned conjugate gradients from zero, for `‖b − A x‖₂ ≤ tolerance ‖b‖₂`.
///
/// The residual of the recurrence drifts from the true one; when it is small enough the true one is computed, and
/// if that is not, the method restarts from it.
///
/// # Reference
/// M. R. Hestenes, E. Stiefel, J. Res. Nat. Bur. Standards 49 (1952), with the preconditioner as in Saad,
/// Iterative Methods for Sparse Linear Systems (2003), algorithm 9.1.
pub(super) struct ConjugateGradient<'a> {
    pub(super) matrix: &'a BlockMatrix,
    pub(super) rows: &'a RowIndex,
    pub(super) preconditioner: &'a PreconditionerFactor,
    pub(super) limits: Limits,
}

impl ConjugateGradient<'_> {
    /// Solves for a right-hand side of order one.
    pub(super) fn solve(&self, b: &[Vec3]) -> Result<(Vec<Vec3>, Convergence), LinearError> {
        let size = b.len();
        let norm = dot(b, b).sqrt();
        let mut x = vec![Vec3::zeros(); size];
        if norm == 0.0 {
            return Ok((x, Convergence { iterations: 0, residual: 0.0 }));
        }
        let (mut r, mut z) = (b.to_vec(), vec![Vec3::zeros(); size]);
        let (mut q, mut work) = (z.clone(), z.clone());
        self.preconditioner.apply_into(&r, &mut work, &mut z);
        let mut p = z.clone();
        let mut descent = dot(&r, &z);
        let mut progress = Progress { best: 1.0, since: 0, restarts: 0 };
        for iteration in 1..=self.limits.max_iterations {
            self.rows.multiply_into(self.matrix, &p, &mut q);
            let curvature = dot(&p, &q);
            if !(curvature > 0.0 && curvature.is_finite() && descent > 0.0) {
                return Err(negative_curvature(iteration, curvature.min(descent), &p));
            }
            advance(descent / curvature, &p, &q, &mut x, &mut r);
            let mut residual = dot(&r, &r).sqrt() / norm;
            let apparently_converged = residual <= self.limits.tolerance;
            if apparently_converged {
                self.residual_into(b, &x, &mut r);
                residual = dot(&r, &r).sqrt() / norm;
                if residual <= self.limits.tolerance {
                    return Ok((x, Convergence { iterations: iteration, residual }));
                }
                progress.restarts += 1;
            }
            if progress.stalls(iteration, residual) {
                return Err(LinearError::Stagnation {
                    iteration,
                    residual,
                    tolerance: self.limits.tolerance,
                    block: largest(&r).1,
                });
            }
            self.preconditioner.apply_into(&r, &mut work, &mut z);
            let next = dot(&r, &z);
            let beta = if apparently_converged { 0.0 } else { next / descent };
            descent = next;
            for (p, z) in p.iter_mut().zip(&z) {
                *p = *z + *p * beta;
            }
        }
        self.residual_into(b, &x, &mut r);
        Err(LinearError::IterationLimit {
            iterations: self.limits.max_iterations,
            residual: dot(&r, &r).sqrt() / norm,
            tolerance: self.limits.tolerance,
            block: largest(&r).1,
        })
    }

    fn residual_into(&self, b: &[Vec3], x: &[Vec3], r: &mut [Vec3]) {
        self.rows.multiply_into(self.matrix, x, r);
        for (r, b) in r.iter_mut().zip(b) {
            *r = b - *r;
        }
    }
}

/// Whether the residual still falls.
struct Progress {
    best: f64,
    since: usize,
    restarts: usize,
}

impl Progress {
    fn stalls(&mut self, iteration: usize, residual: f64) -> bool {
        if residual < 0.5 * self.best {
            self.best = residual;
            self.since = iteration;
        }
        self.restarts > RESTARTS || iteration - self.since > PATIENCE || !residual.is_finite()
    }
}

/// `x += step p`, `r −= step q`.
fn advance(step: f64, p: &[Vec3], q: &[Vec3], x: &mut [Vec3], r: &mut [Vec3]) {
    for (x, p) in x.iter_mut().zip(p) {
        *x += p * step;
    }
    for (r, q) in r.iter_mut().zip(q) {
        *r -= q * step;
    }
}

fn negative_curvature(iteration: usize, curvature: f64, p: &[Vec3]) -> LinearError {
    LinearError::NegativeCurvature { iteration, curvature: curvature / dot(p, p), block: largest(p).1 }
}
