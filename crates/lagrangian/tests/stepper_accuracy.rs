//! Time schemes on scenes with closed forms and high-precision trajectories.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]
// The stepper needs the sparse solvers' feature.
#![cfg(feature = "bodies")]

use lagrangian::element::{
    Amplitude, Attachments, DampingTerm, Dashpots, DeadLoad, Mass, MassDamping, MassDistribution, Springs,
    StiffnessDamping,
};
use lagrangian::stepper::{
    ExplicitScheme, ExplicitStepper, Lagging, StepError, Stepper, StepperOptions, TimeScheme,
};
use mechanics_core::checkpoint::Checkpoint;
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::{Changed, Potential, PotentialError, StepLimit};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::{Moment, Stage};
use mechanics_core::state::State;
use mechanics_core::stencil::StencilTerm;
use mechanics_core::tensor::{Mat3, Vec3};
use serde_json::Value;
use std::time::Duration;

const SCHEMES: [TimeScheme; 4] =
    [TimeScheme::BackwardEuler, TimeScheme::Bdf2, TimeScheme::Newmark, TimeScheme::ImplicitMidpoint];

fn fixture(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_str().map_or_else(|| value.as_f64().unwrap(), |text| text.parse().unwrap())
}

fn options(scheme: TimeScheme) -> StepperOptions {
    StepperOptions {
        scheme,
        newton: NewtonOptions { tolerance: 1e-12, ..Default::default() },
        ..Default::default()
    }
}

/// One point of mass 1 on a spring of stiffness ω² to the origin.
struct Oscillator {
    mass: Mass,
    spring: StencilTerm<Attachments, 1>,
}

impl Oscillator {
    fn new(omega: f64) -> Self {
        let mut mass = Mass::zeros(1);
        mass.add_point(0, 1.0).unwrap();
        let spring = Attachments::term("spring", omega * omega, &[0], vec![Vec3::zeros()]).unwrap();
        Self { mass, spring }
    }

    fn start() -> State {
        let mut state = State::at_rest(vec![Vec3::new(1.0, 0.3, 0.0)]);
        state.velocity[0] = Vec3::new(0.2, -0.4, 0.0);
        state
    }
}

/// ρ² and 2ρ cos θ of the principal root: three consecutive states satisfy x₂ = 2ρ cos θ x₁ − ρ² x₀ in every component.
fn root(states: &[State]) -> (f64, f64) {
    let numbers = |state: &State| {
        let (x, v) = (state.position[0], state.velocity[0]);
        nalgebra::Vector4::new(x.x, x.y, v.x, v.y)
    };
    let [a, b, c] = [0, 1, 2].map(|k| numbers(&states[states.len() - 3 + k]));
    let columns = nalgebra::Matrix4x2::from_columns(&[b, -a]);
    let normal = columns.transpose() * columns;
    let solution = normal.try_inverse().unwrap() * columns.transpose() * c;
    let (amplitude, double_cos) = (solution[1].sqrt(), solution[0]);
    (amplitude, (double_cos / (2.0 * amplitude)).acos())
}

