//! Every law against its energy, its equations, and what is known of it from elsewhere.

#![allow(clippy::unwrap_used, reason = "tests")]

mod elasticity;
mod flow;
mod fluid;
mod hard;
mod lanes;
mod materials;
mod refusals;
mod rotation;
mod sample;
