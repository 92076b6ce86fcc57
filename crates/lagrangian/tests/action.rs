//! Stationary action against exact actions, exact conjugate points, dense eigenvalues and high-precision trajectories.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use lagrangian::action::{Action, Extremum, Galerkin, Outcome, Search};
use lagrangian::error::PathFailure;
use lagrangian::{EulerLagrange, Lagrangian, LagrangianError, System};
use mechanics_core::scalar::Scalar;
use nalgebra::DMatrix;
use serde_json::Value;
use std::f64::consts::PI;

struct Oscillator {
    omega: f64,
}

impl Lagrangian<1> for Oscillator {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].square().scale(0.5 * self.omega * self.omega)
    }
}

struct FreeFall;

impl Lagrangian<1> for FreeFall {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].scale(9.81)
    }
}

struct Pendulum;

impl Lagrangian<1> for Pendulum {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].cos().scale(-9.81)
    }
}

struct DoublePendulum;

impl Lagrangian<2> for DoublePendulum {
    fn kinetic<S: Scalar>(&self, q: &[S; 2], v: &[S; 2], _t: S) -> S {
        let (m1, m2, l1, l2) = (2.0, 1.0, 1.0, 0.5);
        v[0].square().scale(0.5 * (m1 + m2) * l1 * l1)
            + v[1].square().scale(0.5 * m2 * l2 * l2)
            + (v[0] * v[1] * (q[0] - q[1]).cos()).scale(m2 * l1 * l2)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        q[0].cos().scale(-9.81 * 3.0) + q[1].cos().scale(-9.81 * 0.5)
    }
}

struct Kepler;

impl Lagrangian<2> for Kepler {
    fn kinetic<S: Scalar>(&self, _q: &[S; 2], v: &[S; 2], _t: S) -> S {
        (v[0].square() + v[1].square()).scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
        -(q[0].square() + q[1].square()).sqrt().recip()
    }
}

const GALERKIN: fn(usize) -> Galerkin = |degree| Galerkin { degree };

fn fixture(name: &str) -> Value {
    let path = format!("{}/tests/fixtures/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().or_else(|| value.as_str().map(|s| s.parse().unwrap())).unwrap()
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|i| number(&value[i]))
}

/// The exact action of the oscillator between two points (Feynman and Hibbs, *Quantum Mechanics and Path Integrals*,
/// problem 2-2).
fn oscillator_action(omega: f64, a: f64, b: f64, time: f64) -> f64 {
    let angle = omega * time;
    omega / (2.0 * angle.sin()) * ((a * a + b * b) * angle.cos() - 2.0 * a * b)
}

/// A motion by the classical fourth-order method with many small steps, as a start for boundary value problems.
fn motion<const N: usize, S: System<Coordinates = [f64; N]>>(
    system: &S,
    mut q: [f64; N],
    mut v: [f64; N],
    times: &[f64],
) -> Vec<[f64; N]> {
    let shifted = |x: &[f64; N], d: &[f64; N], h: f64| std::array::from_fn(|i| x[i] + h * d[i]);
    let mut out = vec![q];
    for pair in times.windows(2) {
        let h = (pair[1] - pair[0]) / 8.0;
        for step in 0..8 {
            let t = pair[0] + h * f64::from(step);
            let (mut x, mut u) = (q, v);
            let (mut dq, mut dv) = ([0.0; N], [0.0; N]);
            for (stage, weight) in [1.0, 2.0, 2.0, 1.0].into_iter().enumerate() {
                let mut a = [0.0; N];
                system.acceleration(t, &x, &u, &mut a).unwrap();
                dq = shifted(&dq, &u, weight / 6.0);
                dv = shifted(&dv, &a, weight / 6.0);
                let ahead = if stage == 2 { h } else { 0.5 * h };
                (x, u) = (shifted(&q, &u, ahead), shifted(&v, &a, ahead));
            }
            q = shifted(&q, &dq, h);
            v = shifted(&v, &dv, h);
        }
        out.push(q);
    }
    out
}

