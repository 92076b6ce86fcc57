//! Thin bodies: membranes, hinges, rods, strain limits.

#![allow(clippy::unwrap_used)]

#[path = "thin/bodies.rs"]
mod bodies;
#[path = "thin/derivatives.rs"]
mod derivatives;
#[path = "thin/samples.rs"]
mod samples;
#[path = "thin/sheets.rs"]
mod sheets;
#[path = "thin/statics.rs"]
mod statics;
