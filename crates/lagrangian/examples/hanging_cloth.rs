//! A cloth between two bars, hanging in its weight, against the elastic catenary.
//!
//! Cloth 1.25 m long and 0.5 m wide, 0.4 kg/m², 0.3 mm thick, hangs between bars 1 m apart. It hardly stretches and
//! hardly resists bending, so it takes the shape of a cable of length L, weight W, and axial stiffness EA, whose half
//! span and sag are, with v = W/2H for the horizontal tension H,
//!
//! - ½w = HL/2EA + (HL/W) asinh v,  sag = WL/8EA + (HL/W)(√(1 + v²) − 1).
//!
//! The inextensible cable sags by 0.331797 m, this one by 0.331934 m. The discrete cloth comes closer with the square of
//! the mesh size:
//!
//! ```text
//! cargo run --release -p lagrangian --example hanging_cloth
//! ```
//!
//! # Reference
//! H. M. Irvine, *Cable Structures*, 1981, section 1.3.

#![allow(clippy::print_stdout)]

use lagrangian::element::hinge::RestAngle;
use lagrangian::element::membrane::{Membranes, NeoHookeanSheet};
use lagrangian::element::plate::PlateBending;
use mechanics_core::linear::{Method, Solver};
use mechanics_core::mesh::{Diagonals, sheet};
use mechanics_core::newton::{NewtonOptions, minimise};
use mechanics_core::objective::{IncrementalPotential, TimeStep};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::stage::Scheme;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};
use std::error::Error;

const LENGTH: f64 = 1.25;
const WIDTH: f64 = 0.5;
const SPAN: f64 = 1.0;
/// 0.4 kg/m² × 9.81 m/s².
const WEIGHT: f64 = 3.924;
const THICKNESS: f64 = 3e-4;
const YOUNG_MODULUS: f64 = 5e7;

/// Weights: Wᵢ z for each point.
struct Weights(Vec<f64>);

impl Stencil<1> for Weights {
    fn value(&self, point: usize, x: &[Vec3; 1]) -> f64 {
        self.0[point] * x[0].z
    }

    fn gradient(&self, point: usize, _: &[Vec3; 1]) -> [Vec3; 1] {
        [Vec3::z() * self.0[point]]
    }

    fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
        [[Mat3::zeros()]]
    }
}

/// The sag of a cable with the cloth's weight and the axial stiffness given, by bisection for H.
fn cable_sag(axial: f64) -> f64 {
    let weight = WEIGHT * LENGTH * WIDTH;
    let arc = |h: f64| h * LENGTH / weight;
    let half_span = |h: f64| 0.5 * h * LENGTH / axial + arc(h) * (0.5 * weight / h).asinh();
    let (mut low, mut high) = (1e-3 * weight, 1e3 * weight);
    for _ in 0..200 {
        let h = 0.5 * (low + high);
        if half_span(h) < 0.5 * SPAN { low = h } else { high = h }
    }
    weight * LENGTH / (8.0 * axial) + arc(low) * ((1.0 + (0.5 * weight / low).powi(2)).sqrt() - 1.0)
}

/// The sag of the cloth with `n` cells along its length, and the Newton iterations it took.
fn cloth_sag(n: u32) -> Result<(f64, u64), Box<dyn Error>> {
    let rows = n / 4;
    let mesh = sheet([LENGTH, WIDTH], [n, rows], Diagonals::Rising)?;
    let law = NeoHookeanSheet::new(YOUNG_MODULUS, 0.0)?;
    let mut membrane = Membranes::term("membrane", &mesh, law, THICKNESS)?;
    let mut bending = PlateBending::new("bending", &mesh, YOUNG_MODULUS, 0.0, THICKNESS, RestAngle::Flat)?;
    let mut weights = vec![0.0; mesh.points().len()];
    for (triangle, area) in mesh.triangles().iter().zip(mesh.areas()) {
        triangle.iter().for_each(|&i| weights[i as usize] += WEIGHT * area / 3.0);
    }
    let points = (0..weights.len() as u32).map(|i| [i]).collect();
    let mut weight = StencilTerm::new("weight", Weights(weights), points)?;

    // A fold that is a little too long, to start from.
    let depth = 0.5 * (LENGTH * LENGTH - SPAN * SPAN).sqrt();
    let fold = |p: &Vec3| {
        let s = p.x / LENGTH;
        Vec3::new(SPAN * s, p.y, -1.01 * depth * (1.0 - (2.0 * s - 1.0).abs()))
    };
    let start: Vec<Vec3> = mesh.points().iter().map(fold).collect();
    let bars: Vec<(u32, Vec3)> =
        (0..=rows).flat_map(|j| [(n + 1) * j, (n + 1) * j + n]).map(|i| (i, start[i as usize])).collect();
    let map = PointMap::with_fixed(start.len(), &bars)?;
    let mut q = vec![0.0; 3 * map.unknowns()];
    map.unknowns_into(&start, &mut q)?;

    let (mut assembly, mut solver) = (Assembly::new(&map), Solver::new(Method::default()));
    let mut terms: [&mut dyn Potential; 3] = [&mut membrane, &mut bending, &mut weight];
    let time_step = TimeStep { time: 0.0, step: 0.0, scheme: Scheme::statics(&start) };
    let mut objective = IncrementalPotential::new(&mut terms, &map, time_step, &mut assembly, &mut solver);
    let options = NewtonOptions { tolerance: 1e-7, max_iterations: 1000, ..NewtonOptions::default() };
    let report = minimise(&mut objective, &mut q, &options)?;
    let mut x = start;
    map.points_into(&q, &mut x);
    Ok((-x[(n / 2 + (n + 1) * (rows / 2)) as usize].z, report.iterations))
}

fn main() -> Result<(), Box<dyn Error>> {
    let exact = cable_sag(YOUNG_MODULUS * WIDTH * THICKNESS);
    println!("catenary: sag {:.6} m; elastic catenary: sag {exact:.6} m", cable_sag(f64::INFINITY));
    for n in [8, 16, 32, 64] {
        let (sag, iterations) = cloth_sag(n)?;
        println!("{n:3} cells: sag {sag:.6} m, {:+.1e} relative, {iterations} iterations", sag / exact - 1.0);
    }
    Ok(())
}
