//! Assembly of the Hessian and gradient of 105,456 tetrahedra: nanoseconds a tetrahedron, and ratios.
//!
//! `cargo bench -p mechanics-core --bench assembly`

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

#[path = "timing/timing.rs"]
mod timing;

use faer::sparse::{SparseColMat, Triplet};
use mechanics_core::parallel::{for_each_chunk, map_chunks, with_threads};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};
use std::hint::black_box;
use timing::{calibration, interleaved, median, time};

const CELLS: usize = 26;
const REPEATS: usize = 9;

/// Elements whose work can be dialled: a full local Hessian, computed `rounds` times over. One round is the cheapest law
/// there is; a projected hyperelastic Hessian (0.8 µs) lies between four and sixteen.
struct Elements {
    rounds: usize,
}

impl Elements {
    fn edges(x: &[Vec3; 4]) -> [Vec3; 3] {
        [x[1] - x[0], x[2] - x[0], x[3] - x[0]]
    }
    fn volume_gradient(x: &[Vec3; 4]) -> [Vec3; 4] {
        let [a, b, c] = Self::edges(x);
        let (ga, gb, gc) = (b.cross(&c), c.cross(&a), a.cross(&b));
        [-(ga + gb + gc), ga, gb, gc]
    }
}

impl Stencil<4> for Elements {
    fn value(&self, _: usize, x: &[Vec3; 4]) -> f64 {
        let [a, b, c] = Self::edges(x);
        a.dot(&b.cross(&c)).powi(2)
    }
    fn gradient(&self, _: usize, x: &[Vec3; 4]) -> [Vec3; 4] {
        let mut x = *x;
        let mut total = [Vec3::zeros(); 4];
        for _ in 0..self.rounds {
            let [a, b, c] = Self::edges(&x);
            let scale = (2.0 * a.dot(&b.cross(&c)).abs().sqrt()).ln_1p();
            let g = Self::volume_gradient(&x);
            (0..4).for_each(|i| total[i] += g[i] * scale);
            x[0] += g[0] * 1e-9;
        }
        total
    }
    fn hessian(&self, _: usize, x: &[Vec3; 4], projection: Projection) -> LocalHessian<4> {
        let mut x = *x;
        let mut total = [[Mat3::zeros(); 4]; 4];
        for _ in 0..self.rounds {
            let [a, b, c] = Self::edges(&x);
            let excess = projection.apply(a.dot(&b.cross(&c)));
            let g = Self::volume_gradient(&x);
            for i in 0..4 {
                for j in 0..=i {
                    total[i][j] += g[i] * g[j].transpose() + Mat3::from_diagonal_element(excess);
                }
            }
            x[0] += g[0] * 1e-9;
        }
        total
    }
}

fn points() -> Vec<Vec3> {
    let at = |k: usize| k as f64 / CELLS as f64;
    let n = CELLS + 1;
    (0..n * n * n).map(|p| Vec3::new(at(p / (n * n)), at(p / n % n), at(p % n))).collect()
}

fn tetrahedra() -> Vec<[u32; 4]> {
    let at = |c: [usize; 3]| ((c[0] * (CELLS + 1) + c[1]) * (CELLS + 1) + c[2]) as u32;
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let corners = (0..CELLS * CELLS * CELLS).map(|c| [c / (CELLS * CELLS), c / CELLS % CELLS, c % CELLS]);
    let path = |mut c: [usize; 3], order: [usize; 3]| {
        let mut tetrahedron = [at(c); 4];
        for (i, axis) in order.into_iter().enumerate() {
            c[axis] += 1;
            tetrahedron[i + 1] = at(c);
        }
        tetrahedron
    };
    corners.flat_map(|c| orders.map(|order| path(c, order))).collect()
}

/// Pairs of points far apart in the mesh, as contacts are.
fn contacts(round: usize) -> Vec<[u32; 4]> {
    let points = (CELLS + 1).pow(3);
    let at = |k: usize| (k * 7919 % points) as u32;
    (0..1000)
        .map(|k| at(k + 37 * round))
        .map(|p| [p, (p + 5003) % points as u32, (p + 5004) % points as u32, (p + 5033) % points as u32])
        .collect()
}

/// Median of the ratios of interleaved pairs.
fn ratio(mut slow: impl FnMut(), mut fast: impl FnMut()) -> f64 {
    median((0..REPEATS).map(|_| time(&mut slow).as_secs_f64() / time(&mut fast).as_secs_f64()).collect())
}

fn refill(assembly: &mut Assembly, map: &PointMap, term: &dyn Potential, x: &[Vec3]) {
    let mut assembler = assembly.begin(map);
    term.add_hessian(x, Projection::None, &mut assembler);
    black_box(assembler.finish());
}

/// All element Hessians into one batch-sized buffer, again and again: the computation alone.
fn compute(term: &StencilTerm<Elements, 4>, x: &[Vec3], buffer: &mut [LocalHessian<4>]) {
    for (number, part) in term.elements().chunks(buffer.len()).enumerate() {
        let first = number * buffer.len();
        for_each_chunk(&mut buffer[..part.len()], 32, |at, out| {
            for (k, out) in out.iter_mut().enumerate() {
                let e = first + at + k;
                let points = term.elements()[e].map(|i| x[i as usize]);
                *out = term.stencil().hessian(e, &points, Projection::None);
            }
        });
        black_box(&mut *buffer);
    }
}

