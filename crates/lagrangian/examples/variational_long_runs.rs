//! What long runs keep: the angular momentum and the energy of a Kepler orbit with e = 0.9, and the energy of a regular
//! double pendulum, by variational integrators; by Runge–Kutta of order 4, beside them, energy is lost for ever.
//!
//! ```text
//! cargo run -p lagrangian --example variational_long_runs              (50 orbits, 50,000 steps: a second)
//! cargo run --release -p lagrangian --example variational_long_runs -- 10000
//! ```
//!
//! Printed is the largest relative error up to a hundredth, a tenth and the whole of the run. What is bounded stays the
//! same from column to column; a drift grows tenfold, a random walk of rounding errors by √10 ≈ 3.2.

#![allow(clippy::print_stdout)]

use lagrangian::integrator::{DiscreteEulerLagrange, GaussLegendre, Integrator, RungeKutta4};
use lagrangian::systems::{DoublePendulum, Kepler};
use lagrangian::{EulerLagrange, LagrangianError, Phase, System};

type Orbit = EulerLagrange<Kepler, 2>;
type Pendulum = EulerLagrange<DoublePendulum, 2>;

/// The largest |I/I₀ − 1| up to a hundredth, a tenth and the whole of `blocks` blocks of `block` steps,
/// looked at after each block.
fn errors<S: System, I: Integrator<S>>(
    (system, integrator, h): (&S, &mut I, f64),
    phase: &mut Phase<S::Coordinates>,
    (blocks, block): (usize, usize),
    invariant: impl Fn(&Phase<S::Coordinates>) -> f64,
) -> Result<[f64; 3], LagrangianError> {
    let start = invariant(phase);
    let (mut worst, mut out) = (0.0f64, [0.0; 3]);
    for done in 1..=blocks {
        for _ in 0..block {
            integrator.step(system, phase, h)?;
        }
        worst = worst.max((invariant(phase) / start - 1.0).abs());
        for (out, part) in out.iter_mut().zip([100, 10, 1]) {
            if done <= blocks.div_ceil(part) {
                *out = worst;
            }
        }
    }
    Ok(out)
}

/// Angular momentum and energy after every turn of `steps` steps.
fn orbits(
    system: &Orbit,
    mut integrator: impl Integrator<Orbit>,
    (turns, steps): (usize, usize),
) -> Result<(), LagrangianError> {
    let kepler = &system.lagrangian;
    let h = std::f64::consts::TAU / steps as f64;
    let momentum = |at: &Phase<[f64; 2]>| kepler.angular_momentum(&at.q, &at.v);
    let energy = |at: &Phase<[f64; 2]>| system.energy(at.time, &at.q, &at.v);
    let name = integrator.method().name;
    let mut run = |quantity: &str, invariant: &dyn Fn(&Phase<[f64; 2]>) -> f64| {
        let mut phase = kepler.perihelion(1.0, 0.9);
        let [first, tenth, all] =
            errors((system, &mut integrator, h), &mut phase, (turns, steps), invariant)?;
        println!("  {name:36} {steps:>4} a turn  {quantity:16}  {first:8.1e}  {tenth:8.1e}  {all:8.1e}");
        Ok(())
    };
    run("angular momentum", &momentum)?;
    run("energy", &energy)
}

fn pendulum(
    system: &Pendulum,
    mut integrator: impl Integrator<Pendulum>,
    steps: usize,
) -> Result<(), LagrangianError> {
    let mut phase = Phase::new(0.0, [0.5, -0.25], [0.0, 0.5]);
    let energy = |at: &Phase<[f64; 2]>| system.energy(at.time, &at.q, &at.v);
    let [first, tenth, all] = errors((system, &mut integrator, 0.01), &mut phase, (steps, 1), energy)?;
    println!("  {:36}  {first:8.1e}  {tenth:8.1e}  {all:8.1e}", integrator.method().name);
    Ok(())
}

fn main() -> Result<(), LagrangianError> {
    let length = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(50);
    let system = EulerLagrange::new(Kepler::new(1.0, 1.0)?);
    println!(
        "Kepler's orbit, e = 0.9, {length} times round, looked at once a turn (1000 steps resolve it, 80 do not):"
    );
    orbits(&system, DiscreteEulerLagrange::midpoint(), (length, 500))?;
    orbits(&system, GaussLegendre::<2, _>::new(), (length, 200))?;
    orbits(&system, GaussLegendre::<6, _>::new(), (length, 80))?;
    orbits(&system, GaussLegendre::<6, _>::new(), (length, 1000))?;

    let system = EulerLagrange::new(DoublePendulum::new([2.0, 1.0], [1.0, 0.5], 9.81)?);
    println!("the double pendulum's energy over {} steps of 0.01 s:", 1000 * length);
    pendulum(&system, RungeKutta4::new(&system), 1000 * length)?;
    pendulum(&system, DiscreteEulerLagrange::midpoint(), 1000 * length)?;
    pendulum(&system, DiscreteEulerLagrange::trapezoidal(), 1000 * length)?;
    pendulum(&system, GaussLegendre::<2, _>::new(), 1000 * length)?;
    pendulum(&system, GaussLegendre::<6, _>::new(), 1000 * length)
}
