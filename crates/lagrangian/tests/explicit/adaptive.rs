//! Step-size control and dense output.

use crate::systems::{DoublePendulum, Duffing, Fixture, HenonHeiles, Kepler, Oscillator, Pendulum, of};
use lagrangian::integrator::{DormandPrince853, Outcome, Tolerance};
use lagrangian::{EulerLagrange, Lagrangian, Phase};
use std::ops::ControlFlow;

fn with<const N: usize, L: Lagrangian<N>>(
    system: &EulerLagrange<L, N>,
    tolerance: f64,
) -> DormandPrince853<[f64; N]> {
    DormandPrince853::new(system).with_tolerance(Tolerance::uniform(tolerance)).unwrap()
}

/// The largest error at all of a fixture's samples, relative to its largest number.
fn error_at_samples<const N: usize, L: Lagrangian<N>>(lagrangian: L, name: &str, tolerance: f64) -> f64 {
    let (system, fixture) = (of(lagrangian), Fixture::<N>::read(name));
    let mut phase = fixture.start();
    let (trajectory, _) = with(&system, tolerance).sample(&system, &mut phase, &fixture.times).unwrap();
    assert_eq!(trajectory.times, fixture.times, "samples are at their times exactly");
    let error =
        trajectory.phases().enumerate().map(|(i, phase)| fixture.error(i, &phase)).fold(0.0, f64::max);
    println!("{name}: tolerance {tolerance:e}, error {:e}", error / fixture.scale());
    error / fixture.scale()
}

#[test]
fn regular_systems_are_followed_to_1e_12() {
    assert!(error_at_samples(Pendulum, "pendulum_large", 1e-15) <= 1e-12);
    assert!(error_at_samples(DoublePendulum, "double_pendulum_regular", 1e-15) <= 1e-13);
    assert!(error_at_samples(HenonHeiles, "henon_heiles_regular", 1e-15) <= 1e-12);
    assert!(error_at_samples(Kepler, "kepler_e06", 1e-15) <= 1e-11);
    // Disturbances grow 62,638-fold, and the force's argument 1.2 t is rounded at 60 rad, to 3.6e-15.
    assert!(error_at_samples(Duffing, "duffing", 1e-15) <= 5.0 * 1e-16 * 62_638.0);
}

#[test]
fn the_error_follows_the_tolerance() {
    // Errors per step stay below the tolerance and accumulate over some hundred steps.
    for exponent in 4..=13 {
        let tolerance = 10_f64.powi(-exponent);
        let error = error_at_samples(HenonHeiles, "henon_heiles_regular", tolerance);
        assert!(error < 500.0 * tolerance, "tolerance {tolerance:e}, error {error:e}");
        assert!(error > 1e-4 * tolerance, "tolerance {tolerance:e} wastes work: error {error:e}");
    }
}

#[test]
fn dense_output_is_as_good_as_the_steps() {
    let system = of(Oscillator(1.0));
    for exponent in [6, 9, 12] {
        let tolerance = 10_f64.powi(-exponent);
        let mut phase = Phase::new(0.0, [0.0], [1.0]);
        let (motion, report) = with(&system, tolerance).dense(&system, &mut phase, 30.0).unwrap();
        assert_eq!(motion.steps().len() as u64, report.accepted);
        let error = |t: f64| {
            let at = motion.at(t).unwrap();
            (at.q[0] - t.sin()).abs().max((at.v[0] - t.cos()).abs())
        };
        let at_ends = motion.steps().iter().map(|step| error(step.end())).fold(0.0, f64::max);
        let within = (0..=3000).map(|k| error(f64::from(k) * 0.01)).fold(0.0, f64::max);
        println!("tolerance {tolerance:e}: at ends {at_ends:e}, within {within:e}");
        assert!(within < 30.0 * at_ends.max(tolerance), "at ends {at_ends:e}, within {within:e}");
        assert!(motion.at(30.0).is_some() && motion.at(0.0).is_some());
        assert!(motion.at(30.000001).is_none() && motion.at(-1e-9).is_none());
    }
}

