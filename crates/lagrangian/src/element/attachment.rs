//! Soft attachments: points drawn to targets, ½k‖x − t‖².

use super::error::{ElementError, check_positive};
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

/// Points drawn to targets by springs of no rest length: ½k‖x − t‖² \[J\].
///
/// For points that must follow a path exactly, take them out of the unknowns instead:
/// [`Stepper::set_target`](crate::stepper::Stepper::set_target).
#[derive(Clone, Debug)]
pub struct Attachments {
    /// k [N/m].
    stiffness: f64,
    /// t \[m\].
    targets: Vec<Vec3>,
}

impl Attachments {
    /// `points` drawn to `targets` \[m\] with stiffness k > 0 [N/m], as a term.
    ///
    /// # Errors
    /// [`ElementError`] if the stiffness is not positive.
    ///
    /// # Panics
    /// If there is not one target per point.
    pub fn term(
        name: impl Into<String>,
        stiffness: f64,
        points: &[u32],
        targets: Vec<Vec3>,
    ) -> Result<StencilTerm<Self, 1>, ElementError> {
        assert_eq!(points.len(), targets.len(), "one target per point");
        check_positive("stiffness", "attachment", 0, stiffness)?;
        let elements = points.iter().map(|&point| [point]).collect();
        Ok(StencilTerm::new(name, Self { stiffness, targets }, elements)?)
    }

    /// The targets \[m\], to be moved between steps.
    pub fn targets_mut(&mut self) -> &mut [Vec3] {
        &mut self.targets
    }
}

impl Stencil<1> for Attachments {
    fn value(&self, attachment: usize, x: &[Vec3; 1]) -> f64 {
        0.5 * self.stiffness * (x[0] - self.targets[attachment]).norm_squared()
    }

    fn gradient(&self, attachment: usize, x: &[Vec3; 1]) -> [Vec3; 1] {
        [(x[0] - self.targets[attachment]) * self.stiffness]
    }

    fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
        [[Mat3::from_diagonal_element(self.stiffness)]]
    }
}
