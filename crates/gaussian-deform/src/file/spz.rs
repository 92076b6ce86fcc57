//! The format `.spz`, versions 1 to 3: quantised numbers, property after property, compressed by gzip.
//!
//! After a header of 16 bytes (magic "NGSP", version, number of Gaussians, degree, fractional bits, flags, reserved) come, for all Gaussians each,
//!
//! | property | stored as |
//! |---|---|
//! | means | version 1: three half-precision numbers; then three 24-bit integers in units of 2⁻ᶠ, f the fractional bits |
//! | opacities | b for b/255 |
//! | c₀ of red, green, blue | b for (b/255 − ½)/0.15 |
//! | scales | b for the logarithm b/16 − 10 |
//! | rotations | versions 1, 2: x, y, z of the unit quaternion, b for b/127.5 − 1, and w ≥ 0; version 3: its three smallest components in ten bits each, and which is the largest |
//! | further harmonics | coefficient by coefficient, red, green, blue of each, b for (b − 128)/128 |
//!
//! Scenes are stored with y up and z towards the viewer, where `.ply` has y down and z away; they are read as they are stored. (Half a turn about x
//! leads from one to the other: [`Similarity`](crate::similarity::Similarity) does it.)
//!
//! # Reference
//! Niantic Labs (2024), *SPZ*, the description of the format in its repository.

use super::row::{Row, read_rows};
use super::{FileError, SplatFormat};
use crate::splats::{Degree, Splats};
use flate2::read::GzDecoder;
use std::io::Read;

const FORMAT: SplatFormat = SplatFormat::Spz;
const MAGIC: &[u8; 4] = b"NGSP";
const HEADER: usize = 16;
/// gzip compresses by 1,032 at most.
const MOST_COMPRESSION: u64 = 1100;

/// Reads a scene.
///
/// # Errors
/// [`FileError::Damaged`], [`FileError::Header`], [`FileError::Unsupported`], [`FileError::Degree`], [`FileError::Truncated`], [`FileError::BadValue`].
pub fn read(bytes: &[u8]) -> Result<Splats, FileError> {
    let mut plain = Vec::new();
    GzDecoder::new(bytes)
        .take(bytes.len() as u64 * MOST_COMPRESSION)
        .read_to_end(&mut plain)
        .map_err(|source| FileError::Damaged { format: FORMAT, source })?;
    read_plain(&plain)
}

/// What the header says.
struct Header {
    version: u32,
    count: usize,
    degree: Degree,
    fractional_bits: u8,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, FileError> {
        let header = |found: String, expected| FileError::Header { format: FORMAT, line: 0, found, expected };
        let Some(&[m0, m1, m2, m3, v0, v1, v2, v3, n0, n1, n2, n3, degree, fractional_bits, flags, _]) =
            bytes.first_chunk::<HEADER>()
        else {
            return Err(header(format!("{} bytes", bytes.len()), "a header of 16 bytes"));
        };
        if &[m0, m1, m2, m3] != MAGIC {
            return Err(header(format!("{:?}", [m0, m1, m2, m3]), "the letters NGSP"));
        }
        let version = u32::from_le_bytes([v0, v1, v2, v3]);
        let unsupported =
            |found: String, supported| FileError::Unsupported { format: FORMAT, found, supported };
        if !(1..=3).contains(&version) {
            return Err(unsupported(format!("version {version}"), "versions 1 to 3 are"));
        }
        if flags & 2 != 0 {
            return Err(unsupported("an extension".to_string(), "files without extensions are"));
        }
        if fractional_bits > 23 {
            return Err(header(format!("{fractional_bits} fractional bits"), "at most 23 of 24"));
        }
        let found = || format!("degree {degree}");
        let degree =
            Degree::of(degree.into()).ok_or_else(|| FileError::Degree { format: FORMAT, found: found() })?;
        Ok(Self { version, count: u32::from_le_bytes([n0, n1, n2, n3]) as usize, degree, fractional_bits })
    }

    /// Bytes a Gaussian of means, opacities, colours, scales, rotations, further harmonics.
    fn widths(&self) -> [usize; 6] {
        let mean = if self.version == 1 { 6 } else { 9 };
        let rotation = if self.version == 3 { 4 } else { 3 };
        [mean, 1, 3, 3, rotation, self.degree.stride() - 3]
    }
}

