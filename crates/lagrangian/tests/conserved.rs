//! Conserved quantities: found where they are, refused where they are not, and told apart by what integrators do to them.
#![allow(clippy::unwrap_used)]

use lagrangian::conserved::{Energy, Invariant, Momentum, Noether, Symmetry, Verdict, diagnose, found};
use lagrangian::{
    EulerLagrange, Lagrangian, LagrangianError, Phase, SlicedEulerLagrange, SlicedLagrangian, System,
};
use mechanics_core::scalar::Scalar;
use serde_json::Value;

struct Pendulum;

impl Lagrangian<1> for Pendulum {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].cos().scale(-9.81)
    }
}

/// Kepler's problem with a term −ε x²/2 that breaks the rotational symmetry unless ε = 0.
struct Kepler {
    tide: f64,
}

impl Lagrangian<2> for Kepler {
    fn kinetic<S: Scalar>(&self, _q: &[S; 2], v: &[S; 2], _t: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        q[0].square().scale(-0.5 * self.tide) - (q[0].square() + q[1].square()).sqrt().recip()
    }
}

struct SphericalPendulum;

impl Lagrangian<2> for SphericalPendulum {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _t: S) -> S {
        (v[0].square() + (v[1] * q[0].sin()).square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        q[0].cos().scale(-9.81)
    }
}

struct Duffing;

impl Lagrangian<1> for Duffing {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].square().scale(-0.5) + q[0].square().square().scale(0.25)
    }
    fn rayleigh<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.15)
    }
    fn force<S: Scalar>(&self, _q: &[S; 1], _v: &[S; 1], t: S) -> [S; 1] {
        [t.scale(1.2).cos().scale(0.5)]
    }
}

/// A bead on a hoop that turns at the rate Ω, or at Ω + t/10 where it is spun up.
struct Hoop {
    spin_up: f64,
}

impl Lagrangian<1> for Hoop {
    fn kinetic<S: Scalar>(&self, q: &[S; 1], v: &[S; 1], t: S) -> S {
        let rate = if self.spin_up == 0.0 { S::constant(2.5) } else { t.scale(self.spin_up).offset(2.5) };
        (v[0].square() + (rate * q[0].sin()).square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].cos().scale(-9.81)
    }
}

/// Masses on a line, neighbours joined by springs, nothing held.
struct FreeChain {
    masses: Vec<f64>,
}

impl SlicedLagrangian for FreeChain {
    fn dimension(&self) -> usize {
        self.masses.len()
    }
    fn kinetic<S: Scalar>(&self, _q: &[S], v: &[S], _t: S) -> S {
        v.iter().zip(&self.masses).fold(S::constant(0.0), |sum, (v, m)| sum + v.square().scale(0.5 * m))
    }
    fn potential<S: Scalar>(&self, q: &[S], _t: S) -> S {
        q.windows(2).fold(S::constant(0.0), |sum, pair| sum + (pair[1] - pair[0]).square().scale(2.0))
    }
}

struct Rotation;

impl Symmetry for Rotation {
    fn generator_into<S: Scalar>(&self, q: &[S], _t: S, direction: &mut [S]) {
        direction[0] = -q[1];
        direction[1] = q[0];
    }
}

struct Translation;

impl Symmetry for Translation {
    fn generator_into<S: Scalar>(&self, _q: &[S], _t: S, direction: &mut [S]) {
        direction.fill(S::constant(1.0));
    }
}

/// All masses get the same velocity: the charge is M (V t − X), the centre of mass moves uniformly.
struct Boost {
    masses: Vec<f64>,
}

impl Symmetry for Boost {
    fn generator_into<S: Scalar>(&self, _q: &[S], t: S, direction: &mut [S]) {
        direction.fill(t);
    }
    fn boundary<S: Scalar>(&self, q: &[S], _t: S) -> S {
        q.iter().zip(&self.masses).fold(S::constant(0.0), |sum, (q, m)| sum + q.scale(*m))
    }
}

