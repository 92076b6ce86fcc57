//! Derivatives of constraints, and the trait over which methods are written.

use super::{Holonomic, Layout};
use crate::coordinates::Coordinates;
use mechanics_core::jet::{Jet1, Jet2};
use std::fmt::Debug;
use std::ops::Range;

/// A matrix with one row per constraint and one column per coordinate.
pub trait Rows: Clone + Debug + PartialEq + Send + Sync + 'static {
    /// Zeros.
    fn zeros(rows: usize, columns: usize) -> Self;

    /// The entries, row by row.
    fn entries(&self) -> &[f64];

    /// The entries, row by row.
    fn entries_mut(&mut self) -> &mut [f64];
}

impl<const N: usize, const K: usize> Rows for [[f64; N]; K] {
    #[inline]
    fn zeros(rows: usize, columns: usize) -> Self {
        assert_eq!((rows, columns), (K, N), "an array of {K} by {N}");
        [[0.0; N]; K]
    }

    #[inline]
    fn entries(&self) -> &[f64] {
        self.as_flattened()
    }

    #[inline]
    fn entries_mut(&mut self) -> &mut [f64] {
        self.as_flattened_mut()
    }
}

impl Rows for Vec<f64> {
    fn zeros(rows: usize, columns: usize) -> Self {
        vec![0.0; rows * columns]
    }

    fn entries(&self) -> &[f64] {
        self
    }

    fn entries_mut(&mut self) -> &mut [f64] {
        self
    }
}

/// Values and first derivatives of constraints at one (t, q).
#[derive(Clone, Debug, PartialEq)]
pub struct ConstraintExpansion<M, J> {
    /// φ.
    pub value: M,
    /// G = ∂φ/∂q, one row per constraint.
    pub jacobian: J,
    /// ∂φ/∂t.
    pub rate: M,
}

impl<M: Coordinates, J: Rows> ConstraintExpansion<M, J> {
    /// Zeros for `shape` = (coordinates, constraints).
    pub fn zeros(shape: (usize, usize)) -> Self {
        let (n, count) = shape;
        Self { value: M::zeros(count), jacobian: J::zeros(count, n), rate: M::zeros(count) }
    }
}

/// The expansion that a set of constraints fills.
pub type ExpansionOf<C> =
    ConstraintExpansion<<C as ConstraintSet>::Multipliers, <C as ConstraintSet>::Jacobian>;

/// What methods read of constraints. [`Constraints`] and [`SlicedConstraints`](super::SlicedConstraints) are the two
/// implementations.
pub trait ConstraintSet: Send + Sync {
    /// How coordinates are stored.
    type Coordinates: Coordinates;
    /// One number per constraint.
    type Multipliers: Coordinates;
    /// One row per constraint, one column per coordinate.
    type Jacobian: Rows;
    /// Whether matrices are taken as full, or their zeros are looked for and left out.
    const LAYOUT: Layout;

    /// The number of coordinates, and the number of constraints.
    fn shape(&self) -> (usize, usize);

    /// Overwrites `expansion` with that at (t, q). Not checked for NaN. Entries of G outside the [support](Self::support)
    /// may be left alone.
    fn expand(&self, t: f64, q: &Self::Coordinates, expansion: &mut ExpansionOf<Self>);

    /// Overwrites `curving` with φ̈ at zero acceleration: v·φ_qq·v + 2 φ_qt·v + φ_tt, so that φ̈ = G q̈ + `curving`.
    fn curve(&self, t: f64, q: &Self::Coordinates, v: &Self::Coordinates, curving: &mut Self::Multipliers);

    /// A range outside which row `index` of G is zero for every (t, q).
    fn support(&self, index: usize) -> Range<usize>;

    /// The number of coordinates.
    #[inline]
    fn dimension(&self) -> usize {
        self.shape().0
    }

    /// The number of constraints.
    #[inline]
    fn count(&self) -> usize {
        self.shape().1
    }
}

/// A [`Holonomic`] with its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints<H, const N: usize, const K: usize> {
    /// φ.
    pub holonomic: H,
}

impl<const N: usize, const K: usize, H: Holonomic<N, K>> Constraints<H, N, K> {
    /// The derivatives of `holonomic`.
    pub fn new(holonomic: H) -> Self {
        Self { holonomic }
    }
}

impl<const N: usize, const K: usize, H: Holonomic<N, K>> ConstraintSet for Constraints<H, N, K> {
    type Coordinates = [f64; N];
    type Multipliers = [f64; K];
    type Jacobian = [[f64; N]; K];
    const LAYOUT: Layout = Layout::Dense;

    #[inline]
    fn shape(&self) -> (usize, usize) {
        (N, K)
    }

    #[inline]
    fn expand(&self, t: f64, q: &[f64; N], out: &mut ExpansionOf<Self>) {
        let in_q = self.holonomic.constraint(&Jet1::<f64, N>::variables(*q), Jet1::from_value(t));
        let in_t = self.holonomic.constraint(&q.map(Jet1::<f64, 1>::from_value), Jet1::variable(t, 0));
        for k in 0..K {
            out.value[k] = in_q[k].value;
            out.jacobian[k] = in_q[k].gradient;
            out.rate[k] = in_t[k].gradient[0];
        }
    }

    #[inline]
    fn curve(&self, t: f64, q: &[f64; N], v: &[f64; N], out: &mut [f64; K]) {
        let along = std::array::from_fn(|i| moving(q[i], v[i]));
        *out = self.holonomic.constraint(&along, moving(t, 1.0)).map(|phi| phi.hessian(0, 0));
    }

    #[inline]
    fn support(&self, _index: usize) -> Range<usize> {
        0..N
    }
}

/// x + s·rate as a jet in s at s = 0: second derivatives in s of what is computed from such numbers are those along
/// the straight line.
#[inline]
pub(super) fn moving(x: f64, rate: f64) -> Jet2<f64, 1> {
    let mut jet = Jet2::from_value(x);
    jet.gradient[0] = rate;
    jet
}
