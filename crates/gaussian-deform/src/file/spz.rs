//! The format `.spz`, versions 1 to 4: quantised numbers, property after property, compressed.
//!
//! After a header (magic "NGSP", version, number of Gaussians, degree, fractional bits, flags) come, for all Gaussians each,
//!
//! | property | stored as |
//! |---|---|
//! | means | version 1: three half-precision numbers; then three 24-bit integers in units of 2⁻ᶠ, f the fractional bits |
//! | opacities | b for b/255 |
//! | c₀ of red, green, blue | b for (b/255 − ½)/0.15 |
//! | scales | b for the logarithm b/16 − 10 |
//! | rotations | versions 1, 2: x, y, z of the unit quaternion, b for b/127.5 − 1, and w ≥ 0; from 3 on: its three smallest components in ten bits each, and which is the largest |
//! | further harmonics | coefficient by coefficient, red, green, blue of each, b for (b − 128)/128 |
//!
//! Up to version 3 all of that, a header of 16 bytes included, is one stream of gzip. Version 4 has a plain header of 32 bytes, which ends with the number of streams, the
//! place of their table and twelve bytes for the future; the table has, for each property that has any bytes, the length of its stream of Zstandard, and its length without compression; the
//! streams follow.
//!
//! **Extensions** (records of a type, a length, and as many bytes; after everything else up to version 3, between header and table in version 4) are passed over: they say
//! where cameras may go, and the like. One that changes what harmonics mean (type 0xADBE0001) is refused.
//!
//! Scenes are stored with y up and z towards the viewer as a rule, where `.ply` has y down and z away; they are read as they are stored. (Half a turn about x
//! leads from one to the other: [`Similarity`](crate::similarity::Similarity) does it.) The flag of scenes that were trained with smoothing is not looked at:
//! whoever draws them asks for [`Antialiasing::Present`](crate::raster::Antialiasing::Present).
//!
//! # Reference
//! Niantic Labs (2024–2026), *SPZ*, the description of the format in its repository; version 4 and the types of extensions as in the program there.

mod streams;

use super::row::{Row, read_rows, scales_of_logarithms};
use super::{FileError, SplatFormat};
use crate::splats::{Degree, Splats};
use flate2::read::GzDecoder;
use std::io::Read;
use std::ops::RangeInclusive;

const FORMAT: SplatFormat = SplatFormat::Spz;
const MAGIC: &[u8; 4] = b"NGSP";
/// Bytes of the header that all versions have.
const HEADER: usize = 16;
/// gzip compresses by 1,032 at most; the program of reference trusts no more of other files either.
const MOST_COMPRESSION: u64 = 1100;
/// The extension that gives harmonics other units.
const SCALED_HARMONICS: u32 = 0xADBE_0001;

/// Reads a scene.
///
/// # Errors
/// [`FileError::Damaged`], [`FileError::Header`], [`FileError::Unsupported`], [`FileError::Degree`], [`FileError::Truncated`], [`FileError::BadValue`].
pub fn read(bytes: &[u8]) -> Result<Splats, FileError> {
    if bytes.starts_with(MAGIC) {
        let header = Header::read(bytes, 4..=4)?;
        return read_body(&header, &streams::decompressed(&header, bytes)?);
    }
    let mut plain = Vec::new();
    GzDecoder::new(bytes)
        .take((bytes.len() as u64).saturating_mul(MOST_COMPRESSION))
        .read_to_end(&mut plain)
        .map_err(|source| FileError::Damaged { format: FORMAT, source })?;
    let header = Header::read(&plain, 1..=4)?;
    let body = &plain[HEADER..];
    let Some((body, rest)) = usize::try_from(header.needed()).ok().and_then(|n| body.split_at_checked(n))
    else {
        return Err(header.truncated(body.len()));
    };
    if header.has_extensions {
        check_extensions(rest)?;
    } else if !rest.is_empty() {
        return Err(header_error(format!("{} bytes after the last Gaussian", rest.len()), "none"));
    }
    read_body(&header, body)
}

