use super::elimination::{LowerTriangle, Numbering, Reading};
use super::error::LinearError;
use crate::sparse::{BlockMatrix, BlockPattern};
use crate::tensor::{Mat3, Vec3};

/// A pivot smaller than this fraction of the matrix's diagonal entry counts as lost.
const SMALLEST_PIVOT: f64 = 1e-10;

/// Dropped blocks larger than this are compensated, one attempt after the other. Relative to the geometric mean of
/// the softnesses 1/‖Aᵢᵢ⁻¹‖ of the nodes they would have linked.
const COMPENSATED: [f64; 4] = [f64::INFINITY, 0.3, 0.03, 0.0];

/// Block incomplete Cholesky without fill: M = L D Lᵀ ≈ A, where L is unit lower triangular and has blocks only
/// where A has.
///
/// Column by column, with U the current values of A below the pivot block Dₖ: Lᵢₖ = Uᵢₖ Dₖ⁻¹, and every *stored*
/// block (i, j) of the remaining triangle loses F = Lᵢₖ Uⱼₖᵀ. Where no block is stored, F is dropped.
///
/// Dropping can make a pivot indefinite although A is positive definite. Then the factorisation starts again and
/// *compensates* the larger dropped blocks: what is dropped is the matrix with −F at (i, j) and −Fᵀ at (j, i); adding
/// (F Fᵀ)^½ to the diagonal block of i and (Fᵀ F)^½ to that of j as well makes the error positive semi-definite.
/// With every dropped block compensated, each remaining matrix is a Schur complement of A plus positive
/// semi-definite terms, so no pivot is ever lost in exact arithmetic (Ajiz, Jennings 1984, here with blocks). The
/// roots add stiffness only in the directions in which F has it: a stiff contact does not freeze the sliding of its
/// nodes, as a shift of the whole diagonal would.
///
/// # Reference
/// J. A. Meijerink, H. A. van der Vorst, Math. Comp. 31 (1977); M. A. Ajiz, A. Jennings, A robust incomplete
/// Choleski-conjugate gradient algorithm, Int. J. Numer. Meth. Engng 20 (1984).
#[derive(Debug)]
pub(super) struct IncompleteCholesky {
    lower: LowerTriangle,
    numbering: Numbering,
    blocks: Vec<Mat3>,
    pivot_inverses: Vec<Mat3>,
    /// 1/‖Aᵢᵢ⁻¹‖: how stiff a node is in its softest direction.
    sizes: Vec<f64>,
    /// Attempts that lost a pivot, and dropped blocks compensated by the one that did not.
    pub(super) failed_attempts: usize,
    pub(super) compensated: usize,
}

impl IncompleteCholesky {
    /// The structure for a pattern; no numbers yet.
    pub(super) fn new(pattern: &BlockPattern, numbering: Numbering) -> Self {
        let lower = LowerTriangle::renumbered(pattern, &numbering);
        let blocks = vec![Mat3::zeros(); lower.rows.len()];
        let pivot_inverses = vec![Mat3::zeros(); pattern.columns()];
        let sizes = vec![0.0; pattern.columns()];
        Self { lower, numbering, blocks, pivot_inverses, sizes, failed_attempts: 0, compensated: 0 }
    }

    /// Factors, compensating as little as keeps every pivot block positive definite.
    pub(super) fn factor(&mut self, matrix: &BlockMatrix) -> Result<(), LinearError> {
        let mut lost = 0;
        for (size, &old) in self.sizes.iter_mut().zip(&self.numbering.old) {
            let diagonal = matrix.diagonal(old as usize);
            let inverse = inverse_of_pivot(diagonal, diagonal)
                .ok_or(LinearError::NotPositiveDefinite { block: old as usize })?;
            *size = 1.0 / inverse.norm();
        }
        for (attempt, &threshold) in COMPENSATED.iter().enumerate() {
            self.failed_attempts = attempt;
            self.compensated = 0;
            match self.factor_once(matrix, threshold) {
                Ok(()) => return Ok(()),
                Err(column) => lost = self.numbering.old[column] as usize,
            }
        }
        Err(LinearError::PreconditionerBreakdown { block: lost })
    }

    /// One attempt; the column whose pivot is lost on failure.
    fn factor_once(&mut self, matrix: &BlockMatrix, threshold: f64) -> Result<(), usize> {
        self.load(matrix);
        let mut updates = Vec::new();
        for column in 0..self.lower.columns() {
            let range = self.lower.column(column);
            let diagonal = matrix.diagonal(self.numbering.old[column] as usize);
            let inverse = inverse_of_pivot(&self.blocks[range.start], diagonal).ok_or(column)?;
            self.pivot_inverses[column] = inverse;
            updates.clear();
            for place in range.start + 1..range.end {
                let current = self.blocks[place];
                self.blocks[place] = current * inverse;
                updates.push((self.lower.rows[place], self.blocks[place], current.transpose()));
            }
            self.subtract_outer_products(&updates, threshold);
        }
        Ok(())
    }

