//! Orders at the time stamps of the fixtures.

use crate::fixture::{largest_gap, number, orders, samples};
use crate::systems::*;
use lagrangian::constraint::{Composition, Constrained, ConstraintSet, Constraints, Rattle};
use lagrangian::integrator::Integrator;
use lagrangian::{EulerLagrange, Phase, System};
use serde_json::Value;

const PENDULUM: &str = include_str!("../fixtures/pendulum_cartesian.json");
const BEAD: &str = include_str!("../fixtures/bead_parabola_cartesian.json");

fn cartesian(sample: &Value) -> ([f64; 2], [f64; 2]) {
    ([number(&sample["x"]), number(&sample["y"])], [number(&sample["vx"]), number(&sample["vy"])])
}

/// Largest errors of q, v and the pointwise λ over the samples of the first `seconds`, with 1/h = `rate`.
fn errors<S, C>(
    system: &S,
    rattle: &mut Rattle<C>,
    (samples, lambda): (&[Value], &str),
    rate: usize,
) -> [f64; 3]
where
    S: System<Coordinates = [f64; 2]>,
    C: ConstraintSet<Coordinates = [f64; 2], Multipliers = [f64; 1]> + Clone,
{
    let constraints = rattle.constraints().clone();
    let (q, v) = cartesian(&samples[0]);
    let mut phase = Phase::new(0.0, q, v);
    let mut worst = [0.0f64; 3];
    let h = 1.0 / rate as f64;
    for sample in &samples[1..] {
        while phase.time < number(&sample["t"]) - 0.5 * h {
            rattle.step(system, &mut phase, h).unwrap();
        }
        let (q, v) = cartesian(sample);
        let motion = Constrained::new(system, &constraints).motion(&phase).unwrap();
        worst[0] = worst[0].max(largest_gap(&phase.q, &q));
        worst[1] = worst[1].max(largest_gap(&phase.v, &v));
        worst[2] = worst[2].max((motion.multipliers[0] - number(&sample[lambda])).abs());
    }
    worst
}

fn assert_orders<S, C>(
    system: &S,
    constraints: &C,
    (composition, rates, tolerance): (Composition, &[usize], f64),
    fixture: (&[Value], &str),
) where
    S: System<Coordinates = [f64; 2]>,
    C: ConstraintSet<Coordinates = [f64; 2], Multipliers = [f64; 1]> + Clone,
{
    let runs: Vec<[f64; 3]> = rates
        .iter()
        .map(|&rate| errors(system, &mut Rattle::composed(constraints.clone(), composition), fixture, rate))
        .collect();
    for (what, name) in ["q", "v", "λ"].iter().enumerate() {
        let errors: Vec<f64> = runs.iter().map(|run| run[what]).collect();
        for order in orders(&errors) {
            let expected = f64::from(composition.order());
            assert!(
                (order - expected).abs() < tolerance,
                "{composition:?} {name}: {errors:?} {:?}",
                orders(&errors)
            );
        }
    }
}

#[test]
fn pendulum_and_bead_have_order_two() {
    let system = EulerLagrange::new(Particle);
    let pendulum = samples(PENDULUM);
    let rates: &[usize] = &[400, 800, 1600];
    let plan = (Composition::Second, rates, 0.15);
    assert_orders(&system, &rod(), plan, (&pendulum[..6], "lambda_phi_half_r2"));
    assert_orders(&system, &Constraints::new(Parabola), plan, (&samples(BEAD), "lam"));
}

#[test]
fn compositions_have_their_orders() {
    let system = EulerLagrange::new(Particle);
    let bead = samples(BEAD);
    let constraints = Constraints::new(Parabola);
    let cases: [(Composition, &[usize], f64); 3] = [
        (Composition::Fourth, &[80, 160, 320], 0.05),
        (Composition::Sixth, &[40, 80], 0.05),
        (Composition::Eighth, &[24, 48], 0.1),
    ];
    for case in cases {
        assert_orders(&system, &constraints, case, (&bead, "lam"));
    }
}

