//! Conserved quantities: which there are, and how well an integrator keeps them.
//!
//! **Energy.** Where L does not mention time and no other forces act, Jacobi's integral h = v·∂L/∂v − L is
//! conserved. It is T + V where T is quadratic in v; on a hoop that is driven round it is not T + V, and the
//! motor's work is the difference.
//!
//! **Momenta.** Where L does not mention qᵢ (a cyclic coordinate) and no force acts on it, pᵢ = ∂L/∂vᵢ is conserved.
//!
//! **Noether's charges.** Move all coordinates along a generator, q → q + ε ξ(q, t). If L changes by a total time
//! derivative only,
//!
//! δL = ξ·∂L/∂q + (D ξ)·∂L/∂v = D K(q, t), with D = v·∂/∂q + ∂/∂t,
//!
//! and no force does work along ξ, then Q = ∂L/∂v·ξ − K is conserved: along a motion dQ/dt = (d/dt ∂L/∂v)·ξ +
//! ∂L/∂v·Dξ − D K, and d/dt ∂L/∂v = ∂L/∂q + F by the Euler–Lagrange equations, so dQ/dt = δL + ξ·F − D K.
//! [`Noether::new`] checks at many states that this rate vanishes, before any charge is claimed.
//!
//! ξ depends on position and time: a *point* symmetry. The Laplace–Runge–Lenz vector of the Kepler problem is
//! conserved too, but belongs to no point symmetry (its generator contains velocities), and cannot be had this way.
//!
//! [`found`] gives energy and the momenta of cyclic coordinates, [`diagnose`] follows any of them along a trajectory.
//!
//! # Reference
//! Noether, *Invariante Variationsprobleme* (1918). Goldstein, Poole and Safko, *Classical Mechanics*, 3rd ed.
//! (2002), sections 2.6, 2.7 and 13.7; 9.5 and 3.9 for the Laplace–Runge–Lenz vector.

mod diagnosis;
mod noether;

pub use diagnosis::{Diagnosis, Drift, FEWEST_SAMPLES, Verdict, diagnose};
pub use noether::{Noether, Symmetry};

use crate::coordinates::Phase;
use crate::system::{Gradient, System};

/// A function of the state of motion that the motion does not change.
pub trait Invariant<S: System> {
    /// Its name, for reports.
    fn name(&self) -> String;

    /// Its value at a state of motion, in its own unit. NaN where the system's derivatives are.
    fn measure(&self, system: &S, phase: &Phase<S::Coordinates>) -> Measured;
}

/// The value of an invariant, and of what size the terms are that it is the sum of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The value.
    pub value: f64,
    /// The sum of the magnitudes of its terms: rounding is measured against it.
    pub size: f64,
}

/// Jacobi's integral v·∂L/∂v − L \[J\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Energy {
    /// T + V: T is quadratic in the velocities.
    Mechanical,
    /// Not T + V: T has terms of other degrees in the velocities.
    Jacobi,
}

impl<S: System> Invariant<S> for Energy {
    fn name(&self) -> String {
        match self {
            Self::Mechanical => "energy".to_owned(),
            Self::Jacobi => "Jacobi integral".to_owned(),
        }
    }

    fn measure(&self, system: &S, phase: &Phase<S::Coordinates>) -> Measured {
        let at = gradient(system, phase);
        let terms = || at.momentum.as_ref().iter().zip(phase.v.as_ref()).map(|(p, v)| p * v);
        Measured {
            value: terms().sum::<f64>() - at.kinetic + at.potential,
            size: terms().map(f64::abs).sum::<f64>() + at.kinetic.abs() + at.potential.abs(),
        }
    }
}

/// The momentum ∂L/∂vᵢ of one coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Momentum {
    /// i.
    pub coordinate: usize,
}

impl<S: System> Invariant<S> for Momentum {
    fn name(&self) -> String {
        format!("momentum {}", self.coordinate)
    }

    fn measure(&self, system: &S, phase: &Phase<S::Coordinates>) -> Measured {
        let value = gradient(system, phase).momentum.as_ref()[self.coordinate];
        Measured { value, size: value.abs() }
    }
}

/// The invariants that the formulas themselves show: the energy if nothing mentions time and no other forces act, and
/// the momenta of cyclic coordinates.
///
/// The formulas are traced at one state. What they mention may still cancel: an invariant that is not found
/// here may exist, but none is claimed that does not.
pub fn found<S: System>(system: &S, phase: &Phase<S::Coordinates>) -> Vec<Box<dyn Invariant<S>>> {
    let on = system.dependence(phase.time, &phase.q, &phase.v);
    let mut out: Vec<Box<dyn Invariant<S>>> = Vec::new();
    if !(on.kinetic_on_time || on.potential_on_time || on.applied()) {
        out.push(Box::new(if on.kinetic_quadratic { Energy::Mechanical } else { Energy::Jacobi }));
    }
    for coordinate in 0..system.dimension() {
        let mentioned =
            on.kinetic_on_q[coordinate] || on.potential_on_q[coordinate] || on.applied_on[coordinate];
        if !mentioned {
            out.push(Box::new(Momentum { coordinate }));
        }
    }
    out
}

fn gradient<S: System>(system: &S, phase: &Phase<S::Coordinates>) -> Gradient<S::Coordinates> {
    let mut at = Gradient::zeros(system.dimension());
    system.differentiate(phase.time, &phase.q, &phase.v, &mut at);
    at
}
