//! Typed errors that leave everything as it was.

use crate::systems::*;
use lagrangian::constraint::{
    Composition, Constrained, Constraints, Holonomic, Rattle, SlicedConstraints, SlicedHolonomic,
};
use lagrangian::error::{ConstraintLevel, Symbol};
use lagrangian::integrator::Integrator;
use lagrangian::{EulerLagrange, Lagrangian, LagrangianError, Phase, SlicedEulerLagrange};
use mechanics_core::scalar::Scalar;

/// The error of one step from `phase`, which must not change.
fn refusal<L: Lagrangian<N>, H: Holonomic<N, K>, const N: usize, const K: usize>(
    lagrangian: L,
    holonomic: H,
    q: [f64; N],
    v: [f64; N],
    h: f64,
) -> LagrangianError {
    let mut phase = Phase::new(0.25, q, v);
    let mut rattle = Rattle::new(Constraints::new(holonomic));
    let error = rattle.step(&EulerLagrange::new(lagrangian), &mut phase, h).unwrap_err();
    let bits = |x: [f64; N]| x.map(f64::to_bits);
    assert_eq!((bits(phase.q), bits(phase.v), phase.time), (bits(q), bits(v), 0.25));
    assert!(rattle.reaction().is_none());
    error
}

#[test]
fn a_start_beside_the_constraints_is_refused() {
    let q = joints([0.5, 2.0], [1.0, 0.5]);
    let error = refusal(TwoMasses([1.0; 2]), TwoRods([1.0, 0.75]), q, [0.0; 4], 0.01);
    let LagrangianError::ConstraintViolated { level, index, value, time, .. } = error else {
        panic!("{error}")
    };
    assert_eq!((level, index, time), (ConstraintLevel::Position, 1, 0.25));
    assert!((value - 0.5 * (0.25 - 0.5625)).abs() < 1e-15, "{value}");

    let error = refusal(Particle, Rod(1.0), [0.6, -0.8], [0.6, -0.7], 0.01);
    let LagrangianError::ConstraintViolated { level, index, value, .. } = error else { panic!("{error}") };
    assert_eq!((level, index), (ConstraintLevel::Velocity, 0));
    assert!((value - 0.92).abs() < 1e-15);
}

#[test]
fn a_pivot_that_moves_away_is_a_velocity_to_be_met() {
    let pivot = ShakenRod { amplitude: 0.5, frequency: 2.0 };
    let mut phase = Phase::new(0.0, [1.0, 0.0], [0.0, 0.0]);
    let (system, constraints) = (EulerLagrange::new(Particle), Constraints::new(pivot));
    let error = Rattle::new(constraints.clone()).step(&system, &mut phase, 0.01).unwrap_err();
    assert!(
        matches!(error, LagrangianError::ConstraintViolated { level: ConstraintLevel::Velocity, .. }),
        "{error}"
    );
    Constrained::new(&system, &constraints).project(&mut phase).unwrap();
    assert_eq!(phase.v, [1.0, 0.0]);
    Rattle::new(constraints).step(&system, &mut phase, 0.01).unwrap();
}

/// The third constraint is the difference of the first two.
struct Redundant;

impl Holonomic<4, 3> for Redundant {
    fn constraint<S: Scalar>(&self, q: &[S; 4], t: S) -> [S; 3] {
        let [a, b] = TwoRods([1.0, 0.5]).constraint(q, t);
        [a, b, b.scale(2.0) - a]
    }
}

#[test]
fn redundant_constraints_are_named_with_their_combination() {
    let q = joints([0.5, 2.0], [1.0, 0.5]);
    let error = refusal(TwoMasses([1.0, 3.0]), Redundant, q, [0.0; 4], 0.01);
    let LagrangianError::RedundantConstraint { index, combination, .. } = error else { panic!("{error}") };
    assert_eq!(index, 2);
    // φ₀ − 2 φ₁ + φ₂ = 0, of length one.
    let unit = 6f64.sqrt().recip();
    for (found, expected) in combination.iter().zip([unit, -2.0 * unit, unit]) {
        assert!((found - expected).abs() < 1e-12, "{combination:?}");
    }
}

#[test]
fn more_constraints_than_coordinates_are_redundant() {
    struct Three;
    impl Holonomic<2, 3> for Three {
        fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 3] {
            [q[0], q[1], q[0] + q[1]]
        }
    }
    let error = refusal(Particle, Three, [0.0; 2], [0.0; 2], 0.01);
    assert!(matches!(error, LagrangianError::RedundantConstraint { index: 2, .. }), "{error}");
}