/// What most codes begin with: scalar triplets, sorted and summed by the library.
fn naive(term: &StencilTerm<Elements, 4>, x: &[Vec3]) {
    let mut triplets = Vec::new();
    for (e, points) in term.elements().iter().enumerate() {
        let h = term.stencil().hessian(e, &points.map(|i| x[i as usize]), Projection::None);
        for (i, j) in (0..4).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                let (row, column) = (3 * points[i] as usize + r, 3 * points[j] as usize + c);
                triplets.push(Triplet::new(row.max(column), row.min(column), h[i][j][(r, c)]));
            }
        }
    }
    let n = 3 * x.len();
    black_box(SparseColMat::try_new_from_triplets(n, n, &triplets).unwrap());
}

fn term(rounds: usize) -> StencilTerm<Elements, 4> {
    StencilTerm::new("elements", Elements { rounds }, tetrahedra()).unwrap()
}

fn fused(x: &[Vec3], map: &PointMap, rounds: usize, per_tet: f64) {
    let term = term(rounds);
    let mut assembly = Assembly::new(map);
    let first = with_threads(1, || time(|| refill(&mut assembly, map, &term, x))).as_secs_f64();
    let mut buffer = vec![[[Mat3::zeros(); 4]; 4]; 448];
    let [fused, alone] = with_threads(1, || {
        let mut fused = || refill(&mut assembly, map, &term, x);
        let mut alone = || compute(&term, x, &mut buffer);
        interleaved(REPEATS, [&mut fused, &mut alone])
    });
    println!(
        "rounds {rounds}: first assembly {:.0} ns/tet, refill {:.0}, elements alone {:.0}, fused ratio {:.2}",
        first * per_tet,
        fused * per_tet,
        alone * per_tet,
        fused / alone
    );
}

fn threads(x: &[Vec3], map: &PointMap, rounds: usize) {
    let term = term(rounds);
    let mut one = Assembly::new(map);
    let mut two = Assembly::new(map);
    refill(&mut one, map, &term, x);
    refill(&mut two, map, &term, x);
    let pool = |threads: usize, work: &mut (dyn FnMut() + Send)| with_threads(threads, work);
    let hessian = ratio(
        || pool(1, &mut || refill(&mut one, map, &term, x)),
        || pool(2, &mut || refill(&mut two, map, &term, x)),
    );
    let mut gradient = vec![Vec3::zeros(); x.len()];
    let mut other = gradient.clone();
    let gradients = ratio(
        || pool(1, &mut || (0..5).for_each(|_| term.add_gradient(x, &mut gradient))),
        || pool(2, &mut || (0..5).for_each(|_| term.add_gradient(x, &mut other))),
    );
    let alone = || {
        black_box(map_chunks(term.elements().len(), 2048, |range| {
            let trace = |e: usize| {
                let points = term.elements()[e].map(|i| x[i as usize]);
                black_box(term.stencil().hessian(e, &points, Projection::None))[3][0].trace()
            };
            range.map(trace).sum::<f64>()
        }));
    };
    let ceiling = ratio(|| with_threads(1, alone), || with_threads(2, alone));
    println!(
        "rounds {rounds}: two threads are {hessian:.2} times as fast on the Hessian, {gradients:.2} on the gradient, \
         {ceiling:.2} on the elements alone"
    );
}

fn pattern_changes(x: &[Vec3], map: &PointMap) {
    let term = term(4);
    let mut assembly = Assembly::new(map);
    let hessian = [[Mat3::identity(); 4]; 4];
    let assemble = |assembly: &mut Assembly, round: usize| {
        let contacts = contacts(round);
        let mut assembler = assembly.begin(map);
        term.add_hessian(x, Projection::None, &mut assembler);
        assembler.begin_term(1);
        assembler.add(&contacts, |_| hessian);
        black_box(assembler.finish());
    };
    assemble(&mut assembly, 0);
    let mut round = 0;
    let mut copy = Assembly::new(map);
    assemble(&mut copy, 0);
    let [same, changed, over] = with_threads(1, || {
        interleaved(
            REPEATS,
            [
                &mut || assemble(&mut copy, 0),
                &mut || {
                    round += 1;
                    assemble(&mut assembly, round);
                },
                &mut || assemble(&mut Assembly::new(map), 0),
            ],
        )
    });
    println!(
        "1000 contacts, all new each time: {:.1} ms against {:.1} ms unchanged ({:.0} % more); starting over {:.1} ms",
        changed * 1e3,
        same * 1e3,
        (changed / same - 1.0) * 100.0,
        over * 1e3
    );
}

fn main() {
    let (x, tetrahedra) = (points(), tetrahedra());
    let map = PointMap::identity(x.len());
    let per_tet = 1e9 / tetrahedra.len() as f64;
    println!("{} tetrahedra, {} points; calibration {:.3} ns", tetrahedra.len(), x.len(), calibration());
    let cheap = term(1);
    let mut assembly = Assembly::new(&map);
    refill(&mut assembly, &map, &cheap, &x);
    let [naive, ours] = with_threads(1, || {
        interleaved(3, [&mut || naive(&cheap, &x), &mut || refill(&mut assembly, &map, &cheap, &x)])
    });
    println!(
        "naive triplets {:.0} ns/tet, ours {:.0}: {:.0} times",
        naive * per_tet,
        ours * per_tet,
        naive / ours
    );
    for rounds in [1, 4, 16] {
        fused(&x, &map, rounds, per_tet);
    }
    for rounds in [1, 4, 16] {
        threads(&x, &map, rounds);
    }
    pattern_changes(&x, &map);
    println!("calibration {:.3} ns", calibration());
}
