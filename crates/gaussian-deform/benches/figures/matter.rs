//! What happens to a scene before it is drawn, on one thread.

use super::scenes::{Random, cloud};
use super::{Bar, Time, interleaved, median_core, median_wall, print_calibration, print_figure, timed};
use gaussian_deform::Degree;
use gaussian_deform::file::ply::{self, PlyEncoding};
use gaussian_deform::fill::{CellGrid, Rules, Source, fill};
use gaussian_deform::transport::{Colours, Transport};
use mechanics_core::decomposition::{Polar, polar_into};
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{Mat3, Matrix3, Vec3};
use std::hint::black_box;

const REPEATS: usize = 5;

pub(crate) fn figures() {
    transport(1_000_000);
    load(400_000);
    filling();
}

fn print_times(name: &str, times: &[Time], bar: Bar) {
    let name = format!("{name} ({:.0} ms passed)", median_wall(times) * 1e3);
    print_figure(&name, median_core(times) * 1e3, "ms", bar);
}

fn transport(count: usize) {
    print_calibration();
    println!("transport of {count} Gaussians in f32, one thread, core");
    let mut random = Random(2);
    let positions: Vec<Vec3> = (0..count).map(|_| Vec3::from_fn(|_, _| random.next())).collect();
    let gradients: Vec<Mat3> =
        (0..count).map(|_| Mat3::identity() + Mat3::from_fn(|_, _| 0.4 * random.next())).collect();
    let narrow: Vec<Matrix3<f32>> = gradients.iter().map(|f| f.cast::<f32>()).collect();
    let mut polars = vec![Polar::identity(); count];
    let all: Vec<u32> = (0..count as u32).collect();
    let kinds = [
        ("degree 3, coefficients rotated", Degree::Three, Colours::RotateCoefficients, Bar::AtMost(150.0)),
        ("degree 3, directions turned", Degree::Three, Colours::TurnDirections, Bar::Absent),
        ("degree 0", Degree::Zero, Colours::RotateCoefficients, Bar::Absent),
    ];
    let samples = DeformationSamples::new(&positions, &gradients);
    let mut cases: Vec<Box<dyn FnMut() -> Time + '_>> = Vec::new();
    for (_, degree, colours, _) in kinds {
        let mut transport = Transport::new(cloud(degree, count), all.clone(), colours).unwrap();
        cases.push(Box::new(move || {
            timed(|| {
                black_box(transport.deform(samples).unwrap());
            })
        }));
    }
    cases.push(Box::new(|| {
        timed(|| {
            polar_into(&narrow, &mut polars);
            black_box(&polars);
        })
    }));
    let times = interleaved(REPEATS, &mut cases);
    for ((name, _, _, bar), times) in kinds.iter().zip(&times) {
        print_times(name, times, *bar);
    }
    print_times("polar_into of mechanics-core alone", &times[3], Bar::Absent);
}

fn load(count: usize) {
    print_calibration();
    let mut bytes = Vec::new();
    ply::write(&cloud(Degree::Three, count), PlyEncoding::BinaryLittleEndian, &mut bytes).unwrap();
    let megabytes = bytes.len() as f64 / 1e6;
    println!("a PLY of {megabytes:.0} MB, {count} Gaussians of degree 3, one thread, core");
    let mut cases: [Box<dyn FnMut() -> Time + '_>; 1] = [Box::new(|| {
        timed(|| {
            black_box(ply::read(&bytes).unwrap());
        })
    })];
    let times = interleaved(REPEATS, &mut cases);
    print_figure("read", megabytes / median_core(&times[0]), "MB/s", Bar::AtLeast(300.0));
    print_times("read", &times[0], Bar::Absent);
}

fn filling() {
    print_calibration();
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
    println!("filling 128³ cells from {} Gaussians, one thread, core", sources.len());
    let mut cases: [Box<dyn FnMut() -> Time + '_>; 1] = [Box::new(|| {
        timed(|| {
            black_box(fill(&sources, &grid, &Rules::default()).unwrap());
        })
    })];
    let times = interleaved(REPEATS, &mut cases);
    print_times("fill", &times[0], Bar::AtMost(2000.0));
}
