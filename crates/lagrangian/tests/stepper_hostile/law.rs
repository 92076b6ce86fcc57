//! Hyperelastic laws that are no number, at every call in turn, in every stepper of bodies.

use crate::lying::{Lasting, Lie, Question, Step, Switch, every_answer_in_turn};
use crate::resumed::{Body, SCHEMES, STEP, bar};
use lagrangian::element::Tetrahedra;
use lagrangian::stepper::{ExplicitScheme, ExplicitStepper, TimeScheme};
use mechanics_core::law::{Domain, Hyperelastic, NeoHookean, Stiffness};
use mechanics_core::parallel::with_threads;
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::{Mat3, Matrix3, from_entries};
use std::sync::Arc;

/// A law that lies when its switch says so, to all elements that are computed together.
struct LyingLaw<L> {
    law: L,
    switch: Arc<Switch>,
}

impl<L> LyingLaw<L> {
    fn lie(&self, question: Question) -> Option<f64> {
        match self.switch.ask(question) {
            Some(Lie::Number(number)) => Some(number),
            _ => None,
        }
    }
}

impl<L: Hyperelastic> Hyperelastic for LyingLaw<L> {
    fn energy_density<S: Scalar>(&self, f: &Matrix3<S>) -> S {
        self.lie(Question::Value).map_or_else(|| self.law.energy_density(f), S::constant)
    }

    /// A lie is told in one entry.
    fn first_piola<S: Scalar>(&self, f: &Matrix3<S>) -> Matrix3<S> {
        let truth = self.law.first_piola(f);
        let Some(number) = self.lie(Question::Gradient) else { return truth };
        from_entries(|i, j| if (i, j) == (1, 1) { S::constant(number) } else { truth[(i, j)] })
    }

    fn stiffness<S: Scalar>(&self, f: &Matrix3<S>, projection: Projection) -> Stiffness<S> {
        let Some(number) = self.lie(Question::Hessian) else { return self.law.stiffness(f, projection) };
        Stiffness::from_blocks(|_, _| from_entries(|_, _| S::constant(number)))
    }

    fn domain(&self) -> Domain {
        self.law.domain()
    }

    fn largest_step(&self, f: &Mat3, df: &Mat3) -> f64 {
        self.law.largest_step(f, df)
    }
}

const LIES: [(Question, Lie); 7] = [
    (Question::Value, Lie::Number(f64::NAN)),
    (Question::Value, Lie::Number(f64::INFINITY)),
    (Question::Value, Lie::Number(f64::NEG_INFINITY)),
    (Question::Gradient, Lie::Number(f64::NAN)),
    (Question::Gradient, Lie::Number(f64::NEG_INFINITY)),
    (Question::Hessian, Lie::Number(f64::NAN)),
    (Question::Hessian, Lie::Number(f64::INFINITY)),
];

fn lying(switch: &Arc<Switch>) -> StencilTerm<Tetrahedra<LyingLaw<NeoHookean>>, 4> {
    let (mesh, law) = bar();
    Tetrahedra::term("elasticity of the bar", LyingLaw { law, switch: switch.clone() }, &mesh).unwrap()
}

/// The words of an error; of a lie that goes on it names the term and an element.
fn told(switch: &Switch, error: &impl std::error::Error) -> String {
    let fault = *switch.fault();
    let words = error.to_string();
    if fault.is_some_and(|fault| fault.lasting == Lasting::FromThenOn) {
        assert!(words.contains("elasticity of the bar") && words.contains("element"), "{fault:?}: {words}");
    }
    words
}

#[test]
fn implicit_steps_see_through_a_law_that_is_no_number() {
    for scheme in [TimeScheme::Bdf2, TimeScheme::ImplicitMidpoint] {
        let scene = |switch: &Arc<Switch>| -> Step {
            let Body { mut gravity, mut stepper, .. } = Body::new(scheme);
            let (mut elastic, switch) = (lying(switch), switch.clone());
            Box::new(move |state| {
                let made = stepper.step(state, &mut [&mut elastic, &mut gravity], STEP);
                made.map(drop).map_err(|error| told(&switch, &error))
            })
        };
        let mut body = Body::new(scheme);
        body.steps(3);
        let name = format!("law, {scheme:?}");
        let tally = with_threads(1, || every_answer_in_turn(&name, &LIES, &body.state, 1e-8, scene));
        assert!(tally.errors > 50 && tally.survived > 0, "{tally:?}");
    }
}

#[test]
fn an_equilibrium_sees_through_a_law_that_is_no_number() {
    let scene = |switch: &Arc<Switch>| -> Step {
        let Body { mut gravity, mut stepper, .. } = Body::new(SCHEMES[0]);
        let (mut elastic, switch) = (lying(switch), switch.clone());
        Box::new(move |state| {
            let made = stepper.equilibrium(state, &mut [&mut elastic, &mut gravity], 1);
            made.map(drop).map_err(|error| told(&switch, &error))
        })
    };
    let start = Body::new(SCHEMES[0]).state;
    let tally = with_threads(1, || every_answer_in_turn("law, equilibrium", &LIES, &start, 1e-6, scene));
    assert!(tally.errors > 50, "{tally:?}");
}

/// Explicit steps ask for stress alone.
#[test]
fn explicit_steps_see_through_a_law_that_is_no_number() {
    for scheme in [ExplicitScheme::SymplecticEuler, ExplicitScheme::CentralDifferences] {
        let scene = |switch: &Arc<Switch>| -> Step {
            let Body { mut gravity, mass, map, .. } = Body::new(SCHEMES[0]);
            let stepper = ExplicitStepper::new(scheme, mass, map).unwrap();
            let (mut elastic, switch) = (lying(switch), switch.clone());
            Box::new(move |state| {
                let made = stepper.step(state, &mut [&mut elastic, &mut gravity], 1e-4);
                made.map_err(|error| told(&switch, &error))
            })
        };
        let mut body = Body::new(SCHEMES[0]);
        body.steps(3);
        let name = format!("law, {scheme:?}");
        let tally = with_threads(1, || every_answer_in_turn(&name, &LIES, &body.state, 0.0, scene));
        assert!(tally.errors > 10 && tally.survived == 0, "{tally:?}");
    }
}
