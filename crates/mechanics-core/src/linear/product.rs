//! `y = A x` by rows, in parallel, with the same bits for any number of threads.

use crate::parallel;
use crate::sparse::{BlockMatrix, BlockPattern};
use crate::tensor::Vec3;

/// Rows of one parallel task. Depends on nothing but this constant, so results do not depend on the threads.
const ROWS: usize = 512;

/// For each block row the stored blocks left of the diagonal: the transpose of a pattern's column lists.
#[derive(Clone, Debug)]
pub(super) struct RowIndex {
    start: Vec<usize>,
    /// (column, slot) of each block, columns ascending.
    blocks: Vec<(u32, u32)>,
}

impl RowIndex {
    pub(super) fn new(pattern: &BlockPattern) -> Self {
        let columns = pattern.columns();
        let mut start = vec![0usize; columns + 1];
        for column in 0..columns {
            let slots = pattern.column(column);
            for &row in &pattern.rows()[slots.start + 1..slots.end] {
                start[row as usize + 1] += 1;
            }
        }
        for row in 0..columns {
            start[row + 1] += start[row];
        }
        let mut next = start.clone();
        let mut blocks = vec![(0, 0); start[columns]];
        for column in 0..columns {
            for slot in pattern.column(column).skip(1) {
                let row = pattern.rows()[slot] as usize;
                blocks[next[row]] = (column as u32, slot as u32);
                next[row] += 1;
            }
        }
        Self { start, blocks }
    }

    /// `y = A x`: every row gathers its blocks, left of the diagonal as stored, right of it transposed, always in
    /// the same order.
    pub(super) fn multiply_into(&self, matrix: &BlockMatrix, x: &[Vec3], y: &mut [Vec3]) {
        parallel::for_each_chunk(y, ROWS, |first, rows| {
            for (offset, y) in rows.iter_mut().enumerate() {
                *y = self.row_product(matrix, x, first + offset);
            }
        });
    }

    #[inline(always)]
    fn row_product(&self, matrix: &BlockMatrix, x: &[Vec3], row: usize) -> Vec3 {
        let pattern = matrix.pattern();
        let slots = pattern.column(row);
        let blocks = &matrix.blocks()[slots.clone()];
        let mut sum = blocks[0] * x[row];
        for &(column, slot) in &self.blocks[self.start[row]..self.start[row + 1]] {
            sum += matrix.blocks()[slot as usize] * x[column as usize];
        }
        for (block, &below) in blocks[1..].iter().zip(&pattern.rows()[slots.start + 1..slots.end]) {
            sum += block.tr_mul(&x[below as usize]);
        }
        sum
    }
}

/// `a · b` summed in fixed chunks.
pub(super) fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    parallel::sum(a.len(), 4096, |k| a[k].dot(&b[k]))
}

/// The largest component in absolute value and its block.
pub(super) fn largest(a: &[Vec3]) -> (f64, usize) {
    let mut best = (0.0, 0);
    for (block, vector) in a.iter().enumerate() {
        let size = vector.x.abs().max(vector.y.abs()).max(vector.z.abs());
        if size > best.0 {
            best = (size, block);
        }
    }
    best
}

/// Three numbers at a time.
pub(super) fn to_blocks(x: &[f64]) -> Vec<Vec3> {
    x.chunks_exact(3).map(|c| Vec3::new(c[0], c[1], c[2])).collect()
}
