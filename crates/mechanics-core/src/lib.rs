#![doc = include_str!("../README.md")]
//!
//! # Where to go next
//! To write an energy: [`stencil`], then [`potential`]; to minimise it: [`newton`] over an [`objective`]; a material: [`law`]; numbers and their derivatives: [`scalar`], [`jet`], [`lanes`].
//! The examples `hanging_chain`, `one_formula_three_ways`, `bunny_quality` and `resume` begin there. Formulas with the places where they are in the code: `docs/theory/mechanics-core.md` of the repository.
//!
//! # What this crate does not do
//!
//! It has no elements, no contact, no grids and no time-stepper: those crates depend on this one. It does not print, and
//! reads and writes files in [`checkpoint`] and `mesh::io` only. It has no GPU code, no distributed memory, and no
//! nonsymmetric or indefinite sparse solvers: what it minimises has a symmetric Hessian that is made positive definite.

pub mod checkpoint;
mod checksum;
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
pub mod samples;
pub mod scalar;
pub mod sparse;
pub mod stage;
pub mod state;
pub mod stencil;
pub mod tensor;
