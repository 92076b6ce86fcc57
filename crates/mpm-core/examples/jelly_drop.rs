//! A jelly cube falls on a floor, rebounds, and loses nothing of its mass. Prints how high its centre flies after the first bounce.
#![allow(clippy::print_stdout)]

use mechanics_core::law::Lame;
use mpm_constitutive::elastic::NeoHookean;
use mpm_core::sampling::{Pattern, sample_shape};
use mpm_core::{Boundary, Samples, Shape, Simulation, SimulationOptions, Surface};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (spacing, drop, gravity) = (0.05, 0.4, 9.81);
    let cube = Shape::Cuboid { centre: [0.0, 0.0, 0.2 + drop], half: [0.2; 3] };
    let cube = sample_shape(&cube, Pattern::regular(spacing, 2), 1)?;
    let velocities = vec![[0.0; 3]; cube.positions.len()];
    let mut simulation = Simulation::<f32, 3>::new(SimulationOptions::new(spacing))?;
    simulation.set_gravity([0.0, 0.0, -gravity])?;
    let floor = Shape::HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
    simulation.add_boundary(Boundary::at_rest(floor, Surface::Separating))?;
    let jelly = NeoHookean::new(Lame::from_young_poisson(5e4, 0.3)?);
    let samples = Samples { positions: &cube.positions, velocities: &velocities, volumes: &cube.volumes };
    let body = simulation.add_body(jelly, 1000.0, samples)?;

    let height = |simulation: &Simulation<f32, 3>| {
        let positions = simulation.positions(body);
        positions.iter().map(|x| x[2]).sum::<f64>() / positions.len() as f64
    };
    // Falls for √(2 · 0.4/9.81) = 0.286 s.
    let (mut steps, mut lowest, mut highest) = (0, f64::INFINITY, 0.0_f64);
    while simulation.time() < 0.65 {
        steps += simulation.advance(0.01)?.steps;
        let now = height(&simulation);
        if simulation.time() < 0.4 {
            lowest = lowest.min(now);
        } else {
            highest = highest.max(now);
        }
    }
    let totals = simulation.totals(body);
    println!("{} particles, {steps} steps", cube.positions.len());
    println!("the centre falls from {:.2} m to {lowest:.3} m and rises to {highest:.3} m", 0.2 + drop);
    println!("mass {:.4} kg of 64 kg", totals.mass);
    Ok(())
}
