//! Work against precision: the regular double pendulum over 20 s, by our methods with automatic differentiation ("autodiff"), by some
//! with a hand-written right side ("by hand"), and by the DOP853 of two other crates with a hand-written right side.
//!
//! `cargo bench -p lagrangian --no-default-features --bench trajectory`
//!
//! Needs the fixture that the tests use. The error is the largest of the angles and angular velocities at 20 s against a reference of 32 digits.

#![allow(clippy::print_stdout, reason = "a benchmark prints")]
#![allow(clippy::unwrap_used, reason = "a benchmark may stop")]

use differential_equations::prelude::{ExplicitRungeKutta, IVP, ODE};
use lagrangian::integrator::{
    AdamsBashforthMoulton, DormandPrince853, Evaluations, GaussLegendre, Tolerance, drive,
};
use lagrangian::{
    Curvature, EulerLagrange, Expansion, Lagrangian, LagrangianError, Phase, System, system::Dependence,
};
use mechanics_core::scalar::Scalar;
use ode_solvers::{Dop853, OutputType, Vector4};
use std::hint::black_box;
use std::time::Instant;

/// Interleaved repeats, of which the median counts.
const REPEATS: usize = 21;
const END: f64 = 20.0;
const START: Phase<[f64; 2]> = Phase { time: 0.0, q: [0.5, -0.25], v: [0.0, 0.5] };
/// Angles and velocities at 20 s: fixture `double_pendulum_regular`.
const REFERENCE: &str = include_str!("../tests/fixtures/double_pendulum_regular.json");

const M1: f64 = 2.0;
const M2: f64 = 1.0;
const L1: f64 = 1.0;
const L2: f64 = 0.5;
const G: f64 = 9.81;

struct DoublePendulum;

impl Lagrangian<2> for DoublePendulum {
    #[inline]
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _t: S) -> S {
        v[0].square().scale(0.5 * (M1 + M2) * L1 * L1)
            + v[1].square().scale(0.5 * M2 * L2 * L2)
            + ((q[0] - q[1]).cos() * v[0] * v[1]).scale(M2 * L1 * L2)
    }

    #[inline]
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        -q[0].cos().scale((M1 + M2) * G * L1) - q[1].cos().scale(M2 * G * L2)
    }
}

/// q̈ solved by hand.
#[inline]
fn by_hand(q: &[f64; 2], v: &[f64; 2]) -> [f64; 2] {
    let (sin, cos) = (q[0] - q[1]).sin_cos();
    let coupling = M2 * L1 * L2;
    let (m11, m12, m22) = ((M1 + M2) * L1 * L1, coupling * cos, M2 * L2 * L2);
    let f1 = -coupling * sin * v[1] * v[1] - (M1 + M2) * G * L1 * q[0].sin();
    let f2 = coupling * sin * v[0] * v[0] - M2 * G * L2 * q[1].sin();
    let inverse = 1.0 / (m11 * m22 - m12 * m12);
    [(m22 * f1 - m12 * f2) * inverse, (m11 * f2 - m12 * f1) * inverse]
}

/// The hand-written right side as our system: explicit methods read nothing but q̈.
struct ByHand;

impl System for ByHand {
    type Coordinates = [f64; 2];

    fn dimension(&self) -> usize {
        2
    }

    fn expand(&self, t: f64, q: &[f64; 2], v: &[f64; 2], expansion: &mut Expansion<[f64; 2]>) {
        EulerLagrange::new(DoublePendulum).expand(t, q, v, expansion);
    }

    fn curve(&self, t: f64, q: &[f64; 2], v: &[f64; 2], curvature: &mut Curvature<[f64; 2]>) {
        EulerLagrange::new(DoublePendulum).curve(t, q, v, curvature);
    }

    fn dependence(&self, t: f64, q: &[f64; 2], v: &[f64; 2]) -> Dependence {
        EulerLagrange::new(DoublePendulum).dependence(t, q, v)
    }

    #[inline]
    fn acceleration(
        &self,
        _t: f64,
        q: &[f64; 2],
        v: &[f64; 2],
        acceleration: &mut [f64; 2],
    ) -> Result<(), LagrangianError> {
        *acceleration = by_hand(q, v);
        Ok(())
    }
}

impl ODE<f64, [f64; 4]> for ByHand {
    fn diff(&self, _t: f64, y: &[f64; 4], slope: &mut [f64; 4]) {
        let a = by_hand(&[y[0], y[1]], &[y[2], y[3]]);
        *slope = [y[2], y[3], a[0], a[1]];
    }
}

impl ode_solvers::System<f64, Vector4<f64>> for ByHand {
    fn system(&self, _t: f64, y: &Vector4<f64>, slope: &mut Vector4<f64>) {
        let a = by_hand(&[y[0], y[1]], &[y[2], y[3]]);
        *slope = Vector4::new(y[2], y[3], a[0], a[1]);
    }
}

