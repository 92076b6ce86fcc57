//! Pressure and viscosity.

use crate::sample::{Numbers, assert_close};
use mechanics_core::jet::Jet2;
use mechanics_core::tensor::{Mat3, trace};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::{Motion, PointLaw, Strain, Viscosity, Viscous, VolumeChange};

const K: f64 = 2.2e9;
const EXPONENTS: [f64; 6] = [1.0, 2.0, 7.0, 7.15, 0.5, 40.0];

#[test]
fn pressure_and_stiffness_are_derivatives_of_the_energy() {
    for exponent in EXPONENTS {
        let water = Tait::new(K, exponent, Tension::Carried).unwrap();
        for z in [-0.3, -1e-2, -1e-5, 0.0, 1e-7, 0.02, 0.4] {
            let energy = water.energy_density(&VolumeChange(Jet2::<f64, 1>::variables([z])[0]), &());
            let stress = water.stress(&VolumeChange(z), &());
            let j = 1.0 + z;
            let scale = K * j.powf(1.0 - exponent).max(1.0);
            assert_close(stress.kirchhoff[(1, 1)], j * energy.gradient[0], 1e-12 * scale, "J ψ′");
            assert_close(stress.stiffness.lambda, j * j * energy.hessian(0, 0), 1e-12 * scale, "J² ψ″");
            assert_eq!((stress.kirchhoff[(0, 1)], stress.stiffness.mu), (0.0, 0.0));
        }
    }
}

/// Water at 100 MPa is compressed by 4.0 % with K = 2.2 GPa, γ = 7: Tait's equation solved for J.
#[test]
fn water_under_the_deep_sea() {
    let water = Tait::new(K, 7.0, Tension::Carried).unwrap();
    let z = (1.0 + 7.0 * 1e8 / K).powf(-1.0 / 7.0) - 1.0;
    let tau = water.stress(&VolumeChange(z), &()).kirchhoff;
    assert_close(-tau[(0, 0)] / (1.0 + z), 1e8, 1e-5, "pressure");
}

/// What storing J − 1 is for: 1e-6 of K keeps six digits in single precision.
#[test]
fn small_pressures_keep_their_digits_in_single_precision() {
    let water = Tait::new(K, 7.0, Tension::Carried).unwrap();
    for z in [1e-6, -3e-6, 2e-4, -1e-2_f32] {
        let single = water.stress(&VolumeChange(z), &()).kirchhoff[(0, 0)];
        let double = water.stress(&VolumeChange(f64::from(z)), &()).kirchhoff[(0, 0)];
        assert_close(f64::from(single) / double, 1.0, 1e-6, "relative pressure");
    }
}

#[test]
fn drops_do_not_pull() {
    let spray = Tait::new(K, 7.0, Tension::Vanishes).unwrap();
    assert_eq!(spray.stress(&VolumeChange(0.1), &()).kirchhoff, Mat3::zeros());
    assert_eq!(spray.energy_density(&VolumeChange(0.1), &()), 0.0);
    assert!(spray.stress(&VolumeChange(-0.1), &()).kirchhoff[(0, 0)] < 0.0);
}

#[test]
fn an_empty_volume_is_refused() {
    let water = Tait::new(K, 7.0, Tension::Carried).unwrap();
    for z in [-1.0, -1.5, f64::NAN, f64::INFINITY] {
        assert!(!trace(&water.stress(&VolumeChange(z), &()).kirchhoff).is_finite(), "{z}");
        assert!(water.check_admissible(&VolumeChange(z), &()).is_err(), "{z}");
    }
}

/// τ : ∇v = J(2η‖dev d‖² + ζ tr²d), and nothing for a rigid rotation.
#[test]
fn viscosity_dissipates_and_does_not_resist_rotation() {
    let (viscosity, mut numbers) = (Viscosity::new(0.3, 0.7).unwrap(), Numbers(8));
    for _ in 0..20 {
        let gradient = Mat3::from_fn(|_, _| numbers.next());
        let d = 0.5 * (gradient + gradient.transpose());
        let dev = d - Mat3::identity() * (d.trace() / 3.0);
        let power = viscosity.kirchhoff(0.8, &gradient).component_mul(&gradient).sum();
        assert_close(power, 0.8 * (0.6 * dev.norm_squared() + 0.7 * d.trace().powi(2)), 1e-14, "power");
        let spin = gradient - gradient.transpose();
        assert!(viscosity.kirchhoff(0.8, &spin).norm() < 1e-16);
    }
}

#[test]
fn a_step_of_a_viscous_fluid_is_expansion_pressure_and_drag() {
    let viscosity = Viscosity::new(0.5, 0.0).unwrap();
    let oil = Viscous::new(Tait::new(1e6, 7.0, Tension::Carried).unwrap(), viscosity);
    let motion =
        Motion { velocity_gradient: Mat3::new(0.1, 2.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, -0.1), step: 0.01 };
    let (strain, stress) = oil.advance(&VolumeChange(0.01), &mut (), &motion);
    // J = 1.01 (1 + 0.01 · 0.2)
    assert_close(strain.volume_ratio(), 1.01 * 1.002, 1e-15, "J");
    assert_close(
        stress.kirchhoff[(0, 1)],
        strain.volume_ratio() * 0.5 * 2.0,
        1e-15,
        "shear stress η ∂v₀/∂x₁",
    );
}
