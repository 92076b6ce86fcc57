use super::Preconditioner;
use std::fmt;
use std::time::Duration;

/// What a matrix was factored with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// Sparse Cholesky.
    Cholesky,
    /// Conjugate gradients.
    ConjugateGradient(Preconditioner),
}

/// Why the algorithm was used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// The caller asked for it.
    Requested,
    /// Too few unknowns for iterations to pay.
    Small {
        /// The number of unknowns.
        unknowns: usize,
    },
    /// A thin or sparse body: the factor is cheap.
    CheapFactor {
        /// Predicted flops of the factorisation.
        flops: f64,
        /// Flops that the iterations are expected to cost.
        iterative: f64,
    },
    /// A solid body: the factor is dear.
    DearFactor {
        /// Predicted flops of the factorisation.
        flops: f64,
        /// Flops that the iterations are expected to cost.
        iterative: f64,
    },
    /// The iteration failed on an earlier system of this size and step.
    IterationFailed,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Requested => f.write_str("requested by the caller"),
            Self::Small { unknowns } => write!(f, "only {unknowns} unknowns"),
            Self::CheapFactor { flops, iterative } => {
                write!(f, "factoring takes {flops:.1e} flops, iterating about {iterative:.1e}")
            }
            Self::DearFactor { flops, iterative } => {
                write!(f, "factoring would take {flops:.1e} flops, iterating about {iterative:.1e}")
            }
            Self::IterationFailed => {
                f.write_str("conjugate gradients failed on an earlier system of this size")
            }
        }
    }
}

/// What was kept from earlier matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reuse {
    /// First pattern of its size, or a method that analyses nothing.
    Nothing,
    /// Same pattern: the order and the structure of the factor.
    Everything,
    /// Another pattern: the order only.
    Order,
    /// Another pattern, so different that it was ordered anew.
    OrderGivenUp,
}

/// What a factorisation did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorReport {
    /// The algorithm.
    pub algorithm: Algorithm,
    /// Why this one.
    pub reason: Reason,
    /// What was kept.
    pub reuse: Reuse,
    /// Predicted multiplications and additions of a complete factorisation, zero if not analysed.
    pub flops: f64,
    /// Scalar entries of the complete factor, zero if not analysed.
    pub factor_entries: usize,
    /// Supernodes of the complete factor.
    pub supernodes: usize,
    /// Attempts at the incomplete factorisation that lost a pivot.
    pub failed_attempts: usize,
    /// Dropped blocks for which the diagonal was compensated to keep the pivots.
    pub compensated_blocks: usize,
    /// Time to order the graph.
    pub ordering_time: Duration,
    /// Time to predict the factor and lay it out.
    pub symbolic_time: Duration,
    /// Time for the numbers.
    pub numeric_time: Duration,
}

/// What a solve did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// The algorithm that found the solution.
    pub algorithm: Algorithm,
    /// Conjugate gradient iterations, or refinement steps of a direct solve.
    pub iterations: usize,
    /// ‖b − A x‖₂ / ‖b‖₂, evaluated with the matrix; zero for b = 0.
    pub residual: f64,
    /// Time of the solve.
    pub time: Duration,
}
