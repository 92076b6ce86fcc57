//! The lowest axial frequency of a fixed–free bar, ω = (2n − 1)πc/2L with n = 1.
//!
//! Consistent mass makes the discrete frequencies those of a Ritz method, so they are above the exact ones; lumped mass
//! brings those of linear elements below. A chain of springs has them in closed form: with k = (2n − 1)π/2L and c = 1
//!
//! - lumped: ω = (2/Δx) sin ½kΔx;
//! - consistent: ω² = (6/Δx²)(1 − cos kΔx)/(2 + cos kΔx).
//!
//! The frequencies of tetrahedra come from subspace iteration: X ← K⁻¹ M X for a block of vectors, then Rayleigh's and
//! Ritz's small problem on their span. The bar also bends and twists, at lower frequencies; its axial mode is the one
//! that moves along the bar, and the mesh has the bar's mirror symmetries, so that it does not mix with the others. With ν = 0 it is exactly that of the one-dimensional bar.
//!
//! # Reference
//! T. J. R. Hughes, *The Finite Element Method*, 1987, sections 7.3 (frequencies) and 10.5.2 (subspace iteration).

use super::solid::{Shape, Solid};
use crate::experiment::random::Random;
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::element::{Mass, MassDistribution, Springs};
use mechanics_core::law::{Lame, Linear};
use mechanics_core::linear::{Accuracy, LinearSolver, Method, Solver};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::Vec3;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::FRAC_PI_2;

/// A chain of springs of length 1 m, c = 1 m/s; the ladder is Δx (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BarOfSprings {}

impl Experiment for BarOfSprings {
    fn methods(&self) -> &'static [&'static str] {
        &["consistent mass", "lumped mass"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let distribution = distribution(at.method);
        let n = (1.0 / at.ladder).round() as u32;
        let dx = 1.0 / f64::from(n);
        let points: Vec<Vec3> = (0..=n).map(|i| Vec3::x() * (f64::from(i) * dx)).collect();
        let edges: Vec<[u32; 2]> = (0..n).map(|i| [i, i + 1]).collect();
        let springs =
            Springs::term("bar", 1.0 / dx, &points, edges.clone()).map_err(ExperimentError::stopped)?;
        let mut mass = Mass::zeros(points.len());
        mass.add_elements(&edges, distribution, |_| [[dx / 3.0, dx / 6.0], [dx / 6.0, dx / 3.0]])
            .map_err(ExperimentError::stopped)?;
        let found = clock.time(|| axial_frequencies(&springs, &mass, &points, dx))?;
        let mut hash = StateHash::new();
        hash.add("frequencies", found.as_slice());
        let discrete = |mode: usize| {
            let cos = ((2 * mode + 1) as f64 * FRAC_PI_2 * dx).cos();
            let squared = match distribution {
                MassDistribution::Consistent => 6.0 * (1.0 - cos) / (2.0 + cos),
                MassDistribution::Lumped => 2.0 * (1.0 - cos),
            };
            squared.sqrt() / dx
        };
        let gap = found.iter().enumerate().map(|(mode, omega)| (omega / discrete(mode) - 1.0).abs());
        let ratio = found[0] / FRAC_PI_2 - 1.0;
        Ok(Outcome::default()
            .error("frequency", ratio.abs())
            .error("all frequencies, closed form", gap.fold(0.0, f64::max))
            .invariant("on the expected side", side(distribution) * ratio)
            .count("unknowns", u64::from(n))
            .state(hash.value()))
    }
}

