//! Checkpoints of a run: what its next steps depend on.

use super::course::{Course, Kind};
use super::{LoadStepping, Motion};
use crate::experiment::contact::term::ContactTerm;
use crate::scene::SceneFile;
use ipc_contact::ContactError;
use ipc_contact::stiffness::SavedStiffness;
use mechanics_core::checkpoint::{Checkpoint, CheckpointError};
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use std::path::{Path, PathBuf};

/// A checkpoint that cannot be written or does not fit.
#[derive(Debug, thiserror::Error)]
#[error("checkpoint {}: {source}", path.display())]
pub(crate) struct CheckpointFault {
    path: PathBuf,
    source: Misfit,
}

/// What is wrong with it.
#[derive(Debug, thiserror::Error)]
enum Misfit {
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    #[error(transparent)]
    Contact(#[from] ContactError),
}

impl Course {
    /// Writes the state to `path`, whole or not at all.
    pub(crate) fn write_checkpoint(&self, scene: &SceneFile, path: &Path) -> Result<(), CheckpointFault> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.put_text("problem", &problem(scene));
        match &self.kind {
            Kind::Equilibria(stepping) => stepping.save(&mut checkpoint),
            Kind::Motion(motion) => motion.save(&mut checkpoint),
        }
        let fault =
            |source: CheckpointError| CheckpointFault { path: path.to_owned(), source: source.into() };
        checkpoint.write(path).map_err(fault)
    }

    /// Takes over the state at `path`, which must be of the same problem; solver and output may differ.
    pub(crate) fn read_checkpoint(&mut self, scene: &SceneFile, path: &Path) -> Result<(), CheckpointFault> {
        let mut read = || -> Result<(), Misfit> {
            let mut checkpoint = Checkpoint::read(path)?;
            checkpoint.take_matching_text("problem", &problem(scene))?;
            match &mut self.kind {
                Kind::Equilibria(stepping) => stepping.load(checkpoint),
                Kind::Motion(motion) => motion.load(checkpoint),
            }
        };
        read().map_err(|source| CheckpointFault { path: path.to_owned(), source })
    }
}

impl LoadStepping {
    fn save(&self, checkpoint: &mut Checkpoint) {
        checkpoint.put_one("load steps done", self.done() as u64);
        let coordinates: Vec<f64> = self.positions().iter().flatten().copied().collect();
        checkpoint.put("positions", &coordinates);
    }

    fn load(&mut self, mut checkpoint: Checkpoint) -> Result<(), Misfit> {
        let done: u64 = checkpoint.take_one("load steps done")?;
        let mut coordinates = vec![0.0; 3 * self.positions().len()];
        checkpoint.take_into("positions", &mut coordinates)?;
        checkpoint.finish()?;
        self.resume(done as usize, coordinates.chunks_exact(3).map(Vec3::from_column_slice).collect());
        Ok(())
    }
}

impl Motion {
    fn save(&self, checkpoint: &mut Checkpoint) {
        self.state.save(checkpoint, "state");
        if let Some(contact) = &self.contact {
            let SavedStiffness { kappa, largest } = contact.saved_stiffness(&self.state.position);
            checkpoint.put("stiffness of contact", &[kappa, largest]);
        }
    }

    fn load(&mut self, mut checkpoint: Checkpoint) -> Result<(), Misfit> {
        checkpoint.require_length::<Vec3>("state/position", self.state.point_count())?;
        let state = State::load(&mut checkpoint, "state")?;
        if let Some(contact) = &mut self.contact {
            let mut saved = [0.0; 2];
            checkpoint.take_into("stiffness of contact", &mut saved)?;
            let stiffness = SavedStiffness { kappa: saved[0], largest: saved[1] };
            match contact {
                ContactTerm::Frictionless(contact) => contact.resume_stiffness(stiffness)?,
                ContactTerm::WithFriction(both) => both.contact_mut().resume_stiffness(stiffness)?,
            }
        }
        checkpoint.finish()?;
        self.state = state;
        Ok(())
    }
}

/// What must be equal for a state to be one of the same problem.
fn problem(scene: &SceneFile) -> String {
    let SceneFile { meshes, materials, initial, boundary, loads, contact, integration, .. } = scene;
    format!("{meshes:?} {materials:?} {initial:?} {boundary:?} {loads:?} {contact:?} {integration:?}")
}
