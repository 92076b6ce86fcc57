//! Integrators: from a state of motion to the one a step later.

mod adams;
mod backward;
pub mod bdf2;
mod canonical;
mod convergence;
pub mod discrete_euler_lagrange;
mod dormand_prince;
pub mod drive;
mod event;
pub mod gauss_legendre;
pub mod implicit_euler;
mod remainder;
mod runge_kutta;
mod trajectory;
mod verlet;

pub use adams::{AdamsBashforthMoulton, Evaluations};
pub use backward::Formulation;
pub use bdf2::Bdf2;
pub use discrete_euler_lagrange::{DiscreteEulerLagrange, DiscreteLagrangian};
pub use dormand_prince::{AdaptiveReport, DenseStep, DenseTrajectory, DormandPrince853, Tolerance};
pub use drive::{DriveReport, Outcome};
pub use event::{Consequence, Crossing, Direction, Event, Located};
pub use gauss_legendre::GaussLegendre;
pub use implicit_euler::ImplicitEuler;
pub use runge_kutta::RungeKutta4;
pub use trajectory::Trajectory;
pub use verlet::StormerVerlet;

use crate::coordinates::{Coordinates, Phase};
use crate::error::LagrangianError;
use crate::system::System;
use std::ops::AddAssign;

/// A method that advances the state of motion of a system by one step.
///
/// A method may keep history (earlier states of a multistep method, start values of an iteration, the rounding errors
/// of compensated sums). It uses it only if `phase` is what its own last step has left: coordinates and velocities bit
/// for bit, the time up to rounding, because drivers set it to t₀ + n h ([`Phase::continues`]). From any other state it
/// starts anew, as a new integrator would.
///
/// History belongs to a system as well as to a state, and only the state is looked at: after a change of the system (a
/// parameter, another `system`) within a motion, take a new integrator. An old one would go on with a momentum, a mass
/// matrix or a force of before the change.
pub trait Integrator<S: System> {
    /// What the method is.
    fn method(&self) -> Method;

    /// Moves `phase` from t to t + h.
    ///
    /// # Errors
    /// [`LagrangianError`]; `phase` and the history are then as they were.
    ///
    /// # Panics
    /// If the state, or the system that the integrator was made for, is not of the system's size.
    fn step(
        &mut self,
        system: &S,
        phase: &mut Phase<S::Coordinates>,
        h: f64,
    ) -> Result<StepReport, LagrangianError>;
}

/// What a method promises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    /// Its name, for reports.
    pub name: &'static str,
    /// The order of its global error in h.
    pub order: u32,
    /// What it keeps.
    pub structure: Structure,
    /// What a step costs.
    pub cost: Cost,
}

/// What a method keeps of the exact flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// Nothing in particular.
    General,
    /// The symplectic form, so that energy stays near its value for exponentially long times, and the momentum of every
    /// symmetry that is linear in q: linear and angular momentum.
    Symplectic,
    /// The symplectic form, and every invariant that is quadratic in (q, p): momenta, and the energy of an oscillator.
    SymplecticQuadratic,
    /// Energy is taken out of high frequencies.
    Dissipative,
}

/// What a step costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// A fixed number of evaluations of q̈.
    Explicit {
        /// Evaluations a step.
        evaluations: u32,
    },
    /// A system of equations to solve.
    Implicit {
        /// Unknowns per coordinate.
        stages: u32,
    },
}

/// What a step took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepReport {
    /// Evaluations of the system's first derivatives ([`System::expand`], or q̈).
    pub evaluations: u64,
    /// Evaluations of its second derivatives ([`System::curve`]).
    pub curvatures: u64,
    /// Iterations of the solver inside the step.
    pub iterations: u64,
}

impl AddAssign for StepReport {
    fn add_assign(&mut self, other: Self) {
        self.evaluations += other.evaluations;
        self.curvatures += other.curvatures;
        self.iterations += other.iterations;
    }
}

/// Refuses a step size that is not positive and finite, a state that is not finite, and a step that the time is too
/// large to show.
#[inline]
fn admit<C: Coordinates>(phase: &Phase<C>, h: f64) -> Result<(), LagrangianError> {
    if !(h > 0.0 && h.is_finite()) {
        return Err(LagrangianError::Step { step: h });
    }
    phase.validate()?;
    if phase.time + h == phase.time {
        return Err(LagrangianError::StepTooSmall { time: phase.time, step: h });
    }
    Ok(())
}

/// # Panics
/// If the state, or the integrator with its room for `room` coordinates, does not belong to a system of this size.
#[inline]
fn assert_sizes<S: System>(system: &S, phase: &Phase<S::Coordinates>, room: usize) {
    let n = system.dimension();
    let [q, v] = [&phase.q, &phase.v].map(|x| x.as_ref().len());
    assert!(q == n && v == n, "a state of {q} coordinates and {v} velocities for a system of {n}");
    assert_eq!(room, n, "an integrator for {room} coordinates, a system of {n}");
}
