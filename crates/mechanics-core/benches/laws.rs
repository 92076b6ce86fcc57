//! Time for the stiffness of a tetrahedron: closed-form projection against nalgebra's 12×12 eigen-solve, one
//! element at a time and in lanes, and the steps around it.
//!
//! `cargo bench -p mechanics-core --bench laws`

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

#[path = "timing/timing.rs"]
mod timing;

use mechanics_core::lanes::{LaneKernel, Packet, dispatch, load_matrices};
use mechanics_core::law::{
    FixedCorotated, Hyperelastic, Lame, NeoHookean, StableNeoHookean, first_inversion,
};
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::tensor::{Mat3, Matrix3};
use nalgebra::{SMatrix, SymmetricEigen};
use std::hint::black_box;
use timing::{Case, Random, measure};

type Mat12 = SMatrix<f64, 12, 12>;

/// Tetrahedra in a batch.
const COUNT: usize = 1024;
/// Interleaved repeats, of which the median counts.
const REPEATS: usize = 31;

const GRADIENTS: [[f64; 3]; 3] = [[1.0, 0.1, -0.2], [0.3, 1.1, 0.0], [-0.1, 0.2, 0.9]];
const VOLUME: f64 = 0.17;

/// I plus entries in [−size, size).
fn deformations(size: f64) -> Vec<Mat3> {
    let mut random = Random(1);
    (0..COUNT).map(|_| Mat3::identity() + Mat3::from_fn(|_, _| size * random.number())).collect()
}

fn assembled(blocks: &[Mat3; 10]) -> Mat12 {
    let mut matrix = Mat12::zeros();
    let mut next = 0;
    for a in 0..4 {
        for b in a..4 {
            matrix.fixed_view_mut::<3, 3>(3 * a, 3 * b).copy_from(&blocks[next]);
            matrix.fixed_view_mut::<3, 3>(3 * b, 3 * a).copy_from(&blocks[next].transpose());
            next += 1;
        }
    }
    matrix
}

/// Stiffness of all tetrahedra in lanes, clamped if `PROJECTED`, else unprojected with energy and stress; returns a checksum.
struct InLanes<'a, L, const PROJECTED: bool> {
    law: &'a L,
    deformations: &'a [Mat3],
}

impl<L: Hyperelastic, const PROJECTED: bool> LaneKernel<f64> for InLanes<'_, L, PROJECTED> {
    type Output = f64;

    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) -> f64 {
        let gradients = GRADIENTS.map(|g| g.map(P::splat));
        let mut sum = P::splat(0.0);
        for chunk in self.deformations.chunks_exact(P::LANES) {
            let f: Matrix3<P> = load_matrices(chunk);
            let projection = if PROJECTED { Projection::Clamp } else { Projection::None };
            let blocks = self.law.stiffness(&f, projection).tetrahedron(&gradients, P::splat(VOLUME));
            for block in black_box(&blocks) {
                sum += block[(0, 0)];
            }
            if !PROJECTED {
                sum += self.law.energy_density(&f) + black_box(&self.law.first_piola(&f))[(0, 1)];
            }
        }
        sum.to_lanes().iter().sum()
    }
}

fn projection_of_a_tetrahedron<L: Hyperelastic>(name: &str, law: &L) {
    let list = deformations(0.6);
    let list: Vec<Mat3> =
        list.into_iter().map(|f| if f.determinant() > 0.1 { f } else { Mat3::identity() }).collect();
    let blocks = |f: &Mat3, projection| law.stiffness(f, projection).tetrahedron(&GRADIENTS, VOLUME);
    let hessians: Vec<Mat12> = list.iter().map(|f| assembled(&blocks(f, Projection::None))).collect();
    let indefinite = hessians.iter().filter(|h| h.symmetric_eigenvalues().min() < -1e-9).count();
    let scalar = |projection| {
        let (list, blocks) = (&list, &blocks);
        move || {
            for f in list {
                black_box(blocks(black_box(f), projection));
            }
        }
    };
    let cases = vec![
        Case::new("nalgebra: 12x12 eigen-solve and product", COUNT, || {
            for hessian in &hessians {
                let eigen = SymmetricEigen::new(*black_box(hessian));
                let clamped = eigen.eigenvalues.map(|value| value.max(0.0));
                let product =
                    eigen.eigenvectors * SMatrix::from_diagonal(&clamped) * eigen.eigenvectors.transpose();
                black_box(product);
            }
        }),
        Case::new("project_symmetric, 12x12", COUNT, || {
            for hessian in &hessians {
                black_box(project_symmetric(black_box(hessian), Projection::Clamp));
            }
        }),
        Case::new("closed form from F, clamp (bar 12)", COUNT, scalar(Projection::Clamp)),
        Case::new("closed form from F, absolute", COUNT, scalar(Projection::Absolute)),
        Case::new("no projection", COUNT, scalar(Projection::None)),
    ];
    measure(
        &format!("{name}: stiffness of a tetrahedron, {indefinite} of {COUNT} indefinite"),
        REPEATS,
        cases,
    );
}

/// Separate from the rest because each law in lanes is compiled twice, for AVX2 and for any processor.
fn lanes<L: Hyperelastic>(name: &str, law: &L) {
    let list = deformations(0.2);
    let cases = vec![
        Case::new("one at a time, clamp", COUNT, || {
            for f in &list {
                black_box(law.stiffness(black_box(f), Projection::Clamp).tetrahedron(&GRADIENTS, VOLUME));
            }
        }),
        Case::new("four lanes, clamp", COUNT, || {
            black_box(dispatch(InLanes::<_, true> { law, deformations: &list }));
        }),
        Case::new("four lanes, energy, stress and true stiffness (bar 800 ns)", COUNT, || {
            black_box(dispatch(InLanes::<_, false> { law, deformations: &list }));
        }),
    ];
    measure(&format!("{name} in lanes"), REPEATS, cases);
}

fn steps() {
    let (list, changes) = (deformations(0.3), deformations(1.0));
    let pairs = || list.iter().zip(&changes);
    let cases = vec![
        Case::new("determinant, for scale", COUNT, || {
            for f in &list {
                black_box(black_box(f).determinant());
            }
        }),
        Case::new("first_inversion, dF of the size of F", COUNT, || {
            for (f, df) in pairs() {
                black_box(first_inversion(black_box(f), black_box(&(df - Mat3::identity() * 1.5))));
            }
        }),
        Case::new("first_inversion, small dF", COUNT, || {
            for (f, df) in pairs() {
                black_box(first_inversion(black_box(f), black_box(&(df * 1e-3))));
            }
        }),
    ];
    measure("largest step", REPEATS, cases);
}

fn main() {
    timing::print_calibration();
    let lame = Lame::new(1.7, 0.9).unwrap_or_else(|error| panic!("{error}"));
    projection_of_a_tetrahedron("neo-Hookean", &NeoHookean::new(lame));
    projection_of_a_tetrahedron("stable neo-Hookean", &StableNeoHookean::new(lame));
    projection_of_a_tetrahedron("fixed corotated", &FixedCorotated::new(lame));
    lanes("neo-Hookean", &NeoHookean::new(lame));
    steps();
}
