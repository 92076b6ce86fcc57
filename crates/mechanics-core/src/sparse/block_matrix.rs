use crate::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// Which 3×3 blocks of a symmetric matrix are stored: the lower triangle, by block columns.
///
/// Invariants: `columns() + 1` non-decreasing starts; within a column the rows ascend strictly; the first row of
/// every column is its diagonal, which is always present.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockPattern {
    column_start: Vec<usize>,
    rows: Vec<u32>,
}

/// Why arrays do not describe a [`BlockPattern`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PatternError {
    /// Starts must begin at zero, never decrease, and end at the number of rows.
    #[error("block column {column} starts at {start}, which is out of order or beyond the {rows} rows given")]
    Start {
        /// The block column.
        column: usize,
        /// Its start.
        start: usize,
        /// How many row indices there are.
        rows: usize,
    },
    /// The first row of a column is its diagonal.
    #[error("block column {column} does not begin with its diagonal block")]
    NoDiagonal {
        /// The block column.
        column: usize,
    },
    /// Rows ascend strictly and stay below the number of columns.
    #[error("block column {column} lists row {row}, which is out of order or out of range")]
    Row {
        /// The block column.
        column: usize,
        /// The offending row.
        row: u32,
    },
}

impl BlockPattern {
    /// A pattern from its arrays.
    ///
    /// # Errors
    /// [`PatternError`] names the first column that breaks an invariant.
    pub fn new(column_start: Vec<usize>, rows: Vec<u32>) -> Result<Self, PatternError> {
        let columns = column_start.len().saturating_sub(1);
        let start_error = |column| PatternError::Start {
            column,
            start: column_start.get(column).copied().unwrap_or(0),
            rows: rows.len(),
        };
        if column_start.first() != Some(&0) {
            return Err(start_error(0));
        }
        if column_start[columns] != rows.len() {
            return Err(start_error(columns));
        }
        for column in 0..columns {
            let (start, end) = (column_start[column], column_start[column + 1]);
            if start > end || end > rows.len() {
                return Err(start_error(column + 1));
            }
            let listed = &rows[start..end];
            if listed.first().copied() != u32::try_from(column).ok() {
                return Err(PatternError::NoDiagonal { column });
            }
            let disorder = listed.windows(2).find(|pair| pair[0] >= pair[1]).map(|pair| pair[1]);
            let beyond = listed.iter().copied().find(|&row| row as usize >= columns);
            if let Some(row) = disorder.or(beyond) {
                return Err(PatternError::Row { column, row });
            }
        }
        Ok(Self { column_start, rows })
    }

    /// The number of block columns (and block rows).
    pub fn columns(&self) -> usize {
        self.column_start.len() - 1
    }

    /// The number of stored blocks.
    pub fn block_count(&self) -> usize {
        self.rows.len()
    }

    /// Where each column's blocks start; one more entry than there are columns.
    pub fn column_start(&self) -> &[usize] {
        &self.column_start
    }

    /// The block row of every stored block, column after column.
    pub fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// The slots of one column.
    pub fn column(&self, column: usize) -> std::ops::Range<usize> {
        self.column_start[column]..self.column_start[column + 1]
    }

    /// The slot that stores the block of row `row` and column `column`, `row ≥ column`.
    pub fn slot(&self, row: usize, column: usize) -> Option<usize> {
        let range = self.column(column);
        let row = u32::try_from(row).ok()?;
        self.rows[range.clone()].binary_search(&row).ok().map(|k| range.start + k)
    }
}

/// A symmetric matrix of 3×3 blocks: the lower triangle, in the order of its [`BlockPattern`].
///
/// Off-diagonal blocks stand for themselves and for their transposes above the diagonal; diagonal blocks are stored
/// whole and are symmetric.
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    pattern: Arc<BlockPattern>,
    values: Vec<Mat3>,
}

impl BlockMatrix {
    /// The zero matrix on a pattern.
    pub fn zeros(pattern: Arc<BlockPattern>) -> Self {
        let values = vec![Mat3::zeros(); pattern.block_count()];
        Self { pattern, values }
    }

    /// A matrix from its blocks, in the order of the pattern.
    ///
    /// # Panics
    /// If the number of blocks is not the pattern's.
    pub fn from_blocks(pattern: Arc<BlockPattern>, values: Vec<Mat3>) -> Self {
        assert_eq!(values.len(), pattern.block_count(), "one block per slot of the pattern");
        Self { pattern, values }
    }

    /// Where the blocks are.
    pub fn pattern(&self) -> &Arc<BlockPattern> {
        &self.pattern
    }

    /// The number of scalar rows: three for each block column.
    pub fn dimension(&self) -> usize {
        3 * self.pattern.columns()
    }

    /// The blocks, in the order of the pattern.
    pub fn blocks(&self) -> &[Mat3] {
        &self.values
    }

    /// The blocks, taken out, so that their memory can be used again.
    pub fn into_blocks(self) -> Vec<Mat3> {
        self.values
    }

    /// The blocks, to be overwritten.
    pub fn blocks_mut(&mut self) -> &mut [Mat3] {
        &mut self.values
    }

    /// The diagonal block of a column.
    pub fn diagonal(&self, column: usize) -> &Mat3 {
        &self.values[self.pattern.column_start()[column]]
    }

    /// `y = A x` for one 3-vector per block column.
    ///
    /// # Panics
    /// If a length is not the number of block columns.
    pub fn multiply_into(&self, x: &[Vec3], y: &mut [Vec3]) {
        let columns = self.pattern.columns();
        assert_eq!(x.len(), columns, "one 3-vector of x per block column");
        assert_eq!(y.len(), columns, "one 3-vector of y per block column");
        y.fill(Vec3::zeros());
        for column in 0..columns {
            let slots = self.pattern.column(column);
            let mut own = self.values[slots.start] * x[column];
            for slot in slots.start + 1..slots.end {
                let row = self.pattern.rows[slot] as usize;
                let block = &self.values[slot];
                y[row] += block * x[column];
                own += block.tr_mul(&x[row]);
            }
            y[column] += own;
        }
    }
}
