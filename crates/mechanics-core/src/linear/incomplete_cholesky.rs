use super::elimination::{LowerTriangle, Numbering, Reading};
use super::error::LinearError;
use crate::sparse::{BlockMatrix, BlockPattern};
use crate::tensor::{Mat3, Vec3};

/// A pivot smaller than this fraction of the matrix's diagonal entry counts as lost.
const SMALLEST_PIVOT: f64 = 1e-10;

/// Shifts tried one after the other, as fractions of the diagonal blocks.
const SHIFTS: [f64; 8] = [0.0, 1e-3, 4e-3, 1.6e-2, 6.4e-2, 0.25, 1.0, 4.0];

/// Block incomplete Cholesky without fill: M = L D Lᵀ ≈ A, where L is unit lower triangular and has blocks only
/// where A has.
///
/// Column by column, with U the current values of A below the pivot block Dₖ: Lᵢₖ = Uᵢₖ Dₖ⁻¹, and every *stored*
/// block of the remaining triangle loses Lᵢₖ Uⱼₖᵀ; the rest of the update is dropped. Dropping can make a pivot
/// indefinite although A is positive definite. Then the factorisation starts again with A + α blockdiag(A), α from
/// 1e-3 to 4 (Manteuffel 1980): a shift relative to the own block of each node, so that a stiff contact does not
/// drown the soft nodes beside it.
///
/// # Reference
/// J. A. Meijerink, H. A. van der Vorst, Math. Comp. 31 (1977); T. A. Manteuffel, An incomplete factorization
/// technique for positive definite linear systems, Math. Comp. 34 (1980).
#[derive(Debug)]
pub(super) struct IncompleteCholesky {
    lower: LowerTriangle,
    numbering: Numbering,
    blocks: Vec<Mat3>,
    pivot_inverses: Vec<Mat3>,
    /// The shift that worked, and how many did not.
    pub(super) shift: f64,
    pub(super) failed_shifts: usize,
}

impl IncompleteCholesky {
    /// The structure for a pattern; no numbers yet.
    pub(super) fn new(pattern: &BlockPattern, numbering: Numbering) -> Self {
        let lower = LowerTriangle::renumbered(pattern, &numbering);
        let blocks = vec![Mat3::zeros(); lower.rows.len()];
        let pivot_inverses = vec![Mat3::zeros(); pattern.columns()];
        Self { lower, numbering, blocks, pivot_inverses, shift: 0.0, failed_shifts: 0 }
    }

    /// Factors, with the smallest of the shifts that keeps every pivot block positive definite.
    pub(super) fn factor(&mut self, matrix: &BlockMatrix) -> Result<(), LinearError> {
        let mut lost = 0;
        for (attempt, &shift) in SHIFTS.iter().enumerate() {
            match self.factor_shifted(matrix, shift) {
                Ok(()) => {
                    self.shift = shift;
                    self.failed_shifts = attempt;
                    return Ok(());
                }
                Err(column) => lost = self.numbering.old[column] as usize,
            }
        }
        Err(LinearError::PreconditionerBreakdown { block: lost, shift: SHIFTS[SHIFTS.len() - 1] })
    }

    /// One attempt; the column whose pivot is lost on failure.
    fn factor_shifted(&mut self, matrix: &BlockMatrix, shift: f64) -> Result<(), usize> {
        self.load(matrix);
        let mut updates = Vec::new();
        for column in 0..self.lower.columns() {
            let range = self.lower.column(column);
            let diagonal = matrix.diagonal(self.numbering.old[column] as usize);
            let pivot = self.blocks[range.start] + diagonal * shift;
            let inverse = inverse_of_pivot(&pivot, diagonal).ok_or(column)?;
            self.pivot_inverses[column] = inverse;
            updates.clear();
            for place in range.start + 1..range.end {
                let current = self.blocks[place];
                self.blocks[place] = current * inverse;
                updates.push((self.lower.rows[place], self.blocks[place], current.transpose()));
            }
            self.subtract_outer_products(&updates);
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
    fn subtract_outer_products(&mut self, updates: &[(u32, Mat3, Mat3)]) {
        for (first, (column, _, upper)) in updates.iter().enumerate() {
            let range = self.lower.column(*column as usize);
            let mut place = range.start;
            for (row, lower, _) in &updates[first..] {
                while place < range.end && self.lower.rows[place] < *row {
                    place += 1;
                }
                if place == range.end {
                    break;
                }
                if self.lower.rows[place] == *row {
                    self.blocks[place] -= lower * upper;
                }
            }
        }
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
