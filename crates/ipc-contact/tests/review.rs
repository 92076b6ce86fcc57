//! Attempts to get something through contact: random soups with displacements of all magnitudes, against all pairs.
#![allow(clippy::unwrap_used)]

#[path = "review/far_steps.rs"]
mod far_steps;
#[path = "review/names.rs"]
mod names;
#[path = "scenes/random.rs"]
#[allow(dead_code, reason = "shared with other tests")]
mod random;
#[path = "review/soup.rs"]
mod soup;
#[path = "review/stacked.rs"]
mod stacked;

use mechanics_core::potential::{Potential, PotentialError};
use mechanics_core::stage::{Moment, Scheme, Stage};
use mechanics_core::tensor::Vec3;

/// Tells a term where a step begins.
fn begin_step(term: &mut dyn Potential, x: &[Vec3]) -> Result<(), PotentialError> {
    freeze(term, x, Moment::Step)
}

fn freeze(term: &mut dyn Potential, x: &[Vec3], moment: Moment) -> Result<(), PotentialError> {
    term.freeze(&Stage { moment, x, time: 0.0, step: 0.0, scheme: Scheme::statics(x) }).map(drop)
}

/// x + α p.
fn along(x: &[Vec3], p: &[Vec3], part: f64) -> Vec<Vec3> {
    x.iter().zip(p).map(|(x, p)| x + p * part).collect()
}
