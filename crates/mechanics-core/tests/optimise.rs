//! The seams around the minimiser: stencils, point maps, assembly, objectives, Newton's method, derivative checks.

#[path = "optimise/assembly.rs"]
mod assembly;
#[path = "optimise/derivatives.rs"]
mod derivatives;
#[path = "optimise/incremental.rs"]
mod incremental;
#[path = "optimise/newton.rs"]
mod newton;
#[path = "optimise/point_map.rs"]
mod point_map;
#[path = "optimise/samples.rs"]
mod samples;
#[path = "optimise/terms.rs"]
mod terms;
