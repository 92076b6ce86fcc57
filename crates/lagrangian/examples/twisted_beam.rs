//! A round rubber beam twisted between two clamps, and the torque it takes.
//!
//! A neo-Hookean cylinder of radius a, twisted by ψ per length and held at its length, keeps round and plane cross-sections. In the
//! limit of incompressibility its torque is M = ½πμψa⁴ and it pushes its clamps apart with N = ¼πμψ²a⁴, the Poynting effect (Rivlin
//! 1949). This example twists a mesh of ten-node tetrahedra in three load steps and compares.
//!
//! `cargo run --release -p lagrangian --example twisted_beam`

#![allow(clippy::print_stdout, reason = "an example prints")]

use lagrangian::element::{EDGES, Mass, QuadraticMesh, QuadraticTetrahedra};
use lagrangian::stepper::{Stepper, StepperOptions};
use mechanics_core::law::{Lame, NeoHookean};
use mechanics_core::mesh::cylinder;
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use std::error::Error;
use std::f64::consts::PI;

const RADIUS: f64 = 0.1;
const LENGTH: f64 = 0.4;
/// Twist per length [rad/m]: the rim is sheared by 0.3, and the ends turn by 69° against each other.
const TWIST: f64 = 3.0;

fn main() -> Result<(), Box<dyn Error>> {
    let lame = Lame::from_young_poisson(1e6, 0.49)?;
    let linear = cylinder(RADIUS, LENGTH, 3, 6)?;
    let mut mesh = QuadraticMesh::new(&linear);
    round_off(&mut mesh);
    let mut elastic = QuadraticTetrahedra::term("rubber", NeoHookean::new(lame), &mesh)?;

    let turned = |x: &Vec3| {
        let (sin, cos) = (TWIST * x.z).sin_cos();
        Vec3::new(cos * x.x - sin * x.y, sin * x.x + cos * x.y, x.z)
    };
    let top = |x: &Vec3| (x.z - LENGTH).abs() < 1e-9 * LENGTH;
    let clamped = |x: &Vec3| x.z == 0.0 || top(x);
    let ends: Vec<(u32, Vec3)> =
        mesh.points.iter().zip(0..).filter(|(x, _)| clamped(x)).map(|(x, i)| (i, turned(x))).collect();
    let map = PointMap::with_fixed(mesh.points.len(), &ends)?;
    let newton = NewtonOptions { tolerance: 1e-9, ..Default::default() };
    let options = StepperOptions { newton, ..Default::default() };
    let mut stepper = Stepper::new(Mass::zeros(mesh.points.len()), map, options);
    let mut state = State::at_rest(mesh.points.clone());
    let report = stepper.equilibrium(&mut state, &mut [&mut elastic], 3)?;

    let mut forces = vec![Vec3::zeros(); mesh.points.len()];
    elastic.add_gradient(&state.position, &mut forces);
    let held = || mesh.points.iter().zip(&forces).zip(&state.position).filter(|((rest, _), _)| top(rest));
    let torque: f64 = held().map(|((_, f), x)| x.x * f.y - x.y * f.x).sum();
    let push: f64 = held().map(|((_, f), _)| -f.z).sum();
    let (mu, a4) = (lame.mu(), RADIUS.powi(4));
    let (exact_torque, exact_push) = (0.5 * PI * mu * TWIST * a4, 0.25 * PI * mu * TWIST * TWIST * a4);
    println!(
        "{} ten-node tetrahedra, {} Newton iterations in {:.1} s",
        mesh.cells.len(),
        report.newton.iterations,
        report.time.as_secs_f64()
    );
    println!("torque {torque:.3} N m, Rivlin's {exact_torque:.3}: ratio {:.4}", torque / exact_torque);
    println!("push   {push:.3} N,   Rivlin's {exact_push:.3}: ratio {:.4}", push / exact_push);
    Ok(())
}

/// Moves the mid-edge nodes of the rim's chords out onto the circle: elements with curved edges.
fn round_off(mesh: &mut QuadraticMesh) {
    let radius = |x: &Vec3| x.xy().norm();
    let on_rim = |x: &Vec3| radius(x) > 0.999 * RADIUS;
    for cell in &mesh.cells {
        for (edge, &node) in EDGES.iter().zip(&cell[4..]) {
            if edge.iter().all(|&corner| on_rim(&mesh.points[cell[corner] as usize])) {
                let x = mesh.points[node as usize];
                let stretch = RADIUS / radius(&x);
                mesh.points[node as usize] = Vec3::new(x.x * stretch, x.y * stretch, x.z);
            }
        }
    }
}
