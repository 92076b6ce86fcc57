//! Making a Hessian positive semi-definite, so that Newton's direction descends.

use crate::scalar::Scalar;
use nalgebra::{SMatrix, SVector};

/// What to do with the negative eigenvalues of a local Hessian.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// Nothing: the true Hessian.
    None,
    /// Negative eigenvalues become zero (Teran et al. 2005).
    #[default]
    Clamp,
    /// Negative eigenvalues change sign (Chen et al. 2024): better near incompressibility.
    Absolute,
}

impl Projection {
    /// The eigenvalue to use instead of `eigenvalue`. NaN stays NaN.
    #[inline(always)]
    pub fn apply<S: Scalar>(self, eigenvalue: S) -> S {
        match self {
            Self::None => eigenvalue,
            Self::Clamp => S::select(eigenvalue.less(S::constant(0.0)), S::constant(0.0), eigenvalue),
            Self::Absolute => eigenvalue.abs(),
        }
    }
}

/// A symmetric matrix with its eigenvalues replaced as `projection` says: Q f(Λ) Qᵀ for H = Q Λ Qᵀ.
///
/// The numeric way, for authors of new stencils whose Hessian has no closed-form eigen-system. Only the lower
/// triangle of `hessian` is read; the result is exactly symmetric. Its error, and its smallest eigenvalue if that
/// should be zero, are within N·10ε of the largest |eigenvalue|. A matrix that Cholesky's factorisation shows to be positive
/// definite, and any matrix with an entry that is not finite, is returned as it is (with the lower triangle mirrored).
///
/// Cyclic Jacobi rotations: for each pair p < q the rotation by θ with tan 2θ = 2h_pq/(h_pp − h_qq), |θ| ≤ π/4, makes
/// h_pq zero and diminishes the sum of squares off the diagonal by 2h_pq². Sweeps repeat until that sum is below
/// rounding, six to nine in practice.
///
/// # Reference
/// Golub and Van Loan, Matrix Computations (4th ed., 2013), section 8.5.
pub fn project_symmetric<const N: usize>(
    hessian: &SMatrix<f64, N, N>,
    projection: Projection,
) -> SMatrix<f64, N, N> {
    let symmetric: SMatrix<f64, N, N> =
        SMatrix::from_fn(|i, j| if i >= j { hessian[(i, j)] } else { hessian[(j, i)] });
    let largest = symmetric.amax();
    let finite = symmetric.iter().all(|entry| entry.is_finite());
    if projection == Projection::None || !finite || largest == 0.0 || is_positive_definite(&symmetric) {
        return symmetric;
    }
    // Scaled to unit size, so that squares neither overflow nor vanish.
    let (values, vectors) = symmetric_eigen(symmetric / largest);
    let scaled: SMatrix<f64, N, N> =
        SMatrix::from_fn(|i, k| vectors[(i, k)] * projection.apply(values[k]) * largest);
    SMatrix::from_fn(|i, j| {
        let (i, j) = (i.max(j), i.min(j));
        (0..N).map(|k| scaled[(i, k)] * vectors[(j, k)]).sum()
    })
}

/// Whether Cholesky's factorisation succeeds with pivots above rounding error.
fn is_positive_definite<const N: usize>(a: &SMatrix<f64, N, N>) -> bool {
    let mut l = *a;
    for j in 0..N {
        let threshold = N as f64 * f64::EPSILON * a[(j, j)];
        for k in 0..j {
            let factor = l[(j, k)];
            for i in j..N {
                l[(i, j)] -= l[(i, k)] * factor;
            }
        }
        let pivot = l[(j, j)];
        if !(pivot > threshold && pivot > 0.0) {
            return false;
        }
        let reciprocal = pivot.sqrt().recip();
        for i in j..N {
            l[(i, j)] *= reciprocal;
        }
    }
    true
}

/// Eigenvalues and eigenvectors (columns) by cyclic Jacobi rotations.
fn symmetric_eigen<const N: usize>(mut a: SMatrix<f64, N, N>) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
    const MAX_SWEEPS: usize = 30;
    let mut vectors = SMatrix::identity();
    for _ in 0..MAX_SWEEPS {
        let mut off_diagonal = 0.0;
        for q in 1..N {
            for p in 0..q {
                off_diagonal += a[(p, q)] * a[(p, q)];
            }
        }
        if off_diagonal <= f64::EPSILON * f64::EPSILON * 0.01 {
            break;
        }
        for q in 1..N {
            for p in 0..q {
                rotate(&mut a, &mut vectors, p, q);
            }
        }
    }
    (a.diagonal(), vectors)
}

/// One Jacobi rotation in the plane (p, q), which zeroes `a[(p, q)]`.
fn rotate<const N: usize>(a: &mut SMatrix<f64, N, N>, vectors: &mut SMatrix<f64, N, N>, p: usize, q: usize) {
    let off = a[(p, q)];
    if off == 0.0 {
        return;
    }
    let half_gap = 0.5 * (a[(q, q)] - a[(p, p)]);
    let tangent = off.copysign(off * half_gap) / (half_gap.abs() + half_gap.hypot(off));
    let cosine = (1.0 + tangent * tangent).sqrt().recip();
    let sine = tangent * cosine;
    let (pp, qq) = (a[(p, p)] - tangent * off, a[(q, q)] + tangent * off);
    for k in 0..N {
        let (x, y) = (a[(k, p)], a[(k, q)]);
        (a[(k, p)], a[(k, q)]) = (cosine * x - sine * y, sine * x + cosine * y);
        let (x, y) = (vectors[(k, p)], vectors[(k, q)]);
        (vectors[(k, p)], vectors[(k, q)]) = (cosine * x - sine * y, sine * x + cosine * y);
    }
    for k in 0..N {
        (a[(p, k)], a[(q, k)]) = (a[(k, p)], a[(k, q)]);
    }
    (a[(p, p)], a[(q, q)], a[(p, q)], a[(q, p)]) = (pp, qq, 0.0, 0.0);
}
