//! Time for the acceleration q̈ of pendulums: by hand, by this crate, by num-dual's Hessian, by nested jets.
//!
//! `cargo bench -p lagrangian --no-default-features --bench acceleration`
//!
//! All ways answer to the same states, in turn, many times; medians count, and ratios within one run are what can be
//! trusted. With an argument, `-- profile <number of the way>` runs one way of the double pendulum alone, for a profiler.

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

#[path = "acceleration/systems.rs"]
mod systems;
#[path = "acceleration/ways.rs"]
mod ways;

use lagrangian::{EulerLagrange, Lagrangian, System};
use num_dual::{Dual2SVec64, DualNum};
use std::hint::black_box;
use std::time::Instant;
use systems::{Cartesian, Double, GRAVITY, Triple};
use ways::{by_nested_jets, by_num_dual};

/// States in a batch.
const COUNT: usize = 512;
/// Interleaved repeats, of which the median counts.
const REPEATS: usize = 301;

const DOUBLE: Double = Double { mass: [2.0, 1.0], length: [1.0, 0.5] };
const TRIPLE: Triple = Triple { mass: [1.0; 3], length: [1.0; 3] };

type State<const N: usize> = ([f64; N], [f64; N]);
type Batch<'a, const N: usize> = Box<dyn Fn(&[State<N>]) -> f64 + 'a>;

/// A way to an acceleration, over a batch.
struct Way<'a, const N: usize> {
    name: &'static str,
    run: Batch<'a, N>,
    nanoseconds: Vec<f64>,
}

impl<'a, const N: usize> Way<'a, N> {
    fn new(name: &'static str, one: impl Fn(&[f64; N], &[f64; N]) -> [f64; N] + 'a) -> Self {
        let run = move |states: &[State<N>]| {
            let mut sum = 0.0;
            for (q, v) in states {
                sum += black_box(one(black_box(q), black_box(v)))[0];
            }
            sum
        };
        Self { name, run: Box::new(run), nanoseconds: Vec::new() }
    }

    fn ours<L: Lagrangian<N> + 'a>(name: &'static str, lagrangian: L) -> Self {
        let system = EulerLagrange::new(lagrangian);
        Self::new(name, move |q, v| {
            let mut acceleration = [0.0; N];
            match black_box(&system).acceleration(0.0, q, v, &mut acceleration) {
                Ok(()) => acceleration,
                Err(_) => [f64::NAN; N],
            }
        })
    }

    fn median(&mut self) -> f64 {
        self.nanoseconds.sort_by(f64::total_cmp);
        self.nanoseconds[self.nanoseconds.len() / 2]
    }
}

/// States of motion with angles and velocities up to two.
fn states<const N: usize>() -> Vec<State<N>> {
    let mut state = 1u64;
    let mut number = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        4.0 * ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
    };
    (0..COUNT).map(|_| (std::array::from_fn(|_| number()), std::array::from_fn(|_| number()))).collect()
}

/// Nanoseconds of one step of a fixed loop of dependent multiplications and additions: tells machines apart.
fn calibrate() -> f64 {
    let start = Instant::now();
    let mut x = black_box(0.5f64);
    for _ in 0..COUNT {
        x = x * 0.999 + 0.001;
    }
    black_box(x);
    start.elapsed().as_secs_f64() * 1e9 / COUNT as f64
}

/// Runs all ways in turn and prints their medians against the first.
fn compare<const N: usize>(title: &str, ways: &mut [Way<'_, N>], bars: &[(&str, f64)]) {
    let states = states::<N>();
    let mut calibration = Vec::new();
    for _ in 0..REPEATS {
        calibration.push(calibrate());
        for way in &mut *ways {
            let start = Instant::now();
            black_box((way.run)(&states));
            way.nanoseconds.push(start.elapsed().as_secs_f64() * 1e9 / COUNT as f64);
        }
    }
    calibration.sort_by(f64::total_cmp);
    println!("\n{title}  (calibration: {:.2} ns a multiply-add)", calibration[REPEATS / 2]);
    let by_hand = ways[0].median();
    for way in ways {
        let median = way.median();
        let bar = bars.iter().find(|bar| bar.0 == way.name).map(|bar| format!("  (bar {})", bar.1));
        println!(
            "  {:34} {median:8.1} ns {:6.2} x by hand{}",
            way.name,
            median / by_hand,
            bar.unwrap_or_default()
        );
    }
}

type Dual4 = Dual2SVec64<4>;
type Dual6 = Dual2SVec64<6>;

fn double_over_num_dual(q: &[Dual4; 2], v: &[Dual4; 2]) -> Dual4 {
    let ([m1, m2], [l1, l2]) = (black_box(DOUBLE).mass, black_box(DOUBLE).length);
    let coupling = (q[0] - q[1]).cos() * (m2 * l1 * l2);
    v[0].powi(2) * (0.5 * (m1 + m2) * l1 * l1)
        + v[1].powi(2) * (0.5 * m2 * l2 * l2)
        + v[0] * v[1] * coupling
        + q[0].cos() * ((m1 + m2) * GRAVITY * l1)
        + q[1].cos() * (m2 * GRAVITY * l2)
}

fn triple_over_num_dual(q: &[Dual6; 3], v: &[Dual6; 3]) -> Dual6 {
    let (m, l) = (black_box(TRIPLE).mass, black_box(TRIPLE).length);
    let mut sum = Dual6::from(0.0);
    for i in 0..3 {
        let below: f64 = m[i..].iter().sum();
        sum += v[i].powi(2) * (0.5 * below * l[i] * l[i]) + q[i].cos() * (below * GRAVITY * l[i]);
        for j in 0..i {
            sum += v[i] * v[j] * (q[i] - q[j]).cos() * (below * l[i] * l[j]);
        }
    }
    sum
}

fn double_ways<'a>() -> Vec<Way<'a, 2>> {
    vec![
        Way::new("by hand", |q, v| black_box(&DOUBLE).by_hand(q, v)),
        Way::ours("EulerLagrange, compact", DOUBLE),
        Way::ours("EulerLagrange, Cartesian", Cartesian(DOUBLE)),
        Way::new("num-dual, Hessian of L", |q, v| by_num_dual(double_over_num_dual, q, v)),
        Way::new("nested jets, three passes", |q, v| by_nested_jets(black_box(&DOUBLE), q, v)),
    ]
}

fn triple_ways<'a>() -> Vec<Way<'a, 3>> {
    vec![
        Way::new("by hand", |q, v| black_box(&TRIPLE).by_hand(q, v)),
        Way::ours("EulerLagrange", TRIPLE),
        Way::new("num-dual, Hessian of L", |q, v| by_num_dual(triple_over_num_dual, q, v)),
        Way::new("nested jets, three passes", |q, v| by_nested_jets(black_box(&TRIPLE), q, v)),
    ]
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|argument| argument == "profile") {
        let number: usize = arguments.get(at + 1).and_then(|text| text.parse().ok()).unwrap_or(0);
        let states = states();
        for _ in 0..200 {
            black_box((double_ways()[number].run)(&states));
        }
        return;
    }
    let bars = [("EulerLagrange, compact", 2.0)];
    compare("q̈ of a double pendulum", &mut double_ways(), &bars);
    compare("q̈ of a triple pendulum (bar 250 ns)", &mut triple_ways(), &[]);
}
