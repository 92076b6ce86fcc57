//! Errors at the fixtures' time stamps fall with the stated order, to round-off.

use crate::systems::{
    CHAOTIC, Duffing, HenonHeiles, Kepler, Pendulum, REGULAR, SphericalPendulum, SpringPendulum, Top, error,
    reference, run, system,
};
use lagrangian::integrator::{Bdf2, DiscreteEulerLagrange, GaussLegendre, ImplicitEuler, Integrator};
use lagrangian::{EulerLagrange, Lagrangian};

/// The errors at `sample` for three numbers of steps, each half as many again as the one before; asserts the order of
/// the last pair of errors that is clear of round-off.
fn check_order<const N: usize, L, I>(
    name: &str,
    lagrangian: &L,
    make: impl Fn() -> I,
    sample: usize,
    first: usize,
) where
    L: Lagrangian<N> + Clone,
    I: Integrator<EulerLagrange<L, N>>,
{
    let (reference, system) = (reference(name), system(lagrangian.clone()));
    let (end, exact) = reference.at(sample);
    let error_of = |steps: usize| {
        let mut integrator = make();
        error(&run(&system, &mut integrator, &reference.start::<N>(), end, steps), &exact)
    };
    let method = make().method();
    let tolerance = if method.order <= 4 { 0.15 } else { 0.5 };
    let steps = [4 * first, 6 * first, 9 * first].map(|steps| steps / 4);
    let errors = steps.map(error_of);
    let clear = errors.iter().rposition(|&e| e > 1e-13).unwrap_or(0);
    assert!(clear >= 1, "{name}, {}: {errors:?} start at round-off", method.name);
    let order =
        (errors[clear - 1] / errors[clear]).ln() / (steps[clear] as f64 / steps[clear - 1] as f64).ln();
    assert!(
        (order - f64::from(method.order)).abs() <= tolerance,
        "{name}, {}: order {order} of {errors:?}",
        method.name
    );
}

/// Second-order methods are asked at an early sample, where they are already asymptotic.
fn check_all<const N: usize, L: Lagrangian<N> + Clone>(
    name: &str,
    l: &L,
    early: usize,
    late: usize,
    steps: usize,
) {
    check_order(name, l, DiscreteEulerLagrange::midpoint, early, steps);
    check_order(name, l, DiscreteEulerLagrange::trapezoidal, early, steps);
    check_order(name, l, Bdf2::new, early, 4 * steps);
    check_order(name, l, ImplicitEuler::new, early, 16 * steps);
    check_order(name, l, GaussLegendre::<2, _>::new, late, 2 * steps);
    check_order(name, l, GaussLegendre::<3, _>::new, late, steps);
    check_order(name, l, GaussLegendre::<4, _>::new, late, 3 * steps / 4);
}

#[test]
fn pendulum_orders() {
    check_all("pendulum_1rad", &Pendulum, 2, 10, 200);
    check_all("pendulum_large", &Pendulum, 2, 10, 200);
    check_all("pendulum_rotating", &Pendulum, 2, 10, 200);
}

#[test]
fn double_pendulum_orders() {
    check_all("double_pendulum_regular", &REGULAR, 1, 5, 200);
    check_all("double_pendulum", &CHAOTIC, 1, 6, 200);
}

#[test]
fn kepler_orders() {
    check_all("kepler_e06", &Kepler, 1, 8, 300);
}

#[test]
fn spherical_and_spring_pendulum_orders() {
    check_all("spherical_pendulum", &SphericalPendulum, 1, 6, 200);
    check_all("spring_pendulum", &SpringPendulum, 1, 6, 200);
}

#[test]
fn henon_heiles_orders() {
    check_all("henon_heiles_regular", &HenonHeiles, 1, 10, 200);
}

#[test]
fn top_orders() {
    check_all("top_nutating", &Top, 1, 6, 100);
}

#[test]
fn forced_and_damped_orders() {
    check_all("duffing", &Duffing, 1, 6, 100);
}

/// The error of `S` stages at the last time stamp.
fn final_error<const S: usize, const N: usize, L: Lagrangian<N>>(name: &str, l: L, steps: usize) -> f64 {
    let reference = reference(name);
    let (end, exact) = reference.at(reference.samples.len() - 1);
    let mut gauss = GaussLegendre::<S, _>::new();
    error(&run(&system(l), &mut gauss, &reference.start::<N>(), end, steps), &exact)
}

