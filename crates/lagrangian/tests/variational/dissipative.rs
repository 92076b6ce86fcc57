//! Implicit Euler and BDF2: closed forms on the oscillator, and which formulation runs.

use crate::systems::{Duffing, Oscillator, REGULAR, SpringPendulum, run, system};
use lagrangian::integrator::{Bdf2, Formulation, GaussLegendre, ImplicitEuler, Integrator};
use lagrangian::{EulerLagrange, Lagrangian, Phase, System};
use mechanics_core::scalar::Scalar;
use serde_json::Value;

/// Amplitude per step |ζ| and frequency ratio arg ζ/z of a linear two-term recurrence x₊ = 2 Re ζ x − |ζ|² x₋, from
/// four successive values.
fn principal_root(x: [f64; 4], z: f64) -> (f64, f64) {
    let determinant = x[1] * x[1] - x[0] * x[2];
    let trace = (x[1] * x[2] - x[0] * x[3]) / determinant;
    let square = (x[2] * x[2] - x[1] * x[3]) / determinant;
    (square.sqrt(), (trace / (2.0 * square.sqrt())).acos() / z)
}

fn oscillate(integrator: &mut impl Integrator<EulerLagrange<Oscillator, 1>>, z: f64) -> (f64, f64) {
    let oscillator = system(Oscillator { frequency: 1.0 });
    let mut phase = Phase::new(0.0, [1.0], [0.3]);
    // BDF2's second root, below 1/3, has died out by then.
    for _ in 0..40 {
        integrator.step(&oscillator, &mut phase, z).unwrap();
    }
    let mut x = [phase.q[0]; 4];
    for x in &mut x[1..] {
        integrator.step(&oscillator, &mut phase, z).unwrap();
        *x = phase.q[0];
    }
    principal_root(x, z)
}

#[test]
fn amplitude_and_frequency_per_step_are_those_of_the_closed_forms() {
    let path = format!("{}/tests/fixtures/mechanics_reference.json", env!("CARGO_MANIFEST_DIR"));
    let json: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for case in json["integrators_on_oscillator"].as_array().unwrap() {
        let number = |key: &str| case[key].as_str().unwrap().parse::<f64>().unwrap();
        let z = number("z");
        let check = |(amplitude, ratio): (f64, f64), name: &str, amplitude_key: &str, ratio_key: &str| {
            let gaps = [(amplitude - number(amplitude_key)).abs(), (ratio - number(ratio_key)).abs()];
            // Cancellation in the fit costs 1/z² in the amplitude and 1/z² again in the angle.
            assert!(gaps[0] < 2e-15 / (z * z), "{name}, z = {z}: amplitude off by {:e}", gaps[0]);
            assert!(
                gaps[1] < 2e-14 / (z * z * z * z).min(z * z),
                "{name}, z = {z}: frequency off by {:e}",
                gaps[1]
            );
        };
        let euler = oscillate(&mut ImplicitEuler::new(), z);
        check(euler, "implicit Euler", "implicit_euler_amp", "implicit_euler_freq_ratio");
        check(oscillate(&mut Bdf2::new(), z), "BDF2", "bdf2_amp", "bdf2_freq_ratio");
        let midpoint = oscillate(&mut GaussLegendre::<1, _>::new(), z);
        check(midpoint, "midpoint", "midpoint_newmark_amp", "midpoint_freq_ratio");
        check(oscillate(&mut GaussLegendre::<2, _>::new(), z), "Gauss 4", "gl4_amp", "gl4_freq_ratio");
    }
}

/// An oscillator whose force turns: Q = c (−y, x) has no potential.
#[derive(Clone, Debug)]
struct Swirl;

impl Lagrangian<2> for Swirl {
    fn kinetic<S: Scalar>(&self, _: &[S; 2], v: &[S; 2], _: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _: S) -> S {
        (q[0].square() + q[1].square()).scale(0.5)
    }
    fn force<S: Scalar>(&self, q: &[S; 2], _: &[S; 2], _: S) -> [S; 2] {
        [-q[1].scale(0.1), q[0].scale(0.1)]
    }
}

