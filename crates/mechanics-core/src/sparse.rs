//! Symmetric sparse matrices of 3×3 blocks, the form every Hessian of this workspace takes.

mod block_matrix;

pub use block_matrix::{BlockMatrix, BlockPattern, PatternError};
