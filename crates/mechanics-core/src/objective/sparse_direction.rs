//! The sparse solvers as solvers of Newton's systems.

use super::{DirectionAccuracy, DirectionSolver, Indefinite, SolverError};
use crate::linear::{Accuracy, LinearError, LinearSolver, Operand, Solver};
use crate::sparse::BlockMatrix;

impl DirectionSolver for Solver {
    fn begin_step(&mut self) {
        LinearSolver::begin_step(self);
    }

    fn prepare(&mut self, matrix: &BlockMatrix) -> Result<(), SolverError> {
        self.factor(matrix).map(drop).map_err(solver_error)
    }

    fn solve_into(
        &mut self,
        b: &[f64],
        accuracy: DirectionAccuracy,
        x: &mut [f64],
    ) -> Result<u64, SolverError> {
        let accuracy = match accuracy {
            DirectionAccuracy::Full | DirectionAccuracy::Decisive => Accuracy::Configured,
            DirectionAccuracy::Relative(forcing) => Accuracy::Relative(forcing),
        };
        let report = LinearSolver::solve_into(self, b, x, accuracy).map_err(solver_error)?;
        Ok(report.iterations as u64)
    }
}

/// Lost pivots and negative curvature are cured by a shift; what is not finite is looked for in the terms.
fn solver_error(error: LinearError) -> SolverError {
    match error {
        LinearError::NotPositiveDefinite { block }
        | LinearError::PreconditionerBreakdown { block, .. }
        | LinearError::NegativeCurvature { block, .. } => Indefinite { block }.into(),
        LinearError::NotFinite { operand: Operand::Matrix, block } => SolverError::NonFinite { block },
        other => SolverError::Other(Box::new(other)),
    }
}