/// The state at the end and the evaluations it took.
type Run = ([f64; 4], u64);

fn state(phase: &Phase<[f64; 2]>) -> [f64; 4] {
    [phase.q[0], phase.q[1], phase.v[0], phase.v[1]]
}

fn ours<S: System<Coordinates = [f64; 2]>>(system: &S, tolerance: f64) -> Run {
    let mut method = DormandPrince853::new(system).with_tolerance(Tolerance::uniform(tolerance)).unwrap();
    let mut phase = START;
    let report = method.integrate(system, &mut phase, END).unwrap();
    (state(&phase), report.evaluations)
}

fn gauss_legendre<const STAGES: usize>(steps: f64) -> Run {
    let system = EulerLagrange::new(DoublePendulum);
    let mut method = GaussLegendre::<STAGES, [f64; 2]>::new();
    let mut phase = START;
    let report = drive::integrate(&system, &mut method, &mut phase, END, END / steps).unwrap();
    (state(&phase), report.work.evaluations)
}

fn adams<const STEPS: usize, S: System<Coordinates = [f64; 2]>>(
    system: &S,
    evaluations: Evaluations,
    steps: f64,
) -> Run {
    let mut method = AdamsBashforthMoulton::<STEPS, _>::new(system).with_evaluations(evaluations);
    let mut phase = START;
    // Beyond its stability limit a step ends in numbers that are not finite, which is an error of the crate.
    match drive::integrate(system, &mut method, &mut phase, END, END / steps) {
        Ok(report) => (state(&phase), report.work.evaluations),
        Err(_) => ([f64::INFINITY; 4], 0),
    }
}

/// Predict, evaluate, correct.
fn adams_once<const STEPS: usize>(steps: f64) -> Run {
    adams::<STEPS, _>(&EulerLagrange::new(DoublePendulum), Evaluations::One, steps)
}

/// Predict, evaluate, correct, evaluate.
fn adams_twice<const STEPS: usize>(steps: f64) -> Run {
    adams::<STEPS, _>(&EulerLagrange::new(DoublePendulum), Evaluations::Two, steps)
}

fn ode_solvers(tolerance: f64) -> Run {
    let start = Vector4::new(START.q[0], START.q[1], START.v[0], START.v[1]);
    let mut method = Dop853::from_param(
        ByHand,
        0.0,
        END,
        0.0,
        start,
        tolerance,
        tolerance,
        0.9,
        0.0,
        0.333,
        6.0,
        END,
        0.0,
        100_000,
        1000,
        OutputType::Sparse,
    );
    let statistics = method.integrate().unwrap();
    let y = method.y_out().last().unwrap();
    ([y[0], y[1], y[2], y[3]], u64::from(statistics.num_eval))
}

fn differential_equations(tolerance: f64) -> Run {
    let start = [START.q[0], START.q[1], START.v[0], START.v[1]];
    let method = ExplicitRungeKutta::dop853().rtol(tolerance).atol(tolerance).max_steps(1_000_000);
    let solution = IVP::ode(&ByHand, 0.0, END, start).method(method).solve().unwrap();
    (*solution.y.last().unwrap(), solution.evals.function as u64)
}

/// A method with one of its settings.
struct Case {
    contestant: usize,
    setting: f64,
    error: f64,
    evaluations: u64,
    milliseconds: Vec<f64>,
}

impl Case {
    fn median(&self) -> f64 {
        let mut times = self.milliseconds.clone();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    }
}

/// A method by name.
struct Contestant {
    name: &'static str,
    run: fn(f64) -> Run,
    settings: Vec<f64>,
}

fn contestants() -> Vec<Contestant> {
    let tolerances: Vec<f64> = (5..=15).map(|k| 10_f64.powi(-k)).collect();
    let adaptive = |name, run| Contestant { name, run, settings: tolerances.clone() };
    let steps = [40.0, 60.0, 80.0, 100.0, 120.0, 160.0, 200.0, 300.0, 400.0, 500.0, 600.0];
    let fixed = |name, run| Contestant { name, run, settings: steps.to_vec() };
    let many = [2000.0, 2500.0, 3000.0, 3500.0, 4000.0, 4500.0, 5000.0, 5500.0, 6000.0, 7000.0, 8000.0];
    let multistep = |name, run| Contestant { name, run, settings: many.to_vec() };
    vec![
        adaptive("ode_solvers DOP853, by hand", ode_solvers),
        adaptive("differential-equations DOP853, by hand", differential_equations),
        adaptive("ours DOP853, by hand", |tolerance| ours(&ByHand, tolerance)),
        adaptive("ours DOP853, autodiff", |tolerance| ours(&EulerLagrange::new(DoublePendulum), tolerance)),
        multistep("ours Adams 11 PEC, autodiff (steps)", adams_once::<10>),
        multistep("ours Adams 11 PEC, by hand (steps)", |steps| {
            adams::<10, _>(&ByHand, Evaluations::One, steps)
        }),
        multistep("ours Adams 13 PECE, autodiff (steps)", adams_twice::<12>),
        multistep("ours Adams 14 PECE, autodiff (steps)", adams_twice::<13>),
        fixed("ours Gauss–Legendre 12, autodiff (steps)", gauss_legendre::<6>),
        fixed("ours Gauss–Legendre 16, autodiff (steps)", gauss_legendre::<8>),
        fixed("ours Gauss–Legendre 20, autodiff (steps)", gauss_legendre::<10>),
        fixed("ours Gauss–Legendre 24, autodiff (steps)", gauss_legendre::<12>),
    ]
}