#[test]
fn an_oscillator_decays_and_turns_as_each_scheme_should() {
    let reference = fixture(include_str!("fixtures/mechanics_reference.json"));
    let rows = reference["integrators_on_oscillator"].as_array().unwrap();
    assert!(rows.len() >= 4);
    for row in rows {
        let z = number(&row["z"]);
        for scheme in SCHEMES {
            let keys = match scheme {
                TimeScheme::BackwardEuler => ["implicit_euler_amp", "implicit_euler_freq_ratio"],
                TimeScheme::Bdf2 => ["bdf2_amp", "bdf2_freq_ratio"],
                _ => ["midpoint_newmark_amp", "midpoint_freq_ratio"],
            };
            let (omega, h) = (10.0, z / 10.0);
            let Oscillator { mass, mut spring } = Oscillator::new(omega);
            let mut stepper = Stepper::new(mass, PointMap::identity(1), options(scheme));
            let mut states = vec![Oscillator::start()];
            // Enough steps for the parasitic root of BDF2, at most 1/√3 a step, to be gone.
            for _ in 0..60 {
                let mut next = states[states.len() - 1].clone();
                stepper.step(&mut next, &mut [&mut spring], h).unwrap();
                states.push(next);
            }
            let (amplitude, angle) = root(&states);
            let expected = [number(&row[keys[0]]), number(&row[keys[1]])];
            assert!(
                (amplitude - expected[0]).abs() < 1e-9,
                "{scheme:?} z = {z}: {amplitude} {}",
                expected[0]
            );
            // An error δ of the cosine is δ/sin θ of the angle.
            assert!((angle / z - expected[1]).abs() < 1e-9 / (z * z), "{scheme:?} z = {z}: {}", angle / z);
        }
        for scheme in [ExplicitScheme::SymplecticEuler, ExplicitScheme::CentralDifferences] {
            let Oscillator { mass, mut spring } = Oscillator::new(10.0);
            let stepper = ExplicitStepper::new(scheme, mass, PointMap::identity(1)).unwrap();
            let mut states = vec![Oscillator::start()];
            for _ in 0..60 {
                let mut next = states[states.len() - 1].clone();
                stepper.step(&mut next, &mut [&mut spring], z / 10.0).unwrap();
                states.push(next);
            }
            if z < 2.0 {
                let (amplitude, angle) = root(&states);
                assert!((amplitude - 1.0).abs() < 1e-9, "{scheme:?}");
                assert!((angle / z - number(&row["verlet_freq_ratio"])).abs() < 1e-9 / (z * z));
            }
        }
    }
}

/// The spring pendulum of the fixture, in Cartesian coordinates: a spring from a fixed point to a heavy one.
struct SpringPendulum {
    spring: StencilTerm<Springs, 2>,
    gravity: DeadLoad,
    mass: Mass,
    start: State,
    time: f64,
    end: Vec3,
}

impl SpringPendulum {
    fn new() -> Self {
        let data = fixture(include_str!("fixtures/spring_pendulum.json"));
        let p = |key: &str| number(&data["params"][key]);
        let place = |q: &Value| {
            let (r, theta) = (number(&q[0]), number(&q[1]));
            Vec3::new(r * theta.sin(), 0.0, -r * theta.cos())
        };
        let mut mass = Mass::zeros(2);
        mass.add_point(1, p("m")).unwrap();
        let springs = Springs::new(vec![p("k")], vec![p("l0")]).unwrap();
        let samples = data["samples"].as_array().unwrap();
        Self {
            spring: StencilTerm::new("spring", springs, vec![[0, 1]]).unwrap(),
            gravity: DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -p("g"))).unwrap(),
            mass,
            start: State::at_rest(vec![Vec3::zeros(), place(&samples[0]["q"])]),
            time: number(&samples[1]["t"]),
            end: place(&samples[1]["q"]),
        }
    }

    fn map() -> PointMap {
        PointMap::with_fixed(2, &[(0, Vec3::zeros())]).unwrap()
    }

    fn error(&mut self, steps: u32, mut step: impl FnMut(&mut State, &mut [&mut dyn Potential], f64)) -> f64 {
        let mut state = self.start.clone();
        let h = self.time / f64::from(steps);
        for _ in 0..steps {
            step(&mut state, &mut [&mut self.spring, &mut self.gravity], h);
        }
        (state.position[1] - self.end).norm()
    }
}

