//! The numeric factorisation: faer's supernodal Cholesky. The only file of the workspace that names faer.

use super::elimination::{LowerTriangle, Numbering, Reading, UpperPattern};
use super::error::LinearError;
use crate::parallel;
use crate::sparse::{BlockMatrix, BlockPattern};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::cholesky::{simplicial, supernodal};
use faer::sparse::linalg::{SymbolicSupernodalParams, amd};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Auto, Conj, MatMut, Par, Spec};

/// Below this many flops threads cost more than they bring (measured: half the speed on fronts of a thin body).
const PARALLEL_FLOPS: f64 = 2e10;

/// Neighbouring supernodes of at most so many columns are merged while at most this fraction of their entries is
/// zero.
const RELAXATION: &[(usize, f64)] = &[(4, 1.0), (16, 0.8), (48, 0.1), (usize::MAX, 0.05)];

/// Where the factor's entries are, and where each entry of the matrix goes: computed once per pattern and
/// numbering.
#[derive(Debug)]
pub(super) struct SupernodalStructure {
    factor: supernodal::SymbolicSupernodalCholesky<usize>,
    /// Lower triangle of the renumbered matrix, by scalar columns; diagonal blocks whole.
    column_start: Vec<usize>,
    rows: Vec<usize>,
    lower: LowerTriangle,
    flops: f64,
}

impl SupernodalStructure {
    /// The structure of the factor of `pattern` in the order of `numbering`, a postorder of its elimination tree.
    pub(super) fn new(
        pattern: &BlockPattern,
        numbering: &Numbering,
        upper: &UpperPattern,
        flops: f64,
    ) -> Result<Self, LinearError> {
        let columns = pattern.columns();
        let n = 3 * columns;
        let (upper_start, upper_rows) = scalar_upper(upper);
        let scalar_upper = SymbolicSparseColMatRef::new_checked(n, n, &upper_start, None, &upper_rows);
        let mut tree = vec![0isize; n];
        let mut counts = vec![0usize; n];
        let requirement = simplicial::prefactorize_symbolic_cholesky_scratch::<usize>(n, upper_rows.len())
            .or(supernodal::factorize_supernodal_symbolic_cholesky_scratch::<usize>(n));
        let out_of_memory = || LinearError::OutOfMemory { entries: upper_rows.len() };
        let mut memory = MemBuffer::try_new(requirement).map_err(|_| out_of_memory())?;
        let stack = MemStack::new(&mut memory);
        let tree = simplicial::prefactorize_symbolic_cholesky(&mut tree, &mut counts, scalar_upper, stack);
        let parameters = SymbolicSupernodalParams { relax: Some(RELAXATION) };
        let factor = supernodal::factorize_supernodal_symbolic_cholesky(
            scalar_upper,
            tree,
            &counts,
            stack,
            parameters,
        )
        .map_err(|_| LinearError::OutOfMemory { entries: counts.iter().sum() })?;
        let lower = LowerTriangle::renumbered(pattern, numbering);
        let (column_start, rows) = scalar_lower(&lower);
        Ok(Self { factor, column_start, rows, lower, flops })
    }

    /// Entries stored for the factor, explicit zeros of merged supernodes included.
    pub(super) fn stored_entries(&self) -> usize {
        self.factor.len_val()
    }

    pub(super) fn supernodes(&self) -> usize {
        self.factor.n_supernodes()
    }

    /// The lower triangle of the renumbered matrix, in the order of `rows`.
    fn scatter_into(&self, matrix: &BlockMatrix, values: &mut Vec<f64>) {
        values.clear();
        values.reserve(self.rows.len());
        for column in 0..self.lower.columns() {
            for component in 0..3 {
                for &(slot, reading) in &self.lower.sources[self.lower.column(column)] {
                    let block = &matrix.blocks()[slot as usize].data.0;
                    match reading {
                        Reading::AsStored => values.extend_from_slice(&block[component]),
                        Reading::Transposed => values.extend(block.iter().map(|column| column[component])),
                    }
                }
            }
        }
    }
}

/// The numbers of a factor L with L Lᵀ = P A Pᵀ.
#[derive(Debug, Default)]
pub(super) struct SupernodalFactor {
    values: Vec<f64>,
    matrix: Vec<f64>,
}

