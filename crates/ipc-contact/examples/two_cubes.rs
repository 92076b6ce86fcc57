//! Two soft cubes collide: one flies into the other, which rests, and nothing else acts on them.
//!
//! Contact is one more energy for the stepper of `lagrangian`. The momentum of both together is what it was, to rounding.
//!
//! `cargo run --release -p ipc-contact --example two_cubes`

#![allow(clippy::print_stdout, reason = "an example prints")]

use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::element::{Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::law::{Lame, StableNeoHookean};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::point_map::PointMap;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    // Two cubes of 10 cm and 1 kg, 5 mm apart.
    let cube = block(&Vec3::zeros(), &Vec3::new(0.1, 0.1, 0.1), [3, 3, 3], BoxSplit::Six)?;
    let mut other = cube.clone();
    other.translate(&Vec3::new(0.03, 0.02, 0.105))?;
    let mut both = cube.clone();
    let first_of_other = both.append(&other)?;

    let law = StableNeoHookean::new(Lame::from_young_poisson(1e5, 0.4)?);
    let mut elastic = Tetrahedra::term("elastic", law, &both)?;
    let mut mass = Mass::zeros(both.points().len());
    mass.add_tetrahedra(both.points(), both.cells(), 1000.0, MassDistribution::Lumped)?;

    let mut surfaces = CollisionMeshBuilder::new(both.points());
    surfaces.add_object(CollisionObject::of_tets(&cube, 0)?);
    surfaces.add_object(CollisionObject::of_tets(&other, first_of_other)?);
    // Contact acts within 1 mm. A pair at half of that carries 1 N.
    let options = ContactOptions::new(1e-3, Stiffness::adaptive(Scale::Load(1.0)));
    let mut contact = BarrierContact::new(surfaces.build()?, options)?;

    let map = PointMap::identity(both.points().len());
    let mut stepper = Stepper::new(mass.clone(), map, StepperOptions::default());
    let mut state = State::at_rest(both.points().to_vec());
    state.velocity[first_of_other as usize..].fill(Vec3::new(0.0, 0.0, -1.0));
    for _ in 0..30 {
        stepper.step(&mut state, &mut [&mut elastic, &mut contact], 1e-3)?;
    }

    let momentum = |points: std::ops::Range<usize>| -> f64 {
        points.map(|i| mass.diagonal()[i] * state.velocity[i].z).sum()
    };
    let middle = first_of_other as usize;
    let (pushed, pushing) = (momentum(0..middle), momentum(middle..both.points().len()));
    println!("momentum of the pushed cube {pushed:.4} kg m/s, of the pushing one {pushing:.4} kg m/s");
    println!("together {:.12} kg m/s (before: -1)", pushed + pushing);
    assert!((pushed + pushing + 1.0).abs() < 1e-9 && pushed < -0.5);
    Ok(())
}
