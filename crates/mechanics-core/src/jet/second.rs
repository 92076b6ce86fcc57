//! Second-order jets.

use crate::jet_scalar;
use crate::scalar::Scalar;
use std::ops::{AddAssign, Neg, SubAssign};

/// A value, its gradient and its Hessian in `N` variables. See the [module](super) page.
///
/// The Hessian is symmetric: only its lower triangle is computed and stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet2<S, const N: usize> {
    /// f.
    pub value: S,
    /// ∂ᵢf.
    pub gradient: [S; N],
    /// ∂ᵢⱼf in row `i ≥ j`, column `j`; zeros above the diagonal.
    lower_hessian: [[S; N]; N],
}

impl<S: Scalar, const N: usize> Jet2<S, N> {
    /// A constant over the inner scalar: zero derivatives.
    #[inline(always)]
    pub fn from_value(value: S) -> Self {
        let zero = S::constant(0.0);
        Self { value, gradient: [zero; N], lower_hessian: [[zero; N]; N] }
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

    /// ∂ᵢⱼf.
    ///
    /// # Panics
    /// If an index is not below `N`.
    #[inline(always)]
    pub fn hessian(&self, i: usize, j: usize) -> S {
        if i >= j { self.lower_hessian[i][j] } else { self.lower_hessian[j][i] }
    }

    /// The whole symmetric Hessian.
    #[inline(always)]
    pub fn hessian_matrix(&self) -> [[S; N]; N] {
        let mut full = self.lower_hessian;
        for i in 0..N {
            for j in 0..i {
                full[j][i] = full[i][j];
            }
        }
        full
    }

    /// φ(a), given φ, φ′ and φ″ at a's value.
    #[inline(always)]
    fn chain(&self, value: S, first: S, second: impl FnOnce() -> S) -> Self {
        let second = second();
        let mut jet = self.scaled_by(first);
        jet.value = value;
        for i in 0..N {
            let curved = second * self.gradient[i];
            for j in 0..=i {
                jet.lower_hessian[i][j] = curved.mul_add(self.gradient[j], jet.lower_hessian[i][j]);
            }
        }
        jet
    }

    /// φ(a, b), given φ, [φ_a, φ_b] and [φ_aa, φ_ab, φ_bb].
    #[inline(always)]
    fn chain_two(
        a: &Self,
        b: &Self,
        value: S,
        [first_a, first_b]: [S; 2],
        second: impl FnOnce() -> [S; 3],
    ) -> Self {
        let [aa, ab, bb] = second();
        let mut jet = Self::from_value(value);
        for i in 0..N {
            let (a_i, b_i) = (a.gradient[i], b.gradient[i]);
            jet.gradient[i] = first_a.mul_add(a_i, first_b * b_i);
            let (along_a, along_b) = (aa.mul_add(a_i, ab * b_i), ab.mul_add(a_i, bb * b_i));
            for j in 0..=i {
                let linear = first_a.mul_add(a.lower_hessian[i][j], first_b * b.lower_hessian[i][j]);
                jet.lower_hessian[i][j] =
                    along_a.mul_add(a.gradient[j], along_b.mul_add(b.gradient[j], linear));
            }
        }
        jet
    }

    #[inline(always)]
    fn scaled_by(&self, factor: S) -> Self {
        let mut jet = *self;
        jet.value *= factor;
        for i in 0..N {
            jet.gradient[i] *= factor;
            for j in 0..=i {
                jet.lower_hessian[i][j] *= factor;
            }
        }
        jet
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        let mut jet = Self::from_value(self.value * other.value);
        for i in 0..N {
            let (a_i, b_i) = (self.gradient[i], other.gradient[i]);
            jet.gradient[i] = self.value.mul_add(b_i, other.value * a_i);
            for j in 0..=i {
                let linear =
                    self.value.mul_add(other.lower_hessian[i][j], other.value * self.lower_hessian[i][j]);
                jet.lower_hessian[i][j] =
                    a_i.mul_add(other.gradient[j], b_i.mul_add(self.gradient[j], linear));
            }
        }
        jet
    }

    /// q = a/b: from q b = a, ∂ᵢq = (∂ᵢa − q ∂ᵢb) / b and
    /// ∂ᵢⱼq = (∂ᵢⱼa − q ∂ᵢⱼb − ∂ᵢq ∂ⱼb − ∂ⱼq ∂ᵢb) / b.
    #[inline(always)]
    fn over(&self, other: &Self) -> Self {
        let (q, r) = (self.value / other.value, other.value.recip());
        let mut jet = Self::from_value(q);
        for i in 0..N {
            let b_i = other.gradient[i];
            let q_i = (-q).mul_add(b_i, self.gradient[i]) * r;
            jet.gradient[i] = q_i;
            for j in 0..=i {
                let linear = (-q).mul_add(other.lower_hessian[i][j], self.lower_hessian[i][j]);
                let mixed = q_i.mul_add(other.gradient[j], jet.gradient[j] * b_i);
                jet.lower_hessian[i][j] = (linear - mixed) * r;
            }
        }
        jet
    }

    #[inline(always)]
    fn selected(mask: S::Mask, yes: &Self, no: &Self) -> Self {
        let mut jet = *no;
        jet.value = S::select(mask, yes.value, no.value);
        for i in 0..N {
            jet.gradient[i] = S::select(mask, yes.gradient[i], no.gradient[i]);
            for j in 0..=i {
                jet.lower_hessian[i][j] = S::select(mask, yes.lower_hessian[i][j], no.lower_hessian[i][j]);
            }
        }
        jet
    }
}

impl<S: Scalar, const N: usize> AddAssign for Jet2<S, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        for i in 0..N {
            self.gradient[i] += other.gradient[i];
            for j in 0..=i {
                self.lower_hessian[i][j] += other.lower_hessian[i][j];
            }
        }
    }
}

impl<S: Scalar, const N: usize> SubAssign for Jet2<S, N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        self.value -= other.value;
        for i in 0..N {
            self.gradient[i] -= other.gradient[i];
            for j in 0..=i {
                self.lower_hessian[i][j] -= other.lower_hessian[i][j];
            }
        }
    }
}

impl<S: Scalar, const N: usize> Neg for Jet2<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        self.value = -self.value;
        for i in 0..N {
            self.gradient[i] = -self.gradient[i];
            for j in 0..=i {
                self.lower_hessian[i][j] = -self.lower_hessian[i][j];
            }
        }
        self
    }
}

jet_scalar!(Jet2);
