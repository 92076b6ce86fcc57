//! The output folder of a run: it appears whole or not at all, and replaces only what a run has written.

use super::super::CliError;
use crate::experiment::simulation::FILES;
use crate::report::WriteError;
use crate::runner::output;
use std::path::{Path, PathBuf};

/// Refuses to replace a folder with files that no run has written.
pub(super) fn check_replaceable(folder: &Path) -> Result<(), CliError> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for entry in entries.flatten() {
        let name = entry.file_name();
        if !FILES.iter().any(|file| name == *file) {
            return Err(CliError::Occupied { folder: folder.to_owned(), file: name.into() });
        }
    }
    Ok(())
}

/// A folder beside the output folder that becomes it, or is removed.
pub(super) struct Draft {
    pub(super) path: PathBuf,
}

impl Draft {
    pub(super) fn new(folder: &Path) -> Result<Self, CliError> {
        let path = beside(folder, &format!(".part.{}", std::process::id()));
        // A killed process of the same number may have left one, and its frames are no part of this run.
        match std::fs::remove_dir_all(&path) {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
                return Err(output::OutputError::from(WriteError { path, source }).into());
            }
            _ => output::make_folder(&path)?,
        }
        Ok(Self { path })
    }

    pub(super) fn publish(self, folder: &Path) -> Result<(), CliError> {
        let replace = || {
            if folder.exists() {
                let old = beside(folder, &format!(".old.{}", std::process::id()));
                std::fs::rename(folder, &old)?;
                std::fs::rename(&self.path, folder).inspect_err(|_| {
                    // The first error is the one worth telling.
                    let _ = std::fs::rename(&old, folder);
                })?;
                return std::fs::remove_dir_all(&old);
            }
            std::fs::rename(&self.path, folder)
        };
        replace().map_err(|source| {
            output::OutputError::from(WriteError { path: folder.to_owned(), source }).into()
        })
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // After `publish` it is not there any more.
        let _ = std::fs::remove_dir_all(&self.path);
    }
}

/// Checkpoints stand beside the output folder, so that they outlive a run that fails.
pub(super) fn checkpoint_path(folder: &Path, step: usize) -> Result<PathBuf, CliError> {
    let checkpoints = beside(folder, ".checkpoints");
    output::make_folder(&checkpoints)?;
    Ok(checkpoints.join(format!("step_{step:05}.checkpoint")))
}

fn beside(folder: &Path, ending: &str) -> PathBuf {
    let mut name = folder.file_name().unwrap_or_default().to_owned();
    name.push(ending);
    folder.with_file_name(name)
}