fn fixture<const N: usize>(name: &str) -> (Vec<Phase<[f64; N]>>, Value) {
    let path = format!("{}/tests/fixtures/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let data: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let number = |x: &Value| x.as_f64().unwrap_or_else(|| x.as_str().unwrap().parse().unwrap());
    let phase = |sample: &Value| Phase {
        time: number(&sample["t"]),
        q: std::array::from_fn(|i| number(&sample["q"][i])),
        v: std::array::from_fn(|i| number(&sample["qdot"][i])),
    };
    (data["samples"].as_array().unwrap().iter().map(phase).collect(), data)
}

fn accelerate<S: System>(system: &S, t: f64, q: &S::Coordinates, v: &S::Coordinates) -> S::Coordinates {
    let mut a = q.clone();
    system.acceleration(t, q, v, &mut a).unwrap();
    a
}

fn add<C: AsMut<[f64]> + Clone>(x: &C, d: &C, h: f64) -> C {
    let (mut out, mut d) = (x.clone(), d.clone());
    out.as_mut().iter_mut().zip(d.as_mut()).for_each(|(x, d)| *x += h * *d);
    out
}

/// The classical fourth-order method.
fn rk4<S: System>(
    system: &S,
    start: Phase<S::Coordinates>,
    h: f64,
    steps: usize,
) -> Vec<Phase<S::Coordinates>> {
    let mut out = vec![start];
    for step in 0..steps {
        let Phase { time: t, q, v } = out[step].clone();
        let a1 = accelerate(system, t, &q, &v);
        let (q2, v2) = (add(&q, &v, 0.5 * h), add(&v, &a1, 0.5 * h));
        let a2 = accelerate(system, t + 0.5 * h, &q2, &v2);
        let (q3, v3) = (add(&q, &v2, 0.5 * h), add(&v, &a2, 0.5 * h));
        let a3 = accelerate(system, t + 0.5 * h, &q3, &v3);
        let (q4, v4) = (add(&q, &v3, h), add(&v, &a3, h));
        let a4 = accelerate(system, t + h, &q4, &v4);
        let sum = |x: S::Coordinates, d: [&S::Coordinates; 4]| {
            [1.0, 2.0, 2.0, 1.0].iter().zip(d).fold(x, |x, (w, d)| add(&x, d, w * h / 6.0))
        };
        let (q, v) = (sum(q, [&v, &v2, &v3, &v4]), sum(v, [&a1, &a2, &a3, &a4]));
        out.push(Phase { time: h * (step + 1) as f64, q, v });
    }
    out
}

/// Störmer–Verlet, for accelerations that do not depend on velocity.
fn verlet<S: System>(
    system: &S,
    start: Phase<S::Coordinates>,
    h: f64,
    steps: usize,
) -> Vec<Phase<S::Coordinates>> {
    let mut a = accelerate(system, start.time, &start.q, &start.v);
    let mut out = vec![start];
    for step in 0..steps {
        let Phase { q, v, .. } = &out[step];
        let half = add(v, &a, 0.5 * h);
        let q = add(q, &half, h);
        let time = h * (step + 1) as f64;
        a = accelerate(system, time, &q, &half);
        let v = add(&half, &a, 0.5 * h);
        out.push(Phase { time, q, v });
    }
    out
}

fn names<S: System>(invariants: &[Box<dyn Invariant<S>>]) -> Vec<String> {
    invariants.iter().map(|invariant| invariant.name()).collect()
}

#[test]
fn runge_kutta_drifts_in_a_line_and_verlet_does_not() {
    let system = EulerLagrange::new(Pendulum);
    let start = Phase { time: 0.0, q: [1.0], v: [0.0] };
    let invariants = found(&system, &start);
    assert_eq!(names(&invariants), ["energy"]);
    let (h, steps) = (0.05, 20_000);
    let drifting = diagnose(&system, &rk4(&system, start.clone(), h, steps), &invariants).unwrap();
    let bounded = diagnose(&system, &verlet(&system, start.clone(), h, steps), &invariants).unwrap();
    println!("Runge–Kutta, {drifting}Verlet, {bounded}");
    let (runge, verlet) = (&drifting.drifts[0], &bounded.drifts[0]);
    assert_eq!((runge.verdict, verlet.verdict), (Verdict::Drifting, Verdict::Bounded));
    assert!((runge.initial + 9.81 * 1f64.cos()).abs() < 1e-14);
    // A line: the slope times the time is the whole, known to a per cent, and the error falls like h⁵ a step for all h.
    assert!((runge.slope.abs() * h * steps as f64 / runge.largest - 1.0).abs() < 0.02);
    assert!(runge.slope_error < 0.01 * runge.slope.abs());
    let finer = diagnose(&system, &rk4(&system, start, 0.5 * h, 2 * steps), &invariants).unwrap();
    let order = (runge.slope / finer.drifts[0].slope).log2();
    assert!((order - 5.0).abs() < 0.15, "{order}");
    assert!((verlet.last_tenth / verlet.first_tenth - 1.0).abs() < 0.05);
    assert!(verlet.slope.abs() * h * (steps as f64) < 0.01 * verlet.largest);
}

#[test]
fn angular_momentum_is_kept_by_verlet_and_lost_by_runge_kutta() {
    let system = EulerLagrange::new(Kepler { tide: 0.0 });
    let start = Phase { time: 0.0, q: [0.4, 0.0], v: [0.0, 2.0] };
    let rotation = Noether::new("angular momentum", Rotation, &system, std::slice::from_ref(&start)).unwrap();
    let invariants: Vec<Box<dyn Invariant<_>>> = vec![Box::new(Energy::Mechanical), Box::new(rotation)];
    let kept = diagnose(&system, &verlet(&system, start.clone(), 0.01, 40_000), &invariants).unwrap();
    let lost = diagnose(&system, &rk4(&system, start, 0.01, 40_000), &invariants).unwrap();
    println!("Verlet, {kept}Runge–Kutta, {lost}");
    assert_eq!(kept.drifts.iter().map(|d| d.verdict).collect::<Vec<_>>(), [Verdict::Bounded, Verdict::Noise]);
    assert_eq!(lost.drifts.iter().map(|d| d.verdict).collect::<Vec<_>>(), [Verdict::Drifting; 2]);
    assert_eq!(kept.drifts[1].initial, 0.8);
}

#[test]
fn charges_are_those_of_the_fixtures() {
    let system = EulerLagrange::new(Kepler { tide: 0.0 });
    let (orbit, data) = fixture::<2>("kepler_e06");
    let charge = Noether::new("angular momentum", Rotation, &system, &orbit).unwrap();
    for (phase, sample) in orbit.iter().zip(data["samples"].as_array().unwrap()) {
        let exact: f64 = sample["conserved"]["l_z"].as_str().unwrap().parse().unwrap();
        let energy: f64 = sample["energy"].as_str().unwrap().parse().unwrap();
        assert!((charge.measure(&system, phase).value - exact).abs() < 1e-14);
        assert!((Invariant::measure(&Energy::Mechanical, &system, phase).value - energy).abs() < 1e-14);
    }
    let system = EulerLagrange::new(SphericalPendulum);
    let (swing, data) = fixture::<2>("spherical_pendulum");
    let invariants = found(&system, &swing[0]);
    assert_eq!(names(&invariants), ["energy", "momentum 1"]);
    for (phase, sample) in swing.iter().zip(data["samples"].as_array().unwrap()) {
        let exact: f64 = sample["conserved"]["p_phi"].as_str().unwrap().parse().unwrap();
        assert!((invariants[1].measure(&system, phase).value - exact).abs() < 1e-14);
    }
}

#[test]
fn what_is_no_symmetry_is_refused_with_the_state_where_it_fails() {
    let system = EulerLagrange::new(Kepler { tide: 0.01 });
    // On the axis the broken symmetry cannot be seen; beside it, it can.
    let on_axis = [Phase { time: 0.0, q: [1.0, 0.0], v: [0.3, 0.0] }];
    let refused = Noether::new("angular momentum", Rotation, &system, &on_axis).unwrap_err();
    println!("{refused}");
    let LagrangianError::NotASymmetry { name, q, v, change, size, time } = refused else {
        panic!("{refused}")
    };
    // Half a second about the time given was looked at.
    assert!(name == "angular momentum" && time.abs() <= 0.25, "{name} {time}");
    // δL = ξ·∂L/∂q = −ε x y for this L.
    assert!((change + 0.01 * q[0] * q[1]).abs() < 1e-12, "{q:?} {v:?} {change} {size}");
    let whole = EulerLagrange::new(Kepler { tide: 0.0 });
    for refused in [
        Noether::new("momentum", Translation, &whole, &on_axis).unwrap_err(),
        Noether::new("nothing", Translation, &EulerLagrange::new(Kepler { tide: -1.0 }), &on_axis)
            .unwrap_err(),
    ] {
        assert!(matches!(refused, LagrangianError::NotASymmetry { .. }));
    }
    let centre = [Phase { time: 0.0, q: [0.0, 0.0], v: [0.3, 0.0] }];
    let refused = Noether::new("angular momentum", Rotation, &whole, &centre).unwrap_err();
    assert!(matches!(refused, LagrangianError::NonFinite { .. }), "{refused}");
    let refused = Noether::new("angular momentum", Rotation, &whole, &[]).unwrap_err();
    assert_eq!(refused, LagrangianError::FewSamples { samples: 0, needed: 1 });
}

#[test]
fn forces_along_a_symmetry_break_its_charge() {
    let system = EulerLagrange::new(Duffing);
    let start = Phase { time: 0.0, q: [1.0], v: [0.2] };
    assert!(names(&found(&system, &start)).is_empty());
    struct Damped;
    impl Lagrangian<1> for Damped {
        fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
            v[0].square()
        }
        fn potential<S: Scalar>(&self, _q: &[S; 1], _t: S) -> S {
            S::constant(3.0)
        }
        fn rayleigh<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
            v[0].square()
        }
    }
    let damped = EulerLagrange::new(Damped);
    assert!(names(&found(&damped, &start)).is_empty());
    let refused = Noether::new("momentum", Translation, &damped, &[start]).unwrap_err();
    assert!(matches!(refused, LagrangianError::NotASymmetry { .. }), "{refused}");
}