/// What the header says.
struct Header {
    version: u32,
    count: usize,
    degree: Degree,
    fractional_bits: u8,
    has_extensions: bool,
}

fn header_error(found: String, expected: &'static str) -> FileError {
    FileError::Header { format: FORMAT, line: 0, found, expected }
}

impl Header {
    fn read(bytes: &[u8], versions: RangeInclusive<u32>) -> Result<Self, FileError> {
        let Some(&[m0, m1, m2, m3, v0, v1, v2, v3, n0, n1, n2, n3, degree, fractional_bits, flags, _]) =
            bytes.first_chunk::<HEADER>()
        else {
            return Err(header_error(format!("{} bytes", bytes.len()), "a header of 16 bytes"));
        };
        if &[m0, m1, m2, m3] != MAGIC {
            return Err(header_error(format!("{:?}", [m0, m1, m2, m3]), "the letters NGSP"));
        }
        let version = u32::from_le_bytes([v0, v1, v2, v3]);
        if !versions.contains(&version) {
            let (found, supported) =
                (format!("version {version}"), "versions 1 to 3 within gzip, and version 4 are");
            return Err(FileError::Unsupported { format: FORMAT, found, supported });
        }
        if fractional_bits > 23 {
            return Err(header_error(format!("{fractional_bits} fractional bits"), "at most 23 of 24"));
        }
        let found = || format!("degree {degree}");
        let degree =
            Degree::of(degree.into()).ok_or_else(|| FileError::Degree { format: FORMAT, found: found() })?;
        let count = u32::from_le_bytes([n0, n1, n2, n3]) as usize;
        Ok(Self { version, count, degree, fractional_bits, has_extensions: flags & 2 != 0 })
    }

    /// Bytes a Gaussian of means, opacities, colours, scales, rotations, further harmonics.
    fn widths(&self) -> [usize; 6] {
        let mean = if self.version == 1 { 6 } else { 9 };
        let rotation = if self.version >= 3 { 4 } else { 3 };
        [mean, 1, 3, 3, rotation, self.degree.stride() - 3]
    }

    /// Bytes of all Gaussians.
    fn needed(&self) -> u128 {
        self.count as u128 * self.widths().iter().sum::<usize>() as u128
    }

    fn truncated(&self, found: usize) -> FileError {
        FileError::Truncated { format: FORMAT, claimed: self.count as u64, needed: self.needed(), found }
    }
}

/// Whether records can be passed over, and end where their bytes do.
fn check_extensions(mut rest: &[u8]) -> Result<(), FileError> {
    while let Some((&[t0, t1, t2, t3, n0, n1, n2, n3], bytes)) = rest.split_first_chunk::<8>() {
        let (kind, length) = (u32::from_le_bytes([t0, t1, t2, t3]), u32::from_le_bytes([n0, n1, n2, n3]));
        if kind == SCALED_HARMONICS {
            let found = "the extension 0xADBE0001, harmonics scaled to their range,".to_string();
            return Err(FileError::Unsupported {
                format: FORMAT,
                found,
                supported: "the numbers themselves are",
            });
        }
        let Some((_, others)) = bytes.split_at_checked(length as usize) else {
            let found = format!("{} bytes of extension {kind:#X}", bytes.len());
            return Err(header_error(found, "as many as it announces"));
        };
        rest = others;
    }
    if rest.is_empty() { Ok(()) } else { Err(header_error(format!("{} bytes", rest.len()), "an extension")) }
}

/// The Gaussians of `needed` bytes: the columns of all properties, one after the other.
fn read_body(header: &Header, body: &[u8]) -> Result<Splats, FileError> {
    let widths = header.widths();
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
            scales: scales_of_logarithms(std::array::from_fn(|k| f32::from(scales[k]) / 16.0 - 10.0))?,
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
