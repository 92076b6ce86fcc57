//! Files that appear whole or not at all.

use super::FileError;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Calls `fill` with a buffered writer to a new file beside `path`, syncs it and renames it to `path`. If anything fails, the new file is
/// removed, and whatever was at `path` before is untouched.
pub(super) fn write_file(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), FileError>,
) -> Result<(), FileError> {
    let (temporary, file) = create_beside(path)?;
    let outcome = fill_and_rename(file, &temporary, path, fill);
    if outcome.is_err() {
        // The first error is the one worth telling.
        let _ = fs::remove_file(&temporary);
    }
    outcome
}

fn fill_and_rename(
    file: File,
    temporary: &Path,
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), FileError>,
) -> Result<(), FileError> {
    let refused = |action| move |source| FileError::System { action, path: path.to_path_buf(), source };
    let mut writer = BufWriter::with_capacity(1 << 20, file);
    match fill(&mut writer) {
        Err(FileError::Sink(source)) => return Err(refused("write")(source)),
        other => other?,
    }
    writer.flush().map_err(refused("write"))?;
    writer.get_ref().sync_all().map_err(refused("sync"))?;
    fs::rename(temporary, path).map_err(refused("rename a temporary file to"))
}

/// A new file in the same folder (a rename must not cross file systems). A name that is taken, by a thread of this process or left
/// behind by another, is passed over and not touched.
fn create_beside(path: &Path) -> Result<(PathBuf, File), FileError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut number = 0_u64;
    loop {
        let temporary = path.with_file_name(format!(".{name}.{}.{number}.tmp", std::process::id()));
        match File::create_new(&temporary) {
            Ok(file) => return Ok((temporary, file)),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => number += 1,
            Err(source) => {
                let action = "create a temporary file beside";
                return Err(FileError::System { action, path: path.to_path_buf(), source });
            }
        }
    }
}