#[test]
fn a_constraint_without_gradient_is_redundant() {
    // φ = (r² − 0)/2 at the origin.
    let error = refusal(Particle, Rod(0.0), [0.0; 2], [0.0; 2], 0.01);
    assert!(matches!(error, LagrangianError::RedundantConstraint { index: 0, .. }), "{error}");
}

#[test]
fn as_many_constraints_as_coordinates_hold_everything() {
    struct Fixed;
    impl Holonomic<2, 2> for Fixed {
        fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 2] {
            [q[0].offset(-1.0), q[1].offset(-2.0)]
        }
    }
    let mut phase = Phase::new(0.0, [1.0, 2.0], [0.0, 0.0]);
    let mut rattle = Rattle::new(Constraints::new(Fixed));
    for _ in 0..10 {
        rattle.step(&EulerLagrange::new(Particle), &mut phase, 0.1).unwrap();
    }
    assert_eq!((phase.q, phase.v), ([1.0, 2.0], [0.0, 0.0]));
    let mean = rattle.reaction().unwrap().mean;
    assert!(mean[0].abs() < 1e-12 && (mean[1] - G).abs() < 1e-12, "{mean:?}");
}

#[test]
fn no_constraints_are_verlet() {
    struct Nothing;
    impl Holonomic<2, 0> for Nothing {
        fn constraint<S: Scalar>(&self, _: &[S; 2], _: S) -> [S; 0] {
            []
        }
    }
    let mut phase = Phase::new(0.0, [1.0, 2.0], [3.0, 0.0]);
    let mut rattle = Rattle::new(Constraints::new(Nothing));
    for _ in 0..10 {
        rattle.step(&EulerLagrange::new(Particle), &mut phase, 0.1).unwrap();
    }
    // Verlet is exact for a constant force.
    assert!((phase.q[0] - 4.0).abs() < 1e-14 && (phase.q[1] - (2.0 - 0.5 * G)).abs() < 1e-14, "{phase:?}");
}

#[test]
fn a_step_too_long_for_the_rod_is_not_taken() {
    // In 10 s the particle would fly 100 m past a rod of 1 m: no μ along ∇φ brings it back.
    let error = refusal(Particle, Rod(1.0), [1.0, 0.0], [0.0, 10.0], 10.0);
    assert!(matches!(error, LagrangianError::NotConverged { method: "RATTLE", .. }), "{error}");
    // The same in the general form.
    let error = refusal(Polar, PolarParabola, polar_start(), [0.0; 2], 50.0);
    assert!(matches!(error, LagrangianError::NotConverged { method: "RATTLE", .. }), "{error}");
}

/// After a refused step a run goes on as if that step had never been tried, history included.
#[test]
fn a_refused_step_leaves_no_trace() {
    let system = EulerLagrange::new(Particle);
    for composition in [Composition::Second, Composition::Fourth] {
        let run = |interrupted: &[usize]| {
            let mut rattle = Rattle::composed(rod(), composition);
            let mut phase = Phase::new(0.0, [0.6, -0.8], [8.0, 6.0]);
            for n in 0..40 {
                if interrupted.contains(&n) {
                    let before = phase.clone();
                    rattle.step(&system, &mut phase, 10.0).unwrap_err();
                    assert_eq!(phase, before);
                }
                rattle.step(&system, &mut phase, 0.01).unwrap();
            }
            (phase, rattle.reaction().unwrap().clone())
        };
        assert_eq!(run(&[]), run(&[1, 2, 17]));
    }
}

#[test]
fn numbers_that_are_none_are_refused() {
    let error = refusal(Particle, Rod(1.0), [f64::NAN, 0.0], [0.0; 2], 0.01);
    assert!(
        matches!(error, LagrangianError::NonFinite { symbol: Symbol::Coordinate, index: 0, .. }),
        "{error}"
    );
    let error = refusal(Particle, Rod(1.0), [1.0, 0.0], [0.0, f64::INFINITY], 0.01);
    assert!(
        matches!(error, LagrangianError::NonFinite { symbol: Symbol::Velocity, index: 1, .. }),
        "{error}"
    );
    for h in [0.0, -0.01, f64::NAN, f64::INFINITY] {
        let error = refusal(Particle, Rod(1.0), [1.0, 0.0], [0.0; 2], h);
        assert!(matches!(error, LagrangianError::Step { .. }), "{error}");
    }
    struct Undefined;
    impl Holonomic<2, 1> for Undefined {
        fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 1] {
            [q[0].offset(-2.0).sqrt()]
        }
    }
    let error = refusal(Particle, Undefined, [1.0, 0.0], [0.0; 2], 0.01);
    assert!(
        matches!(error, LagrangianError::NonFinite { symbol: Symbol::Constraint, index: 0, .. }),
        "{error}"
    );
}

