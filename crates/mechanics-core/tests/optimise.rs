//! The seams around the minimiser: stencils, point maps, assembly, objectives, Newton's method, derivative checks.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]

#[path = "optimise/assembly.rs"]
mod assembly;
#[path = "optimise/derivatives.rs"]
mod derivatives;
#[path = "optimise/faults.rs"]
mod faults;
#[path = "optimise/incremental.rs"]
mod incremental;
#[path = "optimise/lying.rs"]
mod lying;
#[path = "optimise/newton.rs"]
mod newton;
#[path = "optimise/point_map.rs"]
mod point_map;
#[path = "optimise/samples.rs"]
mod samples;
#[path = "optimise/terms.rs"]
mod terms;