#[test]
fn schemes_converge_with_their_order_to_a_high_precision_trajectory() {
    let mut scene = SpringPendulum::new();
    for scheme in SCHEMES {
        let mut error = |steps| {
            let mut stepper = Stepper::new(scene.mass.clone(), SpringPendulum::map(), options(scheme));
            scene.error(steps, |state, terms, h| drop(stepper.step(state, terms, h).unwrap()))
        };
        let (coarse, fine) = (error(800), error(1600));
        let order = if scheme == TimeScheme::BackwardEuler { 1.0 } else { 2.0 };
        let observed = (coarse / fine).log2();
        assert!((observed - order).abs() < 0.15, "{scheme:?}: {observed}, errors {coarse:e} {fine:e}");
    }
    for (scheme, order) in [(ExplicitScheme::SymplecticEuler, 1.0), (ExplicitScheme::CentralDifferences, 2.0)]
    {
        let stepper = ExplicitStepper::new(scheme, scene.mass.clone(), SpringPendulum::map()).unwrap();
        let mut error = |steps| scene.error(steps, |state, terms, h| stepper.step(state, terms, h).unwrap());
        let (coarse, fine) = (error(800), error(1600));
        let observed = (coarse / fine).log2();
        assert!((observed - order).abs() < 0.15, "{scheme:?}: {observed}, errors {coarse:e} {fine:e}");
    }
}

/// BDF2 keeps its order when the step changes from one to the next, by a factor it can bridge and by one it cannot.
#[test]
fn bdf2_takes_steps_of_any_size() {
    let mut scene = SpringPendulum::new();
    let mut error = |steps: u32| {
        let mut stepper = Stepper::new(scene.mass.clone(), SpringPendulum::map(), options(TimeScheme::Bdf2));
        let mut number = 0;
        // Pairs of steps 0.6 h and 1.4 h.
        scene.error(steps, |state, terms, h| {
            number += 1;
            let h = if number % 2 == 0 { 1.4 * h } else { 0.6 * h };
            stepper.step(state, terms, h).unwrap();
        })
    };
    let (coarse, fine) = (error(800), error(1600));
    assert!(((coarse / fine).log2() - 2.0).abs() < 0.15, "{coarse:e} {fine:e}");

    // A step ten times the last starts anew: exactly a step of backward Euler.
    let mut after_jump = |scheme, history: bool| {
        let mut stepper = Stepper::new(scene.mass.clone(), SpringPendulum::map(), options(TimeScheme::Bdf2));
        let mut state = scene.start.clone();
        stepper.step(&mut state, &mut [&mut scene.spring, &mut scene.gravity], 1e-3).unwrap();
        if !history {
            state.clear_history();
        }
        let mut stepper = Stepper::new(scene.mass.clone(), SpringPendulum::map(), options(scheme));
        stepper.step(&mut state, &mut [&mut scene.spring, &mut scene.gravity], 1e-2).unwrap();
        state.position
    };
    let euler = after_jump(TimeScheme::BackwardEuler, false);
    assert_eq!(after_jump(TimeScheme::Bdf2, true), euler);
}

