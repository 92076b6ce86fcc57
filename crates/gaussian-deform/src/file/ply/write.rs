//! Writing.

use super::PlyEncoding;
use crate::error::{Property, SplatError};
use crate::file::{FileError, SplatFormat};
use crate::harmonics;
use crate::shape::scales_and_quaternion;
use crate::splats::{Splats, largest_number};
use mechanics_core::lanes::Element;
use mechanics_core::scalar::Scalar;
use std::io::Write;

/// Opacities beyond these are 0 and 1 in `f32` when read again.
const LOGITS: [f64; 2] = [-110.0, 20.0];

/// Writes a scene as PLY with the properties, in the order, that viewers expect: mean, normal (zero), `f_dc`, `f_rest`, `opacity`, `scale`, `rot`, all `float`.
///
/// Scales and quaternion come from the singular values of the half-axes ([`scales_and_quaternion`]); orientations are settled; a scale of zero is written as
/// the smallest normal number. What is read again differs by a few roundings of `f32`: of logarithms for scales and opacities.
///
/// # Errors
/// [`FileError::BadValue`] for a number that could not be read again; those of the writer.
pub fn write<E: Element>(
    splats: &Splats<E>,
    encoding: PlyEncoding,
    sink: &mut impl Write,
) -> Result<(), FileError> {
    // Lengths of half-axes are up to √3 times their components.
    splats.check_within(0.5 * largest_number::<f32>()).map_err(refused)?;
    let settled = splats.orientations().map(|_| {
        let mut settled = splats.clone();
        harmonics::settle_orientations(&mut settled);
        settled
    });
    let splats = settled.as_ref().unwrap_or(splats);
    write_header(splats, encoding, sink)?;
    let mut row = Vec::with_capacity(17 + splats.degree().stride());
    let mut bytes = Vec::new();
    for i in 0..splats.count() {
        row.clear();
        add_row(splats, i, &mut row);
        bytes.clear();
        match encoding {
            PlyEncoding::Ascii => {
                let words: Vec<String> = row.iter().map(f32::to_string).collect();
                bytes.extend_from_slice(words.join(" ").as_bytes());
                bytes.push(b'\n');
            }
            PlyEncoding::BinaryLittleEndian => row.iter().for_each(|x| bytes.extend(x.to_le_bytes())),
            PlyEncoding::BinaryBigEndian => row.iter().for_each(|x| bytes.extend(x.to_be_bytes())),
        }
        sink.write_all(&bytes)?;
    }
    Ok(())
}

fn write_header<E: Element>(
    splats: &Splats<E>,
    encoding: PlyEncoding,
    sink: &mut impl Write,
) -> Result<(), FileError> {
    let format = match encoding {
        PlyEncoding::Ascii => "ascii",
        PlyEncoding::BinaryLittleEndian => "binary_little_endian",
        PlyEncoding::BinaryBigEndian => "binary_big_endian",
    };
    writeln!(sink, "ply\nformat {format} 1.0\nelement vertex {}", splats.count())?;
    let rest = (0..splats.degree().stride() - 3).map(|k| format!("f_rest_{k}"));
    let names = ["x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"].map(str::to_string);
    let shape = ["opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"];
    for name in names.into_iter().chain(rest).chain(shape.map(str::to_string)) {
        writeln!(sink, "property float {name}")?;
    }
    writeln!(sink, "end_header")?;
    Ok(())
}

/// The numbers of Gaussian i in the order of the header.
fn add_row<E: Element>(splats: &Splats<E>, i: usize, row: &mut Vec<f32>) {
    let splat = splats.splat(i);
    let narrow = |x: E| -> f32 { <f32 as Scalar>::constant(x.into()) };
    let coefficients = splats.degree().coefficients();
    row.extend(splat.mean.iter().map(|&x| narrow(x)));
    row.extend([0.0; 3]);
    row.extend(splat.harmonics.iter().step_by(coefficients).map(|&c| narrow(c)));
    for channel in splat.harmonics.chunks_exact(coefficients) {
        row.extend(channel[1..].iter().map(|&c| narrow(c)));
    }
    let opacity: f64 = splat.opacity.into();
    row.push((opacity / (1.0 - opacity)).ln().clamp(LOGITS[0], LOGITS[1]) as f32);
    let (scales, quaternion) = scales_and_quaternion(&splat.axes);
    row.extend(scales.map(|s| s.into().max(f64::from(f32::MIN_POSITIVE)).ln() as f32));
    row.extend(quaternion.map(narrow));
}

fn refused(error: SplatError) -> FileError {
    let (splat, property, found) = match error {
        SplatError::BadValue { splat, property, value } => (splat, property, value.to_string()),
        other => (0, Property::Mean, other.to_string()),
    };
    FileError::BadValue {
        format: SplatFormat::Ply,
        splat,
        property: property.to_string(),
        found,
        expected: "a number that can be read again",
    }
}
