//! Time for the energy, gradient and projected Hessian of one pair, and the projection of the same 12×12 Hessians by
//! nalgebra's symmetric eigen-decomposition in the same run.
//!
//! `cargo bench -p ipc-contact --bench pair`

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

#[path = "../../mechanics-core/benches/timing/timing.rs"]
mod timing;

use ipc_contact::barrier::SquaredDistanceBarrier;
use ipc_contact::distance::EdgeEdgeMollifier;
use ipc_contact::pair::{
    Curvature, EdgeEdgePairs, PairLaw, PointEdgePairs, PointPointPairs, PointTrianglePairs,
};
use mechanics_core::parallel;
use mechanics_core::point_map::PointMap;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
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
const ACTIVATION: f64 = 1e-3;

/// A part of something.
fn share(random: &mut Random) -> f64 {
    0.5 + 0.4 * random.number()
}

/// Two crossing edges a gap apart, of one centimetre; `angle` scales one direction towards the other.
fn crossing(random: &mut Random, angle: f64) -> [Vec3; 4] {
    let origin = random.vector();
    let u = random.vector() * 0.01;
    let v = u * share(random) + random.vector() * (0.01 * angle);
    let d = u.cross(&v).normalize() * (ACTIVATION * share(random));
    let (a, b) = (share(random), share(random));
    [origin - u * a, origin + u * (1.0 - a), origin - v * b + d, origin + v * (1.0 - b) + d]
}

/// A point over a triangle.
fn hovering(random: &mut Random) -> [Vec3; 4] {
    let origin = random.vector();
    let [a, b, c] = [0; 3].map(|_| origin + random.vector() * 0.01);
    let n = (b - a).cross(&(c - a)).normalize();
    let (s, t) = (share(random), share(random));
    let foot = a * (1.0 - s) + (b * (1.0 - t) + c * t) * s;
    [foot + n * (ACTIVATION * share(random)), a, b, c]
}

fn lists<const N: usize>(make: impl FnMut(usize) -> [Vec3; N]) -> Vec<[Vec3; N]> {
    (0..COUNT).map(make).collect()
}

fn cases<'a, const N: usize>(
    name: &str,
    stencil: &'a impl Stencil<N>,
    rank_one: &'a impl Stencil<N>,
    x: &'a [[Vec3; N]],
) -> Vec<Case<'a>> {
    let mut values = vec![0.0; COUNT];
    let mut gradients = vec![[Vec3::zeros(); N]; COUNT];
    let mut cases = vec![
        Case::new(format!("{name}, value"), COUNT, move || {
            for (k, (x, values)) in x.chunks(RUN).zip(values.chunks_mut(RUN)).enumerate() {
                stencil.values_into(RUN * k, black_box(x), values);
            }
            black_box(&mut values);
        }),
        Case::new(format!("{name}, gradient"), COUNT, move || {
            for (k, (x, gradients)) in x.chunks(RUN).zip(gradients.chunks_mut(RUN)).enumerate() {
                stencil.gradients_into(RUN * k, black_box(x), gradients);
            }
            black_box(&mut gradients);
        }),
    ];
    for projection in [Projection::None, Projection::Clamp, Projection::Absolute] {
        cases.push(hessians(format!("{name}, Hessian, {projection:?}"), stencil, x, projection));
    }
    cases.push(hessians(format!("{name}, Hessian, Gauss-Newton"), rank_one, x, Projection::Clamp));
    cases
}

fn hessians<'a, const N: usize>(
    name: String,
    stencil: &'a impl Stencil<N>,
    x: &'a [[Vec3; N]],
    projection: Projection,
) -> Case<'a> {
    let mut hessians: Vec<LocalHessian<N>> = vec![[[Mat3::zeros(); N]; N]; RUN];
    Case::new(name, COUNT, move || {
        for (k, x) in x.chunks(RUN).enumerate() {
            stencil.hessians_into(RUN * k, black_box(x), projection, &mut hessians);
            black_box(&mut hessians);
        }
    })
}