/// All frequencies of axial motion, ascending. Springs in a line are linear in it, so their forces are the stiffness.
fn axial_frequencies(
    springs: &dyn Potential,
    mass: &Mass,
    points: &[Vec3],
    dx: f64,
) -> Result<Vec<f64>, ExperimentError> {
    let n = points.len() - 1;
    let mut k = DMatrix::zeros(n, n);
    let mut m = DMatrix::zeros(n, n);
    let push = 0.25 * dx;
    for j in 0..n {
        let mut x = points.to_vec();
        x[j + 1].x += push;
        let mut forces = vec![Vec3::zeros(); n + 1];
        springs.add_gradient(&x, &mut forces);
        let mut unit = vec![Vec3::zeros(); n + 1];
        unit[j + 1].x = 1.0;
        let momenta = mass.momenta(&unit);
        for i in 0..n {
            k[(i, j)] = forces[i + 1].x / push;
            m[(i, j)] = momenta[i + 1].x;
        }
    }
    let (squares, _) = ritz(&k, &m)?;
    Ok(squares.iter().map(|square| square.max(0.0).sqrt()).collect())
}

/// A bar of tetrahedra with ν = 0, c = 1 m/s, length 1 m and a square section; the ladder is the distance of nodes (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BarOfTetrahedra {
    /// The section's edge (m).
    height_m: Positive,
}

/// Vectors iterated: more than the modes below the axial one.
const BLOCK: usize = 10;
const MAX_ITERATIONS: u64 = 60;
/// The change of ω² at which the iteration ends.
const TOLERANCE: f64 = 1e-13;

/// The iteration ended without an axial mode.
#[derive(Debug, thiserror::Error)]
#[error("no axial mode after {MAX_ITERATIONS} iterations of {BLOCK} vectors")]
struct NoAxialMode;

/// Cells of the five-tetrahedra split mirror each other, so an odd number of them has no plane of symmetry.
#[derive(Debug, thiserror::Error)]
#[error("{across} cells across the section; a mesh with its mirror symmetries needs an even number")]
struct OddCells {
    across: u32,
}

/// The mass matrix of the small problem is not positive definite.
#[derive(Debug, thiserror::Error)]
#[error("the vectors of the subspace are linearly dependent")]
struct DependentVectors;

impl Experiment for BarOfTetrahedra {
    fn methods(&self) -> &'static [&'static str] {
        &[
            "linear, consistent mass",
            "linear, lumped mass",
            "ten-node, consistent mass",
            "ten-node, lumped mass",
        ]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let shape = if at.method.starts_with("linear") { Shape::Linear } else { Shape::TenNode };
        let distribution = distribution(at.method);
        let height = self.height_m.value();
        let cell = if shape == Shape::Linear { at.ladder } else { 2.0 * at.ladder };
        let across = (height / cell).round() as u32;
        if !across.is_multiple_of(2) {
            return Err(ExperimentError::stopped(OddCells { across }));
        }
        let cells = [(1.0 / cell).round() as u32, across, across];
        let size = Vec3::new(1.0, height, height);
        let mesh = block(&Vec3::zeros(), &size, cells, BoxSplit::Five).map_err(ExperimentError::stopped)?;
        let lame = Lame::from_young_poisson(1.0, 0.0).map_err(ExperimentError::stopped)?;
        let solid = Solid::new(Linear::new(lame), &mesh, shape)?;
        let mass = solid.mass(1.0, distribution)?;
        let map = PointMap::with_fixed(solid.points.len(), &solid.held(|x| x.x == 0.0))
            .map_err(ExperimentError::stopped)?;
        let (omega, iterations) = clock.time(|| axial_frequency(&solid, &mass, &map))?;
        let mut hash = StateHash::new();
        hash.add("frequency", &[omega]);
        let ratio = omega / FRAC_PI_2 - 1.0;
        Ok(Outcome::default()
            .error("frequency", ratio.abs())
            .invariant("on the expected side", side(distribution) * ratio)
            .count("unknowns", 3 * map.unknowns() as u64)
            .count("iterations", iterations)
            .count("factorisations", 1)
            .state(hash.value()))
    }
}

fn distribution(method: &str) -> MassDistribution {
    if method.contains("lumped") { MassDistribution::Lumped } else { MassDistribution::Consistent }
}

