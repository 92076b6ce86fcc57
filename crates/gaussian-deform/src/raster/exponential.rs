//! The one exponential of a picture.

use mechanics_core::scalar::Scalar;

/// Up to where [`decay`] keeps its word.
#[cfg(test)]
const LONGEST: f64 = 0.7;

/// e⁻⁸ˢ for 0 ≤ s ≤ 0.7: relative error below 2e-6 over `f32`, 4e-15 over `f64`.
///
/// A polynomial p(s) ≈ e⁻ˢ, squared three times. That replaces the split into an integer and a fractional power of two, for which lanes have no
/// integers: what is visible of a Gaussian is at most a factor of 255, so s is at most
/// ln(255)/8 = 0.6927. Squaring multiplies the polynomial's relative error by
/// eight: 7.9e-8 of the minimax polynomial of degree 5 (found with Remez' exchange algorithm at 60 digits) becomes 6.4e-7, rounding adds as much; in
/// double precision the Taylor polynomial of degree 15 has 1.6e-16.
#[inline(always)]
pub(crate) fn decay<S: Scalar>(s: S) -> S {
    let mut power = if S::EPSILON > 1e-10 { horner(s, &MINIMAX) } else { horner(s, &TAYLOR) };
    for _ in 0..3 {
        power = power * power;
    }
    power
}

/// Highest power first.
const MINIMAX: [f64; 6] = [
    -0.005_846_760_116_010_206,
    0.039_772_561_691_643_384,
    -0.165_973_975_381_637_38,
    0.499_882_587_325_268_42,
    -0.999_992_539_309_329_85,
    0.999_999_920_512_838_55,
];

/// (−1)ᵏ/k!, highest power first.
const TAYLOR: [f64; 16] = {
    let mut coefficients = [1.0; 16];
    let mut k = 1;
    while k < 16 {
        coefficients[15 - k] = -coefficients[16 - k] / k as f64;
        k += 1;
    }
    coefficients
};

#[inline(always)]
fn horner<S: Scalar, const N: usize>(s: S, coefficients: &[f64; N]) -> S {
    let mut sum = S::constant(coefficients[0]);
    for k in 1..N {
        sum = sum.mul_add(s, S::constant(coefficients[k]));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use mechanics_core::lanes::{self, Element, LaneKernel, Packet};

    struct Decays<'a, E>(&'a mut [E]);

    impl<E: Element> LaneKernel<E> for Decays<'_, E> {
        type Output = ();
        #[inline(always)]
        fn run<P: Packet<Element = E>>(self) {
            for chunk in self.0.chunks_mut(P::LANES) {
                decay(P::load_or(chunk, E::constant(0.0))).store_prefix(chunk);
            }
        }
    }

    /// The largest relative error over a million points of the whole range, against the standard library in double precision.
    fn largest_error<E: Element>() -> f64 {
        let points: Vec<E> = (0..=1_000_000).map(|k| E::constant(LONGEST * f64::from(k) / 1e6)).collect();
        let mut values = points.clone();
        lanes::dispatch(Decays(&mut values));
        let error = |(s, value): (&E, &E)| {
            let (s, value): (f64, f64) = ((*s).into(), (*value).into());
            (value / (-8.0 * s).exp() - 1.0).abs()
        };
        points.iter().zip(&values).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn the_error_is_as_documented() {
        let (single, double) = (largest_error::<f32>(), largest_error::<f64>());
        assert!(single < 2e-6, "f32: {single:e}");
        assert!(double < 4e-15, "f64: {double:e}");
    }

    #[test]
    fn the_most_that_blending_asks_for_is_in_range() {
        assert!(255.0_f64.ln() / 8.0 < LONGEST);
    }
}
