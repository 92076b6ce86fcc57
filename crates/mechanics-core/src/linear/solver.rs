use super::analysis::{Analysis, AnalysisReport, Family};
use super::conjugate_gradient::{Limits, PreconditionerFactor};
use super::cuthill_mckee::reverse_cuthill_mckee;
use super::elimination::Numbering;
use super::error::{LinearError, Operand};
use super::factorization::{Factor, Factorization};
use super::incomplete_cholesky::IncompleteCholesky;
use super::product::RowIndex;
use super::report::{Algorithm, FactorReport, Reason, Reuse, SolveReport};
use super::supernodal::{FactorFailure, SupernodalFactor};
use super::{Accuracy, LinearSolver, Method, Ordering, Preconditioner};
use crate::sparse::{BlockMatrix, BlockPattern};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Below so many unknowns the direct solver always wins.
const SMALL: usize = 20_000;

/// What conjugate gradients with incomplete Cholesky are expected to cost, in flops of the direct solver for each
/// stored block: 200 iterations of 12 ns, during which the direct solver does 180 flops each.
const ITERATIVE_FLOPS: f64 = 200.0 * 180.0;

/// Tolerance and iterations of [`Method::Automatic`] when it iterates.
const AUTOMATIC_LIMITS: Limits = Limits { tolerance: 1e-8, max_iterations: 2000 };

/// The solver of this workspace: see the [module](super).
#[derive(Debug, Default)]
pub struct Solver {
    method: Method,
    family: Family,
    rows: Option<(Arc<BlockPattern>, Arc<RowIndex>)>,
    narrow: Option<(Arc<BlockPattern>, Numbering)>,
    factorization: Option<Factorization>,
    /// The number of unknowns with which the iteration of [`Method::Automatic`] failed.
    iteration_failed: Option<usize>,
}

impl Solver {
    /// A solver that has factored nothing yet.
    pub fn new(method: Method) -> Self {
        Self { method, ..Self::default() }
    }

    /// The last factorisation.
    pub fn factorization(&self) -> Option<&Factorization> {
        self.factorization.as_ref()
    }

    /// Hands out the last factorisation; the solver keeps its order and goes on.
    pub fn take_factorization(&mut self) -> Option<Factorization> {
        self.factorization.take()
    }

    /// Orders `pattern` now, and starts from that order again at every [`LinearSolver::begin_step`]; a pattern that
    /// contacts only perturb keeps it.
    ///
    /// Give it the pattern without contacts, known from the mesh. Then a step's bits depend on the state given in,
    /// and no step orders from scratch. Without it, a step whose first pattern is not the one ordered last does.
    /// Of no effect for conjugate gradients.
    pub fn start_from(&mut self, pattern: &Arc<BlockPattern>) {
        match self.method {
            Method::Automatic => self.family.start_from(pattern, Ordering::FewestFlops),
            Method::Cholesky { ordering } => self.family.start_from(pattern, ordering),
            Method::ConjugateGradient { .. } => {}
        }
    }

    fn row_index(&mut self, pattern: &Arc<BlockPattern>) -> Arc<RowIndex> {
        match &self.rows {
            Some((known, rows)) if Arc::ptr_eq(known, pattern) || known == pattern => rows.clone(),
            _ => {
                let rows = Arc::new(RowIndex::new(pattern));
                self.rows = Some((pattern.clone(), rows.clone()));
                rows
            }
        }
    }

    /// The numbering for incomplete factorisation: measured on 30k unknowns it saves a third of the iterations of a
    /// lexicographic one and half of those of a random one or of nested dissection.
    fn narrow_numbering(&mut self, pattern: &Arc<BlockPattern>) -> Numbering {
        match &self.narrow {
            Some((known, numbering)) if Arc::ptr_eq(known, pattern) || known == pattern => numbering.clone(),
            _ => {
                let numbering = Numbering::from_old(reverse_cuthill_mckee(pattern));
                self.narrow = Some((pattern.clone(), numbering.clone()));
                numbering
            }
        }
    }