#[test]
fn dense_output_has_order_seven() {
    // The error of the polynomial within one step of size h falls like h⁸.
    let system = of(Oscillator(1.0));
    let error = |h: f64| {
        let mut method = with(&system, 1.0).with_largest_step(h).unwrap();
        let mut phase = Phase::new(0.0, [0.6], [0.8]);
        let (motion, report) = method.dense(&system, &mut phase, h).unwrap();
        assert_eq!(report.accepted, 1);
        let exact = |t: f64| 0.6 * t.cos() + 0.8 * t.sin();
        (1..40)
            .map(|k| h * f64::from(k) / 40.0)
            .map(|t| (motion.at(t).unwrap().q[0] - exact(t)).abs())
            .fold(0.0, f64::max)
    };
    let order = (error(0.5) / error(0.25)).log2();
    assert!((order - 8.0).abs() < 0.6, "{order}");
}

#[test]
fn dense_steps_join() {
    let system = of(DoublePendulum);
    let mut phase = Phase::new(0.0, [0.5, -0.25], [0.0, 0.5]);
    let start = phase.clone();
    let (motion, _) = with(&system, 1e-8).dense(&system, &mut phase, 5.0).unwrap();
    assert_eq!(motion.at(0.0).unwrap(), start);
    for pair in motion.steps().windows(2) {
        assert_eq!(pair[0].end(), pair[1].start());
        let (left, right) = (pair[0].at(pair[0].end()), pair[1].at(pair[1].start()));
        for i in 0..2 {
            assert!((left.q[i] - right.q[i]).abs() < 1e-15 && (left.v[i] - right.v[i]).abs() < 4e-15);
        }
    }
}

#[test]
fn an_interrupted_integration_equals_a_whole_one_in_accuracy_and_repeats_itself() {
    let system = of(DoublePendulum);
    let start = Phase::new(0.0, [0.5, -0.25], [0.0, 0.5]);
    let run = || {
        let (mut method, mut phase) = (with(&system, 1e-10), start.clone());
        let report = method.sample(&system, &mut phase, &[0.3, 0.30000001, 4.0, 7.7, 20.0]).unwrap().1;
        (phase, report)
    };
    let (first, second) = (run(), run());
    assert_eq!(first, second);
    // The tiny interval costs its own step, but does not make the following ones small.
    let mut whole = start.clone();
    let report = with(&system, 1e-10).integrate(&system, &mut whole, 20.0).unwrap();
    assert!(first.1.accepted < report.accepted + 20, "{} against {}", first.1, report);
}

#[test]
fn reports_count_and_print() {
    let system = of(Pendulum);
    let mut phase = Phase::new(0.0, [1.0], [0.0]);
    let mut seen = 0;
    let report = with(&system, 1e-9)
        .advance(&system, &mut phase, 10.0, |phase| {
            seen += 1;
            if phase.time > 5.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .unwrap();
    assert_eq!(report.outcome, Outcome::Stopped);
    assert_eq!(report.accepted, seen);
    // Two evaluations to start, twelve a step, eleven a step refused.
    assert_eq!(report.evaluations, 2 + 12 * report.accepted + 11 * report.rejected);
    assert!(phase.time > 5.0 && phase.time < 6.0);
    assert!(report.smallest > 0.0 && report.smallest <= report.largest);
    let text = report.to_string();
    assert!(
        text.starts_with(&format!("{seen} steps of at most ")) && text.ends_with("stopped by the observer")
    );
}

#[test]
fn a_motion_at_rest_takes_few_steps() {
    let system = of(Pendulum);
    let mut phase = Phase::new(0.0, [0.0], [0.0]);
    let report = with(&system, 1e-12).integrate(&system, &mut phase, 1e6).unwrap();
    assert_eq!((phase.time, phase.q, phase.v), (1e6, [0.0], [0.0]));
    assert!(report.accepted < 40, "{report}");
}

#[test]
fn far_from_time_zero_steps_still_land() {
    // Times near 1e9 s resolve 1.2e-7 s.
    let system = of(Oscillator(1.0));
    let mut phase = Phase::new(1e9, [1.0], [0.0]);
    let end = 1e9 + 10.0;
    with(&system, 1e-10).integrate(&system, &mut phase, end).unwrap();
    assert_eq!(phase.time, end);
    assert!((phase.q[0] - 10_f64.cos()).abs() < 1e-8);
    // Negative times too.
    let mut phase = Phase::new(-10.0, [1.0], [0.0]);
    with(&system, 1e-10).integrate(&system, &mut phase, 0.0).unwrap();
    assert_eq!(phase.time, 0.0);
    assert!((phase.q[0] - 10_f64.cos()).abs() < 1e-8);
}
