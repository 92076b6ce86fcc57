//! Closed forms and high-precision reference values.

use crate::cases::{Random, lame};
use mechanics_core::law::{
    FixedCorotated, Hencky, Hyperelastic, Lame, NeoHookean, StVenantKirchhoff, StableNeoHookean,
};
use mechanics_core::tensor::{Mat3, Vec3};
use serde_json::Value;

fn fixture() -> Value {
    serde_json::from_str(include_str!("../fixtures/laws_uniaxial.json")).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| value.as_str().unwrap().parse().unwrap())
}

#[test]
fn neo_hookean_uniaxial_tension() {
    let fixture = fixture();
    let rows = fixture["neo_hookean_log_uniaxial"].as_array().unwrap();
    assert_eq!(rows.len(), 32);
    for row in rows {
        let value = |key: &str| number(&row[key]);
        let lame = Lame::from_young_poisson(value("E"), value("nu")).unwrap();
        let law = NeoHookean::new(lame);
        let f = Mat3::from_diagonal(&Vec3::new(value("stretch"), value("lateral"), value("lateral")));
        let stress = law.first_piola(&f);
        // The lateral stretch is rounded, which λ/μ multiplies.
        let allowed = 1e-14 * (1.0 + lame.lambda() / lame.mu());
        assert!((stress[(0, 0)] - value("P11")).abs() <= allowed, "{row}: {stress}");
        assert!(stress[(1, 1)].abs() <= allowed && stress[(2, 2)].abs() <= allowed, "{row}: {stress}");
        assert!((law.energy_density(&f) - value("W")).abs() <= allowed, "{row}");
        assert!((stress[(0, 0)] / value("lateral").powi(2) - value("cauchy11")).abs() <= allowed, "{row}");
    }
}

#[test]
fn st_venant_kirchhoff_uniaxial_tension() {
    let fixture = fixture();
    for row in fixture["stvk_uniaxial_P11"].as_array().unwrap() {
        for poisson in [0.0, 0.3, 0.45] {
            let stretch = number(&row["stretch"]);
            let law = StVenantKirchhoff::new(Lame::from_young_poisson(1.0, poisson).unwrap());
            let lateral = (1.0 - poisson * (stretch * stretch - 1.0)).sqrt();
            let stress = law.first_piola(&Mat3::from_diagonal(&Vec3::new(stretch, lateral, lateral)));
            assert!((stress[(0, 0)] - number(&row["P"])).abs() <= 1e-14, "{row} {poisson}: {stress}");
            assert!(stress[(1, 1)].abs() <= 1e-14);
        }
    }
}

#[test]
fn hencky_uniaxial_tension() {
    // Uniaxial stress in logarithmic strain is linear: τ₁ = E ln σ₁ with ln σ₂ = −ν ln σ₁.
    for (stretch, poisson) in [(0.5_f64, 0.3), (1.5, 0.45), (3.0, -0.2)] {
        let law = Hencky::new(Lame::from_young_poisson(2.0, poisson).unwrap());
        let lateral = stretch.powf(-poisson);
        let stress = law.first_piola(&Mat3::from_diagonal(&Vec3::new(stretch, lateral, lateral)));
        assert!((stress[(0, 0)] - 2.0 * stretch.ln() / stretch).abs() <= 1e-14, "{stress}");
        assert!(stress[(1, 1)].abs() <= 1e-14 && stress[(2, 2)].abs() <= 1e-14, "{stress}");
    }
}