#[test]
fn fixture_actions_and_extrema() {
    for case in fixture("action_bvp").as_array().unwrap() {
        let name = case["system"].as_str().unwrap();
        let [from, to, time, exact] = ["q0", "q1", "T", "action"].map(|key| number(&case[key]));
        let minimum = case["is_minimum"].as_bool().unwrap();
        let (oscillator, fall) =
            (EulerLagrange::new(Oscillator { omega: 1.5 }), EulerLagrange::new(FreeFall));
        let solve = |n, rule| {
            if name.starts_with("harmonic") {
                let action = Action::new(&oscillator, 0.0, time, n, rule).unwrap();
                action.stationary(&action.straight(&[from], &[to]), &Search::default()).unwrap()
            } else {
                let action = Action::new(&fall, 0.0, time, n, rule).unwrap();
                action.stationary(&action.straight(&[from], &[to]), &Search::default()).unwrap()
            }
        };
        for (n, degree) in [(400, 2), (40, 4), (10, 6), (2, 12)] {
            let found = solve(n, GALERKIN(degree));
            let error = (found.action - exact).abs() / exact.abs();
            println!(
                "{name} T = {time}: degree {degree}, {n} intervals: A = {} error {error:e}, {:?}",
                found.action,
                found.extremum()
            );
            assert!(error <= 1e-10, "{name}, degree {degree}: {error:e}");
            let expected = if minimum { Extremum::Minimum } else { Extremum::Saddle { index: 1 } };
            assert_eq!(found.extremum(), expected);
            assert!(found.iterations <= 2, "A is quadratic: {} iterations", found.iterations);
        }
    }
}

#[test]
fn actions_converge_with_their_order() {
    let system = EulerLagrange::new(Oscillator { omega: 1.5 });
    let exact = oscillator_action(1.5, 0.25, 1.0, 2.5);
    for (rule, coarse) in [(Galerkin::MIDPOINT, 64), (GALERKIN(2), 16), (GALERKIN(3), 8), (GALERKIN(4), 4)] {
        let error = |n| {
            let action = Action::new(&system, 0.0, 2.5, n, rule).unwrap();
            let found = action.stationary(&action.straight(&[0.25], &[1.0]), &Search::default()).unwrap();
            (found.action - exact).abs()
        };
        let order = (error(coarse) / error(2 * coarse)).log2();
        println!("{rule:?}: order {order}, error {:e}", error(2 * coarse));
        let allowed = if rule.order() <= 4 { 0.15 } else { 0.5 };
        assert!((order - rule.order() as f64).abs() < allowed, "{rule:?}: {order}");
    }
}

/// Near half a period the action is nearly flat along the path's own shape: a residual within its rounding once left
/// errors of 8.5e-11 in the path (found by the scene `stationary-action-minimum`).
#[test]
fn a_nearly_flat_action_does_not_spoil_the_path() {
    let (omega, a, b, time) = (1.5f64, 0.25f64, 1.0f64, 2.0f64);
    let system = EulerLagrange::new(Oscillator { omega });
    for intervals in [80, 160, 320] {
        let action = Action::new(&system, 0.0, time, intervals, Galerkin { degree: 3 }).unwrap();
        let found = action.stationary(&action.straight(&[a], &[b]), &Search::default()).unwrap();
        let exact = |t: f64| (a * (omega * (time - t)).sin() + b * (omega * t).sin()) / (omega * time).sin();
        let worst = found.path.joints().map(|(t, q)| (q[0] - exact(t)).abs()).fold(0.0, f64::max);
        // The discretisation's own error falls with the sixth power: 3.5e-11 at 80 intervals.
        let discretisation = 3.6e-11 * (80.0 / intervals as f64).powi(6);
        assert!(worst < discretisation + 2e-12, "{intervals}: {worst:e}");
    }
}

#[test]
fn midpoint_rule_keeps_the_parabola_and_its_action_is_wrong_by_a_known_amount() {
    // δA = 0 is (q₊ − 2q + q₋)/h² = −g, which a parabola solves exactly. Chords instead of arcs lower ∫ v²/2 by g² h²/24 and
    // raise ∫ −g y by g² h²/12, each a second: A_d − A = g² T h²/24 for m = 1.
    let system = EulerLagrange::new(FreeFall);
    let (g, time, height) = (9.81, 1.0, 2.0);
    let exact = 0.5 * height * height / time - 0.5 * g * height * time - g * g * time.powi(3) / 24.0;
    for n in [2, 5, 40, 1000] {
        let action = Action::new(&system, 0.0, time, n, Galerkin::MIDPOINT).unwrap();
        let found = action.stationary(&action.straight(&[0.0], &[height]), &Search::default()).unwrap();
        let speed = height / time + 0.5 * g * time;
        for (t, q) in found.path.joints() {
            assert!((q[0] - (speed * t - 0.5 * g * t * t)).abs() < 1e-11, "n = {n}, t = {t}: {}", q[0]);
        }
        let h = action.step();
        let excess = found.action - exact;
        assert!((excess - g * g * time * h * h / 24.0).abs() < 1e-12, "n = {n}: {excess:e}");
        assert_eq!(found.extremum(), Extremum::Minimum);
    }
}

