//! Two packets side by side.

use crate::scalar::{Mask, Scalar};
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// Two numbers that move together, as two lanes or two packets of lanes.
///
/// An iteration whose every operation waits for the one before leaves most of the processor idle; a second,
/// independent packet fills the gaps. Measured on the singular value decomposition, see
/// [`svd_into`](crate::decomposition::svd_into).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<P>(pub P, pub P);

impl<M: Mask> Mask for Pair<M> {
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(self.0.and(other.0), self.1.and(other.1))
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(self.0.or(other.0), self.1.or(other.1))
    }
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.not(), self.1.not())
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any() | self.1.any()
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.all() & self.1.all()
    }
}

impl<P: Scalar> Add for Pair<P> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }
}

impl<P: Scalar> AddAssign for Pair<P> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
        self.1 += other.1;
    }
}

impl<P: Scalar> Sub for Pair<P> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0, self.1 - other.1)
    }
}

impl<P: Scalar> SubAssign for Pair<P> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        self.0 -= other.0;
        self.1 -= other.1;
    }
}

impl<P: Scalar> Mul for Pair<P> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0, self.1 * other.1)
    }
}

impl<P: Scalar> MulAssign for Pair<P> {
    #[inline(always)]
    fn mul_assign(&mut self, other: Self) {
        self.0 *= other.0;
        self.1 *= other.1;
    }
}

impl<P: Scalar> Div for Pair<P> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0, self.1 / other.1)
    }
}

impl<P: Scalar> DivAssign for Pair<P> {
    #[inline(always)]
    fn div_assign(&mut self, other: Self) {
        self.0 /= other.0;
        self.1 /= other.1;
    }
}

impl<P: Scalar> Neg for Pair<P> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

/// Functions of one number, on both.
macro_rules! on_both {
    ($($function:ident)*) => {
        $(
            #[inline(always)]
            fn $function(self) -> Self {
                Self(self.0.$function(), self.1.$function())
            }
        )*
    };
}

/// Functions of two numbers, on both.
macro_rules! on_both_with {
    ($($function:ident)*) => {
        $(
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0), self.1.$function(other.1))
            }
        )*
    };
}

impl<P: Scalar> Scalar for Pair<P> {
    type Mask = Pair<P::Mask>;
    type Value = Self;
    const EPSILON: f64 = P::EPSILON;
    const MIN_POSITIVE: f64 = P::MIN_POSITIVE;

    on_both!(
        square recip sqrt exp exp_m1 ln ln_1p sin cos tan asin acos sinh cosh tanh abs reciprocal_power_of_two
    );
    on_both_with!(atan2 copysign min max);

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self(P::constant(value), P::constant(value))
    }
    #[inline(always)]
    fn value(self) -> Self {
        self
    }
    #[inline(always)]
    fn lift(value: Self) -> Self {
        value
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(self.0.mul_add(factor.0, term.0), self.1.mul_add(factor.1, term.1))
    }
    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        Self(self.0.powi(exponent), self.1.powi(exponent))
    }
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        Self(self.0.powf(exponent), self.1.powf(exponent))
    }
    #[inline(always)]
    fn less(self, other: Self) -> Self::Mask {
        Pair(self.0.less(other.0), self.1.less(other.1))
    }
    #[inline(always)]
    fn less_equal(self, other: Self) -> Self::Mask {
        Pair(self.0.less_equal(other.0), self.1.less_equal(other.1))
    }
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        Pair(self.0.is_finite(), self.1.is_finite())
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(P::select(mask.0, yes.0, no.0), P::select(mask.1, yes.1, no.1))
    }
}