/// λ⁺, λ⁻ and their mean for the step that starts at t = 1 s: against λ at 1 s, and the mean against λ in the middle.
fn multiplier_errors(rate: usize) -> [f64; 3] {
    let system = EulerLagrange::new(Particle);
    let bead = samples(BEAD);
    let exact = number(&bead[1]["lam"]);
    let (q, v) = cartesian(&bead[0]);
    let run = |h: f64, steps: usize| {
        let mut rattle = Rattle::new(Constraints::new(Parabola));
        let mut phase = Phase::new(0.0, q, v);
        for _ in 0..steps {
            rattle.step(&system, &mut phase, h).unwrap();
        }
        rattle.reaction().unwrap().clone()
    };
    let h = 1.0 / rate as f64;
    let (before, after) = (run(h, rate), run(h, rate + 1));
    // Of a step whose middle is at 1 s.
    let around = run(1.0 / (rate as f64 + 0.5), rate + 1);
    [after.first[0] - exact, before.last[0] - exact, around.mean[0] - exact]
}

#[test]
fn multipliers_of_a_step_have_order_one_with_opposite_errors_and_their_mean_has_order_two() {
    let runs: Vec<[f64; 3]> = [400, 800, 1600].map(multiplier_errors).to_vec();
    for (what, expected) in [1.0, 1.0, 2.0].into_iter().enumerate() {
        let errors: Vec<f64> = runs.iter().map(|run| run[what].abs()).collect();
        for order in orders(&errors) {
            assert!((order - expected).abs() < 0.15, "{what}: {errors:?} {:?}", orders(&errors));
        }
    }
    let [first, last, _] = runs[2];
    assert!((first + last).abs() < 0.02 * first.abs(), "{first:e} {last:e}");
}