#[test]
fn pendulum_paths_reach_the_actions_of_the_fixtures() {
    let system = EulerLagrange::new(Pendulum);
    for name in ["pendulum_large", "pendulum_1rad", "pendulum_rotating"] {
        let data = fixture(name);
        let samples = data["samples"].as_array().unwrap();
        for (first, last) in [(0, 1), (0, 5), (2, 10)] {
            let (start, end) = (&samples[first], &samples[last]);
            check_arc(&system, start, end, name);
        }
    }
}

#[test]
fn two_coordinates_reach_the_actions_of_the_fixtures() {
    let data = fixture("double_pendulum_regular");
    let system = EulerLagrange::new(DoublePendulum);
    let samples = data["samples"].as_array().unwrap();
    for (first, last) in [(0, 1), (0, 4), (3, 10)] {
        check_arc(&system, &samples[first], &samples[last], "double pendulum");
    }
    let data = fixture("kepler_e06");
    let system = EulerLagrange::new(Kepler);
    let samples = data["samples"].as_array().unwrap();
    for (first, last) in [(0, 1), (1, 4), (0, 10)] {
        check_arc(&system, &samples[first], &samples[last], "Kepler");
    }
}

/// The stationary path near the motion between two samples of a fixture has the fixture's action and passes its samples.
fn check_arc<const N: usize, S: System<Coordinates = [f64; N]>>(
    system: &S,
    start: &Value,
    end: &Value,
    name: &str,
) {
    let (from, to) = (number(&start["t"]), number(&end["t"]));
    let exact = number(&end["action"]) - number(&start["action"]);
    let (q, v, last): ([f64; N], [f64; N], [f64; N]) =
        (numbers(&start["q"]), numbers(&start["qdot"]), numbers(&end["q"]));
    let intervals = ((to - from) * 24.0).ceil() as usize;
    let action = Action::new(system, from, to, intervals, GALERKIN(6)).unwrap();
    let times: Vec<f64> = (0..action.node_count()).map(|node| action.time(node)).collect();
    let guesses = motion(system, q, v, &times);
    let mut at = 0;
    let guess = action.path(|_| {
        at += 1;
        // Far enough from the motion that Newton's method has work to do; the end is the fixture's.
        let bump = 0.01 * (PI * (at - 1) as f64 / (guesses.len() - 1) as f64).sin();
        if at == guesses.len() { last } else { guesses[at - 1].map(|x| x + bump) }
    });
    let found = action.stationary(&guess, &Search::default()).unwrap();
    let error = (found.action - exact).abs();
    println!(
        "{name} {from} to {to} s: action {} error {error:e}, {:?}, {} iterations, residual {:e} ({:e})",
        found.action,
        found.extremum(),
        found.iterations,
        found.residual,
        found.rounding
    );
    assert!(error <= 1e-10 * (1.0 + exact.abs()), "{name}: {error:e}");
    let arrival = found.path.at(to);
    let expected: [f64; N] = numbers(&end["qdot"]);
    for i in 0..N {
        assert!(
            (arrival.v[i] - expected[i]).abs() < 1e-6 * (1.0 + expected[i].abs()),
            "{name}: {arrival:?} {expected:?}"
        );
    }
}

/// Number of negative eigenvalues by nalgebra, of the Hessian by differences of exact gradients.
fn dense_index<const N: usize, S: System<Coordinates = [f64; N]>>(
    action: &Action<'_, S>,
    path: &lagrangian::action::Path<[f64; N]>,
) -> (usize, f64) {
    let unknowns = action.gradient(path).len();
    let mut hessian = DMatrix::zeros(unknowns, unknowns);
    for j in 0..unknowns {
        let shifted = |by: f64| {
            let mut positions = path.positions().to_vec();
            positions[1 + j / N][j % N] += by;
            let mut next = positions.into_iter();
            action.gradient(&action.path(|_| next.next().unwrap()))
        };
        let (up, down) = (shifted(1e-4), shifted(-1e-4));
        (0..unknowns).for_each(|i| hessian[(i, j)] = (up[i] - down[i]) / 2e-4);
    }
    let symmetric = 0.5 * (&hessian + hessian.transpose());
    let values = symmetric.symmetric_eigenvalues();
    let nearest = values.iter().map(|x| x.abs()).fold(f64::INFINITY, f64::min);
    (values.iter().filter(|x| **x < 0.0).count(), nearest / values.amax())
}

