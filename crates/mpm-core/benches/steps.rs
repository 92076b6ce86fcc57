//! Million particle-steps a second, by law, dimension and precision.
#![allow(clippy::print_stdout, missing_docs, clippy::unwrap_used)]
use mechanics_core::lanes::Element;
use mechanics_core::law::Lame;
use mpm_core::*;
use mpm_constitutive::elastic::*;
use std::time::Instant;

fn block<const D: usize>(n: usize, cells: usize) -> (Vec<[f64; D]>, f64) {
    let dx = 1.0 / n as f64;
    let lo = (n - cells) / 2;
    let mut seed = 7_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let side = 2 * cells;
    let count = side.pow(D as u32);
    let points = (0..count)
        .map(|p| {
            std::array::from_fn(|axis| {
                let i = p / side.pow((D - 1 - axis) as u32) % side;
                (lo as f64 + (i as f64 + 0.5 + 0.4 * (random() - 0.5)) / 2.0) * dx
            })
        })
        .collect();
    (points, dx)
}

fn run<E: Element, const D: usize, L: mpm_constitutive::PointLaw + 'static>(name: &str, law: L, n: usize, cells: usize, steps: usize) {
    let (points, dx) = block::<D>(n, cells);
    let mut simulation = Simulation::<E, D>::new(SimulationOptions::new(dx)).unwrap();
    let velocities: Vec<[f64; D]> = points.iter().map(|x| { let mut v = [0.0; D]; v[0] = 2.0 * (x[1] - 0.5); v[1] = -2.0 * (x[0] - 0.5); v[D-1] = -1.0; v }).collect();
    let volume = (dx / 2.0).powi(D as i32);
    let volumes = vec![volume; points.len()];
    simulation.add_body(law, 1000.0, Samples { positions: &points, velocities: &velocities, volumes: &volumes }).unwrap();
    let dt = 0.3 * dx / (1e5_f64 * 1.35 / 1000.0).sqrt();
    for _ in 0..3 { simulation.step_unchecked(dt).unwrap(); }
    let mut sorts = 0;
    let start = Instant::now();
    for _ in 0..steps { if simulation.step_unchecked(dt).unwrap().sorted { sorts += 1 } }
    let time = start.elapsed().as_secs_f64();
    println!("{name}: {} particles, {:.2} M/s, {:.1} ns, {sorts} sorts in {steps}", points.len(), points.len() as f64 * steps as f64 / time / 1e6, time * 1e9 / (points.len() * steps) as f64);
}

fn main() {
    let lame = Lame::from_young_poisson(1e5, 0.3).unwrap();
    let threads: usize = std::env::args().nth(1).and_then(|s| s.parse().ok()).unwrap_or(1);
    mechanics_core::parallel::with_threads(threads, || {
        run::<f32, 3, _>("3D f32 fixed corotated", FixedCorotated::new(lame), 64, 24, 40);
        run::<f32, 3, _>("3D f32 neo-Hookean", NeoHookean::new(lame), 64, 24, 40);
        if threads == 9 { run::<f64, 3, _>("3D f64 fixed corotated", NeoHookean::new(lame), 64, 24, 20) }
        if threads == 9 { run::<f32, 2, _>("2D f32 fixed corotated", FixedCorotated::new(lame), 512, 224, 20) }
    });
}