/// ẍ + γẋ + ω²x = 0: one step of backward Euler is v₁ = (v₀ − hω²x₀)/(1 + hγ + h²ω²), whatever the damping is made of.
#[test]
fn every_damping_has_the_step_of_the_damped_oscillator() {
    let (omega, gamma, h) = (7.0, 3.0, 0.05);
    let points = vec![Vec3::zeros(), Vec3::new(1.0, 0.0, 0.0)];
    let mut mass = Mass::zeros(2);
    mass.add_point(1, 2.0).unwrap();
    let k = 2.0 * omega * omega;
    let mut spring = Springs::term("spring", k, &points, vec![[0, 1]]).unwrap();
    let dashpots = Dashpots::new(vec![2.0 * gamma]).unwrap();
    let beta = gamma / (omega * omega);
    let proportional = StiffnessDamping::new(spring.stencil().clone(), beta).unwrap();
    let mut dampings: [Box<dyn Potential>; 3] = [
        Box::new(MassDamping::new(mass.clone(), gamma).unwrap()),
        Box::new(DampingTerm::new("stiffness damping", proportional, vec![[0, 1]]).unwrap()),
        Box::new(DampingTerm::new("dashpot", dashpots, vec![[0, 1]]).unwrap()),
    ];
    let map = PointMap::with_fixed(2, &[(0, points[0])]).unwrap();
    for damping in &mut dampings {
        let mut stepper = Stepper::new(mass.clone(), map.clone(), options(TimeScheme::BackwardEuler));
        let mut state = State::at_rest(points.clone());
        (state.position[1].x, state.velocity[1].x) = (1.1, -0.5);
        stepper.step(&mut state, &mut [&mut spring, damping.as_mut()], h).unwrap();
        let expected = (-0.5 - h * omega * omega * 0.1) / (1.0 + h * gamma + h * h * omega * omega);
        let ours = state.velocity[1].x;
        assert!((ours - expected).abs() < 1e-13, "{}: {ours} {expected}", damping.name());
        let value = damping.value(&state.position);
        let rate = 0.5 * 2.0 * gamma * expected * expected * h;
        assert!((value - rate).abs() < 1e-12, "the potential is the rate potential over a: {value} {rate}");

        // Explicitly, v₁ = v₀ − h(γv₀ + ω²x₀).
        let explicit =
            ExplicitStepper::new(ExplicitScheme::SymplecticEuler, mass.clone(), map.clone()).unwrap();
        let mut state = State::at_rest(points.clone());
        (state.position[1].x, state.velocity[1].x) = (1.1, -0.5);
        explicit.step(&mut state, &mut [&mut spring, damping.as_mut()], h).unwrap();
        let expected = -0.5 - h * (gamma * -0.5 + omega * omega * 0.1);
        assert!((state.velocity[1].x - expected).abs() < 1e-12);
    }
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(MassDamping::new(mass.clone(), bad).is_err());
        assert!(Dashpots::new(vec![0.0, bad]).is_err());
        assert!(StiffnessDamping::new(spring.stencil().clone(), bad).is_err());
    }
}

/// n equal masses on n equal springs, one end fixed: the axial frequencies are 2√(k/m) sin((2j − 1)π/(4n + 2)).
fn chain(n: u32, k: f64, m: f64) -> (StencilTerm<Springs, 2>, Mass, Vec<Vec3>) {
    let points: Vec<Vec3> = (0..=n).map(|i| Vec3::new(f64::from(i), 0.0, 0.0)).collect();
    let springs = Springs::term("chain", k, &points, (0..n).map(|i| [i, i + 1]).collect()).unwrap();
    let mut mass = Mass::zeros(points.len());
    (1..=n).for_each(|i| mass.add_point(i, m).unwrap());
    (springs, mass, points)
}

#[test]
fn the_stable_step_is_stable_and_a_longer_one_is_not() {
    let (n, k, m) = (20, 300.0, 0.5);
    let (mut springs, mass, points) = chain(n, k, m);
    let map = PointMap::with_fixed(points.len(), &[(0, points[0])]).unwrap();
    let highest = f64::from(2 * n - 1) * std::f64::consts::PI / f64::from(4 * n + 2);
    let exact = 2.0 * (k / m).sqrt() * highest.sin();
    for scheme in [ExplicitScheme::SymplecticEuler, ExplicitScheme::CentralDifferences] {
        let stepper = ExplicitStepper::new(scheme, mass.clone(), map.clone()).unwrap();
        let bounds = stepper.largest_frequency(&points, &mut [&mut springs]).unwrap();
        assert!(bounds.lower <= exact * (1.0 + 1e-12) && bounds.lower > 0.999 * exact, "{bounds:?} {exact}");
        assert!(bounds.upper >= exact && bounds.upper < 1.1 * exact, "{bounds:?} {exact}");
        let mut swing = |h: f64| {
            let mut state = State::at_rest(points.clone());
            state.velocity[20].x = 1e-3;
            let mut largest = 0.0_f64;
            for _ in 0..2000 {
                if stepper.step(&mut state, &mut [&mut springs], h).is_err() {
                    return f64::INFINITY;
                }
                largest = largest.max((state.position[20].x - points[20].x).abs());
            }
            largest
        };
        assert!(swing(bounds.certain_step()) < 1e-2);
        assert!(swing(2.0 / exact * 0.9999) < 1e-2);
        assert!(swing(2.0 / exact * 1.05) > 1.0);
    }
    let mut coupled = Mass::zeros(2);
    coupled.add_elements(&[[0, 1]], MassDistribution::Consistent, |_| [[2.0, 1.0], [1.0, 2.0]]).unwrap();
    let refused = ExplicitStepper::new(ExplicitScheme::SymplecticEuler, coupled, PointMap::identity(2));
    assert!(matches!(refused, Err(StepError::ConsistentMass { pair: [1, 0] })));
    let massless = ExplicitStepper::new(ExplicitScheme::SymplecticEuler, mass, PointMap::identity(21));
    assert!(matches!(massless, Err(StepError::NoMass { point: 0, .. })));
}

