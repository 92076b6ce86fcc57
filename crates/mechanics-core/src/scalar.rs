//! The numbers that formulas are written over.
//!
//! A constitutive law, a lens of two edges or a kinetic energy is written once over [`Scalar`] and then runs as
//! `f64`, as `f32`, as eight `f32` lanes of one vector register (see [`crate::lanes`]), and through automatic
//! differentiation (see [`crate::jet`]). There is no `if` over values in such a formula: a comparison gives a
//! [`Mask`] and [`Scalar::select`] picks lane by lane.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// What a comparison of two [`Scalar`]s gives: one truth value per lane (one in all for `f64`, `f32` and jets
/// over them).
pub trait Mask: Copy + Debug + Send + Sync + 'static {
    /// Lane-wise conjunction.
    fn and(self, other: Self) -> Self;
    /// Lane-wise disjunction.
    fn or(self, other: Self) -> Self;
    /// Lane-wise negation.
    fn not(self) -> Self;
    /// Whether any lane is true.
    fn any(self) -> bool;
    /// Whether every lane is true.
    fn all(self) -> bool;
}

impl Mask for bool {
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self & other
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self | other
    }
    #[inline(always)]
    fn not(self) -> Self {
        !self
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
}

/// A number that formulas are written over: `f64`, `f32`, lanes of either, or a jet over any of them.
///
/// Arithmetic follows IEEE 754 on every lane; nothing here panics. Functions outside their real domain give NaN
/// (`ln` of a negative number) or an infinity (`ln` of zero), as the standard library's do. Differentiable
/// functions carry their derivatives through jets; `abs`, `min`, `max` and [`select`](Self::select) carry those of
/// the branch taken.
pub trait Scalar:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
{
    /// The result of comparisons.
    type Mask: Mask;

    /// The spacing of floating-point numbers at one: 2.2e-16 for everything over `f64`, 1.2e-7 over `f32`.
    const EPSILON: f64;

    /// The smallest positive normal number of the underlying format, as `f64`.
    const MIN_POSITIVE: f64;

    /// The same number without derivatives: `Self`, or what a jet is over.
    ///
    /// Iterations and case distinctions run on values; their derivatives follow from an implicit equation instead.
    type Value: Scalar<Value = Self::Value>;

    /// Whether numbers of this type carry derivatives: true for jets.
    const DIFFERENTIATES: bool = false;

    /// The number without its derivatives.
    fn value(self) -> Self::Value;

    /// A number with zero derivatives.
    fn lift(value: Self::Value) -> Self;

    /// A constant, the same on every lane, with zero derivatives. Rounded to nearest for `f32`.
    fn constant(value: f64) -> Self;

    /// `self · factor`.
    #[inline(always)]
    fn scale(self, factor: f64) -> Self {
        self * Self::constant(factor)
    }

    /// `self + term`.
    #[inline(always)]
    fn offset(self, term: f64) -> Self {
        self + Self::constant(term)
    }

    /// `self · factor + term`, fused into one rounding where the type does so at no cost.
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    /// `self²`.
    #[inline(always)]
    fn square(self) -> Self {
        self * self
    }