#[test]
fn a_driven_hoop_keeps_its_jacobi_integral_only_at_a_constant_rate() {
    let start = Phase { time: 0.0, q: [0.1], v: [0.3] };
    let steady = EulerLagrange::new(Hoop { spin_up: 0.0 });
    let invariants = found(&steady, &start);
    assert_eq!(names(&invariants), ["Jacobi integral"]);
    let kept = diagnose(&steady, &rk4(&steady, start.clone(), 1e-3, 20_000), &invariants).unwrap();
    assert!(kept.drifts[0].largest < 1e-11, "{kept}");
    let spun = EulerLagrange::new(Hoop { spin_up: 0.1 });
    assert!(found(&spun, &start).is_empty());
    let forced: Vec<Box<dyn Invariant<_>>> = vec![Box::new(Energy::Jacobi)];
    let lost = diagnose(&spun, &rk4(&spun, start, 1e-3, 20_000), &forced).unwrap();
    assert!(lost.drifts[0].largest > 0.1, "{lost}");
}

#[test]
fn a_free_chain_has_momentum_and_a_uniform_centre_of_mass() {
    let masses = vec![1.0, 2.5, 0.5, 4.0];
    let system = SlicedEulerLagrange::new(FreeChain { masses: masses.clone() });
    let start = Phase::new(0.0, vec![0.0, 1.0, 2.5, 3.0], vec![0.4, -0.2, 1.0, 0.0]);
    let states = std::slice::from_ref(&start);
    let total = Noether::new("momentum", Translation, &system, states).unwrap();
    let centre = Noether::new("centre of mass", Boost { masses }, &system, states).unwrap();
    assert_eq!(names(&found(&system, &start)), ["energy"]);
    let invariants: Vec<Box<dyn Invariant<_>>> = vec![Box::new(total), Box::new(centre)];
    let kept = diagnose(&system, &verlet(&system, start.clone(), 0.02, 5_000), &invariants).unwrap();
    println!("{kept}");
    assert!((kept.drifts[0].initial - 0.4).abs() < 1e-15 && (kept.drifts[1].initial + 15.75).abs() < 1e-14);
    assert_eq!(kept.drifts.iter().map(|d| d.verdict).collect::<Vec<_>>(), [Verdict::Noise; 2]);
    // A boost without its boundary term is none.
    struct Bare;
    impl Symmetry for Bare {
        fn generator_into<S: Scalar>(&self, _q: &[S], t: S, direction: &mut [S]) {
            direction.fill(t);
        }
    }
    let refused = Noether::new("bare boost", Bare, &system, states).unwrap_err();
    assert!(matches!(refused, LagrangianError::NotASymmetry { .. }), "{refused}");
}

