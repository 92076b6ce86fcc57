//! Small symmetric matrices with their eigenvalues replaced, in lanes.

use mechanics_core::projection::Projection;
use mechanics_core::scalar::{Mask, Scalar};

/// Sweeps for one eigenvalue at most: the bound makes an endless loop impossible.
const MOST_SWEEPS: usize = 30;

/// An off-diagonal entry below this, relative to the sum of all |entries|, counts as zero.
const NEGLIGIBLE: f64 = 1e-16;

/// Q f(Λ) Qᵀ for A = Q Λ Qᵀ, where f is what `projection` does to an eigenvalue, of the symmetric `a`, of which only the
/// upper triangle (`[p][q]`, p ≤ q) is read; all of the result is written. M ≥ 3.
///
/// Backward stable: the result is that of a matrix that differs from `a` by rounding errors of the largest entry.
/// Positive semi-definite but for rounding for [`Projection::Clamp`] and [`Projection::Absolute`]. NaN in, NaN out.
///
/// Reflections make A tridiagonal; implicit QR sweeps with Wilkinson's shift make that diagonal, from the last row up.
/// All lanes sweep the same rows, until the last off-diagonal entry of every lane is negligible. Where an earlier
/// one is negligible on a lane, the chase of the bulge would end there; it begins anew below. The matrix is scaled to unit
/// size first by a power of two, so that squares neither overflow nor vanish.
///
/// # Reference
/// Golub and Van Loan, Matrix Computations (4th ed., 2013), sections 8.3.1 and 8.3.5.
#[inline(always)]
pub(super) fn project<S: Scalar, const M: usize>(a: &[[S; M]; M], projection: Projection) -> [[S; M]; M] {
    let mut magnitude = S::constant(0.0);
    for p in 0..M {
        for q in p..M {
            magnitude += a[p][q].abs();
        }
    }
    let unit = magnitude.reciprocal_power_of_two();
    let mut scaled = [[S::constant(0.0); M]; M];
    for p in 0..M {
        for q in p..M {
            scaled[p][q] = a[p][q] * unit;
            scaled[q][p] = scaled[p][q];
        }
    }
    let (mut diagonal, mut off, mut vectors) = tridiagonalise(&mut scaled);
    diagonalise(&mut diagonal, &mut off, &mut vectors, (magnitude * unit).scale(NEGLIGIBLE));
    let scale = unit.recip();
    for value in &mut diagonal {
        *value = projection.apply(*value) * scale;
    }
    recompose(&diagonal, &vectors)
}

/// Diagonal and off-diagonal of T and the columns of Q, as rows, for A = Q T Qᵀ. Destroys `a`; the last entry of the off-diagonal
/// is zero.
///
/// Step k reflects x, the part of column k below the diagonal, onto −sign(x₀)|x| e₀ by I − β v vᵀ,
/// v = x + sign(x₀)|x| e₀, β = 1/(|x|² + |x₀||x|). With p = β A v and w = p − ½β(p·v) v the rest of A becomes
/// A − v wᵀ − w vᵀ.
#[inline(always)]
fn tridiagonalise<S: Scalar, const M: usize>(a: &mut [[S; M]; M]) -> ([S; M], [S; M], [[S; M]; M]) {
    let zero = S::constant(0.0);
    let (mut diagonal, mut off) = ([zero; M], [zero; M]);
    let mut betas = [zero; M];
    for k in 0..M - 2 {
        let mut square = zero;
        for i in k + 1..M {
            square = a[k][i].mul_add(a[k][i], square);
        }
        let length = square.sqrt();
        let first = a[k][k + 1];
        // The smallest number there is makes the reflection of nothing the identity.
        let beta = length.mul_add(first.abs(), square + S::constant(S::MIN_POSITIVE)).recip();
        off[k] = -length.copysign(first);
        // Row k holds v from now on.
        a[k][k + 1] = first - off[k];
        betas[k] = beta;
        let mut w = [zero; M];
        let mut along = zero;
        for i in k + 1..M {
            let mut sum = zero;
            for j in k + 1..M {
                sum = a[i][j].mul_add(a[k][j], sum);
            }
            w[i] = sum * beta;
            along = w[i].mul_add(a[k][i], along);
        }
        let half = -(along * beta).scale(0.5);
        for i in k + 1..M {
            w[i] = half.mul_add(a[k][i], w[i]);
        }
        for i in k + 1..M {
            let (v, w_i) = (-a[k][i], -w[i]);
            for j in k + 1..M {
                a[i][j] = v.mul_add(w[j], w_i.mul_add(a[k][j], a[i][j]));
            }
        }
    }
    off[M - 2] = a[M - 2][M - 1];
    for k in 0..M {
        diagonal[k] = a[k][k];
    }
    (diagonal, off, product_of_reflections(a, &betas))
}

