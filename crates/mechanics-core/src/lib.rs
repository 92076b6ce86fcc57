#![doc = include_str!("../README.md")]
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
