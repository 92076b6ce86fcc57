//! Discrete Euler–Lagrange equations in position–momentum form, with the midpoint and the trapezoidal discrete
//! Lagrangian.
//!
//! # Derivation
//! A discrete Lagrangian L_d(q₀, q₁) approximates the action of the motion from q₀ to q₁ in the time h. The discrete
//! action Σ L_d(q_k, q_{k+1}) is stationary where D₂L_d(q₀, q₁) + D₁L_d(q₁, q₂) = 0. With the momenta
//!
//! p₀ = −D₁L_d(q₀, q₁) − F_d⁻,  p₁ = D₂L_d(q₀, q₁) + F_d⁺
//!
//! this is a one-step map (q₀, p₀) ↦ (q₁, p₁): solve the first equation for q₁, evaluate the second. F_d^± split the
//! applied forces F = Q − ∂R/∂v by the discrete Lagrange–d'Alembert principle. The unknown here is the velocity
//! w = (q₁ − q₀)/h.
//!
//! **Midpoint**: L_d = h L((q₀ + q₁)/2, w, t₀ + h/2), F_d^± = (h/2) F there. With m for the derivatives at the
//! midpoint: p₀ = ∂L/∂v_m − (h/2)(∂L/∂q + F)_m and p₁ = ∂L/∂v_m + (h/2)(∂L/∂q + F)_m. That is Gauss–Legendre
//! collocation with one stage, which does the work; quadratic invariants are kept.
//!
//! **Trapezoidal**: L_d = (h/2) [L(q₀, w, t₀) + L(q₁, w, t₁)], F_d⁻ = (h/2) F(q₀, w, t₀), F_d⁺ = (h/2) F(q₁, w, t₁):
//!
//! p₀ = ½ (∂L/∂v₀ + ∂L/∂v₁) − (h/2)(∂L/∂q + F)₀,  p₁ = ½ (∂L/∂v₀ + ∂L/∂v₁) + (h/2)(∂L/∂q + F)₁,
//!
//! which for a separable Lagrangian is Störmer–Verlet.
//!
//! Both have order 2, are symmetric, and, without F, keep the symplectic form and the momentum of every symmetry that
//! acts linearly on q.
//!
//! # Solution of the trapezoidal equation
//! With r = p₀ − ½ (∂L/∂v₀ + ∂L/∂v₁) + (h/2)(∂L/∂q + F)₀ the iteration is w += M̄⁻¹ r, M̄ = ½ (M₀ + M₁), which contracts by
//! O(h); where that is slow, Newton's with −∂r/∂w = M̄ + (h/2)(∂²L/∂v∂q₁ − ∂²L/∂q∂v₀ − ∂F/∂v₀).
//!
//! # Reference
//! Marsden, West, *Discrete mechanics and variational integrators*, Acta Numerica 10 (2001), sections 1.3, 1.5, 3.2
//! (forcing), examples 2.3.1 and 2.6.

mod trapezoidal;

use crate::coordinates::{Coordinates, Phase};
use crate::error::LagrangianError;
use crate::integrator::gauss_legendre::GaussLegendre;
use crate::integrator::{Cost, Integrator, Method, StepReport, Structure};
use crate::system::System;
use trapezoidal::Trapezoidal;

/// How the action of one step is approximated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiscreteLagrangian {
    /// By the value at the midpoint of both time and coordinates.
    Midpoint,
    /// By the mean of the values at the ends.
    Trapezoidal,
}

/// The integrator. See the [module](self) page.
#[derive(Clone, Debug)]
pub struct DiscreteEulerLagrange<C: Coordinates> {
    rule: Rule<C>,
}

#[derive(Clone, Debug)]
enum Rule<C: Coordinates> {
    Midpoint(GaussLegendre<1, C>),
    Trapezoidal(Trapezoidal<C>),
}

impl<C: Coordinates> DiscreteEulerLagrange<C> {
    /// The method with the discrete Lagrangian named.
    pub fn new(lagrangian: DiscreteLagrangian) -> Self {
        let rule = match lagrangian {
            DiscreteLagrangian::Midpoint => Rule::Midpoint(GaussLegendre::new()),
            DiscreteLagrangian::Trapezoidal => Rule::Trapezoidal(Trapezoidal::new()),
        };
        Self { rule }
    }

    /// The method with the midpoint discrete Lagrangian.
    pub fn midpoint() -> Self {
        Self::new(DiscreteLagrangian::Midpoint)
    }

    /// The method with the trapezoidal discrete Lagrangian.
    pub fn trapezoidal() -> Self {
        Self::new(DiscreteLagrangian::Trapezoidal)
    }

    /// The discrete Lagrangian.
    pub fn discrete_lagrangian(&self) -> DiscreteLagrangian {
        match self.rule {
            Rule::Midpoint(_) => DiscreteLagrangian::Midpoint,
            Rule::Trapezoidal(_) => DiscreteLagrangian::Trapezoidal,
        }
    }
}

impl<S: System> Integrator<S> for DiscreteEulerLagrange<S::Coordinates> {
    fn method(&self) -> Method {
        let (name, structure) = match self.rule {
            Rule::Midpoint(_) => ("discrete Euler–Lagrange, midpoint", Structure::SymplecticQuadratic),
            Rule::Trapezoidal(_) => (trapezoidal::NAME, Structure::Symplectic),
        };
        Method { name, order: 2, structure, cost: Cost::Implicit { stages: 1 } }
    }

    fn step(
        &mut self,
        system: &S,
        phase: &mut Phase<S::Coordinates>,
        h: f64,
    ) -> Result<StepReport, LagrangianError> {
        match &mut self.rule {
            Rule::Midpoint(gauss) => gauss.step(system, phase, h),
            Rule::Trapezoidal(trapezoidal) => trapezoidal.step(system, phase, h),
        }
    }
}