fn simple_shear(gamma: f64) -> Mat3 {
    Mat3::new(1.0, gamma, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
}

fn assert_close(name: &str, a: &Mat3, b: &Mat3) {
    assert!((a - b).norm() <= 1e-14 * (1.0 + b.norm()), "{name}:{a}{b}");
}

#[test]
fn simple_shear_in_closed_form() {
    let (lambda, mu) = (lame().lambda(), lame().mu());
    for gamma in [-2.0_f64, 1e-3, 0.1, 0.7, 3.0] {
        let f = simple_shear(gamma);

        // J = 1: P = μ(F − F⁻ᵀ).
        let expected = Mat3::new(0.0, gamma, 0.0, gamma, 0.0, 0.0, 0.0, 0.0, 0.0) * mu;
        assert_close("neo-Hookean", &NeoHookean::new(lame()).first_piola(&f), &expected);

        // E₁₂ = γ/2, E₂₂ = γ²/2.
        let trace = 0.5 * gamma * gamma;
        let s12 = mu * gamma;
        let (s11, s22) = (lambda * trace, lambda * trace + mu * gamma * gamma);
        let second = Mat3::new(s11, s12, 0.0, s12, s22, 0.0, 0.0, 0.0, s11);
        assert_close("St. Venant-Kirchhoff", &StVenantKirchhoff::new(lame()).first_piola(&f), &(f * second));

        // R turns by −atan(γ/2).
        let (c, s) = (2.0 / (4.0 + gamma * gamma).sqrt(), gamma / (4.0 + gamma * gamma).sqrt());
        let rotation = Mat3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0);
        let expected = (f - rotation) * (2.0 * mu);
        assert_close("fixed corotated", &FixedCorotated::new(lame()).first_piola(&f), &expected);

        // τ = 2μ ln V = μ ln(FFᵀ), a deviator along FFᵀ − ½ tr in the plane; principal stretches e^±asinh(γ/2).
        let log = (0.5 * gamma).asinh();
        let b = f * f.transpose();
        let half = 0.5 * (b[(0, 0)] + b[(1, 1)]);
        let plane =
            Mat3::new(b[(0, 0)] - half, b[(0, 1)], 0.0, b[(0, 1)], b[(1, 1)] - half, 0.0, 0.0, 0.0, 0.0);
        let kirchhoff = plane * (2.0 * mu * log / (2.0 * log).sinh());
        let expected = kirchhoff * f.try_inverse().unwrap().transpose();
        assert_close("Hencky", &Hencky::new(lame()).first_piola(&f), &expected);
    }
}

#[test]
fn stable_neo_hookean_is_the_published_energy() {
    // Equation 14 with the reparametrisation of section 3.4, from an arbitrary zero.
    let (m, l) = (4.0 / 3.0 * lame().mu(), lame().lambda() + 5.0 / 6.0 * lame().mu());
    let alpha = 1.0 + m / l - m / (4.0 * l);
    let published = |f: &Mat3| {
        let (i, j) = (f.norm_squared(), f.determinant());
        0.5 * m * (i - 3.0) + 0.5 * l * (j - alpha).powi(2) - 0.5 * m * (i + 1.0).ln()
    };
    let law = StableNeoHookean::new(lame());
    let mut random = Random::new(41);
    for case in 0..500 {
        let f = random.hard(case);
        let expected = published(&f) - published(&Mat3::identity());
        let energy = law.energy_density(&f);
        assert!((energy - expected).abs() <= 1e-13 * (1.0 + expected.abs()), "{energy} {expected} at {f}");
    }
    // A point stays under load when crushed: the energy there is above rest and falls towards it.
    assert!(law.energy_density(&Mat3::zeros()) > 0.5);
}

#[test]
fn energies_keep_their_digits_near_rest() {
    // F = diag(1 + e, 1, 1) with 1 + e exact. μ/2 (2e + e²) − μ ln(1 + e) = μ(e² − e³/3 + e⁴/4 − …).
    let (lambda, mu) = (lame().lambda(), lame().mu());
    for exponent in [-12, -20, -30, -40] {
        let e = 2.0_f64.powi(exponent);
        let f = Mat3::from_diagonal(&Vec3::new(1.0 + e, 1.0, 1.0));
        let mut shear = 0.5 * e * e;
        for n in 2..8 {
            shear += (-e).powi(n) / f64::from(n);
        }
        let expected = mu * shear + 0.5 * lambda * e.ln_1p().powi(2);
        let energy = NeoHookean::new(lame()).energy_density(&f);
        // J − 1 and ln J are of size e and rounded; the energy is of size e².
        let error = (energy / expected - 1.0).abs();
        assert!(error <= 2.0 * f64::EPSILON / e, "{energy:e} {expected:e}");
        // Turned by an angle, F itself is rounded: the strain is known to ε/e.
        let turned = Random::new(42).rotation() * f;
        for energy in [
            NeoHookean::new(lame()).energy_density(&turned) / expected,
            StableNeoHookean::new(lame()).energy_density(&turned)
                / StableNeoHookean::new(lame()).energy_density(&f),
        ] {
            assert!((energy - 1.0).abs() <= 20.0 * f64::EPSILON / e, "{energy} at strain {e:e}");
        }
    }
}
