//! First-order jets in phase space.

use mechanics_core::jet_scalar;
use mechanics_core::scalar::Scalar;
use std::ops::{AddAssign, Neg, SubAssign};

/// f(q, v, t) with its gradients in q and in v: 1 + 2N numbers.
///
/// For y = φ(a): ∂y = φ′ ∂a, in every coordinate and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseJet1<S, const N: usize> {
    /// f.
    pub value: S,
    /// ∂f/∂qᵢ.
    pub q: [S; N],
    /// ∂f/∂vᵢ.
    pub v: [S; N],
}

impl<S: Scalar, const N: usize> PhaseJet1<S, N> {
    /// A constant over the inner scalar: zero derivatives.
    #[inline(always)]
    pub fn from_value(value: S) -> Self {
        let zero = [S::constant(0.0); N];
        Self { value, q: zero, v: zero }
    }

    /// The arguments of f at (q, v): coordinates and velocities.
    #[inline(always)]
    pub fn phase(q: [S; N], v: [S; N]) -> ([Self; N], [Self; N]) {
        let one = S::constant(1.0);
        let coordinate = |i: usize| {
            let mut jet = Self::from_value(q[i]);
            jet.q[i] = one;
            jet
        };
        let velocity = |i: usize| {
            let mut jet = Self::from_value(v[i]);
            jet.v[i] = one;
            jet
        };
        (std::array::from_fn(coordinate), std::array::from_fn(velocity))
    }

    /// φ(a), given φ and φ′ at a's value.
    #[inline(always)]
    fn chain(&self, value: S, first: S, _second: impl FnOnce() -> S) -> Self {
        let mut jet = self.scaled_by(first);
        jet.value = value;
        jet
    }

    /// φ(a, b), given φ and [φ_a, φ_b].
    #[inline(always)]
    fn chain_two(
        a: &Self,
        b: &Self,
        value: S,
        [first_a, first_b]: [S; 2],
        _second: impl FnOnce() -> [S; 3],
    ) -> Self {
        let linear = |a_i: S, b_i: S| first_a.mul_add(a_i, first_b * b_i);
        let mut jet = Self::from_value(value);
        for i in 0..N {
            jet.q[i] = linear(a.q[i], b.q[i]);
            jet.v[i] = linear(a.v[i], b.v[i]);
        }
        jet
    }

    #[inline(always)]
    fn scaled_by(&self, factor: S) -> Self {
        let mut jet = *self;
        jet.value *= factor;
        for i in 0..N {
            jet.q[i] *= factor;
            jet.v[i] *= factor;
        }
        jet
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        let zero = S::constant(0.0);
        let first = [other.value, self.value];
        Self::chain_two(self, other, self.value * other.value, first, || [zero, S::constant(1.0), zero])
    }

    /// y = a/b: from y b = a, ∂y = (∂a − y ∂b) / b.
    #[inline(always)]
    fn over(&self, other: &Self) -> Self {
        let (y, r) = (self.value / other.value, other.value.recip());
        let mut jet = Self::from_value(y);
        for i in 0..N {
            jet.q[i] = (-y).mul_add(other.q[i], self.q[i]) * r;
            jet.v[i] = (-y).mul_add(other.v[i], self.v[i]) * r;
        }
        jet
    }

    #[inline(always)]
    fn selected(mask: S::Mask, yes: &Self, no: &Self) -> Self {
        let mut jet = Self::from_value(S::select(mask, yes.value, no.value));
        for i in 0..N {
            jet.q[i] = S::select(mask, yes.q[i], no.q[i]);
            jet.v[i] = S::select(mask, yes.v[i], no.v[i]);
        }
        jet
    }
}

impl<S: Scalar, const N: usize> AddAssign for PhaseJet1<S, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        for i in 0..N {
            self.q[i] += other.q[i];
            self.v[i] += other.v[i];
        }
    }
}

impl<S: Scalar, const N: usize> SubAssign for PhaseJet1<S, N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        self.value -= other.value;
        for i in 0..N {
            self.q[i] -= other.q[i];
            self.v[i] -= other.v[i];
        }
    }
}

impl<S: Scalar, const N: usize> Neg for PhaseJet1<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        self.value = -self.value;
        for i in 0..N {
            self.q[i] = -self.q[i];
            self.v[i] = -self.v[i];
        }
        self
    }
}

jet_scalar!(PhaseJet1);
