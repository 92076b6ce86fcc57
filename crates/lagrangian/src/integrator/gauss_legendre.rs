//! Gauss–Legendre variational collocation: the action of a polynomial path, by Gauss quadrature, made stationary.
//!
//! # Derivation
//! On [t₀, t₀ + h] let the velocity be a polynomial of degree s − 1 with values Vᵢ at the Gauss nodes cᵢ, so that
//! Qᵢ = q₀ + h Σⱼ aᵢⱼ Vⱼ and q₁ = q₀ + h Σᵢ bᵢ Vᵢ. The discrete Lagrangian is the Gauss quadrature of the action,
//! extremal over the inner values,
//!
//! L_d(q₀, q₁) = ext h Σᵢ bᵢ L(Qᵢ, Vᵢ, t₀ + cᵢh).
//!
//! A multiplier for the end point is the momentum p₁; stationarity in Vᵢ, with the symplectic relation
//! bᵢaᵢⱼ + bⱼaⱼᵢ = bᵢbⱼ of the Gauss coefficients, gives the symplectic partitioned Runge–Kutta method on q̇ = v,
//! ṗ = ∂L/∂q + F, p = ∂L/∂v:
//!
//! ∂L/∂v(Qᵢ, Vᵢ) = p₀ + h Σⱼ aᵢⱼ (∂L/∂q + F)(Qⱼ, Vⱼ),  p₁ = p₀ + h Σᵢ bᵢ (∂L/∂q + F)(Qᵢ, Vᵢ).
//!
//! Its order is 2s for any mass matrix. Without F it keeps the symplectic form dq ∧ dp, the momentum of every linear
//! symmetry and every invariant that is quadratic in (q, p); it is symmetric in time. (The same coefficients on q̇ = v, v̇ = q̈(q, v)
//! are *not* symplectic in (q, p) when M depends on q, and are not offered.)
//!
//! # Solution
//! The unknowns are the stage velocities. With rᵢ = p₀ + h Σⱼ aᵢⱼ fⱼ − ∂L/∂v(Qᵢ, Vᵢ) an iteration corrects them by
//! dᵢ = M(Qᵢ, Vᵢ)⁻¹ rᵢ, which contracts by O(h), or, where that is slow, by
//! dᵢ − Mᵢ⁻¹ h Σₖ aᵢₖ (G dₖ − h K Σₗ aₖₗ dₗ) with G = ∂²L/∂v∂q − ∂²L/∂q∂v − ∂F/∂v and K = ∂²L/∂q∂q + ∂F/∂q at one middle stage:
//! two terms of the inverse's Neumann series, which contracts by O(h²). It starts from the last step's velocities, end velocity and end
//! acceleration, extrapolated, and ends at rounding. Where it contracts too slowly, Newton's method with
//! second derivatives ([`System::curve`]) takes over: −∂rᵢ/∂Vⱼ is
//! δᵢⱼ Mᵢ + h aᵢⱼ (∂²L/∂v∂qᵢ − ∂²L/∂q∂vⱼ − ∂F/∂vⱼ) − h² Σₖ aᵢₖ aₖⱼ (∂²L/∂q∂q + ∂F/∂q)ₖ.
//!
//! # Reference
//! Marsden, West, *Discrete mechanics and variational integrators*, Acta Numerica 10 (2001), section 2.6. Hairer,
//! Lubich, Wanner, *Geometric Numerical Integration*, 2nd ed., 2006, II.1.3, VI.4, VI.6.2 (the discrete Lagrangian),
//! VIII.6 (starting values, stopping). Hairer, McLachlan, Razakarivony, *Achieving Brouwer's law with implicit
//! Runge–Kutta methods*, BIT 48 (2008).

mod newton;
mod predictor;
mod stages;
mod tableau;

pub(crate) use tableau::Tableau;

use crate::coordinates::{Coordinates, Phase};
use crate::error::LagrangianError;
use crate::integrator::canonical::{Canonical, Left, check_finite};
use crate::integrator::{Cost, Integrator, Method, StepReport, Structure, admit, assert_sizes};
use crate::system::System;
use predictor::Predictor;
use stages::{Rates, Stages};

/// The method with `STAGES` stages (1 to 16), of order 2 · `STAGES`. See the [module](self) page.
///
/// `GaussLegendre::<1, _>` is the variational midpoint rule; 2, 3, 4 and 6 stages have order 4, 6, 8 and 12.
#[derive(Clone, Debug)]
pub struct GaussLegendre<const STAGES: usize, C: Coordinates> {
    name: &'static str,
    tableau: Tableau<STAGES>,
    predictor: Predictor<STAGES>,
    history: Option<History<STAGES, C>>,
    stages: Option<Box<Stages<STAGES, C>>>,
}

