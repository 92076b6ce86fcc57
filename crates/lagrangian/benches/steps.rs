//! Nanoseconds of one step of each fixed-step method: on the double pendulum, and on a chain of 20 masses whose number is
//! known at run time only. Also what a q̈ costs there.
//!
//! `cargo bench -p lagrangian --no-default-features --bench steps`; with arguments `CASE STEPS` it runs one case once, for
//! counting instructions.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark prints")]

use lagrangian::constraint::{Constraints, Holonomic, Rattle};
use lagrangian::integrator::{
    AdamsBashforthMoulton, Bdf2, DiscreteEulerLagrange, DormandPrince853, Evaluations, GaussLegendre,
    ImplicitEuler, Integrator, RungeKutta4, StormerVerlet,
};
use lagrangian::{EulerLagrange, Lagrangian, Phase, SlicedEulerLagrange, SlicedLagrangian, System};
use mechanics_core::scalar::Scalar;
use std::hint::black_box;
use std::time::Instant;

const REPEATS: usize = 21;
const G: f64 = 9.81;

/// 2 kg on 1 m, 1 kg on ½ m below it.
struct DoublePendulum;

impl Lagrangian<2> for DoublePendulum {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _: S) -> S {
        v[0].square().scale(1.5) + v[1].square().scale(0.125) + ((q[0] - q[1]).cos() * v[0] * v[1]).scale(0.5)
    }
    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        -q[0].cos().scale(3.0 * G) - q[1].cos().scale(0.5 * G)
    }
}

/// The same in the plane, on rods.
struct Bobs;

impl Lagrangian<4> for Bobs {
    #[inline]
    fn kinetic<S: Scalar>(&self, _: &[S; 4], v: &[S; 4], _: S) -> S {
        v[0].square() + v[1].square() + (v[2].square() + v[3].square()).scale(0.5)
    }
    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 4], _: S) -> S {
        q[1].scale(2.0 * G) + q[3].scale(G)
    }
}

impl Holonomic<4, 2> for Bobs {
    fn constraint<S: Scalar>(&self, q: &[S; 4], _: S) -> [S; 2] {
        let lower = (q[2] - q[0]).square() + (q[3] - q[1]).square();
        [(q[0].square() + q[1].square()).offset(-1.0).scale(0.5), lower.offset(-0.25)]
    }
}

/// Equal masses and hardening springs in a row between walls.
struct Chain(usize);

impl SlicedLagrangian for Chain {
    fn dimension(&self) -> usize {
        self.0
    }
    fn kinetic<S: Scalar>(&self, _: &[S], v: &[S], _: S) -> S {
        v.iter().fold(S::constant(0.0), |sum, v| sum + v.square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S], _: S) -> S {
        let energy = |x: S| {
            let square = x.square();
            square.scale(0.5) + square.square().scale(0.05)
        };
        let mut sum = energy(q[0]) + energy(q[self.0 - 1]);
        for i in 1..self.0 {
            sum += energy(q[i] - q[i - 1]);
        }
        sum
    }
}

fn run<S: System>(
    system: &S,
    mut method: impl Integrator<S>,
    mut phase: Phase<S::Coordinates>,
    h: f64,
    steps: usize,
) -> f64 {
    for _ in 0..steps {
        method.step(system, &mut phase, h).unwrap();
    }
    phase.q.as_ref()[0]
}

fn double<I: Integrator<EulerLagrange<DoublePendulum, 2>>>(
    method: impl FnOnce(&EulerLagrange<DoublePendulum, 2>) -> I,
    steps: usize,
) -> f64 {
    let system = EulerLagrange::new(DoublePendulum);
    let method = method(&system);
    run(&system, method, Phase::new(0.0, [0.5, -0.25], [0.0, 0.5]), 0.01, steps)
}

fn rattle(steps: usize) -> f64 {
    let rattle = Rattle::new(Constraints::<_, 4, 2>::new(Bobs));
    let ((s, c), (t, d)) = (0.5_f64.sin_cos(), (-0.25_f64).sin_cos());
    let phase = Phase::new(0.0, [s, -c, s + 0.5 * t, -c - 0.5 * d], [0.0; 4]);
    run(&EulerLagrange::<_, 4>::new(Bobs), rattle, phase, 0.01, steps)
}

