//! Elastic solids: the laws of [`mechanics_core::law`] as laws of material points.
//!
//! Energies are those of the core; stresses are written as Kirchhoff stresses, which are shorter than P Fᵀ and need no more
//! of F than each law must have: nothing (neo-Hookean), its rotation (fixed corotated), its singular values (Hencky).

mod neo_hookean;

pub use neo_hookean::NeoHookean;
