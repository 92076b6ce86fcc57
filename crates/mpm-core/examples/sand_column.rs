//! A column of sand, twice as high as it is wide, collapses on a rough floor (in the plane). Prints its run-out and final height.
#![allow(clippy::print_stdout)]

use mechanics_core::law::Lame;
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle};
use mpm_core::sampling::{Pattern, sample_shape};
use mpm_core::{Boundary, Samples, Shape, Simulation, SimulationOptions, Surface};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (spacing, radius, height) = (0.01, 0.1, 0.2);
    let column = Shape::Cuboid { centre: [0.0, 0.5 * height], half: [radius, 0.5 * height] };
    let column = sample_shape(&column, Pattern::per_cell(spacing, 2), 1)?;
    let velocities = vec![[0.0; 2]; column.positions.len()];
    let mut simulation = Simulation::<f32, 2>::new(SimulationOptions::new(spacing))?;
    simulation.set_gravity([0.0, -9.81])?;
    let floor = Shape::HalfSpace { point: [0.0; 2], normal: [0.0, 1.0] };
    simulation.add_boundary(Boundary::at_rest(floor, Surface::Friction(0.6)))?;
    let sand = DruckerPrager::new(Lame::from_young_poisson(1e6, 0.3)?, FrictionAngle::constant(0.55)?, 0.0)?;
    let samples = Samples { positions: &column.positions, velocities: &velocities, volumes: &column.volumes };
    let body = simulation.add_body(sand, 1600.0, samples)?;
    let report = simulation.advance(0.6)?;

    // The heap without its few loosest grains: 1 % on each side.
    let positions = simulation.positions(body);
    let mut across: Vec<f64> = positions.iter().map(|x| x[0]).collect();
    across.sort_by(f64::total_cmp);
    let few = across.len() / 100;
    let reach = 0.5 * (across[across.len() - 1 - few] - across[few]);
    let top = positions.iter().map(|x| x[1]).fold(0.0, f64::max);
    let totals = simulation.totals(body);
    println!("{} particles, {} steps", positions.len(), report.steps);
    println!(
        "run-out {:.2} of the half width, height {:.2} of the column's",
        reach / radius - 1.0,
        top / height
    );
    println!("mean speed {:.4} m/s", (2.0 * totals.kinetic_energy / totals.mass).sqrt());
    Ok(())
}
