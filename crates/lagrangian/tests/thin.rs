//! Thin bodies: membranes, hinges, rods, strain limits.

#![cfg(feature = "bodies")]
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "thin/bodies.rs"]
mod bodies;
#[path = "thin/derivatives.rs"]
mod derivatives;
#[path = "thin/motion.rs"]
mod motion;
#[path = "thin/samples.rs"]
mod samples;
#[path = "thin/sheets.rs"]
mod sheets;
#[path = "thin/statics.rs"]
mod statics;
