//! Explicit integrators and the driver, against high-precision trajectories, closed forms and conservation laws.

#![allow(clippy::unwrap_used)]
#![allow(clippy::print_stdout, reason = "tests show their figures when they fail")]

#[path = "explicit/adaptive.rs"]
mod adaptive;
#[path = "explicit/events.rs"]
mod events;
#[path = "explicit/fixed_step.rs"]
mod fixed_step;
#[path = "explicit/multistep.rs"]
mod multistep;
#[path = "explicit/refusals.rs"]
mod refusals;
#[path = "explicit/symplectic.rs"]
mod symplectic;
#[path = "explicit/systems.rs"]
mod systems;