#[test]
fn index_is_that_of_dense_eigenvalues() {
    let search = Search::default();
    let (mut compared, mut largest) = (0, 0);
    let oscillator = EulerLagrange::new(Oscillator { omega: 1.5 });
    for (n, degree) in [(12, 1), (7, 3), (30, 1), (5, 5)] {
        for time in [1.0, 2.5, 4.5, 7.0, 11.0] {
            let action = Action::new(&oscillator, 0.0, time, n, GALERKIN(degree)).unwrap();
            let found = action.stationary(&action.straight(&[0.25], &[1.0]), &search).unwrap();
            let (index, nearest) = dense_index(&action, &found.path);
            assert!(nearest > 1e-9);
            assert_eq!(found.index(), index, "n = {n}, degree {degree}, T = {time}");
            compared += 1;
        }
    }
    // At paths that are not stationary, and with two coordinates.
    let double = EulerLagrange::new(DoublePendulum);
    let kepler = EulerLagrange::new(Kepler);
    for time in [0.3, 1.0, 2.0, 3.5, 6.0] {
        for (n, degree) in [(10, 1), (25, 2), (8, 4)] {
            let action = Action::new(&double, 0.5, 0.5 + time, n, GALERKIN(degree)).unwrap();
            let path = action.path(|t| [0.4 * (3.0 * t).sin(), 0.6 * (2.0 * t).cos()]);
            let (index, nearest) = dense_index(&action, &path);
            if nearest > 1e-7 {
                assert_eq!(
                    action.inertia(&path).unwrap().negative,
                    index,
                    "n = {n}, degree {degree}, T = {time}"
                );
                (compared, largest) = (compared + 1, largest.max(index));
            }
            let action = Action::new(&kepler, 0.0, 2.0 * time, n, GALERKIN(degree)).unwrap();
            let path = action.path(|t| [t.cos(), 0.8 * t.sin()]);
            let (index, nearest) = dense_index(&action, &path);
            if nearest > 1e-7 {
                assert_eq!(
                    action.inertia(&path).unwrap().negative,
                    index,
                    "n = {n}, degree {degree}, T = {time}"
                );
                (compared, largest) = (compared + 1, largest.max(index));
            }
        }
    }
    assert!(compared >= 45 && largest >= 3, "{compared} compared, the largest index {largest}");
}

#[test]
fn index_of_the_oscillator_counts_half_periods() {
    // Conjugate points at k π/ω (Jacobi). Grids with nodes exactly on them break elimination without delayed pivots.
    let omega = 1.5;
    let system = EulerLagrange::new(Oscillator { omega });
    for (n, degree) in [(60, 1), (40, 2), (15, 4), (600, 1)] {
        for tenth in [3, 7, 9, 11, 15, 19, 21, 25, 37, 43, 55, 65] {
            let time = 0.1 * f64::from(tenth) * PI / omega;
            let action = Action::new(&system, 0.0, time, n, GALERKIN(degree)).unwrap();
            let found = action.stationary(&action.straight(&[0.25], &[1.0]), &Search::default()).unwrap();
            assert_eq!(found.index(), tenth as usize / 10, "n = {n}, degree {degree}, {tenth}");
            assert_eq!(found.conjugate_times.len(), found.index());
            for (k, at) in found.conjugate_times.iter().enumerate() {
                let exact = (k as f64 + 1.0) * PI / omega;
                let close = 2.0 * action.step() + exact * (omega * action.step()).powi(2 * degree as i32);
                assert!((at - exact).abs() <= close, "n = {n}, T = {time}: {at} for {exact}");
            }
        }
    }
    // Half-integer multiples of the half period, on grids with nodes on the conjugate points of the discrete problem itself.
    for halves in [3u32, 5, 9] {
        for per_half in [2usize, 3, 4, 8] {
            let n = halves as usize * per_half;
            // Midpoint rule: (q₊ − 2q + q₋)/h² = −ω² (q₊ + 2q + q₋)/4 turns by 2 atan(ωh/2) a step, here π/(2·per_half).
            let h = 2.0 / omega * (PI / (4.0 * per_half as f64)).tan();
            let action = Action::new(&system, 0.0, h * n as f64, n, Galerkin::MIDPOINT).unwrap();
            let found = action.stationary(&action.straight(&[0.25], &[1.0]), &Search::default()).unwrap();
            assert_eq!(found.index(), halves as usize / 2);
            let turn = PI / (2.0 * per_half as f64);
            let whole = turn * n as f64;
            for (k, q) in found.path.positions().iter().enumerate() {
                let angle = turn * k as f64;
                let exact = 0.25 * angle.cos() + (1.0 - 0.25 * whole.cos()) / whole.sin() * angle.sin();
                assert!(
                    (q[0] - exact).abs() < 1e-12,
                    "{halves}, {per_half}: node {k} at {} for {exact}",
                    q[0]
                );
            }
        }
    }
}