/// A free particle whose "trajectory" has a momentum of our choice.
fn written(change: impl Fn(f64) -> f64) -> Vec<Phase<[f64; 1]>> {
    (0..4000)
        .map(|k| 0.05 * f64::from(k))
        .map(|time| Phase { time, q: [0.0], v: [1.0 + change(time)] })
        .collect()
}

#[test]
fn verdicts_on_drifts_of_known_shape() {
    let system = EulerLagrange::new(Pendulum);
    let momentum: Vec<Box<dyn Invariant<_>>> = vec![Box::new(Momentum { coordinate: 0 })];
    let verdict = |change: &dyn Fn(f64) -> f64| {
        let drift = diagnose(&system, &written(change), &momentum).unwrap().drifts.remove(0);
        println!("{:.2e} ± {:.1e} {}", drift.slope, drift.slope_error, drift.verdict);
        drift
    };
    let wave = |t: f64| 1e-3 * (2.1 * t).sin() * (0.3 + (0.37 * t).cos());
    assert_eq!(verdict(&|_| 0.0).verdict, Verdict::Noise);
    assert_eq!(verdict(&|t| 1e-16 * (1e9 * t).sin()).verdict, Verdict::Noise);
    assert_eq!(verdict(&wave).verdict, Verdict::Bounded);
    assert_eq!(verdict(&|t| 1e-3 * (1.0 - (0.9 * t).cos())).verdict, Verdict::Bounded);
    // A line under a wave of three times its height is found, with its slope within three standard errors.
    let hidden = verdict(&|t| wave(t) + 2e-6 * t);
    assert_eq!(hidden.verdict, Verdict::Drifting);
    assert!((hidden.slope - 2e-6).abs() < 3.0 * hidden.slope_error);
    assert_eq!(verdict(&|t| -1e-9 * t).verdict, Verdict::Drifting);
    assert_eq!(verdict(&|t| 1e-12 * (0.1 * t).exp()).verdict, Verdict::Drifting);
    assert_eq!(verdict(&|t| 1e-3 * (5.0 * t).sin() * (0.02 * t).exp()).verdict, Verdict::Drifting);
}

