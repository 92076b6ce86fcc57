//! Eigenvalues and eigenvectors of symmetric matrices.

use super::jacobi::{self, EXACT_SWEEPS_LIMIT, SORTING, TOLERANCE_IN_EPSILONS};
use crate::scalar::{Mask, Scalar};
use crate::tensor::{self, Matrix3};

/// A = Q diag(λ) Qᵀ. See [`symmetric_eigen`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymmetricEigen<S> {
    /// λ₀ ≥ λ₁ ≥ λ₂.
    pub values: [S; 3],
    /// Q, a rotation; column i belongs to λᵢ.
    pub vectors: Matrix3<S>,
}

/// The eigenvalues, descending, and eigenvectors, a rotation, of the symmetric matrix `a`, of which only the
/// upper triangle is read. Accuracy, domain and NaN: see the [module](super) page.
///
/// Approximate Jacobi sweeps as in [`svd`](super::svd) give Q; then D = Qᵀ A Q is formed anew from A and exact, ordering Jacobi rotations
/// finish it, once as a rule, until its off-diagonal is rounding error.
#[inline(always)]
pub fn symmetric_eigen<S: Scalar>(a: &Matrix3<S>) -> SymmetricEigen<S> {
    let c = tensor::columns(a);
    let (p, q, r) = (c[1][0], c[2][0], c[2][1]);
    let a = tensor::from_columns([[c[0][0], p, q], [p, c[1][1], r], [q, r, c[2][2]]]);
    let magnitude = jacobi::entry_sum(&a);
    let unit = jacobi::normaliser(magnitude);
    let a = tensor::scaled(&a, unit);
    let mut vectors = jacobi::approximate_eigenvectors(&a, jacobi::sweeps_needed::<S>());
    let tolerance = (magnitude * unit).scale(TOLERANCE_IN_EPSILONS * S::EPSILON / 3.0);
    let mut active = jacobi::every_lane::<S>();
    for _ in 0..EXACT_SWEEPS_LIMIT {
        exact_sweep(&a, &mut vectors, active);
        jacobi::orthonormalise(&mut vectors);
        let d = conjugated(&a, &vectors);
        let beyond = |i: usize, j: usize| tolerance.less(d[j][i].abs());
        active = beyond(0, 1).or(beyond(0, 2)).or(beyond(1, 2));
        if !active.any() {
            break;
        }
    }
    let d = conjugated(&a, &vectors);
    let scale = unit.recip();
    // Rayleigh's quotient qᵀ A q / qᵀ q, to first order in the rounding error of |q|².
    let value = |i: usize| d[i][i] * (S::constant(2.0) - tensor::dot(&vectors[i], &vectors[i])) * scale;
    SymmetricEigen {
        values: descending([value(0), value(1), value(2)]),
        vectors: tensor::from_columns(vectors),
    }
}

/// The values in descending order. The last sweep has sorted them already, but for rounding errors between equals.
#[inline(always)]
fn descending<S: Scalar>([a, b, c]: [S; 3]) -> [S; 3] {
    let (high, low) = (a.max(b), a.min(b));
    let between = high.min(c);
    [high.max(c), low.max(between), low.min(between)]
}

/// Qᵀ A Q.
#[inline(always)]
fn conjugated<S: Scalar>(a: &Matrix3<S>, vectors: &[[S; 3]; 3]) -> [[S; 3]; 3] {
    let q = tensor::from_columns(*vectors);
    *tensor::columns(&tensor::transpose_product(&q, &tensor::product(a, &q)))
}

/// One exact Jacobi sweep: D = Qᵀ A Q and Q turn together.
#[inline(always)]
fn exact_sweep<S: Scalar>(a: &Matrix3<S>, vectors: &mut [[S; 3]; 3], active: S::Mask) {
    let mut d = conjugated(a, vectors);
    for [p, q] in SORTING {
        let rotation = jacobi::ordering_rotation(d[p][p], d[q][q], d[q][p], active);
        jacobi::rotate(&mut d, [p, q], rotation);
        let mut rows = *tensor::columns(&tensor::transpose(&tensor::from_columns(d)));
        jacobi::rotate(&mut rows, [p, q], rotation);
        d = *tensor::columns(&tensor::transpose(&tensor::from_columns(rows)));
        jacobi::rotate(vectors, [p, q], rotation);
    }
}
