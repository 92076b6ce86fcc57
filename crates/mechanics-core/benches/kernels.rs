//! Time for a 3×3 singular value and polar decomposition: nalgebra's static SVD against ours, one number at a time and in
//! lanes, over a slice of matrices as a user calls it.
//!
//! `cargo bench -p mechanics-core --bench kernels`

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

#[path = "timing/timing.rs"]
mod timing;

use mechanics_core::decomposition::{self, Polar, Svd};
use mechanics_core::lanes::{self, Element, LaneKernel, Packet};
use mechanics_core::tensor::{self, Matrix3};
use std::hint::black_box;
use timing::{Case, Random, measure};

/// Matrices in a batch: input and output fit the second-level cache.
const COUNT: usize = 1024;
/// Interleaved repeats, of which the median counts.
const REPEATS: usize = 101;

/// Random matrices with entries in [−1, 1).
fn matrices<E: Element>() -> Vec<Matrix3<E>> {
    let mut random = Random(1);
    (0..COUNT)
        .map(|_| {
            let entries: [f64; 9] = std::array::from_fn(|_| random.number());
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
    let cases = vec![
        Case::new("nalgebra static SVD", COUNT, || {
            for f in &list {
                black_box(black_box(*f).svd(true, true));
            }
        }),
        Case::new("ours, one at a time", COUNT, || {
            for (f, d) in list.iter().zip(&mut one) {
                *d = decomposition::svd(black_box(f));
            }
        }),
        Case::new(lanes, COUNT, || decomposition::svd_into(black_box(&list), black_box(&mut many))),
        Case::new(fewer, COUNT, || {
            if <E as Element>::LANES == 4 {
                decomposition::svd_with_sweeps_into(black_box(&list), 3, black_box(&mut fast));
            } else {
                decomposition::svd_with_sweeps_into(black_box(&list), 2, black_box(&mut fast));
            }
        }),
        Case::new("one packet at a time, sigma only", COUNT, || {
            black_box(lanes::dispatch(LargestSigma(black_box(&list))));
        }),
        Case::new("the same, portable packets", COUNT, || {
            black_box(lanes::dispatch_portable(LargestSigma(black_box(&list))));
        }),
    ];
    let medians = measure(title, REPEATS, cases);
    println!("  the third {:.2}x (bar {bar})", medians[0] / medians[2]);
}

fn polar_factors<E: Element + nalgebra::RealField>(title: &str, lanes: &'static str) {
    let list = matrices::<E>();
    let mut one = vec![Polar::identity(); COUNT];
    let mut many = one.clone();
    let cases = vec![
        Case::new("nalgebra static SVD, U Vt", COUNT, || {
            for f in &list {
                let d = black_box(*f).svd(true, true);
                black_box(d.u.zip(d.v_t).map(|(u, v_t)| u * v_t));
            }
        }),
        Case::new("ours, one at a time", COUNT, || {
            for (f, d) in list.iter().zip(&mut one) {
                *d = decomposition::polar(black_box(f));
            }
        }),
        Case::new(lanes, COUNT, || decomposition::polar_into(black_box(&list), black_box(&mut many))),
    ];
    measure(title, REPEATS, cases);
}

fn main() {
    timing::print_calibration();
    singular_values::<f64>("SVD, f64", "ours, four lanes", "ours, four lanes, 3 + 1 sweeps", 6.5);
    singular_values::<f32>("SVD, f32", "ours, eight lanes", "ours, eight lanes, 2 + 1 sweeps", 11.0);
    polar_factors::<f64>("polar, f64", "ours, four lanes");
    polar_factors::<f32>("polar, f32", "ours, eight lanes");
}
