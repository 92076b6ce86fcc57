//! Bands of harmonics as symmetric traceless tensors, which rotate by multiplication with R on every index.

use super::{SQRT_3, SQRT_3_2, SQRT_5_2, SQRT_15};
use crate::splats::Degree;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Matrix3, dot};

/// What the rotation of every channel shares.
pub(crate) struct ChannelRotation<S> {
    degree: Degree,
    /// The rows of R: Rᵀ eᵢ.
    rows: [[S; 3]; 3],
    /// The seven [`cubics`] at the first and the second row.
    cubics: [[S; 7]; 2],
}

impl<S: Scalar> ChannelRotation<S> {
    #[inline(always)]
    pub(crate) fn new(degree: Degree, rotation: &Matrix3<S>) -> Self {
        let rows = *tensor::columns(&tensor::transpose(rotation));
        let cubics = if degree == Degree::Three {
            [cubics(rows[0]), cubics(rows[1])]
        } else {
            [[S::constant(0.0); 7]; 2]
        };
        Self { degree, rows, cubics }
    }

    /// Rotates the coefficients of one channel.
    #[inline(always)]
    pub(crate) fn apply(&self, channel: &mut [S]) {
        if self.degree >= Degree::One {
            self.rotate_vector(&mut channel[1..4]);
        }
        if self.degree >= Degree::Two {
            self.rotate_quadric(&mut channel[4..9]);
        }
        if self.degree >= Degree::Three {
            self.rotate_cubic(&mut channel[9..16]);
        }
    }

    /// Band 1: f(d) = v · d with v ∝ (−c₃, −c₁, c₂), so g(d) = v · Rᵀ d = (R v) · d.
    #[inline(always)]
    fn rotate_vector(&self, c: &mut [S]) {
        let v = [-c[2], -c[0], c[1]];
        let [x, y, z] = applied(&self.rows, &v);
        c.copy_from_slice(&[-y, z, -x]);
    }

    /// Band 2: f(d) = dᵀ M d with M symmetric and traceless, so g(d) = dᵀ (R M Rᵀ) d. In units of ¼√(15/π) with c = (c₄, …, c₈):
    ///
    /// M_xy = c₄, M_yz = −c₅, M_xz = −c₇, M_zz = 2c₆/√3, M_xx = c₈ − c₆/√3, M_yy = −c₈ − c₆/√3.
    #[inline(always)]
    fn rotate_quadric(&self, c: &mut [S]) {
        let third = c[2].scale(1.0 / SQRT_3);
        let (xy, yz, xz) = (c[0], -c[1], -c[3]);
        let m = [[c[4] - third, xy, xz], [xy, -c[4] - third, yz], [xz, yz, third.scale(2.0)]];
        let [x, y, z] = &self.rows;
        let (mx, my, mz) = (applied(&m, x), applied(&m, y), applied(&m, z));
        c.copy_from_slice(&[
            dot(x, &my),
            -dot(y, &mz),
            dot(z, &mz).scale(0.5 * SQRT_3),
            -dot(x, &mz),
            (dot(x, &mx) - dot(y, &my)).scale(0.5),
        ]);
    }

