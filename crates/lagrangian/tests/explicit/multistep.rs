//! The Adams methods: order, exactness, stability as documented, history.

use crate::systems::{DoublePendulum, Duffing, Fixture, HenonHeiles, Oscillator, of};
use lagrangian::integrator::{AdamsBashforthMoulton, Evaluations, Integrator, drive};
use lagrangian::{
    Curvature, EulerLagrange, Expansion, Lagrangian, LagrangianError, Phase, SlicedEulerLagrange,
    SlicedLagrangian, System, system::Dependence,
};
use mechanics_core::scalar::Scalar;
use std::sync::atomic::{AtomicBool, Ordering};

fn error_with<const STEPS: usize, const N: usize, L: Lagrangian<N>>(
    system: &EulerLagrange<L, N>,
    fixture: &Fixture<N>,
    evaluations: Evaluations,
    last: usize,
    steps: u32,
) -> f64 {
    let mut method = AdamsBashforthMoulton::<STEPS, _>::new(system).with_evaluations(evaluations);
    let mut phase = fixture.start();
    let end = fixture.times[last];
    let h = (end - phase.time) / f64::from(steps);
    drive::integrate(system, &mut method, &mut phase, end, h).unwrap();
    fixture.error(last, &phase)
}

macro_rules! check_order {
    ($k:expr, $evaluations:expr, $lagrangian:expr, $fixture:expr, $last:expr, $steps:expr) => {{
        let (system, fixture) = (of($lagrangian), Fixture::read($fixture));
        let [coarse, fine] = $steps;
        let error = |n| error_with::<$k, _, _>(&system, &fixture, $evaluations, $last, n);
        let order = (error(coarse) / error(fine)).ln() / (f64::from(fine) / f64::from(coarse)).ln();
        println!("{} order {}: {order:.2}, {:e} {:e}", $fixture, $k + 1, error(coarse), error(fine));
        assert!((order - f64::from($k + 1)).abs() <= 0.5, "{}: {order}, expected {}", $fixture, $k + 1);
    }};
}

#[test]
fn errors_fall_with_the_order() {
    use Evaluations::{One, Two};
    check_order!(3, One, HenonHeiles, "henon_heiles_regular", 4, [1600, 3200]);
    check_order!(3, Two, HenonHeiles, "henon_heiles_regular", 4, [1600, 3200]);
    check_order!(7, One, HenonHeiles, "henon_heiles_regular", 10, [300, 400]);
    check_order!(7, Two, HenonHeiles, "henon_heiles_regular", 10, [300, 600]);
    check_order!(9, One, HenonHeiles, "henon_heiles_regular", 10, [400, 800]);
    check_order!(9, Two, HenonHeiles, "henon_heiles_regular", 10, [400, 1100]);
    check_order!(11, Two, HenonHeiles, "henon_heiles_regular", 10, [300, 1100]);
    check_order!(3, Two, Duffing, "duffing", 4, [800, 1600]);
    check_order!(7, Two, Duffing, "duffing", 10, [800, 1500]);
    check_order!(9, Two, Duffing, "duffing", 10, [400, 600]);
    check_order!(9, Two, DoublePendulum, "double_pendulum_regular", 20, [2000, 3600]);
    check_order!(11, Two, DoublePendulum, "double_pendulum_regular", 20, [2700, 5000]);
    check_order!(13, Two, DoublePendulum, "double_pendulum_regular", 20, [3600, 5000]);
}

#[test]
fn the_double_pendulum_is_followed_to_rounding() {
    let (system, fixture) = (of(DoublePendulum), Fixture::read("double_pendulum_regular"));
    let last = fixture.times.len() - 1;
    let error = |evaluations, steps| error_with::<13, _, _>(&system, &fixture, evaluations, last, steps);
    let twice = error(Evaluations::Two, 5000);
    let once = error_with::<10, _, _>(&system, &fixture, Evaluations::One, last, 10_000);
    println!("order 14, twice: {twice:e}; order 11, once: {once:e}");
    assert!(twice <= 1e-13 && once <= 1e-13, "{twice:e} {once:e}");
}

/// q̈ = (k + 1)(k + 2) tᵏ, so that q = t^(k + 2).
struct Power(i32);

impl Lagrangian<1> for Power {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, _q: &[S; 1], _t: S) -> S {
        S::constant(0.0)
    }
    fn force<S: Scalar>(&self, _q: &[S; 1], _v: &[S; 1], t: S) -> [S; 1] {
        [t.powi(self.0).scale(f64::from((self.0 + 1) * (self.0 + 2)))]
    }
}

