//! Displacements far beyond the scene: rounding is in their proportion.

use crate::{along, begin_step, freeze};
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::intersection::check;
use ipc_contact::stiffness::{Scale, Stiffness};
use mechanics_core::potential::Potential;
use mechanics_core::stage::Moment;
use mechanics_core::tensor::Vec3;

/// Two triangles, the second `gap` above the first, and a floor `gap` below it.
fn sandwich(gap: f64) -> CollisionMesh {
    let triangle = |z: f64| [Vec3::new(0.0, 0.0, z), Vec3::new(1.0, 0.0, z), Vec3::new(0.0, 1.0, z)];
    let rest = [triangle(0.0), triangle(gap)].concat();
    let mut builder = CollisionMeshBuilder::new(&rest);
    builder.add_object(CollisionObject::new(vec![[0, 1, 2]]));
    builder.add_object(CollisionObject::new(vec![[3, 4, 5]]));
    builder.add_half_space(HalfSpace::through(&Vec3::new(0.0, 0.0, -gap), &Vec3::z()));
    builder.build().unwrap()
}

fn contact(gap: f64, activation: f64) -> (BarrierContact, Vec<Vec3>) {
    let mesh = sandwich(gap);
    let x = mesh.rest().to_vec();
    let mut contact =
        BarrierContact::new(mesh, ContactOptions::new(activation, Stiffness::fixed(Scale::Load(1.0))))
            .unwrap();
    begin_step(&mut contact, &x).unwrap();
    (contact, x)
}

/// A gap of 1e-9 m is not too close, whatever a minimiser asks for.
#[test]
fn a_huge_displacement_is_shortened_not_refused() {
    for size in [1.0, 1e3, 1e6, 1e9, 1e12, 1e30, 1e100, 1e153] {
        for direction in [Vec3::z(), -Vec3::z(), Vec3::new(1.0, 0.3, 0.2)] {
            for upper in [-1.0, 0.0, 1.0] {
                let (mut contact, x) = contact(1e-9, 1e-3);
                let p: Vec<Vec3> =
                    (0..6).map(|i| direction * size * if i < 3 { 1.0 } else { upper }).collect();
                let limit = contact.limit_step(&x, &p).unwrap_or_else(|e| panic!("{size} {upper}: {e}"));
                assert!(limit.fraction > 0.0, "{size} {upper}");
                let y = along(&x, &p, limit.fraction);
                assert_eq!(check(contact.mesh(), &y).unwrap(), [], "{size} {direction:?} {upper}");
                assert!(contact.value(&y).is_finite());
                freeze(&mut contact, &y, Moment::Iteration).unwrap();
            }
        }
    }
}

/// Positions that are rounded to a coarser grid than the gap between two bodies are not called free.
#[test]
fn rounding_of_a_common_displacement_brings_nothing_together() {
    for size in [1e10, 1e11, 1e12, 1e13, 1e14, 1e16] {
        for direction in [Vec3::z(), Vec3::new(0.7, 0.3, 0.9), Vec3::new(-0.7, 0.3, 0.9)] {
            let (mut contact, x) = contact(2e-3, 1e-3);
            let p = vec![direction * size; 6];
            let limit = contact.limit_step(&x, &p).unwrap();
            let y = along(&x, &p, limit.fraction);
            assert_eq!(check(contact.mesh(), &y).unwrap(), [], "{size} {direction:?} {limit:?}");
            assert!(limit.fraction > 0.0, "{size}");
        }
    }
}

/// What a long cleared segment excuses is its own rounding, not positions beside it.
#[test]
fn positions_beside_a_long_segment_are_looked_at() {
    let (mut contact, x) = contact(1e-6, 1e-3);
    let p: Vec<Vec3> = (0..6).map(|i| Vec3::z() * if i < 3 { 0.0 } else { 1e10 }).collect();
    let limit = contact.limit_step(&x, &p).unwrap();
    assert!(limit.fraction > 0.0);
    let mut beside = x;
    beside[0].z += 2e-6;
    assert!(!check(contact.mesh(), &beside).unwrap().is_empty());
    assert!(freeze(&mut contact, &beside, Moment::Iteration).is_err());
}
