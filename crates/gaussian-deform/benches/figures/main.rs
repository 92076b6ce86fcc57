//! Every figure of speed that this crate promises, beside its bar.
//!
//! `SPLAT_SCENES_DIR=… cargo bench -p gaussian-deform --bench figures`, with `picture` or `matter` after `--` for a half of them. The folder may hold `plant.ply` (113,648
//! Gaussians, degree 0), `playbot_31k_sh2.ply` and `academic_tarot_cards.splat`; without it only synthetic scenes are drawn.
//!
//! Times are medians of interleaved repeats. "core" is what the threads of this process spent on a processor together (Linux; elsewhere it is the time
//! that passed): a busy machine makes it a little longer, where the time that passes becomes anything. With two threads, what the busier one spent is what would pass on a
//! machine that has two cores to spare.

#![allow(clippy::print_stdout, reason = "a benchmark prints")]
#![allow(clippy::unwrap_used, reason = "a benchmark may stop at once")]

mod matter;
mod picture;
mod scenes;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::hint::black_box;
use std::time::Instant;

/// What a figure must be.
#[derive(Clone, Copy)]
enum Bar {
    AtMost(f64),
    AtLeast(f64),
    /// For comparison only.
    Absent,
}

fn print_figure(name: &str, value: f64, unit: &str, bar: Bar) {
    let verdict = |met: bool| if met { "met" } else { "MISSED" };
    let bar = match bar {
        Bar::AtMost(most) => format!("at most {most}: {}", verdict(value <= most)),
        Bar::AtLeast(least) => format!("at least {least}: {}", verdict(value >= least)),
        Bar::Absent => String::new(),
    };
    println!("  {name:64} {value:9.2} {unit:5} {bar}");
}

/// Seconds that passed, that all threads spent on a processor, and that the busiest of them did.
#[derive(Clone, Copy)]
struct Time {
    wall: f64,
    core: f64,
    busiest: f64,
}

/// Times what a thread pool does from inside of it: threads that have ended are in no statistics.
fn timed(run: impl FnOnce()) -> Time {
    let (start, before) = (Instant::now(), core_seconds());
    run();
    let wall = start.elapsed().as_secs_f64();
    let (Some(before), Some(after)) = (before, core_seconds()) else {
        return Time { wall, core: wall, busiest: wall };
    };
    let spent = after.iter().map(|(thread, time)| time - before.get(thread).unwrap_or(&0.0));
    let (core, busiest) = spent.fold((0.0, 0.0), |(sum, most), time| (sum + time, f64::max(most, time)));
    Time { wall, core, busiest }
}

/// By thread the first number of the scheduler's statistics: time on a processor.
fn core_seconds() -> Option<BTreeMap<OsString, f64>> {
    let mut times = BTreeMap::new();
    for thread in std::fs::read_dir("/proc/self/task").ok()? {
        let thread = thread.ok()?;
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        times.insert(thread.file_name(), text.split(' ').next()?.parse::<f64>().ok()? * 1e-9);
    }
    Some(times)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Times of all cases, which time themselves, in turn, so that a slow moment of the machine falls on all of them.
fn interleaved(repeats: usize, cases: &mut [Box<dyn FnMut() -> Time + '_>]) -> Vec<Vec<Time>> {
    let mut times = vec![Vec::new(); cases.len()];
    for _ in 0..repeats {
        for (case, times) in cases.iter_mut().zip(&mut times) {
            times.push(case());
        }
    }
    times
}

fn median_core(times: &[Time]) -> f64 {
    median(times.iter().map(|time| time.core))
}

fn median_busiest(times: &[Time]) -> f64 {
    median(times.iter().map(|time| time.busiest))
}

fn median_wall(times: &[Time]) -> f64 {
    median(times.iter().map(|time| time.wall))
}

/// A chain of dependent multiplications: how fast this machine is at this moment.
fn print_calibration() {
    let time = timed(|| {
        let mut x = black_box(1.0_f64);
        for _ in 0..20_000_000 {
            x = x * 0.999_999_9 + 1e-7;
        }
        black_box(x);
    });
    let [wall, core] = [time.wall, time.core].map(|t| t * 1e9 / 2e7);
    println!(
        "\ncalibration: a dependent multiplication and addition takes {core:.3} ns of a core, {wall:.3} ns passed"
    );
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let wanted = |name: &str| words.is_empty() || words.iter().any(|word| word == name);
    if wanted("matter") {
        mechanics_core::parallel::with_threads(1, matter::figures);
    }
    if wanted("picture") {
        picture::figures();
    }
    print_calibration();
}
