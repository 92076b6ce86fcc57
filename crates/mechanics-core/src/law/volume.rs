//! Energies near rest without cancellation.
//!
//! Line searches compare energies of neighbouring states. Near rest ½μ(tr FᵀF − 3) and −μ ln J are each of first
//! order in the strain and cancel down to second order: evaluated as written, an energy of 1e-14 μ keeps two
//! digits. The functions here are of second order term by term.

use crate::scalar::{Mask, Scalar};
use crate::tensor::{Matrix3, columns, determinant, dot, from_entries, norm_squared};

/// J = det F and what the energies of volume-coupled laws need besides.
pub(super) struct Stretch<S> {
    /// J = det F.
    pub(super) volume_ratio: S,
    /// tr FᵀF − 3, to the absolute accuracy of FᵀF − I.
    pub(super) first_invariant: S,
    /// tr FᵀF − 3 − 2(J − 1), zero to second order at rest.
    pub(super) excess: S,
}

impl<S: Scalar> Stretch<S> {
    /// With G = FᵀF − I and its invariants i₁ = tr G, i₂ = ½(i₁² − G:G), i₃ = det G:
    /// J² = det(I + G) = 1 + i₁ + i₂ + i₃, and with z = J − 1, J² − 1 = z² + 2z, hence
    ///
    /// tr FᵀF − 3 − 2z = i₁ − 2z = z² − i₂ − i₃.
    ///
    /// The right side is used for G:G < 0.1, the left one elsewhere (where the right one would cancel).
    #[inline(always)]
    pub(super) fn of(f: &Matrix3<S>) -> Self {
        let c = columns(f);
        let one = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let g = from_entries(|i, j| dot(&c[i], &c[j]).offset(-one(i, j)));
        let g_squared = norm_squared(&g);
        let i1 = crate::tensor::trace(&g);
        let i2 = (i1.square() - g_squared).scale(0.5);
        let volume_ratio = determinant(f);
        let z = volume_ratio.offset(-1.0);
        let near_rest = g_squared.less(S::constant(0.1)).and(S::constant(0.0).less(volume_ratio));
        let near = z.square() - i2 - determinant(&g);
        let excess = S::select(near_rest, near, i1 - z.scale(2.0));
        Self { volume_ratio, first_invariant: i1, excess }
    }
}
