//! First-order jets.

use crate::jet_scalar;
use crate::scalar::Scalar;
use std::ops::{AddAssign, Neg, SubAssign};

/// A value and its gradient in `N` variables. See the [module](super) page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet1<S, const N: usize> {
    /// f.
    pub value: S,
    /// ∂ᵢf.
    pub gradient: [S; N],
}

impl<S: Scalar, const N: usize> Jet1<S, N> {
    /// A constant over the inner scalar: zero gradient.
    #[inline(always)]
    pub fn from_value(value: S) -> Self {
        Self { value, gradient: [S::constant(0.0); N] }
    }

    /// The independent variable number `index`, at `value`: gradient e_`index`.
    ///
    /// # Panics
    /// If `index ≥ N`.
    #[inline(always)]
    pub fn variable(value: S, index: usize) -> Self {
        assert!(index < N, "variable {index} of a jet in {N} variables");
        let mut jet = Self::from_value(value);
        jet.gradient[index] = S::constant(1.0);
        jet
    }

    /// All `N` independent variables, at `values`.
    #[inline(always)]
    pub fn variables(values: [S; N]) -> [Self; N] {
        let mut jets = [Self::from_value(S::constant(0.0)); N];
        for i in 0..N {
            jets[i].value = values[i];
            jets[i].gradient[i] = S::constant(1.0);
        }
        jets
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
    fn chain_two(a: &Self, b: &Self, value: S, first: [S; 2], _second: impl FnOnce() -> [S; 3]) -> Self {
        let mut gradient = a.gradient;
        for i in 0..N {
            gradient[i] = first[0].mul_add(a.gradient[i], first[1] * b.gradient[i]);
        }
        Self { value, gradient }
    }

    #[inline(always)]
    fn scaled_by(&self, factor: S) -> Self {
        let mut jet = *self;
        jet.value *= factor;
        for g in &mut jet.gradient {
            *g *= factor;
        }
        jet
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        Self::chain_two(self, other, self.value * other.value, [other.value, self.value], || {
            let zero = S::constant(0.0);
            [zero, S::constant(1.0), zero]
        })
    }

    /// q = a/b: from q b = a, ∂q = (∂a − q ∂b) / b.
    #[inline(always)]
    fn over(&self, other: &Self) -> Self {
        let (q, r) = (self.value / other.value, other.value.recip());
        let mut gradient = self.gradient;
        for i in 0..N {
            gradient[i] = (-q).mul_add(other.gradient[i], gradient[i]) * r;
        }
        Self { value: q, gradient }
    }

    #[inline(always)]
    fn selected(mask: S::Mask, yes: &Self, no: &Self) -> Self {
        let mut jet = *no;
        jet.value = S::select(mask, yes.value, no.value);
        for i in 0..N {
            jet.gradient[i] = S::select(mask, yes.gradient[i], no.gradient[i]);
        }
        jet
    }
}

impl<S: Scalar, const N: usize> AddAssign for Jet1<S, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        for i in 0..N {
            self.gradient[i] += other.gradient[i];
        }
    }
}

impl<S: Scalar, const N: usize> SubAssign for Jet1<S, N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        self.value -= other.value;
        for i in 0..N {
            self.gradient[i] -= other.gradient[i];
        }
    }
}

impl<S: Scalar, const N: usize> Neg for Jet1<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        self.value = -self.value;
        for g in &mut self.gradient {
            *g = -*g;
        }
        self
    }
}

jet_scalar!(Jet1);