#[test]
fn a_mass_that_is_none_is_named() {
    let q = joints([0.5, 2.0], [1.0, 0.5]);
    let error = refusal(TwoMasses([1.0, 0.0]), TwoRods([1.0, 0.5]), q, [0.0; 4], 0.01);
    let LagrangianError::SingularMass { null_direction, .. } = error else { panic!("{error}") };
    assert_eq!(null_direction, [0.0, 0.0, 1.0, 0.0]);
}

/// A triangle of rods with a fourth rod doubled, at run-time size.
#[test]
fn a_rod_twice_in_a_framework_is_redundant() {
    struct Framework;
    impl SlicedHolonomic for Framework {
        fn dimension(&self) -> usize {
            6
        }
        fn count(&self) -> usize {
            4
        }
        fn constraint_into<S: Scalar>(&self, q: &[S], _: S, phi: &mut [S]) {
            let pairs = [(0, 1), (1, 2), (2, 0), (0, 2)];
            for (phi, (a, b)) in phi.iter_mut().zip(pairs) {
                let square = (q[2 * a] - q[2 * b]).square() + (q[2 * a + 1] - q[2 * b + 1]).square();
                *phi = square.sqrt().offset(-1.0);
            }
        }
    }
    let mut phase = Phase::new(0.0, vec![0.0, 0.0, 1.0, 0.0, 0.5, 0.75f64.sqrt()], vec![0.0; 6]);
    let mut rattle = Rattle::new(SlicedConstraints::new(Framework));
    let system = SlicedEulerLagrange::new(Masses { number: 3, mass: 1.0 });
    let error = rattle.step(&system, &mut phase, 0.01).unwrap_err();
    let LagrangianError::RedundantConstraint { index, combination, .. } = error else { panic!("{error}") };
    assert_eq!(index, 3);
    let exact = [0.0, 0.0, -(0.5f64.sqrt()), 0.5f64.sqrt()];
    assert!(crate::fixture::largest_gap(&combination, &exact) < 1e-12, "{combination:?}");
}

#[test]
fn there_is_no_way_back_to_a_contradiction() {
    struct Nowhere;
    impl Holonomic<2, 1> for Nowhere {
        fn constraint<S: Scalar>(&self, q: &[S; 2], _: S) -> [S; 1] {
            [q[0].square().offset(1.0)]
        }
    }
    let (system, constraints) = (EulerLagrange::new(Particle), Constraints::new(Nowhere));
    let mut phase = Phase::new(0.0, [1.7, 0.0], [1.0, 0.0]);
    let before = phase.clone();
    let error = Constrained::new(&system, &constraints).project(&mut phase).unwrap_err();
    assert!(matches!(error, LagrangianError::NotConverged { .. }), "{error}");
    assert_eq!(phase, before);
}

/// Rods of all lengths, 1e-6 off: the tolerance must not know what a metre is.
#[test]
fn a_violated_start_is_refused_at_every_scale() {
    for length in [1e-4, 1e-2, 1.0, 1e4, 1e100] {
        let speed = (G * length).sqrt();
        let error = refusal(Particle, Rod(length), [length * (1.0 + 1e-6), 0.0], [0.0, speed], 1e-6);
        assert!(
            matches!(error, LagrangianError::ConstraintViolated { level: ConstraintLevel::Position, .. }),
            "{length} m: {error}"
        );
        let error = refusal(Particle, Rod(length), [length, 0.0], [1e-6 * speed, speed], 1e-6);
        assert!(
            matches!(error, LagrangianError::ConstraintViolated { level: ConstraintLevel::Velocity, .. }),
            "{length} m: {error}"
        );
        let system = EulerLagrange::new(Particle);
        let constraints = Constraints::new(Rod(length));
        let constrained = Constrained::new(&system, &constraints);
        constrained.check(&Phase::new(0.0, [length * (1.0 + 1e-11), 0.0], [1e-11 * speed, speed])).unwrap();
    }
}

/// G M⁻¹ Gᵀ overflows although G is finite.
#[test]
fn an_overflow_is_not_called_redundant() {
    let error = refusal(Particle, Rod(1e160), [1e160, 0.0], [0.0, 0.0], 0.01);
    assert!(matches!(error, LagrangianError::NonFinite { symbol: Symbol::Constraint, .. }), "{error}");
}