/// A scripted point is where it should be at the end of the step, exactly; the spring behind it follows.
#[test]
fn scripted_points_reach_their_targets_exactly() {
    for scheme in SCHEMES {
        let (mut springs, mass, points) = chain(3, 100.0, 1.0);
        let map = PointMap::with_fixed(4, &[(0, points[0])]).unwrap();
        let mut stepper = Stepper::new(mass, map, options(scheme));
        let mut state = State::at_rest(points);
        for k in 1..=50 {
            let target = Vec3::new(0.01 * f64::from(k), (0.1 * f64::from(k)).sin() * 0.1, 0.0);
            stepper.set_target(0, target).unwrap();
            stepper.step(&mut state, &mut [&mut springs], 0.01).unwrap();
            assert_eq!(state.position[0], target, "{scheme:?}");
        }
        let moved = state.position[3] - Vec3::new(3.0, 0.0, 0.0);
        assert!(moved.norm() > 0.1 && moved.norm() < 1.0, "{scheme:?}: {moved}");
        assert!(stepper.set_target(9, Vec3::zeros()).is_err());
        assert!(stepper.set_target(0, Vec3::repeat(f64::NAN)).is_err());
    }
}

/// A run that is saved and resumed with a new stepper has the bits of one that is not.
#[test]
fn a_resumed_run_repeats_the_original() {
    for scheme in SCHEMES {
        let (mut springs, mass, points) = chain(8, 200.0, 0.3);
        let mut gravity = DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -9.81)).unwrap();
        let map = PointMap::with_fixed(9, &[(0, points[0])]).unwrap();
        let new = || Stepper::new(mass.clone(), map.clone(), options(scheme));
        let mut stepper = new();
        let mut state = State::at_rest(points);
        let mut run = |stepper: &mut Stepper, state: &mut State| {
            for _ in 0..4 {
                stepper.step(state, &mut [&mut springs, &mut gravity], 0.01).unwrap();
            }
        };
        run(&mut stepper, &mut state);
        let mut checkpoint = Checkpoint::new();
        state.save(&mut checkpoint, "chain");
        run(&mut stepper, &mut state);
        let mut resumed = State::load(&mut checkpoint, "chain").unwrap();
        run(&mut new(), &mut resumed);
        assert_eq!(resumed.hash(), state.hash(), "{scheme:?}");
    }
}

/// A load with an amplitude is that of the time that the scheme evaluates at.
#[test]
fn a_load_is_that_of_its_time() {
    for scheme in SCHEMES {
        let mut mass = Mass::zeros(1);
        mass.add_point(0, 2.0).unwrap();
        let table = Amplitude::Table(vec![(0.0, 0.0), (1.0, 10.0)]);
        let mut force = DeadLoad::new("push", vec![(0, Vec3::x())]).unwrap().with_amplitude(table);
        let mut stepper = Stepper::new(mass, PointMap::identity(1), options(scheme));
        let mut state = State::at_rest(vec![Vec3::zeros()]);
        let h = 0.1;
        stepper.step(&mut state, &mut [&mut force], h).unwrap();
        // The impulse of 10 t over the step is ½·10 h²; the first step of BDF2 and backward Euler take the force at the end.
        let impulse = match scheme {
            TimeScheme::BackwardEuler | TimeScheme::Bdf2 => 10.0 * h * h,
            TimeScheme::Newmark | TimeScheme::ImplicitMidpoint => 5.0 * h * h,
        };
        assert!((state.velocity[0].x - impulse / 2.0).abs() < 1e-14, "{scheme:?}");
    }
}

