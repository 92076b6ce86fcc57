//! The Störmer–Verlet method.

use super::remainder::Remainder;
use super::{Cost, Integrator, Method, StepReport, Structure, admit, assert_sizes};
use crate::coordinates::{Coordinates, Phase};
use crate::dense;
use crate::error::{LagrangianError, Symbol};
use crate::system::{Dependence, Expansion, Gradient, System};

/// The Störmer–Verlet method (leapfrog in its velocity form), for L = ½ vᵀ M v − V(q, t) with a constant M and nothing
/// applied:
///
/// ```text
/// v½ = v + h/2 a(t, q),   q' = q + h v½,   v' = v½ + h/2 a(t + h, q'),   a = −M⁻¹ ∂V/∂q
/// ```
///
/// Order 2, symplectic, symmetric, one evaluation of ∂V/∂q a step (the last one is the next step's first), M factored
/// once. It keeps linear and angular momentum, but not every quadratic invariant: of an oscillator it keeps an energy that
/// is wrong by O(h²). The sums are compensated.
///
/// Where T mentions q or time, or a force is applied, the formulas above would still run and give numbers, but not
/// this method's: the first step of a trajectory therefore asks the system what its terms mention
/// ([`System::dependence`]) and refuses.
///
/// # Reference
/// Hairer, Lubich, Wanner 2003, "Geometric numerical integration illustrated by the Störmer–Verlet method", Acta
/// Numerica 12, eq. (1.5).
#[derive(Clone, Debug)]
pub struct StormerVerlet<C: Coordinates> {
    remainder: Remainder<C>,
    /// The expansion at the state that the last step has left; its mass holds the factors.
    last: Expansion<C>,
    /// The first derivatives at the end of a step.
    next: Gradient<C>,
    /// M⁻¹ ∂L/∂q at the state that the last step has left.
    a: C,
    /// The same at the end of a step.
    a_next: C,
    q: C,
    v: C,
}

const NAME: &str = "Störmer–Verlet";

impl<C: Coordinates> StormerVerlet<C> {
    /// The method, with room for the coordinates of `system`.
    pub fn new<S: System<Coordinates = C>>(system: &S) -> Self {
        let n = system.dimension();
        Self {
            remainder: Remainder::new(n),
            last: Expansion::zeros(n),
            next: Gradient::zeros(n),
            a: C::zeros(n),
            a_next: C::zeros(n),
            q: C::zeros(n),
            v: C::zeros(n),
        }
    }

    /// Refuses what is not separable; else factors M and finds the acceleration at `phase`.
    fn start<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &Phase<C>,
    ) -> Result<(), LagrangianError> {
        if let Some(reason) = coupling(&system.dependence(phase.time, &phase.q, &phase.v)) {
            return Err(LagrangianError::NotSeparable { method: NAME, reason });
        }
        system.expand(phase.time, &phase.q, &phase.v, &mut self.last);
        self.a.as_mut().copy_from_slice(self.last.slope.as_ref());
        dense::solve_mass::<C>(phase.time, &mut self.last.mass, self.a.as_mut())
    }

    /// The step, from the acceleration at its start. An error leaves that as it was.
    fn kick_drift_kick<S: System<Coordinates = C>>(
        &mut self,
        system: &S,
        phase: &mut Phase<C>,
        h: f64,
    ) -> Result<(), LagrangianError> {
        let time = phase.time + h;
        self.drift(phase, h);
        system.differentiate(time, &self.q, &self.v, &mut self.next);
        let slope = self.next.slope.as_ref();
        if let Some(index) = slope.iter().position(|f| !f.is_finite()) {
            let value = slope[index];
            return Err(LagrangianError::NonFinite { symbol: Symbol::Force, index, value, time });
        }
        self.a_next.as_mut().copy_from_slice(slope);
        dense::solve_factored::<C>(&self.last.mass, self.a_next.as_mut());
        self.increments(phase, h);
        self.remainder.add(phase, h, &self.q, &self.v)?;
        std::mem::swap(&mut self.a, &mut self.a_next);
        Ok(())
    }

    /// Sets q to the coordinates at the end of the step, v to the velocities halfway.
    #[inline]
    fn drift(&mut self, phase: &Phase<C>, h: f64) {
        for i in 0..self.q.as_ref().len() {
            let v = phase.v.as_ref()[i] + 0.5 * h * self.a.as_ref()[i];
            self.v.as_mut()[i] = v;
            self.q.as_mut()[i] = phase.q.as_ref()[i] + h * v;
        }
    }

    /// Sets q and v to the step's increments.
    #[inline]
    fn increments(&mut self, phase: &Phase<C>, h: f64) {
        for i in 0..self.q.as_ref().len() {
            let (a, a_next) = (self.a.as_ref()[i], self.a_next.as_ref()[i]);
            self.q.as_mut()[i] = h * (phase.v.as_ref()[i] + 0.5 * h * a);
            self.v.as_mut()[i] = 0.5 * h * (a + a_next);
        }
    }
}

/// What keeps a Lagrangian from being ½ vᵀ M v − V(q, t), if anything does.
fn coupling(of: &Dependence) -> Option<String> {
    if let Some(i) = of.kinetic_on_q.iter().position(|&on| on) {
        return Some(format!("the kinetic energy depends on coordinate {i}"));
    }
    if of.kinetic_on_time {
        return Some("the kinetic energy depends on time".to_owned());
    }
    if !of.kinetic_quadratic {
        return Some("the kinetic energy is not a quadratic form of the velocities".to_owned());
    }
    if of.applied() {
        let on = of.applied_on.iter().position(|&on| on).map(|i| format!(" on coordinate {i}"));
        return Some(format!(
            "a force or dissipation that no potential gives acts{}",
            on.unwrap_or_default()
        ));
    }
    None
}

impl<C: Coordinates, S: System<Coordinates = C>> Integrator<S> for StormerVerlet<C> {
    fn method(&self) -> Method {
        Method {
            name: NAME,
            order: 2,
            structure: Structure::Symplectic,
            cost: Cost::Explicit { evaluations: 1 },
        }
    }

    fn step(&mut self, system: &S, phase: &mut Phase<C>, h: f64) -> Result<StepReport, LagrangianError> {
        assert_sizes(system, phase, self.q.as_ref().len());
        admit(phase, h)?;
        if self.remainder.continues(phase, h) {
            self.kick_drift_kick(system, phase, h)?;
            return Ok(StepReport { evaluations: 1, ..StepReport::default() });
        }
        let kept = (self.last.clone(), self.a.clone());
        self.start(system, phase)
            .and_then(|()| self.kick_drift_kick(system, phase, h))
            .inspect_err(|_| (self.last, self.a) = kept)?;
        Ok(StepReport { evaluations: 2, ..StepReport::default() })
    }
}
