//! Bad input: typed errors, and a state that is as it was, bit for bit.

use crate::systems::{DoublePendulum, Duffing, Kepler, Oscillator, Pendulum, of};
use lagrangian::integrator::{
    DormandPrince853, Event, Integrator, RungeKutta4, StormerVerlet, Tolerance, drive,
};
use lagrangian::{EulerLagrange, Lagrangian, LagrangianError, Phase};
use mechanics_core::scalar::Scalar;
use std::ops::ControlFlow;

fn bits<const N: usize>(phase: &Phase<[f64; N]>) -> (u64, [u64; N], [u64; N]) {
    (phase.time.to_bits(), phase.q.map(f64::to_bits), phase.v.map(f64::to_bits))
}

/// Whether every explicit method refuses a step with an error that `is` expected, and leaves the state alone.
fn all_refuse<L: Lagrangian<1>>(
    system: &EulerLagrange<L, 1>,
    phase: &Phase<[f64; 1]>,
    h: f64,
    is: impl Fn(&LagrangianError) -> bool,
) {
    let methods: [Box<dyn Integrator<EulerLagrange<L, 1>>>; 3] = [
        Box::new(RungeKutta4::new(system)),
        Box::new(StormerVerlet::new(system)),
        Box::new(DormandPrince853::new(system)),
    ];
    for mut method in methods {
        let mut moved = phase.clone();
        let error = method.step(system, &mut moved, h).unwrap_err();
        assert!(is(&error), "{}: {error}", method.method().name);
        assert_eq!(bits(&moved), bits(phase), "{}", method.method().name);
    }
}

#[test]
fn step_sizes_must_be_positive() {
    let (system, phase) = (of(Pendulum), Phase::new(0.0, [1.0], [0.0]));
    for h in [0.0, -0.0, -0.1, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        all_refuse(&system, &phase, h, |e| matches!(e, LagrangianError::Step { .. }));
        let mut moved = phase.clone();
        let error = drive::integrate(&system, &mut RungeKutta4::new(&system), &mut moved, 1.0, h);
        assert!(matches!(error, Err(LagrangianError::Step { .. })));
    }
    assert!(DormandPrince853::new(&system).with_largest_step(0.0).is_err());
}

#[test]
fn states_must_be_finite() {
    let system = of(Pendulum);
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for x in bad {
        for phase in [Phase::new(0.0, [x], [0.0]), Phase::new(0.0, [0.0], [x]), Phase::new(x, [0.0], [0.0])] {
            all_refuse(&system, &phase, 0.1, |e| matches!(e, LagrangianError::NonFinite { .. }));
            let mut moved = phase.clone();
            let refused = DormandPrince853::new(&system).integrate(&system, &mut moved, 1.0);
            assert!(refused.is_err());
            assert_eq!(bits(&moved), bits(&phase));
        }
    }
}

#[test]
fn a_step_that_overflows_is_refused() {
    let phase = Phase::new(0.0, [1e200], [1e200]);
    all_refuse(&of(Oscillator(1e60)), &phase, 1.0, |e| matches!(e, LagrangianError::NonFinite { .. }));
}

#[test]
fn tolerances_must_be_possible() {
    let system = of(Pendulum);
    for (relative, absolute) in
        [(0.0, 0.0), (-1e-9, 1e-9), (1e-9, -1e-9), (f64::NAN, 1e-9), (1e-9, f64::INFINITY)]
    {
        let refused = DormandPrince853::new(&system).with_tolerance(Tolerance { relative, absolute });
        assert!(matches!(refused, Err(LagrangianError::Tolerance { .. })));
    }
    assert!(
        DormandPrince853::new(&system).with_tolerance(Tolerance { relative: 0.0, absolute: 1e-9 }).is_ok()
    );
}

