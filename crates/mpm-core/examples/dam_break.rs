//! A dam breaks (in the plane): a column of water, twice as high as it is wide, runs out over a dry floor. Prints when its front passes the gates of the
//! experiment, and how fast it is beside the front of shallow water.
//!
//! # Reference
//! J. C. Martin, W. J. Moyce, *An experimental study of the collapse of liquid columns on a rigid horizontal plane*, Phil. Trans. R. Soc. A 244, 1952
//! (n² = 2, a = 2¼ in; times as they are usually quoted, a band to compare with: computed fronts lead by 0.1 to 0.2 early on, because the
//! gate of the experiment takes time to open); A. Ritter, *Die Fortpflanzung der Wasserwellen*, Z. Ver. Dtsch. Ing. 36, 1892: 2√(gH).
#![allow(clippy::print_stdout)]

use mpm_constitutive::fluid::{Tait, Tension};
use mpm_core::sampling::{Pattern, sample_shape};
use mpm_core::{Boundary, Samples, Shape, Simulation, SimulationOptions, Surface};

/// Distance of the front by the width a, and time by √(a/2g), as measured.
const MEASURED: [(f64, f64); 15] = [
    (1.11, 0.41),
    (1.22, 0.84),
    (1.44, 1.19),
    (1.67, 1.43),
    (1.89, 1.63),
    (2.11, 1.83),
    (2.33, 1.98),
    (2.56, 2.20),
    (2.78, 2.32),
    (3.00, 2.51),
    (3.22, 2.65),
    (3.44, 2.83),
    (3.67, 2.98),
    (3.89, 3.11),
    (4.11, 3.33),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (width, gravity, density) = (0.05715, 9.81, 1000.0);
    let (height, spacing) = (2.0 * width, width / 24.0);
    let column = Shape::Cuboid { centre: [0.5 * width, 0.5 * height], half: [0.5 * width, 0.5 * height] };
    let column = sample_shape(&column, Pattern::per_cell(spacing, 2), 1)?;
    let velocities = vec![[0.0; 2]; column.positions.len()];

    let mut simulation = Simulation::<f64, 2>::new(SimulationOptions::new(spacing))?;
    simulation.set_gravity([0.0, -gravity])?;
    let tank = Shape::Walls { low: [0.0; 2], high: [10.0 * width; 2] };
    simulation.add_boundary(Boundary::at_rest(tank, Surface::Slip))?;
    // Sound ten times as fast as the water falls: its density changes by about a hundredth.
    let sound_squared = 100.0 * 2.0 * gravity * height;
    let water = Tait::new(density * sound_squared, 7.0, Tension::Vanishes)?;
    let samples = Samples { positions: &column.positions, velocities: &velocities, volumes: &column.volumes };
    let body = simulation.add_body(water, density, samples)?;

    let unit = (0.5 * width / gravity).sqrt();
    // Without the two hundred foremost drops in a hundred thousand; half a particle's cell lies before the last one.
    let front = |simulation: &Simulation<f64, 2>| {
        let mut across: Vec<f64> = simulation.positions(body).iter().map(|x| x[0]).collect();
        across.sort_by(f64::total_cmp);
        (across[across.len() - 1 - across.len() / 500] + 0.25 * spacing) / width
    };
    println!("{} particles, {} cells a width", column.positions.len(), width / spacing);
    println!("front x/a   T measured   T computed   difference");
    let (mut passed, mut before) = (Vec::new(), (0.0, front(&simulation)));
    for (place, measured) in MEASURED {
        let time = loop {
            let now = (simulation.time() / unit, front(&simulation));
            if now.1 >= place {
                break before.0 + (now.0 - before.0) * (place - before.1) / (now.1 - before.1);
            }
            before = now;
            simulation.advance(0.01 * unit)?;
        };
        println!("{place:9.2} {measured:12.2} {time:12.2} {:12.2}", time - measured);
        passed.push((place, time));
    }
    let ((first, begin), (last, end)) = (passed[9], passed[14]);
    // Ritter's 2√(gH) in these units: 2 √(g 2a) √(a/2g)/a = 2.
    let speed = (last - first) / (end - begin);
    let (water, energy) = (simulation.totals(body), density * gravity * width * height * 0.5 * height);
    println!(
        "front from x/a = 3 on: {:.2} of Ritter's 2√(gH); measured {:.2}",
        speed / 2.0,
        1.11 / 0.82 / 2.0
    );
    println!(
        "{} steps; kinetic energy {:.2} of the potential at the start",
        simulation.steps(),
        water.kinetic_energy / energy
    );
    Ok(())
}
