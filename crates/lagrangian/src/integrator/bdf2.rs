//! BDF2: second order, damps what is too fast for its step, and leaves slow motion nearly alone.
//!
//! (3/2 q₂ − 2 q₁ + ½ q₀)/h = v₂, (3/2 p₂ − 2 p₁ + ½ p₀)/h = (∂L/∂q + F)(q₂, v₂, t₂), p₂ = ∂L/∂v(q₂, v₂, t₂); as increments,
//! q₂ = q₁ + (q₁ − q₀)/3 + (2h/3) v₂ and the same for p. With h = r times the last step the parabola through the three states
//! gives
//!
//! q₂ = q₁ + r²/(1 + 2r) (q₁ − q₀) + (1 + r)/(1 + 2r) h v₂.
//!
//! The first step from a new state, or with r above 2 (from 1 + √2 on the method is unstable), is implicit Euler's. Solved as
//! implicit Euler is ([`Formulation`]).
//!
//! An oscillation of frequency ω loses 1 − (hω)⁴/4 + … of amplitude a step.
//!
//! # Reference
//! Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., 1993, III.1 (1.22′), III.5 (variable
//! steps).

use crate::coordinates::{Coordinates, Phase};
use crate::error::{LagrangianError, Symbol};
use crate::integrator::backward::{Anchor, Backward};
use crate::integrator::canonical::{Canonical, Left, check_finite};
use crate::integrator::{Cost, Formulation, Integrator, Method, StepReport, Structure, admit, assert_sizes};
use crate::system::System;

const NAME: &str = "BDF2";

/// Beyond this ratio of step sizes the method starts anew.
const LARGEST_RATIO: f64 = 2.0;

/// The integrator. See the [module](self) page.
#[derive(Clone, Debug)]
pub struct Bdf2<C: Coordinates> {
    history: Option<History<C>>,
    backward: Option<Box<Backward<C>>>,
}

#[derive(Clone, Debug)]
struct History<C> {
    left: Left<C>,
    /// q₁ − q₀ and p₁ − p₀ of the last step.
    increments: [C; 2],
    step: f64,
    formulation: Formulation,
}

impl<C: Coordinates> Bdf2<C> {
    /// The method, without history.
    pub fn new() -> Self {
        Self { history: None, backward: None }
    }

    /// How the last step was solved; `None` before the first.
    pub fn formulation(&self) -> Option<Formulation> {
        self.history.as_ref().map(|history| history.formulation)
    }
}

impl<C: Coordinates> Default for Bdf2<C> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: System> Integrator<S> for Bdf2<S::Coordinates> {
    fn method(&self) -> Method {
        let cost = Cost::Implicit { stages: 1 };
        Method { name: NAME, order: 2, structure: Structure::Dissipative, cost }
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
        let history = self
            .history
            .as_ref()
            .filter(|history| history.left.is(phase, h) && h <= LARGEST_RATIO * history.step);
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
    history: Option<&History<S::Coordinates>>,
    backward: &mut Backward<S::Coordinates>,
    report: &mut StepReport,
) -> Result<History<S::Coordinates>, LagrangianError> {
    let mut increments =
        [S::Coordinates::zeros(system.dimension()), S::Coordinates::zeros(system.dimension())];
    let (start, formulation, eta) = match history {
        Some(history) => {
            let ratio = h / history.step;
            let rest = 1.0 + 2.0 * ratio;
            for (drift, last) in increments.iter_mut().zip(&history.increments) {
                for (drift, last) in drift.as_mut().iter_mut().zip(last.as_ref()) {
                    *drift = last * (ratio * ratio / rest);
                }
            }
            (history.left.canonical.clone(), history.formulation, (1.0 + ratio) / rest * h)
        }
        None => {
            report.evaluations += 1;
            let (start, _) = Canonical::of_phase(system, phase, &mut backward.at)?;
            (start, backward.formulation(system, phase, h, report), h)
        }
    };
    backward.velocity.clone_from(&phase.v);
    let [drift_q, drift_p] = &increments;
    let anchor = Anchor { start: &start, drift_q, drift_p, eta, h, method: NAME };
    backward.solve(system, &anchor, formulation, report)?;
    let mut impulse = S::Coordinates::zeros(system.dimension());
    backward.impulse_into(eta, &mut impulse);
    let [of_q, of_p] = &mut increments;
    for j in 0..impulse.as_ref().len() {
        of_q.as_mut()[j] += eta * backward.velocity.as_ref()[j];
        of_p.as_mut()[j] += impulse.as_ref()[j];
    }
    let mut end = start.clone();
    end.add_to_q(of_q);
    end.add_to_p(of_p);
    end.advance_time(h);
    check_finite(Symbol::Coordinate, end.time, end.q.as_ref())?;
    *phase = Phase { time: end.time, q: end.q.clone(), v: backward.velocity.clone() };
    let left = Left { phase: phase.clone(), canonical: end };
    Ok(History { left, increments, step: h, formulation })
}
