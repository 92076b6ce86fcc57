//! A bunny falls into sand. The sand knows of it as a collider with a prescribed motion; its fall is integrated here, with the impulses that the
//! collider reports: the seam for rigid bodies. Prints how deep it sinks, what carries it in the end, and how the sand comes to rest.
//!
//! ```text
//! cargo run -p mpm-core --example bunny_in_sand
//! ```
#![allow(clippy::print_stdout)]

use mechanics_core::law::Lame;
use mechanics_core::mesh::io::obj;
use mechanics_core::tensor::Vec3;
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle};
use mpm_core::sampling::{Pattern, sample_shape};
use mpm_core::{
    Boundary, Collider, RigidMotion, Samples, Shape, Simulation, SimulationOptions, SolidMesh, Surface,
};
use std::error::Error;
use std::path::Path;

const GRAVITY: f64 = 9.81;
const SPACING: f64 = 0.02;
const HEIGHT: f64 = 0.2;
const BED: f64 = 0.14;
const HALF: f64 = 0.2;

/// The bunny, as high as asked, its feet at `floor`, its middle above the origin.
fn bunny(floor: f64) -> Result<SolidMesh, Box<dyn Error>> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/assets/meshes");
    let mut mesh = obj::read_file(assets.join("bunny.obj"))?;
    // The file has y upward.
    mesh.map_points(|p| Vec3::new(p.x, -p.z, p.y))?;
    let bounds = mesh.bounding_box().ok_or("an empty mesh")?;
    mesh.translate(&-bounds.centre())?;
    mesh.scale(HEIGHT / bounds.size().z)?;
    mesh.translate(&Vec3::new(0.0, 0.0, floor + 0.5 * HEIGHT))?;
    Ok(SolidMesh::new(&mesh)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let bed = Shape::Cuboid { centre: [0.0, 0.0, 0.5 * BED], half: [HALF, HALF, 0.5 * BED] };
    let bed = sample_shape(&bed, Pattern::per_cell(SPACING, 2), 1)?;
    let velocities = vec![[0.0; 3]; bed.positions.len()];
    let mut simulation = Simulation::<f32, 3>::new(SimulationOptions::new(SPACING))?;
    simulation.set_gravity([0.0, 0.0, -GRAVITY])?;
    let walls = Shape::Walls { low: [-HALF, -HALF, f64::NEG_INFINITY], high: [HALF, HALF, f64::INFINITY] };
    simulation.add_boundary(Boundary::at_rest(walls, Surface::Slip))?;
    let floor = Shape::HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
    simulation.add_boundary(Boundary::at_rest(floor, Surface::Sticky))?;
    let sand = DruckerPrager::new(Lame::from_young_poisson(3e5, 0.3)?, FrictionAngle::constant(0.6)?, 0.0)?;
    let samples = Samples { positions: &bed.positions, velocities: &velocities, volumes: &bed.volumes };
    let body = simulation.add_body(sand, 1600.0, samples)?;
    let bunny = bunny(BED + 0.03)?;
    let mass = 1200.0 * bunny.mesh().enclosed_volume();
    println!(
        "{} particles, a bunny of {} triangles and {mass:.2} kg",
        bed.positions.len(),
        bunny.mesh().triangles().len()
    );
    let bunny = simulation.add_collider(Collider::at_rest(bunny, Surface::Friction(0.5)))?;

    let (mut speed, mut steps, mut frame) = (0.0, 0, 0.0);
    let (mut pushed, mut fastest) = (0.0, 0.0_f64);
    while simulation.time() < 0.8 {
        let step = simulation.stable_step();
        fastest = fastest.max(simulation.step(step)?.speed);
        let load = simulation.collider_load(bunny).step.linear.z;
        // Newton's law of the bunny, which only falls: it does not turn.
        speed += load / mass - GRAVITY * step;
        pushed += load;
        simulation.set_collider_motion(bunny, RigidMotion::translation([0.0, 0.0, speed]))?;
        steps += 1;
        if simulation.time() >= frame + 0.1 {
            let sunk = -simulation.collider_placement(bunny).translation.z - 0.03;
            let carried = pushed / ((simulation.time() - frame) * mass * GRAVITY);
            println!(
                "{:.1} s: {:5.1} mm deep, carried to {carried:.3} of its weight, fastest sand {fastest:.3} m/s",
                simulation.time(),
                1e3 * sunk,
            );
            (frame, pushed, fastest) = (simulation.time(), 0.0, 0.0);
        }
    }
    let totals = simulation.totals(body);
    println!(
        "{steps} steps; mass of the sand {:.4} kg; mean speed {:.1e} m/s",
        totals.mass,
        (2.0 * totals.kinetic_energy / totals.mass).sqrt()
    );
    Ok(())
}
