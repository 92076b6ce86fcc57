//! One state against the constraints: check, projection, acceleration and reaction.

use super::compliance::{Compliance, Met, largest, measure, multiply_into};
use super::{ConstraintExpansion, ConstraintSet, ExpansionOf, Rows};
use crate::coordinates::{Coordinates, Phase};
use crate::error::{ConstraintLevel, LagrangianError, Symbol};
use crate::system::{Expansion, System};

/// A system and the constraints on it, for questions at one state.
///
/// It is not itself a [`System`]: a method that read its energies alone would leave the constraints in silence.
#[derive(Clone, Copy, Debug)]
pub struct Constrained<'a, S, C> {
    system: &'a S,
    constraints: &'a C,
}

/// Acceleration and reaction at one state.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion<Q, M> {
    /// q̈.
    pub acceleration: Q,
    /// λ, so that the reaction is +Gᵀλ beside the applied forces.
    pub multipliers: M,
}

/// What a start may be off by: [`Constrained::check`]. The floors carry a constraint's unit, so they are as low as
/// rounding of starts at q = 0 and at rest allows.
const START: f64 = 1e-9;
const POSITION_FLOOR: f64 = 16.0 * f64::EPSILON;
const VELOCITY_FLOOR: f64 = 1e-12;
/// Iterations of one return to the constraints, and of the search for the nearest point.
const RETURNS: u32 = 50;
const SEARCHES: u32 = 1000;
/// Corrections up to this part of the coordinates are shorter than radii of curvature: one search is enough.
const NEAR: f64 = 1e-2;
/// How far beside the first point the second search begins, in terms of its distance.
const ASIDE: f64 = 1e-2;

impl<'a, S: System, C: ConstraintSet<Coordinates = S::Coordinates>> Constrained<'a, S, C> {
    /// `system` under `constraints`.
    ///
    /// # Panics
    /// If the two differ in the number of coordinates.
    pub fn new(system: &'a S, constraints: &'a C) -> Self {
        assert_eq!(system.dimension(), constraints.dimension(), "constraints on the system's coordinates");
        Self { system, constraints }
    }

    /// Refuses a state that is not on the constraints: |φₖ| ≤ 1e-9 ‖∇φₖ‖₁ ‖q‖∞ + 16 ε and
    /// |∇φₖ·v + ∂φₖ/∂t| ≤ 1e-9 (‖∇φₖ‖₁ ‖v‖∞ + |∂φₖ/∂t|) + 1e-12, the last terms in the constraint's units.
    ///
    /// # Errors
    /// [`LagrangianError::ConstraintViolated`] names the worst constraint, positions before velocities;
    /// [`LagrangianError::NonFinite`].
    pub fn check(&self, phase: &Phase<C::Coordinates>) -> Result<(), LagrangianError> {
        phase.validate()?;
        let mut at = ConstraintExpansion::zeros(self.constraints.shape());
        self.constraints.expand(phase.time, &phase.q, &mut at);
        self.check_expanded(phase, &at)
    }

    pub(super) fn check_expanded(
        &self,
        phase: &Phase<C::Coordinates>,
        at: &ExpansionOf<C>,
    ) -> Result<(), LagrangianError> {
        let (n, count) = self.constraints.shape();
        let slope = |k: usize| at.jacobian.entries()[k * n..(k + 1) * n].iter().map(|g| g.abs()).sum::<f64>();
        let (value, rate) = (at.value.as_ref(), at.rate.as_ref());
        let position = |k: usize| {
            (
                value[k],
                START * slope(k) * largest(phase.q.as_ref()) + POSITION_FLOOR,
                ConstraintLevel::Position,
            )
        };
        let mut speed = C::Multipliers::zeros(count);
        multiply_into(self.constraints, &at.jacobian, phase.v.as_ref(), speed.as_mut());
        let velocity = |k: usize| {
            let tolerance = START * (slope(k) * largest(phase.v.as_ref()) + rate[k].abs()) + VELOCITY_FLOOR;
            (speed.as_ref()[k] + rate[k], tolerance, ConstraintLevel::Velocity)
        };
        refuse_worst(phase.time, (0..count).map(position))?;
        refuse_worst(phase.time, (0..count).map(velocity))
    }

