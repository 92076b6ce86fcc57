//! Twist of rods: derivatives, frames, moments, writhe, and the loads at which twisted rods and rings buckle.

#![cfg(feature = "bodies")]
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "rod_twist/buckling.rs"]
mod buckling;
#[path = "rod_twist/derivatives.rs"]
mod derivatives;
#[path = "rod_twist/motion.rs"]
mod motion;
#[path = "rod_twist/samples.rs"]
mod samples;
#[path = "rod_twist/statics.rs"]
mod statics;
