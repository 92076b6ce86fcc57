//! What colliders cost: a bunny in a bed of sand, as part of a step, at rest and moving; a signed distance, beside parry's.
//!
//! Ratios from one run; medians of interleaved repeats.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

#[path = "../tests/boundaries/parry.rs"]
mod parry;

#[path = "../../mechanics-core/benches/timing/timing.rs"]
mod timing;

use mechanics_core::law::Lame;
use mechanics_core::mesh::TriMesh;
use mechanics_core::mesh::io::obj;
use mechanics_core::parallel::with_threads;
use mechanics_core::tensor::Vec3;
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle};
use mpm_core::sampling::{Pattern, sample_shape};
use mpm_core::{
    Boundary, Collider, RigidMotion, Samples, Shape, Simulation, SimulationOptions, SolidMesh, Surface,
};
use parry::Parry;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;
use timing::median;

const SPACING: f64 = 0.02;

/// The bunny, 0.3 m high, with its middle at a place.
fn bunny(middle: Vec3) -> TriMesh {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/assets/meshes");
    let mut mesh = obj::read_file(assets.join("bunny.obj")).unwrap();
    let bounds = mesh.bounding_box().unwrap();
    mesh.translate(&-bounds.centre()).unwrap();
    mesh.scale(0.3 / bounds.size().max()).unwrap();
    mesh.translate(&middle).unwrap();
    mesh
}

/// A bed of sand around the lower half of a bunny, which is `away` from its place.
fn scene(away: f64) -> Simulation<f32, 3> {
    let solid = SolidMesh::new(&bunny(Vec3::new(0.0, 0.0, 0.2))).unwrap();
    let half = 0.32;
    let bed = Shape::Cuboid { centre: [0.0, 0.0, 0.1], half: [half, half, 0.1] };
    let mut bed = sample_shape(&bed, Pattern::per_cell(SPACING, 2), 1).unwrap();
    bed.positions.retain(|x| solid.signed_distance(*x).distance > 0.2 * SPACING);
    bed.volumes.truncate(bed.positions.len());
    let velocities = vec![[0.0; 3]; bed.positions.len()];
    let mut simulation = Simulation::new(SimulationOptions::new(SPACING)).unwrap();
    simulation.set_gravity([0.0, 0.0, -9.81]).unwrap();
    let box_ = Shape::Walls { low: [-half, -half, 0.0], high: [half, half, 1.0] };
    simulation.add_boundary(Boundary::at_rest(box_, Surface::Slip)).unwrap();
    let lame = Lame::from_young_poisson(1e6, 0.3).unwrap();
    let sand = DruckerPrager::new(lame, FrictionAngle::constant(0.6).unwrap(), 0.0).unwrap();
    let samples = Samples { positions: &bed.positions, velocities: &velocities, volumes: &bed.volumes };
    simulation.add_body(sand, 1600.0, samples).unwrap();
    let solid = SolidMesh::new(&bunny(Vec3::new(away, 0.0, 0.2))).unwrap();
    simulation.add_collider(Collider::at_rest(solid, Surface::Friction(0.5))).unwrap();
    simulation
}

/// Of steps of the same state, with the bunny and with one far away: the collider's part of the whole step.
fn part(motion: Option<RigidMotion>, repeats: usize) -> (f64, f64, f64) {
    let (mut with, mut without) = (scene(0.0), scene(100.0));
    with.advance(0.01).unwrap();
    if let Some(motion) = motion {
        with.set_collider_motion(0, motion).unwrap();
        without.set_collider_motion(0, motion).unwrap();
    }
    let (mut near, mut far, mut whole) = (Vec::new(), Vec::new(), Vec::new());
    let step = 0.5 * with.stable_step();
    for _ in 0..repeats {
        without.resume(with.checkpoint()).unwrap();
        let _sorted = (without.step(step).unwrap(), with.step(step).unwrap());
        // The second step after sorting is like most.
        let _plain = (without.step(step).unwrap(), with.step(step).unwrap());
        let (a, b) = (with.stage_times(), without.stage_times());
        near.push(a.nodes);
        far.push(b.nodes);
        whole.push(a.sort + a.scatter + a.nodes + a.gather);
    }
    let whole = median(whole);
    let particles = with.particle_count(0);
    println!(
        "  {particles} particles, a step {:.3} ms: nodes {:.3} ms, without the bunny {:.3} ms",
        1e3 * whole,
        1e3 * median(near.clone()),
        1e3 * median(far.clone())
    );
    (median(near), median(far), whole)
}

fn main() {
    let repeats = if std::env::args().any(|argument| argument == "--quick") { 11 } else { 41 };
    with_threads(1, || {
        for (name, motion) in [
            ("at rest", None),
            (
                "turning and sinking",
                Some(RigidMotion {
                    centre: [0.0, 0.0, 0.2],
                    velocity: [0.0, 0.0, -0.05],
                    angular_velocity: [0.0, 0.0, 1.0],
                }),
            ),
        ] {
            println!("bunny in sand, {name}:");
            let (near, far, whole) = part(motion, repeats);
            println!("  the collider takes {:.1} % of a step (15 wanted)", 100.0 * (near - far) / whole);
        }
        distances();
    });
}

/// A signed distance of the bunny from places around it.
fn distances() {
    let mesh = bunny(Vec3::zeros());
    let solid = SolidMesh::new(&mesh).unwrap();
    let parry = Parry::new(&mesh);
    let places: Vec<[f64; 3]> = (0..20_000_u32)
        .map(|k| {
            [0.819_172_5, 0.671_043_6, 0.549_700_4].map(|step| 0.4 * ((f64::from(k) * step).fract() - 0.5))
        })
        .collect();
    let (mut own, mut other) = (Vec::new(), Vec::new());
    for _ in 0..5 {
        let start = Instant::now();
        for place in &places {
            black_box(solid.signed_distance(*place));
        }
        own.push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        for place in &places {
            black_box(parry.signed_distance(&(*place).into()));
        }
        other.push(start.elapsed().as_secs_f64());
    }
    let (own, other) = (median(own), median(other));
    let count = places.len() as f64;
    println!(
        "signed distance of {} triangles: {:.0} ns, parry {:.0} ns ({:.2} times)",
        mesh.triangles().len(),
        1e9 * own / count,
        1e9 * other / count,
        other / own
    );
}
