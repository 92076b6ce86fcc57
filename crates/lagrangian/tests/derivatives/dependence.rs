//! What formulas mention.

use crate::systems::{Chain, DoublePendulum};
use lagrangian::system::Dependence;
use lagrangian::{EulerLagrange, Lagrangian, SlicedEulerLagrange, System};
use mechanics_core::scalar::{Mask, Scalar};

fn of<const N: usize>(lagrangian: impl Lagrangian<N>) -> Dependence {
    EulerLagrange::new(lagrangian).dependence(0.3, &[0.7; N], &[-0.4; N])
}

#[test]
fn the_double_pendulum_couples_through_its_kinetic_energy() {
    let found = of(DoublePendulum { mass: [2.0, 1.0], length: [1.0, 0.5] });
    assert_eq!(found.kinetic_on_q, [true, true]);
    assert_eq!(found.potential_on_q, [true, true]);
    assert!(
        found.kinetic_quadratic && !found.applied() && !found.kinetic_on_time && !found.potential_on_time
    );
    assert_eq!(found.applied_on, [false, false]);
}

/// Kinetic energies by a closure-like enum, so that one test can ask many.
#[derive(Clone, Copy, Debug)]
enum Kinetic {
    Polar,
    Magnetic,
    Relativistic,
    RotatingFrame,
    Cancelling,
    Selected,
    Branching,
    Comparing,
    Powers,
    Quotient,
    Zero,
    ValueOnly,
    Differentiated,
}

impl Lagrangian<2> for Kinetic {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], t: S) -> S {
        let square = v[0].square() + v[1] * v[1];
        match self {
            Self::Polar => v[0].square() + q[0].square() * v[1].square(),
            Self::Magnetic => square + q[1] * v[0],
            Self::Relativistic => -(S::constant(1.0) - square).sqrt(),
            Self::RotatingFrame => square + (q[0] * t.cos()).square(),
            Self::Cancelling => square + q[0] + -q[0],
            Self::Selected => S::select(q[1].less(t), square, square.scale(2.0)),
            Self::Branching => {
                if q[0].less(q[1]).any() {
                    square * q[0]
                } else {
                    square
                }
            }
            Self::Comparing => {
                if v[0] == v[1] {
                    square
                } else {
                    square.scale(2.0)
                }
            }
            Self::Powers => v[0].powi(2) + v[1].powf(2.0),
            Self::Quotient => (v[0] * v[1] + square) / q[0].exp(),
            Self::Zero => square + q[0].sin() * S::constant(0.0) * v[0],
            Self::ValueOnly => square * S::lift(q[1].value()),
            // As laws do that know a cheaper way to the value alone: jets take the first branch, and so must the trace.
            Self::Differentiated => {
                if S::DIFFERENTIATES {
                    square * q[0].square().exp()
                } else {
                    square
                }
            }
        }
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        q[0].max(S::constant(0.5))
    }
}

#[test]
fn degrees_in_the_velocities_are_those_of_the_formulas() {
    use Kinetic::*;
    for (kinetic, quadratic) in [
        (Polar, true),
        (Magnetic, false),
        (Relativistic, false),
        (RotatingFrame, false),
        (Cancelling, false),
        (Selected, true),
        (Branching, false),
        (Comparing, false),
        (Powers, true),
        (Quotient, true),
        (Zero, true),
        (ValueOnly, true),
        (Differentiated, true),
    ] {
        assert_eq!(of(kinetic).kinetic_quadratic, quadratic, "{kinetic:?}");
    }
}

#[test]
fn mentions_err_on_the_safe_side_only() {
    use Kinetic::*;
    for (kinetic, on_q, on_time) in [
        (Polar, [true, false], false),
        (Magnetic, [false, true], false),
        (Relativistic, [false, false], false),
        (RotatingFrame, [true, false], true),
        (Cancelling, [true, false], false),
        (Selected, [false, true], true),
        // Which branch was not taken cannot be known.
        (Branching, [true, true], true),
        (Comparing, [true, true], true),
        (Powers, [false, false], false),
        (Quotient, [true, false], false),
        (Zero, [false, false], false),
        (ValueOnly, [false, true], false),
        (Differentiated, [true, false], false),
    ] {
        let found = of(kinetic);
        assert_eq!(found.kinetic_on_q, on_q, "{kinetic:?}");
        assert_eq!(found.kinetic_on_time, on_time, "{kinetic:?}");
        // Branching in T says nothing about V.
        assert_eq!(found.potential_on_q, [true, false], "{kinetic:?}");
        assert!(!found.potential_on_time && !found.applied());
    }
}

#[test]
fn hundreds_of_coordinates_are_told_apart() {
    let chain = |damping, pull| {
        let system = SlicedEulerLagrange::new(Chain { masses: 150, damping, pull });
        system.dependence(0.1, &vec![0.2; 150], &vec![0.3; 150])
    };
    let free = chain(0.0, 0.0);
    assert_eq!(free.kinetic_on_q, vec![false; 150]);
    assert_eq!(free.potential_on_q, vec![true; 150]);
    assert!(free.kinetic_quadratic && !free.applied());
    let pulled = chain(0.0, 2.0);
    let last: Vec<bool> = (0..150).map(|i| i == 149).collect();
    assert_eq!(pulled.applied_on, last);
    assert!(pulled.applied() && pulled.kinetic_quadratic && !pulled.potential_on_time);
    assert_eq!(chain(0.1, 0.0).applied_on, vec![true; 150]);
}
