//! Simulation of the physical part of a scene: what runs where a scene names no experiment.
//!
//! Equilibria of hyperelastic tetrahedra, reached in load steps, and their motion in time, with contact and friction where the
//! scene names them. [`Bodies`] are the scene's meshes and materials, `conditions` what holds and loads them,
//! [`LoadStepping`] finds one equilibrium after the other, [`Motion`] makes time steps, a [`Course`] is either,
//! and [`Recorder`] writes what can be looked at.

mod bodies;
mod checkpoint;
mod conditions;
mod contact;
mod course;
mod load_stepping;
mod motion;
mod picture;
mod recorder;

pub(crate) use bodies::Bodies;
pub(crate) use checkpoint::CheckpointFault;
pub(crate) use course::{Course, Step};
pub(crate) use load_stepping::{LoadStep, LoadStepping};
pub(crate) use motion::{Motion, TimeStep};
pub(crate) use recorder::{FILES, Recorder};

use super::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::physics::Integration;
use mechanics_core::state::StateHash;

/// The motion, or the equilibrium, of a scene's bodies.
pub(crate) struct Simulation;

impl Experiment for Simulation {
    fn methods(&self) -> &'static [&'static str] {
        &["simulation"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        Ok(simulate(at, clock)?.1)
    }
}

/// Runs a scene's physical part to its end: the last state, and what there is to say about it.
pub(crate) fn simulate(at: &Point<'_>, clock: &mut Clock) -> Result<(Course, Outcome), ExperimentError> {
    let mut course = Course::new(at.scene, at.folder)?;
    let (mut iterations, mut factorisations, mut smallest) = (0, 0, f64::INFINITY);
    while course.done() < course.steps() {
        let step = clock.time(|| course.advance())?;
        let newton = step.newton();
        iterations += newton.iterations;
        factorisations += newton.factorisations;
        smallest = smallest.min(step.smallest_volume_ratio());
        clock.add_term("assembly", newton.times.assembly);
        clock.add_term("linear solve", newton.times.solve);
    }
    let mut hash = StateHash::new();
    hash.add_vectors("position", course.positions());
    if let Some(velocities) = course.velocities() {
        hash.add_vectors("velocity", velocities);
    }
    let outcome = Outcome::default()
        .count("unknowns", course.unknowns() as u64)
        .count("Newton iterations", iterations)
        .count("factorisations", factorisations)
        .invariant("smallest det F", smallest)
        .state(hash.value());
    let outcome = outcome.pictured(at, "the last state", || Ok(picture::still(&course)))?;
    Ok((course, outcome))
}

/// The number of load steps of a scene that is to be in equilibrium.
fn load_steps(integration: Option<&Integration>) -> Result<usize, ExperimentError> {
    match integration {
        Some(Integration::Static { load_steps }) => Ok(load_steps.value()),
        Some(other) => Err(refused(format!("integration.{}", other.name()), "is no equilibrium")),
        None => Err(refused("integration", "missing")),
    }
}

/// The error of a scene that asks for something that cannot be done, by the key that asks.
fn refused(key: impl Into<String>, reason: impl std::fmt::Display) -> ExperimentError {
    ExperimentError::Refused { key: key.into(), reason: reason.to_string() }
}
