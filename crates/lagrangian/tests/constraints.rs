//! Holonomic constraints against high-precision trajectories, conservation laws and unconstrained twins.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "constraints/accuracy.rs"]
mod accuracy;
#[path = "constraints/chain.rs"]
mod chain;
#[path = "constraints/faults.rs"]
mod faults;
#[path = "constraints/fixture.rs"]
mod fixture;
#[path = "constraints/long.rs"]
mod long;
#[path = "variational/lying.rs"]
mod lying;
#[path = "constraints/pointwise.rs"]
mod pointwise;
#[path = "constraints/refusals.rs"]
mod refusals;
#[path = "constraints/rigid.rs"]
mod rigid;
#[path = "constraints/systems.rs"]
mod systems;
