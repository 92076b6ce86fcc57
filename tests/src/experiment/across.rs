//! Experiments that no crate can make alone: the same body by two of them, or one that takes what another gives.

mod gripped_splats;
mod pendulum_bar;
mod swing;

pub(super) use gripped_splats::GrippedSplats;
pub(super) use pendulum_bar::PendulumBar;
