//! Cost of constrained steps: the Cartesian pendulum against the same method written by hand for it, a double
//! pendulum, and chains of growing length.
//!
//! `cargo bench -p lagrangian --no-default-features --bench constraints`; with arguments `CASE STEPS` it runs one case
//! once, for counting instructions.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark prints")]

use lagrangian::constraint::{
    Composition, ConstraintSet, Constraints, Holonomic, Rattle, SlicedConstraints, SlicedHolonomic,
};
use lagrangian::integrator::Integrator;
use lagrangian::{EulerLagrange, Lagrangian, Phase, SlicedEulerLagrange, SlicedLagrangian, System};
use mechanics_core::scalar::Scalar;
use std::hint::black_box;
use std::time::Instant;

const G: f64 = 9.81;
const REPEATS: usize = 21;

/// `MASSES` masses in the plane.
struct Fixed;
impl<const N: usize> Lagrangian<N> for Fixed {
    fn kinetic<S: Scalar>(&self, _: &[S; N], v: &[S; N], _: S) -> S {
        v.iter().fold(S::constant(0.0), |sum, v| sum + v.square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; N], _: S) -> S {
        q.iter().skip(1).step_by(2).fold(S::constant(0.0), |sum, y| sum + *y).scale(G)
    }
}

/// Rods of one metre, from the origin on.
struct Rods;
impl Rods {
    fn square<S: Scalar>(q: &[S], k: usize) -> S {
        let zero = S::constant(0.0);
        let (x, y) = if k == 0 { (zero, zero) } else { (q[2 * k - 2], q[2 * k - 1]) };
        ((q[2 * k] - x).square() + (q[2 * k + 1] - y).square()).offset(-1.0).scale(0.5)
    }
}
impl Holonomic<2, 1> for Rods {
    fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 1] {
        [(q[0].square() + q[1].square()).offset(-1.0).scale(0.5)]
    }
}
impl Holonomic<4, 2> for Rods {
    fn constraint<S: Scalar>(&self, q: &[S; 4], _: S) -> [S; 2] {
        [Self::square(q, 0), Self::square(q, 1)]
    }
}

/// As many masses on rods.
struct Chain(usize);
impl SlicedLagrangian for Chain {
    fn dimension(&self) -> usize {
        2 * self.0
    }
    fn kinetic<S: Scalar>(&self, _: &[S], v: &[S], _: S) -> S {
        v.iter().fold(S::constant(0.0), |sum, v| sum + v.square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S], _: S) -> S {
        q.iter().skip(1).step_by(2).fold(S::constant(0.0), |sum, y| sum + *y).scale(G)
    }
}
impl SlicedHolonomic for Chain {
    fn dimension(&self) -> usize {
        2 * self.0
    }
    fn count(&self) -> usize {
        self.0
    }
    fn constraint_into<S: Scalar>(&self, q: &[S], _: S, phi: &mut [S]) {
        (0..self.0).for_each(|k| phi[k] = Rods::square(q, k));
    }
}

/// Andersen's step for the pendulum with every formula by hand.
fn by_hand(steps: usize) -> f64 {
    let ([mut x, mut y], [mut u, mut w], h) = ([0.6f64, -0.8f64], [0.8f64, 0.6f64], 0.01);
    let mut lambda = 0.0;
    for _ in 0..steps {
        let (x0, y0, w0) = (x, y, w - 0.5 * h * G);
        let mut mu = 0.5 * h * lambda;
        loop {
            (x, y) = (x0 + h * (u + mu * x0), y0 + h * (w0 + mu * y0));
            let phi = 0.5 * (x * x + y * y - 1.0);
            if phi.abs() <= 1e-15 {
                break;
            }
            mu -= phi / (h * (x * x0 + y * y0));
        }
        (u, w) = (u + mu * x0, w0 + mu * y0 - 0.5 * h * G);
        let end = -(x * u + y * w) / (x * x + y * y);
        (u, w) = (u + end * x, w + end * y);
        lambda = 2.0 * mu / h;
    }
    x + u
}

fn run<S: System, C: ConstraintSet<Coordinates = S::Coordinates>>(
    system: &S,
    mut rattle: Rattle<C>,
    mut phase: Phase<S::Coordinates>,
    steps: usize,
) -> f64 {
    for _ in 0..steps {
        rattle.step(system, &mut phase, 0.01).unwrap();
    }
    phase.q.as_ref()[0]
}

fn pendulum(composition: Composition, steps: usize) -> f64 {
    let rattle = Rattle::composed(Constraints::<_, 2, 1>::new(Rods), composition);
    run(&EulerLagrange::<_, 2>::new(Fixed), rattle, Phase::new(0.0, [0.6, -0.8], [0.8, 0.6]), steps)
}

fn double(steps: usize) -> f64 {
    let rattle = Rattle::new(Constraints::<_, 4, 2>::new(Rods));
    let phase = Phase::new(0.0, [0.6, -0.8, 0.6, -1.8], [0.0; 4]);
    run(&EulerLagrange::<_, 4>::new(Fixed), rattle, phase, steps)
}

/// A chain hanging from a slope of 3:4, swinging.
fn chain(links: usize, steps: usize) -> f64 {
    let q = (0..2 * links).map(|i| [0.6, -0.8][i % 2] * (i / 2 + 1) as f64).collect();
    let rattle = Rattle::new(SlicedConstraints::new(Chain(links)));
    run(&SlicedEulerLagrange::new(Chain(links)), rattle, Phase::new(0.0, q, vec![0.0; 2 * links]), steps)
}

type Case = (&'static str, usize, fn(usize) -> f64);

const CASES: [Case; 7] = [
    ("pendulum-by-hand", 20_000, by_hand),
    ("pendulum", 20_000, |steps| pendulum(Composition::Second, steps)),
    ("pendulum-order-4", 4_000, |steps| pendulum(Composition::Fourth, steps)),
    ("double", 10_000, double),
    ("chain-10", 200, |steps| chain(10, steps)),
    ("chain-20", 100, |steps| chain(20, steps)),
    ("chain-40", 30, |steps| chain(40, steps)),
];

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with("--")).collect();
    if let [name, steps] = &args[..] {
        let case = CASES.iter().find(|case| case.0 == name).unwrap();
        println!("{}", case.2(steps.parse().unwrap()));
        return;
    }
    let mut times = vec![Vec::new(); CASES.len()];
    for _ in 0..REPEATS {
        for (case, times) in CASES.iter().zip(&mut times) {
            let start = Instant::now();
            black_box(case.2(black_box(case.1)));
            times.push(start.elapsed().as_secs_f64() * 1e9 / case.1 as f64);
        }
    }
    let medians: Vec<f64> = times
        .iter_mut()
        .map(|times| {
            times.sort_by(f64::total_cmp);
            times[REPEATS / 2]
        })
        .collect();
    for (case, median) in CASES.iter().zip(&medians) {
        println!("{:18} {median:10.1} ns a step {:8.2} of the pendulum by hand", case.0, median / medians[0]);
    }
}
