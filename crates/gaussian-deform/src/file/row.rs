//! What every reader does with one Gaussian.

use super::{FileError, SplatFormat};
use crate::shape;
use crate::splats::{ArraysMut, Degree, Splats, largest_number};
use mechanics_core::parallel;
use mechanics_core::tensor;

/// One Gaussian as files have it.
pub(super) struct Row {
    pub(super) mean: [f32; 3],
    /// Not negative, and up to [`largest_number`].
    pub(super) scales: [f32; 3],
    /// (w, x, y, z), of any length.
    pub(super) quaternion: [f32; 4],
    pub(super) opacity: f32,
}

/// What is wrong with one number of a Gaussian.
pub(super) struct BadNumber {
    pub(super) property: String,
    pub(super) found: String,
    pub(super) expected: &'static str,
}

pub(super) const USABLE: &str = "a number from -1e15 to 1e15";
const SCALE: &str = "a scale from 0 to 1e15";
const LOG_SCALE: &str = "the logarithm of a scale up to 1e15";

/// A number that can be computed with.
#[inline(always)]
pub(super) fn usable(x: f32, property: impl FnOnce() -> String) -> Result<f32, BadNumber> {
    if x.abs() <= largest_number::<f32>() as f32 { Ok(x) } else { Err(bad(property(), x, USABLE)) }
}

fn bad(property: String, found: f32, expected: &'static str) -> BadNumber {
    BadNumber { property, found: found.to_string(), expected }
}

/// Scale number `axis`.
#[inline(always)]
pub(super) fn scale(x: f32, axis: usize) -> Result<f32, BadNumber> {
    let valid = (0.0..=largest_number::<f32>() as f32).contains(&x);
    if valid { Ok(x) } else { Err(bad(format!("scale_{axis}"), x, SCALE)) }
}

/// The three scales of which these are the logarithms.
#[inline(always)]
pub(super) fn scales_of_logarithms(logarithms: [f32; 3]) -> Result<[f32; 3], BadNumber> {
    let scales = logarithms.map(f32::exp);
    match scales.iter().position(|&x| x.is_nan() || x > largest_number::<f32>() as f32) {
        None => Ok(scales),
        Some(axis) => Err(bad(format!("scale_{axis}"), logarithms[axis], LOG_SCALE)),
    }
}

/// Gaussians in one piece of parallel work.
const CHUNK: usize = 4096;

/// Consecutive Gaussians to be filled in.
struct Piece<'a> {
    first: usize,
    arrays: ArraysMut<'a, f32>,
    outcome: Result<(), FileError>,
}

/// `count` Gaussians from `fill(i, coefficients of i)`, which gives Gaussian i and writes its coefficients, in parallel.
///
/// The caller has made sure that `count` Gaussians are in the file: memory is taken for all of them.
pub(super) fn read_rows(
    format: SplatFormat,
    degree: Degree,
    count: usize,
    fill: impl Fn(usize, &mut [f32]) -> Result<Row, BadNumber> + Sync,
) -> Result<Splats, FileError> {
    let stride = degree.stride();
    let mut splats = Splats::zeros(degree, count);
    let arrays = splats.arrays_mut();
    let mut pieces: Vec<Piece<'_>> = arrays
        .means
        .chunks_mut(CHUNK)
        .zip(arrays.axes.chunks_mut(CHUNK))
        .zip(arrays.opacities.chunks_mut(CHUNK).zip(arrays.harmonics.chunks_mut(CHUNK * stride)))
        .enumerate()
        .map(|(k, ((means, axes), (opacities, harmonics)))| Piece {
            first: k * CHUNK,
            arrays: ArraysMut { means, axes, opacities, harmonics, orientations: None },
            outcome: Ok(()),
        })
        .collect();
    parallel::for_each_chunk(&mut pieces, 1, |_, pieces| {
        for piece in pieces {
            piece.outcome = fill_piece(format, stride, piece.first, &mut piece.arrays, &fill);
        }
    });
    pieces.into_iter().try_for_each(|piece| piece.outcome)?;
    Ok(splats)
}

fn fill_piece(
    format: SplatFormat,
    stride: usize,
    first: usize,
    arrays: &mut ArraysMut<'_, f32>,
    fill: &impl Fn(usize, &mut [f32]) -> Result<Row, BadNumber>,
) -> Result<(), FileError> {
    for (k, harmonics) in arrays.harmonics.chunks_exact_mut(stride).enumerate() {
        let complain = |b: BadNumber| FileError::BadValue {
            format,
            splat: first + k,
            property: b.property,
            found: b.found,
            expected: b.expected,
        };
        let row = fill(first + k, harmonics).map_err(complain)?;
        arrays.means[k] = tensor::vector(row.mean);
        arrays.opacities[k] = row.opacity;
        arrays.axes[k] = axes(&row).map_err(complain)?;
    }
    Ok(())
}

fn axes(row: &Row) -> Result<tensor::Matrix3<f32>, BadNumber> {
    shape::axes(row.scales, row.quaternion).ok_or_else(|| BadNumber {
        property: "rotation".to_string(),
        found: format!("the quaternion {:?}", row.quaternion),
        expected: "a quaternion that is not zero and of finite length",
    })
}
