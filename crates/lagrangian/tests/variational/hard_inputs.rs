//! What is refused, and that the state is then as it was, bit for bit.

use crate::systems::{Duffing, Kepler, Pendulum, REGULAR, system};
use lagrangian::error::Symbol;
use lagrangian::integrator::{
    Bdf2, DiscreteEulerLagrange, GaussLegendre, ImplicitEuler, Integrator, StormerVerlet,
};
use lagrangian::{EulerLagrange, Lagrangian, LagrangianError, Phase, SlicedEulerLagrange, SlicedLagrangian};
use mechanics_core::scalar::Scalar;

type Boxed<L, const N: usize> = Box<dyn Integrator<EulerLagrange<L, N>>>;

fn methods<const N: usize, L: Lagrangian<N> + 'static>() -> Vec<Boxed<L, N>> {
    vec![
        Box::new(DiscreteEulerLagrange::midpoint()),
        Box::new(DiscreteEulerLagrange::trapezoidal()),
        Box::new(GaussLegendre::<2, _>::new()),
        Box::new(GaussLegendre::<6, _>::new()),
        Box::new(ImplicitEuler::new()),
        Box::new(Bdf2::new()),
    ]
}

/// The error of a step that must fail and leave the state alone.
fn refusal<const N: usize, L: Lagrangian<N>>(
    integrator: &mut Boxed<L, N>,
    system: &EulerLagrange<L, N>,
    phase: &Phase<[f64; N]>,
    h: f64,
) -> LagrangianError {
    let mut tried = phase.clone();
    let error = integrator.step(system, &mut tried, h).unwrap_err();
    let bits = |phase: &Phase<[f64; N]>| {
        let numbers = phase.q.iter().chain(&phase.v).chain([&phase.time]);
        numbers.map(|x| x.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(bits(&tried), bits(phase), "{}", integrator.method().name);
    error
}

#[test]
fn steps_that_are_not_positive_are_refused() {
    let start = Phase::new(0.0, [1.0, 0.5], [0.0, 0.0]);
    for mut integrator in methods() {
        for h in [0.0, -0.01, f64::NAN, f64::INFINITY] {
            let error = refusal(&mut integrator, &system(REGULAR), &start, h);
            assert!(matches!(error, LagrangianError::Step { .. }), "{error}");
        }
    }
}

/// Without this, coordinates would move in a time that does not.
#[test]
fn steps_that_the_time_cannot_show_are_refused() {
    for mut integrator in methods() {
        let error =
            refusal(&mut integrator, &system(REGULAR), &Phase::new(1e16, [1.0, 0.5], [0.0, 0.0]), 0.1);
        assert_eq!(error, LagrangianError::StepTooSmall { time: 1e16, step: 0.1 });
    }
}

/// As many masses as it says, each on a spring.
#[derive(Clone, Debug)]
struct Springs(usize);

impl SlicedLagrangian for Springs {
    fn dimension(&self) -> usize {
        self.0
    }
    fn kinetic<S: Scalar>(&self, _: &[S], v: &[S], _: S) -> S {
        v.iter().fold(S::constant(0.0), |sum, v| sum + v.square())
    }
    fn potential<S: Scalar>(&self, q: &[S], _: S) -> S {
        q.iter().fold(S::constant(0.0), |sum, q| sum + q.square())
    }
}

#[test]
#[should_panic(expected = "a state of 2 coordinates and 2 velocities for a system of 3")]
fn a_state_of_another_size_is_refused() {
    let mut phase = Phase::new(0.0, vec![1.0; 2], vec![0.0; 2]);
    let _ = GaussLegendre::<2, _>::new().step(&SlicedEulerLagrange::new(Springs(3)), &mut phase, 0.1);
}

/// Three coordinates out of four would have been moved.
#[test]
#[should_panic(expected = "an integrator for 3 coordinates, a system of 4")]
fn an_integrator_of_another_size_is_refused() {
    let mut phase = Phase::new(0.0, vec![1.0; 4], vec![0.0; 4]);
    let mut verlet = StormerVerlet::new(&SlicedEulerLagrange::new(Springs(3)));
    let _ = verlet.step(&SlicedEulerLagrange::new(Springs(4)), &mut phase, 0.1);
}

#[test]
fn a_state_that_is_not_finite_is_refused_by_name() {
    for mut integrator in methods() {
        for (q, v, symbol, index) in [
            ([1.0, f64::NAN], [0.0, 0.0], Symbol::Coordinate, 1),
            ([1.0, 0.0], [f64::INFINITY, 0.0], Symbol::Velocity, 0),
        ] {
            let error = refusal(&mut integrator, &system(REGULAR), &Phase::new(2.0, q, v), 0.01);
            match error {
                LagrangianError::NonFinite { symbol: s, index: i, time, .. } => {
                    assert_eq!((s, i, time), (symbol, index, 2.0));
                }
                other => panic!("{other}"),
            }
        }
    }
}

/// The second coordinate has no inertia.
#[derive(Clone, Debug)]
struct Massless;

impl Lagrangian<2> for Massless {
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0] + v[1]).square()
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[0].square() + q[1].square()
    }
}

