//! Polynomials on one interval of time and the quadrature under them.

use crate::error::LagrangianError;

/// The Galerkin discrete Lagrangian, by which a path and its action are made discrete: polynomials of degree `s` on every interval, and the action
/// integrated by the Gauss rule with `s` points.
///
/// On an interval from t to t + h the path is q(t + c h) = Σⱼ ℓⱼ(c) qⱼ, with ℓⱼ Lagrange's polynomials on `s + 1`
/// nodes, both ends among them. The discrete Lagrangian is the smallest (stationary) value, over the nodes between
/// the ends, of
///
/// L_d = h Σᵢ bᵢ L(q(t + cᵢ h), q̇(t + cᵢ h), t + cᵢ h).
///
/// Stationary paths are those of the Gauss collocation method with `s` stages, of order `2 s` at the ends of the
/// intervals; the action has the same order.
///
/// # Reference
/// Marsden and West, *Discrete mechanics and variational integrators*, Acta Numerica 10 (2001), section 2.2.6
/// (Galerkin discrete Lagrangians). Hairer, Lubich and Wanner, *Geometric Numerical Integration*, 2nd ed. (2006),
/// section VI.6.2 (equal to a symplectic Runge–Kutta method with the quadrature's points).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Galerkin {
    /// `s`, from 1 to [`LARGEST_DEGREE`](Self::LARGEST_DEGREE).
    pub degree: usize,
}

impl Galerkin {
    /// The largest degree.
    pub const LARGEST_DEGREE: usize = 12;

    /// `s` = 1: L_d = h L((q₀ + q₁)/2, (q₁ − q₀)/h, t + h/2), that of
    /// [`DiscreteLagrangian::Midpoint`](crate::integrator::DiscreteLagrangian::Midpoint).
    pub const MIDPOINT: Self = Self { degree: 1 };

    /// The order of the action's error, and of the path's at the ends of the intervals: 2 `s`.
    pub fn order(self) -> usize {
        2 * self.degree
    }
}

/// Lagrange's polynomials on an interval [0, 1], and their values and slopes at Gauss's points.
#[derive(Clone, Debug)]
pub(super) struct Basis {
    pub(super) degree: usize,
    /// cⱼ of the `degree + 1` nodes, increasing from 0 to 1: Chebyshev's extrema.
    pub(super) nodes: Vec<f64>,
    /// The barycentric weights of the nodes.
    barycentric: Vec<f64>,
    /// The quadrature's points and weights.
    pub(super) points: Vec<Point>,
}

/// A point of the quadrature.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// cᵢ in (0, 1).
    pub(super) time: f64,
    /// bᵢ.
    pub(super) weight: f64,
    /// ℓⱼ(cᵢ).
    pub(super) values: Vec<f64>,
    /// ℓⱼ′(cᵢ).
    pub(super) slopes: Vec<f64>,
}

impl Basis {
    pub(super) fn new(rule: Galerkin) -> Result<Self, LagrangianError> {
        let degree = rule.degree;
        let largest = Galerkin::LARGEST_DEGREE;
        if degree == 0 || degree > largest {
            return Err(LagrangianError::Degree { degree, largest });
        }
        let nodes: Vec<f64> = (0..=degree)
            .map(|j| (std::f64::consts::FRAC_PI_2 * j as f64 / degree as f64).sin().powi(2))
            .collect();
        // Of Chebyshev's extrema the weights are ±1, half of that at both ends.
        let barycentric = (0..=degree)
            .map(|j| {
                let half = if j == 0 || j == degree { 0.5 } else { 1.0 };
                if j % 2 == 0 { half } else { -half }
            })
            .collect();
        let mut basis = Self { degree, nodes, barycentric, points: Vec::new() };
        basis.points = gauss(degree)
            .into_iter()
            .map(|(time, weight)| {
                let (values, slopes) = basis.at(time);
                Point { time, weight, values, slopes }
            })
            .collect();
        Ok(basis)
    }