/// The same of explicit schemes: the force at the start, or the mean of both ends.
#[test]
fn a_load_of_explicit_steps_is_that_of_its_time() {
    let h = 0.1;
    for (scheme, impulse) in
        [(ExplicitScheme::SymplecticEuler, 0.0), (ExplicitScheme::CentralDifferences, 5.0 * h * h)]
    {
        let mut mass = Mass::zeros(2);
        mass.add_point(0, 2.0).unwrap();
        let table = Amplitude::Table(vec![(0.0, 0.0), (1.0, 10.0)]);
        let mut force = DeadLoad::new("push", vec![(0, Vec3::x())]).unwrap().with_amplitude(table);
        // The second point is not yet where the map holds it.
        let target = Vec3::new(0.0, 0.3, 0.0);
        let map = PointMap::with_fixed(2, &[(1, target)]).unwrap();
        let stepper = ExplicitStepper::new(scheme, mass, map).unwrap();
        let mut state = State::at_rest(vec![Vec3::zeros(); 2]);
        stepper.step(&mut state, &mut [&mut force], h).unwrap();
        assert!((state.velocity[0].x - impulse / 2.0).abs() < 1e-14, "{scheme:?}: {}", state.velocity[0]);
        assert_eq!((state.position[1], state.time), (target, h));
        assert!((state.velocity[1] - target / h).norm() < 1e-14, "{scheme:?}: {}", state.velocity[1]);
    }
}

/// What finds an equilibrium leaves nothing of the motion before: neither velocities nor what schemes remember.
#[test]
fn an_equilibrium_is_at_rest() {
    let (mut springs, mass, points) = chain(3, 100.0, 1.0);
    let mut gravity = DeadLoad::gravity(&mass, &Vec3::new(9.81, 0.0, 0.0)).unwrap();
    let map = PointMap::with_fixed(4, &[(0, points[0])]).unwrap();
    let mut stepper = Stepper::new(mass, map, options(TimeScheme::Bdf2));
    let mut state = State::at_rest(points);
    stepper.step(&mut state, &mut [&mut springs, &mut gravity], 0.01).unwrap();
    assert!(state.velocity[3].norm() > 0.01);
    stepper.equilibrium(&mut state, &mut [&mut springs, &mut gravity], 4).unwrap();
    assert!(state.velocity.iter().all(|v| *v == Vec3::zeros()), "{:?}", state.velocity);
    // Each spring is stretched by what hangs on it: m g (3 + 2 + 1)/k.
    let stretch = 9.81 * 6.0 / 100.0;
    assert!((state.position[3] - Vec3::new(3.0 + stretch, 0.0, 0.0)).norm() < 1e-6, "{}", state.position[3]);
    // A step from there is the first of its kind: it moves nothing.
    let rest = state.clone();
    stepper.step(&mut state, &mut [&mut springs, &mut gravity], 0.01).unwrap();
    assert!(state.position.iter().zip(&rest.position).all(|(a, b)| (a - b).norm() < 1e-6));
}

/// A spring's term that takes a millisecond for every answer.
struct Slow(StencilTerm<Springs, 2>);

const ANSWER: Duration = Duration::from_millis(1);

