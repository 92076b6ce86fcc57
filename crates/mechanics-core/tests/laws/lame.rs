//! Lamé's parameters.

use mechanics_core::law::{Lame, LawError};

#[test]
fn steel_from_the_textbook() {
    let steel = Lame::from_young_poisson(210e9, 0.3).unwrap();
    assert!((steel.mu() / 80.769_230_769_230_77e9 - 1.0).abs() < 1e-15);
    assert!((steel.lambda() / 121.153_846_153_846_15e9 - 1.0).abs() < 1e-15);
    assert!((steel.bulk_modulus() / 175e9 - 1.0).abs() < 1e-15);
    // √((λ + 2μ)/ρ) with ρ = 7850 kg/m³.
    assert!((steel.pressure_wave_speed(7850.0) - 6_001.0).abs() < 1.0);
    assert!((steel.shear_wave_speed(7850.0) - 3_207.7).abs() < 0.1);
}

#[test]
fn conversions_return() {
    for young in [1e-3, 1.0, 1e6, 2e11] {
        for poisson in [-0.99, -0.5, 0.0, 0.25, 0.3, 0.45, 0.499, 0.4999999] {
            let lame = Lame::from_young_poisson(young, poisson).unwrap();
            // 1 − 2ν and 1 + ν carry the rounding of ν.
            let condition = 1.0 / (1.0 - 2.0 * poisson_abs(poisson)).abs().min(1.0 + poisson);
            assert!((lame.young_modulus() / young - 1.0).abs() < 1e-15 * (1.0 + condition));
            assert!((lame.poisson_ratio() - poisson).abs() < 1e-15 * (1.0 + condition));
            let again = Lame::from_bulk_shear(lame.bulk_modulus(), lame.mu()).unwrap();
            assert!((again.lambda() - lame.lambda()).abs() < 1e-15 * lame.bulk_modulus() * 2.0);
        }
    }
}

fn poisson_abs(poisson: f64) -> f64 {
    poisson.max(0.0)
}

#[test]
fn nonsense_is_refused_with_its_value() {
    for young in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        match Lame::from_young_poisson(young, 0.3) {
            Err(LawError::YoungModulus { value }) => assert!(value == young || young.is_nan()),
            other => panic!("{young}: {other:?}"),
        }
    }
    for poisson in [-1.0, 0.5, 0.7, -2.0, f64::NAN] {
        match Lame::from_young_poisson(1.0, poisson) {
            Err(LawError::PoissonRatio { value }) => assert!(value == poisson || poisson.is_nan()),
            other => panic!("{poisson}: {other:?}"),
        }
    }
    assert_eq!(Lame::new(1.0, 0.0), Err(LawError::ShearModulus { value: 0.0 }));
    assert!(matches!(Lame::new(-1.0, 1.0), Err(LawError::BulkModulus { .. })));
    assert!(matches!(Lame::from_bulk_shear(f64::NAN, 1.0), Err(LawError::BulkModulus { .. })));
    let message = Lame::from_young_poisson(1.0, 0.5).unwrap_err().to_string();
    assert!(message.contains("0.5"), "{message}");
}
