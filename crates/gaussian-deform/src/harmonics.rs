//! Spherical harmonics: colour by direction, and its exact rotation.
//!
//! A channel's colour in the unit direction d = (x, y, z), from the camera to the mean, is ½ + Σₖ cₖ Yₖ(d) with k = l² + l + m, −l ≤ m ≤ l, and
//! real harmonics with the signs that trained scenes use:
//!
//! | l | m = −l … l |
//! |---|---|
//! | 0 | ½√(1/π) |
//! | 1 | ½√(3/π) · (−y, z, −x) |
//! | 2 | ¼√(15/π) · (2xy, −2yz, (2z² − x² − y²)/√3, −2xz, x² − y²) |
//! | 3 | ¼√(7/π) · (−√(5/2) y(3x² − y²), 2√15 xyz, −√(3/2) y(4z² − x² − y²), z(2z² − 3x² − 3y²), −√(3/2) x(4z² − x² − y²), √15 z(x² − y²), −√(5/2) x(x² − 3y²)) |
//!
//! Rotated by R, a Gaussian shows in direction d what it showed in Rᵀ d: g(d) = f(Rᵀ d). Each band (l) is closed under rotation, so that g
//! has coefficients again; [`rotate`] gives them.
//!
//! # Reference
//! The signs are those of Kerbl, Kopanas, Leimkühler, Drettakis (2023), *3D Gaussian Splatting for Real-Time Radiance Field Rendering*; the functions those of any table
//! of real harmonics with the Condon–Shortley phase. Bands as symmetric traceless tensors: Applequist (1989), *Traceless Cartesian tensor forms for
//! spherical harmonic functions*, J. Phys. A 22.

mod rotation;

use crate::precision::by_precision;
use crate::splats::{Degree, Splats};
use mechanics_core::lanes::{self, Element, LaneKernel, Packet};
use mechanics_core::parallel;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::Matrix3;
pub(crate) use rotation::ChannelRotation;

/// ½√(1/π).
pub(crate) const BAND_0: f64 = 0.282_094_791_773_878_14;
/// ½√(3/π).
const BAND_1: f64 = 0.488_602_511_902_919_92;
/// ¼√(15/π).
const BAND_2: f64 = 0.546_274_215_296_039_5;
/// ¼√(7/π).
const BAND_3: f64 = 0.373_176_332_590_115_4;
const SQRT_3: f64 = 1.732_050_807_568_877_2;
const SQRT_15: f64 = 3.872_983_346_207_417;
/// √(5/2).
const SQRT_5_2: f64 = 1.581_138_830_084_189_7;
/// √(3/2).
const SQRT_3_2: f64 = 1.224_744_871_391_589;

/// The most coefficients of a channel: those of degree 3.
pub const MOST_COEFFICIENTS: usize = 16;

/// Y₀ to Y₁₅ in a unit direction; zeros beyond the degree.
#[inline(always)]
pub fn basis<S: Scalar>(degree: Degree, [x, y, z]: [S; 3]) -> [S; MOST_COEFFICIENTS] {
    let mut values = [S::constant(0.0); MOST_COEFFICIENTS];
    values[0] = S::constant(BAND_0);
    if degree >= Degree::One {
        values[1] = y.scale(-BAND_1);
        values[2] = z.scale(BAND_1);
        values[3] = x.scale(-BAND_1);
    }
    if degree >= Degree::Two {
        let (xx, yy, zz) = (x * x, y * y, z * z);
        values[4] = (x * y).scale(2.0 * BAND_2);
        values[5] = (y * z).scale(-2.0 * BAND_2);
        values[6] = (zz.scale(2.0) - xx - yy).scale(BAND_2 / SQRT_3);
        values[7] = (x * z).scale(-2.0 * BAND_2);
        values[8] = (xx - yy).scale(BAND_2);
    }
    if degree >= Degree::Three {
        for (value, cubic) in values[9..].iter_mut().zip(rotation::cubics([x, y, z])) {
            *value = cubic.scale(BAND_3);
        }
    }
    values
}

/// The colour ½ + Σₖ cₖ Yₖ(d) of each channel in the unit direction d, not clamped. `coefficients` are channel-major, as in [`Splats::harmonics_of`].
///
/// # Panics
/// If there are not three channels of coefficients of this degree.
#[inline(always)]
pub fn colour<S: Scalar>(degree: Degree, coefficients: &[S], direction: [S; 3]) -> [S; 3] {
    let count = degree.coefficients();
    assert_eq!(coefficients.len(), 3 * count, "coefficients of the degree");
    let values = basis(degree, direction);
    let channel = |c: usize| {
        let channel = &coefficients[c * count..(c + 1) * count];
        channel.iter().zip(values).fold(S::constant(0.5), |sum, (&c, y)| c.mul_add(y, sum))
    };
    [channel(0), channel(1), channel(2)]
}