/// The sign of the frequency's error.
fn side(distribution: MassDistribution) -> f64 {
    match distribution {
        MassDistribution::Consistent => 1.0,
        MassDistribution::Lumped => -1.0,
    }
}

/// The lowest ω whose mode moves along the bar, and the iterations it took.
fn axial_frequency(solid: &Solid, mass: &Mass, map: &PointMap) -> Result<(f64, u64), ExperimentError> {
    let mut assembly = Assembly::new(map);
    let mut assembler = assembly.begin(map);
    assembler.begin_term(0);
    solid.elastic.add_hessian(&solid.points, Projection::None, &mut assembler);
    let mut solver = Solver::new(Method::default());
    solver.factor(assembler.finish()).map_err(ExperimentError::stopped)?;
    let n = 3 * map.unknowns();
    let mut random = Random::new(1);
    let mut vectors = DMatrix::from_fn(n, BLOCK, |_, _| random.symmetric());
    let (mut last, mut settled) = (0.0, 0);
    for iteration in 1..=MAX_ITERATIONS {
        let pushed = momenta(mass, map, &vectors);
        let mut moved = DMatrix::zeros(n, BLOCK);
        for column in 0..BLOCK {
            let mut x = vec![0.0; n];
            solver
                .solve_into(pushed.column(column).as_slice(), &mut x, Accuracy::Configured)
                .map_err(ExperimentError::stopped)?;
            moved.column_mut(column).copy_from_slice(&x);
        }
        // With X = K⁻¹ M X₀ the small stiffness XᵀKX is XᵀMX₀.
        let small_k = moved.transpose() * &pushed;
        let small_m = moved.transpose() * momenta(mass, map, &moved);
        let (squares, modes) = ritz(&(0.5 * (&small_k + small_k.transpose())), &small_m)?;
        vectors = moved * modes;
        let Some(axial) = (0..BLOCK).find(|&column| axial_part(&vectors.column(column).into_owned()) > 0.9)
        else {
            continue;
        };
        let change = (squares[axial] / last - 1.0).abs();
        last = squares[axial];
        settled = if change < TOLERANCE { settled + 1 } else { 0 };
        if settled == 2 {
            return Ok((last.sqrt(), iteration));
        }
    }
    if last > 0.0 { Ok((last.sqrt(), MAX_ITERATIONS)) } else { Err(ExperimentError::stopped(NoAxialMode)) }
}

/// M X.
fn momenta(mass: &Mass, map: &PointMap, vectors: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(vectors.nrows(), vectors.ncols());
    let mut v = vec![Vec3::zeros(); map.points()];
    for column in 0..vectors.ncols() {
        map.displacements_into(vectors.column(column).as_slice(), &mut v);
        map.gradient_into(&mass.momenta(&v), out.column_mut(column).as_mut_slice());
    }
    out
}

fn axial_part(q: &DVector<f64>) -> f64 {
    q.iter().step_by(3).map(|x| x * x).sum::<f64>() / q.norm_squared()
}

/// ω² of K q = ω² M q, ascending, with the vectors q as columns, qᵀMq = 1.
fn ritz(k: &DMatrix<f64>, m: &DMatrix<f64>) -> Result<(Vec<f64>, DMatrix<f64>), ExperimentError> {
    let dependent = || ExperimentError::stopped(DependentVectors);
    let lower = m.clone().cholesky().ok_or_else(dependent)?.l();
    let inverse = lower.try_inverse().ok_or_else(dependent)?;
    let SymmetricEigen { eigenvalues, eigenvectors } =
        SymmetricEigen::new(&inverse * k * inverse.transpose());
    let mut order: Vec<usize> = (0..eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigenvalues[a].total_cmp(&eigenvalues[b]));
    let vectors = inverse.transpose() * eigenvectors;
    let columns: Vec<DVector<f64>> = order.iter().map(|&i| vectors.column(i).into_owned()).collect();
    Ok((order.iter().map(|&i| eigenvalues[i]).collect(), DMatrix::from_columns(&columns)))
}
