//! Samples of a deforming body: what a solver shows to whoever deforms something with it.

use crate::tensor::{Mat3, Vec3};

/// Places of a body and its *total* deformation gradients there, borrowed from a solver, or from a buffer that a solver with another layout filled.
///
/// Sample k is the same material point in every frame, whatever order the solver keeps inside. F = ∂x/∂X from the shape in which the
/// samples were taken, plastic flow included.
///
/// ```
/// use mechanics_core::samples::DeformationSamples;
/// use mechanics_core::tensor::{Mat3, Vec3};
///
/// let (positions, gradients) = ([Vec3::zeros()], [Mat3::identity() * 2.0]);
/// let samples = DeformationSamples::new(&positions, &gradients);
/// assert_eq!(samples.gradients()[0].determinant(), 8.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeformationSamples<'a> {
    positions: &'a [Vec3],
    gradients: &'a [Mat3],
}

impl<'a> DeformationSamples<'a> {
    /// Of as many places as gradients.
    ///
    /// # Panics
    /// If there are not as many.
    pub fn new(positions: &'a [Vec3], gradients: &'a [Mat3]) -> Self {
        assert_eq!(positions.len(), gradients.len(), "one deformation gradient for each sample");
        Self { positions, gradients }
    }

    /// x, by sample \[m\].
    pub fn positions(&self) -> &'a [Vec3] {
        self.positions
    }

    /// F, by sample.
    pub fn gradients(&self) -> &'a [Mat3] {
        self.gradients
    }

    /// How many samples there are.
    pub fn count(&self) -> usize {
        self.positions.len()
    }
}
