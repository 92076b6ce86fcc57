//! A checkpoint on disk.

use super::{Checkpoint, CheckpointError};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

impl Checkpoint {
    /// Writes the checkpoint to `path`, replacing a file that is there.
    ///
    /// Atomic: whatever happens (a full disk, a crash, a power cut), `path` afterwards holds either the old file or
    /// the whole new one. The content goes to a temporary file in the same directory, is flushed to the device,
    /// takes the name `path` in one step, and the directory is flushed too (on Unix; elsewhere directories cannot
    /// be opened for that). After an error the temporary file is removed.
    ///
    /// # Errors
    /// [`CheckpointError::Io`] says which action on which path failed.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        let path = path.as_ref();
        let (temporary, file) = create_beside(path)?;
        let written = fill(file, self)
            .map_err(failed("write", &temporary))
            .and_then(|()| fs::rename(&temporary, path).map_err(failed("replace", path)));
        if let Err(error) = written {
            // The first error is the one to report; a temporary file that cannot be removed does no harm.
            let _ = fs::remove_file(&temporary);
            return Err(error);
        }
        let directory = directory_of(path);
        sync_directory(directory).map_err(failed("flush the directory", directory))
    }

    /// Reads the checkpoint at `path`.
    ///
    /// # Errors
    /// [`CheckpointError::Io`] if the file cannot be read, otherwise as [`Checkpoint::from_bytes`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, CheckpointError> {
        let path = path.as_ref();
        Self::from_bytes(&fs::read(path).map_err(failed("read", path))?)
    }
}

fn failed(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> CheckpointError {
    let path = path.to_owned();
    move |source| CheckpointError::Io { action, path, source }
}

fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A new file in the directory of `path`: renaming is atomic only within one file system.
///
/// Its name carries the process and a counter, so that two writers never share one; a name left behind by a
/// process that died is passed over.
fn create_beside(path: &Path) -> Result<(PathBuf, File), CheckpointError> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let Some(name) = path.file_name() else {
        let source = io::Error::new(io::ErrorKind::InvalidInput, "the path names no file");
        return Err(failed("write", path)(source));
    };
    loop {
        let mut temporary = std::ffi::OsString::from(".");
        temporary.push(name);
        temporary.push(format!(".{}.{}.tmp", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed)));
        let temporary = directory_of(path).join(temporary);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Ok(file) => return Ok((temporary, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(failed("create", &temporary)(error)),
        }
    }
}

fn fill(file: File, checkpoint: &Checkpoint) -> io::Result<()> {
    let mut file = BufWriter::new(file);
    checkpoint.visit_bytes(|piece| file.write_all(piece))?;
    file.into_inner()?.sync_all()
}

#[cfg(unix)]
fn sync_directory(directory: &Path) -> io::Result<()> {
    File::open(directory)?.sync_all()
}

#[cfg(not(unix))]
fn sync_directory(_directory: &Path) -> io::Result<()> {
    Ok(())
}
