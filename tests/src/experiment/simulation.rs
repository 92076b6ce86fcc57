//! Simulation of the physical part of a scene: what runs where a scene names no experiment.
//!
//! Now: equilibria of hyperelastic tetrahedra, reached in load steps. [`Bodies`] are the scene's meshes and materials,
//! [`Conditions`] what holds and loads them, [`LoadStepping`] finds one equilibrium after the other, and [`Recorder`]
//! writes what can be looked at.

mod bodies;
mod checkpoint;
mod conditions;
mod load_stepping;
mod picture;
mod recorder;

pub(crate) use bodies::Bodies;
pub(crate) use checkpoint::CheckpointFault;
pub(crate) use load_stepping::{LoadStep, LoadStepping};
pub(crate) use recorder::{FILES, Recorder};

use super::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::record;
use crate::scene::physics::Integration;
use mechanics_core::state::StateHash;
use std::path::PathBuf;

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
pub(crate) fn simulate(
    at: &Point<'_>,
    clock: &mut Clock,
) -> Result<(LoadStepping, Outcome), ExperimentError> {
    let mut stepping = LoadStepping::new(at.scene, at.folder)?;
    let (mut iterations, mut factorisations, mut smallest) = (0, 0, f64::INFINITY);
    while stepping.done() < stepping.load_steps() {
        let step = clock.time(|| stepping.advance())?;
        iterations += step.report.iterations;
        factorisations += step.report.factorisations;
        smallest = smallest.min(step.smallest_volume_ratio);
        clock.add_term("assembly", step.report.times.assembly);
        clock.add_term("linear solve", step.report.times.solve);
    }
    let mut hash = StateHash::new();
    hash.add_vectors("position", stepping.positions());
    let mut outcome = Outcome::default()
        .count("unknowns", stepping.unknowns() as u64)
        .count("Newton iterations", iterations)
        .count("factorisations", factorisations)
        .invariant("smallest det F", smallest)
        .state(hash.value());
    if let Some((folder, stem)) = at.frames {
        let path = PathBuf::from(format!("{stem}.png"));
        picture::still(stepping.bodies(), stepping.positions())
            .save_png(&folder.join(&path))
            .map_err(ExperimentError::stopped)?;
        let path = path.to_string_lossy().into_owned();
        outcome.pictures.push(record::Picture { path, caption: "the last equilibrium".to_owned() });
    }
    Ok((stepping, outcome))
}

/// A scene's number of load steps; what moves in time is refused.
fn load_steps(integration: Option<&Integration>) -> Result<usize, ExperimentError> {
    match integration {
        Some(Integration::Static { load_steps }) => Ok(load_steps.value()),
        Some(other) => Err(refused(
            format!("integration.{}", other.name()),
            "motion in time is not available yet; available: `static`",
        )),
        None => Err(refused("integration", "missing; `static` is available")),
    }
}

/// The error of a scene that asks for something that cannot be done, by the key that asks.
fn refused(key: impl Into<String>, reason: impl std::fmt::Display) -> ExperimentError {
    ExperimentError::Refused { key: key.into(), reason: reason.to_string() }
}
