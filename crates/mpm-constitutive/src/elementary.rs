//! Logarithm and exponential of moderate arguments, without leaving the vector registers.
//!
//! The standard library's functions run lane by lane. The stretches of a solid are mostly near one, where short series do; lanes outside
//! take the standard library, and what one lane gives does not depend on the others.

use mechanics_core::scalar::{Mask, Scalar};

/// The series of [`ln`] serves [0.6, 1.7], where |s| < 0.26.
const LN_RANGE: [f64; 2] = [0.6, 1.7];
/// The series of [`exp`] serves |x| up to here.
const EXP_RANGE: f64 = 0.55;

/// ln x.
///
/// With s = (x − 1)/(x + 1), ln x = 2 artanh s = 2s Σ s²ᵏ/(2k + 1). x − 1 is exact for x in [½, 2], so that the relative error stays
/// at a few ε down to x = 1. What is cut off is below s²ⁿ/(2n + 1): 6e-18 for n = 14 and 6e-9 for n = 6 terms.
#[inline(always)]
pub(crate) fn ln<S: Scalar>(x: S) -> S {
    let terms = if S::EPSILON < 1e-10 { 14 } else { 6 };
    let s = x.offset(-1.0) / x.offset(1.0);
    let square = s.square();
    let mut sum = S::constant(1.0 / (2 * terms - 1) as f64);
    for k in (0..terms - 1).rev() {
        sum = sum.mul_add(square, S::constant(1.0 / (2 * k + 1) as f64));
    }
    let series = s * (sum + sum);
    let near = S::constant(LN_RANGE[0]).less(x).and(x.less(S::constant(LN_RANGE[1])));
    if near.all() { series } else { S::select(near, series, x.ln()) }
}

/// eˣ = 1 + Σ xᵏ/k!, to k = 15 or k = 8: what is cut off is below 4e-18 and 2e-8.
#[inline(always)]
pub(crate) fn exp<S: Scalar>(x: S) -> S {
    let series = exp_series(x).mul_add(x, S::constant(1.0));
    let near = x.abs().less(S::constant(EXP_RANGE));
    if near.all() { series } else { S::select(near, series, x.exp()) }
}

/// eˣ − 1, to a few ε of itself down to x = 0.
#[inline(always)]
pub(crate) fn exp_m1<S: Scalar>(x: S) -> S {
    let series = x * exp_series(x);
    let near = x.abs().less(S::constant(EXP_RANGE));
    if near.all() { series } else { S::select(near, series, x.exp_m1()) }
}

/// (eˣ − 1)/x = 1 + x/2 (1 + x/3 (…)).
#[inline(always)]
fn exp_series<S: Scalar>(x: S) -> S {
    let degree = if S::EPSILON < 1e-10 { 15 } else { 8 };
    let mut sum = S::constant(1.0);
    for k in (2..=degree).rev() {
        sum = (sum * x).mul_add(S::constant(1.0 / f64::from(k)), S::constant(1.0));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::{exp, exp_m1, ln};

    /// Over the whole range of doubles, the seams included, to a few units in the last place.
    #[test]
    fn equal_the_standard_library() {
        for i in -4000..4000 {
            let x = f64::from(i) * 1e-3;
            let (e, l) = (exp(x), ln(x.exp()));
            assert!((e / x.exp() - 1.0).abs() < 4.0 * f64::EPSILON, "exp {x}");
            assert!((l - x.exp().ln()).abs() <= 4.0 * f64::EPSILON * x.abs().max(1e-3), "ln exp {x}: {l}");
            let (e, l) = (exp(x as f32), ln((x as f32).exp()));
            assert!((e / (x as f32).exp() - 1.0).abs() < 4.0 * f32::EPSILON, "exp {x}");
            assert!(
                (l - (x as f32).exp().ln()).abs() <= 4.0 * f32::EPSILON * (x as f32).abs().max(1e-3),
                "ln exp {x}: {l}"
            );
        }
    }

    #[test]
    fn are_relatively_accurate_at_one_and_sane_at_the_ends() {
        for k in 1..50 {
            let z = 0.5_f64.powi(k);
            assert!((ln(1.0 + z) / z.ln_1p() - 1.0).abs() < 4.0 * f64::EPSILON, "ln(1 + {z})");
            for x in [z, -z, 3.0 * z] {
                assert!((exp_m1(x) / x.exp_m1() - 1.0).abs() < 4.0 * f64::EPSILON, "exp({x}) − 1");
                let (single, x) = (exp_m1(x as f32), x as f32);
                assert!((single / x.exp_m1() - 1.0).abs() < 4.0 * f32::EPSILON, "exp({x}) − 1");
            }
        }
        assert_eq!(
            (ln(0.0), ln(f64::INFINITY), exp(f64::NEG_INFINITY)),
            (f64::NEG_INFINITY, f64::INFINITY, 0.0)
        );
        assert!(ln(-1.0_f64).is_nan() && ln(f64::NAN).is_nan() && exp(f64::NAN).is_nan());
        assert_eq!((ln(1.0_f64), exp(0.0_f64)), (0.0, 1.0));
    }
}