    fn factor_completely(
        &mut self,
        matrix: BlockMatrix,
        ordering: Ordering,
        reason: Reason,
    ) -> Result<FactorReport, LinearError> {
        let mut clock = Clock::start();
        let (analysis, known) = self.family.analyse(matrix.pattern(), ordering);
        let structure = analysis.structure()?;
        let symbolic_time = clock.lap().saturating_sub(known.ordering_time);
        let mut numbers = self.recycled_numbers();
        numbers.factor(&structure, &matrix).map_err(|failure| match failure {
            FactorFailure::Pivot { block } => {
                LinearError::NotPositiveDefinite { block: analysis.numbering.old[block] as usize }
            }
            FactorFailure::OutOfMemory { entries } => LinearError::OutOfMemory { entries },
        })?;
        let report = FactorReport {
            factor_entries: structure.stored_entries(),
            supernodes: structure.supernodes(),
            symbolic_time,
            numeric_time: clock.lap(),
            ..described(Algorithm::Cholesky, reason, Some((&analysis, known)))
        };
        let rows = self.row_index(matrix.pattern());
        let factor = Factor::Complete { analysis, structure, numbers };
        self.factorization = Some(Factorization { matrix, rows, factor });
        Ok(report)
    }

    /// The memory of the last factor: touching fresh pages costs as much as a thin body's factorisation.
    fn recycled_numbers(&mut self) -> SupernodalFactor {
        match self.factorization.take() {
            Some(Factorization { factor: Factor::Complete { numbers, .. }, .. }) => numbers,
            _ => SupernodalFactor::default(),
        }
    }

    fn factor_incompletely(
        &mut self,
        matrix: BlockMatrix,
        preconditioner: Preconditioner,
        limits: Limits,
        reason: Reason,
        known: Option<(&Analysis, AnalysisReport)>,
    ) -> Result<FactorReport, LinearError> {
        if !(0.0..1.0).contains(&limits.tolerance) {
            return Err(LinearError::Tolerance { tolerance: limits.tolerance });
        }
        self.factorization = None;
        let mut clock = Clock::start();
        let rows = self.row_index(matrix.pattern());
        let mut report = described(Algorithm::ConjugateGradient(preconditioner), reason, known);
        let preconditioner = match preconditioner {
            Preconditioner::BlockJacobi => PreconditionerFactor::block_jacobi(&matrix)?,
            Preconditioner::IncompleteCholesky => {
                let numbering = self.narrow_numbering(matrix.pattern());
                let mut factor = IncompleteCholesky::new(matrix.pattern(), numbering);
                report.symbolic_time = clock.lap();
                factor.factor(&matrix)?;
                report.failed_attempts = factor.failed_attempts;
                report.compensated_blocks = factor.compensated;
                PreconditionerFactor::IncompleteCholesky(Box::new(factor))
            }
        };
        report.numeric_time = clock.lap();
        let factor = Factor::Preconditioner { preconditioner, limits };
        self.factorization = Some(Factorization { matrix, rows, factor });
        Ok(report)
    }

    /// Direct if the system is small, if its factor is cheap, or if iterating failed before.
    fn factor_automatically(&mut self, matrix: BlockMatrix) -> Result<FactorReport, LinearError> {
        let unknowns = matrix.dimension();
        let ordering = Ordering::FewestFlops;
        if unknowns < SMALL {
            return self.factor_completely(matrix, ordering, Reason::Small { unknowns });
        }
        if self.iteration_failed == Some(unknowns) {
            return self.factor_completely(matrix, ordering, Reason::IterationFailed);
        }
        let (analysis, known) = self.family.analyse(matrix.pattern(), ordering);
        let iterative = ITERATIVE_FLOPS * matrix.pattern().block_count() as f64;
        let flops = analysis.flops;
        if flops <= iterative {
            let mut report =
                self.factor_completely(matrix, ordering, Reason::CheapFactor { flops, iterative })?;
            (report.reuse, report.ordering_time) = (known.reuse, known.ordering_time);
            return Ok(report);
        }
        let reason = Reason::DearFactor { flops, iterative };
        let preconditioner = Preconditioner::IncompleteCholesky;
        let attempt = self.factor_incompletely(
            matrix.clone(),
            preconditioner,
            AUTOMATIC_LIMITS,
            reason,
            Some((&analysis, known)),
        );
        match attempt {
            Err(LinearError::PreconditionerBreakdown { .. }) => {
                self.iteration_failed = Some(unknowns);
                self.factor_completely(matrix, ordering, Reason::IterationFailed)
            }
            outcome => outcome,
        }
    }
}

