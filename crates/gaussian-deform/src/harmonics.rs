//! Colour by direction: real spherical harmonics of degree 0 to 3.
//!
//! # The basis
//! Coefficient k = l² + l + m, m = −l … l, belongs to Yₗₘ. With the unit vector d = (x, y, z) and the signs that trained scenes are written
//! with (the Condon–Shortley phase (−1)ᵐ stays in the real functions), normalised to ∫ Y² dΩ = 1 over the sphere:
//!
//! | l | m = −l … l |
//! |---|---|
//! | 0 | √(1/4π) |
//! | 1 | √(3/4π) · {−y, z, −x} |
//! | 2 | √(15/4π) · {xy, −yz, (2z² − x² − y²)/√12, −xz, (x² − y²)/2} |
//! | 3 | √(35/32π) · {−y(3x² − y²), −x(x² − 3y²)} at m = ∓3, √(105/4π) · {xyz, z(x² − y²)/2} at m = ∓2, −√(21/32π) · {y, x}(4z² − x² − y²) at m = ∓1, √(7/16π) · z(2z² − 3x² − 3y²) at m = 0 |
//!
//! The colour of one channel in direction d, from the eye to the Gaussian, is max(0, ½ + Σₖ cₖ Yₖ(d)). It is not cut at one.
//!
//! ```
//! use gaussian_deform::{Degree, harmonics};
//!
//! // Red grows towards −x: the last function of degree 1 is −√(3/4π) x.
//! let mut coefficients = [0.0; 12];
//! coefficients[3] = 0.5;
//! let colour = harmonics::colour(Degree::One, &coefficients, [-1.0, 0.0, 0.0]);
//! assert!((colour[0] - 0.7443).abs() < 1e-4 && colour[1] == 0.5);
//! ```
//!
//! # Reference
//! Ramamoorthi, Hanrahan (2001), eq. 3; Sloan (2013), appendix A2. The signs and the offset ½ are those of Kerbl et al. (2023).

use crate::splats::Degree;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor;

/// √(1/4π).
const DEGREE_0: f64 = 0.282_094_791_773_878_14;
/// √(3/4π).
const DEGREE_1: f64 = 0.488_602_511_902_919_92;
/// √(15/4π), √(5/16π), √(15/16π): of xy, yz, xz; of 2z² − x² − y²; of x² − y².
const DEGREE_2: [f64; 3] = [1.092_548_430_592_079_1, 0.315_391_565_252_520_01, 0.546_274_215_296_039_53];
/// √(35/32π), √(105/4π), √(21/32π), √(7/16π), √(105/16π), as |m| falls from 3 to 0; the last one for m = 2.
const DEGREE_3: [f64; 5] = [
    0.590_043_589_926_643_51,
    2.890_611_442_640_554_1,
    0.457_045_799_464_465_77,
    0.373_176_332_590_115_4,
    1.445_305_721_320_277,
];

/// How many functions degree 3 has.
pub const MOST_FUNCTIONS: usize = 16;

/// Y₀ … Y₁₅ in direction `d`, a unit vector. Those above the given degree are zero.
#[inline(always)]
pub fn basis<S: Scalar>(degree: Degree, d: [S; 3]) -> [S; MOST_FUNCTIONS] {
    let [x, y, z] = d;
    let mut basis = [S::constant(0.0); MOST_FUNCTIONS];
    basis[0] = S::constant(DEGREE_0);
    if degree >= Degree::One {
        basis[1] = y.scale(-DEGREE_1);
        basis[2] = z.scale(DEGREE_1);
        basis[3] = x.scale(-DEGREE_1);
    }
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, yz, xz) = (x * y, y * z, x * z);
    if degree >= Degree::Two {
        let [product, axial, planar] = DEGREE_2;
        basis[4] = xy.scale(product);
        basis[5] = yz.scale(-product);
        basis[6] = (zz.scale(2.0) - xx - yy).scale(axial);
        basis[7] = xz.scale(-product);
        basis[8] = (xx - yy).scale(planar);
    }
    if degree >= Degree::Three {
        let [three, two, one, zero, planar] = DEGREE_3;
        let ring = zz.scale(4.0) - xx - yy;
        basis[9] = (y * (xx.scale(3.0) - yy)).scale(-three);
        basis[10] = (xy * z).scale(two);
        basis[11] = (y * ring).scale(-one);
        basis[12] = (z * (zz.scale(2.0) - (xx + yy).scale(3.0))).scale(zero);
        basis[13] = (x * ring).scale(-one);
        basis[14] = (z * (xx - yy)).scale(planar);
        basis[15] = (x * (xx - yy.scale(3.0))).scale(-three);
    }
    basis
}

/// Red, green and blue in direction `d`, a unit vector from the eye to the Gaussian; at least zero, not cut at one.
///
/// # Panics
/// If there are not [`Degree::stride`] coefficients, red's first, then green's, then blue's.
#[inline(always)]
pub fn colour<S: Scalar>(degree: Degree, coefficients: &[S], d: [S; 3]) -> [S; 3] {
    unclamped(degree, coefficients, d).map(|channel| channel.max(S::constant(0.0)))
}

/// The same before it is cut off at zero.
#[inline(always)]
pub(crate) fn unclamped<S: Scalar>(degree: Degree, coefficients: &[S], d: [S; 3]) -> [S; 3] {
    assert_eq!(coefficients.len(), degree.stride(), "the coefficients of three channels");
    let basis = basis(degree, d);
    let count = degree.coefficients();
    std::array::from_fn(|channel| {
        let mut sum = S::constant(0.5);
        for k in 0..count {
            sum = coefficients[channel * count + k].mul_add(basis[k], sum);
        }
        sum
    })
}

/// The unit vector in which a Gaussian's coefficients are looked up: `offset` / ‖`offset`‖, turned by Rᵀ if the Gaussian has the orientation R
/// (see [`Splats`](crate::Splats#orientations)). `offset` leads from the eye to the mean.
#[inline(always)]
pub fn direction<S: Scalar>(offset: [S; 3], orientation: Option<&tensor::Matrix3<S>>) -> [S; 3] {
    let length = tensor::dot(&offset, &offset).sqrt();
    let d = offset.map(|x| x / length);
    match orientation {
        None => d,
        Some(rotation) => tensor::columns(rotation).map(|axis| tensor::dot(&axis, &d)),
    }
}
