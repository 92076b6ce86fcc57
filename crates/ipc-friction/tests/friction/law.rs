//! The law against its definition.

use crate::Random;
use ipc_friction::law::{
    FrictionCoefficient, SmoothedCoulomb, Smoothing, Strength, holding_force, sliding_force,
};
use mechanics_core::jet::{Jet1, Jet2};

const SMOOTHINGS: [Smoothing; 2] = [Smoothing::Quadratic, Smoothing::Quintic];

fn strength(at_rest: f64, sliding: f64, magnitude: f64) -> Strength<f64> {
    Strength::new(FrictionCoefficient::with_kinetic(at_rest, sliding).unwrap(), magnitude)
}

#[test]
fn the_sliding_force_dissipates_most_of_all_forces_of_the_disk() {
    let mut random = Random(1);
    for _ in 0..50 {
        let v = [random.number(), random.number()];
        let bound = 1.0 + random.number();
        let force = sliding_force(v, bound).unwrap();
        let best = force[0] * v[0] + force[1] * v[1];
        assert!((force[0].hypot(force[1]) - bound).abs() <= 4.0 * f64::EPSILON);
        for k in 0..720 {
            let angle = f64::from(k) * std::f64::consts::PI / 360.0;
            for radius in [0.25, 0.5, 1.0] {
                let other = [radius * bound * angle.cos(), radius * bound * angle.sin()];
                assert!(best <= other[0] * v[0] + other[1] * v[1] + 1e-15);
            }
        }
    }
    assert_eq!(sliding_force([0.0, 0.0], 1.0), None);
}

#[test]
fn the_holding_force_is_the_nearest_of_the_disk_to_what_is_needed() {
    let mut random = Random(2);
    for _ in 0..50 {
        let load = [2.0 * random.number(), 2.0 * random.number()];
        let force = holding_force(load, 1.0);
        assert!(force[0].hypot(force[1]) <= 1.0 + 1e-15);
        let rest = (load[0] + force[0]).hypot(load[1] + force[1]);
        for k in 0..720 {
            let angle = f64::from(k) * std::f64::consts::PI / 360.0;
            for radius in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let other = [radius * angle.cos(), radius * angle.sin()];
                assert!(rest <= (load[0] + other[0]).hypot(load[1] + other[1]) + 1e-14);
            }
        }
    }
}

#[test]
fn the_quadratic_law_is_the_published_one() {
    // f₁ = −y²/(εᵥ²h²) + 2y/(εᵥh) of the displacement y; in velocities h is 1. f₀ = y from εᵥ on.
    let epsilon = 1e-3;
    let law = SmoothedCoulomb::new(epsilon).unwrap();
    let one = strength(1.0, 1.0, 1.0);
    for y in [0.0, 1e-9, 2e-4, 5e-4, 9.99e-4] {
        let f1 = -y * y / (epsilon * epsilon) + 2.0 * y / epsilon;
        let f0 = -y * y * y / (3.0 * epsilon * epsilon) + y * y / epsilon + epsilon / 3.0;
        assert!((law.force(one, y) - f1).abs() < 1e-15);
        assert!((law.potential(one, y) - f0).abs() < 1e-18);
    }
    for y in [1e-3, 1.1e-3, 1.0, 1e6] {
        assert!((law.force(one, y) - 1.0).abs() < 1e-15);
        assert!((law.potential(one, y) / y - 1.0).abs() < 1e-15);
    }
}