/// ∫₀¹ λ dt of the bead, λ = (v_x² + g)/(1 + x²) along x(t) by Runge–Kutta in x alone.
fn exact_impulse() -> f64 {
    // y = x²/2: (1 + x²) ẍ = −x (ẋ² + g), and m ẍ = −λ x.
    let rate = |[x, v, _]: [f64; 3]| {
        let lambda = (v * v + G) / (1.0 + x * x);
        [v, -x * lambda, lambda]
    };
    let ahead = |s: [f64; 3], k: [f64; 3], h: f64| std::array::from_fn(|i| s[i] + h * k[i]);
    let (mut s, h) = ([1.5, 0.0, 0.0], 1.0 / 8192.0);
    for _ in 0..8192 {
        let a = rate(s);
        let b = rate(ahead(s, a, 0.5 * h));
        let c = rate(ahead(s, b, 0.5 * h));
        let d = rate(ahead(s, c, h));
        s = std::array::from_fn(|i| s[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    s[2]
}

#[test]
fn summed_mean_reactions_give_the_impulse_to_the_methods_order() {
    let system = EulerLagrange::new(Particle);
    let exact = exact_impulse();
    let error = |composition, steps: usize| {
        let mut rattle = Rattle::composed(Constraints::new(Parabola), composition);
        let mut phase = Phase::new(0.0, [1.5, 1.125], [0.0, 0.0]);
        let h = 1.0 / steps as f64;
        let mut impulse = 0.0;
        for _ in 0..steps {
            rattle.step(&system, &mut phase, h).unwrap();
            impulse += h * rattle.reaction().unwrap().mean[0];
        }
        (impulse - exact).abs()
    };
    for (composition, rates, tolerance) in [
        (Composition::Second, [200, 400], 0.15),
        (Composition::Fourth, [40, 80], 0.2),
        (Composition::Sixth, [20, 40], 0.5),
    ] {
        let errors = rates.map(|rate| error(composition, rate));
        let order = orders(&errors)[0];
        assert!(
            (order - f64::from(composition.order())).abs() < tolerance,
            "{composition:?} {errors:?} {order}"
        );
    }
}

/// The parabola of the fixture in polar coordinates: the general form of the step.
fn polar_errors(composition: Composition, rate: usize) -> f64 {
    let system = EulerLagrange::new(Polar);
    let mut rattle = Rattle::composed(Constraints::new(PolarParabola), composition);
    let bead = samples(BEAD);
    let mut phase = Phase::new(0.0, polar_start(), [0.0, 0.0]);
    for _ in 0..rate {
        rattle.step(&system, &mut phase, 1.0 / rate as f64).unwrap();
    }
    let ([r, theta], [dr, dtheta]) = (phase.q, phase.v);
    let (s, c) = theta.sin_cos();
    let (q, v) = ([r * s, 1.0 - r * c], [dr * s + r * c * dtheta, -dr * c + r * s * dtheta]);
    let exact = cartesian(&bead[1]);
    largest_gap(&q, &exact.0).max(largest_gap(&v, &exact.1))
}

#[test]
fn the_general_form_has_its_order_where_masses_depend_on_coordinates() {
    for (composition, rates, tolerance) in [
        (Composition::Second, [200, 400], 0.15),
        (Composition::Fourth, [80, 160], 0.2),
        (Composition::Sixth, [40, 80], 0.5),
    ] {
        let errors = rates.map(|rate| polar_errors(composition, rate));
        let order = orders(&errors)[0];
        assert!(
            (order - f64::from(composition.order())).abs() < tolerance,
            "{composition:?} {errors:?} {order}"
        );
    }
}

/// θ̈ = −g sin θ − c θ̇ − ẍ_p cos θ by Runge–Kutta, to 1e-13.
fn angle(theta: f64, damping: f64, pivot: ShakenRod, seconds: f64) -> [f64; 2] {
    let rate = |[theta, omega]: [f64; 2], t: f64| {
        let push = -pivot.amplitude * pivot.frequency.powi(2) * (pivot.frequency * t).sin();
        [omega, -G * theta.sin() - damping * omega - push * theta.cos()]
    };
    let (steps, mut s) = (8192, [theta, 0.0]);
    let h = seconds / f64::from(steps);
    let ahead = |s: [f64; 2], k: [f64; 2], h: f64| [s[0] + h * k[0], s[1] + h * k[1]];
    for n in 0..steps {
        let t = f64::from(n) * h;
        let a = rate(s, t);
        let b = rate(ahead(s, a, 0.5 * h), t + 0.5 * h);
        let c = rate(ahead(s, b, 0.5 * h), t + 0.5 * h);
        let d = rate(ahead(s, c, h), t + h);
        s = std::array::from_fn(|i| s[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    s
}

#[test]
fn a_damped_pendulum_follows_its_angle() {
    let system = EulerLagrange::new(Damped { damping: 0.7 });
    let [theta, _] = angle(1.0, 0.7, ShakenRod { amplitude: 0.0, frequency: 0.0 }, 2.0);
    let error = |steps: usize| {
        let mut rattle = Rattle::new(rod());
        let mut phase = Phase::new(0.0, [1f64.sin(), -1f64.cos()], [0.0, 0.0]);
        for _ in 0..steps {
            rattle.step(&system, &mut phase, 2.0 / steps as f64).unwrap();
        }
        (phase.q[0] - theta.sin()).abs()
    };
    let errors = [error(400), error(800)];
    assert!((orders(&errors)[0] - 2.0).abs() < 0.15, "{errors:?}");
}

#[test]
fn a_pendulum_with_a_shaken_pivot_follows_its_angle() {
    let system = EulerLagrange::new(Particle);
    let pivot = ShakenRod { amplitude: 0.3, frequency: 2.0 };
    let [theta, omega] = angle(1.0, 0.0, pivot, 2.0);
    let (x, dx) = (0.3 * 4f64.sin(), 0.6 * 4f64.cos());
    let exact = [x + theta.sin(), -theta.cos(), dx + theta.cos() * omega, theta.sin() * omega];
    let error = |composition, steps: usize| {
        let mut rattle = Rattle::composed(Constraints::new(pivot), composition);
        // The pivot starts with velocity 0.6 m/s and the rod does not turn: the bob moves along.
        let mut phase = Phase::new(0.0, [1f64.sin(), -1f64.cos()], [0.6, 0.0]);
        for _ in 0..steps {
            rattle.step(&system, &mut phase, 2.0 / steps as f64).unwrap();
        }
        let Phase { q, v, .. } = phase;
        largest_gap(&[q[0], q[1], v[0], v[1]], &exact)
    };
    let errors = [error(Composition::Second, 400), error(Composition::Second, 800)];
    assert!((orders(&errors)[0] - 2.0).abs() < 0.15, "{errors:?}");
    let errors = [error(Composition::Fourth, 80), error(Composition::Fourth, 160)];
    assert!((orders(&errors)[0] - 4.0).abs() < 0.3, "{errors:?}");
}

#[test]
fn a_step_back_returns_to_the_start() {
    fn there_and_back<S, C>(system: &S, constraints: C, start: &Phase<[f64; 2]>) -> f64
    where
        S: System<Coordinates = [f64; 2]>,
        C: ConstraintSet<Coordinates = [f64; 2]> + Clone,
    {
        let mut phase = start.clone();
        for _ in 0..2 {
            let mut rattle = Rattle::new(constraints.clone());
            for _ in 0..50 {
                rattle.step(system, &mut phase, 0.02).unwrap();
            }
            phase = Phase::new(0.0, phase.q, phase.v.map(|v| -v));
        }
        largest_gap(&phase.q, &start.q).max(largest_gap(&phase.v, &start.v))
    }
    let start = Phase::new(0.0, [1.5, 1.125], [0.0, 0.0]);
    let gap = there_and_back(&EulerLagrange::new(Particle), Constraints::new(Parabola), &start);
    assert!(gap < 1e-12, "{gap:e}");
    let start = Phase::new(0.0, polar_start(), [0.0, 0.0]);
    let gap = there_and_back(&EulerLagrange::new(Polar), Constraints::new(PolarParabola), &start);
    assert!(gap < 1e-11, "{gap:e}");
}

/// The double pendulum of the fixture as two masses on two rods: the same motion as in the two angles.
#[test]
fn a_double_pendulum_of_rods_is_that_of_angles() {
    const DOUBLE: &str = include_str!("../fixtures/double_pendulum_regular.json");
    let all = samples(DOUBLE);
    let pair = |value: &Value| [number(&value[0]), number(&value[1])];
    let lengths = [1.0, 0.5];
    let start = (pair(&all[0]["q"]), pair(&all[0]["qdot"]));
    let sample = all.iter().find(|s| number(&s["t"]) >= 2.0).unwrap();
    let (end, seconds) = ((pair(&sample["q"]), pair(&sample["qdot"])), number(&sample["t"]));
    let error = |composition, steps: usize| {
        let system = EulerLagrange::new(TwoMasses([2.0, 1.0]));
        let mut rattle = Rattle::composed(Constraints::new(TwoRods(lengths)), composition);
        let mut phase =
            Phase::new(0.0, joints(start.0, lengths), joint_velocities(start.0, start.1, lengths));
        for _ in 0..steps {
            rattle.step(&system, &mut phase, seconds / steps as f64).unwrap();
        }
        let q = largest_gap(&phase.q, &joints(end.0, lengths));
        q.max(largest_gap(&phase.v, &joint_velocities(end.0, end.1, lengths)))
    };
    let errors = [500, 1000].map(|steps| error(Composition::Second, steps));
    assert!((orders(&errors)[0] - 2.0).abs() < 0.15, "{errors:?}");
    let best = error(Composition::Eighth, 400);
    assert!(best < 1e-11, "{best:e}");
}
