//! Million particle-steps a second, by law, dimension and precision; sorting included.
//!
//! Scenes as in `/work/shared/peers/taichi_mpm.py`: a block of cells with 2^D jittered particles each, spinning and falling. Every figure is the median
//! of interleaved repeats. With `TAICHI_PYTHON` (an interpreter that has taichi) and `PEERS_DIR` set, that script runs in between, on
//! one thread, and the ratio is printed. `--quick` leaves out the million particles.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use mechanics_core::lanes::Element;
use mechanics_core::law::Lame;
use mechanics_core::parallel::with_threads;
use mpm_constitutive::PointLaw;
use mpm_constitutive::elastic::{FixedCorotated, NeoHookean};
use mpm_constitutive::fluid::{Tait, Tension};
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle, VonMises, YieldStress};
use mpm_core::sampling::{Pattern, SampledBody, sample_shape};
use mpm_core::{Samples, Shape, Simulation, SimulationOptions};
use std::process::Command;
use std::time::Instant;

const REPEATS: usize = 5;

/// Nodes along the unit box, and the block's edge in cells.
#[derive(Clone, Copy)]
struct Size {
    nodes: usize,
    cells: usize,
    steps: usize,
}

const SMALL: Size = Size { nodes: 64, cells: 24, steps: 20 };
const LARGE: Size = Size { nodes: 128, cells: 50, steps: 5 };
const PLANE: Size = Size { nodes: 512, cells: 224, steps: 20 };

fn lame() -> Lame {
    Lame::from_young_poisson(1e5, 0.3).unwrap()
}

struct Scene<E: Element, const D: usize> {
    simulation: Simulation<E, D>,
    particles: usize,
    step: f64,
    steps: usize,
}

impl<E: Element, const D: usize> Scene<E, D> {
    fn new<L: PointLaw + 'static>(law: L, size: Size) -> Self {
        let spacing = 1.0 / size.nodes as f64;
        let shape = Shape::Cuboid { centre: [0.5; D], half: [0.5 * size.cells as f64 * spacing; D] };
        let SampledBody { positions, volumes } =
            sample_shape(&shape, Pattern::per_cell(spacing, 2), 7).unwrap();
        let velocity = |x: &[f64; D]| {
            let mut v = [0.0; D];
            (v[0], v[1]) = (2.0 * (x[1] - 0.5), -2.0 * (x[0] - 0.5));
            v[D - 1] = if D == 3 { -1.0 } else { v[D - 1] };
            v
        };
        let velocities: Vec<_> = positions.iter().map(velocity).collect();
        let mut simulation = Simulation::new(SimulationOptions::new(spacing)).unwrap();
        let samples = Samples { positions: &positions, velocities: &velocities, volumes: &volumes };
        simulation.add_body(law, 1000.0, samples).unwrap();
        let step = 0.3 * spacing / (1e5_f64 * 1.346 / 1000.0).sqrt();
        for _ in 0..3 {
            simulation.step_unchecked(step).unwrap();
        }
        Self { simulation, particles: positions.len(), step, steps: size.steps }
    }

    /// Million particle-steps a second.
    fn rate(&mut self, threads: usize) -> f64 {
        with_threads(threads, || {
            let start = Instant::now();
            for _ in 0..self.steps {
                self.simulation.step_unchecked(self.step).unwrap();
            }
            (self.particles * self.steps) as f64 / start.elapsed().as_secs_f64() / 1e6
        })
    }
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// Nanoseconds of a loop that does not change: how fast the machine is at the moment.
fn calibration() -> f64 {
    let start = Instant::now();
    let mut x = 1.0_f64;
    for _ in 0..2_000_000 {
        x = std::hint::black_box(x.mul_add(0.999_999, 1e-6));
    }
    start.elapsed().as_secs_f64() * 1e9 / 2e6
}

/// One line: alone, with two threads in turns, the wanted rate.
fn report<E: Element, const D: usize, L: PointLaw + 'static>(
    name: &str,
    law: L,
    size: Size,
    wanted: f64,
) -> f64 {
    let mut scene = Scene::<E, D>::new(law, size);
    let (mut single, mut ratios) = (Vec::new(), Vec::new());
    for _ in 0..REPEATS {
        let one = scene.rate(1);
        single.push(one);
        ratios.push(scene.rate(2) / one);
    }
    let (rate, ratio) = (median(single), median(ratios));
    println!(
        "{name:<34} {:>8} particles {rate:>7.2} M/s (wanted {wanted:>4.0}) {:>6.1} ns, two threads {ratio:.2}×, calibration {:.2} ns",
        scene.particles,
        1e3 / rate,
        calibration()
    );
    rate
}

/// Million particle-steps a second of Taichi for the same scene, if it is there.
fn taichi(arguments: &[&str]) -> Option<f64> {
    let (python, folder) = (std::env::var("TAICHI_PYTHON").ok()?, std::env::var("PEERS_DIR").ok()?);
    let mut command = Command::new(python);
    command.current_dir(folder).arg("taichi_mpm.py").args(["--threads", "1"]).args(arguments);
    let text = String::from_utf8(command.output().ok()?.stdout).ok()?;
    let rest = text.split("\"Mpps\":").nth(1)?;
    rest.split(',').next()?.trim().parse().ok()
}

fn compare(rate: f64, wanted: f64, arguments: &[&str]) {
    if let Some(theirs) = taichi(arguments) {
        println!("{:<34} Taichi {theirs:.2} M/s: {:.1} times as fast (wanted {wanted})", "", rate / theirs);
    }
}

fn main() {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let water = Tait::new(1e5, 7.0, Tension::Carried).unwrap();
    let metal = VonMises::new(lame(), YieldStress::perfect(1e3).unwrap()).unwrap();
    let sand = DruckerPrager::new(lame(), FrictionAngle::constant(0.52).unwrap(), 0.0).unwrap();
    let jelly = FixedCorotated::new(lame());
    let rate = report::<f32, 3, _>("3D f32 fixed corotated", jelly, SMALL, 10.0);
    compare(rate, 11.0, &["--n", "64", "--prec", "f32"]);
    let rate = report::<f64, 3, _>("3D f64 fixed corotated", jelly, SMALL, 5.0);
    compare(rate, 7.0, &["--n", "64", "--prec", "f64"]);
    let rate = report::<f32, 3, _>("3D f32 fluid", water, SMALL, 18.0);
    compare(rate, 8.0, &["--n", "64", "--prec", "f32", "--model", "fluid"]);
    report::<f32, 3, _>("3D f32 neo-Hookean", NeoHookean::new(lame()), SMALL, 13.0);
    report::<f32, 3, _>("3D f32 von Mises", metal, SMALL, 7.0);
    report::<f32, 3, _>("3D f32 sand", sand, SMALL, 7.0);
    let rate = report::<f32, 2, _>("2D f32 fixed corotated", jelly, PLANE, 40.0);
    compare(rate, 5.0, &["--dim", "2", "--n", "512", "--cells", "224"]);
    if !quick {
        report::<f32, 3, _>("3D f32 fixed corotated, a million", jelly, LARGE, 10.0);
        report::<f64, 3, _>("3D f64 fixed corotated, a million", jelly, LARGE, 5.0);
    }
}