impl LinearSolver for Solver {
    fn begin_step(&mut self) {
        self.family.begin_step();
        self.iteration_failed = None;
    }

    fn factor(&mut self, matrix: &BlockMatrix) -> Result<FactorReport, LinearError> {
        if let Some(block) = not_finite(matrix) {
            self.factorization = None;
            return Err(LinearError::NotFinite { operand: Operand::Matrix, block });
        }
        let matrix = matrix.clone();
        match self.method {
            Method::Automatic => self.factor_automatically(matrix),
            Method::Cholesky { ordering } => self.factor_completely(matrix, ordering, Reason::Requested),
            Method::ConjugateGradient { preconditioner, tolerance, max_iterations } => {
                let limits = Limits { tolerance, max_iterations };
                self.factor_incompletely(matrix, preconditioner, limits, Reason::Requested, None)
            }
        }
    }

    fn solve_into(
        &mut self,
        b: &[f64],
        x: &mut [f64],
        accuracy: Accuracy,
    ) -> Result<SolveReport, LinearError> {
        let factorization = self.factorization.as_ref().ok_or(LinearError::NotFactored)?;
        let outcome = factorization.solve_into(b, x, accuracy);
        let iterated = matches!(factorization.factor, Factor::Preconditioner { .. });
        let failed = matches!(
            outcome,
            Err(LinearError::IterationLimit { .. }
                | LinearError::Stagnation { .. }
                | LinearError::NegativeCurvature { .. })
        );
        if !(failed && iterated && self.method == Method::Automatic) {
            return outcome;
        }
        let matrix = factorization.matrix.clone();
        self.iteration_failed = Some(matrix.dimension());
        self.factor_completely(matrix, Ordering::FewestFlops, Reason::IterationFailed)?;
        let factorization = self.factorization.as_ref().ok_or(LinearError::NotFactored)?;
        factorization.solve_into(b, x, accuracy)
    }
}

/// The first block column with an entry that is NaN or infinite.
fn not_finite(matrix: &BlockMatrix) -> Option<usize> {
    // x·0 is NaN exactly for the numbers sought; summing that over a column needs no branches.
    (0..matrix.pattern().columns()).find(|&column| {
        let blocks = &matrix.blocks()[matrix.pattern().column(column)];
        let sum: f64 = blocks.iter().map(|block| block.iter().map(|entry| entry * 0.0).sum::<f64>()).sum();
        sum != 0.0
    })
}

/// A report with nothing measured yet.
fn described(
    algorithm: Algorithm,
    reason: Reason,
    known: Option<(&Analysis, AnalysisReport)>,
) -> FactorReport {
    let (flops, entries) = known.map_or((0.0, 0), |(analysis, _)| (analysis.flops, analysis.entries));
    let (reuse, ordering_time) =
        known.map_or((Reuse::Nothing, Duration::ZERO), |(_, report)| (report.reuse, report.ordering_time));
    FactorReport {
        algorithm,
        reason,
        reuse,
        flops,
        factor_entries: entries,
        supernodes: 0,
        failed_attempts: 0,
        compensated_blocks: 0,
        ordering_time,
        symbolic_time: Duration::ZERO,
        numeric_time: Duration::ZERO,
    }
}

/// Time between laps.
struct Clock(Instant);

impl Clock {
    fn start() -> Self {
        Self(Instant::now())
    }

    fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now - std::mem::replace(&mut self.0, now)
    }
}
