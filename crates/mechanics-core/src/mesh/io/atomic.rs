//! Files that appear whole or not at all.

use super::error::MeshFileError;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Calls `fill` with a buffered writer to a new file beside `path`, syncs it and renames it to `path`. If anything
/// fails the new file is removed, and whatever was at `path` before is untouched.
pub(super) fn write_file(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), MeshFileError>,
) -> Result<(), MeshFileError> {
    let temporary = temporary_beside(path);
    let result = fill_and_rename(&temporary, path, fill);
    if result.is_err() {
        // The first error is the one worth telling.
        let _ = fs::remove_file(&temporary);
    }
    result
}

fn fill_and_rename(
    temporary: &Path,
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), MeshFileError>,
) -> Result<(), MeshFileError> {
    let refused = |action| move |source| MeshFileError::System { action, path: path.to_path_buf(), source };
    let file = File::create_new(temporary).map_err(refused("create a temporary file beside"))?;
    let mut writer = BufWriter::new(file);
    match fill(&mut writer) {
        Err(MeshFileError::Sink(source)) => return Err(refused("write")(source)),
        other => other?,
    }
    writer.flush().map_err(refused("write"))?;
    writer.get_ref().sync_all().map_err(refused("sync"))?;
    fs::rename(temporary, path).map_err(refused("rename a temporary file to"))
}

/// A name in the same folder (a rename must not cross file systems) that no other thread or process uses.
fn temporary_beside(path: &Path) -> PathBuf {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let number = COUNTER.fetch_add(1, Ordering::Relaxed);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.{number}.tmp", std::process::id()))
}

/// All bytes of a file.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>, MeshFileError> {
    fs::read(path).map_err(|source| MeshFileError::System {
        action: "read",
        path: path.to_path_buf(),
        source,
    })
}
