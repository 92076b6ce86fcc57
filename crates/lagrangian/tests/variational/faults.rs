//! Systems whose functions answer NaN, at every call in turn: every integrator says so, and is not the worse for it.

#![allow(clippy::print_stdout, reason = "a test prints what it counted")]

use crate::lying::Switch;
use crate::systems::REGULAR;
use lagrangian::integrator::{
    AdamsBashforthMoulton, Bdf2, DiscreteEulerLagrange, DormandPrince853, GaussLegendre, ImplicitEuler,
    Integrator, RungeKutta4, StormerVerlet,
};
use lagrangian::{EulerLagrange, Lagrangian, LagrangianError, Phase};
use mechanics_core::scalar::Scalar;
use std::sync::Arc;

/// A system of constant mass that lies when its switch says so.
#[derive(Clone, Debug)]
struct Lying(Arc<Switch>);

impl Lagrangian<2> for Lying {
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        self.0.answer(v[0].square() + v[1].square().scale(0.5))
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], t: S) -> S {
        self.0.answer(REGULAR.potential(q, t) + (q[0] * q[1]).square())
    }
}

type Boxed = Box<dyn Integrator<EulerLagrange<Lying, 2>>>;

fn methods(system: &EulerLagrange<Lying, 2>) -> Vec<Boxed> {
    vec![
        Box::new(AdamsBashforthMoulton::<4, _>::new(system)),
        Box::new(Bdf2::new()),
        Box::new(DiscreteEulerLagrange::midpoint()),
        Box::new(DiscreteEulerLagrange::trapezoidal()),
        Box::new(DormandPrince853::new(system)),
        Box::new(GaussLegendre::<2, _>::new()),
        Box::new(GaussLegendre::<6, _>::new()),
        Box::new(ImplicitEuler::new()),
        Box::new(RungeKutta4::new(system)),
        Box::new(StormerVerlet::new(system)),
    ]
}

const STEP: f64 = 0.02;
/// Steps before, so that methods with history have it.
const BEFORE: usize = 9;

fn bits(phase: &Phase<[f64; 2]>) -> Vec<u64> {
    phase.q.iter().chain(&phase.v).chain([&phase.time]).map(|x| x.to_bits()).collect()
}

#[test]
fn a_system_that_is_no_number_at_some_call_is_an_error_that_leaves_no_trace() {
    let switch = Arc::new(Switch::default());
    let system = EulerLagrange::new(Lying(switch.clone()));
    for which in 0..methods(&system).len() {
        let prepared = || {
            switch.set(0..0, 1.0);
            let mut integrator = methods(&system).swap_remove(which);
            let mut phase = Phase::new(0.0, [1.0, 0.5], [0.2, -0.3]);
            for _ in 0..BEFORE {
                integrator.step(&system, &mut phase, STEP).unwrap();
            }
            (integrator, phase)
        };
        let (mut integrator, start) = prepared();
        let name = integrator.method().name;
        let mut truth = start.clone();
        switch.set(0..0, 1.0);
        integrator.step(&system, &mut truth, STEP).unwrap();
        let calls = switch.asked();
        let (mut errors, mut survived) = (0, 0);
        for lasting in [1, u64::MAX / 2] {
            let (mut integrator, _) = prepared();
            for call in 0..calls {
                switch.set(call..call + lasting, f64::NAN);
                let mut phase = start.clone();
                let outcome = integrator.step(&system, &mut phase, STEP);
                switch.set(0..0, 1.0);
                match outcome {
                    Err(error) => {
                        assert_eq!(bits(&phase), bits(&start), "{name}, call {call}: {error}");
                        assert!(
                            matches!(
                                error,
                                LagrangianError::NonFinite { .. } | LagrangianError::NotConverged { .. }
                            ),
                            "{name}, call {call} is called something else: {error}"
                        );
                        errors += 1;
                    }
                    Ok(_) => {
                        let pairs = phase.q.iter().chain(&phase.v).zip(truth.q.iter().chain(&truth.v));
                        let far = pairs
                            .map(|(a, b)| (a - b).abs())
                            .fold(0.0, |m: f64, d| if d <= m { m } else { d });
                        assert!(far < 1e-9, "{name}: NaN at call {call} of {calls} is believed: {far:e}");
                        survived += 1;
                        integrator = prepared().0;
                    }
                }
            }
            // After all these errors, history and all, it goes on as if none had been.
            let mut phase = start.clone();
            integrator.step(&system, &mut phase, STEP).unwrap();
            assert_eq!(bits(&phase), bits(&truth), "{name}");
        }
        println!("{name}: {calls} calls, {errors} errors, {survived} survived");
        assert!(errors > 0, "{name}");
    }
}
