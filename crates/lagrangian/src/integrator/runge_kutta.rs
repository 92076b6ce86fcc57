//! The classical Runge–Kutta method.

use super::remainder::Remainder;
use super::{Cost, Integrator, Method, StepReport, Structure, admit, assert_sizes};
use crate::coordinates::{Coordinates, Phase};
use crate::error::LagrangianError;
use crate::system::System;

/// The classical Runge–Kutta method of order 4 for q̇ = v, v̇ = a(t, q, v).
///
/// Because q̇ = v, the stages' velocities need not be kept: inserting them leaves
///
/// ```text
/// a₁ = a(t,       q,                      v)
/// a₂ = a(t + h/2, q + h/2 v,              v + h/2 a₁)
/// a₃ = a(t + h/2, q + h/2 v + h²/4 a₁,    v + h/2 a₂)
/// a₄ = a(t + h,   q + h v + h²/2 a₂,      v + h a₃)
/// q' = q + h v + h²/6 (a₁ + a₂ + a₃),     v' = v + h/6 (a₁ + 2 a₂ + 2 a₃ + a₄)
/// ```
///
/// Its energy drifts: it is here for comparison, and for short times. The sums are compensated.
///
/// # Reference
/// Kutta 1901; Hairer, Nørsett, Wanner 1993, *Solving Ordinary Differential Equations I*, section II.1 and, for the
/// second-order form, section II.14.
#[derive(Clone, Debug)]
pub struct RungeKutta4<C> {
    remainder: Remainder<C>,
    /// a₁ … a₄.
    a: [C; 4],
    /// A stage's coordinates, and at last Δq.
    q: C,
    /// A stage's velocities, and at last Δv.
    v: C,
}

impl<C: Coordinates> RungeKutta4<C> {
    /// The method, with room for the coordinates of `system`.
    pub fn new<S: System<Coordinates = C>>(system: &S) -> Self {
        let zeros = || C::zeros(system.dimension());
        Self {
            remainder: Remainder::new(system.dimension()),
            a: std::array::from_fn(|_| zeros()),
            q: zeros(),
            v: zeros(),
        }
    }

    /// Sets the stage's state to q + c h v + w h² a_j and v + c h a_k.
    #[inline]
    fn stage(&mut self, phase: &Phase<C>, ch: f64, (wh2, j): (f64, usize), k: usize) {
        for i in 0..self.q.as_ref().len() {
            let v = phase.v.as_ref()[i];
            self.q.as_mut()[i] = phase.q.as_ref()[i] + (ch * v + wh2 * self.a[j].as_ref()[i]);
            self.v.as_mut()[i] = v + ch * self.a[k].as_ref()[i];
        }
    }

    /// Sets q and v to the step's increments.
    #[inline]
    fn increments(&mut self, phase: &Phase<C>, h: f64) {
        for i in 0..self.q.as_ref().len() {
            let [a1, a2, a3, a4] = [0, 1, 2, 3].map(|s: usize| self.a[s].as_ref()[i]);
            self.q.as_mut()[i] = h * (phase.v.as_ref()[i] + h / 6.0 * (a1 + a2 + a3));
            self.v.as_mut()[i] = h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4);
        }
    }
}

impl<C: Coordinates, S: System<Coordinates = C>> Integrator<S> for RungeKutta4<C> {
    fn method(&self) -> Method {
        Method {
            name: "Runge–Kutta 4",
            order: 4,
            structure: Structure::General,
            cost: Cost::Explicit { evaluations: 4 },
        }
    }

    fn step(&mut self, system: &S, phase: &mut Phase<C>, h: f64) -> Result<StepReport, LagrangianError> {
        assert_sizes(system, phase, self.q.as_ref().len());
        admit(phase, h)?;
        let (t, half) = (phase.time, 0.5 * h);
        system.acceleration(t, &phase.q, &phase.v, &mut self.a[0])?;
        self.stage(phase, half, (0.0, 0), 0);
        system.acceleration(t + half, &self.q, &self.v, &mut self.a[1])?;
        self.stage(phase, half, (half * half, 0), 1);
        system.acceleration(t + half, &self.q, &self.v, &mut self.a[2])?;
        self.stage(phase, h, (half * h, 1), 2);
        system.acceleration(t + h, &self.q, &self.v, &mut self.a[3])?;
        self.increments(phase, h);
        self.remainder.add(phase, h, &self.q, &self.v)?;
        Ok(StepReport { evaluations: 4, ..StepReport::default() })
    }
}
