//! Chains of run-time length.

use crate::systems::*;
use lagrangian::constraint::{Composition, ConstraintSet, ExpansionOf, Rattle, SlicedConstraints};
use lagrangian::constraint::{Constraints, SlicedHolonomic};
use lagrangian::integrator::Integrator;
use lagrangian::{EulerLagrange, Phase, SlicedEulerLagrange, System};
use mechanics_core::scalar::Scalar;

/// A chain stretched out sideways, at rest.
fn stretched(rods: Rods) -> Phase<Vec<f64>> {
    let q = (0..2 * rods.number).map(|i| if i % 2 == 0 { rods.length * (i / 2 + 1) as f64 } else { 0.0 });
    Phase::new(0.0, q.collect(), vec![0.0; 2 * rods.number])
}

/// The largest |φ| and energy error of a chain of twenty in two seconds.
fn whip(h: f64) -> [f64; 2] {
    let rods = Rods { number: 20, length: 0.05 };
    let system = SlicedEulerLagrange::new(Masses { number: 20, mass: 0.1 });
    let constraints = SlicedConstraints::new(rods);
    assert_eq!(constraints.directions(), 4, "two coordinates of two neighbours");
    let mut rattle = Rattle::new(constraints.clone());
    let mut phase = stretched(rods);
    let mut at = ExpansionOf::<SlicedConstraints<Rods>>::zeros(constraints.shape());
    let mut worst = [0.0f64; 2];
    while phase.time < 2.0 {
        rattle.step(&system, &mut phase, h).unwrap();
        constraints.expand(phase.time, &phase.q, &mut at);
        worst[0] = at.value.iter().fold(worst[0], |worst, phi| worst.max(phi.abs()));
        // Of 0.1 · 20 · 9.81 · 0.5 = 9.81 J that can turn into motion.
        worst[1] = worst[1].max(system.energy(phase.time, &phase.q, &phase.v).abs() / 9.81);
    }
    worst
}

/// The chain swings down and whips; its energy error stays of second order.
#[test]
fn twenty_links_keep_lengths_and_energy() {
    let (coarse, fine) = (whip(4e-4), whip(2e-4));
    println!("chain of 20: {coarse:?} {fine:?}");
    assert!(coarse[0] < 1e-14 && fine[0] < 1e-14, "{coarse:?} {fine:?}");
    assert!(fine[1] < 3e-4 && (3.5..4.5).contains(&(coarse[1] / fine[1])), "{coarse:?} {fine:?}");
}

/// The total of horizontal reactions at the pivot is what the chain's momentum gains: Σ m v_x = ∫ λ₀ x₀ dt.
#[test]
fn the_pivot_pulls_what_the_chain_gains() {
    let rods = Rods { number: 5, length: 0.2 };
    let system = SlicedEulerLagrange::new(Masses { number: 5, mass: 0.1 });
    let error = |steps: usize| {
        let mut rattle = Rattle::new(SlicedConstraints::new(rods));
        let mut phase = stretched(rods);
        let (h, mut impulse) = (0.25 / steps as f64, 0.0);
        for _ in 0..steps {
            let before = phase.q[0];
            rattle.step(&system, &mut phase, h).unwrap();
            let reaction = rattle.reaction().unwrap();
            impulse += 0.5 * h * (reaction.first[0] * before + reaction.last[0] * phase.q[0]);
        }
        let gained: f64 = phase.v.iter().step_by(2).map(|v| 0.1 * v).sum();
        (gained - impulse).abs()
    };
    // Exactly, for every h: the discrete momentum balance.
    for steps in [50, 400] {
        assert!(error(steps) < 1e-13, "{steps}: {:e}", error(steps));
    }
}

#[test]
fn two_links_of_run_time_size_move_as_those_of_fixed_size() {
    let lengths = [0.75; 2];
    let q = joints([0.5, 2.0], lengths);
    let v = joint_velocities([0.5, 2.0], [1.0, -3.0], lengths);
    let mut fixed = Phase::new(0.0, q, v);
    let mut sliced = Phase::new(0.0, q.to_vec(), v.to_vec());
    let mut of_fixed = Rattle::composed(Constraints::new(TwoRods(lengths)), Composition::Fourth);
    let rods = SlicedConstraints::new(Rods { number: 2, length: 0.75 });
    let mut of_sliced = Rattle::composed(rods, Composition::Fourth);
    let system = EulerLagrange::new(TwoMasses([1.5; 2]));
    let masses = SlicedEulerLagrange::new(Masses { number: 2, mass: 1.5 });
    for _ in 0..200 {
        of_fixed.step(&system, &mut fixed, 0.005).unwrap();
        of_sliced.step(&masses, &mut sliced, 0.005).unwrap();
    }
    let gap = crate::fixture::largest_gap(&fixed.q, &sliced.q);
    assert!(gap < 1e-12, "{gap:e}");
}

/// More directions than one pass takes, time among them, and a constraint that mentions everything.
#[test]
fn the_compressed_jacobian_is_the_whole_one() {
    struct Mixed;
    impl SlicedHolonomic for Mixed {
        fn dimension(&self) -> usize {
            11
        }
        fn count(&self) -> usize {
            3
        }
        fn constraint_into<S: Scalar>(&self, q: &[S], t: S, phi: &mut [S]) {
            phi[0] = q.iter().fold(t.sin(), |sum, x| sum * x.offset(1.5));
            phi[1] = q[10] * q[2].square() - t;
            phi[2] = S::constant(3.0);
        }
    }
    let constraints = SlicedConstraints::new(Mixed);
    assert_eq!(constraints.directions(), 12);
    assert_eq!(
        (constraints.support(0), constraints.support(1), constraints.support(2)),
        (0..11, 2..11, 0..0)
    );
    let q: Vec<f64> = (0..11).map(|i| 0.1 * f64::from(i) - 0.3).collect();
    let mut at = ExpansionOf::<SlicedConstraints<Mixed>>::zeros(constraints.shape());
    constraints.expand(0.7, &q, &mut at);
    let product: f64 = q.iter().map(|x| x + 1.5).product();
    for j in 0..11 {
        let exact = 0.7f64.sin() * product / (q[j] + 1.5);
        assert!((at.jacobian[j] - exact).abs() < 1e-13 * exact.abs());
    }
    assert!((at.rate[0] - 0.7f64.cos() * product).abs() < 1e-13 * product);
    let mut row = [0.0; 11];
    (row[2], row[10]) = (2.0 * q[10] * q[2], q[2] * q[2]);
    assert!(crate::fixture::largest_gap(&at.jacobian[11..22], &row) < 1e-16);
    assert_eq!((at.rate[1], at.rate[2], at.value[2]), (-1.0, 0.0, 3.0));
}

/// Nothing moves, and nothing panics.
#[test]
fn a_chain_of_no_links_only_lets_time_pass() {
    let system = SlicedEulerLagrange::new(Masses { number: 0, mass: 1.0 });
    let mut rattle = Rattle::new(SlicedConstraints::new(Rods { number: 0, length: 1.0 }));
    let mut phase = Phase::new(0.0, vec![], vec![]);
    rattle.step(&system, &mut phase, 0.5).unwrap();
    assert_eq!(phase, Phase::new(0.5, vec![], vec![]));
}
