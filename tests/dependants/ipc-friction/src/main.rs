//! A block is pushed and slides to a stop: contact's normal force, friction's force, and an integrator of one's own.

use ipc_friction::ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_friction::ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_friction::ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::lagged::LaggedFriction;
use ipc_friction::law::{FrictionCoefficient, SmoothedCoulomb};
use ipc_friction::mechanics_core::stage::{Coefficients, Scheme};
use ipc_friction::mechanics_core::tensor::Vec3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mass, g, mu, start, h) = (2.0, 9.81, 0.3, 3.0, 1e-4);
    let reach = 1e-3;
    // A block that does not turn is a point, here where the floor carries its weight.
    let mut x = vec![Vec3::new(0.0, 0.0, 0.5 * reach)];
    let mut surfaces = CollisionMeshBuilder::new(&x);
    surfaces.add_object(CollisionObject { points: vec![0], ..Default::default() }.with_thickness(0.1));
    surfaces.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
    let options = ContactOptions::new(reach, Stiffness::fixed(Scale::Load(mass * g)));
    let contact = BarrierContact::new(surfaces.build()?, options)?;

    let law = SmoothedCoulomb::new(1e-3)?;
    let coefficient = FrictionCoefficient::new(mu)?;
    let mut velocity = Vec3::x() * start;
    while velocity.x > 1e-2 {
        let scheme = Scheme::new(Coefficients::backward_euler(h), &x, &x);
        let friction = LaggedFriction::new(law, &contact.normal_forces(&x), &[coefficient], &scheme)?;
        let force = friction.forces(&[x[0] + velocity * h])[0];
        velocity += force * (h / mass);
        x[0] += velocity * h;
    }
    let (way, exact) = (x[0].x, 0.5 * start * start / (mu * g));
    println!("the block slides {way:.4} m; v²/2μg is {exact:.4} m");
    assert!((way / exact - 1.0).abs() < 1e-3);
    Ok(())
}