    fn load(&mut self, matrix: &BlockMatrix) {
        for (block, &(slot, reading)) in self.blocks.iter_mut().zip(&self.lower.sources) {
            let stored = &matrix.blocks()[slot as usize];
            *block = match reading {
                Reading::AsStored => *stored,
                Reading::Transposed => stored.transpose(),
            };
        }
    }

    /// Subtracts Lᵢ Uⱼᵀ from every stored block (i, j), j ≤ i. `updates` holds (i, Lᵢ, Uᵢᵀ), i ascending.
    fn subtract_outer_products(&mut self, updates: &[(u32, Mat3, Mat3)], threshold: f64) {
        for (first, (column, _, upper)) in updates.iter().enumerate() {
            let range = self.lower.column(*column as usize);
            let mut place = range.start;
            for (row, lower, _) in &updates[first..] {
                while place < range.end && self.lower.rows[place] < *row {
                    place += 1;
                }
                if place < range.end && self.lower.rows[place] == *row {
                    self.blocks[place] -= lower * upper;
                } else if threshold.is_finite() {
                    self.drop_block(*row as usize, *column as usize, &(lower * upper), threshold);
                }
            }
        }
    }

    /// Compensates the block F = `dropped` between two nodes if it is large.
    fn drop_block(&mut self, row: usize, column: usize, dropped: &Mat3, threshold: f64) {
        let size = dropped.norm();
        if size * size <= threshold * threshold * self.sizes[row] * self.sizes[column] {
            return;
        }
        let (left, right) = roots(&(dropped / size));
        let (row, column) = (self.lower.column(row).start, self.lower.column(column).start);
        self.blocks[row] += left * size;
        self.blocks[column] += right * size;
        self.compensated += 1;
    }

    /// `z = M⁻¹ r`. `work` is overwritten.
    pub(super) fn apply_into(&self, r: &[Vec3], work: &mut [Vec3], z: &mut [Vec3]) {
        for (value, &old) in work.iter_mut().zip(&self.numbering.old) {
            *value = r[old as usize];
        }
        for column in 0..self.lower.columns() {
            let value = work[column];
            for place in self.lower.column(column).skip(1) {
                work[self.lower.rows[place] as usize] -= self.blocks[place] * value;
            }
        }
        for column in (0..self.lower.columns()).rev() {
            let mut value = self.pivot_inverses[column] * work[column];
            for place in self.lower.column(column).skip(1) {
                value -= self.blocks[place].tr_mul(&work[self.lower.rows[place] as usize]);
            }
            work[column] = value;
        }
        for (value, &new) in z.iter_mut().zip(&self.numbering.new) {
            *value = work[new as usize];
        }
    }
}

/// (F Fᵀ)^½ and (Fᵀ F)^½ = V Σ Vᵀ for F of norm one: V and Σ² from the eigen-system of Fᵀ F, and U Σ Uᵀ = F (V Σ⁻¹ Vᵀ)
/// Fᵀ. Singular values below 1e-8 are lost in the squaring; they are left out, and 1e-8 of the norm is added to both
/// roots for them.
fn roots(f: &Mat3) -> (Mat3, Mat3) {
    let eigen = f.tr_mul(f).symmetric_eigen();
    let (mut right, mut inner) = (Mat3::zeros(), Mat3::zeros());
    for k in 0..3 {
        let (value, v) = (eigen.eigenvalues[k], eigen.eigenvectors.column(k));
        if value > 1e-16 {
            let outer = v * v.transpose();
            right += outer * value.sqrt();
            inner += outer / value.sqrt();
        }
    }
    let rest = Mat3::identity() * 1e-8;
    (f * inner * f.transpose() + rest, right + rest)
}

/// The inverse of a pivot block through its Cholesky factor; `None` if a pivot falls below its share of the
/// diagonal of `reference`.
pub(super) fn inverse_of_pivot(pivot: &Mat3, reference: &Mat3) -> Option<Mat3> {
    let mut l = [[0.0; 3]; 3];
    for j in 0..3 {
        let reduced = pivot[(j, j)] - (0..j).map(|k| l[j][k] * l[j][k]).sum::<f64>();
        if !(reduced > SMALLEST_PIVOT * reference[(j, j)] && reduced > 0.0 && reduced.is_finite()) {
            return None;
        }
        l[j][j] = reduced.sqrt();
        for i in j + 1..3 {
            l[i][j] = (pivot[(i, j)] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>()) / l[j][j];
        }
    }
    let (a, b, c) = (1.0 / l[0][0], 1.0 / l[1][1], 1.0 / l[2][2]);
    let d = -l[1][0] * a * b;
    let e = -l[2][1] * b * c;
    let f = -(l[2][0] * a + l[2][1] * d) * c;
    // Rows of L⁻¹; the inverse is L⁻ᵀ L⁻¹.
    let inverse = Mat3::new(a, 0.0, 0.0, d, b, 0.0, f, e, c);
    Some(inverse.tr_mul(&inverse))
}
