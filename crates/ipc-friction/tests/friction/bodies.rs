//! Elastic bodies: creep, momentum, bits.

use crate::Random;
use crate::scene::{Bodies, cube, glancing_blow, gravity_on_slope, mu, options, stepping};
use ipc_friction::coefficients::CoefficientTable;
use ipc_friction::law::FrictionCoefficient;
use lagrangian::stepper::Lagging;
use mechanics_core::derivatives::{check_potential_gradient, check_potential_hessian};
use mechanics_core::parallel;
use mechanics_core::potential::Potential;
use mechanics_core::stage::{Coefficients, Moment, Scheme, Stage};
use mechanics_core::tensor::Vec3;

#[test]
fn an_elastic_block_on_a_slope_creeps_like_a_particle() {
    let (angle, coefficient, stick_velocity) = (26f64.to_radians(), 0.5, 1e-3);
    let floor = cube(2, Vec3::new(0.0, 0.0, 6e-4));
    let friction = options(mu(coefficient), stick_velocity);
    let gravity = Some(gravity_on_slope(angle));
    let mut block = Bodies::new(&[floor], gravity, friction, stepping(1e-10, Lagging::AtMost(3)));
    for _ in 0..150 {
        block.step(0.02);
    }
    let expected = stick_velocity * (1.0 - (1.0 - angle.tan() / coefficient).sqrt());
    let velocity = block.mean_velocity();
    assert!((velocity.x / expected - 1.0).abs() < 1e-5, "{velocity} {expected}");
    let report = block.contact.report(&block.state.position).unwrap();
    assert!(report.pairs == report.sticking && report.pairs >= 6, "{report:?}");
}

#[test]
fn an_elastic_block_slides_where_friction_is_too_weak() {
    let (angle, coefficient) = (26f64.to_radians(), 0.3);
    let block = cube(2, Vec3::new(0.0, 0.0, 6e-4));
    let friction = options(mu(coefficient), 1e-3);
    let gravity = Some(gravity_on_slope(angle));
    let mut block = Bodies::new(&[block], gravity, friction, stepping(1e-9, Lagging::AtMost(10)));
    let mut speeds = Vec::new();
    for _ in 0..60 {
        block.step(0.01);
        speeds.push(block.mean_velocity().x);
    }
    // It settles on its contact first.
    let acceleration = (speeds[59] - speeds[29]) / 0.3;
    let expected = 9.81 * (angle.sin() - coefficient * angle.cos());
    assert!((acceleration / expected - 1.0).abs() < 1e-2, "{acceleration} {expected}");
}

#[test]
fn friction_between_bodies_conserves_momentum_and_takes_energy() {
    for coefficient in [0.2, 1.5] {
        let mut bodies = glancing_blow(coefficient, Lagging::AtMost(20));
        let before = bodies.momentum();
        let (mut dissipated, mut pairs) = (0.0, 0);
        for _ in 0..30 {
            bodies.step(1e-3);
            let report = bodies.contact.report(&bodies.state.position).unwrap();
            assert!(report.dissipated >= 0.0);
            dissipated += report.dissipated;
            pairs = pairs.max(report.pairs);
            let forces = bodies.contact.friction().forces(&bodies.state.position);
            let (sum, size): (Vec3, f64) = (forces.iter().sum(), forces.iter().map(Vec3::norm).sum());
            assert!(sum.norm() <= 1e-14 * size);
            for pair in bodies.contact.pairs(&bodies.state.position) {
                assert!(pair.force.norm() <= pair.bound * (1.0 + 1e-14));
                assert!(pair.force.dot(&pair.slip_velocity) <= 0.0);
            }
        }
        assert!(pairs > 10 && dissipated > 1e-3, "{pairs} {dissipated}");
        assert!((bodies.momentum() - before).norm() < 1e-13, "{}", bodies.momentum() - before);
        // What was at rest is dragged along.
        let dragged: Vec3 = bodies.state.velocity[..bodies.first[1]].iter().sum();
        assert!(dragged.x > 0.0 && dragged.y > 0.0, "{dragged}");
    }
}

