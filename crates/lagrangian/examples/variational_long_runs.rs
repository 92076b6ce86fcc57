//! Long runs of the variational integrators: energy of a regular double pendulum over 1e6 steps of 0.01 s, angular
//! momentum of a Kepler orbit with e = 0.9 over as many orbits as the first argument says (1000; 100000 take minutes).
//!
//! `cargo run --release -p lagrangian --no-default-features --example variational_long_runs -- 100000`
#![allow(clippy::print_stdout)]

use lagrangian::integrator::{DiscreteEulerLagrange, GaussLegendre, Integrator};
use lagrangian::{EulerLagrange, Lagrangian, LagrangianError, Phase, System};
use mechanics_core::scalar::Scalar;
use std::time::Instant;

/// Rods of 1 and ½ m, masses of 2 and 1 kg, absolute angles.
struct DoublePendulum;

impl Lagrangian<2> for DoublePendulum {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _: S) -> S {
        v[0].square().scale(1.5) + v[1].square().scale(0.125) + (v[0] * v[1] * (q[0] - q[1]).cos()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[0].cos().scale(-3.0 * 9.81) + q[1].cos().scale(-0.5 * 9.81)
    }
}

struct Kepler;

impl Lagrangian<2> for Kepler {
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        -(q[0].square() + q[1].square()).sqrt().recip()
    }
}

fn energy(mut integrator: impl Integrator<EulerLagrange<DoublePendulum, 2>>) -> Result<(), LagrangianError> {
    const STEPS: usize = 1_000_000;
    let system = EulerLagrange::new(DoublePendulum);
    let mut phase = Phase::new(0.0, [0.5, -0.25], [0.0, 0.5]);
    let begin = system.energy(phase.time, &phase.q, &phase.v);
    let (mut worst, mut iterations, clock) = ([0.0_f64; 10], 0, Instant::now());
    for step in 0..STEPS {
        iterations += integrator.step(&system, &mut phase, 0.01)?.iterations;
        let error = (system.energy(phase.time, &phase.q, &phase.v) / begin - 1.0).abs();
        let tenth = &mut worst[10 * step / STEPS];
        *tenth = tenth.max(error);
    }
    let microseconds = clock.elapsed().as_secs_f64();
    println!(
        "{:36} energy, first tenth {:.2e}, last {:.2e}; {:.2} iterations and {microseconds:.2} µs a step",
        integrator.method().name,
        worst[0],
        worst[9],
        iterations as f64 / STEPS as f64,
    );
    Ok(())
}

fn angular_momentum(
    mut integrator: impl Integrator<EulerLagrange<Kepler, 2>>,
    orbits: usize,
    steps_per_orbit: usize,
) -> Result<(), LagrangianError> {
    let system = EulerLagrange::new(Kepler);
    let mut phase = Phase::new(0.0, [0.1, 0.0], [0.0, 19.0_f64.sqrt()]);
    let angular = |phase: &Phase<[f64; 2]>| phase.q[0] * phase.v[1] - phase.q[1] * phase.v[0];
    let (begin, h) = (angular(&phase), std::f64::consts::TAU / steps_per_orbit as f64);
    let (mut worst, clock) = (0.0_f64, Instant::now());
    for _ in 0..orbits * steps_per_orbit {
        integrator.step(&system, &mut phase, h)?;
        worst = worst.max((angular(&phase) / begin - 1.0).abs());
    }
    println!(
        "{:36} angular momentum over {orbits} orbits of {steps_per_orbit} steps: {worst:.2e}; {:.1} s",
        integrator.method().name,
        clock.elapsed().as_secs_f64(),
    );
    Ok(())
}

/// The orbits first, all at once.
fn main() -> Result<(), LagrangianError> {
    let orbits = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(1000);
    std::thread::scope(|scope| {
        let runs = [
            scope.spawn(move || angular_momentum(DiscreteEulerLagrange::midpoint(), orbits, 500)),
            scope.spawn(move || angular_momentum(GaussLegendre::<2, _>::new(), orbits, 200)),
            scope.spawn(move || angular_momentum(GaussLegendre::<6, _>::new(), orbits, 80)),
        ];
        runs.into_iter()
            .try_for_each(|run| run.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })?;
    energy(DiscreteEulerLagrange::midpoint())?;
    energy(DiscreteEulerLagrange::trapezoidal())?;
    energy(GaussLegendre::<2, _>::new())?;
    energy(GaussLegendre::<3, _>::new())?;
    energy(GaussLegendre::<4, _>::new())?;
    energy(GaussLegendre::<6, _>::new())
}