/// The columns, as rows, of the product of the reflections I − β v vᵀ, v in the rows of `a`, formed from the last to the first.
#[inline(always)]
fn product_of_reflections<S: Scalar, const M: usize>(a: &[[S; M]; M], betas: &[S; M]) -> [[S; M]; M] {
    let zero = S::constant(0.0);
    let mut vectors = [[zero; M]; M];
    for k in 0..M {
        vectors[k][k] = S::constant(1.0);
    }
    for k in (0..M - 2).rev() {
        for column in k + 1..M {
            let mut along = zero;
            for i in k + 1..M {
                along = vectors[column][i].mul_add(a[k][i], along);
            }
            let along = -(along * betas[k]);
            for i in k + 1..M {
                vectors[column][i] = along.mul_add(a[k][i], vectors[column][i]);
            }
        }
    }
    vectors
}

/// Makes the tridiagonal matrix diagonal and turns the vectors, the rows of `vectors`, along.
#[inline(always)]
fn diagonalise<S: Scalar, const M: usize>(
    diagonal: &mut [S; M],
    off: &mut [S; M],
    vectors: &mut [[S; M]; M],
    negligible: S,
) {
    for last in (1..M).rev() {
        for _ in 0..MOST_SWEEPS {
            if !negligible.less(off[last - 1].abs()).any() {
                break;
            }
            sweep(diagonal, off, vectors, last, negligible);
        }
        off[last - 1] = S::constant(0.0);
    }
}

/// One implicit QR sweep over rows 0 to `last`.
///
/// The shift is the eigenvalue of the last 2×2 block [a, e; e, b] nearer to b: b − e²/(δ + sign(δ)√(δ² + e²)), δ = (a − b)/2.
#[inline(always)]
fn sweep<S: Scalar, const M: usize>(
    diagonal: &mut [S; M],
    off: &mut [S; M],
    vectors: &mut [[S; M]; M],
    last: usize,
    negligible: S,
) {
    let (zero, one, least) = (S::constant(0.0), S::constant(1.0), S::constant(S::MIN_POSITIVE));
    let half_gap = (diagonal[last - 1] - diagonal[last]).scale(0.5);
    let square = off[last - 1].square();
    let root = half_gap.mul_add(half_gap, square).sqrt() + least;
    let shift = diagonal[last] - square / (half_gap + root.copysign(half_gap));
    let (mut x, mut z) = (diagonal[0] - shift, off[0]);
    for k in 0..last {
        let decoupled = (x.abs() + z.abs()).less_equal(negligible);
        if k > 0 {
            x = S::select(decoupled, diagonal[k] - shift, x);
            z = S::select(decoupled, off[k], z);
        }
        let square = x.mul_add(x, z * z);
        let idle = square.less_equal(least);
        let reciprocal = S::select(idle, zero, square.sqrt().recip());
        let c = S::select(idle, one, x * reciprocal);
        let s = z * reciprocal;
        if k > 0 {
            off[k - 1] = S::select(decoupled, zero, c.mul_add(x, s * z));
        }
        let (a, m, b) = (diagonal[k], off[k], diagonal[k + 1]);
        let (am, mb) = (c.mul_add(a, s * m), c.mul_add(m, s * b));
        let (ma, bm) = (c * m - s * a, c * b - s * m);
        diagonal[k] = c.mul_add(am, s * mb);
        diagonal[k + 1] = c * bm - s * ma;
        off[k] = c * mb - s * am;
        x = off[k];
        z = s * off[k + 1];
        off[k + 1] *= c;
        for i in 0..M {
            let (p, q) = (vectors[k][i], vectors[k + 1][i]);
            vectors[k][i] = c.mul_add(p, s * q);
            vectors[k + 1][i] = c * q - s * p;
        }
    }
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
