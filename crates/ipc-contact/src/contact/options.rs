//! What contact is to be like.

use crate::barrier::{Barrier, DistanceBarrier, MinimumSeparation, PhysicalBarrier, SquaredDistanceBarrier};
use crate::ccd::Detection;
use crate::contact_set::Weighting;
use crate::error::ContactError;
use crate::pair::Curvature;
use crate::stiffness::Stiffness;

/// The form of the barrier; see [`crate::barrier`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BarrierForm {
    /// b = −(s − ŝ)² ln(s/ŝ) of the squared distance s; κ in N/m³.
    #[default]
    SquaredDistance,
    /// b = −(d − d̂)² ln(d/d̂); κ in N/m.
    Distance,
    /// b = −d̂ (s/ŝ − 1)² ln(s/ŝ); κ in Pa with area weights, in N/m without.
    Physical,
}

impl BarrierForm {
    /// The barrier that is active below d̂ and infinite at d_min.
    pub(super) fn barrier(
        self,
        activation_distance: f64,
        minimum_separation: f64,
    ) -> Result<Box<dyn Barrier>, ContactError> {
        Ok(match self {
            Self::SquaredDistance => Box::new(MinimumSeparation::new(
                SquaredDistanceBarrier::new(activation_distance)?,
                minimum_separation,
            )?),
            Self::Distance => Box::new(MinimumSeparation::new(
                DistanceBarrier::new(activation_distance)?,
                minimum_separation,
            )?),
            Self::Physical => Box::new(MinimumSeparation::new(
                PhysicalBarrier::new(activation_distance)?,
                minimum_separation,
            )?),
        })
    }
}

/// What contact is to be like: [`ContactOptions::new`] and what differs from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactOptions {
    /// d̂: contact acts below this gap (distance less minimum separation) \[m\].
    pub activation_distance: f64,
    /// d_min: the distance that is never reached \[m\]; a thickness that is there but not meshed. Zero unless said.
    pub minimum_separation: f64,
    /// κ.
    pub stiffness: Stiffness,
    /// What a pair counts.
    pub weighting: Weighting,
    /// The form of the barrier.
    pub form: BarrierForm,
    /// Which Hessian is projected.
    pub curvature: Curvature,
    /// How contact on the way is detected.
    pub detection: Detection,
    /// A step of the minimiser leaves every pair this part of its gap, or half of d̂ where that is less. In (0, 1); 0.1
    /// unless said.
    pub kept_gap: f64,
}

impl ContactOptions {
    /// Contact below the gap `activation_distance` \[m\], else as the fields say.
    pub fn new(activation_distance: f64, stiffness: Stiffness) -> Self {
        Self {
            activation_distance,
            minimum_separation: 0.0,
            stiffness,
            weighting: Weighting::default(),
            form: BarrierForm::default(),
            curvature: Curvature::default(),
            detection: Detection::default(),
            kept_gap: 0.1,
        }
    }

    /// Checks the ranges of all numbers.
    ///
    /// # Errors
    /// The first that is out of range.
    pub fn validate(&self) -> Result<(), ContactError> {
        self.stiffness.validate()?;
        self.form.barrier(self.activation_distance, self.minimum_separation)?;
        if !(self.kept_gap > 0.0 && self.kept_gap < 1.0) {
            return Err(ContactError::KeptGap { value: self.kept_gap });
        }
        Ok(())
    }
}
