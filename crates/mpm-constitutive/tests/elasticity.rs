//! Energies, stresses, stiffness bounds, the fluid, the fast rotation, and what is refused.

#![allow(clippy::unwrap_used, reason = "tests")]

#[path = "laws/curvature.rs"]
mod curvature;
#[path = "laws/derivatives.rs"]
mod derivatives;
#[path = "laws/fluid.rs"]
mod fluid;
#[path = "laws/materials.rs"]
mod materials;
#[path = "laws/refusals.rs"]
mod refusals;
#[path = "laws/rotation.rs"]
mod rotation;
#[path = "laws/sample.rs"]
mod sample;
