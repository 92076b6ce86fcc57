//! The cubic τ ↦ det(F + τ dF) with a bound of its rounding error, in double and double-double arithmetic.

use crate::tensor::Mat3;
use std::ops::{Add, Mul, Neg, Sub};

/// What the coefficients are computed in.
pub(super) trait Arithmetic:
    Copy + From<f64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// Bound of the rounding error of coefficients and Horner's scheme, relative to the sum of all |products|.
    const ERROR: f64;
    /// The nearest `f64`.
    fn rounded(self) -> f64;
}

impl Arithmetic for f64 {
    /// A coefficient has 6 roundings on the way of each product and at most 6 in sums, Horner's scheme 6: 18 halves
    /// of ε, and as much again for safety.
    const ERROR: f64 = 18.0 * f64::EPSILON;
    fn rounded(self) -> f64 {
        self
    }
}

/// p(τ) = Σ cₖ τᵏ and its error bound.
#[derive(Clone, Copy, Debug)]
pub(super) struct VolumePolynomial<T> {
    coefficients: [T; 4],
    /// Bounds |error of cₖ|, with the share of evaluation.
    errors: [f64; 4],
}

impl VolumePolynomial<f64> {
    /// Coefficients in `f64`.
    pub(super) fn in_double(f: &Mat3, df: &Mat3) -> Self {
        Self::new(f, df)
    }

    /// Whether p(τ) < 0 is certain.
    pub(super) fn is_negative_at(&self, tau: f64) -> bool {
        self.value(tau) + self.error(tau) < 0.0
    }
}

impl VolumePolynomial<DoubleDouble> {
    /// Coefficients in double-double arithmetic.
    pub(super) fn in_double_double(f: &Mat3, df: &Mat3) -> Self {
        Self::new(f, df)
    }
}

impl<T: Arithmetic> VolumePolynomial<T> {
    /// The determinant is linear in each column, so with the columns a, b, c of F and d, e, f of dF
    /// det(F + τ dF) = \[abc\] + τ(\[dbc\] + \[aec\] + \[abf\]) + τ²(\[aef\] + \[dbf\] + \[dec\]) + τ³\[def\].
    fn new(matrix: &Mat3, change: &Mat3) -> Self {
        let column = |m: &Mat3, j: usize| [m[(0, j)], m[(1, j)], m[(2, j)]];
        let [a, b, c] = [0, 1, 2].map(|j| column(matrix, j));
        let [d, e, f] = [0, 1, 2].map(|j| column(change, j));
        let triple = triple_product::<T>;
        let coefficients = [
            triple(&a, &b, &c),
            triple(&d, &b, &c) + triple(&a, &e, &c) + triple(&a, &b, &f),
            triple(&a, &e, &f) + triple(&d, &b, &f) + triple(&d, &e, &c),
            triple(&d, &e, &f),
        ];
        let [a, b, c, d, e, f] = [a, b, c, d, e, f].map(|v| v.map(f64::abs));
        let sums = [
            permanent(&a, &b, &c),
            permanent(&d, &b, &c) + permanent(&a, &e, &c) + permanent(&a, &b, &f),
            permanent(&a, &e, &f) + permanent(&d, &b, &f) + permanent(&d, &e, &c),
            permanent(&d, &e, &f),
        ];
        // Products that underflow lose less than the smallest normal number, before powers of τ magnify it.
        Self { coefficients, errors: sums.map(|sum| sum * T::ERROR + f64::MIN_POSITIVE) }
    }

    /// p(τ), rounded to `f64` at the end.
    fn value(&self, tau: f64) -> f64 {
        let t = T::from(tau);
        let [c0, c1, c2, c3] = self.coefficients;
        (((c3 * t + c2) * t + c1) * t + c0).rounded()
    }

    /// p(τ) − E(τ).
    pub(super) fn lower_bound(&self, tau: f64) -> f64 {
        self.value(tau) - self.error(tau)
    }

    /// The bound E(τ) of |p(τ) − det(F + τ dF)|.
    fn error(&self, tau: f64) -> f64 {
        let [e0, e1, e2, e3] = self.errors;
        ((e3 * tau + e2) * tau + e1) * tau + e0
    }