#[test]
fn bad_trajectories_are_refused_by_name() {
    let system = EulerLagrange::new(Pendulum);
    let energy: Vec<Box<dyn Invariant<_>>> = vec![Box::new(Energy::Mechanical)];
    let good = written(|_| 0.0);
    let refused = diagnose(&system, &good[..19], &energy).unwrap_err();
    assert_eq!(refused, LagrangianError::FewSamples { samples: 19, needed: 20 });
    assert!(diagnose(&system, &good[..20], &energy).is_ok());
    let mut bad = good.clone();
    bad[7].v[0] = f64::NAN;
    assert!(matches!(
        diagnose(&system, &bad, &energy).unwrap_err(),
        LagrangianError::NonFinite { index: 0, .. }
    ));
    let mut bad = good;
    bad[7].time = bad[6].time;
    let refused = diagnose(&system, &bad, &energy).unwrap_err();
    assert!(matches!(refused, LagrangianError::Unordered { index: 7, .. }), "{refused}");
}

/// A uniform field that grows from nothing at t = 0.
struct GrowingField;

impl Lagrangian<2> for GrowingField {
    fn kinetic<S: Scalar>(&self, _q: &[S; 2], v: &[S; 2], _t: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], t: S) -> S {
        q[0] * t.sin() + q[1].square()
    }
}

struct AlongX;

impl Symmetry for AlongX {
    fn generator_into<S: Scalar>(&self, _q: &[S], _t: S, direction: &mut [S]) {
        direction[0] = S::constant(1.0);
    }
}

#[test]
fn a_field_that_is_off_at_the_only_time_given_breaks_the_symmetry_all_the_same() {
    let system = EulerLagrange::new(GrowingField);
    let start = Phase::new(0.0, [1.0, 0.5], [0.3, 0.1]);
    let refused = Noether::new("p along x", AlongX, &system, &[start]).unwrap_err();
    assert!(matches!(refused, LagrangianError::NotASymmetry { .. }), "{refused}");
}
