//! Errors name somebody.

use crate::begin_step;
use crate::random::Random;
use ipc_contact::ContactError;
use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use mechanics_core::potential::PotentialError;
use mechanics_core::tensor::Vec3;

/// Two points at the minimum separation, more or less an ulp: fine, or refused by name.
#[test]
fn a_pair_too_close_is_named_however_its_distance_rounds() {
    let mut random = Random(5);
    let mut refused = 0;
    for _ in 0..2000 {
        let rest = [random.point(), Vec3::zeros()];
        let x = [rest[0].normalize() * 1e-3, Vec3::zeros()];
        let mut builder = CollisionMeshBuilder::new(&rest);
        let points = vec![0, 1];
        builder.add_object(CollisionObject { points, ..Default::default() }.with_thickness(0.01));
        let stiffness = Stiffness::fixed(Scale::Load(1.0));
        let options = ContactOptions { minimum_separation: 1e-3, ..ContactOptions::new(1e-3, stiffness) };
        let mut contact = BarrierContact::new(builder.build().unwrap(), options).unwrap();
        if let Err(error) = begin_step(&mut contact, &x) {
            let PotentialError::Term { source, .. } = error else { panic!("{error}") };
            let Some(ContactError::TooClose { pairs, .. }) = source.downcast_ref() else {
                panic!("{source}")
            };
            assert_eq!(pairs.len(), 1, "{x:?}");
            refused += 1;
        }
    }
    assert!(refused > 100 && refused < 2000, "{refused}");
}
