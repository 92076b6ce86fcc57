//! Checkpoints of load stepping: positions and the number of load steps made.

use super::LoadStepping;
use crate::scene::SceneFile;
use mechanics_core::checkpoint::{Checkpoint, CheckpointError};
use mechanics_core::tensor::Vec3;
use std::path::{Path, PathBuf};

/// A checkpoint that cannot be written or does not fit.
#[derive(Debug, thiserror::Error)]
#[error("checkpoint {}: {source}", path.display())]
pub(crate) struct CheckpointFault {
    path: PathBuf,
    source: CheckpointError,
}

impl LoadStepping {
    /// Writes the state to `path`, whole or not at all.
    pub(crate) fn write_checkpoint(&self, scene: &SceneFile, path: &Path) -> Result<(), CheckpointFault> {
        let mut checkpoint = Checkpoint::new();
        checkpoint.put_text("problem", &problem(scene));
        checkpoint.put_one("load steps done", self.done() as u64);
        let coordinates: Vec<f64> = self.positions().iter().flatten().copied().collect();
        checkpoint.put("positions", &coordinates);
        checkpoint.write(path).map_err(|source| CheckpointFault { path: path.to_owned(), source })
    }

    /// Takes over the state at `path`, which must be of the same problem; solver and output may differ.
    pub(crate) fn read_checkpoint(&mut self, scene: &SceneFile, path: &Path) -> Result<(), CheckpointFault> {
        let read = || -> Result<(u64, Vec<f64>), CheckpointError> {
            let mut checkpoint = Checkpoint::read(path)?;
            checkpoint.take_matching_text("problem", &problem(scene))?;
            let done = checkpoint.take_one("load steps done")?;
            let mut coordinates = vec![0.0; 3 * self.positions().len()];
            checkpoint.take_into("positions", &mut coordinates)?;
            checkpoint.finish()?;
            Ok((done, coordinates))
        };
        let (done, coordinates) =
            read().map_err(|source| CheckpointFault { path: path.to_owned(), source })?;
        self.resume(done as usize, coordinates.chunks_exact(3).map(Vec3::from_column_slice).collect());
        Ok(())
    }
}

/// What must be equal for a state to be one of the same problem.
fn problem(scene: &SceneFile) -> String {
    let SceneFile { meshes, materials, initial, boundary, loads, integration, .. } = scene;
    format!("{meshes:?} {materials:?} {initial:?} {boundary:?} {loads:?} {integration:?}")
}