#[test]
fn index_of_the_pendulum_counts_the_zeros_of_its_jacobi_field() {
    // Motions that leave the same point with neighbouring velocities meet again at conjugate points (Jacobi).
    let system = EulerLagrange::new(Pendulum);
    let mut indices = Vec::new();
    for (q, v, time) in [(0.3, 1.0, 0.9), (0.3, 1.0, 6.0), (0.0, 6.0, 7.5), (-1.0, 0.5, 9.0), (0.0, 7.0, 5.0)]
    {
        let action = Action::new(&system, 0.0, time, 150, GALERKIN(4)).unwrap();
        let times: Vec<f64> = (0..action.node_count()).map(|node| action.time(node)).collect();
        let run = |v| motion(&system, [q], [v], &times);
        let (slower, middle, faster) = (run(v - 1e-5), run(v), run(v + 1e-5));
        let field: Vec<f64> = faster.iter().zip(&slower).map(|(a, b)| (a[0] - b[0]) / 2e-5).collect();
        let zeros: Vec<f64> =
            (1..field.len() - 1).filter(|&k| field[k] * field[k + 1] < 0.0).map(|k| times[k]).collect();
        let mut positions = middle.iter();
        let found =
            action.stationary(&action.path(|_| *positions.next().unwrap()), &Search::default()).unwrap();
        assert_eq!(found.index(), zeros.len(), "from {q} at {v} for {time} s");
        for (at, zero) in found.conjugate_times.iter().zip(&zeros) {
            // The zero lies between this node and the next one.
            assert!((at - zero).abs() < 2.5 * action.step(), "{at} for {zero}");
        }
        indices.push(found.index());
    }
    assert!(indices.contains(&0) && indices.iter().any(|&index| index > 3), "{indices:?}");
}

#[test]
fn conjugate_ends_are_degenerate_or_refused() {
    let omega = 1.5;
    let system = EulerLagrange::new(Oscillator { omega });
    let action = Action::new(&system, 0.0, PI / omega, 12, GALERKIN(8)).unwrap();
    // All motions from 0.3 meet at −0.3: one of them is found, and it has a direction of no change.
    let found = action.stationary(&action.straight(&[0.3], &[-0.3]), &Search::default()).unwrap();
    assert_eq!(found.extremum(), Extremum::Degenerate { index: 0, nullity: 1 });
    assert!(found.action.abs() < 1e-10);
    // None arrives anywhere else.
    let refused = action.stationary(&action.straight(&[0.3], &[1.0]), &Search::default()).unwrap_err();
    println!("{refused}");
    assert!(
        matches!(refused, LagrangianError::NoStationaryPath { failure: PathFailure::Conjugate, .. }),
        "{refused:?}"
    );
}