/// The same Hessians, clamped by nalgebra.
fn numeric<'a>(name: &str, stencil: &'a impl Stencil<4>, x: &'a [[Vec3; 4]]) -> Case<'a> {
    Case::new(format!("{name}, nalgebra 12x12 eigen and rebuild"), COUNT, move || {
        for (k, x) in x.iter().enumerate() {
            let hessian = stencil.hessian(k, x, Projection::None);
            let whole: SMatrix<f64, 12, 12> = SMatrix::from_fn(|i, j| {
                let (i, j) = (i.max(j), i.min(j));
                hessian[i / 3][j / 3][(i % 3, j % 3)]
            });
            let eigen = black_box(whole).symmetric_eigen();
            let clamped = eigen.eigenvalues.map(|value| value.max(0.0));
            black_box(eigen.eigenvectors * SMatrix::from_diagonal(&clamped) * eigen.eigenvectors.transpose());
        }
    })
}

/// Assembled into the block matrix of all points.
fn assembled<'a>(name: &str, stencil: &'a impl Stencil<4>, x: &'a [[Vec3; 4]]) -> Case<'a> {
    // Neighbouring pairs share points, as neighbouring contacts do.
    let elements: Vec<[u32; 4]> =
        (0..COUNT as u32).map(|k| [k, k + 1, COUNT as u32 + k, COUNT as u32 + k + 1]).collect();
    let map = PointMap::identity(2 * COUNT + 2);
    let mut assembly = Assembly::new(&map);
    Case::new(format!("{name}, clamped and assembled"), COUNT, move || {
        let mut assembler = assembly.begin(&map);
        assembler.begin_term(0);
        assembler.add_batches(&elements, |first, hessians: &mut [LocalHessian<4>]| {
            stencil.hessians_into(first, &x[first..first + hessians.len()], Projection::Clamp, hessians);
        });
        black_box(assembler.finish());
    })
}

fn main() {
    timing::print_calibration();
    parallel::with_threads(1, compare);
}

fn compare() {
    let barrier = match SquaredDistanceBarrier::new(ACTIVATION) {
        Ok(barrier) => barrier,
        Err(error) => return println!("{error}"),
    };
    let law = PairLaw { barrier: &barrier, stiffness: 1e6, curvature: Curvature::Full };
    let gauss_newton = PairLaw { curvature: Curvature::GaussNewton, ..law };
    let weights = vec![1.0; COUNT];
    let weights = &weights[..];
    let mut random = Random(1);

    let x = lists(|_| {
        let [a, _, c, _] = crossing(&mut random, 1.0);
        [a, a + (c - a).normalize() * 5e-4]
    });
    let (full, rank_one) = (PointPointPairs { law, weights }, PointPointPairs { law: gauss_newton, weights });
    measure("two points", REPEATS, cases("point-point", &full, &rank_one, &x));

    let x = lists(|_| {
        let [p, a, b, _] = hovering(&mut random);
        let along = (b - a) * 0.4;
        let across = (p - a).cross(&along).normalize() * 5e-4;
        [a + along + across, a, b]
    });
    let (full, rank_one) = (PointEdgePairs { law, weights }, PointEdgePairs { law: gauss_newton, weights });
    measure("a point and an edge", REPEATS, cases("point-edge", &full, &rank_one, &x));

    let x = lists(|_| hovering(&mut random));
    let (full, rank_one) =
        (PointTrianglePairs { law, weights }, PointTrianglePairs { law: gauss_newton, weights });
    let mut list = vec![numeric("point-triangle", &full, &x)];
    list.extend(cases("point-triangle", &full, &rank_one, &x));
    list.push(assembled("point-triangle", &full, &x));
    measure("a point and a triangle", REPEATS, list);

    for (title, angle) in [("two edges", 1.0), ("two nearly parallel edges", 0.01)] {
        let x = lists(|_| crossing(&mut random, angle));
        let mollifiers: Vec<EdgeEdgeMollifier> = x.iter().map(EdgeEdgeMollifier::from_rest).collect();
        let mollifiers = &mollifiers[..];
        let active = x.iter().zip(mollifiers).filter(|(x, mollifier)| mollifier.is_active(x)).count();
        println!("\n{active} of {COUNT} pairs are mollified");
        let full = EdgeEdgePairs { law, weights, mollifiers, regions: &[] };
        let rank_one = EdgeEdgePairs { law: gauss_newton, weights, mollifiers, regions: &[] };
        let mut list = vec![numeric("edge-edge", &full, &x)];
        list.extend(cases("edge-edge", &full, &rank_one, &x));
        list.push(assembled("edge-edge", &full, &x));
        measure(title, REPEATS, list);
    }
}
