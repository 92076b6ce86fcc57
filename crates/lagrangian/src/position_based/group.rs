//! Constraints of one kind, and how they are projected.

use super::colouring::coloured_order;
use super::constraint::{ConstraintKind, PositionConstraint};
use super::error::PositionError;
use mechanics_core::tensor::Vec3;

/// How constraints answer to being violated. See the [module](super) page.
#[derive(Clone, Debug, PartialEq)]
pub enum Response {
    /// A part `stiffness` ∈ (0, 1] of the violation is removed at each projection.
    Classic {
        /// The part.
        stiffness: f64,
    },
    /// Springs with the energy ½C²/α: one compliance α ≥ 0 per constraint, in the constraint's unit squared per joule.
    Compliant {
        /// The compliances.
        compliance: Vec<f64>,
    },
}

impl Response {
    /// `count` constraints without compliance.
    pub fn rigid(count: usize) -> Self {
        Self::Compliant { compliance: vec![0.0; count] }
    }
}

/// Where a group stands at the end of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupReport {
    /// The group's name.
    pub name: String,
    /// What is left to solve, in the unit of C: the largest |C + α̃λ| of compliant constraints, |C| of classic ones; of one-sided
    /// constraints what is violated.
    pub residual: f64,
    /// Σ ½C²/α over the constraints with a compliance \[J\].
    pub energy: f64,
}

/// Constraints of any kind, as a step sees them.
pub trait Constraints: Send {
    /// Forgets the multipliers of the last step.
    fn begin_step(&mut self);

    /// Projects every constraint once. Answers how many were projected and how many passed over.
    fn sweep(&mut self, x: &mut [Vec3], inverse_masses: &[f64], h: f64) -> [u64; 2];

    /// Where the group stands.
    fn report(&self, x: &[Vec3], h: f64) -> GroupReport;

    /// Checks that every particle named exists.
    ///
    /// # Errors
    /// [`PositionError::ParticleOutOfRange`].
    fn check_particles(&self, particles: usize) -> Result<(), PositionError>;
}

/// Constraints of one kind with their particles.
#[derive(Clone, Debug)]
pub struct ConstraintGroup<C, const N: usize> {
    name: String,
    constraint: C,
    elements: Vec<[u32; N]>,
    response: Response,
    /// Colour after colour.
    order: Vec<u32>,
    /// λ of each constraint in this step.
    multipliers: Vec<f64>,
}

impl<C: PositionConstraint<N>, const N: usize> ConstraintGroup<C, N> {
    /// `constraint` number e acts on the particles `elements[e]`.
    ///
    /// # Errors
    /// A particle named twice by one constraint; a stiffness or compliance out of range, or not one per constraint.
    pub fn new(
        name: impl Into<String>,
        constraint: C,
        elements: Vec<[u32; N]>,
        response: Response,
    ) -> Result<Self, PositionError> {
        let name = name.into();
        check_response(&name, &response, elements.len())?;
        for (element, particles) in elements.iter().enumerate() {
            for (k, &particle) in particles.iter().enumerate() {
                if particles[..k].contains(&particle) {
                    return Err(PositionError::RepeatedParticle { group: name, element, particle });
                }
            }
        }
        let order = coloured_order(&elements);
        let multipliers = vec![0.0; elements.len()];
        Ok(Self { name, constraint, elements, response, order, multipliers })
    }

    /// The multipliers λ of the last step [J s²/unit of C]; λ/h² times ∇C is the force of a constraint.
    pub fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }

    /// The constraint family.
    pub fn constraint(&self) -> &C {
        &self.constraint
    }

    /// The particles of every constraint.
    pub fn elements(&self) -> &[[u32; N]] {
        &self.elements
    }

    /// Δλ, and what λ is after it.
    fn multiplier_change(&self, element: usize, value: f64, weight: f64, h: f64) -> f64 {
        let one_sided = self.constraint.kind() == ConstraintKind::AtLeastZero;
        match &self.response {
            Response::Classic { .. } if one_sided && value >= 0.0 => 0.0,
            Response::Classic { stiffness } => -stiffness * value / weight,
            Response::Compliant { compliance } => {
                let softness = compliance[element] / (h * h);
                let multiplier = self.multipliers[element];
                let change = -(value + softness * multiplier) / (weight + softness);
                // Not `max`, which would take −λ for a change that is no number.
                if one_sided && change < -multiplier { -multiplier } else { change }
            }
        }
    }
}

