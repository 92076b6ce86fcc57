//! Files that are either whole or not there: written under a temporary name, then renamed.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file of the report could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}; nothing was left half-written. Choose another folder with --out, or make room.", path.display())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// What the system said.
    pub source: io::Error,
}

/// Writes `bytes` to `path`, replacing what was there in one step. Missing folders are made.
///
/// # Errors
/// [`WriteError`] when the folder cannot be made or written, or the disk is full; an older file at `path` is then
/// untouched and no temporary file is left.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_file_with(path, |out| out.write_all(bytes))
}

/// As [`write_file`], for content that is produced piece by piece.
///
/// # Errors
/// As [`write_file`], and whatever `content` answers.
pub fn write_file_with(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    let failed = |source| WriteError { path: path.to_owned(), source };
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(failed)?;
    }
    let temporary = temporary_name(path);
    let written = fill(&temporary, content).and_then(|()| fs::rename(&temporary, path));
    written.map_err(|source| {
        // The first error is the one worth telling; a temporary file that was never made cannot be removed.
        let _ = fs::remove_file(&temporary);
        failed(source)
    })
}

fn fill(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    content(&mut out)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()
}

fn temporary_name(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.tmp", std::process::id()))
}
