//! Implicit and variational integrators: order, structure, long runs, hard inputs.
#![allow(clippy::unwrap_used)]

#[path = "variational/dissipative.rs"]
mod dissipative;
#[path = "variational/faults.rs"]
mod faults;
#[path = "variational/hard_inputs.rs"]
mod hard_inputs;
#[path = "variational/long_runs.rs"]
mod long_runs;
#[path = "variational/lying.rs"]
mod lying;
#[path = "variational/orders.rs"]
mod orders;
#[path = "variational/rounding.rs"]
mod rounding;
#[path = "variational/structure.rs"]
mod structure;
#[path = "variational/systems.rs"]
mod systems;
