//! What a particle has in memory.

use super::Simulation;
use mechanics_core::lanes::Element;

/// How many numbers a particle of a body has, by what they are: each takes the bytes of the simulation's precision. A law pays for what it
/// needs and for nothing else; an elastic one has no history and keeps no stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParticleNumbers {
    /// Position, velocity, and its gradient or affine part: D + D + D².
    pub motion: usize,
    /// Of the law's strain: nine for F, one for J.
    pub strain: usize,
    /// Of the law's history of plastic flow.
    pub history: usize,
    /// Stress and stiffness that a return map has found, kept to the next step.
    pub kept_stress: usize,
    /// Mass and rest volume.
    pub mass_and_volume: usize,
    /// Of the total deformation gradient, where it is [tracked](Simulation::add_tracked_body) beside the strain.
    pub total_deformation: usize,
}

impl ParticleNumbers {
    /// All of them.
    pub fn count(&self) -> usize {
        let Self { motion, strain, history, kept_stress, mass_and_volume, total_deformation } = self;
        motion + strain + history + kept_stress + mass_and_volume + total_deformation
    }
}

impl<E: Element, const D: usize> Simulation<E, D> {
    /// Which numbers the particles of a body have.
    ///
    /// # Panics
    /// If there is no such body.
    pub fn particle_numbers(&self, body: usize) -> ParticleNumbers {
        let layout = self.bodies[body].particles.layout;
        ParticleNumbers {
            motion: layout.strain,
            strain: layout.history - layout.strain,
            history: layout.stress - layout.history,
            kept_stress: layout.mass - layout.stress,
            mass_and_volume: layout.total - layout.mass,
            total_deformation: layout.count - layout.total,
        }
    }
}
