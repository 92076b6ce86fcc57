//! Contact of a world: with friction, or without anything of it.

use crate::experiment::ExperimentError;
use ipc_contact::contact::BarrierContact;
use ipc_friction::{ContactWithFriction, FrictionOptions};
use mechanics_core::potential::{Changed, Demand, Potential, PotentialError, StepLimit};
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembler;
use mechanics_core::stage::Stage;
use mechanics_core::tensor::Vec3;
use std::ops::Deref;

/// Contact, with friction where a scene names it. What can be read of contact can be read of both.
#[allow(clippy::large_enum_variant, reason = "a world has one")]
pub(in crate::experiment) enum ContactTerm {
    /// Nothing of friction is there.
    Frictionless(BarrierContact),
    /// Contact and friction as one term.
    WithFriction(ContactWithFriction),
}

impl ContactTerm {
    /// `contact`, with friction if there are options for it.
    pub(in crate::experiment) fn new(
        contact: BarrierContact,
        friction: Option<FrictionOptions>,
    ) -> Result<Self, ExperimentError> {
        match friction {
            None => Ok(Self::Frictionless(contact)),
            Some(options) => ContactWithFriction::new(contact, options)
                .map(Self::WithFriction)
                .map_err(ExperimentError::stopped),
        }
    }

    /// Contact with friction, where there is friction.
    pub(in crate::experiment) fn friction(&self) -> Option<&ContactWithFriction> {
        match self {
            Self::Frictionless(_) => None,
            Self::WithFriction(both) => Some(both),
        }
    }

    fn term(&self) -> &dyn Potential {
        match self {
            Self::Frictionless(contact) => contact,
            Self::WithFriction(both) => both,
        }
    }

    fn term_mut(&mut self) -> &mut dyn Potential {
        match self {
            Self::Frictionless(contact) => contact,
            Self::WithFriction(both) => both,
        }
    }
}

impl Deref for ContactTerm {
    type Target = BarrierContact;

    fn deref(&self) -> &BarrierContact {
        match self {
            Self::Frictionless(contact) => contact,
            Self::WithFriction(both) => both.contact(),
        }
    }
}

impl Potential for ContactTerm {
    fn name(&self) -> &str {
        self.term().name()
    }

    fn value(&self, x: &[Vec3]) -> f64 {
        self.term().value(x)
    }

    fn add_gradient(&self, x: &[Vec3], gradient: &mut [Vec3]) {
        self.term().add_gradient(x, gradient);
    }

    fn add_settled_gradient(&self, stage: &Stage<'_>, gradient: &mut [Vec3]) {
        self.term().add_settled_gradient(stage, gradient);
    }

    fn add_hessian(&self, x: &[Vec3], projection: Projection, hessian: &mut Assembler<'_>) {
        self.term().add_hessian(x, projection, hessian);
    }

    fn soften(&mut self, velocity: f64) {
        self.term_mut().soften(velocity);
    }

    fn freeze(&mut self, stage: &Stage<'_>) -> Result<Changed, PotentialError> {
        self.term_mut().freeze(stage)
    }

    fn limit_step(&mut self, x: &[Vec3], p: &[Vec3]) -> Result<StepLimit, PotentialError> {
        self.term_mut().limit_step(x, p)
    }

    fn is_settled(&self, x: &[Vec3], p: &[Vec3]) -> bool {
        self.term().is_settled(x, p)
    }

    fn demand(&self) -> Demand {
        self.term().demand()
    }

    fn locate(&self, x: &[Vec3], point: usize) -> Option<usize> {
        self.term().locate(x, point)
    }

    fn diagnose(&self, x: &[Vec3]) -> Option<PotentialError> {
        self.term().diagnose(x)
    }
}
