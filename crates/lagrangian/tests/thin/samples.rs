//! Random numbers, loads, statics, and reference values that the tests share.

use mechanics_core::linear::{Method, Solver};
use mechanics_core::newton::{NewtonError, NewtonOptions, NewtonReport, minimise};
use mechanics_core::objective::{IncrementalPotential, TimeStep};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::stage::Scheme;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

/// SplitMix64 (Steele, Lea, Flood 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// In [−1, 1).
    pub(crate) fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    pub(crate) fn rotation(&mut self) -> Mat3 {
        let axis = nalgebra::Unit::new_normalize(self.vector());
        nalgebra::Rotation3::from_axis_angle(&axis, 3.0 * self.number()).into_inner()
    }
}

/// Forces that depend on nothing: −Σ fᵢ · xᵢ.
pub(crate) struct DeadForces(pub(crate) Vec<Vec3>);

impl Stencil<1> for DeadForces {
    fn value(&self, point: usize, x: &[Vec3; 1]) -> f64 {
        -self.0[point].dot(&x[0])
    }
    fn gradient(&self, point: usize, _: &[Vec3; 1]) -> [Vec3; 1] {
        [-self.0[point]]
    }
    fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
        [[Mat3::zeros()]]
    }
}

pub(crate) fn dead_forces(forces: Vec<Vec3>) -> StencilTerm<DeadForces, 1> {
    let elements = (0..forces.len() as u32).map(|i| [i]).collect();
    StencilTerm::new("forces", DeadForces(forces), elements).unwrap()
}

/// Moves the points that are not `fixed` to a minimum of the terms' sum.
pub(crate) fn equilibrium(
    x: &mut [Vec3],
    fixed: &[u32],
    terms: &mut [&mut dyn Potential],
    tolerance: f64,
) -> Result<NewtonReport, Box<NewtonError>> {
    let held: Vec<(u32, Vec3)> = fixed.iter().map(|&i| (i, x[i as usize])).collect();
    let map = PointMap::with_fixed(x.len(), &held).unwrap();
    let mut q = vec![0.0; 3 * map.unknowns()];
    map.unknowns_into(x, &mut q).unwrap();
    let start = x.to_vec();
    let (mut assembly, mut solver) = (Assembly::new(&map), Solver::new(Method::default()));
    let time_step = TimeStep { time: 0.0, step: 0.0, scheme: Scheme::statics(&start) };
    let objective = IncrementalPotential::new(terms, &map, time_step, &mut assembly, &mut solver);
    // Projected Hessians descend from anywhere, but where an element's own Hessian is not definite at the minimum they
    // converge linearly only. So the end is made with the true ones, unless the minimum is degenerate.
    let mut objective = objective.with_projection(Projection::Clamp);
    let options = NewtonOptions { tolerance: 1e-4, max_iterations: 1000, ..NewtonOptions::default() };
    let mut report = minimise(&mut objective, &mut q, &options)?;
    let options = NewtonOptions { tolerance, ..options };
    let mut exact = objective.with_projection(Projection::None);
    let last =
        minimise(&mut exact, &mut q, &NewtonOptions { max_iterations: 50, ..options }).or_else(|_| {
            let mut objective = exact.with_projection(Projection::Clamp);
            minimise(&mut objective, &mut q, &options)
        })?;
    report.iterations += last.iterations;
    map.points_into(&q, x);
    Ok(report)
}

pub(crate) fn reference() -> serde_json::Value {
    serde_json::from_str(include_str!("../fixtures/mechanics_reference.json")).unwrap()
}

/// A number that a fixture holds as a number or as a string.
pub(crate) fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap_or_else(|| value.as_str().unwrap().parse().unwrap())
}

/// log₂ of the ratios of successive errors on meshes of halved size.
pub(crate) fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).abs().log2()).collect()
}

/// The most negative eigenvalue over the largest.
pub(crate) fn relative_lowest<const N: usize>(h: &LocalHessian<N>) -> f64 {
    let entry = |row: usize, column: usize| {
        let (r, c) = (row.max(column), row.min(column));
        h[r / 3][c / 3][(r % 3, c % 3)]
    };
    let values = nalgebra::DMatrix::from_fn(3 * N, 3 * N, entry).symmetric_eigenvalues();
    values.min() / values.amax()
}