impl Potential for Slow {
    fn name(&self) -> &str {
        self.0.name()
    }
    fn value(&self, x: &[Vec3]) -> f64 {
        std::thread::sleep(ANSWER);
        self.0.value(x)
    }
    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        std::thread::sleep(ANSWER);
        self.0.add_gradient(x, gradient);
    }
    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        std::thread::sleep(ANSWER);
        self.0.add_hessian(x, projection, hessian);
    }
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        std::thread::sleep(ANSWER);
        self.0.freeze(stage)
    }
    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        std::thread::sleep(ANSWER);
        self.0.limit_step(x, p)
    }
}

/// A sleep is never shorter than asked for, so that these bounds hold on any machine.
#[test]
fn the_times_of_a_term_are_those_of_all_it_does() {
    let (springs, mass, points) = chain(2, 100.0, 1.0);
    let mut slow = Slow(springs);
    let mut gravity = DeadLoad::gravity(&mass, &Vec3::new(0.0, 0.0, -9.81)).unwrap();
    let map = PointMap::with_fixed(3, &[(0, points[0])]).unwrap();
    let mut stepper = Stepper::new(mass, map, options(TimeScheme::BackwardEuler));
    let mut state = State::at_rest(points);
    let report = stepper.step(&mut state, &mut [&mut gravity, &mut slow], 0.01).unwrap();
    let names: Vec<&str> = report.terms.iter().map(|term| term.name.as_str()).collect();
    assert_eq!(names.len(), 3, "{names:?}");
    let times = report.terms[2].times;
    assert_eq!(names[2], slow.name());
    let iterations = report.newton.iterations as u32;
    assert!(iterations > 0);
    assert!(times.value >= 2 * ANSWER && times.freeze >= 2 * ANSWER, "{times:?}");
    assert!(times.gradient >= iterations * ANSWER && times.hessian >= iterations * ANSWER, "{times:?}");
    assert!(times.limit_step >= iterations * ANSWER && report.time >= times.gradient, "{times:?}");
}

/// A force k x̄ that lags: its x̄ is refreshed at every lag iteration, as friction's normal forces are.
struct LaggedForce {
    k: f64,
    lagged: Vec3,
}

impl Potential for LaggedForce {
    fn name(&self) -> &str {
        "lagged"
    }
    fn value(&self, x: &[Vec3]) -> f64 {
        -self.k * self.lagged.dot(&x[0])
    }
    fn add_gradient(&self, _: &[Vec3], gradient: &mut [Vec3]) {
        gradient[0] -= self.lagged * self.k;
    }
    fn add_hessian(&self, _: &[Vec3], _: Projection, _: &mut Assembler<'_>) {}
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        if stage.moment == Moment::Lag && self.lagged != stage.x[0] {
            self.lagged = stage.x[0];
            return Ok(Changed::Energy);
        }
        Ok(Changed::Nothing)
    }
}

/// Repeated lagging of the force k x finds the fixed point of (m/h²)(x − x̃) = k x; once is one sweep of it.
#[test]
fn lag_iterations_settle() {
    let step = |lagging| {
        let mut mass = Mass::zeros(1);
        mass.add_point(0, 1.0).unwrap();
        let options = StepperOptions { lagging, ..options(TimeScheme::BackwardEuler) };
        let mut stepper = Stepper::new(mass, PointMap::identity(1), options);
        let mut state = State::at_rest(vec![Vec3::x()]);
        let mut force = LaggedForce { k: 10.0, lagged: Vec3::zeros() };
        let report = stepper.step(&mut state, &mut [&mut force], 0.1);
        report.map(|report| (state.position[0].x, report.lag_iterations))
    };
    let (once, iterations) = step(Lagging::Once).unwrap();
    assert!((once - 1.1).abs() < 1e-12 && iterations == 1);
    let (settled, iterations) = step(Lagging::Until(40)).unwrap();
    assert!((settled - 1.0 / 0.9).abs() < 1e-12 && (10..20).contains(&iterations), "{settled} {iterations}");
    let (three, iterations) = step(Lagging::AtMost(3)).unwrap();
    assert!((three - 1.111).abs() < 1e-12 && iterations == 3);
    assert!(matches!(step(Lagging::Until(3)), Err(StepError::Lagging { iterations: 3, .. })));
}

