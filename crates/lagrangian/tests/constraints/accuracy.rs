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
        (Composition::Fourth, &[40, 80, 160], 0.2),
        (Composition::Sixth, &[40, 80], 0.5),
        (Composition::Eighth, &[20, 40], 0.7),
    ];
    for case in cases {
        assert_orders(&system, &constraints, case, (&bead, "lam"));
    }
}
