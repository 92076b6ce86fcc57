//! Implicit Euler: first order, and it takes energy out of whatever is too fast for its step.
//!
//! q₁ = q₀ + h v₁, p₁ = p₀ + h (∂L/∂q + F)(q₁, v₁, t₁), p₁ = ∂L/∂v(q₁, v₁, t₁).
//!
//! Where the mass matrix is constant this is the minimum of an incremental potential and found as one; for M(q) it is
//! a root in (q, p). [`ImplicitEuler::formulation`] says which ran; [`Formulation`] has both equations.
//!
//! An oscillation of frequency ω loses amplitude by the factor 1/√(1 + h²ω²) a step.
//!
//! A step changes the energy by −½ h² żᵀ∇²H ż + O(h³), ż = (q̇, ṗ): it falls where H is convex along the motion. Where it is
//! not, in a pendulum above the horizontal or with an M(q) that moves fast, it may rise.
//!
//! # Reference
//! Hairer, Lubich, Wanner, *Geometric Numerical Integration*, 2nd ed., 2006, I.1. Ortiz, Stainier, *The variational
//! formulation of viscoplastic constitutive updates*, Comput. Methods Appl. Mech. Eng. 171 (1999) (incremental
//! potentials with dissipation).

use crate::coordinates::{Coordinates, Phase};
use crate::error::{LagrangianError, Symbol};
use crate::integrator::backward::{Anchor, Backward};
use crate::integrator::canonical::{Canonical, Left, check_finite};
use crate::integrator::{Cost, Formulation, Integrator, Method, StepReport, Structure, admit, assert_sizes};
use crate::system::System;

const NAME: &str = "implicit Euler";

/// The integrator. See the [module](self) page.
#[derive(Clone, Debug)]
pub struct ImplicitEuler<C: Coordinates> {
    history: Option<(Left<C>, Formulation)>,
    backward: Option<Box<Backward<C>>>,
}

impl<C: Coordinates> ImplicitEuler<C> {
    /// The method, without history.
    pub fn new() -> Self {
        Self { history: None, backward: None }
    }

    /// How the last step was solved; `None` before the first.
    pub fn formulation(&self) -> Option<Formulation> {
        self.history.as_ref().map(|(_, formulation)| *formulation)
    }
}

impl<C: Coordinates> Default for ImplicitEuler<C> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: System> Integrator<S> for ImplicitEuler<S::Coordinates> {
    fn method(&self) -> Method {
        let cost = Cost::Implicit { stages: 1 };
        Method { name: NAME, order: 1, structure: Structure::Dissipative, cost }
    }

    fn step(
        &mut self,
        system: &S,
        phase: &mut Phase<S::Coordinates>,
        h: f64,
    ) -> Result<StepReport, LagrangianError> {
        let n = system.dimension();
        assert_sizes(system, phase, n);
        admit(phase, h)?;
        let mut report = StepReport::default();
        let mut backward = match self.backward.take() {
            Some(backward) if backward.dimension() == n => backward,
            _ => Box::new(Backward::new(n)),
        };
        let history = self.history.as_ref().filter(|(left, _)| left.is(phase, h));
        let result = advance(system, phase, h, history, &mut backward, &mut report);
        self.backward = Some(backward);
        self.history = Some(result?);
        Ok(report)
    }
}

fn advance<S: System>(
    system: &S,
    phase: &mut Phase<S::Coordinates>,
    h: f64,
    history: Option<&(Left<S::Coordinates>, Formulation)>,
    backward: &mut Backward<S::Coordinates>,
    report: &mut StepReport,
) -> Result<(Left<S::Coordinates>, Formulation), LagrangianError> {
    let (start, formulation) = match history {
        Some((left, formulation)) => (left.canonical.clone(), *formulation),
        None => {
            report.evaluations += 1;
            let (start, _) = Canonical::of_phase(system, phase, &mut backward.at)?;
            (start, backward.formulation(system, phase, h, report))
        }
    };
    backward.velocity.clone_from(&phase.v);
    let zeros = S::Coordinates::zeros(system.dimension());
    let anchor = Anchor { start: &start, drift_q: &zeros, drift_p: &zeros, eta: h, h, method: NAME };
    backward.solve(system, &anchor, formulation, report)?;
    let mut end = start.clone();
    let mut increment = zeros.clone();
    backward.impulse_into(h, &mut increment);
    end.add_to_p(&increment);
    for (increment, w) in increment.as_mut().iter_mut().zip(backward.velocity.as_ref()) {
        *increment = h * w;
    }
    end.add_to_q(&increment);
    end.advance_time(h);
    check_finite(Symbol::Coordinate, end.time, end.q.as_ref())?;
    *phase = Phase { time: end.time, q: end.q.clone(), v: backward.velocity.clone() };
    Ok((Left { phase: phase.clone(), canonical: end }, formulation))
}
