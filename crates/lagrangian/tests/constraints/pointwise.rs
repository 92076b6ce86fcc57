//! One state: reaction, acceleration, projection.

use crate::fixture::{largest_gap, number, samples};
use crate::systems::*;
use lagrangian::constraint::{Constrained, Constraints, Holonomic, SlicedConstraints};
use lagrangian::{EulerLagrange, Phase, SlicedEulerLagrange};
use mechanics_core::scalar::Scalar;

#[test]
fn the_multiplier_at_a_state_is_the_fixtures() {
    let system = EulerLagrange::new(Particle);
    let constraints = rod();
    let constrained = Constrained::new(&system, &constraints);
    for sample in samples(include_str!("../fixtures/pendulum_cartesian.json")) {
        let q = [number(&sample["x"]), number(&sample["y"])];
        let v = [number(&sample["vx"]), number(&sample["vy"])];
        let motion = constrained.motion(&Phase::new(0.0, q, v)).unwrap();
        let lambda = number(&sample["lambda_phi_half_r2"]);
        assert!(
            (motion.multipliers[0] - lambda).abs() < 1e-13 * lambda.abs().max(10.0),
            "{motion:?} {lambda}"
        );
        // m q̈ = F + λ ∇φ.
        let exact = [lambda * q[0], lambda * q[1] - G];
        assert!(largest_gap(&motion.acceleration, &exact) < 1e-13 * lambda.abs().max(10.0));
    }
}

#[test]
fn the_acceleration_does_not_depend_on_coordinates() {
    let (r, theta, spin) = (1.25f64, 0.7f64, 0.9);
    // On a circle of radius r: θ̈ = −(g/r) sin θ, and λ of r − 1.25 is −(m r ω² + m g cos θ).
    struct Radius;
    impl Holonomic<2, 1> for Radius {
        fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 1] {
            [q[0].offset(-1.25)]
        }
    }
    let (system, constraints) = (EulerLagrange::new(Polar), Constraints::new(Radius));
    let motion =
        Constrained::new(&system, &constraints).motion(&Phase::new(0.0, [r, theta], [0.0, spin])).unwrap();
    assert!(motion.acceleration[0].abs() < 1e-14);
    assert!((motion.acceleration[1] + G / r * theta.sin()).abs() < 1e-14);
    assert!((motion.multipliers[0] + r * spin * spin + G * theta.cos()).abs() < 1e-13);
}

/// A rod that stands still while its pivot is pushed: ẍ_p = −a w² sin(w t) enters φ̈ through φ_tt and φ_qt.
#[test]
fn a_moving_pivot_enters_the_reaction() {
    let (system, pivot) = (EulerLagrange::new(Particle), ShakenRod { amplitude: 0.3, frequency: 2.0 });
    let constraints = Constraints::new(pivot);
    let (t, theta, omega) = (0.4f64, 0.5f64, 1.5);
    let (s, c) = theta.sin_cos();
    let (x, dx, ddx) = (0.3 * (2.0 * t).sin(), 0.6 * (2.0 * t).cos(), -1.2 * (2.0 * t).sin());
    let phase = Phase::new(t, [x + s, -c], [dx + c * omega, s * omega]);
    let constrained = Constrained::new(&system, &constraints);
    constrained.check(&phase).unwrap();
    let motion = constrained.motion(&phase).unwrap();
    let alpha = -G * s - ddx * c;
    let exact = [ddx + c * alpha - s * omega * omega, s * alpha + c * omega * omega];
    assert!(largest_gap(&motion.acceleration, &exact) < 1e-13, "{motion:?} {exact:?}");
}

#[test]
fn projection_onto_a_circle_is_radial_from_near_and_far() {
    let (system, constraints) = (EulerLagrange::new(Particle), rod());
    let constrained = Constrained::new(&system, &constraints);
    for distance in [0.05, 0.5, 0.999, 1.0, 1.0 + 1e-9, 1.1, 3.0, 40.0] {
        let direction = [0.6, -0.8];
        let mut phase = Phase::new(0.0, direction.map(|x| x * distance), [3.0, 1.0]);
        constrained.project(&mut phase).unwrap();
        assert!(largest_gap(&phase.q, &direction) < 1e-11, "{distance}: {:?}", phase.q);
        // What is left of (3, 1) along (0.8, 0.6) is 3.
        assert!(largest_gap(&phase.v, &[2.4, 1.8]) < 1e-10, "{distance}: {:?}", phase.v);
        constrained.check(&phase).unwrap();
    }
}