impl SupernodalFactor {
    /// Overwrites the factor. On failure the block column of the lost pivot, in the new numbering.
    pub(super) fn factor(
        &mut self,
        structure: &SupernodalStructure,
        matrix: &BlockMatrix,
    ) -> Result<(), FactorFailure> {
        structure.scatter_into(matrix, &mut self.matrix);
        let entries = structure.factor.len_val();
        if self.values.len() != entries {
            self.values = Vec::new();
            self.values.try_reserve_exact(entries).map_err(|_| FactorFailure::OutOfMemory { entries })?;
            self.values.resize(entries, 0.0);
        }
        let n = structure.factor.nrows();
        let pattern = SymbolicSparseColMatRef::new_unsorted_checked(
            n,
            n,
            &structure.column_start,
            None,
            &structure.rows,
        );
        let threads = parallel::thread_count();
        let parallelism =
            if structure.flops < PARALLEL_FLOPS || threads < 2 { Par::Seq } else { Par::rayon(threads) };
        let parameters = Spec::new(Auto::<f64>::auto());
        let requirement = supernodal::factorize_supernodal_numeric_llt_scratch::<usize, f64>(
            &structure.factor,
            parallelism,
            parameters,
        );
        let mut memory =
            MemBuffer::try_new(requirement).map_err(|_| FactorFailure::OutOfMemory { entries })?;
        supernodal::factorize_supernodal_numeric_llt(
            &mut self.values,
            SparseColMatRef::new(pattern, &self.matrix),
            Default::default(),
            &structure.factor,
            parallelism,
            MemStack::new(&mut memory),
            parameters,
        )
        .map(|_| ())
        .map_err(|LltError::NonPositivePivot { index }| FactorFailure::Pivot { block: index / 3 })
    }

    /// `x ← (L Lᵀ)⁻¹ x` in the new numbering; always sequential, because faer's solve gives other bits with
    /// threads.
    pub(super) fn solve_in_place(
        &self,
        structure: &SupernodalStructure,
        x: &mut [f64],
    ) -> Result<(), LinearError> {
        let requirement = structure.factor.solve_in_place_scratch::<f64>(1, Par::Seq);
        let mut memory = MemBuffer::try_new(requirement)
            .map_err(|_| LinearError::OutOfMemory { entries: structure.factor.nrows() })?;
        let rows = x.len();
        supernodal::SupernodalLltRef::new(&structure.factor, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, rows, 1),
            Par::Seq,
            MemStack::new(&mut memory),
        );
        Ok(())
    }
}

/// Why there is no factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FactorFailure {
    /// The block column of the pivot, in the new numbering.
    Pivot {
        block: usize,
    },
    OutOfMemory {
        entries: usize,
    },
}

/// Approximate minimum degree: the caller's column at each new position.
pub(super) fn approximate_minimum_degree(pattern: &BlockPattern) -> Vec<u32> {
    let columns = pattern.columns();
    let upper = UpperPattern::renumbered(pattern, &Numbering::identity(columns));
    let rows: Vec<usize> = upper.rows.iter().map(|&row| row as usize).collect();
    let graph = SymbolicSparseColMatRef::new_checked(columns, columns, &upper.start, None, &rows);
    let (mut order, mut inverse) = (vec![0usize; columns], vec![0usize; columns]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(columns, rows.len()));
    let ordered =
        amd::order(&mut order, &mut inverse, graph, amd::Control::default(), MemStack::new(&mut memory));
    match ordered {
        Ok(_) => order.into_iter().map(|column| column as u32).collect(),
        Err(_) => (0..columns as u32).collect(),
    }
}

/// The upper triangle, diagonal included, expanded by three.
fn scalar_upper(upper: &UpperPattern) -> (Vec<usize>, Vec<usize>) {
    let columns = upper.columns();
    let mut start = Vec::with_capacity(3 * columns + 1);
    let mut rows = Vec::with_capacity(9 * upper.rows.len() + 6 * columns);
    start.push(0);
    for column in 0..columns {
        for component in 0..3 {
            for &row in upper.column(column) {
                let first = 3 * row as usize;
                rows.extend(first..first + 3);
            }
            rows.extend(3 * column..=3 * column + component);
            start.push(rows.len());
        }
    }
    (start, rows)
}

