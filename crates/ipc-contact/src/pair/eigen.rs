//! Small symmetric matrices with their eigenvalues replaced.

use mechanics_core::projection::Projection;
use mechanics_core::scalar::{Mask, Scalar};

/// Sweeps at most; five are enough for every matrix met, the bound makes an endless loop impossible.
const MOST_SWEEPS: usize = 16;

/// What the sweeps may leave off the diagonal, squared, relative to the sum of squares of all entries. The projection
/// depends on the matrix with a Lipschitz constant near one, so this leaves a relative error of 1e-12.
const TOLERANCE: f64 = 1e-24;

/// Q f(Λ) Qᵀ for A = Q Λ Qᵀ, where f is what `projection` does to an eigenvalue of the symmetric `a`, of which only the upper
/// triangle (`[p][q]`, p ≤ q) is read; all of the result is written. Positive semi-definite but for rounding for
/// [`Projection::Clamp`] and [`Projection::Absolute`], with a relative error of 1e-12 of the largest entry.
///
/// Cyclic Jacobi rotations: for each pair p < q the rotation by θ with tan 2θ = 2a_pq/(a_qq − a_pp), |θ| ≤ π/4, makes
/// a_pq zero. The matrix is scaled to unit size first by a power of two, so that squares neither overflow nor vanish.
///
/// # Reference
/// Golub and Van Loan, Matrix Computations (4th ed., 2013), section 8.5.
#[inline(always)]
pub(super) fn project<S: Scalar, const M: usize>(a: &[[S; M]; M], projection: Projection) -> [[S; M]; M] {
    let mut a = *a;
    let mut magnitude = S::constant(0.0);
    for p in 0..M {
        for q in p..M {
            magnitude += a[p][q].abs();
        }
    }
    let unit = magnitude.reciprocal_power_of_two();
    let mut vectors = [[S::constant(0.0); M]; M];
    let mut tolerance = S::constant(0.0);
    for p in 0..M {
        vectors[p][p] = S::constant(1.0);
        for q in p..M {
            a[p][q] *= unit;
            tolerance = a[p][q].mul_add(a[p][q], tolerance);
        }
    }
    tolerance = tolerance.scale(TOLERANCE);
    for _ in 0..MOST_SWEEPS {
        let mut off_diagonal = S::constant(0.0);
        for p in 0..M {
            for q in p + 1..M {
                off_diagonal = a[p][q].mul_add(a[p][q], off_diagonal);
            }
        }
        if !tolerance.less(off_diagonal).any() {
            break;
        }
        sweep(&mut a, &mut vectors);
    }
    let scale = unit.recip();
    let mut values = [S::constant(0.0); M];
    for p in 0..M {
        values[p] = projection.apply(a[p][p]) * scale;
    }
    recompose(&values, &vectors)
}

/// Q Λ Qᵀ; row k of `vectors` is the eigenvector of value k.
#[inline(always)]
fn recompose<S: Scalar, const M: usize>(values: &[S; M], vectors: &[[S; M]; M]) -> [[S; M]; M] {
    let mut result = [[S::constant(0.0); M]; M];
    for k in 0..M {
        for p in 0..M {
            let scaled = values[k] * vectors[k][p];
            for q in p..M {
                result[p][q] = scaled.mul_add(vectors[k][q], result[p][q]);
            }
        }
    }
    for p in 0..M {
        for q in 0..p {
            result[p][q] = result[q][p];
        }
    }
    result
}

/// One rotation for each pair.
#[inline(always)]
fn sweep<S: Scalar, const M: usize>(a: &mut [[S; M]; M], vectors: &mut [[S; M]; M]) {
    for p in 0..M {
        for q in p + 1..M {
            let off = a[p][q];
            let half_gap = (a[q][q] - a[p][p]).scale(0.5);
            let root = half_gap.mul_add(half_gap, off.square()).sqrt();
            // The smallest number there is makes the rotation of nothing the identity.
            let denominator = half_gap.abs() + root + S::constant(S::MIN_POSITIVE);
            let tangent = off.copysign(off * half_gap) / denominator;
            let cosine = tangent.mul_add(tangent, S::constant(1.0)).sqrt().recip();
            let sine = tangent * cosine;
            a[p][p] -= tangent * off;
            a[q][q] += tangent * off;
            a[p][q] = S::constant(0.0);
            for k in 0..M {
                if k != p && k != q {
                    let (kp, kq) = (a[k.min(p)][k.max(p)], a[k.min(q)][k.max(q)]);
                    a[k.min(p)][k.max(p)] = cosine * kp - sine * kq;
                    a[k.min(q)][k.max(q)] = sine.mul_add(kp, cosine * kq);
                }
                let (kp, kq) = (vectors[p][k], vectors[q][k]);
                vectors[p][k] = cosine * kp - sine * kq;
                vectors[q][k] = sine.mul_add(kp, cosine * kq);
            }
        }
    }
}
