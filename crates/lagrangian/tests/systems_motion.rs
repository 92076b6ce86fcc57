//! Every worked system with a trajectory of 32 digits, integrated to its time stamps by several methods, and compared there.
//!
//! Errors are relative: the largest of any coordinate or velocity over all stamps, in units of the largest that this coordinate or
//! velocity takes. A regular motion must be right to 1e-12. A sensitive one multiplies what rounding does in its first step by
//! the file's `perturbation_growth_to_T`, and is judged against that.

#![allow(clippy::unwrap_used)]

#[path = "fixture/reader.rs"]
mod fixture;

use fixture::{Fixture, Sample, distance, number, numbers, size};
use lagrangian::constraint::{Composition, Constrained, Constraints, Holonomic, Rattle};
use lagrangian::integrator::{
    Bdf2, DiscreteEulerLagrange, DormandPrince853, GaussLegendre, ImplicitEuler, Integrator, RungeKutta4,
    Tolerance, drive,
};
use lagrangian::systems::*;
use lagrangian::{Coordinates, EulerLagrange, Lagrangian, Phase, SlicedEulerLagrange, System};

/// What a method may err by.
#[derive(Clone, Copy, Debug)]
enum Bound {
    /// Relative, on a regular motion.
    Relative(f64),
    /// So many times 1e-16 × growth, absolute, on a sensitive one.
    Growth(f64),
}

/// The largest error over all samples: of any coordinate or velocity relative to the largest of its own, and absolute.
fn errors<C: Coordinates>(states: impl Iterator<Item = Phase<C>>, samples: &[Sample]) -> [f64; 2] {
    let states: Vec<_> = states.collect();
    assert_eq!(states.len(), samples.len());
    let mut worst = [0.0f64; 2];
    let largest = |pick: fn(&Sample) -> &[f64], i: usize| {
        samples.iter().map(|s| pick(s)[i].abs()).fold(f64::MIN_POSITIVE, f64::max)
    };
    for i in 0..samples[0].q.len() {
        let scales = [largest(|s| &s.q, i), largest(|s| &s.v, i)];
        for (state, sample) in states.iter().zip(samples) {
            assert_eq!(state.time, sample.t);
            let q = (state.q.as_ref()[i] - sample.q[i]).abs();
            let v = (state.v.as_ref()[i] - sample.v[i]).abs();
            worst = [worst[0].max(q / scales[0]).max(v / scales[1]), worst[1].max(q).max(v)];
        }
    }
    worst
}

fn judge(name: &str, method: &str, [relative, absolute]: [f64; 2], growth: Option<f64>, bound: Bound) {
    match bound {
        Bound::Relative(bound) => {
            assert!(relative <= bound, "{name}, {method}: error {relative:.2e}, at most {bound:e}");
        }
        Bound::Growth(factor) => {
            let bound = factor * 1e-16 * growth.expect("a sensitive motion");
            assert!(absolute <= bound, "{name}, {method}: error {absolute:.2e}, at most {bound:.2e}");
        }
    }
}

/// DOP853 with a tolerance near rounding, and Gauss–Legendre of order 12 and 8 with the step sizes `h` and `h`/5.
fn compare<S: System>(fixture: &Fixture, system: &S, start: &Phase<S::Coordinates>, h: f64, bound: Bound) {
    let samples = fixture.samples();
    let times: Vec<f64> = samples.iter().map(|s| s.t).collect();

    let mut adaptive = DormandPrince853::new(system).with_tolerance(Tolerance::uniform(3e-16)).unwrap();
    let (states, _) = adaptive.sample(system, &mut start.clone(), &times).unwrap();
    judge(fixture.name(), "DOP853", errors(states.phases(), &samples), fixture.growth(), bound);

    let mut gauss = GaussLegendre::<6, _>::new();
    let (states, _) = drive::sample(system, &mut gauss, &mut start.clone(), &times, h).unwrap();
    judge(fixture.name(), "Gauss–Legendre 12", errors(states.phases(), &samples), fixture.growth(), bound);

    let mut gauss = GaussLegendre::<4, _>::new();
    let (states, _) = drive::sample(system, &mut gauss, &mut start.clone(), &times, h / 5.0).unwrap();
    judge(fixture.name(), "Gauss–Legendre 8", errors(states.phases(), &samples), fixture.growth(), bound);
}

fn check<const N: usize>(name: &str, lagrangian: impl Lagrangian<N>, h: f64, bound: Bound) {
    let fixture = Fixture::read(name);
    compare(&fixture, &EulerLagrange::new(lagrangian), &fixture.start::<N>(), h, bound);
}

const REGULAR: Bound = Bound::Relative(1e-12);

