//! What has no stationary action, and must not be given one in silence.
#![allow(clippy::unwrap_used)]

use lagrangian::action::{Action, Galerkin, Search};
use lagrangian::error::PathFailure;
use lagrangian::systems::MassOnSpring;
use lagrangian::{EulerLagrange, Lagrangian, LagrangianError};
use mechanics_core::scalar::Scalar;
use std::f64::consts::PI;

/// Friction that grows with the cube of the speed: at rest neither it nor its slope is there.
struct CubicFriction;

impl Lagrangian<1> for CubicFriction {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].square().scale(0.5)
    }
    fn rayleigh<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().square().scale(0.25)
    }
}

#[test]
fn friction_that_a_guess_at_rest_does_not_show_is_refused() {
    let system = EulerLagrange::new(CubicFriction);
    let action = Action::new(&system, 0.0, 1.0, 10, Galerkin { degree: 3 }).unwrap();
    let rest = action.straight(&[1.0], &[1.0]);
    for refused in [
        action.stationary(&rest, &Search::default()).unwrap_err(),
        action.descend(&rest, &Search::default()).unwrap_err(),
    ] {
        assert!(matches!(refused, LagrangianError::NoAction { coordinate: 0, .. }), "{refused}");
    }
    // At the bottom nothing moves, and nothing rubs.
    let still = action.stationary(&action.straight(&[0.0], &[0.0]), &Search::default()).unwrap();
    assert_eq!(still.action, 0.0);
}

/// L = ½ v² − ln q, of which nothing is left for q < 0; in no coordinates, NaN.
struct Logarithm;

impl Lagrangian<1> for Logarithm {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].ln()
    }
}

impl Lagrangian<0> for Logarithm {
    fn kinetic<S: Scalar>(&self, _q: &[S; 0], _v: &[S; 0], _t: S) -> S {
        S::constant(f64::NAN)
    }
    fn potential<S: Scalar>(&self, _q: &[S; 0], _t: S) -> S {
        S::constant(0.0)
    }
}

#[test]
fn an_action_that_is_no_number_is_refused_even_with_nothing_to_vary() {
    let system = EulerLagrange::<_, 1>::new(Logarithm);
    for (n, degree) in [(1, 1), (1, 2), (5, 1), (5, 2)] {
        let action = Action::new(&system, 0.0, 1.0, n, Galerkin { degree }).unwrap();
        let guess = action.straight(&[-1.0], &[-1.0]);
        for refused in [
            action.stationary(&guess, &Search::default()).unwrap_err(),
            action.descend(&guess, &Search::default()).unwrap_err(),
        ] {
            assert!(
                matches!(refused, LagrangianError::NonFinite { .. }),
                "n = {n}, degree {degree}: {refused}"
            );
        }
    }
    let nothing = EulerLagrange::<_, 0>::new(Logarithm);
    let action = Action::new(&nothing, 0.0, 1.0, 3, Galerkin { degree: 2 }).unwrap();
    let refused = action.stationary(&action.straight(&[], &[]), &Search::default()).unwrap_err();
    assert!(matches!(refused, LagrangianError::NonFinite { .. }), "{refused}");
}

#[test]
fn descent_to_a_conjugate_end_says_so_at_once() {
    let system = EulerLagrange::new(MassOnSpring::new(1.0, 1.0).unwrap());
    let action = Action::new(&system, 0.0, PI, 20, Galerkin { degree: 4 }).unwrap();
    let refused = action.descend(&action.straight(&[1.0], &[1.0]), &Search::default()).unwrap_err();
    let LagrangianError::NoStationaryPath { failure, iterations, .. } = refused else { panic!("{refused}") };
    assert_eq!(failure, PathFailure::Conjugate);
    assert!(iterations < 20, "{iterations} iterations");
}
