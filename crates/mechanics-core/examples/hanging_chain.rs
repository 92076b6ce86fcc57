//! A chain of stiff springs between two nails, hanging in its weight: statics by minimisation.
//!
//! The continuous chain of length L with its ends at the same height, w apart, is the catenary y = a cosh(x/a), where
//! L = 2a sinh(w/2a); it sags by a (cosh(w/2a) − 1). A thousand links come within a few millionths of it:
//!
//! ```text
//! cargo run -p mechanics-core --example hanging_chain
//! ```

#![allow(clippy::print_stdout)]

use mechanics_core::derivatives::check_stencil;
use mechanics_core::linear::{Method, Solver};
use mechanics_core::newton::{NewtonOptions, minimise};
use mechanics_core::objective::{IncrementalPotential, TimeStep};
use mechanics_core::point_map::PointMap;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::stage::Scheme;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

/// Links: ½ (k/ℓ) (|x₁ − x₀| − ℓ)², with the stiffness k [N] of the chain and the length ℓ [m] of a link.
struct Links {
    stiffness: f64,
    length: f64,
}

impl Stencil<2> for Links {
    fn value(&self, _: usize, x: &[Vec3; 2]) -> f64 {
        0.5 * self.stiffness / self.length * ((x[1] - x[0]).norm() - self.length).powi(2)
    }

    fn gradient(&self, _: usize, x: &[Vec3; 2]) -> [Vec3; 2] {
        let d = x[1] - x[0];
        let tension = d.normalize() * (self.stiffness * (d.norm() / self.length - 1.0));
        [-tension, tension]
    }

    /// Along the link k/ℓ; across it the tension over the distance, negative under compression: projected.
    fn hessian(&self, _: usize, x: &[Vec3; 2], projection: Projection) -> LocalHessian<2> {
        let d = x[1] - x[0];
        let along = d.normalize() * d.normalize().transpose();
        let across = projection.apply(self.stiffness * (1.0 / self.length - 1.0 / d.norm()));
        let h = along * (self.stiffness / self.length) + (Mat3::identity() - along) * across;
        [[h, -h], [-h, h]]
    }
}

/// Weights: m g z for each point.
struct Weights {
    weight: f64,
}

impl Stencil<1> for Weights {
    fn value(&self, _: usize, x: &[Vec3; 1]) -> f64 {
        self.weight * x[0].z
    }

    fn gradient(&self, _: usize, _: &[Vec3; 1]) -> [Vec3; 1] {
        [Vec3::z() * self.weight]
    }

    fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
        [[Mat3::zeros()]]
    }
}

/// The sag of a catenary of length `length` between nails `width` apart.
fn catenary_sag(length: f64, width: f64) -> f64 {
    // L/w = sinh(u)/u with u = w/2a, by bisection.
    let (mut low, mut high) = (1e-6_f64, 20.0_f64);
    for _ in 0..200 {
        let u = 0.5 * (low + high);
        if u.sinh() / u < length / width { low = u } else { high = u }
    }
    width / (2.0 * low) * (low.cosh() - 1.0)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (links, length, width, weight) = (1000_usize, 2.0, 1.0, 10.0);
    let links_stencil = Links { stiffness: 1e7, length: length / links as f64 };
    let stretched = [Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0) * links_stencil.length];
    check_stencil(&links_stencil, 0, &stretched).require(1e-7)?;

    // Start: a polygon that is a little too long, down and up again.
    let at = |i: usize| i as f64 / links as f64;
    let depth = 0.5 * (length * length - width * width).sqrt();
    let start: Vec<Vec3> = (0..=links)
        .map(|i| Vec3::new(width * at(i), 0.0, -1.01 * depth * (1.0 - (2.0 * at(i) - 1.0).abs())))
        .collect();
    let elements = (0..links as u32).map(|i| [i, i + 1]).collect();
    let mut springs = StencilTerm::new("links", links_stencil, elements)?;
    let points = (0..=links as u32).map(|i| [i]).collect();
    let mut weights = StencilTerm::new("weight", Weights { weight: weight / links as f64 }, points)?;

    let nails = [(0, start[0]), (links as u32, start[links])];
    let map = PointMap::with_fixed(start.len(), &nails)?;
    let mut q = vec![0.0; 3 * map.unknowns()];
    map.unknowns_into(&start, &mut q)?;
    let (mut assembly, mut solver) = (Assembly::new(&map), Solver::new(Method::default()));
    let mut terms: [&mut dyn mechanics_core::potential::Potential; 2] = [&mut springs, &mut weights];
    let time_step = TimeStep { time: 0.0, step: 0.0, scheme: Scheme::statics(&start) };
    let mut objective = IncrementalPotential::new(&mut terms, &map, time_step, &mut assembly, &mut solver);
    let options = NewtonOptions { tolerance: 1e-9, max_iterations: 1000, ..NewtonOptions::default() };
    let report = minimise(&mut objective, &mut q, &options)?;

    let mut x = start.clone();
    map.points_into(&q, &mut x);
    let sag = -x.iter().map(|x| x.z).fold(0.0, f64::min);
    let exact = catenary_sag(length, width);
    println!("{} iterations, {} halvings, {} shifts", report.iterations, report.halvings, report.shifts);
    println!("sag {sag:.6} m, catenary {exact:.6} m, relative difference {:.1e}", (sag / exact - 1.0).abs());
    Ok(())
}
