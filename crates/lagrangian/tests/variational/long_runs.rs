//! Energy over a million steps, angular momentum over many orbits.

use crate::systems::{Kepler, REGULAR, reference, system};
use lagrangian::integrator::{DiscreteEulerLagrange, GaussLegendre, Integrator};
use lagrangian::{EulerLagrange, Phase, System};

/// The largest relative energy error in the first and in the last tenth of `steps` steps of 0.01 s.
fn energy_errors<I>(mut integrator: I, steps: usize) -> [f64; 2]
where
    I: Integrator<EulerLagrange<crate::systems::DoublePendulum, 2>>,
{
    let system = system(REGULAR);
    let mut phase = reference("double_pendulum_regular").start::<2>();
    let energy = |phase: &Phase<[f64; 2]>| system.energy(phase.time, &phase.q, &phase.v);
    let start = energy(&phase);
    let mut worst = [0.0_f64; 2];
    for step in 0..steps {
        integrator.step(&system, &mut phase, 0.01).unwrap();
        if step < steps / 10 || step >= steps - steps / 10 {
            let error = (energy(&phase) / start - 1.0).abs();
            let tenth = usize::from(step >= steps / 10);
            worst[tenth] = worst[tenth].max(error);
        }
    }
    worst
}

fn check_bounded(name: &str, [first, last]: [f64; 2]) {
    let even = (last / first - 1.0).abs() <= 0.05;
    assert!(even || (first <= 1e-12 && last <= 1e-12), "{name}: {first:e}, later {last:e}");
}

#[test]
fn energy_is_bounded_over_a_million_steps_of_second_order() {
    check_bounded("midpoint", energy_errors(DiscreteEulerLagrange::midpoint(), 1_000_000));
    check_bounded("trapezoidal", energy_errors(DiscreteEulerLagrange::trapezoidal(), 1_000_000));
}

#[test]
fn energy_is_bounded_over_a_million_steps_of_gauss_legendre() {
    check_bounded("Gauss–Legendre 4", energy_errors(GaussLegendre::<2, _>::new(), 1_000_000));
    check_bounded("Gauss–Legendre 6", energy_errors(GaussLegendre::<3, _>::new(), 1_000_000));
    check_bounded("Gauss–Legendre 8", energy_errors(GaussLegendre::<4, _>::new(), 1_000_000));
    check_bounded("Gauss–Legendre 12", energy_errors(GaussLegendre::<6, _>::new(), 1_000_000));
}

/// e = 0.9: the angular momentum is quadratic in (q, p). The example `variational_long_runs` goes on to 1e5 orbits.
#[test]
fn angular_momentum_of_an_eccentric_orbit_is_kept() {
    fn check(mut integrator: impl Integrator<EulerLagrange<Kepler, 2>>, steps_per_orbit: usize) {
        let system = system(Kepler);
        let mut phase = Phase::new(0.0, [0.1, 0.0], [0.0, 19.0_f64.sqrt()]);
        let angular = |phase: &Phase<[f64; 2]>| phase.q[0] * phase.v[1] - phase.q[1] * phase.v[0];
        let (start, h) = (angular(&phase), std::f64::consts::TAU / steps_per_orbit as f64);
        let mut worst = 0.0_f64;
        for _ in 0..200 * steps_per_orbit {
            integrator.step(&system, &mut phase, h).unwrap();
            worst = worst.max((angular(&phase) / start - 1.0).abs());
        }
        assert!(worst < 1e-12, "{}: {worst:e}", integrator.method().name);
    }
    check(DiscreteEulerLagrange::midpoint(), 1000);
    check(GaussLegendre::<2, _>::new(), 400);
    check(GaussLegendre::<6, _>::new(), 200);
}
