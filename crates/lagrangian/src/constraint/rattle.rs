//! RATTLE: symplectic steps on the constraints.

mod composition;
mod general;
mod separable;
mod track;

pub use composition::Composition;

use super::constrained::Constrained;
use super::{ConstraintSet, Motion};
use crate::coordinates::{Coordinates, Phase};
use crate::error::LagrangianError;
use crate::integrator::{Cost, Integrator, Method, StepReport, Structure};
use crate::system::System;
use track::{Substep, Track};

/// RATTLE, and its symmetric compositions of higher order: symplectic on the constrained phase space, time-reversible,
/// with φ(q, t) = 0 and G v + ∂φ/∂t = 0 to rounding after every step.
///
/// One step of order 2 from (q₀, p₀ = ∂L/∂v) to (q₁, p₁), v_a, v_b being the velocities of p½ at q₀ and at q₁, F the
/// applied forces, f = ∂L/∂q + F, and G₀ = G(q₀, t₀), G₁ = G(q₁, t₁):
///
/// ```text
/// p½ = p₀ + h/2 (f(t₀, q₀, v_a) + G₀ᵀ λ⁺),    p½ = ∂L/∂v(t₀, q₀, v_a) = ∂L/∂v(t₁, q₁, v_b),
/// q₁ = q₀ + h/2 (v_a + v_b),                  φ(q₁, t₁) = 0,
/// p₁ = p½ + h/2 (f(t₁, q₁, v_b) + G₁ᵀ λ⁻),    G₁ v₁ + ∂φ/∂t = 0.
/// ```
///
/// It is the partitioned Lobatto IIIA–IIIB pair of two stages. Where T is a quadratic form in v with constant
/// coefficients and nothing but a potential acts, v_a = v_b and the step is Andersen's: one evaluation of the forces,
/// and Newton's method on K equations for λ⁺ (λ⁻ is linear). Elsewhere Newton's method solves for (v_a, v_b, λ⁺), by
/// elimination to N×N and K×K systems. [`System::dependence`] decides which. With dissipation or applied forces the step keeps its order and the constraints,
/// not the symplectic form.
///
/// SHAKE is not here: it gives the same positions and velocities that are not tangent to the constraints.
///
/// # Multipliers
/// λ⁺ and λ⁻ differ from λ(t₀) and λ(t₁) by O(h), with opposite errors; their mean is the reaction of the step, with
/// ∫λ dt over any time right to the order of the method ([`Reaction`]). λ at a state, to the order of that state, is
/// [`Constrained::motion`]'s.
///
/// # Cost
/// Where sizes are known to the compiler, all matrices are full and loops unroll. At run-time sizes leading zeros and
/// bands are used: a chain's M and G M⁻¹ Gᵀ are factored, and its G differentiated, in time linear in the number of
/// links; what remains quadratic is looking for overlaps of constraints and the N×N matrices that a [`System`] fills.
/// A framework whose constraints couple everything costs O(K³), the general form O(N³).
///
/// # History
/// The rounding errors of the sums q + Δq (and, in Andersen's form, v + Δv), the forces and G at the last state,
/// start values for Newton's method, and which form the system needs; in Andersen's form the masses too. A system
/// whose parameters change between steps, or another one, is not noticed: it wants a new `Rattle`.
///
/// # Reference
/// Andersen 1983, *Rattle: a "velocity" version of the Shake algorithm*; Jay 1996, *Symplectic partitioned Runge–Kutta
/// methods for constrained Hamiltonian systems*; Hairer, Lubich & Wanner 2006, *Geometric Numerical Integration*,
/// VII.1, equations (1.19) and (1.26); compensated sums: VIII.5.
#[derive(Clone, Debug)]
pub struct Rattle<C: ConstraintSet> {
    constraints: C,
    composition: Composition,
    course: Option<Course<C>>,
}

/// Multipliers of the last step.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction<M> {
    /// λ⁺: at the start of the step, to order 1.
    pub first: M,
    /// λ⁻: at its end, to order 1.
    pub last: M,
    /// The mean over the step, (1/h) ∫λ dt, to the order of the method; for the middle of the step to order 2.
    pub mean: M,
}

/// Which form of the step a system needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// Constant masses and a potential: explicit but for λ.
    Separable,
    /// Anything else, and whether one iteration gives v from p.
    General { quadratic: Quadratic },
}

/// Whether ∂L/∂v is linear in v.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quadratic {
    Yes,
    Unknown,
}

/// A run from one fresh start on.
#[derive(Clone, Debug)]
struct Course<C: ConstraintSet> {
    form: Form,
    /// What the last step has left, and the step under way, which takes its place if it succeeds.
    tracks: [Track<C>; 2],
    /// The index of the former.
    left: usize,
    separable: separable::Workspace<C>,
    general: Option<Box<general::Workspace<C>>>,
    reaction: Reaction<C::Multipliers>,
}

impl<C: ConstraintSet> Rattle<C> {
    /// Order 2.
    pub fn new(constraints: C) -> Self {
        Self::composed(constraints, Composition::Second)
    }

    /// Steps of order 2 composed to one of higher order.
    pub fn composed(constraints: C, composition: Composition) -> Self {
        Self { constraints, composition, course: None }
    }

