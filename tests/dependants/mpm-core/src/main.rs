//! An elastic ball is thrown; nothing acts on it but its weight.

use mpm_core::mechanics_core::law::Lame;
use mpm_core::mpm_constitutive::elastic::FixedCorotated;
use mpm_core::sampling::{Pattern, sample_shape};
use mpm_core::{Samples, Shape, Simulation, SimulationOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (spacing, time, g) = (0.1, 0.2, 9.81);
    let ball = Shape::Ball { centre: [0.0, 0.0, 2.0], radius: 0.25 };
    let ball = sample_shape(&ball, Pattern::per_cell(spacing, 2), 1)?;
    let velocities = vec![[1.0, 0.0, 2.0]; ball.positions.len()];

    let mut simulation = Simulation::<f64, 3>::new(SimulationOptions::new(spacing))?;
    simulation.set_gravity([0.0, 0.0, -g])?;
    let jelly = FixedCorotated::new(Lame::from_young_poisson(1e5, 0.3)?);
    let samples = Samples { positions: &ball.positions, velocities: &velocities, volumes: &ball.volumes };
    let body = simulation.add_body(jelly, 1000.0, samples)?;
    let report = simulation.advance(time)?;

    let totals = simulation.totals(body);
    let velocity = totals.momentum / totals.mass;
    println!("{} steps; {:.12} m/s along x, {:.12} m/s upwards", report.steps, velocity.x, velocity.z);
    assert!((velocity.x - 1.0).abs() < 1e-12 && (velocity.z - (2.0 - g * time)).abs() < 1e-12);
    // What no elastic body needs is not there.
    let numbers = simulation.particle_numbers(body);
    assert_eq!((numbers.history, numbers.kept_stress), (0, 0));
    Ok(())
}