#[test]
fn pendulums() {
    let pendulum = Pendulum::new(1.0, 1.0, 9.81).unwrap();
    for name in ["pendulum_large", "pendulum_1rad", "pendulum_rotating"] {
        check(name, pendulum, 0.05, REGULAR);
    }
    check("spherical_pendulum", SphericalPendulum::new(1.0, 1.0, 9.81).unwrap(), 0.03, REGULAR);
    check("spring_pendulum", SpringPendulum::new(1.0, 40.0, 1.0, 9.81).unwrap(), 0.04, REGULAR);
    let regular = DoublePendulum::new([2.0, 1.0], [1.0, 0.5], 9.81).unwrap();
    check("double_pendulum_regular", regular, 0.025, REGULAR);
}

#[test]
fn orbits() {
    let kepler = Kepler::new(1.0, 1.0).unwrap();
    check("kepler_e06", kepler, 0.04, REGULAR);
    check("kepler_e09", kepler, 0.006, REGULAR);
    check("henon_heiles_regular", HenonHeiles, 0.2, REGULAR);
}

#[test]
fn tops() {
    let top = HeavyTop::new(0.25, 0.125, 1.0, 0.5, 9.81).unwrap();
    check("top_nutating", top, 0.02, REGULAR);
    // Near the vertical φ̇ = (p_φ − p_ψ cos θ)/(I₁ sin²θ) is a difference of numbers 1/θ² = 1e4 larger than itself: that many roundings
    // remain in whatever steps in momenta.
    check("top_sleeping_stable", top, 0.01, Bound::Relative(1e-10));
    check("top_sleeping_unstable", top, 0.01, Bound::Relative(1e-10));
}

#[test]
fn guided_beads() {
    let hoop = |rate| BeadOnHoop::new(1.0, 1.0, 9.81, rate).unwrap();
    check("hoop_subcritical", hoop(2.5), 0.1, REGULAR);
    check("hoop_supercritical", hoop(5.0), 0.05, REGULAR);
    let wire = BeadOnWire::new(1.0, 9.81, Parabola { curvature: 1.0 }).unwrap();
    check("bead_parabola", wire, 0.04, REGULAR);
}

#[test]
fn sensitive_motions() {
    let bound = Bound::Growth(10.0);
    check("double_pendulum", DoublePendulum::new([1.0; 2], [1.0; 2], 9.81).unwrap(), 0.01, bound);
    check("triple_pendulum", TriplePendulum::new([1.0; 3], [1.0; 3], 9.81).unwrap(), 0.01, bound);
    check("duffing", Duffing::new(-1.0, 1.0, 0.3, 0.5, 1.2).unwrap(), 0.1, bound);
}

/// Any number of links, on the trajectory of three.
#[test]
fn a_chain_of_pendulums() {
    let fixture = Fixture::read("triple_pendulum");
    let system = SlicedEulerLagrange::new(PendulumChain::uniform(3, 1.0, 1.0, 9.81).unwrap());
    let Phase { q, v, .. } = fixture.start::<3>();
    compare(&fixture, &system, &Phase::new(0.0, q.to_vec(), v.to_vec()), 0.01, Bound::Growth(10.0));
}

/// Twenty masses to t = 1000, against the exact modes.
#[test]
fn a_chain_of_springs() {
    let fixture = Fixture::read("chain20");
    let (m, k) = (fixture.number("m"), fixture.number("k"));
    let system = SlicedEulerLagrange::new(SpringChain::uniform(20, m, k).unwrap());
    let [q, v] = ["q0", "qdot0"].map(|key| numbers(&fixture.content()[key]));
    let samples = fixture.samples();
    let times: Vec<f64> = samples.iter().map(|s| s.t).collect();
    let mut gauss = GaussLegendre::<8, _>::new();
    let (states, _) = drive::sample(&system, &mut gauss, &mut Phase::new(0.0, q, v), &times, 0.25).unwrap();
    judge("chain20", "Gauss–Legendre 16", errors(states.phases(), &samples), None, REGULAR);
}

