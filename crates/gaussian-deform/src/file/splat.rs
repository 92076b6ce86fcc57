//! The format `.splat`: 32 bytes a Gaussian, no header, no harmonics.
//!
//! | bytes | what |
//! |---|---|
//! | 0–11 | the mean, three `f32` |
//! | 12–23 | the scales, three `f32` |
//! | 24–27 | red, green, blue, opacity, 0 to 255 |
//! | 28–31 | the quaternion (w, x, y, z), b for (b − 128)/128 |
//!
//! All little-endian. Red of 255 is the colour 1: ½ + c₀ Y₀ = red/255.

use super::row::{Row, read_rows, scale, usable};
use super::{FileError, SplatFormat};
use crate::harmonics::BAND_0;
use crate::splats::{Degree, Splats};

/// Bytes of one Gaussian.
const SIZE: usize = 32;

/// Reads a scene of degree 0.
///
/// # Errors
/// [`FileError::Header`] if the length is no multiple of 32; [`FileError::BadValue`].
pub fn read(bytes: &[u8]) -> Result<Splats, FileError> {
    let format = SplatFormat::Splat;
    if !bytes.len().is_multiple_of(SIZE) {
        let found = format!("{} bytes", bytes.len());
        return Err(FileError::Header { format, line: 0, found, expected: "a multiple of 32 bytes" });
    }
    read_rows(format, Degree::Zero, bytes.len() / SIZE, |i, harmonics| {
        let row = &bytes[i * SIZE..(i + 1) * SIZE];
        let float = |k: usize| f32::from_le_bytes([row[k], row[k + 1], row[k + 2], row[k + 3]]);
        let mut mean = [0.0; 3];
        let mut scales = [0.0; 3];
        for k in 0..3 {
            mean[k] = usable(float(4 * k), || format!("coordinate {k} of the mean"))?;
            scales[k] = scale(float(12 + 4 * k), k)?;
            harmonics[k] = (f32::from(row[24 + k]) / 255.0 - 0.5) / BAND_0 as f32;
        }
        let quaternion = [28, 29, 30, 31].map(|k| (f32::from(row[k]) - 128.0) / 128.0);
        Ok(Row { mean, scales, quaternion, opacity: f32::from(row[27]) / 255.0 })
    })
}
