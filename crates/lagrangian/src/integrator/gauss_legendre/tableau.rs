//! The coefficients of Gauss–Legendre collocation, computed to twice the precision of a float.
//!
//! Nodes cᵢ = (1 + xᵢ)/2 at the zeros xᵢ of the Legendre polynomial P_s, weights bᵢ = 1/((1 − xᵢ²) P′_s(xᵢ)²), and
//! aᵢⱼ = ∫₀^cᵢ ℓⱼ with the Lagrange polynomials ℓⱼ of the nodes. As the rule is exact up to degree 2s − 1, the Legendre
//! expansion of ℓⱼ is bⱼ Σₖ (2k+1) Pₖ(xⱼ) Pₖ(2τ − 1), and ∫₀^c Pₖ(2τ − 1) dτ = (Pₖ₊₁ − Pₖ₋₁)/(2(2k+1)) at x = 2c − 1, so
//!
//! aᵢⱼ = bⱼ ( cᵢ + ½ Σₖ₌₁^{s−1} Pₖ(xⱼ) (Pₖ₊₁(xᵢ) − Pₖ₋₁(xᵢ)) ).
//!
//! Rounding bᵢ to a float breaks the condition of symplecticity bᵢaᵢⱼ + bⱼaⱼᵢ = bᵢbⱼ by 1e-17, always with the same
//! sign; energy then drifts by rounding (Hairer, McLachlan, Razakarivony 2008). So the tableau keeps what rounding
//! takes from the coefficients.

use std::ops::{Add, Mul, Neg, Sub};

/// The coefficients of the method with `S` stages.
#[derive(Clone, Debug)]
pub(crate) struct Tableau<const S: usize> {
    /// cᵢ.
    pub nodes: [f64; S],
    /// bᵢ, rounded.
    pub weights: [f64; S],
    /// bᵢ minus its rounded value.
    pub weights_lost: [f64; S],
    /// aᵢⱼ, rounded.
    pub stages: [[f64; S]; S],
    /// aᵢⱼ minus its rounded value.
    pub stages_lost: [[f64; S]; S],
}

impl<const S: usize> Tableau<S> {
    /// Computes the coefficients.
    ///
    /// # Panics
    /// If `S` is zero or above 16.
    pub(crate) fn new() -> Self {
        assert!(S >= 1 && S <= 16, "1 to 16 stages, not {S}");
        let one = Twofold::from(1.0);
        let x: [Twofold; S] = std::array::from_fn(|i| legendre_zero(S, i));
        let c = x.map(|x| (x + one).scaled(0.5));
        let b = x.map(|x| {
            let slope = legendre_slope(S, x);
            ((one - x * x) * slope * slope).reciprocal()
        });
        let p: Vec<[Twofold; S]> = (0..=S).map(|k| x.map(|x| legendre(k, x).0)).collect();
        let a: [[Twofold; S]; S] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let sum =
                    (1..S).fold(c[i], |sum, k| sum + (p[k][j] * (p[k + 1][i] - p[k - 1][i])).scaled(0.5));
                b[j] * sum
            })
        });
        Self {
            nodes: c.map(|c| c.high),
            weights: b.map(|b| b.high),
            weights_lost: b.map(|b| b.low),
            stages: a.map(|row| row.map(|a| a.high)),
            stages_lost: a.map(|row| row.map(|a| a.low)),
        }
    }
}

/// Zero number `i` of P_s, ascending: Newton's method from Tricomi's estimate.
fn legendre_zero(s: usize, i: usize) -> Twofold {
    if 2 * i + 1 == s {
        return Twofold::from(0.0);
    }
    let angle = std::f64::consts::PI * (4 * (s - i) - 1) as f64 / (4 * s + 2) as f64;
    let mut x = Twofold::from(angle.cos());
    for _ in 0..7 {
        x = x - legendre(s, x).0 * legendre_slope(s, x).reciprocal();
    }
    x
}

/// Pₖ(x) and Pₖ₋₁(x), by j Pⱼ = (2j − 1) x Pⱼ₋₁ − (j − 1) Pⱼ₋₂.
fn legendre(k: usize, x: Twofold) -> (Twofold, Twofold) {
    let (mut now, mut before) = (Twofold::from(1.0), Twofold::from(0.0));
    for j in 1..=k {
        let next = ((x * now).scaled((2 * j - 1) as f64) - before.scaled((j - 1) as f64))
            * Twofold::from(j as f64).reciprocal();
        (now, before) = (next, now);
    }
    (now, before)
}