    /// Band 3: f(d) = T(d, d, d) with a symmetric, in every pair of indices traceless T, so g's tensor is T(Rᵀ·, Rᵀ·, Rᵀ·), whose components are T on rows rᵢ of R.
    ///
    /// In units of ¼√(7/π), with a … h the coefficients times the square roots of [`cubics`],
    ///
    /// f = a(3x²y − y³) + b xyz + c(4yz² − x²y − y³) + d(2z³ − 3x²z − 3y²z) + e(4xz² − x³ − xy²) + g(x²z − y²z) + h(x³ − 3xy²).
    ///
    /// Seven monomials of g give its seven coefficients: \[z³\] = 2d, \[xyz\] = b, \[xz²\] = 4e, \[yz²\] = 4c, \[x²z\] = g − 3d, \[x³\] = h − e, \[y³\] = −a − c.
    /// Five of them contain z: with N = ½ ∂²f/∂d² at r₃ (so that T(u, v, r₃) = uᵀN v/3), \[z³\] = r₃ᵀN r₃/3, \[xyz\] = 2 r₁ᵀN r₂, \[xz²\] = r₁ᵀN r₃, \[yz²\] = r₂ᵀN r₃,
    /// \[x²z\] = r₁ᵀN r₁. The others are \[x³\] = f(r₁), \[y³\] = f(r₂).
    #[inline(always)]
    fn rotate_cubic(&self, coefficients: &mut [S]) {
        // Loops: a closure that is not inlined would not be compiled for AVX2.
        let (at_first, at_second) = (&self.cubics[0], &self.cubics[1]);
        let mut first = coefficients[0] * at_first[0];
        let mut second = coefficients[0] * at_second[0];
        for k in 1..7 {
            first = coefficients[k].mul_add(at_first[k], first);
            second = coefficients[k].mul_add(at_second[k], second);
        }
        let n = half_hessian(&scaled_cubics(coefficients), &self.rows[2]);
        let (n1, n3) = (applied(&n, &self.rows[0]), applied(&n, &self.rows[2]));
        let [r1, r2, r3] = &self.rows;
        let d = dot(r3, &n3).scale(1.0 / 6.0);
        let e = dot(r1, &n3).scale(0.25);
        let c = dot(r2, &n3).scale(0.25);
        coefficients.copy_from_slice(&[
            (second + c).scale(1.0 / SQRT_5_2),
            dot(r2, &n1).scale(1.0 / SQRT_15),
            c.scale(-1.0 / SQRT_3_2),
            d,
            e.scale(-1.0 / SQRT_3_2),
            d.mul_add(S::constant(3.0), dot(r1, &n1)).scale(1.0 / SQRT_15),
            (first + e).scale(-1.0 / SQRT_5_2),
        ]);
    }
}

/// A matrix, given by its rows, times a vector.
#[inline(always)]
fn applied<S: Scalar>(rows: &[[S; 3]; 3], v: &[S; 3]) -> [S; 3] {
    [dot(&rows[0], v), dot(&rows[1], v), dot(&rows[2], v)]
}

/// The seven functions of band 3 as homogeneous polynomials, in units of ¼√(7/π).
#[inline(always)]
pub(super) fn cubics<S: Scalar>([x, y, z]: [S; 3]) -> [S; 7] {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let across = zz.scale(4.0) - xx - yy;
    [
        (y * (xx.scale(3.0) - yy)).scale(-SQRT_5_2),
        (x * y * z).scale(2.0 * SQRT_15),
        (y * across).scale(-SQRT_3_2),
        z * (zz.scale(2.0) - (xx + yy).scale(3.0)),
        (x * across).scale(-SQRT_3_2),
        (z * (xx - yy)).scale(SQRT_15),
        (x * (xx - yy.scale(3.0))).scale(-SQRT_5_2),
    ]
}

/// a, b/2, c, d, e, g, h of [`ChannelRotation::rotate_cubic`].
#[inline(always)]
fn scaled_cubics<S: Scalar>(c: &[S]) -> [S; 7] {
    [
        c[0].scale(-SQRT_5_2),
        c[1].scale(SQRT_15),
        c[2].scale(-SQRT_3_2),
        c[3],
        c[4].scale(-SQRT_3_2),
        c[5].scale(SQRT_15),
        c[6].scale(-SQRT_5_2),
    ]
}

/// N = ½ ∂²f/∂d² at (x, y, z), row by row.
#[inline(always)]
fn half_hessian<S: Scalar>(&[a, half_b, c, d, e, g, h]: &[S; 7], &[x, y, z]: &[S; 3]) -> [[S; 3]; 3] {
    let (a, d, h) = (a.scale(3.0), d.scale(3.0), h.scale(3.0));
    let xx = (a - c) * y + (g - d) * z + (h - e.scale(3.0)) * x;
    let zz = (c * y + e * x).scale(4.0) + (d * z).scale(2.0);
    let yy = -(xx + zz);
    let xy = (a - c) * x + half_b * z - (e + h) * y;
    let xz = half_b * y + (g - d) * x + (e * z).scale(4.0);
    let yz = half_b * x + (c * z).scale(4.0) - (d + g) * y;
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}
