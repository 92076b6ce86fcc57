//! Symmetric sparse matrices of 3×3 blocks, the form every Hessian of this workspace takes, and their assembly
//! from element Hessians.

mod assembly;
mod block_matrix;
mod scatter;

pub use assembly::{Assembler, Assembly, AssemblyCounts};
pub use block_matrix::{BlockMatrix, BlockPattern, PatternError};
pub(crate) use scatter::{Contributions, Scatter, Scattered, Slots};
