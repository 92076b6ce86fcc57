//! Particles side by side on a slope, μ from 0 to 1: who sticks, who slides, and how far, against the closed forms.
//!
//! `cargo run -p ipc-friction --example blocks_on_slope`

#![allow(clippy::print_stdout, reason = "an example prints")]

use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::coefficients::CoefficientTable;
use ipc_friction::law::{FrictionCoefficient, SmoothedCoulomb};
use ipc_friction::{ContactWithFriction, FrictionOptions};
use lagrangian::element::{DeadLoad, Mass};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;

const BLOCKS: u32 = 11;
const GRAVITY: f64 = 9.81;
const STICK_VELOCITY: f64 = 1e-4;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let slope = 26_f64.to_radians();
    let mu = |block: u32| 0.1 * f64::from(block);
    let rest: Vec<Vec3> = (0..BLOCKS).map(|block| Vec3::new(0.0, f64::from(block), 5e-4)).collect();

    let mut surfaces = CollisionMeshBuilder::new(&rest);
    let mut table = CoefficientTable::default();
    let floor = surfaces.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
    let mut mass = Mass::zeros(rest.len());
    for block in 0..BLOCKS {
        let point = CollisionObject { points: vec![block], ..Default::default() };
        let object = surfaces.add_object(point.with_thickness(0.1));
        table = table.with_half_space_and_object(floor, object, FrictionCoefficient::new(mu(block))?);
        mass.add_point(block, 1.0)?;
    }
    let stiffness = Stiffness::fixed(Scale::Load(GRAVITY * slope.cos()));
    let contact = BarrierContact::new(surfaces.build()?, ContactOptions::new(1e-3, stiffness))?;
    let options = FrictionOptions::new(SmoothedCoulomb::new(STICK_VELOCITY)?, table);
    let mut contact = ContactWithFriction::new(contact, options)?;

    let down = Vec3::new(GRAVITY * slope.sin(), 0.0, -GRAVITY * slope.cos());
    let mut gravity = DeadLoad::gravity(&mass, &down)?;
    let newton = NewtonOptions { tolerance: 1e-10, ..Default::default() };
    let options = StepperOptions { newton, ..Default::default() };
    let mut stepper = Stepper::new(mass, PointMap::identity(rest.len()), options);
    let mut state = State::at_rest(rest);
    let mut dissipated = 0.0;
    for _ in 0..1000 {
        stepper.step(&mut state, &mut [&mut gravity, &mut contact], 1e-3)?;
        dissipated += contact.report(&state.position)?.dissipated;
    }

    println!("a slope of 26°, tan θ = {:.4}; after one second", slope.tan());
    println!("   μ    velocity [m/s]   closed form [m/s]");
    for block in 0..BLOCKS {
        let stuck = 1.0 - slope.tan() / mu(block);
        let expected = if stuck > 0.0 {
            STICK_VELOCITY * (1.0 - stuck.sqrt())
        } else {
            GRAVITY * (slope.sin() - mu(block) * slope.cos())
        };
        println!("  {:.1}  {:15.8e}  {expected:15.8e}", mu(block), state.velocity[block as usize].x);
    }
    let report = contact.report(&state.position)?;
    println!("{} of {} stick; friction took {dissipated:.3} J", report.sticking, report.pairs);
    Ok(())
}
