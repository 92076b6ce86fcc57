//! Thin bodies: membranes, hinges, rods, strain limits.

#![allow(clippy::unwrap_used)]

#[path = "thin/derivatives.rs"]
mod derivatives;
#[path = "thin/samples.rs"]
mod samples;
#[path = "thin/sheets.rs"]
mod sheets;
