//! Observed orders, sums without loss, times without drift.

use crate::systems::{
    DoublePendulum, Duffing, Fixture, HenonHeiles, Kepler, Oscillator, Pendulum, SpringChain, energy, of,
};
use lagrangian::integrator::{DormandPrince853, Integrator, Outcome, RungeKutta4, StormerVerlet, drive};
use lagrangian::{EulerLagrange, Lagrangian, Phase, System};
use std::ops::ControlFlow;

/// The error at the end of a fixture with `steps` steps in all.
fn error_with<const N: usize, L: Lagrangian<N>, I: Integrator<EulerLagrange<L, N>>>(
    system: &EulerLagrange<L, N>,
    mut method: I,
    fixture: &Fixture<N>,
    last: usize,
    steps: u32,
) -> f64 {
    let mut phase = fixture.start();
    let end = fixture.times[last];
    let h = (end - phase.time) / f64::from(steps);
    let report = drive::integrate(system, &mut method, &mut phase, end, h).unwrap();
    assert_eq!(report.steps, u64::from(steps));
    fixture.error(last, &phase)
}

/// The order between numbers of steps that double, from the best pair of errors well above rounding.
fn observed_orders(steps: &[u32], error: impl Fn(u32) -> f64) -> Vec<f64> {
    let errors: Vec<f64> = steps.iter().map(|&n| error(n)).collect();
    errors
        .windows(2)
        .zip(steps.windows(2))
        .map(|(e, n)| (e[0] / e[1]).ln() / (f64::from(n[1]) / f64::from(n[0])).ln())
        .collect()
}

#[track_caller]
fn assert_order(orders: &[f64], expected: f64, within: f64) {
    assert!(
        orders.iter().all(|order| (order - expected).abs() <= within),
        "observed orders {orders:?}, expected {expected} ± {within}"
    );
}

macro_rules! orders {
    ($name:ident, $method:ident, $order:expr, $within:expr, $($lagrangian:expr, $fixture:expr, $last:expr, $steps:expr;)*) => {
        #[test]
        fn $name() {
            $({
                let (system, fixture) = (of($lagrangian), Fixture::read($fixture));
                let orders = observed_orders(&$steps, |n| {
                    error_with(&system, $method::new(&system), &fixture, $last, n)
                });
                println!("{}: {orders:.3?}", $fixture);
                assert_order(&orders, $order, $within);
            })*
        }
    };
}

orders! { runge_kutta_has_order_four, RungeKutta4, 4.0, 0.15,
    Pendulum, "pendulum_large", 1, [200, 400, 800];
    DoublePendulum, "double_pendulum_regular", 3, [2000, 4000, 8000];
    Kepler, "kepler_e06", 5, [4000, 8000, 16000];
    HenonHeiles, "henon_heiles_regular", 4, [800, 1600, 3200];
    Duffing, "duffing", 4, [400, 800, 1600];
}

orders! { stormer_verlet_has_order_two, StormerVerlet, 2.0, 0.15,
    Pendulum, "pendulum_large", 5, [1600, 3200, 6400];
    Kepler, "kepler_e06", 5, [8000, 16000, 32000];
    HenonHeiles, "henon_heiles_regular", 4, [800, 1600, 3200];
}

orders! { dormand_prince_has_order_eight, DormandPrince853, 8.0, 0.5,
    HenonHeiles, "henon_heiles_regular", 10, [120, 160, 200];
    Duffing, "duffing", 10, [80, 100, 120];
}

// The terms of order 8 do not add up over the swings of these; what does is of order 9.
orders! { dormand_prince_gains_an_order_on_pendulums, DormandPrince853, 9.0, 0.15,
    Pendulum, "pendulum_large", 20, [240, 320, 400];
    DoublePendulum, "double_pendulum_regular", 20, [600, 800, 1000];
}

