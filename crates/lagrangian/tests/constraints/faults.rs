//! Systems and constraints that answer NaN or infinity, at every call in turn: RATTLE says so, and is not the worse for it.

use crate::lying::Switch;
use crate::systems::*;
use lagrangian::constraint::{Composition, Constrained, Constraints, Holonomic, Rattle};
use lagrangian::error::LagrangianError;
use lagrangian::integrator::Integrator;
use lagrangian::{EulerLagrange, Lagrangian, Phase};
use mechanics_core::scalar::Scalar;
use std::sync::Arc;

/// A system or a constraint that lies when its switch says so.
#[derive(Clone, Debug)]
struct Lying<T> {
    truth: T,
    switch: Arc<Switch>,
}

impl<L: Lagrangian<2>> Lagrangian<2> for Lying<L> {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], t: S) -> S {
        self.switch.answer(self.truth.kinetic(q, v, t))
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], t: S) -> S {
        self.switch.answer(self.truth.potential(q, t))
    }
    fn rayleigh<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], t: S) -> S {
        self.switch.answer(self.truth.rayleigh(q, v, t))
    }
}

impl<H: Holonomic<2, 1>> Holonomic<2, 1> for Lying<H> {
    fn constraint<S: Scalar>(&self, q: &[S; 2], t: S) -> [S; 1] {
        self.truth.constraint(q, t).map(|constraint| self.switch.answer(constraint))
    }
}

/// Kinetic energy that is no quadratic form: p is not linear in v.
#[derive(Clone, Copy, Debug)]
struct Quartic;

impl Lagrangian<2> for Quartic {
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        let square = v[0].square() + v[1].square();
        square.scale(0.5) + square.square().scale(0.05)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        q[1].scale(G)
    }
}

const STEP: f64 = 0.01;
/// Steps that go before, so that start values are extrapolated.
const BEFORE: usize = 5;

fn bits(phase: &Phase<[f64; 2]>) -> Vec<u64> {
    phase.q.iter().chain(&phase.v).chain([&phase.time]).map(|x| x.to_bits()).collect()
}

/// Lies to a run at every call of a step after `before` others, and answers how many steps failed.
fn lie_in_turn<L, H>(
    name: &str,
    truth: (L, H),
    composition: Composition,
    start: &Phase<[f64; 2]>,
    before: usize,
) -> u32
where
    L: Lagrangian<2> + Clone,
    H: Holonomic<2, 1> + Clone,
{
    let switch = Arc::new(Switch::default());
    let system = EulerLagrange::new(Lying { truth: truth.0, switch: switch.clone() });
    let constraints = Constraints::new(Lying { truth: truth.1, switch: switch.clone() });
    let prepared = || {
        switch.set(0..0, 1.0);
        let (mut rattle, mut phase) = (Rattle::composed(constraints.clone(), composition), start.clone());
        for _ in 0..before {
            rattle.step(&system, &mut phase, STEP).unwrap();
        }
        (rattle, phase)
    };
    let (mut rattle, begin) = prepared();
    let reaction = rattle.reaction().cloned();
    let mut truth = begin.clone();
    switch.set(0..0, 1.0);
    rattle.step(&system, &mut truth, STEP).unwrap();
    let (calls, true_reaction) = (switch.asked(), rattle.reaction().cloned());
    let (mut errors, mut survived) = (0, 0);
    for (factor, lasting) in
        [(f64::NAN, 1), (f64::NAN, u64::MAX / 2), (f64::INFINITY, 1), (f64::NEG_INFINITY, u64::MAX / 2)]
    {
        let (mut rattle, _) = prepared();
        for call in 0..calls {
            let mut phase = begin.clone();
            switch.set(call..call + lasting, factor);
            let outcome = rattle.step(&system, &mut phase, STEP);
            switch.set(0..0, 1.0);
            match outcome {
                Err(error) => {
                    assert_eq!(bits(&phase), bits(&begin), "{name}, call {call}: {error}");
                    assert_eq!(rattle.reaction().cloned(), reaction, "{name}, call {call}: {error}");
                    assert!(
                        matches!(
                            error,
                            LagrangianError::NonFinite { .. } | LagrangianError::NotConverged { .. }
                        ),
                        "{name}, {factor} at call {call} of {calls} is called something else: {error}"
                    );
                    errors += 1;
                }
                Ok(_) => {
                    let pairs = phase.q.iter().chain(&phase.v).zip(truth.q.iter().chain(&truth.v));
                    // A NaN is no distance.
                    let far =
                        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, |m: f64, d| if d <= m { m } else { d });
                    assert!(far < 1e-12, "{name}: {factor} at call {call} of {calls} is believed: {far:e}");
                    survived += 1;
                    rattle = prepared().0;
                }
            }
        }
        // After all these errors, history and all, it goes on as if none had been.
        let mut phase = begin.clone();
        rattle.step(&system, &mut phase, STEP).unwrap();
        assert_eq!(bits(&phase), bits(&truth), "{name}");
        assert_eq!(rattle.reaction().cloned(), true_reaction, "{name}");
    }
    println!(
        "{name}, {composition:?} after {before} steps: {calls} calls, {errors} errors, {survived} survived"
    );
    errors
}

