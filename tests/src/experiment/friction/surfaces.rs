//! Particles on planes: what the scenes with closed forms are made of.

use crate::experiment::ExperimentError;
use crate::experiment::contact::world::{World, WorldBuilder};
use ipc_contact::collision_mesh::{CollisionObject, HalfSpace, SelfContact};
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::FrictionOptions;
use ipc_friction::coefficients::CoefficientTable;
use ipc_friction::law::{FrictionCoefficient, SmoothedCoulomb};
use lagrangian::stepper::{Lagging, StepperOptions, TimeScheme};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;

pub(super) const GRAVITY: f64 = 9.81;
/// Where contact begins (m).
pub(super) const ACTIVATION: f64 = 1e-3;
/// Lag passes after which a step fails.
pub(super) const MOST_LAGS: u64 = 100;

/// Gravity in the frame of a plane z = 0 that falls towards +x by an angle.
pub(super) fn gravity_on_slope(angle: f64) -> Vec3 {
    Vec3::new(angle.sin(), 0.0, -angle.cos()) * GRAVITY
}

/// One coefficient for all surfaces, and the quadratic law.
pub(super) fn friction(
    at_rest: f64,
    sliding: f64,
    stick_velocity: f64,
) -> Result<FrictionOptions, ExperimentError> {
    let coefficient =
        FrictionCoefficient::with_kinetic(at_rest, sliding).map_err(ExperimentError::stopped)?;
    let law = SmoothedCoulomb::new(stick_velocity).map_err(ExperimentError::stopped)?;
    Ok(FrictionOptions::new(law, CoefficientTable::uniform(coefficient)))
}

/// Steps of `scheme` whose normal forces agree with what they lead to, or which fail.
pub(super) fn stepping(tolerance: f64, scheme: TimeScheme) -> StepperOptions {
    let newton = NewtonOptions { tolerance, ..NewtonOptions::default() };
    StepperOptions { newton, scheme, lagging: Lagging::Until(MOST_LAGS), ..StepperOptions::default() }
}

/// Adds particles of one mass (kg) over the plane z = 0, at the height at which contact carries their weight.
pub(super) fn add_particles(
    builder: &mut WorldBuilder,
    places: &[[f64; 2]],
    mass: f64,
    velocity: Vec3,
) -> std::ops::Range<u32> {
    let points: Vec<Vec3> = places.iter().map(|[x, y]| Vec3::new(*x, *y, 0.5 * ACTIVATION)).collect();
    let count = points.len() as u32;
    builder.add_masses(&points, mass, velocity, |first| {
        let points = (first..first + count).collect();
        let object = CollisionObject { points, ..CollisionObject::default() };
        object.with_thickness(ACTIVATION).with_self_contact(SelfContact::Excluded)
    })
}

/// The world of particles that weigh `weight` (N) each, on the plane z = 0.
pub(super) fn on_plane(
    mut builder: WorldBuilder,
    gravity: Vec3,
    weight: f64,
    options: StepperOptions,
) -> Result<World, ExperimentError> {
    builder.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
    let contact = ContactOptions::new(ACTIVATION, Stiffness::fixed(Scale::Load(weight)));
    builder.build(gravity, contact, options)
}

/// One particle of 1 kg on a slope.
pub(super) fn particle_on_slope(
    angle: f64,
    friction: FrictionOptions,
    options: StepperOptions,
    velocity: Vec3,
) -> Result<World, ExperimentError> {
    let mut builder = WorldBuilder::default().with_friction(friction);
    add_particles(&mut builder, &[[0.0, 0.0]], 1.0, velocity);
    on_plane(builder, gravity_on_slope(angle), GRAVITY * angle.cos(), options)
}

/// The speed of what sticks under a load of τ μ λ: εᵥ (1 − √(1 − τ)).
pub(super) fn creep(stick_velocity: f64, part_of_bound: f64) -> f64 {
    stick_velocity * (1.0 - (1.0 - part_of_bound).sqrt())
}
