//! [`Scalar`] for jets, written once from their chain rules.

/// Implements the operators and [`Scalar`](crate::scalar::Scalar) for a jet type `$jet<S, const N: usize>` from its
/// chain rules, so that a crate with other derivatives in mind than [`Jet1`](crate::jet::Jet1) and
/// [`Jet2`](crate::jet::Jet2) writes those alone.
///
/// The type is `Copy`, `Debug` and `PartialEq`, has `AddAssign`, `SubAssign` and `Neg`, a field `value: S` and these
/// inherent methods, which may be private:
///
/// - `from_value(S) -> Self`: zero derivatives;
/// - `chain(&self, φ, φ′, || φ″) -> Self`: a function of one argument, whose second derivative first-order jets never
///   ask;
/// - `chain_two(a: &Self, b: &Self, φ, [φ_a, φ_b], || [φ_aa, φ_ab, φ_bb]) -> Self`: a function of two;
/// - `times(&self, &Self)`, `over(&self, &Self)`, `scaled_by(&self, S)`, `selected(S::Mask, yes: &Self, no: &Self)`:
///   written out for speed.
#[macro_export]
macro_rules! jet_scalar {
    ($jet:ident) => {
        impl<S: $crate::scalar::Scalar, const N: usize> std::ops::Add for $jet<S, N> {
            type Output = Self;
            #[inline(always)]
            fn add(mut self, other: Self) -> Self {
                self += other;
                self
            }
        }

        impl<S: $crate::scalar::Scalar, const N: usize> std::ops::Sub for $jet<S, N> {
            type Output = Self;
            #[inline(always)]
            fn sub(mut self, other: Self) -> Self {
                self -= other;
                self
            }
        }

        impl<S: $crate::scalar::Scalar, const N: usize> std::ops::Mul for $jet<S, N> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                self.times(&other)
            }
        }

        impl<S: $crate::scalar::Scalar, const N: usize> std::ops::Div for $jet<S, N> {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                self.over(&other)
            }
        }

        impl<S: $crate::scalar::Scalar, const N: usize> std::ops::MulAssign for $jet<S, N> {
            #[inline(always)]
            fn mul_assign(&mut self, other: Self) {
                *self = self.times(&other);
            }
        }

        impl<S: $crate::scalar::Scalar, const N: usize> std::ops::DivAssign for $jet<S, N> {
            #[inline(always)]
            fn div_assign(&mut self, other: Self) {
                *self = self.over(&other);
            }
        }

        impl<S: $crate::scalar::Scalar, const N: usize> $crate::scalar::Scalar for $jet<S, N> {
            type Mask = S::Mask;
            type Value = S::Value;
            const EPSILON: f64 = S::EPSILON;
            const MIN_POSITIVE: f64 = S::MIN_POSITIVE;
            const DIFFERENTIATES: bool = true;

            #[inline(always)]
            fn value(self) -> S::Value {
                self.value.value()
            }
            #[inline(always)]
            fn lift(value: S::Value) -> Self {
                Self::from_value(S::lift(value))
            }
            #[inline(always)]
            fn constant(value: f64) -> Self {
                Self::from_value(S::constant(value))
            }
            #[inline(always)]
            fn scale(self, factor: f64) -> Self {
                self.scaled_by(S::constant(factor))
            }
            #[inline(always)]
            fn offset(mut self, term: f64) -> Self {
                self.value = self.value.offset(term);
                self
            }
            #[inline(always)]
            fn square(self) -> Self {
                self.chain(self.value.square(), self.value + self.value, || S::constant(2.0))
            }
            #[inline(always)]
            fn recip(self) -> Self {
                let r = self.value.recip();
                let first = -r.square();
                self.chain(r, first, || (first * r).scale(-2.0))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                let root = self.value.sqrt();
                let first = S::constant(0.5) / root;
                self.chain(root, first, || (first / self.value).scale(-0.5))
            }
            #[inline(always)]
            fn exp(self) -> Self {
                let e = self.value.exp();
                self.chain(e, e, || e)
            }
            #[inline(always)]
            fn exp_m1(self) -> Self {
                let e = self.value.exp();
                self.chain(self.value.exp_m1(), e, || e)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                let first = self.value.recip();
                self.chain(self.value.ln(), first, || -first.square())
            }
            #[inline(always)]
            fn ln_1p(self) -> Self {
                let first = self.value.offset(1.0).recip();
                self.chain(self.value.ln_1p(), first, || -first.square())
            }
            #[inline(always)]
            fn sin(self) -> Self {
                let s = self.value.sin();
                self.chain(s, self.value.cos(), || -s)
            }
            #[inline(always)]
            fn cos(self) -> Self {
                let c = self.value.cos();
                self.chain(c, -self.value.sin(), || -c)
            }
            #[inline(always)]
            fn tan(self) -> Self {
                let t = self.value.tan();
                let first = t.square().offset(1.0);
                self.chain(t, first, || (t * first).scale(2.0))
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                // With r² = x² + y²: ∂θ/∂y = x/r² = u, ∂θ/∂x = −y/r² = w, and of these again
                // θ_yy = 2uw, θ_yx = w² − u², θ_xx = −2uw. Divided by the larger of |x|, |y| first,
                // because r² would overflow or vanish long before the angle is in doubt.
                let (a, b) = (self.value, x.value);
                let steep = b.abs().less(a.abs());
                let large = S::select(steep, a, b);
                let ratio = S::select(steep, b, a) / large;
                let major = (large * ratio.square().offset(1.0)).recip();
                let minor = major * ratio;
                let u = S::select(steep, minor, major);
                let w = -S::select(steep, major, minor);
                Self::chain_two(&self, &x, a.atan2(b), [u, w], || {
                    let twice = (u * w).scale(2.0);
                    [twice, w.square() - u.square(), -twice]
                })
            }
            #[inline(always)]
            fn asin(self) -> Self {
                let first = $crate::jet::inverse_root_of_one_minus_square(self.value);
                self.chain(self.value.asin(), first, || self.value * first * first.square())
            }
            #[inline(always)]
            fn acos(self) -> Self {
                let first = -$crate::jet::inverse_root_of_one_minus_square(self.value);
                self.chain(self.value.acos(), first, || self.value * first * first.square())
            }
            #[inline(always)]
            fn sinh(self) -> Self {
                let s = self.value.sinh();
                self.chain(s, self.value.cosh(), || s)
            }
            #[inline(always)]
            fn cosh(self) -> Self {
                let c = self.value.cosh();
                self.chain(c, self.value.sinh(), || c)
            }
            #[inline(always)]
            fn tanh(self) -> Self {
                // 1/cosh² and not 1 − tanh²: the latter has no correct digit left from |x| = 19 on.
                let t = self.value.tanh();
                let first = self.value.cosh().recip().square();
                self.chain(t, first, || (t * first).scale(-2.0))
            }
            #[inline(always)]
            fn powi(self, exponent: i32) -> Self {
                // Exponents 0 and 1 apart: 0 · x⁻¹ is NaN at zero, where the derivative is 0.
                let n = f64::from(exponent);
                let lower = |by: i32| self.value.powi(exponent.saturating_sub(by));
                let first = if exponent == 0 { S::constant(0.0) } else { lower(1).scale(n) };
                self.chain(self.value.powi(exponent), first, || match exponent {
                    0 | 1 => S::constant(0.0),
                    _ => lower(2).scale(n * (n - 1.0)),
                })
            }
            #[inline(always)]
            fn powf(self, exponent: f64) -> Self {
                let lower = |by: f64| self.value.powf(exponent - by);
                let first = if exponent == 0.0 { S::constant(0.0) } else { lower(1.0).scale(exponent) };
                self.chain(self.value.powf(exponent), first, || {
                    if exponent == 0.0 || exponent == 1.0 {
                        S::constant(0.0)
                    } else {
                        lower(2.0).scale(exponent * (exponent - 1.0))
                    }
                })
            }
            #[inline(always)]
            fn abs(self) -> Self {
                let negative = self.value.less(S::constant(0.0));
                let mut folded = Self::selected(negative, &-self, &self);
                // Also the sign of −0.
                folded.value = self.value.abs();
                folded
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                let one = S::constant(1.0);
                // The sign that takes self to the result; its derivative is zero wherever it has one.
                self.scaled_by(one.copysign(self.value) * one.copysign(sign.value))
            }
            #[inline(always)]
            fn less(self, other: Self) -> Self::Mask {
                self.value.less(other.value)
            }
            #[inline(always)]
            fn less_equal(self, other: Self) -> Self::Mask {
                self.value.less_equal(other.value)
            }
            #[inline(always)]
            fn is_finite(self) -> Self::Mask {
                self.value.is_finite()
            }
            #[inline(always)]
            fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
                Self::selected(mask, &yes, &no)
            }
            #[inline(always)]
            fn reciprocal_power_of_two(self) -> Self {
                // Piecewise constant: its derivative is zero wherever it has one.
                Self::from_value(self.value.reciprocal_power_of_two())
            }
        }
    };
}

/// `1 / √(1 − x²)`; the product (1 − x)(1 + x) keeps its digits near x = ±1.
#[doc(hidden)]
#[inline(always)]
pub fn inverse_root_of_one_minus_square<S: crate::scalar::Scalar>(x: S) -> S {
    let one = S::constant(1.0);
    ((one - x) * (one + x)).sqrt().recip()
}
