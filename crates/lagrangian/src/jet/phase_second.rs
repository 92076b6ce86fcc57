//! Second-order jets in phase space.

use mechanics_core::jet_scalar;
use mechanics_core::scalar::Scalar;
use std::ops::{AddAssign, Neg, SubAssign};

/// f(q, v, t) with all its first and second derivatives in q and v: 1 + 3N + 2N² numbers.
///
/// For y = φ(a) and any two arguments x, z among the qᵢ and vᵢ:
///
/// - ∂y/∂x = φ′ ∂a/∂x
/// - ∂²y/∂x∂z = φ′ ∂²a/∂x∂z + φ″ ∂a/∂x ∂a/∂z
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseJet2<S, const N: usize> {
    /// f.
    pub value: S,
    /// ∂f/∂qᵢ.
    pub q: [S; N],
    /// ∂f/∂vᵢ.
    pub v: [S; N],
    /// ∂²f/∂qᵢ∂qⱼ in row `i ≥ j`, column `j`; zeros above the diagonal.
    lower_qq: [[S; N]; N],
    /// ∂²f/∂vᵢ∂qⱼ in row `i`, column `j`.
    pub vq: [[S; N]; N],
    /// ∂²f/∂vᵢ∂vⱼ in row `i ≥ j`, column `j`; zeros above the diagonal.
    lower_vv: [[S; N]; N],
}

impl<S: Scalar, const N: usize> PhaseJet2<S, N> {
    /// A constant over the inner scalar: zero derivatives.
    #[inline(always)]
    pub fn from_value(value: S) -> Self {
        let zero = [S::constant(0.0); N];
        Self { value, q: zero, v: zero, lower_qq: [zero; N], vq: [zero; N], lower_vv: [zero; N] }
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

    /// The whole symmetric matrix ∂²f/∂q∂q.
    #[inline(always)]
    pub fn qq_matrix(&self) -> [[S; N]; N] {
        mirrored(&self.lower_qq)
    }

    /// The whole symmetric matrix ∂²f/∂v∂v.
    #[inline(always)]
    pub fn vv_matrix(&self) -> [[S; N]; N] {
        mirrored(&self.lower_vv)
    }

    /// Derivatives of a result from those of its arguments: `linear` of every derivative, and for the second ones
    /// `curved(first derivatives of a and b in x, the same in z)` on top.
    #[inline(always)]
    fn combined(
        a: &Self,
        b: &Self,
        value: S,
        linear: impl Fn(S, S) -> S,
        curved: impl Fn([S; 2], [S; 2], S) -> S,
    ) -> Self {
        let mut jet = Self::from_value(value);
        for i in 0..N {
            let (q_i, v_i) = ([a.q[i], b.q[i]], [a.v[i], b.v[i]]);
            jet.q[i] = linear(q_i[0], q_i[1]);
            jet.v[i] = linear(v_i[0], v_i[1]);
            for j in 0..N {
                let q_j = [a.q[j], b.q[j]];
                jet.vq[i][j] = curved(v_i, q_j, linear(a.vq[i][j], b.vq[i][j]));
                if j <= i {
                    let flat = linear(a.lower_qq[i][j], b.lower_qq[i][j]);
                    jet.lower_qq[i][j] = curved(q_i, q_j, flat);
                    let flat = linear(a.lower_vv[i][j], b.lower_vv[i][j]);
                    jet.lower_vv[i][j] = curved(v_i, [a.v[j], b.v[j]], flat);
                }
            }
        }
        jet
    }

    /// φ(a), given φ, φ′ and φ″ at a's value.
    #[inline(always)]
    fn chain(&self, value: S, first: S, second: impl FnOnce() -> S) -> Self {
        let second = second();
        let curved = |x: [S; 2], z: [S; 2], flat: S| (second * x[0]).mul_add(z[0], flat);
        Self::combined(self, self, value, |a, _| a * first, curved)
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
        let linear = |a: S, b: S| first_a.mul_add(a, first_b * b);
        let curved = |x: [S; 2], z: [S; 2], flat: S| {
            let along_b = ab.mul_add(x[0], bb * x[1]).mul_add(z[1], flat);
            aa.mul_add(x[0], ab * x[1]).mul_add(z[0], along_b)
        };
        Self::combined(a, b, value, linear, curved)
    }

    #[inline(always)]
    fn scaled_by(&self, factor: S) -> Self {
        Self::combined(self, self, self.value * factor, |a, _| a * factor, |_, _, flat| flat)
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        let linear = |a: S, b: S| self.value.mul_add(b, other.value * a);
        let curved = |x: [S; 2], z: [S; 2], flat: S| x[0].mul_add(z[1], x[1].mul_add(z[0], flat));
        Self::combined(self, other, self.value * other.value, linear, curved)
    }

    /// y = a/b: from y b = a, ∂ₓy = (∂ₓa − y ∂ₓb) / b and ∂ₓ∂_z y = (∂ₓ∂_z a − y ∂ₓ∂_z b − ∂ₓy ∂_z b − ∂_z y ∂ₓb) / b.
    #[inline(always)]
    fn over(&self, other: &Self) -> Self {
        let (y, r) = (self.value / other.value, other.value.recip());
        let linear = |a: S, b: S| (-y).mul_add(b, a) * r;
        let curved = |x: [S; 2], z: [S; 2], flat: S| {
            let mixed = linear(x[0], x[1]).mul_add(z[1], linear(z[0], z[1]) * x[1]);
            (-r).mul_add(mixed, flat)
        };
        Self::combined(self, other, y, linear, curved)
    }

    #[inline(always)]
    fn selected(mask: S::Mask, yes: &Self, no: &Self) -> Self {
        let pick = |yes: S, no: S| S::select(mask, yes, no);
        Self::combined(yes, no, pick(yes.value, no.value), pick, |_, _, flat| flat)
    }
}

#[inline(always)]
fn mirrored<S: Copy, const N: usize>(lower: &[[S; N]; N]) -> [[S; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i >= j { lower[i][j] } else { lower[j][i] }))
}

impl<S: Scalar, const N: usize> AddAssign for PhaseJet2<S, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = Self::combined(self, &other, self.value + other.value, |a, b| a + b, |_, _, flat| flat);
    }
}

impl<S: Scalar, const N: usize> SubAssign for PhaseJet2<S, N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = Self::combined(self, &other, self.value - other.value, |a, b| a - b, |_, _, flat| flat);
    }
}

impl<S: Scalar, const N: usize> Neg for PhaseJet2<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::combined(&self, &self, -self.value, |a, _| -a, |_, _, flat| flat)
    }
}

jet_scalar!(PhaseJet2);