#[test]
fn descent_finds_minima_and_leaves_saddles() {
    let system = EulerLagrange::new(Oscillator { omega: 1.5 });
    let search = Search::default();
    let action = Action::new(&system, 0.0, 2.0, 50, Galerkin::MIDPOINT).unwrap();
    let straight = action.straight(&[0.25], &[1.0]);
    let newton = action.stationary(&straight, &search).unwrap();
    let Outcome::Arrived(down) = action.descend(&straight, &search).unwrap().outcome else {
        panic!("a minimum")
    };
    assert_eq!(down.extremum(), Extremum::Minimum);
    for (a, b) in newton.path.positions().iter().zip(down.path.positions()) {
        assert!((a[0] - b[0]).abs() < 1e-10);
    }
    let action = Action::new(&system, 0.0, 2.5, 50, Galerkin::MIDPOINT).unwrap();
    let straight = action.straight(&[0.25], &[1.0]);
    let saddle = action.stationary(&straight, &search).unwrap();
    let descent = action.descend(&straight, &search).unwrap();
    let Outcome::RanAway { extent, action: lowest } = descent.outcome else {
        panic!("a saddle holds nothing")
    };
    println!("ran away in {} steps to {extent:e}, A = {lowest:e}", descent.iterations);
    assert!(lowest < saddle.action - 1e6 && extent > 1e6);
    assert!(descent.actions.windows(2).all(|pair| pair[1] <= pair[0] + 1e-12));
}

#[test]
fn descent_from_beside_a_pendulum_s_saddle_ends_at_a_lower_path() {
    // Hanging still for longer than half a period is stationary, a saddle: swinging out and back has less action.
    let system = EulerLagrange::new(Pendulum);
    let half_period = PI / 9.81f64.sqrt();
    let action = Action::new(&system, 0.0, 1.3 * half_period, 60, GALERKIN(2)).unwrap();
    let rest = action.stationary(&action.straight(&[0.0], &[0.0]), &Search::default()).unwrap();
    assert_eq!(rest.extremum(), Extremum::Saddle { index: 1 });
    let beside = action.path(|t| [1e-3 * (PI * t / (1.3 * half_period)).sin()]);
    let Outcome::Arrived(lower) = action.descend(&beside, &Search::default()).unwrap().outcome else {
        panic!("−V is bounded")
    };
    println!("A = {} at rest, {} swinging", rest.action, lower.action);
    assert_eq!(lower.extremum(), Extremum::Minimum);
    assert!(lower.action < rest.action - 0.1);
    // It is half a swing: the amplitude is that whose half period is the time given, by the arithmetic–geometric mean.
    let amplitude = lower.path.positions().iter().map(|q| q[0].abs()).fold(0.0, f64::max);
    let (mut a, mut g) = (1.0, (0.5 * amplitude).cos());
    for _ in 0..8 {
        (a, g) = (0.5 * (a + g), f64::sqrt(a * g));
    }
    assert!((half_period / a / (1.3 * half_period) - 1.0).abs() < 1e-4, "amplitude {amplitude}");
}

#[test]
fn straight_lines_lead_to_motions() {
    // Newton's method alone does not find all of these; what it finds must be motions, whatever it went through.
    let system = EulerLagrange::new(Pendulum);
    let (mut tried, mut arrived, mut checked) = (0, 0, 0);
    for time in [0.5, 1.25, 2.0, 2.75, 4.0, 5.5] {
        for end in [-5.9, -3.9, -1.4, 0.1, 1.6, 3.1, 5.1] {
            tried += 1;
            let action = Action::new(&system, 0.0, time, 40, GALERKIN(3)).unwrap();
            let found = match action.stationary(&action.straight(&[0.3], &[end]), &Search::default()) {
                Ok(found) => found,
                Err(refused) => {
                    assert!(matches!(refused, LagrangianError::NoStationaryPath { .. }), "{refused}");
                    continue;
                }
            };
            arrived += 1;
            let largest = found.path.positions().iter().map(|q| q[0].abs()).fold(0.0, f64::max);
            // Paths that the grid cannot resolve are stationary for it, but no motions.
            if largest > 8.0 {
                continue;
            }
            // A motion from every joint on arrives at the next; from end to end instabilities would hide that.
            for (k, pair) in found.path.joints().collect::<Vec<_>>().windows(2).enumerate() {
                let (start, end) = (pair[0], pair[1]);
                let velocity = found.path.at(start.0 + 1e-9).v;
                let there = motion(&system, *start.1, velocity, &[start.0, end.0])[1];
                let apart = (there[0] - end.1[0]).abs();
                assert!(apart < 1e-3, "T = {time}, end {:?}: interval {k} by {apart}", end.1);
            }
            checked += 1;
        }
    }
    println!("{arrived} of {tried} found, {checked} resolved");
    assert!(
        arrived * 10 >= tried * 9 && checked * 10 >= tried * 9,
        "{arrived} of {tried}, {checked} resolved"
    );
}

