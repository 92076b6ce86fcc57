//! The coefficients γ_j and σ_j, from their recurrences in whole-number fractions.

/// Coefficients there are: for up to 15 steps, and the corrector's.
pub(super) const COUNT: usize = 16;

/// γ_j and σ_j, each a quotient of two whole numbers rounded at last.
pub(super) struct Coefficients {
    /// γ_j = ∫₀¹ s (s + 1) … (s + j − 1) / j! ds.
    pub velocity: [f64; COUNT],
    /// σ_j = ∫₀¹ (1 − s) s (s + 1) … (s + j − 1) / j! ds.
    pub position: [f64; COUNT],
}

pub(super) const COEFFICIENTS: Coefficients = generate();

/// A fraction in lowest terms; the denominator is positive.
#[derive(Clone, Copy)]
struct Fraction {
    numerator: i128,
    denominator: i128,
}

impl Fraction {
    const fn new(numerator: i128, denominator: i128) -> Self {
        let (mut a, mut b) = (numerator.abs(), denominator);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        Self { numerator: numerator / a, denominator: denominator / a }
    }

    /// self − other / divisor, with the least denominator, so that nothing overflows.
    const fn minus(self, other: Self, divisor: i128) -> Self {
        let term = Self::new(other.numerator, other.denominator * divisor);
        let common = Self::new(self.denominator, term.denominator);
        Self::new(
            self.numerator * common.denominator - term.numerator * common.numerator,
            self.denominator * common.denominator,
        )
    }

    const fn rounded(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }
}

/// With G(x) = Σ γ_j xʲ = ∫₀¹ (1 − x)⁻ˢ ds, S(x) = Σ σ_j xʲ = ∫₀¹ (1 − s)(1 − x)⁻ˢ ds and Λ = −ln(1 − x) = Σ xʲ/j:
///
/// - Λ G = 1/(1 − x) − 1, so Σ_{i ≤ m} γ_i / (m − i + 1) = 1;
/// - Λ S = G − 1, so Σ_{i ≤ m} σ_i / (m − i + 1) = γ_{m+1}.
const fn generate() -> Coefficients {
    let mut ones = [Fraction::new(1, 1); COUNT + 1];
    let gamma = divided(&mut ones);
    let mut shifted = [Fraction::new(0, 1); COUNT + 1];
    let mut m = 0;
    while m < COUNT {
        shifted[m] = gamma[m + 1];
        m += 1;
    }
    let sigma = divided(&mut shifted);
    let (mut velocity, mut position) = ([0.0; COUNT], [0.0; COUNT]);
    let mut j = 0;
    while j < COUNT {
        (velocity[j], position[j]) = (gamma[j].rounded(), sigma[j].rounded());
        j += 1;
    }
    Coefficients { velocity, position }
}

/// The y with Σ_{i ≤ m} y_i / (m − i + 1) = x_m.
const fn divided(x: &mut [Fraction; COUNT + 1]) -> [Fraction; COUNT + 1] {
    let mut m = 1;
    while m <= COUNT {
        let mut i = 0;
        while i < m {
            x[m] = x[m].minus(x[i], (m - i + 1) as i128);
            i += 1;
        }
        m += 1;
    }
    *x
}

#[cfg(test)]
mod tests {
    use super::{COEFFICIENTS, COUNT};

    /// ∫₀¹ f ds by the three-point Gauss rule on 128 pieces.
    fn integral(f: impl Fn(f64) -> f64) -> f64 {
        let (x, w) = ([-(0.6_f64.sqrt()), 0.0, 0.6_f64.sqrt()], [5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0]);
        let pieces = 128;
        let h = 1.0 / f64::from(pieces);
        let mut sum = 0.0;
        for piece in 0..pieces {
            for k in 0..3 {
                sum += w[k] * f(h * (f64::from(piece) + 0.5 + 0.5 * x[k]));
            }
        }
        0.5 * h * sum
    }

    #[test]
    fn coefficients_are_the_integrals() {
        let rising = |s: f64, j: usize| (0..j).map(|i| (s + i as f64) / (i + 1) as f64).product::<f64>();
        for j in 0..COUNT {
            let velocity = integral(|s| rising(s, j));
            let position = integral(|s| (1.0 - s) * rising(s, j));
            assert!((COEFFICIENTS.velocity[j] - velocity).abs() < 1e-14, "γ_{j}");
            assert!((COEFFICIENTS.position[j] - position).abs() < 1e-14, "σ_{j}");
        }
    }

    #[test]
    fn coefficients_are_the_published_ones() {
        // Hairer, Nørsett, Wanner 1993, table III.1.1.
        let published = [
            (1, 1.0 / 2.0),
            (2, 5.0 / 12.0),
            (3, 3.0 / 8.0),
            (4, 251.0 / 720.0),
            (5, 95.0 / 288.0),
            (6, 19087.0 / 60480.0),
            (7, 5257.0 / 17280.0),
            (8, 1070017.0 / 3628800.0),
        ];
        for (j, value) in published {
            assert!((COEFFICIENTS.velocity[j] - value).abs() <= f64::EPSILON * value, "γ_{j}");
        }
        // ½, 1/6, 1/8: ∫(1 − s), ∫(1 − s) s, ∫(1 − s) s (s + 1)/2.
        for (j, value) in [(0, 0.5), (1, 1.0 / 6.0), (2, 0.125)] {
            assert_eq!(COEFFICIENTS.position[j], value);
        }
    }
}
