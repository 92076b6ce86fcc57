//! Terms that lie, at every answer in turn: every stepper sees through it, and is not the worse for it.

use crate::lying::{Fault, LIES, Lasting, Lie, Lying, Question, Step, Switch, every_answer_in_turn};
use crate::resumed::{Body, SCHEMES, STEP};
use lagrangian::stepper::{ExplicitScheme, ExplicitStepper, StepError};
use mechanics_core::newton::NewtonCause;
use mechanics_core::potential::Potential;
use mechanics_core::state::State;
use std::sync::Arc;

#[test]
fn implicit_steps_see_through_every_lie() {
    for scheme in SCHEMES {
        let scene = |switch: &Arc<Switch>| -> Step {
            let Body { elastic, gravity, mut stepper, .. } = Body::new(scheme);
            let mut terms = [Lying::new(elastic, switch)];
            let mut gravity = Lying::new(gravity, switch);
            Box::new(move |state| {
                let [elastic] = &mut terms;
                let made = stepper.step(state, &mut [elastic, &mut gravity], STEP);
                made.map(drop).map_err(|error| error.to_string())
            })
        };
        // With the history of a scheme that has one.
        let mut body = Body::new(scheme);
        body.steps(3);
        let tally = every_answer_in_turn(&format!("{scheme:?}"), &LIES, &body.state, 1e-8, scene);
        assert!(tally.errors > 50 && tally.survived > 0, "{tally:?}");
    }
}

/// Without history the average acceleration asks for the forces at the start of its first step, and takes what is finite for true.
#[test]
fn a_first_step_sees_through_every_lie() {
    let scheme = lagrangian::stepper::TimeScheme::Newmark;
    let scene = |switch: &Arc<Switch>| -> Step {
        let Body { elastic, gravity, mut stepper, .. } = Body::new(scheme);
        let (mut elastic, mut gravity) = (Lying::new(elastic, switch), Lying::new(gravity, switch));
        Box::new(move |state| {
            let made = stepper.step(state, &mut [&mut elastic, &mut gravity], STEP);
            made.map(drop).map_err(|error| error.to_string())
        })
    };
    let lies: Vec<_> = LIES.into_iter().filter(|(_, lie)| *lie != Lie::Opposite).collect();
    every_answer_in_turn("Newmark, first step", &lies, &Body::new(scheme).state, 1e-8, scene);
}

#[test]
fn an_equilibrium_sees_through_every_lie() {
    let scene = |switch: &Arc<Switch>| -> Step {
        let Body { elastic, gravity, mut stepper, .. } = Body::new(SCHEMES[0]);
        let (mut elastic, mut gravity) = (Lying::new(elastic, switch), Lying::new(gravity, switch));
        Box::new(move |state| {
            let made = stepper.equilibrium(state, &mut [&mut elastic, &mut gravity], 2);
            made.map(drop).map_err(|error| error.to_string())
        })
    };
    let tally = every_answer_in_turn("equilibrium", &LIES, &Body::new(SCHEMES[0]).state, 1e-6, scene);
    assert!(tally.errors > 50, "{tally:?}");
}

/// A value that rises at every answer: from then on no step along any direction lowers it, be it the first of a step or a later one.
#[test]
fn exhausted_line_searches_say_so() {
    let switch = Arc::new(Switch::default());
    let Body { elastic, gravity, mut stepper, state: start, .. } = Body::new(SCHEMES[0]);
    let (mut elastic, mut gravity) = (Lying::new(elastic, &switch), gravity);
    let mut exhausted = 0;
    for after in 0.. {
        let (question, lie) = (Question::Value, Lie::Rising(1e3));
        switch.set(Some(Fault { question, lie, after, lasting: Lasting::FromThenOn }));
        let mut state = start.clone();
        match stepper.step(&mut state, &mut [&mut elastic, &mut gravity], STEP) {
            Ok(_) if switch.told() == 0 => break,
            // Directions tell that it is there.
            Ok(_) => {}
            Err(StepError::Newton { source, .. }) => {
                assert!(matches!(source.cause, NewtonCause::LineSearch { .. }), "{source}");
                assert!(source.report.halvings >= 52, "{source}");
                assert_eq!(state.hash(), start.hash());
                exhausted += 1;
            }
            Err(error) => panic!("{error}"),
        }
    }
    assert!(exhausted > 2, "{exhausted}");
}

/// Explicit steps ask for gradients alone, and nothing but NaN tells a wrong one from a right one.
#[test]
fn explicit_steps_see_through_what_is_no_number() {
    for scheme in [ExplicitScheme::SymplecticEuler, ExplicitScheme::CentralDifferences] {
        for lie in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let switch = Arc::new(Switch::default());
            let Body { elastic, gravity, mass, map, mut state, .. } = Body::new(SCHEMES[0]);
            let (mut elastic, mut gravity) = (Lying::new(elastic, &switch), Lying::new(gravity, &switch));
            let stepper = ExplicitStepper::new(scheme, mass, map).unwrap();
            let mut step = |state: &mut State| {
                let terms: &mut [&mut dyn Potential] = &mut [&mut elastic, &mut gravity];
                stepper.step(state, terms, 1e-4)
            };
            let lies = lies_about_gradients(lie);
            for _ in 0..3 {
                let (start, mut truth) = (state.clone(), state.clone());
                step(&mut truth).unwrap();
                let mut errors = 0;
                for fault in &lies {
                    switch.set(Some(*fault));
                    if let Err(error) = step(&mut state) {
                        assert!(error.to_string().contains("elastic"), "{error}");
                        errors += 1;
                    } else {
                        assert_eq!(switch.told(), 0, "{scheme:?}: {fault:?} is believed");
                        assert_eq!(state.hash(), truth.hash());
                        state = start.clone();
                    }
                    assert_eq!(state.hash(), start.hash());
                }
                assert!(errors >= 2, "{scheme:?}: {errors}");
                switch.set(None);
                step(&mut state).unwrap();
                assert_eq!(state.hash(), truth.hash());
            }
        }
    }
}

fn lies_about_gradients(number: f64) -> Vec<Fault> {
    let fault = |after| Fault {
        question: Question::Gradient,
        lie: Lie::Number(number),
        after,
        lasting: Lasting::Once,
    };
    (0..6).map(fault).collect()
}
