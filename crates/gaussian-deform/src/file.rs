//! Files of Gaussian scenes.
//!
//! | module | format | reads | writes |
//! |---|---|---|---|
//! | [`ply`] | trained scenes, ASCII and binary of both byte orders | properties by name, in any order | the usual properties |
//! | [`splat`] | 32 bytes a Gaussian, no harmonics | yes | – |
//! | `spz` (feature `spz`) | quantised and compressed, versions 1 to 4 | yes | – |
//! | [`sequence`] | `frame_0001.ply`, `frame_0002.ply`, … | – | yes |
//!
//! **Input is not trusted.** Readers take bytes; for no bytes do they panic. Memory and time are bounded by a multiple of the number of bytes (of
//! decompressed bytes for `.spz`, and these by a thousand times the compressed ones), because nothing is allocated for what a header claims before the bytes for it have been
//! counted. Every number that is read is finite and can be computed with ([`crate::splats::largest_number`]). An error names the Gaussian and the property.
//!
//! **Output appears whole or not at all**: files are written under a temporary name, synced, then renamed.

mod atomic;
mod error;
pub mod ply;
mod row;
pub mod sequence;
pub mod splat;
#[cfg(feature = "spz")]
pub mod spz;

pub use error::{FileError, SplatFormat};

use crate::splats::Splats;
use std::path::Path;

/// Reads a scene from a file whose name ends in `.ply`, `.splat` or `.spz`, in capitals or not.
///
/// # Errors
/// [`FileError::InFile`] with the reader's complaint; [`FileError::System`]; [`FileError::UnknownEnding`].
pub fn read_file(path: impl AsRef<Path>) -> Result<Splats, FileError> {
    let path = path.as_ref();
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let read: fn(&[u8]) -> Result<Splats, FileError> = match ending.as_str() {
        "ply" => ply::read,
        "splat" => splat::read,
        #[cfg(feature = "spz")]
        "spz" => spz::read,
        _ => return Err(FileError::UnknownEnding { path: path.to_path_buf() }),
    };
    let bytes = std::fs::read(path).map_err(|source| FileError::System {
        action: "read",
        path: path.to_path_buf(),
        source,
    })?;
    read(&bytes).map_err(|source| FileError::InFile { path: path.to_path_buf(), source: Box::new(source) })
}
