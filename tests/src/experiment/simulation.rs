//! Simulation of the physical part of a scene: what runs where a scene names no experiment.

use super::{Clock, Experiment, ExperimentError, Outcome, Point};

/// The motion, or the equilibrium, of a scene's bodies.
pub(crate) struct Simulation;

impl Experiment for Simulation {
    fn methods(&self) -> &'static [&'static str] {
        &["simulation"]
    }

    fn run(&self, at: &Point<'_>, _clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let feature = at.scene.integration.as_ref().map_or("static", |integration| integration.name());
        Err(ExperimentError::NotAvailable { feature: format!("integration.{feature}"), available: "none" })
    }
}
