use std::fmt;

/// Which operand of a linear system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// The matrix.
    Matrix,
    /// The right-hand side.
    RightHandSide,
}

impl fmt::Display for Operand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Matrix => "matrix",
            Self::RightHandSide => "right-hand side",
        })
    }
}

/// Why a linear system was not solved. Blocks are block columns in the caller's numbering.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinearError {
    /// An entry is NaN or infinite.
    #[error("the {operand} has an entry that is not finite in block {block}")]
    NotFinite {
        /// Which operand.
        operand: Operand,
        /// The block column (matrix) or block row (right-hand side).
        block: usize,
    },
    /// A pivot of the complete factorisation is zero or negative: the matrix is not positive definite to working
    /// precision.
    #[error("the matrix is not positive definite: Cholesky loses its pivot at block {block}")]
    NotPositiveDefinite {
        /// The block column of the pivot.
        block: usize,
    },
    /// The incomplete factorisation loses a pivot although all that it drops is compensated: the matrix is not
    /// positive definite, or only just.
    #[error("the incomplete factorisation breaks down at block {block}; use the direct solver")]
    PreconditionerBreakdown {
        /// The block column of the pivot.
        block: usize,
    },
    /// A search direction p has pᵀA p ≤ 0: the matrix is not positive definite.
    #[error(
        "the matrix is not positive definite: conjugate gradients meet curvature {curvature:e} in iteration \
         {iteration}, most of the direction lies in block {block}"
    )]
    NegativeCurvature {
        /// The iteration, counted from one.
        iteration: usize,
        /// pᵀA p / pᵀp, in the units of the matrix.
        curvature: f64,
        /// The block where the direction is largest.
        block: usize,
    },
    /// The residual stopped falling above the tolerance: the system is singular or too badly conditioned.
    #[error(
        "the relative residual stays at {residual:e} after {iteration} iterations (wanted {tolerance:e}); it is \
         largest in block {block}"
    )]
    Stagnation {
        /// Iterations, or refinement steps of a direct solve.
        iteration: usize,
        /// ‖b − A x‖ / ‖b‖.
        residual: f64,
        /// What was wanted.
        tolerance: f64,
        /// The block where the residual is largest.
        block: usize,
    },
    /// The limit of iterations was reached.
    #[error(
        "{iterations} iterations reach the relative residual {residual:e} (wanted {tolerance:e}); it is largest \
         in block {block}"
    )]
    IterationLimit {
        /// The limit.
        iterations: usize,
        /// ‖b − A x‖ / ‖b‖.
        residual: f64,
        /// What was wanted.
        tolerance: f64,
        /// The block where the residual is largest.
        block: usize,
    },
    /// There is no factorisation to solve with.
    #[error("solve was called before a successful factor")]
    NotFactored,
    /// A tolerance is not in [0, 1).
    #[error("a relative tolerance lies in [0, 1), but {tolerance} was given")]
    Tolerance {
        /// The tolerance given.
        tolerance: f64,
    },
    /// The factor does not fit in memory.
    #[error("the Cholesky factor needs {entries} entries of 8 bytes, which could not be had")]
    OutOfMemory {
        /// Entries of the factor.
        entries: usize,
    },
}