    /// All ℓⱼ and ℓⱼ′ at `c`, by the products ℓⱼ = Π (c − cₖ)/(cⱼ − cₖ), whose denominators are the reciprocals of
    /// the barycentric weights, up to one factor that Σ ℓⱼ = 1 fixes.
    pub(super) fn at(&self, c: f64) -> (Vec<f64>, Vec<f64>) {
        let count = self.nodes.len();
        let product = |skip: &[usize]| -> f64 {
            (0..count).filter(|k| !skip.contains(k)).map(|k| c - self.nodes[k]).product()
        };
        let mut values: Vec<f64> = (0..count).map(|j| self.barycentric[j] * product(&[j])).collect();
        let mut slopes: Vec<f64> = (0..count)
            .map(|j| {
                self.barycentric[j] * (0..count).filter(|&k| k != j).map(|k| product(&[j, k])).sum::<f64>()
            })
            .collect();
        let total: f64 = values.iter().sum();
        values.iter_mut().chain(&mut slopes).for_each(|x| *x /= total);
        (values, slopes)
    }
}

/// Points and weights of Gauss's rule on [0, 1]: the roots x of Legendre's polynomial Pₙ, by Newton's method from
/// cos(π (i + 3/4)/(n + 1/2)), and 2/((1 − x²) Pₙ′(x)²) (Abramowitz and Stegun, *Handbook of Mathematical Functions*
/// (1964), 22.16.6 and 25.4.29), moved over from [−1, 1].
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let legendre = |x: f64| {
        let (mut before, mut p) = (1.0, x);
        for k in 2..=n {
            let k = k as f64;
            (before, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k);
        }
        (p, n as f64 * (before - x * p) / (1.0 - x * x))
    };
    (0..n)
        .map(|i| {
            let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            if 2 * i + 1 == n {
                x = 0.0;
            }
            // Newton's method converges quadratically from these starts: five steps reach rounding for every n here.
            for _ in 0..6 {
                let (p, slope) = legendre(x);
                x -= p / slope;
            }
            let slope = legendre(x).1;
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn basis(degree: usize) -> Basis {
        Basis::new(Galerkin { degree }).expect("a degree in range")
    }

    #[test]
    fn gauss_rules_integrate_powers_up_to_twice_their_size_exactly() {
        for n in 1..=Galerkin::LARGEST_DEGREE {
            let rule = gauss(n);
            for power in 0..2 * n {
                let sum: f64 = rule.iter().map(|(c, b)| b * c.powi(power as i32)).sum();
                let exact = 1.0 / (power as f64 + 1.0);
                assert!((sum - exact).abs() < 2e-15, "n = {n}, power {power}: {sum} for {exact}");
            }
            let beyond: f64 = rule.iter().map(|(c, b)| b * c.powi(2 * n as i32)).sum();
            let missing = 1.0 / (2.0 * n as f64 + 1.0) - beyond;
            assert!(n > 8 || missing > 1e-11, "n = {n} is not exact beyond its degree");
        }
    }

    #[test]
    fn polynomials_of_the_degree_and_their_slopes_are_reproduced() {
        for degree in 1..=Galerkin::LARGEST_DEGREE {
            let basis = basis(degree);
            for c in [0.0, 0.123, 0.5, 0.77, 1.0] {
                let (values, slopes) = basis.at(c);
                for power in 0..=degree as i32 {
                    let on = |w: &[f64]| -> f64 {
                        w.iter().zip(&basis.nodes).map(|(w, x)| w * x.powi(power)).sum()
                    };
                    let slope = if power == 0 { 0.0 } else { f64::from(power) * c.powi(power - 1) };
                    assert!((on(&values) - c.powi(power)).abs() < 1e-14);
                    assert!((on(&slopes) - slope).abs() < 1e-12, "degree {degree}, power {power}, c = {c}");
                }
            }
        }
    }

    #[test]
    fn degrees_out_of_range_are_refused() {
        for degree in [0, Galerkin::LARGEST_DEGREE + 1, usize::MAX] {
            let refused = Basis::new(Galerkin { degree }).unwrap_err();
            assert_eq!(refused, LagrangianError::Degree { degree, largest: Galerkin::LARGEST_DEGREE });
        }
    }
}