/// Block columns expanded by three.
fn scalar_lower(lower: &LowerTriangle) -> (Vec<usize>, Vec<usize>) {
    let mut start = Vec::with_capacity(3 * lower.columns() + 1);
    let mut rows = Vec::with_capacity(9 * lower.rows.len());
    start.push(0);
    for column in 0..lower.columns() {
        for _ in 0..3 {
            for &row in &lower.rows[lower.column(column)] {
                let first = 3 * row as usize;
                rows.extend(first..first + 3);
            }
            start.push(rows.len());
        }
    }
    (start, rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::analysis::order;
    use crate::linear::elimination::Elimination;
    use crate::linear::{Ordering, predict_factor};
    use crate::tensor::Mat3;
    use std::sync::Arc;

    /// Springs along the axes and diagonals of a grid of n³ nodes.
    fn grid(n: usize) -> BlockMatrix {
        let node = |i: usize, j: usize, k: usize| (k * n + j) * n + i;
        let (mut start, mut rows) = (vec![0], Vec::new());
        for k in 0..n {
            for j in 0..n {
                for i in 0..n {
                    rows.push(node(i, j, k) as u32);
                    for (next, inside) in [
                        (node(i + 1, j, k), i + 1 < n),
                        (node(i, j + 1, k), j + 1 < n),
                        (node(i, j, k + 1), k + 1 < n),
                        (node(i + 1, j + 1, k + 1), i.max(j).max(k) + 1 < n),
                    ] {
                        if inside {
                            rows.push(next as u32);
                        }
                    }
                    start.push(rows.len());
                }
            }
        }
        let pattern = Arc::new(BlockPattern::new(start, rows).unwrap());
        let mut matrix = BlockMatrix::zeros(pattern.clone());
        for column in 0..n * n * n {
            for slot in pattern.column(column) {
                let diagonal = pattern.rows()[slot] as usize == column;
                let entry = |i: usize, j: usize| 1.0 / (1.0 + (i + j) as f64 + (slot % 7) as f64);
                matrix.blocks_mut()[slot] =
                    if diagonal { Mat3::identity() * 40.0 } else { Mat3::from_fn(entry) };
            }
        }
        matrix
    }

    /// The threaded path is for factors of 20 Gflop, too slow for a test: claim that many.
    #[test]
    fn a_threaded_factorisation_gives_the_bits_of_a_sequential_one() {
        let matrix = grid(12);
        let pattern = matrix.pattern();
        let order = order(pattern, Ordering::NestedDissection);
        let tree = Elimination::new(&UpperPattern::renumbered(pattern, &order));
        let old = tree.postorder().into_iter().map(|position| order.old[position as usize]).collect();
        let numbering = Numbering::from_old(old);
        let upper = UpperPattern::renumbered(pattern, &numbering);
        let factor = |flops: f64, threads: usize| {
            let structure = SupernodalStructure::new(pattern, &numbering, &upper, flops).unwrap();
            let mut numbers = SupernodalFactor::default();
            parallel::with_threads(threads, || numbers.factor(&structure, &matrix)).unwrap();
            numbers.values
        };
        let reference = factor(0.0, 1);
        for threads in [1, 2, 3, 8] {
            let values = factor(1e12, threads);
            assert!(
                values.iter().zip(&reference).all(|(a, b)| a.to_bits() == b.to_bits()),
                "{threads} threads"
            );
        }
    }

    #[test]
    fn the_predicted_entries_are_those_of_the_factor() {
        // Counted by brute force: eliminate on a dense pattern.
        let matrix = grid(4);
        let columns = matrix.pattern().columns();
        let mut filled = vec![vec![false; columns]; columns];
        for column in 0..columns {
            for slot in matrix.pattern().column(column) {
                filled[matrix.pattern().rows()[slot] as usize][column] = true;
            }
        }
        let (mut entries, mut flops) = (0, 0.0);
        for pivot in 0..columns {
            let below: Vec<usize> = (pivot..columns).filter(|&row| filled[row][pivot]).collect();
            for &row in &below[1..] {
                for &column in below[1..].iter().filter(|&&column| column <= row) {
                    filled[row][column] = true;
                }
            }
            for scalars in [3 * below.len(), 3 * below.len() - 1, 3 * below.len() - 2] {
                entries += scalars;
                flops += (scalars * scalars) as f64;
            }
        }
        let predicted = predict_factor(matrix.pattern(), Ordering::Natural);
        assert_eq!((predicted.entries, predicted.flops), (entries, flops));
    }
}