/// Rotates one Gaussian's colours: the coefficients of g(d) = f(Rᵀ d) in place of those of f.
///
/// Exact but for rounding, for a rotation R. What comes of other matrices is finite if they are, and means nothing.
///
/// ```
/// use gaussian_deform::{Degree, harmonics};
/// use mechanics_core::tensor::Mat3;
///
/// // A quarter turn about z takes the colour seen along x to y.
/// let turn = Mat3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
/// let mut coefficients: Vec<f64> = (0..48).map(|k| f64::from(k).sin()).collect();
/// let before = harmonics::colour(Degree::Three, &coefficients, [1.0, 0.0, 0.0]);
/// harmonics::rotate(Degree::Three, &turn, &mut coefficients);
/// let after = harmonics::colour(Degree::Three, &coefficients, [0.0, 1.0, 0.0]);
/// assert!((before[0] - after[0]).abs() < 1e-14);
/// ```
///
/// # Panics
/// If there are not three channels of coefficients of this degree.
#[inline(always)]
pub fn rotate<S: Scalar>(degree: Degree, rotation: &Matrix3<S>, coefficients: &mut [S]) {
    assert_eq!(coefficients.len(), degree.stride(), "coefficients of the degree");
    let rotation = ChannelRotation::new(degree, rotation);
    coefficients.chunks_exact_mut(degree.coefficients()).for_each(|channel| rotation.apply(channel));
}

/// Goes over from remembered orientations to rotated coefficients: the same colours, no [`Splats::orientations`] afterwards.
pub fn settle_orientations<E: Element>(splats: &mut Splats<E>) {
    by_precision(splats, settle_single, settle_double);
}

#[inline(never)]
fn settle_single(splats: &mut Splats<f32>) {
    settle(splats);
}

#[inline(never)]
fn settle_double(splats: &mut Splats<f64>) {
    settle(splats);
}

fn settle<E: Element>(splats: &mut Splats<E>) {
    let Some(orientations) = splats.orientations().map(<[_]>::to_vec) else { return };
    splats.set_orientations(None);
    let degree = splats.degree();
    let chunk = 1024 * degree.stride();
    parallel::for_each_chunk(splats.harmonics_mut(), chunk, |first, part| {
        let first = first / degree.stride();
        let count = part.len() / degree.stride();
        lanes::dispatch(Rotations { degree, rotations: &orientations[first..first + count], rows: part });
    });
}

/// One rotation for each consecutive row of coefficients.
struct Rotations<'a, E> {
    degree: Degree,
    rotations: &'a [Matrix3<E>],
    rows: &'a mut [E],
}

impl<E: Element> LaneKernel<E> for Rotations<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) {
        let stride = self.degree.stride();
        let packets = self.rotations.chunks(P::LANES).zip(self.rows.chunks_mut(P::LANES * stride));
        for (rotations, rows) in packets {
            let rotation = load_rotations::<P>(rotations);
            let sources: [usize; lanes::MOST_LANES] = std::array::from_fn(|lane| lane * stride);
            let mut block = Coefficients::load(self.degree, rows, &sources[..rotations.len()]);
            block.rotate(&rotation);
            block.store(rows, &sources[..rotations.len()]);
        }
    }
}

/// A rotation on each lane; the identity on lanes beyond the last one.
#[inline(always)]
pub(crate) fn load_rotations<P: Packet>(rotations: &[Matrix3<P::Element>]) -> Matrix3<P> {
    if rotations.len() == P::LANES {
        return lanes::load_matrices(rotations);
    }
    let one = P::Element::constant(1.0);
    let mut filled = [mechanics_core::tensor::multiple_of_identity(one); lanes::MOST_LANES];
    filled[..rotations.len()].copy_from_slice(rotations);
    lanes::load_matrices(&filled[..P::LANES])
}

/// Coefficients of as many Gaussians as lanes: packet k holds coefficient k of all of them.
pub(crate) struct Coefficients<P> {
    degree: Degree,
    packets: [P; 3 * MOST_COEFFICIENTS],
}

impl<P: Packet> Coefficients<P> {
    /// Of the rows that start at `starts`, one a lane.
    #[inline(always)]
    pub(crate) fn load(degree: Degree, elements: &[P::Element], starts: &[usize]) -> Self {
        let stride = degree.stride();
        let mut packets = [P::constant(0.0); 3 * MOST_COEFFICIENTS];
        for block in (0..stride).step_by(P::LANES) {
            // The last block of a row is filled up with its predecessors' entries: loads stay within the row where it has any.
            let width = P::LANES.min(stride - block);
            let rows = &mut packets[block..block + P::LANES];
            for (row, &start) in rows.iter_mut().zip(starts) {
                *row = P::load_or(&elements[start + block..start + block + width], P::Element::constant(0.0));
            }
            P::transpose(rows);
        }
        Self { degree, packets }
    }

    /// To the rows that start at `starts`, one a lane.
    #[inline(always)]
    pub(crate) fn store(mut self, elements: &mut [P::Element], starts: &[usize]) {
        let stride = self.degree.stride();
        for block in (0..stride).step_by(P::LANES) {
            let width = P::LANES.min(stride - block);
            let rows = &mut self.packets[block..block + P::LANES];
            P::transpose(rows);
            for (row, &start) in rows.iter().zip(starts) {
                row.store_prefix(&mut elements[start + block..start + block + width]);
            }
        }
    }

    #[inline(always)]
    pub(crate) fn rotate(&mut self, rotation: &Matrix3<P>) {
        let count = self.degree.coefficients();
        let rotation = ChannelRotation::new(self.degree, rotation);
        for channel in 0..3 {
            rotation.apply(&mut self.packets[channel * count..(channel + 1) * count]);
        }
    }
}