#[test]
fn coordinates_in_very_different_units_do_not_hide_each_other() {
    // Two oscillators, ω = 1 and 2, with masses up to 1e21 apart: conjugate points at kπ and kπ/2.
    struct Mixed {
        masses: [f64; 2],
    }
    impl Lagrangian<2> for Mixed {
        fn kinetic<S: Scalar>(&self, _q: &[S; 2], v: &[S; 2], _t: S) -> S {
            v[0].square().scale(0.5 * self.masses[0]) + v[1].square().scale(0.5 * self.masses[1])
        }
        fn potential<S: Scalar>(&self, q: &[S; 2], _t: S) -> S {
            q[0].square().scale(0.5 * self.masses[0]) + q[1].square().scale(2.0 * self.masses[1])
        }
    }
    for (masses, sizes) in
        [([1e-9, 1e9], [1.0, 1.0]), ([1e-9, 1e9], [1e6, 1e-6]), ([1e12, 1e-9], [1e-3, 1e3])]
    {
        let system = EulerLagrange::new(Mixed { masses });
        for time in [1.0, 2.0, 4.0, 8.0] {
            let action = Action::new(&system, 0.0, time, 60, GALERKIN(4)).unwrap();
            let [from, to] = [[0.3, -0.4], [1.0, 1.0]].map(|x| [x[0] * sizes[0], x[1] * sizes[1]]);
            let found = action.stationary(&action.straight(&from, &to), &Search::default()).unwrap();
            let expected = (time / PI).floor() + (2.0 * time / PI).floor();
            assert_eq!(found.index() as f64, expected, "masses {masses:?}, T = {time}");
            for i in 0..2 {
                let omega = [1.0, 2.0][i];
                let angle = omega * 0.5 * time;
                let exact = 0.5 * (from[i] + to[i]) / angle.cos();
                let middle = found.path.at(0.5 * time).q[i];
                assert!(
                    (middle - exact).abs() < 1e-9 * sizes[i],
                    "{middle} for {exact}, masses {masses:?}, T = {time}"
                );
            }
        }
    }
}

struct Damped;

impl Lagrangian<1> for Damped {
    fn kinetic<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.5)
    }
    fn potential<S: Scalar>(&self, q: &[S; 1], _t: S) -> S {
        q[0].square()
    }
    fn rayleigh<S: Scalar>(&self, _q: &[S; 1], v: &[S; 1], _t: S) -> S {
        v[0].square().scale(0.1)
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let system = EulerLagrange::new(Pendulum);
    let rule = Galerkin::MIDPOINT;
    for (start, end, n) in [
        (0.0, 1.0, 0),
        (1.0, 1.0, 5),
        (1.0, 0.0, 5),
        (0.0, f64::NAN, 5),
        (0.0, f64::INFINITY, 5),
        (1e20, 1e20 + 1e5, 100),
    ] {
        let refused = Action::new(&system, start, end, n, rule).unwrap_err();
        assert!(matches!(refused, LagrangianError::Span { .. }), "{refused}");
    }
    let action = Action::new(&system, 0.0, 1.0, 10, rule).unwrap();
    for bad in [f64::NAN, f64::INFINITY] {
        let guess = action.straight(&[0.0], &[bad]);
        let refused = action.stationary(&guess, &Search::default()).unwrap_err();
        assert!(matches!(refused, LagrangianError::NonFinite { .. }), "{refused}");
    }
    let damped = EulerLagrange::new(Damped);
    let action = Action::new(&damped, 0.0, 1.0, 10, rule).unwrap();
    for refused in [
        action.stationary(&action.straight(&[0.0], &[1.0]), &Search::default()).unwrap_err(),
        action.descend(&action.straight(&[0.0], &[1.0]), &Search::default()).unwrap_err(),
    ] {
        assert!(matches!(refused, LagrangianError::NoAction { coordinate: 0, .. }), "{refused}");
    }
    let kepler = EulerLagrange::new(Kepler);
    let action = Action::new(&kepler, 0.0, 1.0, 9, rule).unwrap();
    let through = action.stationary(&action.straight(&[-1.0, 0.0], &[1.0, 0.0]), &Search::default());
    assert!(matches!(through, Err(LagrangianError::NonFinite { .. })), "through the centre: {through:?}");
    let capped = Search { max_iterations: 1, ..Search::default() };
    let action = Action::new(&system, 0.0, 5.0, 50, rule).unwrap();
    let refused = action.stationary(&action.straight(&[0.0], &[3.0]), &capped).unwrap_err();
    assert!(
        matches!(
            refused,
            LagrangianError::NoStationaryPath { failure: PathFailure::Iterations, iterations: 1, .. }
        ),
        "{refused}"
    );
}