/// Angles and velocities at the end, from the fixture's last sample.
fn reference() -> [f64; 4] {
    let fixture: serde_json::Value = serde_json::from_str(REFERENCE).unwrap();
    let last = fixture["samples"].as_array().unwrap().last().unwrap();
    assert_eq!(last["t"].as_f64(), Some(END));
    let number = |key: &str, i: usize| last[key][i].as_str().unwrap().parse::<f64>().unwrap();
    [number("q", 0), number("q", 1), number("qdot", 0), number("qdot", 1)]
}

/// The time of a fixed piece of arithmetic \[ms\], to judge the machine by.
fn calibration() -> f64 {
    let start = Instant::now();
    let mut x = black_box(0.5_f64);
    for _ in 0..1_000_000 {
        x = x.mul_add(0.999_999, 1e-7);
    }
    black_box(x);
    start.elapsed().as_secs_f64() * 1e3
}

fn main() {
    let contestants = contestants();
    let exact = reference();
    let mut cases: Vec<Case> = Vec::new();
    for (contestant, c) in contestants.iter().enumerate() {
        for &setting in &c.settings {
            let (end, evaluations) = (c.run)(setting);
            let error = end.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            cases.push(Case { contestant, setting, error, evaluations, milliseconds: Vec::new() });
        }
    }
    let mut machine = Vec::new();
    for _ in 0..REPEATS {
        machine.push(calibration());
        for case in &mut cases {
            let start = Instant::now();
            black_box((contestants[case.contestant].run)(black_box(case.setting)));
            case.milliseconds.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    machine.sort_by(f64::total_cmp);
    println!(
        "regular double pendulum, 20 s; a million dependent multiply-adds take {:.3} ms",
        machine[REPEATS / 2]
    );
    for (index, c) in contestants.iter().enumerate() {
        println!("\n{}", c.name);
        for case in cases.iter().filter(|case| case.contestant == index) {
            if !case.error.is_finite() {
                println!("  {:8.1e}  unstable", case.setting);
                continue;
            }
            println!(
                "  {:8.1e}  error {:8.1e}  {:7} evaluations  {:8.3} ms",
                case.setting,
                case.error,
                case.evaluations,
                case.median()
            );
        }
    }
    summary(&contestants, &cases);
}

/// The quickest case of each method within each error, and the ratio of its time to those of the two other crates.
fn summary(contestants: &[Contestant], cases: &[Case]) {
    let quickest = |contestant: usize, error: f64| {
        let able = cases.iter().filter(|case| case.contestant == contestant && case.error <= error);
        able.min_by(|a, b| a.median().total_cmp(&b.median()))
    };
    let time = |case: Option<&Case>| case.map_or(f64::INFINITY, Case::median);
    for error in [1e-7, 1e-9, 1e-11, 1e-12, 1e-13] {
        println!("\nerror ≤ {error:.0e}{:40}error         ms  evaluations  of {OTHERS}", "");
        let others = [0, 1].map(|index| time(quickest(index, error)));
        for (index, c) in contestants.iter().enumerate() {
            let Some(case) = quickest(index, error) else {
                println!("  {:45} does not reach it", c.name);
                continue;
            };
            let ratios = others.map(|other| match case.median() / other {
                ratio if other.is_finite() => format!("{ratio:6.2}"),
                _ => "     –".to_owned(),
            });
            let (ms, evaluations) = (case.median(), case.evaluations);
            println!("  {:45} {:8.1e}  {ms:8.3} {evaluations:12}  {}", c.name, case.error, ratios.join(" "));
        }
        let autodiff = contestants.iter().enumerate().filter(|(_, c)| c.name.contains("autodiff"));
        let best = autodiff.map(|(index, _)| time(quickest(index, error))).fold(f64::INFINITY, f64::min);
        let faster = others[0].min(others[1]);
        if faster.is_finite() {
            let bar = if error == 1e-11 { " (bar: 1)" } else { "" };
            println!(
                "  best of ours with autodiff over the faster crate, by hand: {:.2}{bar}",
                best / faster
            );
        } else {
            println!("  neither crate reaches it; best of ours with autodiff: {best:.3} ms");
        }
    }
}

const OTHERS: &str = "ode_solvers, differential-equations";