#[test]
fn force_and_slope_are_the_derivatives_of_the_potential() {
    let mut random = Random(3);
    for smoothing in SMOOTHINGS {
        let law = SmoothedCoulomb::new(0.01).unwrap().with_smoothing(smoothing);
        let law = law.with_transition(0.03).unwrap();
        for (at_rest, sliding) in [(0.5, 0.5), (1.0, 0.3)] {
            let s = strength(at_rest, sliding, 7.0);
            let jet = Strength { at_rest: Jet2::from_value(s.at_rest), fall: Jet2::from_value(s.fall) };
            for _ in 0..200 {
                let y = 0.03 + 0.03 * random.number();
                let [variable] = Jet2::variables([y]);
                let potential = law.potential(jet, variable);
                let scale = s.at_rest;
                assert!((potential.value - law.potential(s, y)).abs() < 1e-15 * scale);
                assert!((potential.gradient[0] - law.force(s, y)).abs() < 1e-13 * scale, "{y}");
                let slope = law.slope(s, y);
                assert!((potential.hessian(0, 0) - slope).abs() < 1e-12 * scale / 0.01, "{y} {slope}");
            }
        }
    }
}

#[test]
fn forces_are_as_smooth_at_the_seams_as_they_say() {
    let (epsilon, delta) = (0.01, 0.03);
    for smoothing in SMOOTHINGS {
        let law = SmoothedCoulomb::new(epsilon).unwrap().with_smoothing(smoothing);
        let law = law.with_transition(delta).unwrap();
        let s = strength(1.0, 0.4, 1.0);
        for seam in [epsilon, epsilon + delta] {
            let step = 1e-9 * epsilon;
            let (below, above) = (seam - step, seam + step);
            assert!((law.potential(s, above) - law.potential(s, below)).abs() < 3.0 * step);
            assert!((law.force(s, above) - law.force(s, below)).abs() < 1e-15 / epsilon);
            assert!((law.slope(s, above) - law.slope(s, below)).abs() < 1e-8 / epsilon);
            let second = |y: f64| {
                let [variable] = Jet1::<f64, 1>::variables([y]);
                let s = Strength { at_rest: Jet1::from_value(1.0), fall: Jet1::from_value(-0.6) };
                law.slope(s, variable).gradient[0] * epsilon * epsilon
            };
            let jump = (second(above) - second(below)).abs();
            assert_eq!(jump < 1e-6, smoothing == Smoothing::Quintic, "{smoothing:?} {seam} {jump}");
        }
        assert!((law.force(s, epsilon) - 1.0).abs() < 1e-15, "the whole static friction");
        assert!((law.force(s, epsilon + delta) - 0.4).abs() < 1e-15, "the kinetic friction");
    }
}

#[test]
fn the_smoothed_force_is_the_exact_one_from_the_stick_velocity_on_and_never_more() {
    let mut random = Random(4);
    for smoothing in SMOOTHINGS {
        for decade in 1..7 {
            let epsilon = 10f64.powi(-decade);
            let law = SmoothedCoulomb::new(epsilon).unwrap().with_smoothing(smoothing);
            let s = strength(0.7, 0.7, 3.0);
            for _ in 0..200 {
                let y = 10f64.powf(3.0 * random.number() - 3.0);
                let force = law.force(s, y);
                let [exact, _] = sliding_force([y, 0.0], 2.1).unwrap();
                assert!(force > 0.0 && force <= 2.1 * (1.0 + 4.0 * f64::EPSILON));
                assert!(y < epsilon || (force + exact).abs() <= 1e-15 * 2.1);
            }
        }
    }
}

#[test]
fn friction_is_finite_and_zero_at_rest_down_to_the_smallest_numbers() {
    for smoothing in SMOOTHINGS {
        for epsilon in [1e-9, 1.0, 1e9] {
            let law = SmoothedCoulomb::new(epsilon).unwrap().with_smoothing(smoothing);
            let s = strength(0.5, 0.2, 1e4);
            assert_eq!(law.force(s, 0.0), 0.0);
            let viscosity = law.slope(s, 0.0);
            assert!(viscosity.is_finite() && viscosity > 0.0);
            for y in [0.0, f64::MIN_POSITIVE, 1e-160, 1e-30] {
                assert!((law.force_over_speed(s, y) / viscosity - 1.0).abs() < 1e-12);
                assert!(law.potential(s, y).is_finite());
            }
        }
    }
}