fn read_plain(bytes: &[u8]) -> Result<Splats, FileError> {
    let header = Header::read(bytes)?;
    let body = &bytes[HEADER..];
    let widths = header.widths();
    let needed = header.count as u128 * widths.iter().sum::<usize>() as u128;
    if body.len() as u128 != needed {
        let claimed = header.count as u64;
        return Err(FileError::Truncated { format: FORMAT, claimed, needed, found: body.len() });
    }
    let mut rest = body;
    let columns = widths.map(|width| {
        let (column, others) = rest.split_at(width * header.count);
        rest = others;
        column
    });
    let of = |column: usize, i: usize| &columns[column][i * widths[column]..(i + 1) * widths[column]];
    let coefficients = header.degree.coefficients();
    let unit = 1.0 / (1_u32 << header.fractional_bits) as f32;
    read_rows(FORMAT, header.degree, header.count, |i, harmonics| {
        for (channel, &b) in of(2, i).iter().enumerate() {
            harmonics[channel * coefficients] = (f32::from(b) / 255.0 - 0.5) / 0.15;
        }
        for (k, &b) in of(5, i).iter().enumerate() {
            harmonics[(k % 3) * coefficients + 1 + k / 3] = (f32::from(b) - 128.0) / 128.0;
        }
        let (mean, scales, rotation) = (of(0, i), of(3, i), of(4, i));
        Ok(Row {
            mean: std::array::from_fn(|k| match header.version {
                1 => half(u16::from_le_bytes([mean[2 * k], mean[2 * k + 1]])),
                _ => fixed([mean[3 * k], mean[3 * k + 1], mean[3 * k + 2]]) as f32 * unit,
            }),
            log_scales: std::array::from_fn(|k| f32::from(scales[k]) / 16.0 - 10.0),
            quaternion: match *rotation {
                [a, b, c, d] => smallest_three(u32::from_le_bytes([a, b, c, d])),
                _ => first_three(rotation),
            },
            opacity: f32::from(of(1, i)[0]) / 255.0,
        })
        .and_then(|row: Row| finite_mean(row))
    })
}

/// Half-precision numbers may be infinite or NaN.
fn finite_mean(row: Row) -> Result<Row, super::row::BadNumber> {
    for k in 0..3 {
        super::row::usable(row.mean[k], || format!("coordinate {k} of the mean"))?;
    }
    Ok(row)
}

/// A signed integer of 24 bits.
fn fixed([a, b, c]: [u8; 3]) -> i32 {
    i32::from_le_bytes([0, a, b, c]) >> 8
}

/// A number of half precision (IEEE 754 binary16).
fn half(bits: u16) -> f32 {
    let (exponent, fraction) = (u32::from(bits >> 10) & 0x1f, u32::from(bits) & 0x3ff);
    let size = match exponent {
        0 => fraction as f32 * 2.0_f32.powi(-24),
        31 if fraction == 0 => f32::INFINITY,
        31 => f32::NAN,
        _ => f32::from_bits(((exponent + 112) << 23) | (fraction << 13)),
    };
    if bits >> 15 == 0 { size } else { -size }
}

/// (w, x, y, z) from x, y, z.
fn first_three(bytes: &[u8]) -> [f32; 4] {
    let [x, y, z] = [0, 1, 2].map(|k| f32::from(bytes[k]) / 127.5 - 1.0);
    [(1.0 - x * x - y * y - z * z).max(0.0).sqrt(), x, y, z]
}

/// (w, x, y, z) from two bits that say which of x, y, z, w is the largest, and the others, from the last to the first, as nine bits of |q| √2 and a sign each.
fn smallest_three(mut bits: u32) -> [f32; 4] {
    let largest = (bits >> 30) as usize;
    let mut xyzw = [0.0_f32; 4];
    let mut sum = 0.0;
    for k in (0..4).rev().filter(|&k| k != largest) {
        let size = (bits & 0x1ff) as f32 / 511.0 * std::f32::consts::FRAC_1_SQRT_2;
        xyzw[k] = if bits & 0x200 == 0 { size } else { -size };
        sum += size * size;
        bits >>= 10;
    }
    xyzw[largest] = (1.0 - sum).max(0.0).sqrt();
    let [x, y, z, w] = xyzw;
    [w, x, y, z]
}
