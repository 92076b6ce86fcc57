//! Elements, assembly and whole steps of elastic bodies.
//!
//! `cargo bench -p lagrangian --bench bodies [-- elements | assembly | newton | mat | threads]`
//!
//! The mat is that of issue 5: 40×40×2 vertices, 1 × 0.008 × 1 m, stable neo-Hookean, its ends turned in opposite
//! directions at 72°/s, no contact. STARK (C++) needs 226–276 ms a step on the same machine.

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../../mechanics-core/benches/timing/timing.rs"]
mod timing;

use lagrangian::element::{Mass, MassDistribution, Tetrahedra};
use lagrangian::stepper::{StepReport, Stepper, StepperOptions};
use mechanics_core::law::{Hyperelastic, Lame, NeoHookean, StableNeoHookean};
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::parallel::{for_each_chunk, with_threads};
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::state::State;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::{SMatrix, SymmetricEigen};
use std::hint::black_box;
use timing::{Random, interleaved, median, time};

type Mat12 = SMatrix<f64, 12, 12>;

/// Elements handed to a stencil at once, as a term does.
const RUN: usize = 32;
const REPEATS: usize = 15;

/// A block whose points are moved at random by a part of its cells, no cell inverted.
fn jittered(cells: u32, part: f64) -> (TetMesh, Vec<Vec3>) {
    let size = Vec3::repeat(f64::from(cells));
    let mesh = block(&Vec3::zeros(), &size, [cells; 3], BoxSplit::Six).unwrap();
    let mut random = Random(1);
    let mut move_point = |x: &Vec3| x + Vec3::new(random.number(), random.number(), random.number()) * part;
    let x = mesh.points().iter().map(&mut move_point).collect();
    (mesh, x)
}

fn dense(hessian: &LocalHessian<4>) -> Mat12 {
    let mut matrix = Mat12::zeros();
    for a in 0..4 {
        for b in 0..=a {
            matrix.fixed_view_mut::<3, 3>(3 * a, 3 * b).copy_from(&hessian[a][b]);
            matrix.fixed_view_mut::<3, 3>(3 * b, 3 * a).copy_from(&hessian[a][b].transpose());
        }
    }
    matrix
}

fn elements_of<L: Hyperelastic + Copy>(name: &str, law: L) {
    let (mesh, moved) = jittered(6, 0.15);
    let elements = Tetrahedra::new(law, mesh.points(), mesh.cells()).unwrap();
    let x: Vec<[Vec3; 4]> = mesh.cells().iter().map(|cell| cell.map(|i| moved[i as usize])).collect();
    let n = x.len();
    let mut values = vec![0.0; RUN];
    let mut gradients = vec![[Vec3::zeros(); 4]; RUN];
    let mut hessians = [(); 3].map(|()| vec![[[Mat3::zeros(); 4]; 4]; RUN]);
    let [h0, h1, h2] = &mut hessians;
    let runs = |work: &mut dyn FnMut(usize, &[[Vec3; 4]])| {
        x.chunks(RUN).enumerate().for_each(|(k, x)| work(k * RUN, x));
    };
    let (mut v1, mut g1) = (values.clone(), gradients.clone());
    let times = interleaved(
        REPEATS,
        [
            &mut || {
                for (e, x) in x.iter().enumerate() {
                    let hessian = dense(&elements.hessian(e, black_box(x), Projection::None));
                    let eigen = SymmetricEigen::new(hessian);
                    let clamped = eigen.eigenvalues.map(|value| value.max(0.0));
                    let vectors = eigen.eigenvectors;
                    black_box(vectors * SMatrix::from_diagonal(&clamped) * vectors.transpose());
                }
            },
            &mut || runs(&mut |first, x| elements.hessians_into(first, x, Projection::Clamp, h0)),
            &mut || runs(&mut |first, x| elements.hessians_into(first, x, Projection::None, h1)),
            &mut || runs(&mut |first, x| elements.gradients_into(first, x, &mut gradients)),
            &mut || runs(&mut |first, x| elements.values_into(first, x, &mut values)),
            &mut || {
                runs(&mut |first, x| {
                    elements.values_into(first, x, &mut v1);
                    elements.gradients_into(first, x, &mut g1);
                    elements.hessians_into(first, x, Projection::None, h2);
                });
            },
        ],
    );
    let [numeric, clamped, unprojected, gradient, value, all] = times.map(|t| t * 1e9 / n as f64);
    println!("\n{name}: {n} tetrahedra, one thread, ns each");
    println!("  Hessian with nalgebra's 12×12 eigen-projection {numeric:8.0}");
    println!(
        "  Hessian, projected                             {clamped:8.0}   {:.1}× faster (bar 12×)",
        numeric / clamped
    );
    println!(
        "  Hessian, not projected                         {unprojected:8.0}   {:.1}×",
        numeric / unprojected
    );
    println!(
        "  gradient                                       {gradient:8.0}   {:.3} of the projected Hessian (bar 0.12)",
        gradient / clamped
    );
    println!("  energy                                         {value:8.0}   {:.3}", value / clamped);
    println!("  energy + gradient + unprojected Hessian        {all:8.0}   (bar 800)");
}

