//! Derivatives of a Lagrangian, and which arguments it mentions.

#![allow(clippy::unwrap_used)]

#[path = "derivatives/acceleration.rs"]
mod acceleration;
#[path = "derivatives/agreement.rs"]
mod agreement;
#[path = "derivatives/dependence.rs"]
mod dependence;
#[path = "derivatives/oracle.rs"]
mod oracle;
#[path = "derivatives/sliced.rs"]
mod sliced;
#[path = "derivatives/systems.rs"]
mod systems;
