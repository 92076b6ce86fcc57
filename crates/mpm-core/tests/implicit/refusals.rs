//! Steps that cannot be made are not made.

use crate::block::{Block, SPACING};
use mpm_core::{
    Boundary, Collider, Equilibrium, ImplicitError, ImplicitStep, MpmError, PrescribedVelocity, Shape,
    SheetMesh, Surface, Transfer,
};

#[test]
fn what_fails_changes_nothing() {
    let block = Block::<2>::new([4, 4], SPACING);
    let mut simulation = block.rubber(Transfer::MlsApic, |x| [3.0 * x[0] * x[1], -2.0 * x[1]]);
    simulation.step_implicitly(1e-3, &ImplicitStep::default()).unwrap();
    let hash = simulation.state_hash();
    let wrong = |error: MpmError, kind: fn(&MpmError) -> bool| assert!(kind(&error), "{error}");
    for h in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = simulation.step_implicitly(h, &ImplicitStep::default()).unwrap_err();
        wrong(error, |error| matches!(error, MpmError::Step { .. }));
    }
    let options = ImplicitStep { tolerance: f64::NAN, ..ImplicitStep::default() };
    let error = simulation.step_implicitly(0.01, &options).unwrap_err();
    wrong(error, |error| matches!(error, MpmError::Implicit(ImplicitError::Tolerance { .. })));
    let options = ImplicitStep { tolerance: 1e-12, max_iterations: 1 };
    let error = simulation.step_implicitly(0.05, &options).unwrap_err();
    println!("{error}");
    wrong(error, |error| matches!(error, MpmError::Implicit(ImplicitError::NotConverged { .. })));
    let equilibrium = Equilibrium { max_steps: 1, ..Equilibrium::default() };
    simulation.set_gravity([0.0, -9.81]).unwrap();
    let error = simulation.equilibrate(&equilibrium).unwrap_err();
    println!("{error}");
    wrong(error, |error| matches!(error, MpmError::Implicit(ImplicitError::NoEquilibrium { .. })));
    assert_eq!(simulation.state_hash(), hash);
    // Still able.
    simulation.step_implicitly(1e-3, &ImplicitStep::default()).unwrap();
}

/// A grip that goes through the body in one step.
#[test]
fn grips_that_turn_matter_inside_out_are_refused_with_the_particle() {
    let block = Block::<2>::new([4, 4], SPACING);
    let mut simulation = block.rubber(Transfer::MlsApic, |_| [0.0; 2]);
    for (centre, velocity) in [(0.05, 1.0), (0.35, -1.0)] {
        let region = Shape::Cuboid { centre: [0.2, centre], half: [1.0, 0.16] };
        let grip = PrescribedVelocity { region, velocity: [0.0, velocity], from: 0.0, until: f64::INFINITY };
        simulation.add_prescribed_velocity(grip).unwrap();
    }
    simulation.step_implicitly(1e-3, &ImplicitStep::default()).unwrap();
    let hash = simulation.state_hash();
    let error = simulation.step_implicitly(1.0, &ImplicitStep::default()).unwrap_err();
    println!("{error}");
    assert!(matches!(error, MpmError::Implicit(ImplicitError::Start { body: 0, .. })), "{error}");
    assert_eq!(simulation.state_hash(), hash);
}

/// A step of a second, where an explicit one is a hundred-thousandth: it is made, or refused with a reason.
#[test]
fn huge_steps_are_made_or_refused() {
    let block = Block::<2>::new([4, 4], SPACING);
    let mut simulation = block.rubber(Transfer::MlsApic, |x| [20.0 * x[1], -30.0 * x[0] + 10.0 * x[1]]);
    let floor = Shape::HalfSpace { point: [0.0, -0.1], normal: [0.0, 1.0] };
    simulation.add_boundary(Boundary::at_rest(floor, Surface::Separating)).unwrap();
    for h in [0.1, 1.0, 10.0, 1e6] {
        let hash = simulation.state_hash();
        match simulation.step_implicitly(h, &ImplicitStep::default()) {
            Ok(report) => println!("{h} s: {report:?}"),
            Err(error) => {
                println!("{h} s: {error}");
                assert_eq!(simulation.state_hash(), hash);
            }
        }
        assert!(simulation.positions(0).iter().flatten().all(|x| x.is_finite()));
    }
}

#[test]
fn what_implicit_steps_do_not_know_is_refused_and_not_left_out() {
    for transfer in [Transfer::Xpic { order: 2 }, Transfer::Asflip { flip: 0.9, position: 0.5 }] {
        let block = Block::<2>::new([4, 4], SPACING);
        let mut simulation = block.rubber(transfer, |_| [0.0; 2]);
        let hash = simulation.state_hash();
        let error = simulation.step_implicitly(1e-3, &ImplicitStep::default()).unwrap_err();
        assert_eq!(error, MpmError::Implicit(ImplicitError::Transfer));
        assert_eq!(simulation.state_hash(), hash);
    }
    let block = Block::<3>::new([4, 4, 4], SPACING);
    let mut simulation = block.rubber(Transfer::MlsApic, |_| [0.0; 3]);
    // A sheet far away from the block.
    let mut sheet =
        mechanics_core::mesh::sheet([0.2; 2], [2; 2], mechanics_core::mesh::Diagonals::Rising).unwrap();
    sheet.translate(&mechanics_core::tensor::Vec3::new(5.0, 0.0, 0.0)).unwrap();
    simulation.add_collider(Collider::at_rest(SheetMesh::new(&sheet).unwrap(), Surface::Sticky)).unwrap();
    let hash = simulation.state_hash();
    let error = simulation.step_implicitly(1e-3, &ImplicitStep::default()).unwrap_err();
    assert_eq!(error, MpmError::Implicit(ImplicitError::NotKnown { what: "thin sheets", count: 1 }));
    assert_eq!(simulation.state_hash(), hash);
}