/// The body that flips about its middle axis: quaternion, angular velocity and angular momentum at every stamp, and |q| = 1 throughout.
#[test]
fn the_flipping_body() {
    let fixture = Fixture::read("dzhanibekov");
    let body = FreeBody::new(numbers(&fixture.content()["I"]).try_into().unwrap()).unwrap();
    let system = EulerLagrange::new(body);
    let exact: Vec<([f64; 4], [f64; 3])> = fixture
        .raw_samples()
        .iter()
        .map(|s| {
            (numbers(&s["quat_wxyz"]).try_into().unwrap(), numbers(&s["omega_body"]).try_into().unwrap())
        })
        .collect();
    let times: Vec<f64> = fixture.raw_samples().iter().map(|s| number(&s["t"])).collect();
    let start = Phase::new(0.0, exact[0].0, FreeBody::rate(&exact[0].0, &exact[0].1));
    let space = numbers(&fixture.raw_samples()[0]["L_space"]);

    // The body passes the middle axis, from which no flip would start, at the relative distance (L² − 2E I₂)/L² = 1.25e-7 of the conserved
    // quantities. What a method loses of these counts 8e6 times in the time of the next flip. Gauss–Legendre loses some roundings;
    // DOP853 its tolerance a step, as a random walk of some 2000 steps.
    let walk = 2000.0f64.sqrt() * 3e-16;
    let losses = [walk, 10.0 * 1e-16];

    let mut adaptive = DormandPrince853::new(&system).with_tolerance(Tolerance::uniform(3e-16)).unwrap();
    let (explicit, _) = adaptive.sample(&system, &mut start.clone(), &times).unwrap();
    let mut gauss = GaussLegendre::<6, _>::new();
    let (implicit, _) = drive::sample(&system, &mut gauss, &mut start.clone(), &times, 0.05).unwrap();
    for ((name, states), loss) in
        [("DOP853", explicit), ("Gauss–Legendre 12", implicit)].into_iter().zip(losses)
    {
        let bound = loss / 1.25e-7;
        for (state, (q, omega)) in states.phases().zip(&exact) {
            let t = state.time;
            let found = FreeBody::angular_velocity(&state.q, &state.v);
            let error = distance(&state.q, q).max(distance(&found, omega) / 2.0);
            assert!(error <= bound, "{name}, t = {t}: {error:.2e}, at most {bound:.2e}");
            let length: f64 = state.q.iter().map(|x| x * x).sum::<f64>().sqrt();
            // r̈ = 0: what the same random walk leaves of ṙ adds up in proportion to time.
            let drift = 1e-14 + walk * t;
            assert!((length - 1.0).abs() <= drift, "{name}, t = {t}: |q| − 1 = {:.2e}", length - 1.0);
            let momentum = body.angular_momentum(&state.q, &state.v);
            assert!(distance(&momentum, &space) <= 1e-12 * size(&space), "{name}, t = {t}: L = {momentum:?}");
        }
    }
}

/// Hundreds and thousands of turns, against Kepler's equation. The period depends on the start, dn/n = 3 a dr/r², so a rounding of the
/// perihelion's distance r = 1 − e alone is a phase error of 3 ε t/(1 − e)², at the speed √((1 + e)/(1 − e)) there. Every step rounds again;
/// the bound allows for the sum of independent roundings, the root of the number of steps (Brouwer's law), a quarter of one each.
#[test]
fn many_turns_of_keplers_orbits() {
    let kepler = Kepler::new(1.0, 1.0).unwrap();
    let system = EulerLagrange::new(kepler);
    for (name, last, h) in [("kepler_e06_long", 10_000.0, 0.04), ("kepler_e09_long", 1_000.0, 0.006)] {
        let fixture = Fixture::read(name);
        let e = fixture.number("e");
        let growth = 3.0 / (1.0 - e).powi(2) * ((1.0 + e) / (1.0 - e)).sqrt();
        let start = fixture.start::<2>();
        let mut phase = start.clone();
        let mut gauss = GaussLegendre::<6, _>::new();
        for sample in fixture.samples().iter().filter(|s| s.t <= last) {
            drive::integrate(&system, &mut gauss, &mut phase, sample.t, h).unwrap();
            let error = distance(&phase.q, &sample.q);
            let bound = 1e-16 * growth * sample.t * (1.0 + 0.25 * (sample.t / h).sqrt());
            assert!(error <= bound, "{name}, t = {}: {error:.2e}, at most {bound:.2e}", sample.t);
        }
        let momentum = kepler.angular_momentum(&phase.q, &phase.v);
        let drift = momentum / kepler.angular_momentum(&start.q, &start.v) - 1.0;
        assert!(drift.abs() <= 1e-12, "{name}: angular momentum drifts by {drift:e}");
    }
}

