//! Exact arithmetic on sums of `f64`: the sign of det(F + t dF) without rounding.
//!
//! Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates (1997), sections 2.3
//! to 2.5. Valid while no product over- or underflows.

use mechanics_core::tensor::Mat3;

/// A number as an unevaluated sum of `f64` that do not overlap, ascending in magnitude.
#[derive(Clone, Debug)]
pub(crate) struct Exact(Vec<f64>);

fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

impl Exact {
    pub(crate) fn new(x: f64) -> Self {
        Self(vec![x])
    }

    fn add_number(&mut self, x: f64) {
        let mut carry = x;
        for term in &mut self.0 {
            (carry, *term) = two_sum(carry, *term);
        }
        self.0.retain(|term| *term != 0.0);
        self.0.push(carry);
    }

    pub(crate) fn plus(mut self, other: &Self) -> Self {
        for &term in &other.0 {
            self.add_number(term);
        }
        self
    }

    pub(crate) fn times(&self, x: f64) -> Self {
        let mut product = Self(Vec::new());
        for &term in &self.0 {
            let high = term * x;
            product.add_number(term.mul_add(x, -high));
            product.add_number(high);
        }
        product
    }

    pub(crate) fn sign(&self) -> f64 {
        self.0.iter().rev().find(|term| **term != 0.0).map_or(0.0, |term| term.signum())
    }
}

fn triple(a: &[f64; 3], b: &[f64; 3], c: &[f64; 3]) -> Exact {
    let mut sum = Exact::new(0.0);
    for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
        sum = sum.plus(&Exact::new(a[i]).times(b[j]).times(c[k]));
        sum = sum.plus(&Exact::new(-a[i]).times(b[k]).times(c[j]));
    }
    sum
}

/// The sign of det(F + t dF).
pub(crate) fn sign_of_volume(f: &Mat3, df: &Mat3, t: f64) -> f64 {
    let column = |m: &Mat3, j: usize| [m[(0, j)], m[(1, j)], m[(2, j)]];
    let mut total = Exact::new(0.0);
    for subset in 0..8_u32 {
        let pick = |j: usize| column(if subset >> j & 1 == 1 { df } else { f }, j);
        let mut term = triple(&pick(0), &pick(1), &pick(2));
        for _ in 0..subset.count_ones() {
            term = term.times(t);
        }
        total = total.plus(&term);
    }
    total.sign()
}

#[test]
fn exact_arithmetic_is_exact() {
    let tiny = 2.0_f64.powi(-60);
    let x = Exact::new(1.0).plus(&Exact::new(tiny)).times(1.0 + f64::EPSILON);
    let rest = x.plus(&Exact::new(-1.0)).plus(&Exact::new(-f64::EPSILON)).plus(&Exact::new(-tiny));
    assert_eq!(rest.sign(), 1.0);
    assert_eq!(rest.plus(&Exact::new(-tiny * f64::EPSILON)).sign(), 0.0);
}