    /// The zeros of (p − E)′ in (0, `end`), ascending; `end` in place of a missing one.
    pub(super) fn stationary_points(&self, end: f64) -> [f64; 2] {
        let slope: [f64; 3] =
            std::array::from_fn(|k| self.coefficients[k + 1].rounded() - self.errors[k + 1]);
        // Brought to order one, so that the squares below do not underflow.
        let largest = slope.iter().fold(f64::MIN_POSITIVE, |largest, c| largest.max(c.abs()));
        let [c1, c2, c3] = slope.map(|c| c / largest);
        let discriminant = c2 * c2 - 3.0 * c1 * c3;
        let q = -(c2 + discriminant.sqrt().copysign(c2));
        let (x, y) = (q / (3.0 * c3), c1 / q);
        let inside = |tau: f64| if tau > 0.0 && tau < end { tau } else { end };
        let (x, y) = (inside(x), inside(y));
        [x.min(y), x.max(y)]
    }
}

/// a · (b × c).
fn triple_product<T: Arithmetic>(a: &[f64; 3], b: &[f64; 3], c: &[f64; 3]) -> T {
    let minor = |j: usize, k: usize| T::from(b[j]) * T::from(c[k]) - T::from(b[k]) * T::from(c[j]);
    T::from(a[0]) * minor(1, 2) + T::from(a[1]) * minor(2, 0) + T::from(a[2]) * minor(0, 1)
}

/// The same with plus signs throughout.
fn permanent(a: &[f64; 3], b: &[f64; 3], c: &[f64; 3]) -> f64 {
    let minor = |j: usize, k: usize| b[j] * c[k] + b[k] * c[j];
    a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1)
}

/// The exponent e of a power of two with 2ᵉ ≈ x; 0 for x = 0.
pub(super) fn power_of_two_near(x: f64) -> i32 {
    if x > 0.0 { x.log2().floor() as i32 } else { 0 }
}

/// A 2^power, without overflow on the way.
pub(super) fn scaled_by_power(a: &Mat3, power: i32) -> Mat3 {
    let half = power / 2;
    a * 2.0_f64.powi(half) * 2.0_f64.powi(power - half)
}

/// The unevaluated sum of two `f64`, about 32 digits.
///
/// # Reference
/// Dekker, A floating-point technique for extending the available precision (Numer. Math. 18, 1971); Hida, Li, Bailey,
/// Algorithms for quad-double precision floating point arithmetic (ARITH 2001), section 3.
#[derive(Clone, Copy, Debug)]
pub(super) struct DoubleDouble {
    high: f64,
    low: f64,
}

impl DoubleDouble {
    /// a + b exactly, for |a| ≥ |b|.
    fn quick_sum(a: f64, b: f64) -> Self {
        let high = a + b;
        Self { high, low: b - (high - a) }
    }

    /// a + b exactly.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let b_part = high - a;
        Self { high, low: (a - (high - b_part)) + (b - b_part) }
    }

    /// a b exactly, by splitting each factor into two halves of 26 bits.
    fn product(a: f64, b: f64) -> Self {
        let split = |x: f64| {
            // 2²⁷ + 1. Overflows for |x| > 2⁹⁹⁶, far beyond scaled entries and their powers.
            let shifted = 134_217_729.0 * x;
            let upper = shifted - (shifted - x);
            (upper, x - upper)
        };
        let high = a * b;
        let ((a1, a0), (b1, b0)) = (split(a), split(b));
        Self { high, low: ((a1 * b1 - high) + a1 * b0 + a0 * b1) + a0 * b0 }
    }
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> Self {
        Self { high: x, low: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (Self::sum(self.high, other.high), Self::sum(self.low, other.low));
        let first = Self::quick_sum(high.high, high.low + low.high);
        Self::quick_sum(first.high, first.low + low.low)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let p = Self::product(self.high, other.high);
        Self::quick_sum(p.high, p.low + (self.high * other.low + self.low * other.high))
    }
}

impl Arithmetic for DoubleDouble {
    /// Far above the error of the arithmetic, 1e-30, and of the stationary points' own `f64` error, which enters as
    /// ε^(3/2) = 3e-24 at worst.
    const ERROR: f64 = 1e-22;
    fn rounded(self) -> f64 {
        self.high
    }
}
