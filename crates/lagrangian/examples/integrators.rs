//! One motion, every integrator: the regular double pendulum to t = 20 s in 2000 steps, against an angle known to 32 digits.
//!
//! ```text
//! cargo run -p lagrangian --example integrators
//! ```
//!
//! Störmer–Verlet is in the list to show what it does with a mass matrix that depends on q: it refuses.

#![allow(clippy::print_stdout)]

use lagrangian::integrator::*;
use lagrangian::systems::DoublePendulum;
use lagrangian::{EulerLagrange, LagrangianError, Phase, System};

type Pendulum = EulerLagrange<DoublePendulum, 2>;

/// θ₁ and θ₂ \[rad\] after 20 s from (0.5, −0.25) with θ̇ = (0, 0.5) (`tests/fixtures/double_pendulum_regular.json`).
const EXACT: [f64; 2] = [0.491_554_111_274_494_435_675_86, -0.242_970_720_384_660_686_384_67];

fn show(system: &Pendulum, integrator: &mut dyn Integrator<Pendulum>) {
    let Method { name, order, structure, .. } = integrator.method();
    let mut phase = Phase::new(0.0, [0.5, -0.25], [0.0, 0.5]);
    let start = system.energy(0.0, &phase.q, &phase.v);
    match drive::integrate(system, integrator, &mut phase, 20.0, 0.01) {
        Ok(report) => {
            let error = (phase.q[0] - EXACT[0]).abs().max((phase.q[1] - EXACT[1]).abs());
            let energy = (system.energy(phase.time, &phase.q, &phase.v) - start) / start.abs();
            let work = format!("{} + {}", report.work.evaluations, report.work.curvatures);
            println!("{name:36} {order:>2}  {error:>9.1e}  {energy:>9.1e}  {work:>12}  {structure:?}");
        }
        Err(error) => println!("{name:36} {order:>2}  {error}"),
    }
}

fn main() -> Result<(), LagrangianError> {
    let system = EulerLagrange::new(DoublePendulum::new([2.0, 1.0], [1.0, 0.5], 9.81)?);
    println!("method                            order      error     energy   evaluations  keeps");
    show(&system, &mut ImplicitEuler::new());
    show(&system, &mut Bdf2::new());
    show(&system, &mut StormerVerlet::new(&system));
    show(&system, &mut DiscreteEulerLagrange::trapezoidal());
    show(&system, &mut DiscreteEulerLagrange::midpoint());
    show(&system, &mut RungeKutta4::new(&system));
    show(&system, &mut DormandPrince853::new(&system));
    show(&system, &mut AdamsBashforthMoulton::<13, _>::new(&system));
    show(&system, &mut GaussLegendre::<2, _>::new());
    show(&system, &mut GaussLegendre::<3, _>::new());
    show(&system, &mut GaussLegendre::<4, _>::new());
    show(&system, &mut GaussLegendre::<6, _>::new());
    Ok(())
}
