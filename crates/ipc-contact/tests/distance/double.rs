//! Double-double numbers: an unevaluated sum of two f64, about 32 digits, for reference values that hold where f64
//! formulas are mostly rounding.
//!
//! # Reference
//! T. J. Dekker, *A floating-point technique for extending the available precision*, Numer. Math. 18, 1971; D. E. Knuth,
//! *The Art of Computer Programming* 2, 4.2.2 (two-sum).

use mechanics_core::scalar::Scalar;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Double {
    pub(crate) high: f64,
    low: f64,
}

/// a + b and its rounding error.
fn two_sum(a: f64, b: f64) -> Double {
    let high = a + b;
    let part = high - a;
    Double { high, low: (a - (high - part)) + (b - part) }
}

impl From<f64> for Double {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (two_sum(self.high, other.high), two_sum(self.low, other.low));
        let sum = two_sum(high.high, high.low + low.high);
        two_sum(sum.high, sum.low + low.low)
    }
}

impl Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        let error = self.high.mul_add(other.high, -high);
        two_sum(high, error + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self - other * first.into();
        let second = rest.high / other.high;
        let rest = rest - other * second.into();
        two_sum(first, second) + (rest.high / other.high).into()
    }
}

macro_rules! assign {
    ($($of:ident $name:ident $operator:tt),*) => {$(
        impl $of for Double {
            fn $name(&mut self, other: Self) {
                *self = *self $operator other;
            }
        }
    )*};
}
assign!(AddAssign add_assign +, SubAssign sub_assign -, MulAssign mul_assign *, DivAssign div_assign /);

/// Functions that the formulas under test do not use have the accuracy of f64.
macro_rules! single {
    ($($name:ident($($argument:ident: $kind:ty),*)),* $(,)?) => {$(
        fn $name(self $(, $argument: $kind)*) -> Self {
            f64::$name(self.high $(, $argument.into())*).into()
        }
    )*};
}

impl Scalar for Double {
    type Mask = bool;
    type Value = Self;
    const EPSILON: f64 = 1e-32;
    const MIN_POSITIVE: f64 = f64::MIN_POSITIVE;

    fn value(self) -> Self {
        self
    }
    fn lift(value: Self) -> Self {
        value
    }
    fn constant(value: f64) -> Self {
        value.into()
    }
    single!(
        sqrt(), exp(), exp_m1(), ln(), ln_1p(), sin(), cos(), tan(), asin(), acos(), sinh(), cosh(), tanh(),
        powi(exponent: i32), powf(exponent: f64),
    );
    fn atan2(self, x: Self) -> Self {
        self.high.atan2(x.high).into()
    }
    fn reciprocal_power_of_two(self) -> Self {
        self.high.reciprocal_power_of_two().into()
    }
    fn abs(self) -> Self {
        if self.high < 0.0 { -self } else { self }
    }
    fn copysign(self, sign: Self) -> Self {
        if sign.high.is_sign_negative() { -self.abs() } else { self.abs() }
    }
    fn less(self, other: Self) -> bool {
        (self.high, self.low) < (other.high, other.low)
    }
    fn less_equal(self, other: Self) -> bool {
        (self.high, self.low) <= (other.high, other.low)
    }
    fn is_finite(self) -> bool {
        self.high.is_finite()
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

/// The double-double arithmetic itself: (1 + 2⁻⁶⁰)² and the quotient by it keep what f64 loses.
#[test]
fn doubles_keep_thirty_digits() {
    let small = (-60.0_f64).exp2();
    let x = Double::from(1.0) + small.into();
    let square = x * x;
    assert!((square - 1.0.into() - (2.0 * small).into()).high.abs() < 1e-32);
    assert!((square / x - x).high.abs() < 1e-31);
    let third = Double::from(1.0) / 3.0.into();
    assert!((third * 3.0.into() - 1.0.into()).high.abs() < 1e-31);
}