fn chain<I: Integrator<SlicedEulerLagrange<Chain>>>(
    method: impl FnOnce(&SlicedEulerLagrange<Chain>) -> I,
    steps: usize,
) -> f64 {
    let system = SlicedEulerLagrange::new(Chain(20));
    let method = method(&system);
    let q = (0..20).map(|i| (f64::from(i)).sin()).collect();
    run(&system, method, Phase::new(0.0, q, vec![0.0; 20]), 0.05, steps)
}

fn acceleration(steps: usize) -> f64 {
    let system = SlicedEulerLagrange::new(Chain(20));
    let q: Vec<f64> = (0..20).map(|i| (f64::from(i)).sin()).collect();
    let (v, mut a) = (vec![0.0; 20], vec![0.0; 20]);
    let mut sum = 0.0;
    for _ in 0..steps {
        system.acceleration(0.0, black_box(&q), &v, &mut a).unwrap();
        sum += a[0];
    }
    sum
}

type Case = (&'static str, usize, fn(usize) -> f64);

const CASES: [Case; 22] = [
    ("runge-kutta-4", 5000, |n| double(RungeKutta4::new, n)),
    ("dormand-prince", 2000, |n| double(DormandPrince853::new, n)),
    ("adams-14-pece", 5000, |n| double(AdamsBashforthMoulton::<13, _>::new, n)),
    ("midpoint", 5000, |n| double(|_| DiscreteEulerLagrange::midpoint(), n)),
    ("trapezoidal", 5000, |n| double(|_| DiscreteEulerLagrange::trapezoidal(), n)),
    ("gauss-legendre-4", 5000, |n| double(|_| GaussLegendre::<2, _>::new(), n)),
    ("gauss-legendre-6", 2000, |n| double(|_| GaussLegendre::<3, _>::new(), n)),
    ("gauss-legendre-8", 2000, |n| double(|_| GaussLegendre::<4, _>::new(), n)),
    ("gauss-legendre-12", 1000, |n| double(|_| GaussLegendre::<6, _>::new(), n)),
    ("implicit-euler", 2000, |n| double(|_| ImplicitEuler::new(), n)),
    ("bdf2", 2000, |n| double(|_| Bdf2::new(), n)),
    ("rattle", 2000, rattle),
    ("chain-acceleration", 500, acceleration),
    ("chain-verlet", 500, |n| chain(StormerVerlet::new, n)),
    ("chain-runge-kutta-4", 200, |n| chain(RungeKutta4::new, n)),
    ("chain-adams-11-pec", 500, |n| {
        chain(|s| AdamsBashforthMoulton::<10, _>::new(s).with_evaluations(Evaluations::One), n)
    }),
    ("chain-midpoint", 100, |n| chain(|_| DiscreteEulerLagrange::midpoint(), n)),
    ("chain-gauss-legendre-4", 100, |n| chain(|_| GaussLegendre::<2, _>::new(), n)),
    ("chain-gauss-legendre-6", 50, |n| chain(|_| GaussLegendre::<3, _>::new(), n)),
    ("chain-gauss-legendre-12", 20, |n| chain(|_| GaussLegendre::<6, _>::new(), n)),
    ("chain-implicit-euler", 50, |n| chain(|_| ImplicitEuler::new(), n)),
    ("chain-bdf2", 50, |n| chain(|_| Bdf2::new(), n)),
];

/// Nanoseconds of a multiply-add that waits for the one before.
fn calibration() -> f64 {
    let start = Instant::now();
    let mut x = black_box(0.5_f64);
    for _ in 0..100_000 {
        x = x * 0.999 + 0.001;
    }
    black_box(x);
    start.elapsed().as_secs_f64() * 1e4
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with("--")).collect();
    if let [name, steps] = &args[..] {
        let case = CASES.iter().find(|case| case.0 == name).unwrap();
        println!("{}", case.2(steps.parse().unwrap()));
        return;
    }
    let (mut times, mut machine) = (vec![Vec::new(); CASES.len()], Vec::new());
    for _ in 0..REPEATS {
        machine.push(calibration());
        for (case, times) in CASES.iter().zip(&mut times) {
            let start = Instant::now();
            black_box(case.2(black_box(case.1)));
            times.push(start.elapsed().as_secs_f64() * 1e9 / case.1 as f64);
        }
    }
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    println!("a multiply-add takes {:.2} ns", median(&mut machine));
    for (case, times) in CASES.iter().zip(&mut times) {
        println!("{:24} {:10.0} ns a step", case.0, median(times));
    }
}
