//! Lagging: settled to the tolerance, or said.

use crate::scene::{Bodies, Particle, cube, glancing_blow, mu, options, stepping};
use ipc_friction::FrictionOptions;
use ipc_friction::coefficients::CoefficientTable;
use ipc_friction::law::FrictionCoefficient;
use lagrangian::stepper::{Lagging, StepError};
use mechanics_core::tensor::Vec3;

#[test]
fn repeated_lagging_settles_to_the_tolerance_and_a_single_pass_says_what_it_left() {
    let run = |lagging: Lagging| {
        let mut bodies = glancing_blow(0.3, lagging);
        let (mut worst, mut lags): (f64, u64) = (0.0, 0);
        for _ in 0..25 {
            let step = bodies.step(5e-4);
            let report = bodies.contact.report(&bodies.state.position).unwrap();
            worst = worst.max(report.relative_lag_residual);
            lags = lags.max(report.lags);
            assert!(report.lags <= step.lag_iterations);
        }
        (worst, lags)
    };
    let (settled, lags) = run(Lagging::Until(60));
    assert!(settled <= 1e-3 && lags > 1, "{settled} {lags}");
    let (once, lags) = run(Lagging::Once);
    assert!(once > 0.1 && lags == 1, "{once} {lags}");
}

#[test]
fn lagging_that_does_not_settle_is_an_error() {
    let mut bodies = glancing_blow(0.3, Lagging::Until(1));
    let mut failed = None;
    for _ in 0..25 {
        let before = bodies.state.hash();
        let ipc = &mut bodies;
        let result = ipc.stepper.step(&mut ipc.state, &mut [&mut ipc.elastic, &mut ipc.contact], 5e-4);
        if let Err(error) = result {
            assert_eq!(bodies.state.hash(), before);
            failed = Some(error);
            break;
        }
    }
    assert!(matches!(failed, Some(StepError::Lagging { iterations: 1, .. })), "{failed:?}");
}

/// Cubes whose edges meet exactly: normal forces jump from pair to pair. Taken anew as they are, they come in a cycle, here for μ = 1 and
/// the largest step.
#[test]
fn lagging_that_would_go_around_in_a_cycle_settles() {
    for coefficient in [0.5, 1.0, 2.0] {
        for h in [2e-3, 5e-3, 0.01] {
            let meshes = [cube(3, Vec3::zeros()), cube(3, Vec3::new(0.05, 0.0, 0.1015))];
            let lagging = Lagging::Until(200);
            let mut bodies =
                Bodies::new(&meshes, None, options(mu(coefficient), 1e-3), stepping(1e-6, lagging));
            let second = bodies.first[1];
            bodies.state.velocity[second..].fill(Vec3::new(0.8, 0.3, -0.7));
            for _ in 0..4 {
                bodies.step(h);
                let x = &bodies.state.position;
                let report = bodies.contact.report(x).unwrap();
                assert!(report.relative_lag_residual <= 1e-3, "{report:?}");
                assert!(report.dissipated >= 0.0, "{report:?}");
                for pair in bodies.contact.pairs(x) {
                    assert!(pair.force.norm() <= pair.bound * (1.0 + 1e-12), "{pair:?}");
                }
            }
        }
    }
}

#[test]
fn without_friction_nothing_is_lagged() {
    let mut particle =
        Particle::on_slope(0.3, options(FrictionCoefficient::NONE, 1e-3), stepping(1e-9, Lagging::Until(2)));
    let report = particle.step(0.01);
    assert_eq!(report.lag_iterations, 1);
    let report = particle.contact.report(&particle.state.position).unwrap();
    assert_eq!((report.pairs, report.lag_residual, report.dissipated), (0, 0.0, 0.0));
}

#[test]
fn coefficients_are_those_of_the_surfaces() {
    let slippery = CoefficientTable::uniform(mu(1.0)).with_half_space(0, mu(0.1));
    let own = slippery.clone().with_half_space_and_object(0, 0, mu(0.2));
    for (table, expected) in [(CoefficientTable::uniform(mu(1.0)), 1.0), (slippery, 0.1), (own, 0.2)] {
        let friction = FrictionOptions { coefficients: table, ..options(mu(0.0), 1e-5) };
        let mut particle = Particle::on_slope(0.0, friction, stepping(1e-10, Lagging::Once));
        particle.state.velocity[0] = Vec3::new(1.0, 0.0, 0.0);
        particle.step(1e-3);
        let slowed = 1.0 - particle.velocity().x;
        assert!((slowed / (expected * 9.81e-3) - 1.0).abs() < 1e-6, "{slowed}");
    }
}
