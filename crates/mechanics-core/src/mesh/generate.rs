//! Meshes of simple shapes, for tests, scenes and examples.
//!
//! All volumes come out positive, all closed surfaces with outward normals, all numbering in a stated order.

mod ball;
mod block;
mod cylinder;
mod line;
mod sheet;
mod torus;

pub use ball::{ball, sphere};
pub use block::{BoxSplit, block};
pub use cylinder::{CylinderEnds, cylinder, cylinder_surface};
pub use line::{PolylineEnds, polyline, rod};
pub use sheet::{Diagonals, height_field, sheet};
pub use torus::torus;

use super::error::MeshError;

/// Refuses zero counts, and counts so large that 32-bit indices could not number the result: `estimate` is the
/// product that bounds the number of points and cells, times `factor`.
fn check_counts(parameter: &'static str, counts: &[u32], factor: u64) -> Result<(), MeshError> {
    if counts.contains(&0) {
        return Err(MeshError::BadParameter { parameter, value: 0.0, expected: "at least 1" });
    }
    // (n + 1) points for n cells along a side.
    let product = counts.iter().fold(factor, |p, &n| p.saturating_mul(u64::from(n) + 1));
    if product > u64::from(u32::MAX) { Err(MeshError::TooLarge { count: product }) } else { Ok(()) }
}