#[test]
fn a_blow_with_friction_has_the_same_bits_for_any_number_of_threads() {
    let run = |threads: usize| {
        parallel::with_threads(threads, || {
            let mut bodies = glancing_blow(0.5, Lagging::AtMost(5));
            (0..8).for_each(|_| drop(bodies.step(1e-3)));
            let report = bodies.contact.report(&bodies.state.position).unwrap();
            assert!(report.pairs > 0);
            (bodies.state.hash(), report)
        })
    };
    let one = run(1);
    for threads in [2, 3, 8] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}

#[test]
fn derivatives_of_the_whole_friction_agree_with_finite_differences() {
    let meshes = [cube(2, Vec3::new(0.0, 0.0, 5e-4)), cube(2, Vec3::new(0.031, 0.017, 0.101))];
    let coefficient = FrictionCoefficient::with_kinetic(0.8, 0.5).unwrap();
    let mut friction = options(coefficient, 0.5);
    friction.coefficients = CoefficientTable::uniform(coefficient).with_objects([0, 1], mu(0.3));
    let mut bodies = Bodies::new(&meshes, Some(-Vec3::z()), friction, stepping(1e-8, Lagging::Once));
    let mut random = Random(21);
    let x: Vec<Vec3> = bodies.state.position.iter().map(|x| x + random.vector() * 2e-4).collect();
    // Unit a, and slips of the size of the stick velocity, so that differences neither drown nor round.
    let coefficients = Coefficients { inertia: 1.0, velocity: 1.0 };
    let origin: Vec<Vec3> = x.iter().map(|x| x - random.vector()).collect();
    let scheme = Scheme::new(coefficients, &x, &origin);
    for moment in [Moment::Step, Moment::Lag] {
        let _ = bodies.contact.freeze(&Stage { moment, x: &x, time: 0.0, step: 1.0, scheme }).unwrap();
    }
    let friction = bodies.contact.friction();
    assert!(friction.pairs(&x).iter().any(|pair| pair.points().len() == 1));
    assert!(friction.pairs(&x).iter().any(|pair| pair.points().len() == 4));
    check_potential_gradient(friction, &x).require(1e-8).unwrap();
    check_potential_hessian(friction, &x).require(1e-7).unwrap();
}

/// Found by a sweep: with the true Hessian of friction alone, Newton's method stopped after 100 iterations in four of these.
#[test]
fn collisions_with_strong_friction_and_tiny_stick_velocities_converge() {
    for stick_velocity in [1e-2, 1e-4, 1e-6] {
        for h in [1e-3, 1e-2, 0.1] {
            for lagging in [Lagging::Once, Lagging::AtMost(30)] {
                let meshes = [cube(2, Vec3::zeros()), cube(2, Vec3::new(0.02, 0.01, 0.1015))];
                let friction = options(mu(2.0), stick_velocity);
                let mut bodies = Bodies::new(&meshes, None, friction, stepping(1e-6, lagging));
                let second = bodies.first[1];
                bodies.state.velocity[second..].fill(Vec3::new(0.8, 0.3, -0.7));
                let before = bodies.momentum();
                for _ in 0..3 + (0.01 / h) as u32 {
                    bodies.step(h);
                }
                assert!((bodies.momentum() - before).norm() < 1e-6, "{stick_velocity} {h}");
            }
        }
    }
}

/// Found by the scene of two bodies: with the floor under the curvature in every later iteration, Newton's method converged only linearly here, and
/// stopped after 100 iterations.
#[test]
fn cubes_that_rub_with_strong_friction_converge_to_a_tight_tolerance() {
    let meshes = [cube(3, Vec3::zeros()), cube(3, Vec3::new(0.02, 0.01, 0.1015))];
    let friction = options(mu(1.5), 1e-5);
    let mut bodies = Bodies::new(&meshes, None, friction, stepping(1e-9, Lagging::Until(100)));
    let second = bodies.first[1];
    bodies.state.velocity[second..].fill(Vec3::new(0.8, 0.3, -0.7));
    for _ in 0..20 {
        let report = bodies.step(1e-3);
        assert!(report.newton.iterations < 40 * report.lag_iterations, "{report:?}");
    }
}