#[test]
fn projection_weighs_by_masses() {
    let (system, constraints) = (EulerLagrange::new(TwoMasses([3.0, 1.0])), Constraints::new(Apart));
    // Two masses on a line 2 m apart, to be 1 m apart: the light one moves three times as far.
    struct Apart;
    impl Holonomic<4, 1> for Apart {
        fn constraint<S: Scalar>(&self, q: &[S; 4], _: S) -> [S; 1] {
            [((q[2] - q[0]).square() + (q[3] - q[1]).square()).sqrt().offset(-1.0)]
        }
    }
    let mut phase = Phase::new(0.0, [0.0, 0.0, 2.0, 0.0], [1.0, 0.0, -3.0, 0.5]);
    Constrained::new(&system, &constraints).project(&mut phase).unwrap();
    assert!(largest_gap(&phase.q, &[0.25, 0.0, 1.25, 0.0]) < 1e-14, "{:?}", phase.q);
    // The centre of mass goes on: (3·1 − 3)/4 = 0.
    assert!(largest_gap(&phase.v, &[0.0, 0.0, 0.0, 0.5]) < 1e-14, "{:?}", phase.v);
}

#[test]
fn a_state_on_the_constraints_stays() {
    let (system, constraints) = (EulerLagrange::new(Particle), Constraints::new(Parabola));
    let mut phase = Phase::new(0.0, [0.5, 0.125], [2.0, 1.0]);
    let before = phase.clone();
    Constrained::new(&system, &constraints).project(&mut phase).unwrap();
    assert!(largest_gap(&phase.q, &before.q) < 1e-15 && largest_gap(&phase.v, &before.v) < 1e-15);
}

/// Fixed and run-time sizes are one method.
#[test]
fn run_time_sizes_give_what_fixed_sizes_give() {
    let rods = SlicedConstraints::new(Rods { number: 2, length: 0.75 });
    assert_eq!(rods.directions(), 4);
    let masses = SlicedEulerLagrange::new(Masses { number: 2, mass: 1.5 });
    let (system, constraints) =
        (EulerLagrange::new(TwoMasses([1.5; 2])), Constraints::new(TwoRods([0.75; 2])));
    let q = joints([0.5, 2.0], [0.75; 2]);
    let v = joint_velocities([0.5, 2.0], [1.0, -3.0], [0.75; 2]);
    let fixed = Constrained::new(&system, &constraints).motion(&Phase::new(0.0, q, v)).unwrap();
    let sliced = Constrained::new(&masses, &rods).motion(&Phase::new(0.0, q.to_vec(), v.to_vec())).unwrap();
    assert!(largest_gap(&fixed.acceleration, &sliced.acceleration) < 1e-13);
    assert!(largest_gap(&fixed.multipliers, &sliced.multipliers) < 1e-13);
}

/// An ellipse with half axes 2 and 1. From a point on its long axis inside, the far end of that axis is a stationary
/// point of the distance; from beyond the centre of curvature (1.5 m) it is the furthest, not the nearest.
#[test]
fn symmetric_starts_do_not_end_at_the_furthest_point() {
    struct Ellipse;
    impl Holonomic<2, 1> for Ellipse {
        fn constraint<S: Scalar>(&self, [x, y]: &[S; 2], _: S) -> [S; 1] {
            [(x.square().scale(0.25) + y.square()).offset(-1.0)]
        }
    }
    let (system, constraints) = (EulerLagrange::new(Particle), Constraints::new(Ellipse));
    for x in [1e-3, 0.1, 0.7, 1.3, 1.6, 1.99, 2.5] {
        let mut phase = Phase::new(0.0, [x, 0.0], [1.0, 1.0]);
        Constrained::new(&system, &constraints).project(&mut phase).unwrap();
        // (x − X) Y-part of the normal: the nearest point has X = 4x/3 where that is below 2.
        let nearest: f64 = if x < 1.5 { 4.0 / 3.0 * x } else { 2.0 };
        let exact = [nearest, (1.0 - 0.25 * nearest * nearest).max(0.0).sqrt()];
        let found = [phase.q[0], phase.q[1].abs()];
        assert!(largest_gap(&found, &exact) < 1e-9, "from {x}: {found:?} for {exact:?}");
    }
}
