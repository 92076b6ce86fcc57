//! Time for a picture: a real capture and a synthetic scene, exact and tight mode, one and two threads.
//!
//! `SPLAT_SCENES_DIR=… cargo bench -p gaussian-deform --bench raster`; the folder holds `plant.ply` (113,648 Gaussians, degree 0). Without it only the
//! synthetic scene is drawn.

#![allow(clippy::print_stdout, reason = "a benchmark prints")]
#![allow(clippy::unwrap_used, reason = "a benchmark may stop at once")]

use gaussian_deform::camera::{Camera, Orbit};
use gaussian_deform::raster::{self, Mode, Picture, Settings};
use gaussian_deform::{Degree, Splat, Splats, file};
use mechanics_core::parallel;
use mechanics_core::tensor::{Mat3, Vec3};
use std::hint::black_box;
use std::time::Instant;

/// Interleaved repeats, of which the median counts.
const REPEATS: usize = 9;

/// A chain of dependent multiplications: how fast this machine is today.
fn calibration() -> f64 {
    let start = Instant::now();
    let mut x = black_box(1.0_f64);
    for _ in 0..20_000_000 {
        x = x * 0.999_999_9 + 1e-7;
    }
    black_box(x);
    start.elapsed().as_secs_f64() * 1e9 / 2e7
}

/// Milliseconds for one picture with so many threads.
fn milliseconds(
    threads: usize,
    scene: &Splats,
    camera: &Camera,
    mode: Mode,
    picture: &mut Picture<f32>,
) -> f64 {
    let settings = Settings { mode, ..Settings::default() };
    parallel::with_threads(threads, || {
        let start = Instant::now();
        raster::render_into(scene, camera, &settings, picture).unwrap();
        start.elapsed().as_secs_f64() * 1e3
    })
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn measure(title: &str, scene: &Splats, camera: &Camera) {
    let mut picture = Picture::empty();
    let cases = [(Mode::Exact, 1), (Mode::Exact, 2), (Mode::Tight, 1), (Mode::Tight, 2)];
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); cases.len()];
    let mut gains: Vec<Vec<f64>> = vec![Vec::new(); 2];
    let mut reports = Vec::new();
    for repeat in 0..REPEATS {
        for (&(mode, threads), times) in cases.iter().zip(&mut times) {
            times.push(milliseconds(threads, scene, camera, mode, &mut picture));
            if repeat == 0 && threads == 1 {
                reports.push(picture.report());
            }
        }
        for (gain, pair) in gains.iter_mut().zip(times.chunks(2)) {
            gain.push(pair[0][repeat] / pair[1][repeat]);
        }
    }
    println!("\n{title}, {} x {}", camera.width(), camera.height());
    for (k, name) in ["exact", "tight"].into_iter().enumerate() {
        let (one, two) = (median(&mut times[2 * k]), median(&mut times[2 * k + 1]));
        println!(
            "  {name}: {one:6.1} ms on one thread, {two:6.1} ms on two: {:.2} times",
            median(&mut gains[k])
        );
        println!("    {:?}", reports[k]);
    }
    differences(scene, camera);
}

/// What speed costs: the differences between modes and between precisions \[dB\].
fn differences(scene: &Splats, camera: &Camera) {
    let settings = |mode| Settings { mode, ..Settings::default() };
    let single =
        [Mode::Exact, Mode::Tight].map(|mode| raster::render(scene, camera, &settings(mode)).unwrap());
    let start = Instant::now();
    let double = raster::render(&scene.cast::<f64>(), camera, &settings(Mode::Exact)).unwrap();
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    println!("  exact against tight: {:.1} dB", single[0].signal_to_noise(&single[1]));
    println!(
        "  f32 against f64: {:.1} dB (f64 takes {milliseconds:.0} ms on {} threads, conversion included)",
        single[0].signal_to_noise(&double),
        parallel::thread_count()
    );
}

/// Discs on a wavy sphere of radius one: colours of degree 2, every other one half transparent.
fn wavy_sphere(count: usize) -> Splats {
    let mut state = 1u64;
    let mut number = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut splats = Splats::with_capacity(Degree::Two, count);
    let spacing = (4.0 * std::f64::consts::PI / count as f64).sqrt();
    for i in 0..count {
        // A spiral that covers the sphere evenly.
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (sin, cos) = (i as f64 * 2.399_963_229_728_653).sin_cos();
        let across = (1.0 - z * z).sqrt();
        let normal = Vec3::new(across * cos, across * sin, z);
        let radius = 1.0 + 0.1 * (9.0 * normal.x).sin() * (7.0 * normal.y).cos();
        let side = normal.cross(&Vec3::new(0.3, 0.5, 0.81)).normalize();
        let rotation = Mat3::from_columns(&[side, normal.cross(&side), normal]);
        let scales = [1.0, 1.0, 0.2].map(|s| s * spacing * (1.0 + 0.5 * number()));
        let axes = rotation * Mat3::from_diagonal(&Vec3::from(scales));
        let harmonics: [f32; 27] =
            std::array::from_fn(|k| (number() * if k % 9 == 0 { 1.5 } else { 0.2 }) as f32);
        splats.push(Splat {
            mean: (normal * radius).cast(),
            axes: axes.cast(),
            opacity: if i % 2 == 0 { 0.95 } else { 0.5 },
            harmonics: &harmonics,
        });
    }
    splats
}

fn main() {
    println!("calibration: {:.3} ns for a dependent multiplication and addition", calibration());
    let orbit = Orbit {
        target: Vec3::zeros(),
        distance: 3.2,
        azimuth: 0.6,
        elevation: 0.3,
        up: Vec3::y(),
        field_of_view: 0.8,
    };
    if let Some(folder) = std::env::var_os("SPLAT_SCENES_DIR") {
        let scene = file::read_file(std::path::Path::new(&folder).join("plant.ply")).unwrap();
        let mut mean = Vec3::zeros();
        for m in scene.means() {
            mean += m.cast::<f64>();
        }
        mean /= scene.count() as f64;
        let orbit = Orbit { target: mean, distance: 1.4, up: -Vec3::y(), ..orbit };
        measure(
            "plant, 113,648 Gaussians of degree 0",
            &scene,
            &Camera::on_orbit([800, 800], &orbit).unwrap(),
        );
    } else {
        println!("plant: SKIPPED, SPLAT_SCENES_DIR is not set");
    }
    let scene = wavy_sphere(500_000);
    measure(
        "wavy sphere, 500,000 Gaussians of degree 2",
        &scene,
        &Camera::on_orbit([800, 800], &orbit).unwrap(),
    );
}
