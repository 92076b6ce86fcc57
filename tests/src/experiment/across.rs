//! Experiments that no crate can make alone: the same body by two of them, or one that takes what another gives.

mod pendulum_bar;
mod swing;

pub(super) use pendulum_bar::PendulumBar;
