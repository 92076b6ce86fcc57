//! Fields that a caller sets.

use crate::conservation::Block;
use mechanics_core::tensor::Mat3;
use mpm_core::{Kernel, MpmError, Transfer};

#[test]
fn equal_accelerations_of_particles_are_gravity() {
    let block = Block::<2>::spinning(4, 3.0);
    for transfer in
        [Transfer::Pic, Transfer::FLIP, Transfer::Flip { flip: 0.95 }, Transfer::APIC, Transfer::MlsApic]
    {
        let mut pulled = block.simulation::<f64>(Kernel::Quadratic, transfer);
        let mut pushed = block.simulation::<f64>(Kernel::Quadratic, transfer);
        pulled.set_gravity([1.5, -9.81]).unwrap();
        let everywhere = vec![[1.5, -9.81]; block.positions.len()];
        for _ in 0..40 {
            pushed.accelerate(0, &everywhere, 1e-3).unwrap();
            pulled.step(1e-3).unwrap();
            pushed.step(1e-3).unwrap();
        }
        for (a, b) in pulled.positions(0).iter().flatten().zip(pushed.positions(0).iter().flatten()) {
            assert!((a - b).abs() < 1e-13, "{transfer:?}: {a} {b}");
        }
    }
}

#[test]
fn wrong_fields_are_refused_and_change_nothing() {
    let block = Block::<2>::spinning(2, 3.0);
    let mut simulation = block.simulation::<f64>(Kernel::Quadratic, Transfer::MlsApic);
    let untouched = block.simulation::<f64>(Kernel::Quadratic, Transfer::MlsApic);
    let count = block.positions.len();
    let mut fields = vec![[0.0; 2]; count];
    assert!(matches!(simulation.accelerate(0, &fields[1..], 1e-3), Err(MpmError::Count { .. })));
    fields[3][1] = f64::NAN;
    assert!(matches!(simulation.accelerate(0, &fields, 1e-3), Err(MpmError::Particle { particle: 3, .. })));
    assert!(matches!(
        simulation.accelerate(0, &vec![[1.0; 2]; count], f64::INFINITY),
        Err(MpmError::Step { .. })
    ));
    let mut gradients = vec![[[1.0; 2]; 2]; count];
    gradients[5][1][0] = f64::INFINITY;
    let error = simulation.set_velocity_gradients(0, &gradients);
    assert!(matches!(error, Err(MpmError::Particle { particle: 5, .. })));
    assert!(matches!(simulation.set_velocity_gradients(0, &gradients[1..]), Err(MpmError::Count { .. })));
    let mut deformations = vec![Mat3::identity() * 1.1; count];
    deformations[7] = Mat3::from_diagonal(&[-1.0, 1.0, 1.0].into());
    let error = simulation.set_deformation_gradients(0, &deformations);
    assert!(matches!(error, Err(MpmError::Law { particle: 7, .. })), "{error:?}");
    assert_eq!(simulation.positions(0), untouched.positions(0));
    assert_eq!(simulation.velocities(0), untouched.velocities(0));
    assert_eq!(simulation.velocity_gradients(0), untouched.velocity_gradients(0));
    assert_eq!(simulation.states(0), untouched.states(0));
}
