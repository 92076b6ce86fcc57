//! Numbers, tensors, meshes, energies, sparse solvers and Newton's method: the ground that the solver crates
//! of this workspace stand on.

pub mod checkpoint;
pub mod decomposition;
pub mod derivatives;
pub mod diagnostics;
pub mod jet;
pub mod lanes;
pub mod law;
#[cfg(feature = "solvers")]
pub mod linear;
pub mod mesh;
pub mod newton;
pub mod objective;
pub mod parallel;
pub mod point_map;
pub mod potential;
pub mod projection;
pub mod scalar;
pub mod sparse;
pub mod stage;
pub mod state;
pub mod stencil;
pub mod tensor;
