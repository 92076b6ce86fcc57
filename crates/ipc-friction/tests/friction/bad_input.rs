//! What is refused, by name.

use crate::scene::{Particle, mu, options, stepping};
use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::normal_force::NormalForce;
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::coefficients::CoefficientTable;
use ipc_friction::lagged::LaggedFriction;
use ipc_friction::law::{FrictionCoefficient, SmoothedCoulomb};
use ipc_friction::{ContactWithFriction, FrictionError, FrictionOptions};
use lagrangian::stepper::Lagging;
use mechanics_core::stage::Scheme;
use mechanics_core::tensor::Vec3;

#[test]
fn coefficients_out_of_range_are_refused() {
    for bad in [-1e-9, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(matches!(FrictionCoefficient::new(bad), Err(FrictionError::Coefficient { .. })));
        assert!(matches!(
            FrictionCoefficient::with_kinetic(bad, 0.1),
            Err(FrictionError::Coefficient { .. })
        ));
        assert!(matches!(
            FrictionCoefficient::with_kinetic(0.1, bad),
            Err(FrictionError::Coefficient { .. })
        ));
    }
    let error = FrictionCoefficient::with_kinetic(0.3, 0.4).unwrap_err();
    assert_eq!(error, FrictionError::KineticAboveStatic { at_rest: 0.3, sliding: 0.4 });
    assert_eq!(error.to_string(), "the kinetic coefficient 0.4 is above the static one, 0.3");
}

#[test]
fn velocities_out_of_range_are_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(SmoothedCoulomb::new(bad), Err(FrictionError::StickVelocity { .. })));
        let law = SmoothedCoulomb::new(1.0).unwrap();
        assert!(matches!(law.with_transition(bad), Err(FrictionError::TransitionVelocity { .. })));
    }
}

fn contact() -> BarrierContact {
    let rest = [Vec3::new(0.0, 0.0, 1.0)];
    let mut builder = CollisionMeshBuilder::new(&rest);
    builder.add_object(CollisionObject { points: vec![0], ..Default::default() }.with_thickness(0.01));
    builder.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
    let options = ContactOptions::new(1e-3, Stiffness::fixed(Scale::Load(1.0)));
    BarrierContact::new(builder.build().unwrap(), options).unwrap()
}

#[test]
fn surfaces_that_do_not_exist_are_refused() {
    let table = |table: CoefficientTable| {
        let options = FrictionOptions { coefficients: table, ..options(mu(0.1), 1e-3) };
        ContactWithFriction::new(contact(), options).map(drop)
    };
    let base = CoefficientTable::uniform(mu(0.1));
    assert_eq!(table(base.clone().with_objects([0, 0], mu(0.2))), Ok(()));
    let object = FrictionError::ObjectOutOfRange { object: 1, objects: 1 };
    assert_eq!(table(base.clone().with_objects([1, 0], mu(0.2))), Err(object.clone()));
    assert_eq!(table(base.clone().with_half_space_and_object(0, 1, mu(0.2))), Err(object));
    let half_space = FrictionError::HalfSpaceOutOfRange { half_space: 1, half_spaces: 1 };
    assert_eq!(table(base.clone().with_half_space(1, mu(0.2))), Err(half_space.clone()));
    assert_eq!(table(base.with_half_space_and_object(1, 0, mu(0.2))), Err(half_space));
    for bad in [-1e-3, f64::NAN] {
        let options = FrictionOptions { lag_tolerance: bad, ..options(mu(0.1), 1e-3) };
        let error = ContactWithFriction::new(contact(), options).unwrap_err();
        assert!(matches!(error, FrictionError::LagTolerance { .. }));
    }
}

#[test]
fn normal_forces_that_are_none_are_refused() {
    let law = SmoothedCoulomb::new(1e-3).unwrap();
    let x = [Vec3::zeros(), Vec3::z()];
    let try_force = |force: NormalForce| LaggedFriction::new(law, &[force], &[mu(0.5)], &Scheme::statics(&x));
    let of = |normal: Vec3, magnitude: f64| NormalForce::new([1, 0], [1.0, -1.0], normal, 1.0, magnitude);
    assert_eq!(try_force(of(Vec3::z(), 2.0)).unwrap().len(), 1);
    for bad in [f64::NAN, f64::INFINITY] {
        let error = try_force(of(Vec3::z(), bad)).unwrap_err();
        assert!(matches!(error, FrictionError::NormalForce { ref points, .. } if *points == [1, 0]));
        let weights = NormalForce::new([1, 0], [bad, -1.0], Vec3::z(), 1.0, 2.0);
        assert!(matches!(try_force(weights), Err(FrictionError::NormalForce { .. })));
    }
    for bad in [Vec3::zeros(), Vec3::z() * 2.0, Vec3::repeat(f64::NAN)] {
        let error = try_force(of(bad, 2.0)).unwrap_err();
        assert!(matches!(error, FrictionError::NormalForce { .. }));
    }
    let twice = NormalForce::new([1, 1], [1.0, -1.0], Vec3::z(), 1.0, 2.0);
    let error = try_force(twice).unwrap_err();
    assert_eq!(error, FrictionError::RepeatedPoint { points: vec![1, 1], point: 1 });
    // No force, no friction: nothing is kept.
    assert!(try_force(of(Vec3::z(), 0.0)).unwrap().is_empty());
}

#[test]
fn there_is_nothing_to_report_before_the_first_step() {
    let particle = Particle::on_slope(0.0, options(mu(0.5), 1e-3), stepping(1e-9, Lagging::Once));
    let report = particle.contact.report(&particle.state.position).unwrap();
    assert_eq!(report, ipc_friction::FrictionReport::default());
}
