//! Time for the energy, gradient and projected Hessian of one pair with friction, and the projection of the same 12×12 Hessians
//! by nalgebra's symmetric eigen-decomposition in the same run.
//!
//! `cargo bench -p ipc-friction --bench friction`

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

#[path = "../../mechanics-core/benches/timing/timing.rs"]
mod timing;

use ipc_contact::normal_force::NormalForce;
use ipc_friction::FrictionError;
use ipc_friction::law::{FrictionCoefficient, SmoothedCoulomb, Strength};
use ipc_friction::pair::{FrictionPairs, LaggedPair};
use mechanics_core::parallel;
use mechanics_core::point_map::PointMap;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::stage::{Coefficients, Scheme};
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::SMatrix;
use std::hint::black_box;
use timing::{Case, Random, measure};

/// Pairs in a list.
const COUNT: usize = 256;
/// Pairs in one call, as core's terms and assembler have it.
const RUN: usize = 32;
/// Interleaved repeats, of which the median counts.
const REPEATS: usize = 101;
/// a of backward Euler with h = 0.01 s.
const A: f64 = 100.0;

/// Random pairs, half of them slower than the stick velocity of 1 cm/s.
fn pairs<const N: usize>(
    random: &mut Random,
    kinetic: f64,
) -> Result<(FrictionPairs<N>, Vec<[Vec3; N]>), FrictionError> {
    let law = SmoothedCoulomb::new(0.01)?;
    let coefficient = FrictionCoefficient::with_kinetic(0.5, kinetic)?;
    let (mut pairs, mut x) = (Vec::new(), Vec::new());
    for _ in 0..COUNT {
        let origin: [Vec3; N] = std::array::from_fn(|_| random.vector());
        let mut weights: [f64; N] = std::array::from_fn(|_| random.number());
        weights[N - 1] -= weights.iter().sum::<f64>();
        let points = std::array::from_fn(|i| i as u32);
        let force = NormalForce::new(points, weights, random.vector().normalize(), 1e-3, 5.0);
        let scheme = Scheme::new(Coefficients { inertia: A * A, velocity: A }, &origin, &origin);
        pairs.push(LaggedPair::new(&force, Strength::new(coefficient, 5.0), &scheme));
        x.push(origin.map(|point| point + random.vector() * (0.01 / A)));
    }
    Ok((FrictionPairs { law, velocity_factor: A, floor: 0.0, pairs }, x))
}

fn cases<'a, const N: usize>(pairs: &'a FrictionPairs<N>, x: &'a [[Vec3; N]]) -> Vec<Case<'a>> {
    let mut values = vec![0.0; COUNT];
    let mut gradients = vec![[Vec3::zeros(); N]; RUN];
    let mut hessians: Vec<LocalHessian<N>> = vec![[[Mat3::zeros(); N]; N]; RUN];
    let mut unprojected = hessians.clone();
    vec![
        Case::new("value", COUNT, move || {
            for first in (0..COUNT).step_by(RUN) {
                pairs.values_into(first, &x[first..first + RUN], &mut values[first..first + RUN]);
            }
            black_box(&values);
        }),
        Case::new("gradient", COUNT, move || {
            for first in (0..COUNT).step_by(RUN) {
                pairs.gradients_into(first, &x[first..first + RUN], &mut gradients);
                black_box(&gradients);
            }
        }),
        Case::new("Hessian", COUNT, move || {
            for first in (0..COUNT).step_by(RUN) {
                pairs.hessians_into(first, &x[first..first + RUN], Projection::None, &mut unprojected);
                black_box(&unprojected);
            }
        }),
        Case::new("Hessian, clamped", COUNT, move || {
            for first in (0..COUNT).step_by(RUN) {
                pairs.hessians_into(first, &x[first..first + RUN], Projection::Clamp, &mut hessians);
                black_box(&hessians);
            }
        }),
    ]
}

/// The projection of the 12×12 Hessians alone, by nalgebra.
fn numeric<'a>(pairs: &FrictionPairs<4>, x: &[[Vec3; 4]]) -> Case<'a> {
    let whole = |(k, x): (usize, &[Vec3; 4])| {
        let hessian = pairs.hessian(k, x, Projection::None);
        SMatrix::<f64, 12, 12>::from_fn(|i, j| {
            let (i, j) = (i.max(j), i.min(j));
            hessian[i / 3][j / 3][(i % 3, j % 3)]
        })
    };
    let matrices: Vec<_> = x.iter().enumerate().map(whole).collect();
    Case::new("projection alone, nalgebra 12×12", COUNT, move || {
        for matrix in &matrices {
            let mut eigen = matrix.symmetric_eigen();
            eigen.eigenvalues.iter_mut().for_each(|value| *value = value.max(0.0));
            black_box(eigen.recompose());
        }
    })
}

/// The clamped Hessians of pairs that share points as neighbouring contacts do, assembled.
fn assembled<'a>(pairs: &'a FrictionPairs<4>, x: &'a [[Vec3; 4]]) -> Case<'a> {
    let elements: Vec<[u32; 4]> =
        (0..COUNT as u32).map(|k| [k, k + 1, COUNT as u32 + k, COUNT as u32 + k + 1]).collect();
    let map = PointMap::identity(2 * COUNT + 2);
    let mut assembly = Assembly::new(&map);
    Case::new("Hessian, clamped and assembled", COUNT, move || {
        let mut assembler = assembly.begin(&map);
        assembler.begin_term(0);
        assembler.add_batches(&elements, |first, hessians: &mut [LocalHessian<4>]| {
            pairs.hessians_into(first, &x[first..first + hessians.len()], Projection::Clamp, hessians);
        });
        black_box(assembler.finish());
    })
}

fn compare() -> Result<(), FrictionError> {
    let mut random = Random(1);
    let (ones, x) = pairs::<1>(&mut random, 0.5)?;
    measure("a point and a half-space", REPEATS, cases(&ones, &x));
    let (twos, x) = pairs::<2>(&mut random, 0.5)?;
    measure("two points", REPEATS, cases(&twos, &x));
    let (threes, x) = pairs::<3>(&mut random, 0.5)?;
    measure("a point and an edge", REPEATS, cases(&threes, &x));
    for (title, kinetic) in [("four points", 0.5), ("four points, kinetic below static", 0.3)] {
        let (fours, x) = pairs::<4>(&mut random, kinetic)?;
        let mut list = vec![numeric(&fours, &x)];
        list.extend(cases(&fours, &x));
        list.push(assembled(&fours, &x));
        measure(title, REPEATS, list);
    }
    Ok(())
}

fn main() -> Result<(), FrictionError> {
    timing::print_calibration();
    parallel::with_threads(1, compare)
}
