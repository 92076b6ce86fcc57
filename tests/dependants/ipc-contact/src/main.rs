//! Contact for a solver of one's own: how far a fall may go, and the gap at which a weight rests.

use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::mechanics_core::potential::Potential;
use ipc_contact::mechanics_core::tensor::Vec3;
use ipc_contact::stiffness::{Scale, Stiffness};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A particle of 1 kg above the plane z = 0. Contact acts within 1 mm, and carries the weight at half of that.
    let (weight, reach) = (9.81, 1e-3);
    let rest = [Vec3::new(0.0, 0.0, 1.0)];
    let mut surfaces = CollisionMeshBuilder::new(&rest);
    surfaces.add_object(CollisionObject { points: vec![0], ..Default::default() }.with_thickness(0.1));
    surfaces.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
    let options = ContactOptions::new(reach, Stiffness::fixed(Scale::Load(weight)));
    let mut contact = BarrierContact::new(surfaces.build()?, options)?;

    // A step that would end three metres below the floor.
    let limit = contact.limit_step(&rest, &[Vec3::new(0.0, 0.0, -4.0)])?;
    let height = 1.0 - 4.0 * limit.fraction;
    println!("{:.6} of the step is free: it ends {height:.6} m above the floor", limit.fraction);
    assert!(height > 0.0 && height < 0.5);

    // Where the push is the weight, by bisection.
    let (mut low, mut high) = (1e-9, reach);
    for _ in 0..100 {
        let z = 0.5 * (low + high);
        let push = contact.forces(&[Vec3::new(0.0, 0.0, z)])[0].z;
        if push > weight { low = z } else { high = z }
    }
    println!("the weight rests {low:.9} m above the floor");
    assert!((low - 0.5 * reach).abs() < 1e-12);
    Ok(())
}
