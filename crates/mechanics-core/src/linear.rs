//! Sparse symmetric positive definite systems of 3×3 blocks: one trait, one enum.
//!
//! [`Solver`] factors a [`BlockMatrix`] and then solves with it as often as wanted; what it factored can be taken
//! out ([`Solver::take_factorization`]) and used later, for adjoints say. [`Method`] picks the algorithm:
//!
//! * **Cholesky**: the *node graph* is ordered by nested dissection or minimum degree, every node standing for its
//!   three scalars; the numeric factorisation is supernodal; each solve is refined with the matrix itself until the residual stops
//!   falling. Within a time step the order is kept while contacts come and go, and made anew only when the pattern
//!   has drifted so far that it pays; [`LinearSolver::begin_step`] goes back to that of [`Solver::start_from`].
//! * **Conjugate gradients**, preconditioned by the inverses of the diagonal blocks or by an incomplete Cholesky
//!   factorisation on the pattern of the matrix (contact blocks included).
//! * **Automatic**: decides from the flops the factor needs against what the iterations are expected to cost, and
//!   says why in its report. If the iteration fails, it factors instead, and stays with that until the next step.
//!
//! The result has the same bits for any number of threads.
//!
//! ```
//! use mechanics_core::linear::{Accuracy, LinearSolver, Method, Solver};
//! use mechanics_core::sparse::{BlockMatrix, BlockPattern};
//! use mechanics_core::tensor::Mat3;
//! use std::sync::Arc;
//!
//! // Two nodes, tied by a spring: 2 on the diagonal, −1 beside it.
//! let pattern = Arc::new(BlockPattern::new(vec![0, 2, 3], vec![0, 1, 1])?);
//! let blocks = vec![Mat3::identity() * 2.0, -Mat3::identity(), Mat3::identity() * 2.0];
//! let mut solver = Solver::new(Method::Automatic);
//! solver.factor(&BlockMatrix::from_blocks(pattern, blocks))?;
//! let mut x = [0.0; 6];
//! solver.solve_into(&[1.0, 2.0, 3.0, 0.0, 0.0, 0.0], &mut x, Accuracy::Configured)?;
//! assert!((x[0] - 2.0 / 3.0).abs() < 1e-15 && (x[3] - 1.0 / 3.0).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod analysis;
mod conjugate_gradient;
mod cuthill_mckee;
mod dissection;
mod elimination;
mod error;
mod factorization;
mod incomplete_cholesky;
mod product;
mod report;
mod solver;
mod supernodal;

pub use analysis::{FactorPrediction, predict_factor};
pub use error::{LinearError, Operand};
pub use factorization::Factorization;
pub use report::{Algorithm, FactorReport, Reason, Reuse, SolveReport};
pub use solver::Solver;

use crate::sparse::BlockMatrix;

/// Factors symmetric positive definite matrices and solves with them.
pub trait LinearSolver {
    /// Forgets what earlier matrices taught: from here on, results have the bits that a new solver's have. The last
    /// factorisation stays until the next.
    ///
    /// Between two calls a solver may keep an order of elimination while the pattern changes, or remember that
    /// iterating failed; then the bits of a result depend on the matrices before. A time step that begins with this
    /// call depends on the state given in alone, so that a resumed run repeats the original one.
    fn begin_step(&mut self);

    /// Prepares to solve with `matrix`. After an error there is nothing to solve with.
    ///
    /// # Errors
    /// [`LinearError::NotFinite`], [`LinearError::NotPositiveDefinite`], [`LinearError::PreconditionerBreakdown`],
    /// [`LinearError::OutOfMemory`].
    fn factor(&mut self, matrix: &BlockMatrix) -> Result<FactorReport, LinearError>;

    /// `x = A⁻¹ b` with the matrix last factored. On error `x` is left as it was.
    ///
    /// # Errors
    /// [`LinearError::NotFactored`], [`LinearError::NotFinite`], [`LinearError::Tolerance`],
    /// [`LinearError::NegativeCurvature`], [`LinearError::Stagnation`], [`LinearError::IterationLimit`].
    ///
    /// # Panics
    /// If `b` or `x` does not have the matrix's dimension.
    fn solve_into(
        &mut self,
        b: &[f64],
        x: &mut [f64],
        accuracy: Accuracy,
    ) -> Result<SolveReport, LinearError>;
}

/// How small the residual ‖b − A x‖₂ / ‖b‖₂ of one solve must be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Accuracy {
    /// As the [`Method`] says; a direct solve is refined until rounding stops it.
    #[default]
    Configured,
    /// At most this, in [0, 1): an inexact Newton step. A direct solve that rounding stops above it counts as long as
    /// its residual is below 1e-6, or below 1e-3 and within the rounding of A x; the report says what was reached.
    Relative(f64),
}

/// How to solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Method {
    /// Chosen by size and shape; see [`Reason`].
    #[default]
    Automatic,
    /// Complete factorisation.
    Cholesky {
        /// The order of elimination.
        ordering: Ordering,
    },
    /// Preconditioned conjugate gradients.
    ConjugateGradient {
        /// The preconditioner.
        preconditioner: Preconditioner,
        /// Largest relative residual, in [0, 1).
        tolerance: f64,
        /// Iterations before [`LinearError::IterationLimit`].
        max_iterations: usize,
    },
}

/// The order in which unknowns are eliminated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ordering {
    /// Nested dissection or minimum degree, whichever needs fewer flops on this pattern.
    #[default]
    FewestFlops,
    /// Nested dissection of the node graph: best for solids.
    NestedDissection,
    /// Approximate minimum degree on the node graph: quick to find, often good for thin bodies.
    MinimumDegree,
    /// The caller's numbering.
    Natural,
}

/// What multiplies the residual in conjugate gradients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preconditioner {
    /// The inverses of the diagonal blocks: cheap, weak.
    BlockJacobi,
    /// Block incomplete Cholesky on the pattern of the matrix: survives contact blocks 10⁴ times stiffer.
    #[default]
    IncompleteCholesky,
}