    /// q̈ and λ at a state on the constraints, pointwise and not over a step: of M q̈ = f + Gᵀλ and φ̈ = G q̈ + γ = 0,
    /// with f = ∂L/∂q + Q − ∂R/∂v − D ∂L/∂v and γ = v·φ_qq·v + 2 φ_qt·v + φ_tt,
    ///
    /// (G M⁻¹ Gᵀ) λ = −γ − G M⁻¹ f,  q̈ = M⁻¹(f + Gᵀλ).
    ///
    /// Fed with a state of an integrator of order p, λ has that order too.
    ///
    /// # Errors
    /// [`LagrangianError::SingularMass`], [`LagrangianError::RedundantConstraint`], [`LagrangianError::NonFinite`].
    pub fn motion(
        &self,
        phase: &Phase<C::Coordinates>,
    ) -> Result<Motion<C::Coordinates, C::Multipliers>, LagrangianError> {
        phase.validate()?;
        let (n, count) = self.constraints.shape();
        let mut dynamics = Expansion::zeros(n);
        self.system.expand(phase.time, &phase.q, &phase.v, &mut dynamics);
        let mut at = ConstraintExpansion::zeros(self.constraints.shape());
        self.constraints.expand(phase.time, &phase.q, &mut at);

        let mut compliance = Compliance::new(self.constraints);
        let mut response = C::Jacobian::zeros(count, n);
        compliance.hold_mass(phase.time, &dynamics.mass, n)?;
        compliance.hold_jacobian(phase.time, self.constraints, &at.jacobian, &mut response)?;

        let mut acceleration = dynamics.slope;
        for (i, a) in acceleration.as_mut().iter_mut().enumerate() {
            *a += dynamics.applied.as_ref()[i] - dynamics.momentum_rate.as_ref()[i];
        }
        compliance.divide_by_mass(acceleration.as_mut());

        let mut multipliers = C::Multipliers::zeros(count);
        let mut curving = C::Multipliers::zeros(count);
        self.constraints.curve(phase.time, &phase.q, &phase.v, &mut curving);
        multiply_into(self.constraints, &at.jacobian, acceleration.as_ref(), multipliers.as_mut());
        for (l, c) in multipliers.as_mut().iter_mut().zip(curving.as_ref()) {
            *l = -(*l + c);
        }
        compliance.divide_by_compliance(multipliers.as_mut());
        compliance.add_responses(self.constraints, &response, multipliers.as_ref(), acceleration.as_mut());
        refuse_nonfinite(phase.time, Symbol::Acceleration, acceleration.as_ref())?;
        refuse_nonfinite(phase.time, Symbol::Constraint, multipliers.as_ref())?;
        Ok(Motion { acceleration, multipliers })
    }

    /// Brings a state onto the constraints: q becomes the nearest point with φ = 0 (a local minimum of
    /// ½ (q − q̂)ᵀ M (q − q̂), M taken at q̂), then v the nearest velocity with G v + ∂φ/∂t = 0, in the same metric
    /// with M at the new q. A state that is on them to rounding does not move by more than rounding.
    ///
    /// From further away than radii of curvature there are several local minima, and which of them is found is not
    /// promised. Stationary points that are no minima, which symmetric starts lead to, are left: a second search
    /// begins beside the first point, and the nearer of both counts.
    ///
    /// Positions: Newton returns to φ = 0 along M⁻¹Gᵀ; then steps −τ, τ the part of q − q̂ tangent to the constraints,
    /// each followed by a return, and halved while the distance grows, until τ vanishes (‖τ‖∞ ≤ 1e-12 ‖q − q̂‖∞). Near
    /// the constraints (compared with their radii of curvature) that takes two or three steps.
    ///
    /// # Errors
    /// [`LagrangianError::NotConverged`] if there is no way back to φ = 0,
    /// [`LagrangianError::RedundantConstraint`] where gradients vanish or depend on each other,
    /// [`LagrangianError::SingularMass`], [`LagrangianError::NonFinite`]. The phase is then as it was.
    pub fn project(&self, phase: &mut Phase<C::Coordinates>) -> Result<(), LagrangianError> {
        phase.validate()?;
        let n = self.constraints.dimension();
        let mut projection = Projection::new(self.constraints, phase.time);
        let mut dynamics = Expansion::zeros(n);
        self.system.expand(phase.time, &phase.q, &phase.v, &mut dynamics);
        projection.compliance.hold_mass(phase.time, &dynamics.mass, n)?;
        let mass = C::Coordinates::entries(&dynamics.mass).to_vec();
        let q = projection.nearest(&phase.q, &mass)?;

        self.system.expand(phase.time, &q, &phase.v, &mut dynamics);
        projection.compliance.hold_mass(phase.time, &dynamics.mass, n)?;
        let mut v = phase.v.clone();
        projection.expand(&q)?;
        projection.remove_normal_part(Shift::WithRate, v.as_mut());
        refuse_nonfinite(phase.time, Symbol::Velocity, v.as_ref())?;
        phase.q = q;
        phase.v = v;
        Ok(())
    }
}