#[test]
fn one_interval_has_nothing_to_vary_at_degree_one() {
    let system = EulerLagrange::new(FreeFall);
    let action = Action::new(&system, 0.0, 1.0, 1, Galerkin::MIDPOINT).unwrap();
    let found = action.stationary(&action.straight(&[0.0], &[2.0]), &Search::default()).unwrap();
    assert_eq!(found.action, 2.0 - 9.81);
    assert_eq!(found.extremum(), Extremum::Minimum);
}

/// Small motions about rest, with any M, K and magnetic (gyroscopic) term B.
struct Small<const N: usize> {
    mass: [[f64; N]; N],
    stiffness: [[f64; N]; N],
    magnetic: [[f64; N]; N],
}

impl<const N: usize> Lagrangian<N> for Small<N> {
    fn kinetic<S: Scalar>(&self, q: &[S; N], v: &[S; N], _t: S) -> S {
        let mut sum = S::constant(0.0);
        for i in 0..N {
            for j in 0..N {
                sum += (v[i] * v[j]).scale(0.5 * self.mass[i][j]) + (q[i] * v[j]).scale(self.magnetic[i][j]);
            }
        }
        sum
    }
    fn potential<S: Scalar>(&self, q: &[S; N], _t: S) -> S {
        let mut sum = S::constant(0.0);
        for i in 0..N {
            for j in 0..N {
                sum += (q[i] * q[j]).scale(0.5 * self.stiffness[i][j]);
            }
        }
        sum
    }
}

/// Conjugate points of random linear systems: sign changes of det J(t), J the Jacobi fields that leave zero.
fn check_random_index<const N: usize>(seed: u64) -> Option<usize> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut symmetric = |shift: f64, scale: f64| {
        let mut out = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..=i {
                let entry = scale * next() + if i == j { shift } else { 0.0 };
                (out[i][j], out[j][i]) = (entry, entry);
            }
        }
        out
    };
    let (mass, stiffness, mut magnetic) = (symmetric(2.0, 0.5), symmetric(3.0, 4.0), symmetric(0.0, 1.0));
    for i in 0..N {
        for j in 0..i {
            magnetic[i][j] = -magnetic[j][i];
        }
    }
    let system = EulerLagrange::new(Small { mass, stiffness, magnetic });
    let time = 6.0;
    let times: Vec<f64> = (0..=600).map(|k| time * f64::from(k) / 600.0).collect();
    let fields: Vec<Vec<[f64; N]>> = (0..N)
        .map(|j| motion(&system, [0.0; N], std::array::from_fn(|i| f64::from(u8::from(i == j))), &times))
        .collect();
    let determinant = |k: usize| DMatrix::from_fn(N, N, |i, j| fields[j][k][i]).determinant();
    let values: Vec<f64> = (1..times.len()).map(determinant).collect();
    let largest = values.iter().fold(0.0f64, |m, d| m.max(d.abs()));
    // Near-double zeros between two samples, and ends near a conjugate point, cannot be judged by signs.
    let grazes = values.windows(3).any(|d| {
        d[1].abs() < d[0].abs() && d[1].abs() < d[2].abs() && d[0] * d[2] > 0.0 && d[1].abs() < 1e-3 * largest
    });
    if grazes || values[values.len() - 1].abs() < 1e-3 * largest {
        return None;
    }
    let expected = values.windows(2).filter(|d| d[0] * d[1] < 0.0).count();
    let action = Action::new(&system, 0.0, time, 60, Galerkin { degree: 3 }).unwrap();
    let found = action.stationary(&action.straight(&[0.3; N], &[-0.2; N]), &Search::default()).unwrap();
    assert_eq!(found.index(), expected, "{N} coordinates, seed {seed}");
    Some(expected)
}

#[test]
fn index_of_random_problems_counts_the_zeros_of_their_jacobi_determinants() {
    let found: Vec<usize> = (1..=12)
        .flat_map(|seed| {
            [check_random_index::<1>(seed), check_random_index::<2>(seed), check_random_index::<3>(seed)]
        })
        .flatten()
        .collect();
    println!("{found:?}");
    assert!(found.len() >= 24 && found.contains(&0) && found.iter().any(|&index| index >= 5), "{found:?}");
}