/// The relative errors of q and v at t = 2 where the acceleration is tᵏ, started at t = 1 with steps of 1/32.
fn power_error<const STEPS: usize>(power: i32) -> f64 {
    let system = of(Power(power));
    let mut method = AdamsBashforthMoulton::<STEPS, _>::new(&system);
    let mut phase = Phase::new(1.0, [1.0], [f64::from(power + 2)]);
    drive::integrate(&system, &mut method, &mut phase, 2.0, 1.0 / 32.0).unwrap();
    let exact = [2_f64.powi(power + 2), f64::from(power + 2) * 2_f64.powi(power + 1)];
    (phase.q[0] / exact[0] - 1.0).abs().max((phase.v[0] / exact[1] - 1.0).abs())
}

#[test]
fn accelerations_of_the_degree_are_integrated_exactly() {
    // The corrector's polynomial has degree k; one more leaves an error.
    let exact = [power_error::<1>(1), power_error::<2>(2), power_error::<5>(5), power_error::<7>(7)];
    println!("{exact:?}");
    let start_exact = exact[0].max(exact[1]).max(exact[2]).max(exact[3]);
    assert!(start_exact < 2e-15, "{exact:?}");
    let beyond = [power_error::<1>(2), power_error::<2>(3), power_error::<5>(6)];
    assert!(beyond.iter().all(|&error| error > 1e-12), "{beyond:?}");
}

/// The largest |q| of an oscillator of frequency 1 from (1, 0), in steps of `h`; infinite when it overflows.
fn largest<const STEPS: usize>(evaluations: Evaluations, h: f64) -> f64 {
    let system = of(Oscillator(1.0));
    let mut method = AdamsBashforthMoulton::<STEPS, _>::new(&system).with_evaluations(evaluations);
    let mut phase = Phase::new(0.0, [1.0], [0.0]);
    let mut largest = 0.0_f64;
    for _ in 0..20_000 {
        if method.step(&system, &mut phase, h).is_err() {
            return f64::INFINITY;
        }
        largest = largest.max(phase.q[0].abs());
    }
    largest
}

#[test]
fn stability_ends_where_documented() {
    fn check<const STEPS: usize>(evaluations: Evaluations, limit: f64) {
        let (within, beyond) =
            (largest::<STEPS>(evaluations, 0.93 * limit), largest::<STEPS>(evaluations, 1.07 * limit));
        assert!(within < 2.0 && beyond > 1e3, "order {}: {within:e}, {beyond:e}", STEPS + 1);
    }
    check::<7>(Evaluations::One, 0.322);
    check::<9>(Evaluations::One, 0.170);
    check::<10>(Evaluations::One, 0.122);
    check::<11>(Evaluations::One, 0.088);
    check::<11>(Evaluations::Two, 0.778);
    check::<12>(Evaluations::Two, 0.698);
    check::<13>(Evaluations::Two, 0.632);
}

/// Hénon–Heiles whose acceleration fails when told to.
struct Fragile {
    inner: EulerLagrange<HenonHeiles, 2>,
    broken: AtomicBool,
}

impl Fragile {
    fn new() -> Self {
        Self { inner: of(HenonHeiles), broken: AtomicBool::new(false) }
    }
}

impl System for Fragile {
    type Coordinates = [f64; 2];
    fn dimension(&self) -> usize {
        2
    }
    fn expand(&self, t: f64, q: &[f64; 2], v: &[f64; 2], expansion: &mut Expansion<[f64; 2]>) {
        self.inner.expand(t, q, v, expansion);
        if self.broken.load(Ordering::Relaxed) {
            expansion.slope[1] = f64::NAN;
        }
    }
    fn curve(&self, t: f64, q: &[f64; 2], v: &[f64; 2], curvature: &mut Curvature<[f64; 2]>) {
        self.inner.curve(t, q, v, curvature);
    }
    fn dependence(&self, t: f64, q: &[f64; 2], v: &[f64; 2]) -> Dependence {
        self.inner.dependence(t, q, v)
    }
}

fn start() -> Phase<[f64; 2]> {
    Phase::new(0.0, [0.1, 0.2], [0.3, -0.1])
}

