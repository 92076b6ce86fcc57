//! Steel is sheared until it flows, and stays on its hardening curve.

use mpm_constitutive::mechanics_core::{law::Lame, tensor::Mat3};
use mpm_constitutive::plastic::{VonMises, YieldStress};
use mpm_constitutive::{Motion, PointLaw, Strain, fresh_history};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let steel = VonMises::new(Lame::from_young_poisson(2.1e11, 0.3)?, YieldStress::linear(2.5e8, 1e9)?)?;
    let (mut strain, mut history) = (Mat3::undeformed(), fresh_history::<VonMises, f64>());
    let mut shear = Mat3::zeros();
    shear[(0, 1)] = 1e-3;
    let mut stress = 0.0;
    for _ in 0..100 {
        let (moved, answer) =
            steel.advance(&strain, &mut history, &Motion { velocity_gradient: shear, step: 1.0 });
        strain = moved;
        let tau = answer.kirchhoff;
        let mean = tau.trace() / 3.0;
        stress = (1.5_f64).sqrt() * (tau - Mat3::identity() * mean).norm();
    }
    let exact = 2.5e8 + 1e9 * history.equivalent;
    println!(
        "{stress:.4e} Pa at a plastic strain of {:.5}; the curve says {exact:.4e} Pa",
        history.equivalent
    );
    assert!(history.equivalent > 0.05 && (stress / exact - 1.0).abs() < 1e-9);
    Ok(())
}