fn check_response(group: &str, response: &Response, expected: usize) -> Result<(), PositionError> {
    let group = group.to_owned();
    match response {
        Response::Classic { stiffness } if *stiffness > 0.0 && *stiffness <= 1.0 => Ok(()),
        Response::Classic { stiffness } => Err(PositionError::Stiffness { group, value: *stiffness }),
        Response::Compliant { compliance } if compliance.len() != expected => {
            Err(PositionError::ComplianceCount { group, found: compliance.len(), expected })
        }
        Response::Compliant { compliance } => {
            match compliance.iter().enumerate().find(|(_, a)| !(**a >= 0.0 && a.is_finite())) {
                Some((element, &value)) => Err(PositionError::Compliance { group, element, value }),
                None => Ok(()),
            }
        }
    }
}

impl<C: PositionConstraint<N>, const N: usize> Constraints for ConstraintGroup<C, N> {
    fn begin_step(&mut self) {
        self.multipliers.fill(0.0);
    }

    fn sweep(&mut self, x: &mut [Vec3], inverse_masses: &[f64], h: f64) -> [u64; 2] {
        let mut counts = [0, 0];
        for k in 0..self.order.len() {
            let element = self.order[k] as usize;
            let points = self.elements[element].map(|particle| particle as usize);
            let found = self.constraint.evaluate(element, &points.map(|i| x[i]));
            let weight = |gradient: &[Vec3; N]| -> f64 {
                points.iter().zip(gradient).map(|(&i, g)| inverse_masses[i] * g.norm_squared()).sum()
            };
            let Some((value, gradient, weight)) =
                // A weight that is no number is not passed over: the step finds it in the positions, and fails.
                found.map(|(c, g)| (c, g, weight(&g))).filter(|(.., weight)| *weight > 0.0 || weight.is_nan())
            else {
                counts[1] += 1;
                continue;
            };
            let change = self.multiplier_change(element, value, weight, h);
            self.multipliers[element] += change;
            for (&i, g) in points.iter().zip(&gradient) {
                x[i] += g * (inverse_masses[i] * change);
            }
            counts[0] += 1;
        }
        counts
    }

    fn report(&self, x: &[Vec3], h: f64) -> GroupReport {
        let (mut residual, mut energy) = (0.0_f64, 0.0);
        for (element, points) in self.elements.iter().enumerate() {
            let Some((value, _)) = self.constraint.evaluate(element, &points.map(|i| x[i as usize])) else {
                continue;
            };
            let compliance = match &self.response {
                Response::Classic { .. } => 0.0,
                Response::Compliant { compliance } => compliance[element],
            };
            let left = value + compliance / (h * h) * self.multipliers[element];
            let is_idle = self.constraint.kind() == ConstraintKind::AtLeastZero && value >= 0.0;
            if !is_idle {
                let left = if compliance == 0.0 { value } else { left };
                residual = if left.abs() <= residual { residual } else { left.abs() };
                energy += if compliance > 0.0 { 0.5 * value * value / compliance } else { 0.0 };
            }
        }
        GroupReport { name: self.name.clone(), residual, energy }
    }

    fn check_particles(&self, particles: usize) -> Result<(), PositionError> {
        for (element, points) in self.elements.iter().enumerate() {
            if let Some(&particle) = points.iter().find(|point| **point as usize >= particles) {
                let group = self.name.clone();
                return Err(PositionError::ParticleOutOfRange { group, element, particle, particles });
            }
        }
        Ok(())
    }
}
