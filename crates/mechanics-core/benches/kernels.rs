//! Time for a 3×3 singular value and polar decomposition: nalgebra's static SVD against ours, one number at a time and in
//! lanes, over a slice of matrices as a user calls it.
//!
//! `cargo bench -p mechanics-core --bench kernels`

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

use mechanics_core::decomposition::{self, Polar, Svd};
use mechanics_core::lanes::{self, Element, LaneKernel, Packet};
use mechanics_core::tensor::{self, Matrix3};
use std::hint::black_box;
use std::time::Instant;

/// Matrices in a batch: input and output fit the second-level cache.
const COUNT: usize = 1024;
/// Interleaved repeats, of which the median counts.
const REPEATS: usize = 101;

/// A measurement by name.
struct Case<'a> {
    name: &'static str,
    run: Box<dyn FnMut() + 'a>,
    nanoseconds: Vec<f64>,
}

impl<'a> Case<'a> {
    fn new(name: &'static str, run: impl FnMut() + 'a) -> Self {
        Self { name, run: Box::new(run), nanoseconds: Vec::new() }
    }

    fn median(&mut self) -> f64 {
        self.nanoseconds.sort_by(f64::total_cmp);
        self.nanoseconds[REPEATS / 2]
    }
}

/// Runs all cases in turn, many times, so that a slow moment of the machine falls on all of them.
fn measure(title: &str, cases: &mut [Case<'_>], bars: &[(usize, f64)]) {
    for _ in 0..REPEATS {
        for case in &mut *cases {
            let start = Instant::now();
            (case.run)();
            case.nanoseconds.push(start.elapsed().as_secs_f64() * 1e9 / COUNT as f64);
        }
    }
    println!("\n{title}");
    let medians: Vec<f64> = cases.iter_mut().map(Case::median).collect();
    for (i, case) in cases.iter().enumerate() {
        let bar = bars.iter().find(|bar| bar.0 == i).map(|bar| format!("  (bar {})", bar.1));
        println!(
            "  {:34} {:8.1} ns {:7.2}x{}",
            case.name,
            medians[i],
            medians[0] / medians[i],
            bar.unwrap_or_default()
        );
    }
}

/// Random matrices with entries in [−1, 1).
fn matrices<E: Element>() -> Vec<Matrix3<E>> {
    let mut state = 1u64;
    let mut number = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..COUNT)
        .map(|_| {
            let entries: [f64; 9] = std::array::from_fn(|_| number());
            tensor::from_entries(|i, j| E::constant(entries[3 * i + j]))
        })
        .collect()
}

/// One packet at a time, results left in lanes: for comparing packets.
struct LargestSigma<'a, E>(&'a [Matrix3<E>]);

impl<E: Element> LaneKernel<E> for LargestSigma<'_, E> {
    type Output = f64;
    #[inline(always)]
    fn run<P: Packet<Element = E>>(self) -> f64 {
        let mut largest = P::constant(0.0);
        for matrices in self.0.chunks_exact(P::LANES) {
            largest = largest.max(decomposition::svd(&lanes::load_matrices::<P>(matrices)).sigma[0]);
        }
        largest.to_lanes().as_ref()[0].into()
    }
}

fn singular_values<E: Element + nalgebra::RealField>(
    title: &str,
    lanes: &'static str,
    fewer: &'static str,
    bar: f64,
) {
    let list = matrices::<E>();
    let mut one = vec![Svd::identity(); COUNT];
    let mut many = one.clone();
    let mut fast = one.clone();
    let mut cases = [
        Case::new("nalgebra static SVD", || {
            for f in &list {
                black_box(black_box(*f).svd(true, true));
            }
        }),
        Case::new("ours, one at a time", || {
            for (f, d) in list.iter().zip(&mut one) {
                *d = decomposition::svd(black_box(f));
            }
        }),
        Case::new(lanes, || decomposition::svd_into(black_box(&list), black_box(&mut many))),
        Case::new(fewer, || {
            if <E as Element>::LANES == 4 {
                decomposition::svd_with_sweeps_into(black_box(&list), 3, black_box(&mut fast));
            } else {
                decomposition::svd_with_sweeps_into(black_box(&list), 2, black_box(&mut fast));
            }
        }),
        Case::new("one packet at a time, sigma only", || {
            black_box(lanes::dispatch(LargestSigma(black_box(&list))));
        }),
        Case::new("the same, portable packets", || {
            black_box(lanes::dispatch_portable(LargestSigma(black_box(&list))));
        }),
    ];
    measure(title, &mut cases, &[(2, bar)]);
}

fn polar_factors<E: Element + nalgebra::RealField>(title: &str, lanes: &'static str) {
    let list = matrices::<E>();
    let mut one = vec![Polar::identity(); COUNT];
    let mut many = one.clone();
    let mut cases = [
        Case::new("nalgebra static SVD, U Vt", || {
            for f in &list {
                let d = black_box(*f).svd(true, true);
                black_box(d.u.zip(d.v_t).map(|(u, v_t)| u * v_t));
            }
        }),
        Case::new("ours, one at a time", || {
            for (f, d) in list.iter().zip(&mut one) {
                *d = decomposition::polar(black_box(f));
            }
        }),
        Case::new(lanes, || decomposition::polar_into(black_box(&list), black_box(&mut many))),
    ];
    measure(title, &mut cases, &[]);
}

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

fn main() {
    println!("calibration: {:.3} ns for a dependent multiplication and addition", calibration());
    singular_values::<f64>("SVD, f64", "ours, four lanes", "ours, four lanes, 3 + 1 sweeps", 6.5);
    singular_values::<f32>("SVD, f32", "ours, eight lanes", "ours, eight lanes, 2 + 1 sweeps", 11.0);
    polar_factors::<f64>("polar, f64", "ours, four lanes");
    polar_factors::<f32>("polar, f32", "ours, eight lanes");
}