fn refill(assembly: &mut Assembly, map: &PointMap, term: &dyn Potential, x: &[Vec3]) {
    let mut assembler = assembly.begin(map);
    term.add_hessian(x, Projection::Clamp, &mut assembler);
    black_box(assembler.finish());
}

/// All element Hessians into one buffer that stays in cache: the computation alone.
fn compute(term: &StencilTerm<Tetrahedra<StableNeoHookean>, 4>, x: &[Vec3], buffer: &mut [LocalHessian<4>]) {
    for (number, part) in term.elements().chunks(buffer.len()).enumerate() {
        let first = number * buffer.len();
        for_each_chunk(&mut buffer[..part.len()], RUN, |at, out| {
            let mut points = [[Vec3::zeros(); 4]; RUN];
            let elements = &part[at..at + out.len()];
            for (points, element) in points.iter_mut().zip(elements) {
                *points = element.map(|i| x[i as usize]);
            }
            term.stencil().hessians_into(first + at, &points[..out.len()], Projection::Clamp, out);
        });
        black_box(&mut *buffer);
    }
}

fn law() -> StableNeoHookean {
    StableNeoHookean::new(Lame::from_young_poisson(2e4, 0.4).unwrap())
}

fn assembly() {
    let (mesh, x) = jittered(26, 0.15);
    let term = Tetrahedra::term("elastic", law(), &mesh).unwrap();
    let map = PointMap::identity(x.len());
    let n = mesh.cells().len() as f64;
    let mut assembly = Assembly::new(&map);
    refill(&mut assembly, &map, &term, &x);
    let mut buffer = vec![[[Mat3::zeros(); 4]; 4]; 448];
    let [fused, alone] = with_threads(1, || {
        interleaved(
            REPEATS,
            [&mut || refill(&mut assembly, &map, &term, &x), &mut || compute(&term, &x, &mut buffer)],
        )
    });
    println!(
        "\nassembly of {n} tetrahedra, projected: fused {:.0} ns each, elements alone {:.0}: {:.2}× (bar 1.3×)",
        fused * 1e9 / n,
        alone * 1e9 / n,
        fused / alone
    );
}

fn threads() {
    let (mesh, x) = jittered(26, 0.15);
    let term = Tetrahedra::term("elastic", law(), &mesh).unwrap();
    let map = PointMap::identity(x.len());
    let mut assembly = Assembly::new(&map);
    refill(&mut assembly, &map, &term, &x);
    let mut gradient = vec![Vec3::zeros(); x.len()];
    let mut buffer = vec![[[Mat3::zeros(); 4]; 4]; 4096];
    let mut ratios = [const { Vec::new() }; 3];
    for _ in 0..REPEATS {
        let [one, two] = [1, 2].map(|threads| {
            with_threads(threads, || {
                let hessian = time(|| refill(&mut assembly, &map, &term, &x)).as_secs_f64();
                let gradient = time(|| (0..5).for_each(|_| term.add_gradient(&x, &mut gradient)));
                let alone = time(|| compute(&term, &x, &mut buffer));
                [hessian, gradient.as_secs_f64(), alone.as_secs_f64()]
            })
        });
        (0..3).for_each(|k| ratios[k].push(one[k] / two[k]));
    }
    let [hessian, gradient, alone] = ratios.map(median);
    println!(
        "\ntwo threads: assembled Hessian {hessian:.2}×, gradient {gradient:.2}× as fast as one (bar 1.7×); element Hessians \
         alone {alone:.2}×"
    );
}

/// The mat of issue 5, or one with another number of cells along its sides.
struct Mat {
    mesh: TetMesh,
    term: StencilTerm<Tetrahedra<StableNeoHookean>, 4>,
    ends: Vec<(u32, f64)>,
    stepper: Stepper,
    state: State,
}

const STEP: f64 = 0.04;
const RATE: f64 = 72.0 / 180.0 * std::f64::consts::PI;