/// What the last step left.
#[derive(Clone, Debug)]
struct History<const STAGES: usize, C: Coordinates> {
    left: Left<C>,
    acceleration: C,
    step: f64,
    velocities: [C; STAGES],
    rates: Rates,
}

impl<const STAGES: usize, C: Coordinates> GaussLegendre<STAGES, C> {
    /// The method, without history.
    ///
    /// # Panics
    /// If `STAGES` is zero or above 16.
    pub fn new() -> Self {
        Self::named(NAMES[STAGES])
    }

    /// The method under another name, for messages.
    pub(super) fn named(name: &'static str) -> Self {
        let tableau = Tableau::new();
        Self { name, predictor: Predictor::new(&tableau), tableau, history: None, stages: None }
    }
}

impl<const STAGES: usize, C: Coordinates> Default for GaussLegendre<STAGES, C> {
    fn default() -> Self {
        Self::new()
    }
}

const NAMES: [&str; 17] = [
    "Gauss–Legendre",
    "Gauss–Legendre 2",
    "Gauss–Legendre 4",
    "Gauss–Legendre 6",
    "Gauss–Legendre 8",
    "Gauss–Legendre 10",
    "Gauss–Legendre 12",
    "Gauss–Legendre 14",
    "Gauss–Legendre 16",
    "Gauss–Legendre 18",
    "Gauss–Legendre 20",
    "Gauss–Legendre 22",
    "Gauss–Legendre 24",
    "Gauss–Legendre 26",
    "Gauss–Legendre 28",
    "Gauss–Legendre 30",
    "Gauss–Legendre 32",
];

impl<const STAGES: usize, S: System> Integrator<S> for GaussLegendre<STAGES, S::Coordinates> {
    fn method(&self) -> Method {
        Method {
            name: self.name,
            order: 2 * STAGES as u32,
            structure: Structure::SymplecticQuadratic,
            cost: Cost::Implicit { stages: STAGES as u32 },
        }
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
        let mut stages = match self.stages.take() {
            Some(stages) if stages.dimension() == n => stages,
            _ => Box::new(Stages::new(n)),
        };
        let result = self.advance(system, phase, h, &mut stages, &mut report);
        self.stages = Some(stages);
        result.map(|()| report)
    }
}

impl<const STAGES: usize, C: Coordinates> GaussLegendre<STAGES, C> {
    fn advance<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        h: f64,
        stages: &mut Stages<STAGES, C>,
        report: &mut StepReport,
    ) -> Result<(), LagrangianError> {
        stages.start_velocity.clone_from(&phase.v);
        let history = self.history.as_ref().filter(|history| history.left.is(phase, h));
        let (start, acceleration, mut rates) = match history {
            Some(history) => {
                self.predictor.predict(
                    history.step,
                    &history.velocities,
                    phase,
                    &history.acceleration,
                    h,
                    stages,
                );
                (history.left.canonical.clone(), history.acceleration.clone(), history.rates)
            }
            None => {
                report.evaluations += 1;
                let (start, a) = Canonical::of_phase(system, phase, &mut stages.expansions[0])?;
                stages.predict_linearly(&self.tableau, &phase.v, &a, h);
                (start, a, Rates::UNKNOWN)
            }
        };
        if stages.iterate(system, &self.tableau, &start, h, &mut rates, report).is_err() {
            stages.predict_linearly(&self.tableau, &phase.v, &acceleration, h);
            stages.solve_by_newton(system, &self.tableau, &start, h, self.name, report)?;
            rates = Rates::UNKNOWN;
        }
        let mut end = start;
        stages.advance(&self.tableau, h, &mut end);
        let mut v = self.predictor.end_velocity(&stages.velocities, &phase.v);
        let found = end.solve_velocity(system, &mut v, &mut stages.expansions[0]);
        report.evaluations += found.map_err(|lost| LagrangianError::NotConverged {
            method: self.name,
            time: phase.time,
            step: h,
            iterations: report.iterations as u32,
            correction: lost.0,
            tolerance: 1e-12,
        })?;
        check_finite(crate::error::Symbol::Coordinate, end.time, end.q.as_ref())?;
        check_finite(crate::error::Symbol::Velocity, end.time, v.as_ref())?;
        let acceleration = stages.end_acceleration();
        *phase = Phase { time: end.time, q: end.q.clone(), v };
        let left = Left { phase: phase.clone(), canonical: end };
        let velocities = stages.velocities.clone();
        self.history = Some(History { left, acceleration, step: h, velocities, rates });
        Ok(())
    }
}
