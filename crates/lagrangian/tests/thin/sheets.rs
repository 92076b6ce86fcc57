//! Sheets against closed forms and published values.

use crate::samples::{number, reference};
use lagrangian::element::membrane::{NeoHookeanSheet, PlaneStrain, SaintVenantKirchhoffSheet, SheetLaw};
use mechanics_core::projection::Projection;

/// Lateral stretch at which the lateral stress vanishes, by bisection, and the axial stress there.
fn uniaxial(law: &dyn SheetLaw, stretch: f64) -> (f64, f64, f64) {
    let f = |lateral: f64| nalgebra::Matrix3x2::new(stretch, 0.0, 0.0, lateral, 0.0, 0.0);
    let (mut low, mut high) = (0.05, 3.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if law.first_piola(&f(middle))[(1, 1)] < 0.0 { low = middle } else { high = middle }
    }
    let f = f(0.5 * (low + high));
    (0.5 * (low + high), law.first_piola(&f)[(0, 0)], law.energy_density(&f))
}

/// Both lateral directions are free in the fixture: across the sheet by its law, along it by the bisection above.
#[test]
fn uniaxial_neo_hookean_stretch_agrees_with_the_closed_form() {
    let reference = reference();
    let mut count = 0;
    for case in reference["neo_hookean_log_uniaxial"].as_array().unwrap() {
        let law = NeoHookeanSheet::new(number(&case["E"]), number(&case["nu"])).unwrap();
        let stretch = number(&case["stretch"]);
        let (lateral, stress, energy) = uniaxial(&law, stretch);
        let expected = [number(&case["lateral"]), number(&case["P11"]), number(&case["W"])];
        for (found, expected) in [lateral, stress, energy].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-13, "{case}: {found} {expected}");
        }
        let f = nalgebra::Matrix3x2::new(stretch, 0.0, 0.0, lateral, 0.0, 0.0);
        let across = law.thickness_stretch(&PlaneStrain::of(&f)).unwrap();
        assert!((across - lateral).abs() < 1e-13);
        count += 1;
    }
    assert!(count > 5);
}

#[test]
fn uniaxial_saint_venant_kirchhoff_stretch_agrees_with_the_closed_form() {
    for case in reference()["stvk_uniaxial_P11"].as_array().unwrap() {
        for poisson in [-0.5, 0.0, 0.3, 0.45] {
            let law = SaintVenantKirchhoffSheet::new(number(&case["E"]), poisson).unwrap();
            let stretch = number(&case["stretch"]);
            let (lateral, stress, _) = uniaxial(&law, stretch);
            assert!((stress - number(&case["P"])).abs() < 1e-13);
            assert!((lateral * lateral - (1.0 - poisson * (stretch * stretch - 1.0))).abs() < 1e-13);
        }
    }
}

/// The thickness equation is solved for all strains: huge, tiny, nearly incompressible.
#[test]
fn the_thickness_equation_holds_over_the_whole_range() {
    for poisson in [0.0, 1e-9, 0.2, 0.45, 0.4999999] {
        let law = NeoHookeanSheet::new(1.0, poisson).unwrap();
        let ratio = 2.0 * poisson / (1.0 - 2.0 * poisson);
        for exponent in -70..=70 {
            let side = 10.0_f64.powf(0.2 * f64::from(exponent));
            let f = nalgebra::Matrix3x2::new(side, 0.0, 0.0, 1.0, 0.0, 0.0);
            let stretch = law.thickness_stretch(&PlaneStrain::of(&f)).unwrap();
            let residual = stretch * stretch - 1.0 + ratio * (side.ln() + stretch.ln());
            let size = 1.0 + stretch * stretch + ratio * (side.ln().abs() + stretch.ln().abs());
            assert!(residual.abs() < 1e-14 * size, "{poisson} {side:e}: {residual:e}");
        }
    }
    // An auxetic law has no equilibrium below its bound, ln √D = μ/λ + ½ − ½ ln(−λ/2μ) = −0.807 for ν = −½.
    let law = NeoHookeanSheet::new(1.0, -0.5).unwrap();
    let strain = |side: f64| PlaneStrain::of(&nalgebra::Matrix3x2::new(side, 0.0, 0.0, 1.0, 0.0, 0.0));
    let bound = (-2.0_f64 + 0.5 - 0.5 * 0.25_f64.ln()).exp();
    assert!(law.thickness_stretch(&strain(1.001 * bound)).is_some());
    assert!(law.thickness_stretch(&strain(0.999 * bound)).is_none());
    let f = nalgebra::Matrix3x2::new(0.4, 0.0, 0.0, 1.0, 0.0, 0.0);
    assert_eq!(law.energy_density(&f), f64::INFINITY);
    assert!(law.stiffness(&f, Projection::Clamp).iter().any(|k| k.is_nan()));
}
