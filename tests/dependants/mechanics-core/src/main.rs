//! A weight on ten springs in series: statics by Newton's method and a sparse factorisation.

use mechanics_core::linear::{Method, Solver};
use mechanics_core::newton::{NewtonOptions, minimise};
use mechanics_core::objective::{IncrementalPotential, TimeStep};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::stage::Scheme;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

/// Springs of rest length zero: ½ k |x₁ − x₀|².
struct Spring(f64);

impl Stencil<2> for Spring {
    fn value(&self, _: usize, x: &[Vec3; 2]) -> f64 {
        0.5 * self.0 * (x[1] - x[0]).norm_squared()
    }

    fn gradient(&self, _: usize, x: &[Vec3; 2]) -> [Vec3; 2] {
        let tension = (x[1] - x[0]) * self.0;
        [-tension, tension]
    }

    fn hessian(&self, _: usize, _: &[Vec3; 2], _: Projection) -> LocalHessian<2> {
        let h = Mat3::identity() * self.0;
        [[h, -h], [-h, h]]
    }
}

/// A weight: W z.
struct Weight(f64);

impl Stencil<1> for Weight {
    fn value(&self, _: usize, x: &[Vec3; 1]) -> f64 {
        self.0 * x[0].z
    }

    fn gradient(&self, _: usize, _: &[Vec3; 1]) -> [Vec3; 1] {
        [Vec3::z() * self.0]
    }

    fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
        [[Mat3::zeros()]]
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (springs, stiffness, weight) = (10, 200.0, 30.0);
    let start: Vec<Vec3> = (0..=springs).map(|i| Vec3::new(0.1 * f64::from(i), 0.0, 0.0)).collect();
    let chain = (0..springs).map(|i| [i, i + 1]).collect();
    let mut chain = StencilTerm::new("springs", Spring(stiffness), chain)?;
    let mut load = StencilTerm::new("weight", Weight(weight), vec![[springs]])?;

    let map = PointMap::with_fixed(start.len(), &[(0, start[0])])?;
    let mut q = vec![0.0; 3 * map.unknowns()];
    map.unknowns_into(&start, &mut q)?;
    let (mut assembly, mut solver) = (Assembly::new(&map), Solver::new(Method::default()));
    let mut terms: [&mut dyn Potential; 2] = [&mut chain, &mut load];
    let time_step = TimeStep { time: 0.0, step: 0.0, scheme: Scheme::statics(&start) };
    let mut objective = IncrementalPotential::new(&mut terms, &map, time_step, &mut assembly, &mut solver);
    let report = minimise(&mut objective, &mut q, &NewtonOptions::default())?;

    let mut x = start;
    map.points_into(&q, &mut x);
    let (way, exact) = (-x[springs as usize].z, f64::from(springs) * weight / stiffness);
    println!(
        "the weight hangs {way:.12} m below the nail; n W/k is {exact} m ({} iterations)",
        report.iterations
    );
    assert!((way - exact).abs() < 1e-12);
    Ok(())
}