impl Mat {
    fn new(cells: [u32; 3]) -> Self {
        let size = Vec3::new(1.0, 0.008, 1.0);
        let mesh = block(&Vec3::zeros(), &size, cells, BoxSplit::Six).unwrap();
        let term = Tetrahedra::term("elastic", law(), &mesh).unwrap();
        let mut mass = Mass::zeros(mesh.points().len());
        mass.add_tetrahedra(mesh.points(), mesh.cells(), 1000.0, MassDistribution::Lumped).unwrap();
        let points = mesh.points().iter().zip(0u32..);
        let ends: Vec<(u32, f64)> = points
            .filter(|(x, _)| x.x == 0.0 || x.x == 1.0)
            .map(|(x, i)| (i, if x.x == 0.0 { RATE } else { -RATE }))
            .collect();
        let fixed: Vec<(u32, Vec3)> = ends.iter().map(|&(i, _)| (i, mesh.points()[i as usize])).collect();
        let map = PointMap::with_fixed(mesh.points().len(), &fixed).unwrap();
        let newton = NewtonOptions { tolerance: 1e-3, ..Default::default() };
        let stepper = Stepper::new(mass, map, StepperOptions { newton, ..Default::default() });
        let state = State::at_rest(mesh.points().to_vec());
        Self { mesh, term, ends, stepper, state }
    }

    fn step(&mut self) -> StepReport {
        let time = self.state.time + STEP;
        for &(point, rate) in &self.ends {
            let (x, centre) = (self.mesh.points()[point as usize], Vec3::new(0.0, 0.004, 0.5));
            let (sin, cos) = (rate * time).sin_cos();
            let r = x - centre;
            let turned = Vec3::new(r.x, cos * r.y - sin * r.z, sin * r.y + cos * r.z);
            self.stepper.set_target(point, centre + turned).unwrap();
        }
        self.stepper.step(&mut self.state, &mut [&mut self.term], STEP).unwrap()
    }
}

fn mat() {
    let mut medians = Vec::new();
    for threads in [1, 2] {
        let (times, iterations, halvings, shares) = with_threads(threads, || {
            let mut mat = Mat::new([39, 1, 39]);
            let (mut times, mut iterations, mut halvings) = (Vec::new(), 0, 0);
            let mut shares = [0.0; 4];
            for _ in 0..20 {
                let report = mat.step();
                times.push(report.time.as_secs_f64() * 1e3);
                iterations += report.newton.iterations;
                halvings += report.newton.halvings;
                let t = report.newton.times;
                let parts = [t.assembly, t.solve, t.gradient, t.value];
                (0..4).for_each(|k| shares[k] += parts[k].as_secs_f64() * 1e3 / 20.0);
            }
            (times, iterations, halvings, shares)
        });
        let mean = times.iter().sum::<f64>() / times.len() as f64;
        println!(
            "\nmat, {threads} thread(s): {mean:.0} ms a step (bar 150 with two), slowest {:.0}; {:.1} iterations, {halvings} halvings in \
             all; assembly {:.1}, solve {:.1}, gradient {:.1}, energy {:.1} ms",
            times.iter().copied().fold(0.0, f64::max),
            iterations as f64 / 20.0,
            shares[0],
            shares[1],
            shares[2],
            shares[3]
        );
        medians.push(mean);
    }
    println!("two threads {:.2}× as fast", medians[0] / medians[1]);
}

/// One step each of mats of growing size: where a Newton iteration spends its time.
fn newton() {
    println!();
    for cells in [[22, 1, 22], [70, 1, 70], [122, 1, 122]] {
        let (report, unknowns) = with_threads(1, || {
            let mut mat = Mat::new(cells);
            mat.step();
            let unknowns = 3 * mat.stepper.map().unknowns();
            (mat.step(), unknowns)
        });
        let per = 1e3 / report.newton.directions as f64;
        let t = report.newton.times;
        let rest = t.gradient + t.value + t.limit_step + t.freeze;
        let whole = (t.assembly + t.solve + rest).as_secs_f64();
        println!(
            "{unknowns} unknowns: an iteration {:.1} ms: assembly {:.1}, solve {:.1} ({:.0} %), the rest {:.1}",
            whole * per,
            t.assembly.as_secs_f64() * per,
            t.solve.as_secs_f64() * per,
            100.0 * t.solve.as_secs_f64() / whole,
            rest.as_secs_f64() * per
        );
    }
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with('-')).collect();
    let runs = |name: &str| wanted.is_empty() || wanted.iter().any(|w| w == name);
    timing::print_calibration();
    if runs("elements") {
        with_threads(1, || {
            let lame = Lame::from_young_poisson(1e5, 0.3).unwrap();
            elements_of("stable neo-Hookean", StableNeoHookean::new(lame));
            elements_of("neo-Hookean", NeoHookean::new(lame));
        });
    }
    if runs("assembly") {
        assembly();
    }
    if runs("threads") {
        threads();
    }
    if runs("newton") {
        newton();
    }
    if runs("mat") {
        mat();
    }
    timing::print_calibration();
}