/// Whether the surface moves under the vector that is projected.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shift {
    /// Displacements at one time: G x = 0.
    Fixed,
    /// Velocities: G x + ∂φ/∂t = 0.
    WithRate,
}

/// The surface φ(·, t) = 0 at one time in the metric of one mass matrix.
struct Projection<'a, C: ConstraintSet> {
    constraints: &'a C,
    time: f64,
    compliance: Compliance<C>,
    at: ExpansionOf<C>,
    response: C::Jacobian,
    iterations: u32,
}

impl<'a, C: ConstraintSet> Projection<'a, C> {
    fn new(constraints: &'a C, time: f64) -> Self {
        let (n, count) = constraints.shape();
        Self {
            constraints,
            time,
            compliance: Compliance::new(constraints),
            at: ConstraintExpansion::zeros(constraints.shape()),
            response: C::Jacobian::zeros(count, n),
            iterations: 0,
        }
    }

    fn expand(&mut self, q: &C::Coordinates) -> Result<(), LagrangianError> {
        self.constraints.expand(self.time, q, &mut self.at);
        self.compliance.hold_jacobian(self.time, self.constraints, &self.at.jacobian, &mut self.response)
    }

    /// x −= M⁻¹Gᵀ (G M⁻¹ Gᵀ)⁻¹ (G x + shift).
    fn remove_normal_part(&self, shift: Shift, x: &mut [f64]) {
        let mut normal = C::Multipliers::zeros(self.constraints.count());
        multiply_into(self.constraints, &self.at.jacobian, x, normal.as_mut());
        for (normal, rate) in normal.as_mut().iter_mut().zip(self.at.rate.as_ref()) {
            *normal = -*normal - if shift == Shift::WithRate { *rate } else { 0.0 };
        }
        self.compliance.divide_by_compliance(normal.as_mut());
        self.compliance.add_responses(self.constraints, &self.response, normal.as_ref(), x);
    }

    /// Newton's method along M⁻¹Gᵀ until φ is zero to rounding; leaves the expansion at the result.
    fn bring_back(&mut self, q: &mut C::Coordinates) -> Result<(), LagrangianError> {
        let mut previous = f64::INFINITY;
        for _ in 0..RETURNS {
            self.iterations += 1;
            self.expand(q)?;
            let (met, now) = measure(self.constraints, self.at.value.as_ref(), &self.at.jacobian, q.as_ref());
            if met == Met::Tight || (met == Met::Loose && now > 0.5 * previous) {
                return Ok(());
            }
            previous = now;
            let mut step = self.at.value.clone();
            step.as_mut().iter_mut().for_each(|x| *x = -*x);
            self.compliance.divide_by_compliance(step.as_mut());
            self.compliance.add_responses(self.constraints, &self.response, step.as_ref(), q.as_mut());
        }
        Err(self.not_converged(previous))
    }

