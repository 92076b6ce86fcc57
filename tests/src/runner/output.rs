//! The output folder and what can go wrong with it. Files in it are written by [`write_file`], whole or not at all.

pub use crate::report::write_file;

use crate::report::WriteError;
use std::io;
use std::path::{Path, PathBuf};

/// The output folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A file or folder cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file of an earlier run cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file of an earlier run is not what this program writes.
    #[error("{}: not a file of this suite: {reason}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
}

/// Makes a folder and those above it, and makes sure that files can be written there.
///
/// # Errors
/// When it cannot.
pub fn make_folder(folder: &Path) -> Result<(), OutputError> {
    let fails = |source| WriteError { path: folder.to_owned(), source };
    std::fs::create_dir_all(folder).map_err(fails)?;
    let probe = folder.join(format!(".probe.{}.part", std::process::id()));
    std::fs::File::create(&probe).and_then(|_| std::fs::remove_file(&probe)).map_err(fails)?;
    Ok(())
}

/// A scene's name as a file name.
pub fn file_stem(scene: &str) -> String {
    scene.replace(['/', '\\'], "__")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_below_a_file_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("file");
        std::fs::write(&file, "x").expect("a file");
        assert!(make_folder(&file.join("below")).is_err());
        assert!(make_folder(&folder.path().join("a/b/c")).is_ok());
    }
}