/// The orders of five and six stages show only between large steps and round-off.
#[test]
fn gauss_ten_and_twelve_orders() {
    let check = |name: &str, steps: [usize; 2], errors: [f64; 2], order: f64| {
        let observed = (errors[0] / errors[1]).ln() / (steps[1] as f64 / steps[0] as f64).ln();
        assert!((observed - order).abs() <= 0.5, "{name}: order {observed} of {errors:?}");
    };
    let steps = [130, 190];
    let name = "henon_heiles_regular";
    check(name, steps, steps.map(|k| final_error::<5, 2, _>(name, HenonHeiles, k)), 10.0);
    check(name, steps, steps.map(|k| final_error::<6, 2, _>(name, HenonHeiles, k)), 12.0);
    let (name, steps) = ("top_nutating", [110, 130]);
    check(name, [110, 160], [110, 160].map(|k| final_error::<5, 3, _>(name, Top, k)), 10.0);
    check(name, steps, steps.map(|k| final_error::<6, 3, _>(name, Top, k)), 12.0);
    let (name, steps) = ("pendulum_1rad", [130, 190]);
    check(name, steps, steps.map(|k| final_error::<5, 1, _>(name, Pendulum, k)), 10.0);
}

/// The largest error of Gauss–Legendre 12 over all time stamps but the first.
fn gauss_twelve<const N: usize, L: Lagrangian<N> + Clone>(name: &str, lagrangian: &L, h: f64) -> f64 {
    let (reference, system) = (reference(name), system(lagrangian.clone()));
    let mut gauss = GaussLegendre::<6, _>::new();
    let mut phase = reference.start::<N>();
    let mut worst = 0.0_f64;
    for sample in 1..reference.samples.len() {
        let (end, exact) = reference.at(sample);
        let steps = ((end - reference.at(sample - 1).0) / h).round().max(1.0);
        let h = (end - reference.at(sample - 1).0) / steps;
        for _ in 0..steps as usize {
            gauss.step(&system, &mut phase, h).unwrap();
        }
        worst = worst.max(error(&phase, &exact));
    }
    worst
}

#[test]
fn gauss_twelve_reaches_rounding_on_regular_systems() {
    let check = |name: &str, error: f64, bar: f64| assert!(error <= bar, "{name}: {error:e} above {bar:e}");
    check("pendulum_1rad", gauss_twelve("pendulum_1rad", &Pendulum, 0.05), 1e-12);
    check("pendulum_large", gauss_twelve("pendulum_large", &Pendulum, 0.05), 1e-12);
    check("pendulum_rotating", gauss_twelve("pendulum_rotating", &Pendulum, 0.05), 1e-12);
    check("double_pendulum_regular", gauss_twelve("double_pendulum_regular", &REGULAR, 0.02), 1e-12);
    check("spherical_pendulum", gauss_twelve("spherical_pendulum", &SphericalPendulum, 0.02), 1e-12);
    check("spring_pendulum", gauss_twelve("spring_pendulum", &SpringPendulum, 0.02), 1e-12);
    check("henon_heiles_regular", gauss_twelve("henon_heiles_regular", &HenonHeiles, 0.2), 1e-12);
    check("top_nutating", gauss_twelve("top_nutating", &Top, 0.0125), 1e-12);
    check("kepler_e06", gauss_twelve("kepler_e06", &Kepler, 0.02), 1e-11);
}

/// Where nearby motions part, nothing better than ε times the growth of a perturbation can be asked for; ten of it are
/// allowed, for a rounding of about ε in every one of some thousand steps, all smaller than the first by then.
#[test]
fn gauss_twelve_is_as_good_as_a_sensitive_motion_lets_it() {
    let check = |name: &str, error: f64| {
        let bar = 10.0 * 1e-16 * reference(name).growth.unwrap();
        assert!(error <= bar, "{name}: {error:e} above {bar:e}");
    };
    check("double_pendulum", gauss_twelve("double_pendulum", &CHAOTIC, 0.005));
    check("duffing", gauss_twelve("duffing", &Duffing, 0.1));
}