#[test]
fn a_singular_mass_matrix_is_refused_with_its_null_direction() {
    for mut integrator in methods() {
        let error =
            refusal(&mut integrator, &system(Massless), &Phase::new(0.0, [1.0, 0.5], [0.1, 0.2]), 0.01);
        match error {
            LagrangianError::SingularMass { null_direction, .. } => {
                assert!((null_direction[0] + null_direction[1]).abs() < 1e-15, "{null_direction:?}");
            }
            other => panic!("{other}"),
        }
    }
}

/// Straight at the centre of attraction there is no solution to converge to with such a step; whatever a method
/// answers, it is a solution or an error.
#[test]
fn a_huge_step_ends_finite_or_in_an_error_that_leaves_the_state() {
    for mut integrator in methods() {
        let system = system(Kepler);
        let mut phase = Phase::new(0.0, [1.0, 0.0], [0.0, 1.0]);
        integrator.step(&system, &mut phase, 0.01).unwrap();
        for h in [1e3, 1e6, 1e200] {
            let mut tried = phase.clone();
            match integrator.step(&system, &mut tried, h) {
                Ok(_) => tried.validate().unwrap(),
                Err(error) => {
                    assert_eq!(tried, phase);
                    assert!(
                        matches!(
                            error,
                            LagrangianError::NotConverged { .. } | LagrangianError::NonFinite { .. }
                        ),
                        "{error}"
                    );
                }
            }
        }
        integrator.step(&system, &mut phase, 0.01).unwrap();
    }
}

/// V = −exp(q) has no motion beyond a finite time: p₁ = p₀ + h exp(Q) has no root for h = 10.
#[derive(Clone, Debug)]
struct RunAway;

impl Lagrangian<1> for RunAway {
    fn kinetic<S: Scalar>(&self, _: &[S; 1], v: &[S; 1], _: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _: S) -> S {
        -q[0].exp()
    }
}

#[test]
fn equations_without_a_root_are_not_converged() {
    let start = Phase::new(0.0, [0.0], [1.0]);
    for mut integrator in methods() {
        if integrator.method().name.contains("trapezoidal") {
            continue; // explicit here: always solvable
        }
        let error = refusal(&mut integrator, &system(RunAway), &start, 10.0);
        match error {
            LagrangianError::NotConverged { method, time, step, iterations, .. } => {
                assert_eq!((method, time, step), (integrator.method().name, 0.0, 10.0));
                assert!(iterations > 0);
            }
            other => panic!("{other}"),
        }
        refusal(&mut integrator, &system(RunAway), &start, 10.0);
        integrator.step(&system(RunAway), &mut start.clone(), 0.01).unwrap();
    }
}

/// Rest is a solution: no division by zero velocities or momenta.
#[test]
fn rest_stays_rest() {
    for mut integrator in methods() {
        let mut phase = Phase::new(0.0, [0.0], [0.0]);
        for _ in 0..10 {
            integrator.step(&system(Pendulum), &mut phase, 0.1).unwrap();
        }
        assert_eq!((phase.q, phase.v), ([0.0], [0.0]));
    }
    for mut integrator in methods() {
        // sin π is not quite zero: forces of 1e-16.
        let mut phase = Phase::new(0.0, [std::f64::consts::PI], [0.0]);
        for _ in 0..10 {
            integrator.step(&system(Pendulum), &mut phase, 0.1).unwrap();
        }
        assert!(phase.v[0].abs() < 1e-14);
    }
}

/// Steps beyond the reach of the simple iteration: Newton's method takes over, and the damped forced motion follows.
#[test]
fn large_steps_are_solved_by_newton() {
    let system = system(Duffing);
    let mut gauss = GaussLegendre::<3, _>::new();
    let mut phase = Phase::new(0.0, [20.0], [0.0]);
    let mut curvatures = 0;
    for _ in 0..50 {
        curvatures += gauss.step(&system, &mut phase, 0.25).unwrap().curvatures;
    }
    assert!(curvatures > 0, "the first steps are stiff: ω h = 20 √3 · 0.25");
}
