//! Machines that work by friction, impacts, and hard cases: grippers, tactile pads, rollers, turntables.

mod gripper;
pub(in crate::experiment) mod hand;
mod hard;
mod impact;
mod pad;
mod rollers;
mod turntable;

pub(in crate::experiment) use gripper::Gripper;
pub(in crate::experiment) use hard::{FrictionPair, HeavyOnLight, StickingPile};
pub(in crate::experiment) use impact::BallImpact;
pub(in crate::experiment) use pad::TactilePad;
pub(in crate::experiment) use rollers::Rollers;
pub(in crate::experiment) use turntable::Turntable;

use crate::experiment::ExperimentError;
use crate::experiment::contact::world::World;
use ipc_friction::FrictionOptions;
use mechanics_core::tensor::Vec3;
use std::ops::Range;

/// Friction with one coefficient for all surfaces, smoothed below `stick_velocity` (m/s).
pub(in crate::experiment) fn friction(
    coefficient: f64,
    stick_velocity: f64,
) -> Result<FrictionOptions, ExperimentError> {
    FrictionOptions::uniform(coefficient, stick_velocity).map_err(ExperimentError::stopped)
}

/// Moves scripted points by `way` (m) during the next step.
pub(in crate::experiment) fn push(
    world: &mut World,
    points: Range<u32>,
    way: Vec3,
) -> Result<(), ExperimentError> {
    for point in points {
        let target = world.state.position[point as usize] + way;
        world.move_to(point, target)?;
    }
    Ok(())
}

/// The mean of the vectors of some points, weighted by their masses.
pub(in crate::experiment) fn mass_mean(world: &World, points: Range<u32>, vectors: &[Vec3]) -> Vec3 {
    let masses = world.stepper.mass().diagonal();
    let range = points.start as usize..points.end as usize;
    let sum: Vec3 = range.clone().map(|i| vectors[i] * masses[i]).sum();
    sum / range.map(|i| masses[i]).sum::<f64>()
}
