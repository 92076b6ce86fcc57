//! The integrators that scenes can name.

use super::unknown_method;
use crate::experiment::ExperimentError;
use lagrangian::System;
use lagrangian::integrator::{
    AdamsBashforthMoulton, Bdf2, DiscreteEulerLagrange, DormandPrince853, GaussLegendre, ImplicitEuler,
    Integrator, RungeKutta4, StormerVerlet,
};

/// The method with step-size control.
pub(super) const ADAPTIVE: &str = "dop853-adaptive";

/// All of them, by name.
pub(super) const ALL: &[&str] = &[
    "rk4",
    "dop853",
    "verlet",
    "midpoint",
    "trapezoidal",
    "gauss-legendre-4",
    "gauss-legendre-6",
    "gauss-legendre-8",
    "gauss-legendre-12",
    "implicit-euler",
    "bdf2",
    "adams-12",
    ADAPTIVE,
];

/// Those with a fixed step: all but the last.
pub(super) const FIXED_STEP: &[&str] = ALL.split_at(ALL.len() - 1).0;

/// The integrator with a scene's name, for a fixed step.
pub(super) fn fixed_step<S: System + 'static>(
    system: &S,
    method: &str,
) -> Result<Box<dyn Integrator<S>>, ExperimentError> {
    Ok(match method {
        "rk4" => Box::new(RungeKutta4::new(system)),
        "dop853" => Box::new(DormandPrince853::new(system)),
        "verlet" => Box::new(StormerVerlet::new(system)),
        "midpoint" => Box::new(DiscreteEulerLagrange::midpoint()),
        "trapezoidal" => Box::new(DiscreteEulerLagrange::trapezoidal()),
        "gauss-legendre-4" => Box::new(GaussLegendre::<2, _>::new()),
        "gauss-legendre-6" => Box::new(GaussLegendre::<3, _>::new()),
        "gauss-legendre-8" => Box::new(GaussLegendre::<4, _>::new()),
        "gauss-legendre-12" => Box::new(GaussLegendre::<6, _>::new()),
        "implicit-euler" => Box::new(ImplicitEuler::new()),
        "bdf2" => Box::new(Bdf2::new()),
        "adams-12" => Box::new(AdamsBashforthMoulton::<11, _>::new(system)),
        _ => return Err(unknown_method(method)),
    })
}
