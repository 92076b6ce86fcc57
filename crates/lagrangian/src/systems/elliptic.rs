//! The arithmetic–geometric mean, to which the periods of pendulums, tops and free bodies reduce.

/// The arithmetic–geometric mean of two numbers ≥ 0: the common limit of aₙ₊₁ = (aₙ + bₙ)/2 and bₙ₊₁ = √(aₙ bₙ).
///
/// The complete elliptic integral of the first kind with modulus k is K(k) = π / (2 agm(1, √(1 − k²))). In this form it
/// keeps full accuracy near k = 1, if the complementary modulus √(1 − k²) is known accurately: the cosine of half the amplitude of
/// a pendulum, say.
///
/// Convergence is quadratic: once b/a > ½, four more steps reach round-off. The result is within a few ε. It is 0 if an argument is 0 (then K is infinite), NaN if an argument is negative or NaN.
///
/// # Reference
/// Abramowitz, Stegun 1964, 17.6.
pub fn arithmetic_geometric_mean(a: f64, b: f64) -> f64 {
    if !(a >= 0.0 && b >= 0.0) {
        return f64::NAN;
    }
    let (mut a, mut b) = (a.max(b), a.min(b));
    if b == 0.0 || a.is_infinite() {
        return if b == 0.0 { 0.0 } else { a };
    }
    // Each step takes the root of b/a until it is near 1: 2⁻²⁰⁴⁸ takes eleven steps, and a few more do the rest.
    for _ in 0..20 {
        if a - b <= 2.0 * f64::EPSILON * a {
            break;
        }
        (a, b) = (0.5 * a + 0.5 * b, a.sqrt() * b.sqrt());
    }
    0.5 * a + 0.5 * b
}

/// The complete elliptic integral of the first kind, K = ∫₀^{π/2} dφ / √(1 − k² sin²φ), from its complementary modulus
/// k′ = √(1 − k²) in (0, 1].
pub fn complete_first_kind(complementary_modulus: f64) -> f64 {
    std::f64::consts::FRAC_PI_2 / arithmetic_geometric_mean(1.0, complementary_modulus)
}
