//! What this machine can do: clock, memory bandwidth, and instructions counted by valgrind.

use std::hint::black_box;
use std::process::Command;
use std::time::Instant;

/// GHz, from a chain of operations of one cycle each; the best of some tries.
pub(crate) fn clock() -> f64 {
    const LENGTH: u32 = 2_000_000;
    let time = |_| {
        let (start, mut x) = (Instant::now(), black_box(1_u64));
        for _ in 0..LENGTH {
            // Two operations, each of which waits for the other.
            x = x.rotate_left(7) ^ 0x5555;
        }
        black_box(x);
        start.elapsed().as_secs_f64()
    };
    2.0 * f64::from(LENGTH) / (0..7).map(time).fold(f64::INFINITY, f64::min) / 1e9
}

/// GB/s of one thread that reads one array and writes another, each of 256 MiB; the best of some tries.
pub(crate) fn bandwidth() -> f64 {
    let source = vec![1.0_f64; 1 << 25];
    let mut target = vec![0.0_f64; source.len()];
    let mut time = || {
        let start = Instant::now();
        for (a, b) in target.iter_mut().zip(black_box(&source)) {
            *a = 3.0 * b;
        }
        black_box(&target);
        start.elapsed().as_secs_f64()
    };
    let best = (0..5).map(|_| time()).fold(f64::INFINITY, f64::min);
    16.0 * source.len() as f64 / best / 1e9
}

/// How many times as much arithmetic two threads do as one, at this moment: the most that two threads can gain.
pub(crate) fn two_threads() -> f64 {
    let work = || {
        let start = Instant::now();
        let mut sums = black_box([1.0_f64; 8]);
        for _ in 0..10_000_000 {
            for x in &mut sums {
                *x = 0.999_999 * *x + 1e-9;
            }
        }
        black_box(sums);
        start.elapsed().as_secs_f64()
    };
    let pair = |_| {
        let (alone, other) = (work(), std::thread::spawn(work));
        2.0 * alone / work().max(other.join().unwrap())
    };
    let mut ratios: Vec<f64> = (0..7).map(pair).collect();
    ratios.sort_by(f64::total_cmp);
    ratios[3]
}

/// Instructions of this program with these arguments, counted by valgrind if it is there.
fn instructions(arguments: &[&str]) -> Option<f64> {
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(std::env::current_exe().ok()?);
    // Repeated stores count as one instruction a byte.
    command.args(arguments).env("GLIBC_TUNABLES", "glibc.cpu.x86_rep_stosb_threshold=1000000000");
    let text = String::from_utf8(command.output().ok()?.stderr).ok()?;
    let line = text.lines().find(|line| line.contains("Collected"))?;
    line.split_whitespace().last()?.parse().ok()
}

/// Instructions a particle-step of a scene: the difference of a long and a short walk.
pub(crate) fn instructions_a_particle(name: &str, particles: usize) -> Option<f64> {
    let count = |steps: &str| instructions(&["--walk", name, steps]);
    Some((count("10")? - count("4")?) / (6 * particles) as f64)
}

/// Million particle-steps a second of processor time of Taichi for the same scene on one thread, if `TAICHI_PYTHON` and `PEERS_DIR` say where it is.
pub(crate) fn taichi(arguments: &str) -> Option<f64> {
    let (python, folder) = (std::env::var("TAICHI_PYTHON").ok()?, std::env::var("PEERS_DIR").ok()?);
    let mut command = Command::new(python);
    command.current_dir(folder).arg("taichi_mpm.py").args(["--threads", "1"]);
    let text = String::from_utf8(command.args(arguments.split(' ')).output().ok()?.stdout).ok()?;
    let rest = text.split("\"Mpps_cpu\":").nth(1)?;
    rest.split(',').next()?.trim().parse().ok()
}
