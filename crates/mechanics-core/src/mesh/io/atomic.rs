//! Files that appear whole or not at all.

use super::error::MeshFileError;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Calls `fill` with a buffered writer to a new file beside `path`, syncs it and renames it to `path`. If anything
/// fails, or `fill` panics, the new file is removed, and whatever was at `path` before is untouched.
pub(super) fn write_file(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), MeshFileError>,
) -> Result<(), MeshFileError> {
    let (temporary, file) = create_beside(path)?;
    let mut temporary = Temporary { path: temporary, renamed: false };
    fill_and_rename(file, &temporary.path, path, fill)?;
    temporary.renamed = true;
    Ok(())
}

/// A file that goes when this goes, unless it has its final name by then.
struct Temporary {
    path: PathBuf,
    renamed: bool,
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.renamed {
            // The first error is the one worth telling.
            let _ = fs::remove_file(&self.path);
        }
    }
}

fn fill_and_rename(
    file: File,
    temporary: &Path,
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), MeshFileError>,
) -> Result<(), MeshFileError> {
    let refused = |action| move |source| MeshFileError::System { action, path: path.to_path_buf(), source };
    let mut writer = BufWriter::new(file);
    match fill(&mut writer) {
        Err(MeshFileError::Sink(source)) => return Err(refused("write")(source)),
        other => other?,
    }
    writer.flush().map_err(refused("write"))?;
    writer.get_ref().sync_all().map_err(refused("sync"))?;
    fs::rename(temporary, path).map_err(refused("rename a temporary file to"))
}

/// A new file in the same folder (a rename must not cross file systems). A name that is taken, left behind by a
/// process that died or in use by one of the same number in another container, is passed over and not touched.
fn create_beside(path: &Path) -> Result<(PathBuf, File), MeshFileError> {
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    loop {
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let temporary = path.with_file_name(format!(".{name}.{}.{number}.tmp", std::process::id()));
        match File::create_new(&temporary) {
            Ok(file) => return Ok((temporary, file)),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(source) => {
                let action = "create a temporary file beside";
                return Err(MeshFileError::System { action, path: path.to_path_buf(), source });
            }
        }
    }
}

/// All bytes of a file.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>, MeshFileError> {
    fs::read(path).map_err(|source| MeshFileError::System {
        action: "read",
        path: path.to_path_buf(),
        source,
    })
}
