//! A run that is interrupted and resumed ends in the same bits as one that is not.
//!
//! A ring of 2,000 masses joined by springs swings freely (leapfrog, whose force at the end of a step is used again
//! at the start of the next: history that a checkpoint must not lose). One run goes through; the other is written to
//! disk half way, thrown away, read back, and finished on another number of threads.
//!
//! `cargo run -p mechanics-core --example resume`
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use mechanics_core::checkpoint::Checkpoint;
use mechanics_core::diagnostics::{kinetic_energy, linear_momentum};
use mechanics_core::parallel::{map_into, sum, with_threads};
use mechanics_core::state::State;
use mechanics_core::tensor::Vec3;
use std::error::Error;
use std::f64::consts::TAU;

const POINTS: usize = 2_000;
const STEPS: u64 = 4_000;
const CHUNK: usize = 256;
/// Spring constant [N/m], rest length [m], mass [kg], time step [s].
const STIFFNESS: f64 = 100.0;
const REST_LENGTH: f64 = 1e-3;
const MASS: f64 = 1e-3;
const STEP: f64 = 1e-4;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::temp_dir().join(format!("mechanics-resume-{}.checkpoint", std::process::id()));
    let start = ring();
    let energy_at_start = energy(&start);

    let mut through = start.clone();
    with_threads(1, || advance(&mut through, STEPS));

    let mut half = start;
    with_threads(1, || advance(&mut half, STEPS / 2));
    save(&half, &path)?;
    drop(half);
    let mut resumed = load(&path)?;
    with_threads(2, || advance(&mut resumed, STEPS / 2));
    std::fs::remove_file(&path)?;

    let momentum = linear_momentum(&[MASS; POINTS], &through.velocity);
    println!("after {} steps, t = {:.3} s:", through.step, through.time);
    println!("  uninterrupted, 1 thread  state {:016x}", through.hash());
    println!("  resumed, then 2 threads  state {:016x}", resumed.hash());
    println!("  energy {:.6} J at the start, {:.6} J now", energy_at_start, energy(&through));
    println!("  momentum {:.1e} kg m/s, zero at the start", momentum.norm());
    if through.hash() == resumed.hash() { Ok(()) } else { Err("the resumed run went another way".into()) }
}

/// A circle that is stretched by a tenth, with a wave along it.
fn ring() -> State {
    let radius = 1.1 * REST_LENGTH * POINTS as f64 / TAU;
    let place = |i: usize| {
        let angle = TAU * i as f64 / POINTS as f64;
        Vec3::new(angle.cos(), angle.sin(), 0.02 * (5.0 * angle).sin()) * radius
    };
    let mut state = State::at_rest((0..POINTS).map(place).collect());
    let mut force = vec![Vec3::zeros(); POINTS];
    forces_into(&state.position, &mut force);
    state.set_history("force", force);
    state
}

/// The pull of the spring from `a` to `b` on `a` [N].
fn pull(a: &Vec3, b: &Vec3) -> Vec3 {
    let along = b - a;
    along * (STIFFNESS * (1.0 - REST_LENGTH / along.norm()))
}

fn forces_into(x: &[Vec3], force: &mut [Vec3]) {
    map_into(force, CHUNK, |i| {
        let (before, after) = ((i + POINTS - 1) % POINTS, (i + 1) % POINTS);
        pull(&x[i], &x[after]) + pull(&x[i], &x[before])
    });
}

fn advance(state: &mut State, steps: u64) {
    let mut force = state.history("force").map(<[Vec3]>::to_vec).unwrap_or_default();
    for _ in 0..steps {
        let kick = 0.5 * STEP / MASS;
        for ((x, v), f) in state.position.iter_mut().zip(&mut state.velocity).zip(&force) {
            *v += f * kick;
            *x += *v * STEP;
        }
        forces_into(&state.position, &mut force);
        for (v, f) in state.velocity.iter_mut().zip(&force) {
            *v += f * kick;
        }
        state.step += 1;
        state.time = state.step as f64 * STEP;
    }
    state.set_history("force", force);
}

/// Kinetic and elastic energy [J].
fn energy(state: &State) -> f64 {
    let x = &state.position;
    let stretch = |i: usize| (x[(i + 1) % POINTS] - x[i]).norm() - REST_LENGTH;
    let elastic = sum(POINTS, CHUNK, |i| 0.5 * STIFFNESS * stretch(i).powi(2));
    kinetic_energy(&[MASS; POINTS], &state.velocity) + elastic
}

fn save(state: &State, path: &std::path::Path) -> Result<(), Box<dyn Error>> {
    let mut checkpoint = Checkpoint::new();
    checkpoint.put_text("scheme", "leapfrog ring");
    state.save(&mut checkpoint, "ring");
    Ok(checkpoint.write(path)?)
}

fn load(path: &std::path::Path) -> Result<State, Box<dyn Error>> {
    let mut checkpoint = Checkpoint::read(path)?;
    checkpoint.take_matching_text("scheme", "leapfrog ring")?;
    let state = State::load(&mut checkpoint, "ring")?;
    checkpoint.finish()?;
    Ok(state)
}
