//! Contact and friction of a scene's bodies.

use super::{Bodies, refused};
use crate::experiment::ExperimentError;
use crate::experiment::contact::term::ContactTerm;
use crate::scene::physics::Contact;
use crate::scene::quantity::Finite;
use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::FrictionOptions;
use mechanics_core::tensor::Vec3;

/// The term; points in `held` move by prescription, and half-spaces let them pass.
pub(super) fn term(
    contact: &Contact,
    bodies: &Bodies,
    held: impl Iterator<Item = u32>,
) -> Result<ContactTerm, ExperimentError> {
    let mut builder = CollisionMeshBuilder::new(bodies.mesh().points());
    for (index, body) in bodies.each().iter().enumerate() {
        let object = CollisionObject::of_tets(&body.mesh, body.points.start as u32)
            .map_err(|error| refused(format!("meshes.{index}"), error))?;
        builder.add_object(object);
    }
    for half_space in &contact.half_spaces {
        let [point, normal] =
            [half_space.point_m, half_space.normal].map(|v| Vec3::from(v.map(Finite::value)));
        builder.add_half_space(HalfSpace::through(&point, &normal));
    }
    builder.script_points(held);
    let mesh = builder.build().map_err(|error| refused("contact", error))?;
    let stiffness = Stiffness::adaptive(Scale::Load(contact.pair_force_n.value()));
    let options = ContactOptions::new(contact.activation_distance_m.value(), stiffness);
    let barrier = BarrierContact::new(mesh, options).map_err(|error| refused("contact", error))?;
    let friction = match contact.friction {
        Some(given) => {
            let uniform =
                FrictionOptions::uniform(given.coefficient.value(), given.stick_velocity_m_s.value());
            Some(uniform.map_err(|error| refused("contact.friction", error))?)
        }
        None => None,
    };
    ContactTerm::new(barrier, friction)
}

/// The height of the scene's highest level floor [m].
pub(super) fn floor(contact: &Contact) -> Option<f64> {
    let is_level = |v: &[Finite; 3]| v[0].value() == 0.0 && v[1].value() == 0.0 && v[2].value() > 0.0;
    let levels = contact.half_spaces.iter().filter(|half_space| is_level(&half_space.normal));
    levels.map(|half_space| half_space.point_m[2].value()).reduce(f64::max)
}
