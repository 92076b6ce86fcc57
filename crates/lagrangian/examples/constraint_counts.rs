//! Instructions of constrained steps, for callgrind: `constraint_counts pendulum|double|polar|chain [steps] [links]`.
#![allow(clippy::print_stdout)]

use lagrangian::constraint::{Constraints, Holonomic, Rattle, SlicedConstraints, SlicedHolonomic};
use lagrangian::integrator::Integrator;
use lagrangian::{EulerLagrange, Lagrangian, Phase, SlicedEulerLagrange, SlicedLagrangian};
use mechanics_core::scalar::Scalar;

struct Particle;
impl Lagrangian<2> for Particle {
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[1].scale(9.81)
    }
}
struct Rod;
impl Holonomic<2, 1> for Rod {
    fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 1] {
        [(q[0].square() + q[1].square()).offset(-1.0).scale(0.5)]
    }
}
struct Masses(usize);
impl SlicedLagrangian for Masses {
    fn dimension(&self) -> usize {
        2 * self.0
    }
    fn kinetic<S: Scalar>(&self, _: &[S], v: &[S], _: S) -> S {
        v.iter().fold(S::constant(0.0), |sum, v| sum + v.square()).scale(0.05)
    }
    fn potential<S: Scalar>(&self, q: &[S], _: S) -> S {
        q.iter().skip(1).step_by(2).fold(S::constant(0.0), |sum, y| sum + *y).scale(0.981)
    }
}
struct Rods(usize);
impl SlicedHolonomic for Rods {
    fn dimension(&self) -> usize {
        2 * self.0
    }
    fn count(&self) -> usize {
        self.0
    }
    fn constraint_into<S: Scalar>(&self, q: &[S], _: S, phi: &mut [S]) {
        let zero = S::constant(0.0);
        for (k, phi) in phi.iter_mut().enumerate() {
            let (x0, y0) = if k == 0 { (zero, zero) } else { (q[2 * k - 2], q[2 * k - 1]) };
            let square = (q[2 * k] - x0).square() + (q[2 * k + 1] - y0).square();
            *phi = square.offset(-0.0025).scale(0.5);
        }
    }
}

fn main() {
    let mut args = std::env::args().skip(1);
    let what = args.next().unwrap_or_default();
    let mut number = |default| args.next().and_then(|x| x.parse().ok()).unwrap_or(default);
    let (steps, links): (usize, usize) = (number(1000), number(20));
    let mut iterations = 0;
    let clock = std::time::Instant::now();
    if what == "chain" {
        let system = SlicedEulerLagrange::new(Masses(links));
        let q = (0..2 * links).map(|i| if i % 2 == 0 { 0.05 * (i / 2 + 1) as f64 } else { 0.0 }).collect();
        let mut phase = Phase::new(0.0, q, vec![0.0; 2 * links]);
        let mut rattle = Rattle::new(SlicedConstraints::new(Rods(links)));
        for _ in 0..steps {
            iterations += rattle.step(&system, &mut phase, 2e-4).expect("a step").iterations;
        }
    } else {
        let system = EulerLagrange::new(Particle);
        let mut phase = Phase::new(0.0, [0.6, -0.8], [0.8, 0.6]);
        let mut rattle = Rattle::new(Constraints::new(Rod));
        for _ in 0..steps {
            iterations += rattle.step(&system, &mut phase, 0.01).expect("a step").iterations;
        }
    }
    let each = clock.elapsed().as_secs_f64() / steps as f64;
    println!("{what}: {:.1} ns a step, {} expansions of φ in {steps} steps", 1e9 * each, iterations);
}