#[test]
fn a_failed_step_leaves_state_and_history() {
    for evaluations in [Evaluations::One, Evaluations::Two] {
        let system = Fragile::new();
        let new = || AdamsBashforthMoulton::<6, _>::new(&system).with_evaluations(evaluations);
        let (mut method, mut phase) = (new(), start());
        let (mut untroubled, mut whole) = (new(), start());
        for n in 0..20 {
            system.broken.store(true, Ordering::Relaxed);
            let before = phase.clone();
            let refusal = method.step(&system, &mut phase, 0.05).unwrap_err();
            assert!(matches!(refusal, LagrangianError::NonFinite { index: 1, .. }), "{refusal}");
            // From elsewhere, which starts anew, too.
            let mut elsewhere = Phase::new(0.0, [0.0, 0.1], [0.1, 0.1]);
            assert!(method.step(&system, &mut elsewhere, 0.05).is_err());
            assert_eq!(phase, before);
            system.broken.store(false, Ordering::Relaxed);
            method.step(&system, &mut phase, 0.05).unwrap();
            untroubled.step(&system, &mut whole, 0.05).unwrap();
            assert_eq!(phase, whole, "step {n}");
        }
    }
}

#[test]
fn any_other_state_or_step_size_starts_anew() {
    let system = of(HenonHeiles);
    let new = || AdamsBashforthMoulton::<6, _>::new(&system);
    let mut used = new();
    let mut phase = start();
    drive::integrate(&system, &mut used, &mut phase, 1.0, 0.05).unwrap();
    let (mut again, mut fresh) = (start(), start());
    drive::integrate(&system, &mut used, &mut again, 1.0, 0.05).unwrap();
    drive::integrate(&system, &mut new(), &mut fresh, 1.0, 0.05).unwrap();
    assert_eq!(again, fresh);
    // Another step size.
    let mut fresh = again.clone();
    let (by_used, by_new) = (
        drive::integrate(&system, &mut used, &mut again, 2.0, 0.04).unwrap(),
        drive::integrate(&system, &mut new(), &mut fresh, 2.0, 0.04).unwrap(),
    );
    assert_eq!((again, by_used), (fresh, by_new));
}

#[test]
fn parts_make_the_whole() {
    // Intervals of a tenth are not exactly one: their steps differ by rounding, which does not start anew.
    let system = of(HenonHeiles);
    let mut whole = start();
    let mut method = AdamsBashforthMoulton::<8, _>::new(&system);
    let report = drive::integrate(&system, &mut method, &mut whole, 10.0, 0.01).unwrap();
    let mut parts = start();
    let mut method = AdamsBashforthMoulton::<8, _>::new(&system);
    let times: Vec<f64> = (1..=100).map(|n| f64::from(n) * 0.1).collect();
    let (_, of_parts) = drive::sample(&system, &mut method, &mut parts, &times, 0.01).unwrap();
    assert_eq!(of_parts.work, report.work);
    assert_eq!(report.work.evaluations, 7 * 25 + 1 + 993 * 2);
    assert!((parts.q[0] - whole.q[0]).abs() < 1e-14);
}

#[test]
fn bad_input_is_refused() {
    let system = of(HenonHeiles);
    let mut method = AdamsBashforthMoulton::<4, _>::new(&system);
    for h in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let mut phase = start();
        assert!(matches!(method.step(&system, &mut phase, h), Err(LagrangianError::Step { .. })));
        assert_eq!(phase, start());
    }
    let mut phase = start();
    phase.v[1] = f64::INFINITY;
    assert!(matches!(
        method.step(&system, &mut phase, 0.1),
        Err(LagrangianError::NonFinite { index: 1, .. })
    ));
}

/// A row of equal masses and springs between walls.
struct Row(usize);

impl SlicedLagrangian for Row {
    fn dimension(&self) -> usize {
        self.0
    }
    fn kinetic<S: Scalar>(&self, _q: &[S], v: &[S], _t: S) -> S {
        v.iter().fold(S::constant(0.0), |sum, v| sum + v.square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S], _t: S) -> S {
        let mut sum = q[0].square() + q[self.0 - 1].square();
        for i in 1..self.0 {
            sum += (q[i] - q[i - 1]).square();
        }
        sum.scale(0.5)
    }
}

#[test]
fn a_row_of_springs_keeps_its_normal_mode() {
    // Mode m of n masses: amplitude sin(π m i/(n + 1)), frequency 2 sin(π m/(2 (n + 1))).
    let n = 7;
    let system = SlicedEulerLagrange::new(Row(n));
    let angle = std::f64::consts::PI * 3.0 / (n + 1) as f64;
    let shape: Vec<f64> = (1..=n).map(|i| (angle * i as f64).sin()).collect();
    let frequency = 2.0 * (0.5 * angle).sin();
    let mut phase = Phase::new(0.0, shape.clone(), vec![0.0; n]);
    let mut method = AdamsBashforthMoulton::<11, _>::new(&system);
    drive::integrate(&system, &mut method, &mut phase, 20.0, 0.05).unwrap();
    for i in 0..n {
        let error = phase.q[i] - shape[i] * (frequency * 20.0).cos();
        assert!(error.abs() < 2e-14, "{i}: {error:e}");
    }
}
