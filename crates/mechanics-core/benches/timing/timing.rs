//! What benches share: cases that run in turn, so that a slow moment of the machine falls on all of them, their medians and
//! ratios within the run, and a loop that tells how fast the machine is today.
//!
//! Other crates' benches include this file by its path, as their tests do with `tests/fuzz/fuzzing.rs`.

// Not every bench uses all of it.
#![allow(dead_code)]
#![allow(clippy::print_stdout, reason = "a benchmark prints")]

use mechanics_core::tensor::Vec3;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// A measurement by name.
pub(crate) struct Case<'a> {
    name: String,
    /// Things that one run does, each of which is to be timed.
    count: usize,
    run: Box<dyn FnMut() + 'a>,
}

impl<'a> Case<'a> {
    /// A run that does something `count` times.
    pub(crate) fn new(name: impl Into<String>, count: usize, run: impl FnMut() + 'a) -> Self {
        Self { name: name.into(), count, run: Box::new(run) }
    }
}

/// Runs all cases in turn, `repeats` times, and prints and answers their medians \[ns\], with ratios to the first.
pub(crate) fn measure(title: &str, repeats: usize, mut cases: Vec<Case<'_>>) -> Vec<f64> {
    let mut times = vec![Vec::new(); cases.len()];
    for _ in 0..repeats {
        for (case, times) in cases.iter_mut().zip(&mut times) {
            times.push(time(&mut *case.run).as_secs_f64() * 1e9 / case.count as f64);
        }
    }
    let medians: Vec<f64> = times.into_iter().map(median).collect();
    println!("\n{title}");
    for (case, &own) in cases.iter().zip(&medians) {
        let part = own / medians[0];
        println!("  {:58} {own:9.1} ns {part:9.4} of the first {:8.2}x", case.name, 1.0 / part);
    }
    medians
}

/// Medians of interleaved repeats \[s\].
pub(crate) fn interleaved<const K: usize>(repeats: usize, mut work: [&mut dyn FnMut(); K]) -> [f64; K] {
    let mut times = [const { Vec::new() }; K];
    for _ in 0..repeats {
        for (times, work) in times.iter_mut().zip(&mut work) {
            times.push(time(&mut **work).as_secs_f64());
        }
    }
    times.map(median)
}

/// How long some work takes.
pub(crate) fn time(work: impl FnOnce()) -> Duration {
    let begin = Instant::now();
    work();
    begin.elapsed()
}

/// The middle of some numbers.
pub(crate) fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// Time of a multiplication and addition that wait for the ones before \[ns\]: how fast this machine is today.
pub(crate) fn calibration() -> f64 {
    let mut x = black_box(1.0_f64);
    let work = time(|| (0..20_000_000).for_each(|_| x = x * 0.999_999_9 + 1e-7));
    black_box(x);
    work.as_secs_f64() * 1e9 / 2e7
}

/// Prints it.
pub(crate) fn print_calibration() {
    println!("calibration: {:.3} ns for a dependent multiplication and addition", calibration());
}

/// Numbers that look random, in [−1, 1), the same in every run (Knuth's linear congruential generator for 64 bits).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
}
