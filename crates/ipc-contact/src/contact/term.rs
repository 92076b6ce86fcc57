//! [`BarrierContact`] as a [`Potential`].

use super::{BarrierContact, NAME, detection};
use crate::collision_mesh::Feature;
use crate::error::ContactError;
use mechanics_core::potential::{Changed, Demand, Potential, PotentialError, StepLimit};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::{Moment, Stage};
use mechanics_core::tensor::Vec3;

impl From<ContactError> for PotentialError {
    fn from(error: ContactError) -> Self {
        Self::Term { term: NAME.to_owned(), source: Box::new(error) }
    }
}

impl Potential for BarrierContact {
    fn name(&self) -> &str {
        NAME
    }

    /// κ Σ w m b \[J\]; +∞ at and within the minimum separation, NaN if a position is not finite.
    fn value(&self, x: &[Vec3]) -> f64 {
        match self.active_at(x) {
            Ok(active) => active.value(self.law(), x),
            Err(_) => f64::NAN,
        }
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        assert_eq!(gradient.len(), x.len(), "one gradient per point");
        match self.active_at(x) {
            Ok(active) => active.add_gradient(self.law(), x, gradient),
            Err(_) => gradient.iter_mut().for_each(|g| g.fill(f64::NAN)),
        }
    }

    /// Five lists, always: points and half-spaces, two points, points and edges, points and triangles, two edges. All are empty if a
    /// position is not finite; value and gradient are NaN there, so that no minimiser gets this far.
    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        let active = self.active_at(x).unwrap_or_default();
        active.add_hessian(self.law(), x, projection, hessian);
    }

    /// Admits the positions. At the start of a step counts begin anew; before an iteration κ may grow.
    ///
    /// # Errors
    /// [`ContactError::Intersecting`] or [`ContactError::TooClose`] lists the pairs that meet at `x`, unless `x` is known to be free of
    /// such; [`ContactError::NonFinite`] and [`ContactError::TooFar`] name a point, [`ContactError::EnergyOverflow`] pairs.
    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        if stage.moment == Moment::Step {
            self.begin_report();
        }
        self.admit(stage.x)?;
        match stage.moment {
            Moment::Step => Ok(self.adaptation.begin_step(stage.x)),
            Moment::Lag | Moment::Settling => Ok(Changed::Nothing),
            Moment::Iteration if self.options.stiffness.growth.is_none() => Ok(Changed::Nothing),
            Moment::Iteration => {
                let gap = self.smallest_gap(stage.x)?;
                Ok(self.adaptation.begin_iteration(gap))
            }
        }
    }

    /// The part of the step that is certainly free. The element is a point of the pair that limits it;
    /// [`ContactReport::limiting_pair`](super::ContactReport::limiting_pair) names the whole pair.
    ///
    /// # Errors
    /// As [`freeze`](Potential::freeze), for `x`; and if the step's end is not finite.
    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        assert_eq!(p.len(), x.len(), "one displacement per point");
        if !x.iter().zip(p).all(|(x, p)| (x + p).norm_squared().is_finite()) {
            return Err(detection::non_finite(x, p).into());
        }
        self.admit(x)?;
        let Self { detector, neighbourhood, mesh, guard, .. } = self;
        let limit = detector.limit(mesh, neighbourhood, x, p)?;
        guard.clear(x, p, limit.fraction);
        let Some(culprit) = limit.culprit else {
            return Ok(StepLimit { fraction: limit.fraction, element: None });
        };
        self.limiting_pair = Some(culprit.features);
        let point = culprit.features.iter().find_map(|feature| match *feature {
            Feature::Point(point) => Some(point),
            Feature::Edge(edge) => Some(self.mesh.edges()[edge as usize][0]),
            Feature::Triangle(_) | Feature::HalfSpace(_) => None,
        });
        Ok(StepLimit { fraction: limit.fraction, element: point.map(|point| point as usize) })
    }

    /// No as long as `p` changes a gap below 1 % of the activation distance by more than a tenth of itself.
    ///
    /// Where the gap g of a pair is far below the one at which its force balances the others, that force is of the form c/g and all that
    /// counts: Newton's direction is g, so that every iteration doubles the gap. It may be 1e-15 m, and no tolerance of a velocity
    /// would find such a direction long; but the force is too large by orders of magnitude. Near the balance at g* the direction is
    /// g (1 − g/g*) for one pair against a constant force, so that a gap that is left is within about a tenth of the balanced one.
    fn is_settled(&self, x: &[Vec3], p: &[Vec3]) -> bool {
        self.active_at(x).is_ok_and(|active| self.keeps_squeezed_gaps(&active, x, p))
    }

    fn demand(&self) -> Demand {
        Demand::EndPositions
    }

    /// The number of the pair among [`normal_forces`](BarrierContact::normal_forces) at `x`.
    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        let forces = self.normal_forces(x);
        let pull = |(number, force): (usize, &crate::normal_force::NormalForce)| {
            let own = force.forces().find(|(other, _)| *other as usize == point)?;
            Some((number, own.1.norm()))
        };
        let pulls = forces.iter().enumerate().filter_map(pull);
        pulls.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(number, _)| number)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        self.check_separation(x).err().map(PotentialError::from)
    }
}
