//! Derivatives of a Lagrangian, and which arguments it mentions.

#![allow(clippy::unwrap_used)]

#[path = "derivatives/dependence.rs"]
mod dependence;
#[path = "derivatives/systems.rs"]
mod systems;
