//! Pictures of deformed solids.

use super::solid::Solid;
use crate::experiment::contact::portrait::captioned;
use crate::experiment::{ExperimentError, Outcome, Point};
use mechanics_core::tensor::Vec3;

/// `outcome` with a picture of `solid` with its nodes at `x`, coloured by displacement, if pictures are wanted.
pub(super) fn pictured(
    outcome: Outcome,
    at: &Point<'_>,
    solid: &Solid,
    x: &[Vec3],
    caption: &str,
) -> Result<Outcome, ExperimentError> {
    let displacements = x.iter().zip(&solid.points).map(|(x, rest)| (x - rest).norm()).collect();
    captioned(outcome, at, x, &solid.skin(), ("displacement", "m", displacements), caption)
}
