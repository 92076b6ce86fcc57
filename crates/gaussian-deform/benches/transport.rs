//! Time to carry a million Gaussians of degree 3, to read a scene of 100 MB, and to fill 128³ cells; on one thread.
//!
//! `cargo bench -p gaussian-deform --bench transport`; `BENCH_COUNT` another number of Gaussians, `BENCH_REPEATS` another number of repeats.

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

use gaussian_deform::file::ply::{self, PlyEncoding};
use gaussian_deform::fill::{CellGrid, Rules, Source, fill};
use gaussian_deform::transport::{Colours, Transport};
use gaussian_deform::{Degree, Splat, Splats};
use mechanics_core::decomposition::{Polar, polar_into};
use mechanics_core::parallel;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Matrix3, Vec3, vector};
use std::hint::black_box;
use std::time::Instant;

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn from_environment(name: &str, default: usize) -> usize {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

fn scene(degree: Degree, count: usize) -> Splats<f32> {
    let mut random = Random(1);
    let mut splats = Splats::with_capacity(degree, count);
    let mut harmonics = vec![0.0; degree.stride()];
    for _ in 0..count {
        harmonics.fill_with(|| random.next() as f32);
        splats.push(Splat {
            mean: vector([0.0; 3].map(|_: f32| random.next() as f32)),
            axes: Matrix3::from_fn(|_, _| 0.01 * random.next() as f32),
            opacity: 0.5,
            harmonics: &harmonics,
        });
    }
    splats
}

/// A measurement by name, milliseconds.
struct Case<'a> {
    name: String,
    run: Box<dyn FnMut() + 'a>,
    milliseconds: Vec<f64>,
}

impl<'a> Case<'a> {
    fn new(name: impl Into<String>, run: impl FnMut() + 'a) -> Self {
        Self { name: name.into(), run: Box::new(run), milliseconds: Vec::new() }
    }
}

/// All cases in turn, so that a slow moment of the machine falls on all of them; medians.
fn measure(cases: &mut [Case<'_>], repeats: usize) {
    for _ in 0..repeats {
        for case in &mut *cases {
            let start = Instant::now();
            (case.run)();
            case.milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    for case in cases {
        case.milliseconds.sort_by(f64::total_cmp);
        let median = case.milliseconds[repeats / 2];
        println!("  {:58} {median:9.1} ms (best {:.1})", case.name, case.milliseconds[0]);
    }
}

/// 200 million dependent multiplications and additions: what this core is worth at this moment.
fn calibration() {
    let mut x = black_box(1.000_000_1_f64);
    for _ in 0..200_000_000 {
        x = x * 0.999_999_9 + 1e-7;
    }
    black_box(x);
}

fn main() {
    parallel::with_threads(1, run);
}

fn run() {
    let count = from_environment("BENCH_COUNT", 1_000_000);
    let repeats = from_environment("BENCH_REPEATS", 5);
    let mut random = Random(2);
    let positions: Vec<Vec3> = (0..count).map(|_| Vec3::from_fn(|_, _| random.next())).collect();
    let gradients: Vec<Mat3> =
        (0..count).map(|_| Mat3::identity() + Mat3::from_fn(|_, _| 0.4 * random.next())).collect();
    let narrow: Vec<Matrix3<f32>> = gradients.iter().map(|f| f.cast::<f32>()).collect();
    let mut polars = vec![Polar::identity(); count];
    let samples = DeformationSamples::new(&positions, &gradients);
    let all: Vec<u32> = (0..count as u32).collect();
    let moving = |degree, colours| {
        Transport::new(scene(degree, count), all.clone(), colours).expect("the scene is sound")
    };
    let mut transports = [
        (
            "degree 3, coefficients rotated (bar: 150 for a million)",
            moving(Degree::Three, Colours::RotateCoefficients),
        ),
        ("degree 3, directions turned", moving(Degree::Three, Colours::TurnDirections)),
        ("degree 0", moving(Degree::Zero, Colours::RotateCoefficients)),
    ];
    println!("{count} Gaussians, one thread");
    let mut cases = vec![Case::new("calibration (200 million dependent multiply-adds)", calibration)];
    for (name, transport) in &mut transports {
        cases.push(Case::new(*name, move || {
            black_box(transport.deform(samples).expect("the motion is sound"));
        }));
    }
    cases.push(Case::new("polar_into of mechanics-core alone, f32", || {
        polar_into(&narrow, &mut polars);
        black_box(&polars);
    }));
    measure(&mut cases, repeats);
    drop(cases);
    drop(transports);
    load(count * 2 / 5, repeats);
    filling(repeats);
}

fn load(count: usize, repeats: usize) {
    let mut bytes = Vec::new();
    ply::write(&scene(Degree::Three, count), PlyEncoding::BinaryLittleEndian, &mut bytes).expect("memory");
    let megabytes = bytes.len() as f64 / 1e6;
    println!("a PLY of {megabytes:.0} MB, {count} Gaussians (bar: 300 MB/s, {:.0} ms)", megabytes / 0.3);
    let mut cases = [Case::new("read", || {
        black_box(ply::read(&bytes).expect("it was written"));
    })];
    measure(&mut cases, repeats);
}

fn filling(repeats: usize) {
    let mut random = Random(3);
    let cell = 1.0 / 128.0;
    let sources: Vec<Source> = (0..113_000)
        .map(|_| {
            let normal = Vec3::from_fn(|_, _| random.next()).normalize();
            let axes = Mat3::from_fn(|_, _| random.next()) * cell;
            Source { mean: Vec3::repeat(0.5) + normal * 0.4, axes, opacity: 0.8 }
        })
        .collect();
    let grid = CellGrid { origin: Vec3::zeros(), cell, counts: [128; 3] };
    println!("filling 128³ cells from {} Gaussians (bar: 2000 ms)", sources.len());
    let mut cases = [Case::new("fill", || {
        black_box(fill(&sources, &grid, &Rules::default()).expect("the scene is sound"));
    })];
    measure(&mut cases, repeats);
}