/// A force A x that lags, A not symmetric.
struct LaggedTurn {
    matrix: Mat3,
    lagged: Vec3,
}

impl Potential for LaggedTurn {
    fn name(&self) -> &str {
        "lagged turn"
    }
    fn value(&self, x: &[Vec3]) -> f64 {
        -self.lagged.dot(&x[0])
    }
    fn add_gradient(&self, _: &[Vec3], gradient: &mut [Vec3]) {
        gradient[0] -= self.lagged;
    }
    fn add_settled_gradient(&self, stage: &Stage<'_>, gradient: &mut [Vec3]) {
        gradient[0] -= self.matrix * stage.x[0];
    }
    fn add_hessian(&self, _: &[Vec3], _: Projection, _: &mut Assembler<'_>) {}
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        let anew = self.matrix * stage.x[0];
        let is_settled = (anew - self.lagged).norm() <= 1e-9 * anew.norm();
        if stage.moment == Moment::Settling || stage.moment == Moment::Lag && !is_settled {
            self.lagged = anew;
            return Ok(Changed::Energy);
        }
        Ok(Changed::Nothing)
    }
}

/// Lagging x ← x̃ + (h²/m) A x runs away where A has an eigenvalue beyond m/h², here a pair of imaginary ones, ±1.1 i m/h², and −1.5 m/h². The equations
/// (m/h²)(x − x̃) = A x have their solution all the same.
#[test]
fn what_lagging_does_not_settle_is_solved_as_it_is() {
    let h = 0.1;
    let turn = Mat3::new(0.0, -110.0, 0.0, 110.0, 0.0, 20.0, 0.0, 0.0, -150.0);
    let mut mass = Mass::zeros(1);
    mass.add_point(0, 1.0).unwrap();
    let lagging = Lagging::Until(30);
    let options = StepperOptions { lagging, ..options(TimeScheme::BackwardEuler) };
    let mut stepper = Stepper::new(mass, PointMap::identity(1), options);
    let start = Vec3::new(1.0, -0.5, 0.25);
    let mut state = State::at_rest(vec![start]);
    let mut force = LaggedTurn { matrix: turn, lagged: Vec3::zeros() };
    let report = stepper.step(&mut state, &mut [&mut force], h).unwrap();
    let exact = (Mat3::identity() - turn * (h * h)).try_inverse().unwrap() * start;
    assert!((state.position[0] - exact).norm() < 1e-8, "{} {exact}", state.position[0]);
    assert!(report.settlings == 1 && report.lag_iterations == 25, "{report:?}");
}

/// The midpoint rule on a nonlinear system: the energy stays near its start for long, backward Euler loses it.
#[test]
fn the_midpoint_rule_keeps_the_energy_of_a_pendulum() {
    let mut scene = SpringPendulum::new();
    let mut drift = |scheme| {
        let mut stepper = Stepper::new(scene.mass.clone(), SpringPendulum::map(), options(scheme));
        let mut state = scene.start.clone();
        let energy = |state: &State, scene: &mut SpringPendulum| {
            scene.mass.kinetic_energy(&state.velocity)
                + scene.spring.value(&state.position)
                + scene.gravity.value(&state.position)
        };
        let start = energy(&state, &mut scene);
        let mut largest = 0.0_f64;
        for _ in 0..3000 {
            stepper.step(&mut state, &mut [&mut scene.spring, &mut scene.gravity], 0.01).unwrap();
            largest = largest.max((energy(&state, &mut scene) - start).abs());
        }
        largest
    };
    let (midpoint, euler) = (drift(TimeScheme::ImplicitMidpoint), drift(TimeScheme::BackwardEuler));
    assert!(midpoint < 0.02 && euler > 0.5, "{midpoint} {euler}");
}