#[test]
fn increments_are_added_without_loss() {
    // Errors of the method are below 1e-17 here, so what is left is rounding: a plain sum of 128,000 increments loses
    // 3e-14 and more.
    let system = of(Oscillator(1.0));
    let mut method = DormandPrince853::new(&system);
    let mut phase = Phase::new(0.0, [1.0], [0.0]);
    drive::integrate(&system, &mut method, &mut phase, 1000.0, 1.0 / 128.0).unwrap();
    let error = (phase.q[0] - 1000_f64.cos()).abs().max((phase.v[0] + 1000_f64.sin()).abs());
    assert!(error < 2e-15, "{error:e}");
}

#[test]
fn time_is_rounded_once() {
    let system = of(Oscillator(1.0));
    let mut method = RungeKutta4::new(&system);
    let mut phase = Phase::new(0.7, [1.0], [0.0]);
    let mut n = 0;
    drive::advance(&system, &mut method, &mut phase, 0.1, 100_000, |phase, _| {
        n += 1;
        assert_eq!(phase.time, 0.7 + f64::from(n) * 0.1);
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(n, 100_000);
}

#[test]
fn a_driven_run_keeps_its_remainders_and_equals_itself() {
    // Drivers set the time; the methods must not take that for a new start.
    let system = of(SpringChain);
    let start = Phase::new(0.3, [0.5, -0.2, 0.1], [0.0, 1.0, -0.3]);
    let mut whole = start.clone();
    drive::integrate(&system, &mut StormerVerlet::new(&system), &mut whole, 10.3, 0.01).unwrap();
    let (mut method, mut parts) = (StormerVerlet::new(&system), start.clone());
    let mut evaluations = 0;
    for k in 1..=10 {
        let report =
            drive::advance(&system, &mut method, &mut parts, 0.01, 100, |_, _| ControlFlow::Continue(()))
                .unwrap();
        evaluations += report.work.evaluations;
        parts.time = 0.3 + f64::from(k);
    }
    assert_eq!((whole.q, whole.v), (parts.q, parts.v));
    assert_eq!(evaluations, 1001, "one evaluation a step and one to start");
}

#[test]
fn a_new_start_forgets() {
    // The same integrator, sent to another state and back, does what a new one does.
    let system = of(HenonHeiles);
    let (a, b) = (Phase::new(0.0, [0.0, 0.1], [0.35, 0.1]), Phase::new(3.0, [0.1, 0.1], [0.2, -0.1]));
    let mut used = StormerVerlet::new(&system);
    for phase in [&a, &b] {
        drive::integrate(&system, &mut used, &mut phase.clone(), phase.time + 5.0, 0.05).unwrap();
    }
    let (mut again, mut fresh) = (a.clone(), a.clone());
    drive::integrate(&system, &mut used, &mut again, 5.0, 0.05).unwrap();
    drive::integrate(&system, &mut StormerVerlet::new(&system), &mut fresh, 5.0, 0.05).unwrap();
    assert_eq!(again, fresh);
}

#[test]
fn samples_are_at_their_times() {
    let (system, fixture) = (of(HenonHeiles), Fixture::read("henon_heiles_regular"));
    let mut phase = fixture.start();
    let (trajectory, report) =
        drive::sample(&system, &mut DormandPrince853::new(&system), &mut phase, &fixture.times, 0.05)
            .unwrap();
    assert_eq!(trajectory.times, fixture.times);
    assert_eq!(trajectory.len(), 21);
    assert_eq!(report.steps, 2000);
    for (index, phase) in trajectory.phases().enumerate() {
        assert!(fixture.error(index, &phase) <= 1e-12 * fixture.scale());
    }
    assert_eq!(trajectory.phase(20), phase);
}

#[test]
fn an_interval_is_divided_evenly() {
    let system = of(Oscillator(1.0));
    let run = |end: f64, h: f64| {
        let mut phase = Phase::new(0.0, [1.0], [0.0]);
        let report = drive::integrate(&system, &mut RungeKutta4::new(&system), &mut phase, end, h).unwrap();
        assert_eq!(phase.time, end);
        report.steps
    };
    // 0.1 does not divide 1 exactly in binary, but does up to rounding.
    assert_eq!(run(1.0, 0.1), 10);
    assert_eq!(run(1.0, 0.3), 4);
    assert_eq!(run(1.0, 5.0), 1);
    assert_eq!(run(0.0, 0.1), 0);
}

#[test]
fn the_observer_can_stop() {
    let system = of(Pendulum);
    let mut phase = Phase::new(0.0, [1.0], [0.0]);
    let report =
        drive::advance(&system, &mut RungeKutta4::new(&system), &mut phase, 0.01, 1000, |phase, _| {
            if phase.q[0] < 0.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .unwrap();
    assert_eq!(report.outcome, Outcome::Stopped);
    // A quarter of the period 2.139 s of this amplitude.
    assert_eq!(report.steps, 54);
    assert_eq!(phase.time, 0.54);
    assert_eq!(report.to_string(), "54 steps, 216 evaluations, stopped by the observer");
}

/// The energy errors of the largest magnitude in the first and last tenth of a run.
fn energy_errors<S: System, I: Integrator<S>>(
    system: &S,
    mut method: I,
    mut phase: Phase<S::Coordinates>,
    h: f64,
    steps: u64,
) -> (f64, f64) {
    let start = energy(system, &phase);
    let (mut n, mut first, mut last) = (0, 0.0_f64, 0.0_f64);
    drive::advance(system, &mut method, &mut phase, h, steps, |phase, _| {
        n += 1;
        if n <= steps / 10 || n > steps - steps / 10 {
            let error = (energy(system, phase) - start).abs();
            let most = if n <= steps / 10 { &mut first } else { &mut last };
            *most = most.max(error);
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    (first, last)
}

#[test]
fn energy_drifts_with_runge_kutta() {
    // A million steps of 0.01 s, the run in which symplectic methods stay bounded: the drift is linear, so the last
    // tenth's is ten times the first's.
    let system = of(DoublePendulum);
    let start = Phase::new(0.0, [0.5, -0.25], [0.0, 0.5]);
    let (first, last) = energy_errors(&system, RungeKutta4::new(&system), start, 0.01, 1_000_000);
    println!("RK4 double pendulum: first tenth {first:e}, last tenth {last:e}");
    assert!(last > 5.0 * first && last > 1e-3, "first tenth {first:e}, last tenth {last:e}");
}

#[test]
fn energy_is_bounded_with_stormer_verlet() {
    let bounded = |name: &str, (first, last): (f64, f64)| {
        println!("Verlet {name}: first tenth {first:e}, last tenth {last:e}");
        assert!((last / first - 1.0).abs() <= 0.05, "{name}: first tenth {first:e}, last tenth {last:e}");
    };
    let system = of(Pendulum);
    let start = Phase::new(0.0, [2.0], [0.0]);
    bounded("pendulum", energy_errors(&system, StormerVerlet::new(&system), start, 0.01, 1_000_000));
    let system = of(HenonHeiles);
    let start = Phase::new(0.0, [0.0, 0.1], [0.35, 0.1]);
    bounded("Hénon–Heiles", energy_errors(&system, StormerVerlet::new(&system), start, 0.01, 1_000_000));
    let system = of(SpringChain);
    let start = Phase::new(0.0, [0.1, -0.2, 0.1], [0.0, 0.1, -0.3]);
    bounded("spring chain", energy_errors(&system, StormerVerlet::new(&system), start, 0.01, 1_000_000));
    let system = of(Kepler);
    let start = Phase::new(0.0, [0.4, 0.0], [0.0, 2.0]);
    bounded("Kepler", energy_errors(&system, StormerVerlet::new(&system), start, 0.01, 1_000_000));
}