    /// The constraints.
    pub fn constraints(&self) -> &C {
        &self.constraints
    }

    /// The multipliers of the last step, if there was one.
    pub fn reaction(&self) -> Option<&Reaction<C::Multipliers>> {
        self.course.as_ref().map(|course| &course.reaction)
    }
}

impl<S: System, C: ConstraintSet<Coordinates = S::Coordinates>> Integrator<S> for Rattle<C> {
    fn method(&self) -> Method {
        let factors = self.composition.factors().len() as u32;
        Method {
            name: self.composition.name(),
            order: self.composition.order(),
            structure: Structure::Symplectic,
            cost: Cost::Implicit { stages: 2 * factors },
        }
    }

    fn step(
        &mut self,
        system: &S,
        phase: &mut Phase<C::Coordinates>,
        h: f64,
    ) -> Result<StepReport, LagrangianError> {
        if !(h > 0.0 && h.is_finite()) {
            return Err(LagrangianError::Step { step: h });
        }
        let factors = self.composition.factors();
        match self.course.as_mut().filter(|course| phase.continues(&course.tracks[course.left].phase, h)) {
            Some(course) => course.advance(system, &self.constraints, phase, factors, h),
            None => {
                let mut course = Course::start(system, &self.constraints, phase)?;
                let report = course.advance(system, &self.constraints, phase, factors, h)?;
                self.course = Some(course);
                Ok(report)
            }
        }
    }
}

impl<C: ConstraintSet> Course<C> {
    fn start<S: System<Coordinates = C::Coordinates>>(
        system: &S,
        constraints: &C,
        phase: &Phase<C::Coordinates>,
    ) -> Result<Self, LagrangianError> {
        let constrained = Constrained::new(system, constraints);
        constrained.check(phase)?;
        let Motion { acceleration, multipliers } = constrained.motion(phase)?;
        let form = form(system, phase);
        let mut separable = separable::Workspace::new(constraints);
        let trial = Track::new(constraints, phase, acceleration.clone(), multipliers.clone());
        let mut track = Track::new(constraints, phase, acceleration, multipliers.clone());
        constraints.expand(phase.time, &phase.q, &mut separable.at);
        track.jacobian.clone_from(&separable.at.jacobian);
        let general = match form {
            Form::Separable => {
                separable.start(system, constraints, &mut track)?;
                None
            }
            Form::General { .. } => Some(Box::new(general::Workspace::new(constraints))),
        };
        let zero = C::Multipliers::zeros(constraints.count());
        let reaction = Reaction { first: zero.clone(), last: multipliers, mean: zero };
        Ok(Self { form, tracks: [track, trial], left: 0, separable, general, reaction })
    }

    /// Takes the sub-steps on `trial`, and only then touches anything else.
    fn advance<S: System<Coordinates = C::Coordinates>>(
        &mut self,
        system: &S,
        constraints: &C,
        phase: &mut Phase<C::Coordinates>,
        factors: &[f64],
        h: f64,
    ) -> Result<StepReport, LagrangianError> {
        let mut report = StepReport::default();
        let (start, end) = (phase.time, phase.time + h);
        let [one, other] = &mut self.tracks;
        let (left, trial) = if self.left == 0 { (one, other) } else { (other, one) };
        trial.copy_from(left, constraints, &self.separable.compliance);
        trial.phase.time = start;
        let mut mean = C::Multipliers::zeros(constraints.count());
        let mut first = None;
        let mut passed = 0.0;
        for (i, factor) in factors.iter().enumerate() {
            passed += factor;
            let end = if i + 1 == factors.len() { end } else { start + passed * h };
            let step = Substep { h: factor * h, end };
            match (self.form, self.general.as_mut()) {
                (Form::General { quadratic }, Some(work)) => {
                    work.step(system, constraints, trial, step, quadratic, &mut report)?;
                }
                _ => self.separable.step(system, constraints, trial, step, &mut report)?,
            }
            for (k, mean) in mean.as_mut().iter_mut().enumerate() {
                *mean += 0.5 * factor * (trial.first[0].as_ref()[k] + trial.last.as_ref()[k]);
            }
            if i == 0 {
                first = Some(trial.first[0].clone());
            }
        }
        phase.time = trial.phase.time;
        phase.q.clone_from(&trial.phase.q);
        phase.v.clone_from(&trial.phase.v);
        self.reaction.first.clone_from(first.as_ref().unwrap_or(&trial.first[0]));
        self.reaction.last.clone_from(&trial.last);
        self.reaction.mean = mean;
        self.left = 1 - self.left;
        Ok(report)
    }
}

fn form<S: System>(system: &S, phase: &Phase<S::Coordinates>) -> Form {
    let on = system.dependence(phase.time, &phase.q, &phase.v);
    let constant_mass = on.kinetic_quadratic && !on.kinetic_on_time && !on.kinetic_on_q.contains(&true);
    match (constant_mass && !on.applied(), on.kinetic_quadratic) {
        (true, _) => Form::Separable,
        (false, true) => Form::General { quadratic: Quadratic::Yes },
        (false, false) => Form::General { quadratic: Quadratic::Unknown },
    }
}