/// P′ₖ(x) = k (x Pₖ − Pₖ₋₁)/(x² − 1).
fn legendre_slope(k: usize, x: Twofold) -> Twofold {
    let (p, before) = legendre(k, x);
    (x * p - before).scaled(k as f64) * (x * x - Twofold::from(1.0)).reciprocal()
}

/// An unevaluated sum of two floats, about 32 digits (Dekker 1971).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Twofold {
    high: f64,
    low: f64,
}

impl Twofold {
    fn normalised(high: f64, low: f64) -> Self {
        let (high, low) = super::super::canonical::sum_and_loss(high, low);
        Self { high, low }
    }

    fn scaled(self, factor: f64) -> Self {
        self * Self::from(factor)
    }

    fn reciprocal(self) -> Self {
        let first = Self::from(1.0 / self.high);
        let two = Self::from(2.0);
        let second = first * (two - self * first);
        second * (two - self * second)
    }
}

impl From<f64> for Twofold {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Twofold {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = super::super::canonical::sum_and_loss(self.high, other.high);
        Self::normalised(high, low + (self.low + other.low))
    }
}

impl Neg for Twofold {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Twofold {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Twofold {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        // One rounding in all: the exact error of the product.
        let low = self.high.mul_add(other.high, -high);
        Self::normalised(high, low + (self.high * other.low + self.low * other.high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ bᵢ cᵢ^{k−1} = 1/k for k ≤ 2s, Σ aᵢⱼ cⱼ^{k−1} = cᵢᵏ/k for k ≤ s, bᵢaᵢⱼ + bⱼaⱼᵢ = bᵢbⱼ, all to 32 digits' end.
    fn check<const S: usize>() {
        let tableau = Tableau::<S>::new();
        let twofold = |high: f64, low: f64| Twofold { high, low };
        let x: [Twofold; S] = std::array::from_fn(|i| legendre_zero(S, i));
        let c = x.map(|x| (x + Twofold::from(1.0)).scaled(0.5));
        let b: [Twofold; S] = std::array::from_fn(|i| twofold(tableau.weights[i], tableau.weights_lost[i]));
        let a = |i: usize, j: usize| twofold(tableau.stages[i][j], tableau.stages_lost[i][j]);
        let power = |x: Twofold, k: usize| (0..k).fold(Twofold::from(1.0), |p, _| p * x);
        let near = |x: Twofold, y: Twofold, what: &str| {
            let gap = (x - y).high.abs();
            assert!(gap < 2e-30, "{S} stages: {what} is off by {gap:e}");
        };
        for k in 1..=2 * S {
            let sum = (0..S).fold(Twofold::from(0.0), |sum, i| sum + b[i] * power(c[i], k - 1));
            near(sum, Twofold::from(k as f64).reciprocal(), "quadrature");
        }
        for i in 0..S {
            for k in 1..=S {
                let sum = (0..S).fold(Twofold::from(0.0), |sum, j| sum + a(i, j) * power(c[j], k - 1));
                near(sum, power(c[i], k) * Twofold::from(k as f64).reciprocal(), "a stage");
            }
            for j in 0..S {
                near(b[i] * a(i, j) + b[j] * a(j, i), b[i] * b[j], "symplecticity");
            }
            assert!(tableau.weights_lost[i].abs() <= 0.5 * f64::EPSILON * tableau.weights[i]);
        }
    }

    #[test]
    fn coefficients_meet_the_order_conditions_to_thirty_digits() {
        check::<1>();
        check::<2>();
        check::<3>();
        check::<4>();
        check::<5>();
        check::<6>();
        check::<8>();
    }

    #[test]
    fn two_stages_are_hammer_and_hollingsworth() {
        let tableau = Tableau::<2>::new();
        let root = 3.0_f64.sqrt() / 6.0;
        for (ours, theirs) in [
            (tableau.nodes[0], 0.5 - root),
            (tableau.weights[0], 0.5),
            (tableau.stages[0][0], 0.25),
            (tableau.stages[0][1], 0.25 - root),
            (tableau.stages[1][0], 0.25 + root),
        ] {
            assert!((ours - theirs).abs() < 1e-16, "{ours} {theirs}");
        }
    }
}