#[test]
fn intervals_must_run_forwards() {
    let (system, start) = (of(Pendulum), Phase::new(2.0, [1.0], [0.5]));
    for end in [1.0, f64::NAN, f64::INFINITY] {
        let mut phase = start.clone();
        let fixed = drive::integrate(&system, &mut RungeKutta4::new(&system), &mut phase, end, 0.1);
        assert!(matches!(fixed, Err(LagrangianError::Interval { .. })));
        let adaptive = DormandPrince853::new(&system).integrate(&system, &mut phase, end);
        assert!(matches!(adaptive, Err(LagrangianError::Interval { .. })));
        assert_eq!(bits(&phase), bits(&start));
    }
    // Times that turn back are found on the way; the state returns to where it was.
    let mut phase = start.clone();
    let times = [2.0, 3.0, 2.5];
    assert!(drive::sample(&system, &mut RungeKutta4::new(&system), &mut phase, &times, 0.1).is_err());
    assert_eq!(bits(&phase), bits(&start));
    assert!(DormandPrince853::new(&system).sample(&system, &mut phase, &times).is_err());
    assert_eq!(bits(&phase), bits(&start));
}

#[test]
fn verlet_refuses_what_is_not_separable() {
    let reason = |error: LagrangianError| match error {
        LagrangianError::NotSeparable { reason, .. } => reason,
        other => panic!("{other}"),
    };
    let system = of(DoublePendulum);
    let mut phase = Phase::new(0.0, [0.5, -0.25], [0.0, 0.5]);
    let start = phase.clone();
    let error = StormerVerlet::new(&system).step(&system, &mut phase, 0.01).unwrap_err();
    assert!(error.to_string().starts_with("Störmer–Verlet needs a separable Lagrangian"));
    assert_eq!(reason(error), "the kinetic energy depends on coordinate 0");
    assert_eq!(bits(&phase), bits(&start));

    let system = of(Duffing);
    let error =
        StormerVerlet::new(&system).step(&system, &mut Phase::new(0.0, [1.0], [0.0]), 0.01).unwrap_err();
    assert!(reason(error).starts_with("a force or dissipation"));

    let system = of(Growing);
    let error =
        StormerVerlet::new(&system).step(&system, &mut Phase::new(0.0, [1.0], [0.0]), 0.01).unwrap_err();
    assert_eq!(reason(error), "the kinetic energy depends on time");

    let system = of(Relativistic);
    let error =
        StormerVerlet::new(&system).step(&system, &mut Phase::new(0.0, [1.0], [0.1]), 0.01).unwrap_err();
    assert!(reason(error).contains("not a quadratic form"));
}

/// A mass that grows with time.
struct Growing;

impl Lagrangian<1> for Growing {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], t: S) -> S {
        t.exp() * v[0].square()
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].square()
    }
}

/// T = 1 − √(1 − v²).
struct Relativistic;

impl Lagrangian<1> for Relativistic {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        S::constant(1.0) - (S::constant(1.0) - v[0].square()).sqrt()
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].square()
    }
}

/// No inertia along the second coordinate.
struct Massless;

impl Lagrangian<2> for Massless {
    fn kinetic<S: Scalar>(&self, _q: &[S; 2], v: &[S; 2], _t: S) -> S {
        v[0].square()
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        q[0].square() + q[1].square()
    }
}

#[test]
fn singular_masses_are_named() {
    let (system, start) = (of(Massless), Phase::new(0.0, [1.0, 2.0], [0.0, 0.0]));
    let methods: [Box<dyn Integrator<EulerLagrange<Massless, 2>>>; 3] = [
        Box::new(RungeKutta4::new(&system)),
        Box::new(StormerVerlet::new(&system)),
        Box::new(DormandPrince853::new(&system)),
    ];
    for mut method in methods {
        let mut phase = start.clone();
        match method.step(&system, &mut phase, 0.1) {
            Err(LagrangianError::SingularMass { null_direction, .. }) => {
                assert_eq!(null_direction, [0.0, 1.0])
            }
            other => panic!("{}: {other:?}", method.method().name),
        }
        assert_eq!(bits(&phase), bits(&start));
    }
}

#[test]
fn a_collision_ends_in_an_error_that_names_the_time() {
    // Radial fall onto the centre of attraction from r = 1: t = π/(2√2) = 1.1107.
    let system = of(Kepler);
    let start = Phase::new(0.0, [1.0, 0.0], [0.0, 0.0]);
    let mut phase = start.clone();
    let error = DormandPrince853::new(&system).integrate(&system, &mut phase, 2.0).unwrap_err();
    let (LagrangianError::StepTooSmall { time, .. }
    | LagrangianError::NonFinite { time, .. }
    | LagrangianError::TooManySteps { time, .. }) = error
    else {
        panic!("{error}");
    };
    assert!((time - 1.110_720_734_539_591_6).abs() < 1e-6, "{error}");
    assert_eq!(bits(&phase), bits(&start));
}