/// A system in Cartesian coordinates on its constraint: positions, velocities and multiplier at every stamp by RATTLE of order 8, the constraint
/// to rounding.
fn check_constrained<H>(fixture: &str, holonomic: H, multiplier: &str, h: f64)
where
    H: Lagrangian<2> + Holonomic<2, 1> + Clone,
{
    let fixture = Fixture::read(fixture);
    let system = EulerLagrange::new(holonomic.clone());
    let constraints = Constraints::new(holonomic);
    let state = |s: &serde_json::Value| {
        let [x, y, vx, vy] = ["x", "y", "vx", "vy"].map(|key| number(&s[key]));
        Phase::new(number(&s["t"]), [x, y], [vx, vy])
    };
    let mut phase = state(&fixture.raw_samples()[0]);
    let mut rattle = Rattle::composed(constraints.clone(), Composition::Eighth);
    for sample in fixture.raw_samples() {
        drive::integrate(&system, &mut rattle, &mut phase, number(&sample["t"]), h).unwrap();
        let (exact, t) = (state(sample), phase.time);
        let error = distance(&phase.q, &exact.q).max(distance(&phase.v, &exact.v) / 5.0);
        assert!(error <= 1e-12, "{}, t = {t}: {error:.2e}", fixture.name());
        let motion = Constrained::new(&system, &constraints).motion(&phase).unwrap();
        let lambda = number(&sample[multiplier]);
        assert!((motion.multipliers[0] - lambda).abs() <= 2e-11 * lambda.abs().max(10.0), "{motion:?}");
    }
}

#[test]
fn on_constraints() {
    let pendulum = CartesianPendulum::new(1.0, 1.0, 9.81).unwrap();
    check_constrained("pendulum_cartesian", pendulum, "lambda_phi_half_r2", 0.01);
    let bead = CartesianBead::new(1.0, 9.81, Parabola { curvature: 1.0 }).unwrap();
    check_constrained("bead_parabola_cartesian", bead, "lam", 0.01);
}

/// The error at the first stamp after `steps` steps.
fn error_after<S: System>(
    system: &S,
    mut integrator: impl Integrator<S>,
    start: &Phase<S::Coordinates>,
    sample: &Sample,
    steps: u32,
) -> f64 {
    let mut phase = start.clone();
    drive::integrate(system, &mut integrator, &mut phase, sample.t, sample.t / f64::from(steps)).unwrap();
    distance(phase.q.as_ref(), &sample.q).max(distance(phase.v.as_ref(), &sample.v))
}

/// The errors of the methods of low order fall with their order, on this system up to the first stamp.
fn check_orders<const N: usize>(name: &str, lagrangian: impl Lagrangian<N>, steps: u32) {
    let fixture = Fixture::read(name);
    let system = EulerLagrange::new(lagrangian);
    let (start, sample) = (fixture.start::<N>(), &fixture.samples()[1]);
    let observed = |error: &dyn Fn(u32) -> f64| (error(steps) / error(2 * steps)).log2();
    let orders = [
        (1.0, observed(&|n| error_after(&system, ImplicitEuler::new(), &start, sample, 8 * n))),
        (2.0, observed(&|n| error_after(&system, Bdf2::new(), &start, sample, 4 * n))),
        (2.0, observed(&|n| error_after(&system, DiscreteEulerLagrange::midpoint(), &start, sample, n))),
        (2.0, observed(&|n| error_after(&system, DiscreteEulerLagrange::trapezoidal(), &start, sample, n))),
        (4.0, observed(&|n| error_after(&system, RungeKutta4::new(&system), &start, sample, n))),
        (4.0, observed(&|n| error_after(&system, GaussLegendre::<2, _>::new(), &start, sample, n))),
    ];
    for (stated, observed) in orders {
        assert!(
            (observed - stated).abs() <= 0.15,
            "{name}: order {observed:.3} instead of {stated}; all: {orders:.2?}"
        );
    }
}

#[test]
fn orders() {
    check_orders("pendulum_large", Pendulum::new(1.0, 1.0, 9.81).unwrap(), 200);
    check_orders("double_pendulum", DoublePendulum::new([1.0; 2], [1.0; 2], 9.81).unwrap(), 200);
    check_orders("triple_pendulum", TriplePendulum::new([1.0; 3], [1.0; 3], 9.81).unwrap(), 200);
    check_orders("spherical_pendulum", SphericalPendulum::new(1.0, 1.0, 9.81).unwrap(), 200);
    check_orders("spring_pendulum", SpringPendulum::new(1.0, 40.0, 1.0, 9.81).unwrap(), 200);
    check_orders("kepler_e06", Kepler::new(1.0, 1.0).unwrap(), 400);
    check_orders("henon_heiles_regular", HenonHeiles, 200);
    check_orders("top_nutating", HeavyTop::new(0.25, 0.125, 1.0, 0.5, 9.81).unwrap(), 200);
    check_orders("hoop_supercritical", BeadOnHoop::new(1.0, 1.0, 9.81, 5.0).unwrap(), 200);
    check_orders("bead_parabola", BeadOnWire::new(1.0, 9.81, Parabola { curvature: 1.0 }).unwrap(), 200);
    check_orders("duffing", Duffing::new(-1.0, 1.0, 0.3, 0.5, 1.2).unwrap(), 200);
}