/// The first step, which looks at the start, and one with history; Andersen's form and both general ones, of one and of several sub-steps.
#[test]
fn systems_and_constraints_that_are_no_number_at_some_call_are_errors_that_leave_no_trace() {
    let hanging = Phase::new(0.0, [0.6, -0.8], [8.0, 6.0]);
    let polar = Phase::new(0.0, polar_start(), [0.0; 2]);
    for composition in [Composition::Second, Composition::Fourth] {
        for before in [0, BEFORE] {
            let counts = [
                lie_in_turn("rod", (Particle, Rod(1.0)), composition, &hanging, before),
                lie_in_turn("damped", (Damped { damping: 0.3 }, Rod(1.0)), composition, &hanging, before),
                lie_in_turn("polar", (Polar, PolarParabola), composition, &polar, before),
                lie_in_turn("quartic", (Quartic, Rod(1.0)), composition, &hanging, before),
            ];
            assert!(counts.iter().all(|errors| *errors > 10), "{counts:?}");
        }
    }
}

/// What is asked of a state, and may move it.
type Question<'a> = &'a dyn Fn(&mut Phase<[f64; 2]>) -> Result<(), LagrangianError>;

/// Questions about one state, and the way back to the constraints.
#[test]
fn questions_at_one_state_are_errors_where_functions_are_no_number() {
    let switch = Arc::new(Switch::default());
    let system = EulerLagrange::new(Lying { truth: Polar, switch: switch.clone() });
    let constraints = Constraints::new(Lying { truth: PolarParabola, switch: switch.clone() });
    let constrained = Constrained::new(&system, &constraints);
    let on = Phase::new(0.0, polar_start(), [0.0; 2]);
    let mut beside = on.clone();
    beside.q[0] += 0.01;
    beside.v = [0.3, -0.2];
    let questions: [Question<'_>; 3] =
        [&|phase| constrained.check(phase), &|phase| constrained.motion(phase).map(drop), &|phase| {
            constrained.project(phase)
        }];
    for (question, start) in questions.iter().zip([&on, &on, &beside]) {
        let mut truth = start.clone();
        switch.set(0..0, 1.0);
        question(&mut truth).unwrap();
        for call in 0..switch.asked() {
            for lasting in [1, u64::MAX / 2] {
                let mut phase = start.clone();
                switch.set(call..call + lasting, f64::NAN);
                match question(&mut phase) {
                    Err(error) => assert_eq!(bits(&phase), bits(start), "call {call}: {error}"),
                    Ok(()) => {
                        let pairs = phase.q.iter().chain(&phase.v).zip(truth.q.iter().chain(&truth.v));
                        assert!(
                            pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-9),
                            "call {call} is believed: {phase:?}"
                        );
                    }
                }
            }
        }
    }
}
