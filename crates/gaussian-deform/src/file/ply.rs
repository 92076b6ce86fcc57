//! Trained scenes as PLY, ASCII and binary in both byte orders.
//!
//! Properties of element `vertex` are found by name, in any order and of any scalar type:
//!
//! | property | what |
//! |---|---|
//! | `x`, `y`, `z` | the mean |
//! | `scale_0` … `scale_2` | ln of the scales |
//! | `rot_0` … `rot_3` | the quaternion (w, x, y, z), of any length but zero |
//! | `opacity` | ln(α/(1 − α)) |
//! | `f_dc_0` … `f_dc_2` | c₀ of red, green, blue |
//! | `f_rest_0` … | the other coefficients, red's first, then green's, then blue's: 0, 9, 24 or 45 |
//!
//! Other properties (normals, training data), other elements and comments are passed over. Elements before `vertex` may not have lists, and
//! neither may `vertex`.

mod body;
mod header;
mod write;

use super::{FileError, atomic};
use crate::splats::Splats;
use mechanics_core::lanes::Element;
use std::path::Path;
pub use write::write;

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyEncoding {
    /// Text.
    Ascii,
    /// Binary, least significant byte first.
    BinaryLittleEndian,
    /// Binary, most significant byte first.
    BinaryBigEndian,
}

/// Reads a scene from the bytes of a PLY file.
///
/// # Errors
/// [`FileError::Header`], [`FileError::MissingProperty`], [`FileError::Repeated`], [`FileError::Degree`], [`FileError::Unsupported`],
/// [`FileError::Truncated`], [`FileError::BadValue`].
pub fn read(bytes: &[u8]) -> Result<Splats, FileError> {
    let header = header::Header::read(bytes)?;
    body::read(&header, bytes)
}

/// Writes a scene to a PLY file, as [`write()`].
///
/// # Errors
/// [`FileError::System`]; the file is then as before.
pub fn write_file<E: Element>(
    splats: &Splats<E>,
    encoding: PlyEncoding,
    path: impl AsRef<Path>,
) -> Result<(), FileError> {
    atomic::write_file(path.as_ref(), |sink| write(splats, encoding, sink))
}
