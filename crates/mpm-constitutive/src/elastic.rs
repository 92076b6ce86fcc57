//! Elastic solids: the laws of [`mechanics_core::law`] as laws of material points.
//!
//! Energies are those of the core. Stresses are written as Kirchhoff stresses, which are shorter than P Fᵀ and ask no more
//! of F than each law must have: nothing (neo-Hookean, linear), its rotation (fixed corotated), its singular values (Hencky). Through
//! jets all of them carry first derivatives of the stress.

mod fixed_corotated;
mod hencky;
mod linear;
mod neo_hookean;
mod rotation;

pub use fixed_corotated::FixedCorotated;
pub use hencky::Hencky;
pub use linear::Linear;
pub use neo_hookean::NeoHookean;
pub use rotation::nearest_rotation;

pub(crate) use fixed_corotated::corotated_stiffness;
pub(crate) use rotation::select;
