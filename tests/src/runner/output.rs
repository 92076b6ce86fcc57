//! Files of the output folder: each is there whole or not at all.

use std::io;
use std::path::{Path, PathBuf};

/// The output folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A file or folder cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
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

/// Writes a file under a temporary name beside it, then renames it: whoever looks sees the old file or the new one.
///
/// # Errors
/// When the folder cannot be written or the disk is full; the temporary file is gone then.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), OutputError> {
    write_whole_with(path, |file| io::Write::write_all(file, content))
}

/// As [`write_whole`], for content that is written piece by piece.
///
/// # Errors
/// As [`write_whole`], or when `write` fails.
pub fn write_whole_with(
    path: &Path,
    write: impl FnOnce(&mut std::fs::File) -> io::Result<()>,
) -> Result<(), OutputError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let temporary = path.with_file_name(format!(".{name}.{}.part", std::process::id()));
    let attempt = || {
        let mut file = std::fs::File::create(&temporary)?;
        write(&mut file)?;
        // Some file systems report a full disk only here.
        file.sync_all()?;
        std::fs::rename(&temporary, path)
    };
    attempt().map_err(|source| {
        // It may not exist; there is nothing more to do about it either way.
        let _ = std::fs::remove_file(&temporary);
        OutputError::Write { path: path.to_owned(), source }
    })
}

/// Makes a folder and those above it, and makes sure that files can be written there.
///
/// # Errors
/// When it cannot.
pub fn make_folder(folder: &Path) -> Result<(), OutputError> {
    let fails = |source| OutputError::Write { path: folder.to_owned(), source };
    std::fs::create_dir_all(folder).map_err(fails)?;
    let probe = folder.join(format!(".probe.{}.part", std::process::id()));
    std::fs::File::create(&probe).and_then(|_| std::fs::remove_file(&probe)).map_err(fails)
}

/// A scene's name as a file name.
pub fn file_stem(scene: &str) -> String {
    scene.replace(['/', '\\'], "__")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("report.json");
        write_whole(&path, b"old").expect("an empty folder can be written");
        let full = write_whole_with(&path, |file| {
            file.write_all(b"ne")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        assert!(matches!(full, Err(OutputError::Write { .. })));
        assert_eq!(std::fs::read(&path).expect("the old file"), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 1);
        write_whole(&path, b"new").expect("the folder can be written");
        assert_eq!(std::fs::read(&path).expect("the new file"), b"new");
    }

    #[test]
    fn a_folder_below_a_file_is_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("file");
        std::fs::write(&file, "x").expect("a file");
        assert!(make_folder(&file.join("below")).is_err());
        assert!(make_folder(&folder.path().join("a/b/c")).is_ok());
    }
}