    fn nearest(&mut self, target: &C::Coordinates, mass: &[f64]) -> Result<C::Coordinates, LagrangianError> {
        let found = self.approach(target.clone(), target, mass)?;
        let mut beside = found.clone();
        subtract(beside.as_mut(), target.as_ref());
        let gap = largest(beside.as_ref());
        if gap <= NEAR * largest(found.as_ref()) {
            return Ok(found);
        }
        for (i, (x, q)) in beside.as_mut().iter_mut().zip(found.as_ref()).enumerate() {
            // Fractions of multiples of the golden ratio: no direction that a symmetry prefers.
            let offset = (0.618_033_988_75 * (i + 1) as f64).fract() - 0.35;
            *x = q + ASIDE * gap * offset;
        }
        match self.approach(beside, target, mass) {
            Ok(other) if distance(&other, target, mass) < (1.0 - 1e-6) * distance(&found, target, mass) => {
                Ok(other)
            }
            _ => Ok(found),
        }
    }

    /// From `q` to a point where q − `target` has no tangent part.
    fn approach(
        &mut self,
        mut q: C::Coordinates,
        target: &C::Coordinates,
        mass: &[f64],
    ) -> Result<C::Coordinates, LagrangianError> {
        self.bring_back(&mut q)?;
        let (mut distance, mut length, mut last) = (distance(&q, target, mass), 1.0, f64::INFINITY);
        for _ in 0..SEARCHES {
            let mut tangent = q.clone();
            subtract(tangent.as_mut(), target.as_ref());
            let gap = largest(tangent.as_ref());
            self.remove_normal_part(Shift::Fixed, tangent.as_mut());
            last = largest(tangent.as_ref());
            if last <= 1e-12 * gap + 8.0 * f64::EPSILON * largest(q.as_ref()) {
                return Ok(q);
            }
            let mut trial = q.clone();
            for (x, t) in trial.as_mut().iter_mut().zip(tangent.as_ref()) {
                *x -= length * t;
            }
            let arrived = self.bring_back(&mut trial).is_ok();
            let now = self::distance(&trial, target, mass);
            if arrived && now <= distance * (1.0 + 8.0 * f64::EPSILON) {
                (q, distance) = (trial, now);
            } else {
                length *= 0.5;
                self.expand(&q)?;
            }
        }
        Err(self.not_converged(last))
    }

    fn not_converged(&self, correction: f64) -> LagrangianError {
        LagrangianError::NotConverged {
            method: "projection onto constraints",
            time: self.time,
            step: 0.0,
            iterations: self.iterations,
            correction,
            tolerance: 1e-12,
        }
    }
}

/// (a − b)ᵀ M (a − b).
fn distance<C: Coordinates>(a: &C, b: &C, mass: &[f64]) -> f64 {
    let mut gap = a.clone();
    subtract(gap.as_mut(), b.as_ref());
    let gap = gap.as_ref();
    let row = |i: usize| mass[i * gap.len()..].iter().zip(gap).map(|(m, x)| m * x).sum::<f64>();
    gap.iter().enumerate().map(|(i, x)| x * row(i)).sum()
}

fn subtract(a: &mut [f64], b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a -= b);
}

/// Refuses the largest of (value, tolerance, level) that is above its tolerance.
fn refuse_worst(
    time: f64,
    found: impl Iterator<Item = (f64, f64, ConstraintLevel)>,
) -> Result<(), LagrangianError> {
    let mut worst: Option<(f64, LagrangianError)> = None;
    for (index, (value, tolerance, level)) in found.enumerate() {
        if !value.is_finite() {
            return Err(LagrangianError::NonFinite { symbol: Symbol::Constraint, index, value, time });
        }
        let excess = value.abs() / tolerance;
        if excess > 1.0 && worst.as_ref().is_none_or(|(most, _)| excess > *most) {
            let error = LagrangianError::ConstraintViolated { level, index, value, tolerance, time };
            worst = Some((excess, error));
        }
    }
    worst.map_or(Ok(()), |(_, error)| Err(error))
}

#[inline]
pub(super) fn refuse_nonfinite(time: f64, symbol: Symbol, values: &[f64]) -> Result<(), LagrangianError> {
    for (index, &value) in values.iter().enumerate() {
        if !value.is_finite() {
            return Err(LagrangianError::NonFinite { symbol, index, value, time });
        }
    }
    Ok(())
}
