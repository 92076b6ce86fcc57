//! Sequences of frames, one file each: `frame_0001.ply`, `frame_0002.ply`, …, as editors of splats import them.

use super::FileError;
use super::ply::{self, PlyEncoding};
use crate::splats::Splats;
use mechanics_core::lanes::Element;
use std::path::{Path, PathBuf};

/// The file of frame `number`; the first frame is 1. Beyond 9999 names grow longer.
pub fn frame_path(folder: impl AsRef<Path>, number: usize) -> PathBuf {
    folder.as_ref().join(format!("frame_{number:04}.ply"))
}

/// Writes a scene as frame `number` of the sequence in `folder`, which is made if it is not there; answers the file.
///
/// # Errors
/// [`FileError::System`]; the frame's file is then as before.
pub fn write_frame<E: Element>(
    splats: &Splats<E>,
    folder: impl AsRef<Path>,
    number: usize,
) -> Result<PathBuf, FileError> {
    let folder = folder.as_ref();
    std::fs::create_dir_all(folder).map_err(|source| FileError::System {
        action: "make the folder",
        path: folder.to_path_buf(),
        source,
    })?;
    let path = frame_path(folder, number);
    ply::write_file(splats, PlyEncoding::BinaryLittleEndian, &path)?;
    Ok(path)
}
