//! Hard states of contact: gaps far below any tolerance, positions far out, energies beyond a number, runs that are interrupted.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]

#[path = "hard/squeezed.rs"]
mod squeezed;