#[test]
fn the_formulation_follows_the_mass_matrix_and_the_forces() {
    fn after_one_step<const N: usize, L: Lagrangian<N>>(
        lagrangian: L,
        q: [f64; N],
    ) -> [Option<Formulation>; 2] {
        let (mut euler, mut bdf2) = (ImplicitEuler::new(), Bdf2::new());
        let system = system(lagrangian);
        assert_eq!(euler.formulation(), None);
        euler.step(&system, &mut Phase::new(0.0, q, [0.1; N]), 0.01).unwrap();
        bdf2.step(&system, &mut Phase::new(0.0, q, [0.1; N]), 0.01).unwrap();
        [euler.formulation(), bdf2.formulation()]
    }
    let oscillator = Oscillator { frequency: 2.0 };
    assert_eq!(after_one_step(oscillator, [1.0]), [Some(Formulation::Minimisation); 2]);
    assert_eq!(after_one_step(Duffing, [1.0]), [Some(Formulation::Minimisation); 2]);
    assert_eq!(after_one_step(Swirl, [1.0, 0.5]), [Some(Formulation::RootFinding); 2]);
    assert_eq!(after_one_step(REGULAR, [1.0, 0.5]), [Some(Formulation::RootFinding); 2]);
    assert_eq!(after_one_step(SpringPendulum, [1.0, 0.5]), [Some(Formulation::RootFinding); 2]);
}

/// One step of implicit Euler on the damped, driven, two-well oscillator satisfies its equation as written.
#[test]
fn a_minimised_step_satisfies_the_equation_of_implicit_euler() {
    let h = 0.2;
    let start = Phase::new(0.7, [0.3], [0.8]);
    let end = run(&system(Duffing), &mut ImplicitEuler::new(), &start, 0.7 + h, 1);
    let (x, v, t) = (end.q[0], end.v[0], end.time);
    let force = x - x.powi(3) - 0.3 * v + 0.5 * (1.2 * t).cos();
    assert!((x - (0.3 + (t - 0.7) * v)).abs() < 1e-15);
    assert!((v - (0.8 + (t - 0.7) * force)).abs() < 1e-15, "{v}");
}

/// With a step far beyond its period, a stiff oscillator is at rest after a few steps (implicit Euler: 1/√(1 + z²) a
/// step), and what is slow goes on.
#[test]
fn steps_far_beyond_the_period_damp() {
    let stiff = system(Oscillator { frequency: 1e4 });
    let end = run(&stiff, &mut ImplicitEuler::new(), &Phase::new(0.0, [1.0], [0.0]), 1.0, 10);
    let expected = (1.0 + 1e6_f64).powf(-5.0);
    assert!(end.q[0].abs() <= expected, "{} {expected}", end.q[0]);
    let end = run(&stiff, &mut Bdf2::new(), &Phase::new(0.0, [1.0], [0.0]), 1.0, 10);
    assert!(end.q[0].abs() < 1e-10, "{}", end.q[0]);
}

/// Where H is convex the root-finding form loses energy in every step, here by ½ h² żᵀ∇²H ż to leading order: half
/// the step, a quarter of the loss.
#[test]
fn root_finding_dissipates_where_the_energy_is_convex() {
    let system = system(REGULAR);
    let start = Phase::new(0.0, [0.5, -0.25], [0.0, 0.5]);
    let energy = |phase: &Phase<[f64; 2]>| system.energy(phase.time, &phase.q, &phase.v);
    let (mut phase, mut euler) = (start.clone(), ImplicitEuler::new());
    let mut last = energy(&phase);
    for _ in 0..500 {
        euler.step(&system, &mut phase, 0.01).unwrap();
        assert!(energy(&phase) < last);
        last = energy(&phase);
    }
    let loss = |h: f64| energy(&start) - energy(&run(&system, &mut ImplicitEuler::new(), &start, h, 1));
    let ratio = loss(1e-3) / loss(5e-4);
    assert!((ratio - 4.0).abs() < 0.02, "{ratio}");
}

/// Steps that alternate by a factor of nearly two: starting anew with each would leave order one.
#[test]
fn bdf2_keeps_its_order_with_changing_steps() {
    let system = system(Oscillator { frequency: 1.0 });
    let error = |pairs: u32| {
        let (mut bdf2, mut phase) = (Bdf2::new(), Phase::new(0.0, [1.0], [0.0]));
        for _ in 0..pairs {
            for share in [0.7, 1.3] {
                bdf2.step(&system, &mut phase, share / f64::from(pairs)).unwrap();
            }
        }
        (phase.q[0] - phase.time.cos()).abs()
    };
    let order = (error(200) / error(400)).log2();
    assert!((order - 2.0).abs() < 0.15, "{order}");
}