#[test]
fn trial_steps_into_forbidden_ground_are_only_refused() {
    // T = 1 − √(1 − v²) is NaN beyond v = 1; steps that are too long enter there, shorter ones do not.
    let system = of(Relativistic);
    let mut phase = Phase::new(0.0, [3.0], [0.0]);
    let mut method = DormandPrince853::new(&system).with_tolerance(Tolerance::uniform(1e-9)).unwrap();
    let energy = |phase: &Phase<[f64; 1]>| 1.0 / (1.0 - phase.v[0].powi(2)).sqrt() + phase.q[0].powi(2);
    let start = energy(&phase);
    let report = method.integrate(&system, &mut phase, 20.0).unwrap();
    assert!(report.rejected > 0);
    assert!((energy(&phase) - start).abs() < 1e-5, "{:e}", energy(&phase) - start);
}

#[test]
fn steps_are_limited() {
    let (system, start) = (of(Pendulum), Phase::new(0.0, [1.0], [0.0]));
    let mut phase = start.clone();
    let error =
        DormandPrince853::new(&system).with_step_limit(7).integrate(&system, &mut phase, 100.0).unwrap_err();
    assert!(matches!(error, LagrangianError::TooManySteps { limit: 7, time, end: 100.0 } if time > 0.0));
    assert_eq!(bits(&phase), bits(&start));
}

/// ẍ = −10⁶ (x − cos t) − 10⁴ ẋ: damped far beyond critical.
struct Stiff;

impl Lagrangian<1> for Stiff {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], t: S) -> S {
        (q[0] - t.cos()).square().scale(5e5)
    }
    fn rayleigh<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(5e3)
    }
}

#[test]
fn stiffness_is_reported() {
    let system = of(Stiff);
    let mut phase = Phase::new(0.0, [1.0], [0.0]);
    let mut method = DormandPrince853::new(&system).with_tolerance(Tolerance::uniform(1e-6)).unwrap();
    let error = method.integrate(&system, &mut phase, 100.0).unwrap_err();
    let LagrangianError::Stiff { step, .. } = error else { panic!("{error}") };
    // The boundary is at h λ = 6.1 with λ = 10⁴.
    assert!((step * 1e4 - 6.1).abs() < 2.0, "{step}");
    assert!(error.to_string().contains("implicit"));
}

#[test]
fn event_functions_must_be_finite() {
    let (system, start) = (of(Pendulum), Phase::new(0.0, [1.0], [0.0]));
    let mut phase = start.clone();
    let mut events =
        [Event::new(|_, q: &[f64; 1], _| q[0] + 10.0), Event::new(|_, q: &[f64; 1], _| q[0].sqrt())];
    let error = DormandPrince853::new(&system).locate(&system, &mut phase, 10.0, &mut events).unwrap_err();
    assert!(
        matches!(error, LagrangianError::Event { index: 1, time, .. } if time > 0.4 && time < 0.7),
        "{error}"
    );
    assert_eq!(bits(&phase), bits(&start));
}

#[test]
fn an_error_on_the_way_returns_to_the_start() {
    // The fourth step leaves the domain of the potential.
    let system = of(HalfLine);
    let start = Phase::new(0.0, [0.35], [-1.0]);
    for mut method in [
        Box::new(RungeKutta4::new(&system)) as Box<dyn Integrator<EulerLagrange<HalfLine, 1>>>,
        Box::new(StormerVerlet::new(&system)),
    ] {
        let (mut phase, mut steps) = (start.clone(), 0);
        let error = drive::advance(&system, method.as_mut(), &mut phase, 0.1, 10, |_, _| {
            steps += 1;
            ControlFlow::Continue(())
        });
        assert!(matches!(error, Err(LagrangianError::NonFinite { .. })), "{error:?}");
        assert!(steps == 2 || steps == 3);
        assert_eq!(bits(&phase), bits(&start));
    }
}

/// V = 10⁻³ √q, for q > 0 only.
struct HalfLine;

impl Lagrangian<1> for HalfLine {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].sqrt().scale(1e-3)
    }
}
