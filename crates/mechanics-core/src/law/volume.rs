//! Energies near rest without cancellation.
//!
//! Line searches compare energies of neighbouring states. Near rest ½μ(tr FᵀF − 3) and −μ ln J are each of first
//! order in the strain and cancel down to second order: evaluated as written, an energy of 1e-14 μ keeps two
//! digits. The functions here are of second order term by term.

use crate::scalar::{Mask, Scalar};
use crate::tensor::{Matrix3, columns, determinant, dot, from_entries, norm_squared, trace};

/// J = det F, and tr FᵀF in a form that can be compared with functions of J near rest.
pub(super) struct Stretch<S: Scalar> {
    /// J = det F.
    pub(super) volume_ratio: S,
    /// tr FᵀF − 3, to the absolute accuracy of FᵀF − I.
    pub(super) first_invariant: S,
    /// tr FᵀF − 3 − 2(J − 1), accurate near rest only.
    excess_near_rest: S,
    near_rest: S::Mask,
}

impl<S: Scalar> Stretch<S> {
    /// With G = FᵀF − I and its invariants i₁ = tr G, i₂ = ½(i₁² − G:G), i₃ = det G:
    /// J² = det(I + G) = 1 + i₁ + i₂ + i₃, and with z = J − 1, J² − 1 = z² + 2z, hence
    ///
    /// tr FᵀF − 3 − 2z = i₁ − 2z = z² − i₂ − i₃,
    ///
    /// of second order term by term. It is used where G:G < 0.1 (further out it would cancel).
    #[inline(always)]
    pub(super) fn of(f: &Matrix3<S>) -> Self {
        let c = columns(f);
        let one = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let g = from_entries(|i, j| dot(&c[i], &c[j]).offset(-one(i, j)));
        let g_squared = norm_squared(&g);
        let i1 = trace(&g);
        let i2 = (i1.square() - g_squared).scale(0.5);
        let volume_ratio = determinant(f);
        let z = volume_ratio.offset(-1.0);
        Self {
            volume_ratio,
            first_invariant: i1,
            excess_near_rest: z.square() - i2 - determinant(&g),
            near_rest: g_squared.less(S::constant(0.1)).and(S::constant(0.0).less(volume_ratio)),
        }
    }

    /// tr FᵀF − 3 − 2g for a function g(J) with g(1) = 0 and g′(1) = 1, of second order near rest if J − 1 − g is.
    #[inline(always)]
    pub(super) fn excess_over(&self, g: S) -> S {
        let near = self.excess_near_rest + (self.volume_ratio.offset(-1.0) - g).scale(2.0);
        S::select(self.near_rest, near, self.first_invariant - g.scale(2.0))
    }
}