    /// `1 / self`.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::constant(1.0) / self
    }

    /// Square root.
    fn sqrt(self) -> Self;
    /// eˣ.
    fn exp(self) -> Self;
    /// eˣ − 1, accurate near zero.
    fn exp_m1(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// ln(1 + x), accurate near zero.
    fn ln_1p(self) -> Self;
    /// Sine, radians.
    fn sin(self) -> Self;
    /// Cosine, radians.
    fn cos(self) -> Self;
    /// Tangent, radians.
    fn tan(self) -> Self;
    /// Angle of the point (x = `x`, y = `self`), radians in (−π, π].
    fn atan2(self, x: Self) -> Self;
    /// Arc sine, radians.
    fn asin(self) -> Self;
    /// Arc cosine, radians.
    fn acos(self) -> Self;
    /// Hyperbolic sine.
    fn sinh(self) -> Self;
    /// Hyperbolic cosine.
    fn cosh(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Integer power.
    fn powi(self, exponent: i32) -> Self;
    /// Real power of a positive number.
    fn powf(self, exponent: f64) -> Self;

    /// 2⁻ᵉ with 2ᵉ ≤ |self| < 2ᵉ⁺¹: multiplying by it brings a number into [1, 2) without rounding.
    ///
    /// For |self| from [`MIN_POSITIVE`](Self::MIN_POSITIVE) up to half of the largest finite number. Zero and
    /// subnormal numbers give the largest power of two; numbers above the range, infinities and NaN give zero, an
    /// infinity or NaN, never a positive finite number.
    fn reciprocal_power_of_two(self) -> Self;

    /// Absolute value.
    fn abs(self) -> Self;
    /// |self| with the sign of `sign`, that of a zero included.
    fn copysign(self, sign: Self) -> Self;
    /// The smaller of two; the other one if one is NaN is *not* promised.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.less(other), self, other)
    }
    /// The larger of two; the other one if one is NaN is *not* promised.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.less(self), self, other)
    }

    /// `self < other`, by value.
    fn less(self, other: Self) -> Self::Mask;
    /// `self ≤ other`, by value.
    fn less_equal(self, other: Self) -> Self::Mask;
    /// Whether the value is neither infinite nor NaN.
    fn is_finite(self) -> Self::Mask;
    /// `yes` on the lanes where `mask` is true, `no` elsewhere; both are evaluated.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

macro_rules! float_scalar {
    ($float:ident, $exponent_bits:expr) => {
        impl Scalar for $float {
            type Mask = bool;
            type Value = Self;
            const EPSILON: f64 = $float::EPSILON as f64;
            const MIN_POSITIVE: f64 = $float::MIN_POSITIVE as f64;

            #[inline(always)]
            fn value(self) -> Self {
                self
            }
            #[inline(always)]
            fn lift(value: Self) -> Self {
                value
            }
            #[inline(always)]
            fn constant(value: f64) -> Self {
                value as $float
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $float::sqrt(self)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                $float::exp(self)
            }
            #[inline(always)]
            fn exp_m1(self) -> Self {
                $float::exp_m1(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                $float::ln(self)
            }
            #[inline(always)]
            fn ln_1p(self) -> Self {
                $float::ln_1p(self)
            }
            #[inline(always)]
            fn sin(self) -> Self {
                $float::sin(self)
            }
            #[inline(always)]
            fn cos(self) -> Self {
                $float::cos(self)
            }
            #[inline(always)]
            fn tan(self) -> Self {
                $float::tan(self)
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                $float::atan2(self, x)
            }
            #[inline(always)]
            fn asin(self) -> Self {
                $float::asin(self)
            }
            #[inline(always)]
            fn acos(self) -> Self {
                $float::acos(self)
            }
            #[inline(always)]
            fn sinh(self) -> Self {
                $float::sinh(self)
            }
            #[inline(always)]
            fn cosh(self) -> Self {
                $float::cosh(self)
            }
            #[inline(always)]
            fn tanh(self) -> Self {
                $float::tanh(self)
            }
            #[inline(always)]
            fn powi(self, exponent: i32) -> Self {
                $float::powi(self, exponent)
            }
            #[inline(always)]
            fn powf(self, exponent: f64) -> Self {
                $float::powf(self, exponent as $float)
            }
            #[inline(always)]
            fn reciprocal_power_of_two(self) -> Self {
                // The biased exponent E of self becomes 2·bias − E; the bits of 1 are bias, shifted.
                let exponent = self.to_bits() & $exponent_bits;
                $float::from_bits((2 * (1.0 as $float).to_bits()).wrapping_sub(exponent))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $float::abs(self)
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                $float::copysign(self, sign)
            }
            #[inline(always)]
            fn less(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn less_equal(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                $float::is_finite(self)
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
        }
    };
}

float_scalar!(f64, 0x7ff0_0000_0000_0000);
float_scalar!(f32, 0x7f80_0000);
