//! Energies near rest without cancellation.
//!
//! Line searches compare energies of neighbouring states. Near rest ½μ(tr FᵀF − 3) and −μ ln J are each of first
//! order in the strain and cancel down to second order: evaluated as written, an energy of 1e-14 μ keeps two
//! digits. The functions here are of second order term by term, and start from H = F − I, which floating-point
//! subtraction gives exactly where an entry of F is between ½ and 2 times that of I.
//!
//! **What is left.** Let s = ‖C − I‖, C = FᵀF, and r = ‖H‖, which a rotation makes larger than s. C − I = H + Hᵀ + HᵀH is
//! then wrong by a few ε(s + r²), J − 1 = tr H + ½(tr²H − tr H²) + det H likewise, and an energy of order s² by a few
//! ε(1 + r²/s) of itself: by round-off alone for small displacements, and by ε/s where the body has turned. Turned far (r² > ½),
//! H is no help, and C − I is wrong by ε as FᵀF is. The entries of F are taken as exact. They rarely are: rounded to ε, they make
//! C − I wrong by ε in any case.

use crate::scalar::{Mask, Scalar};
use crate::tensor::{
    Mat3, Matrix3, columns, constant, determinant, difference, from_entries, norm_squared, trace,
    transpose_product,
};

/// C − I = FᵀF − I, twice Green's strain.
#[inline(always)]
pub(super) fn metric_change<S: Scalar>(f: &Matrix3<S>) -> Matrix3<S> {
    Displacement::of(f).metric_change(f)
}

/// H = F − I, and where it is small enough to be of use.
struct Displacement<S: Scalar> {
    h: Matrix3<S>,
    /// ‖H‖² < ½.
    is_small: S::Mask,
}

impl<S: Scalar> Displacement<S> {
    #[inline(always)]
    fn of(f: &Matrix3<S>) -> Self {
        let h = difference(f, &constant(&Mat3::identity()));
        Self { h, is_small: norm_squared(&h).less(S::constant(0.5)) }
    }

    /// H + Hᵀ + HᵀH, or FᵀF − I.
    #[inline(always)]
    fn metric_change(&self, f: &Matrix3<S>) -> Matrix3<S> {
        let (quadratic, metric) = (transpose_product(&self.h, &self.h), transpose_product(f, f));
        let (h, one) = (columns(&self.h), |i: usize, j: usize| if i == j { 1.0 } else { 0.0 });
        from_entries(|i, j| {
            let small = (h[j][i] + h[i][j]) + quadratic[(i, j)];
            S::select(self.is_small, small, metric[(i, j)].offset(-one(i, j)))
        })
    }

    /// tr H + ½(tr²H − tr H²) + det H, or J − 1.
    #[inline(always)]
    fn volume_change(&self, volume_ratio: S) -> S {
        let c = columns(&self.h);
        let minor = |i: usize, j: usize| c[i][i] * c[j][j] - c[i][j] * c[j][i];
        let quadratic = minor(0, 1) + minor(1, 2) + minor(2, 0);
        let small = trace(&self.h) + (quadratic + determinant(&self.h));
        S::select(self.is_small, small, volume_ratio.offset(-1.0))
    }
}

/// The measures of a deformation that energies are made of.
pub(super) struct Stretch<S: Scalar> {
    /// C − I.
    pub(super) metric_change: Matrix3<S>,
    /// Where ‖C − I‖² < 0.1 and J > 0.
    pub(super) near_rest: S::Mask,
    /// J = det F.
    pub(super) volume_ratio: S,
    /// J − 1.
    pub(super) volume_change: S,
    /// tr FᵀF − 3.
    pub(super) first_invariant: S,
    /// tr FᵀF − 3 − 2(J − 1), accurate near rest only.
    excess_near_rest: S,
}

impl<S: Scalar> Stretch<S> {
    /// With A = C − I and its invariants i₁ = tr A, i₂ = ½(i₁² − A:A), i₃ = det A:
    /// J² = det(I + A) = 1 + i₁ + i₂ + i₃, and with z = J − 1, J² − 1 = z² + 2z, hence
    ///
    /// tr FᵀF − 3 − 2z = i₁ − 2z = z² − i₂ − i₃,
    ///
    /// of second order term by term. It is used where A:A < 0.1 (further out it would cancel).
    #[inline(always)]
    pub(super) fn of(f: &Matrix3<S>) -> Self {
        let displacement = Displacement::of(f);
        let metric_change = displacement.metric_change(f);
        let squared = norm_squared(&metric_change);
        let i1 = trace(&metric_change);
        let i2 = (i1.square() - squared).scale(0.5);
        let volume_ratio = determinant(f);
        let volume_change = displacement.volume_change(volume_ratio);
        Self {
            metric_change,
            near_rest: squared.less(S::constant(0.1)).and(S::constant(0.0).less(volume_ratio)),
            volume_ratio,
            volume_change,
            first_invariant: i1,
            excess_near_rest: volume_change.square() - i2 - determinant(&metric_change),
        }
    }

    /// tr FᵀF − 3 − 2(J − 1).
    #[inline(always)]
    pub(super) fn excess_over_volume_change(&self) -> S {
        let far = self.first_invariant - self.volume_change.scale(2.0);
        S::select(self.near_rest, self.excess_near_rest, far)
    }

    /// ln J, and tr FᵀF − 3 − 2 ln J.
    #[inline(always)]
    pub(super) fn log_volume_and_excess(&self) -> (S, S) {
        let rest = excess_over_log(self.volume_change);
        let log = S::select(self.near_rest, self.volume_change - rest, self.volume_ratio.ln());
        let near = self.excess_near_rest + rest.scale(2.0);
        (log, S::select(self.near_rest, near, self.first_invariant - log.scale(2.0)))
    }

    /// w − ln(1 + w) with w = ¼(tr FᵀF − 3).
    #[inline(always)]
    pub(super) fn quarter_excess_over_log(&self) -> S {
        let w = self.first_invariant.scale(0.25);
        S::select(self.near_rest, excess_over_log(w), w - w.ln_1p())
    }
}

/// x − ln(1 + x) for |x| ≤ 0.3, to a few ε of itself.
///
/// With s = x/(2 + x), ln(1 + x) = 2 artanh s = 2(s + s³/3 + s⁵/5 + …) and x − 2s = x s, so that
///
/// x − ln(1 + x) = x s − 2s³(1/3 + s²/5 + s⁴/7 + …).
///
/// s² ≤ 0.0312: of the bracket thirteen terms are taken, the next is 1e-21.
#[inline(always)]
pub(super) fn excess_over_log<S: Scalar>(x: S) -> S {
    let s = x / x.offset(2.0);
    let square = s.square();
    let mut bracket = S::constant(1.0 / 27.0);
    for n in 1..13 {
        bracket = bracket.mul_add(square, S::constant(1.0 / f64::from(27 - 2 * n)));
    }
    x * s - (s * square * bracket).scale(2.0)
}
