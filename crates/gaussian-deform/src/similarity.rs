//! From the scene's coordinates to those of a simulation and back: a rotation, one scale, and a shift.

use crate::bind::Moved;
use crate::error::SplatError;
use crate::harmonics;
use crate::splats::Splats;
use mechanics_core::lanes::Element;
use mechanics_core::mesh::BoundingBox;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::tensor::{self, Mat3, Matrix3, Vec3};

/// y = s Q x + t with s > 0 and a rotation Q.
///
/// What a simulation in y says of a motion, the scene in x sees as
///
/// | | in y | in x |
/// |---|---|---|
/// | position | y | x = Qᵀ (y − t)/s |
/// | deformation gradient | F | Qᵀ F Q |
/// | its rotation, which turns colours | R | Qᵀ R Q |
/// | a Gaussian at rest | half-axes s Q B, harmonics rotated by Q | B |
///
/// (Rotating the scene's colours by R instead of Qᵀ R Q is an error that only scenes with Q ≠ I show.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    scale: f64,
    rotation: Mat3,
    translation: Vec3,
}

impl Similarity {
    /// y = s Q x + t.
    ///
    /// # Errors
    /// [`SplatError::BadSimilarity`] unless the scale is positive, everything finite, and Q a rotation to 1e-9.
    pub fn new(scale: f64, rotation: Mat3, translation: Vec3) -> Result<Self, SplatError> {
        let off = (rotation.transpose() * rotation - Mat3::identity()).norm();
        let valid = scale > 0.0
            && scale.is_finite()
            && off < 1e-9
            && rotation.determinant() > 0.0
            && translation.iter().all(|x| x.is_finite());
        if !valid {
            return Err(SplatError::BadSimilarity { scale, off, determinant: rotation.determinant() });
        }
        Ok(Self { scale, rotation, translation })
    }

    /// y = x.
    pub fn identity() -> Self {
        Self { scale: 1.0, rotation: Mat3::identity(), translation: Vec3::zeros() }
    }

    /// Turns by `rotation` about the centre of the box `from`, and brings it into the middle of the box `to`, as large as it fits.
    ///
    /// # Errors
    /// As [`Similarity::new`]: a box without extent has no scale.
    pub fn fitting(from: &BoundingBox, to: &BoundingBox, rotation: Mat3) -> Result<Self, SplatError> {
        let half = from.size() * 0.5;
        // The half-sides of the turned box: |Q| times those of the box.
        let turned = rotation.abs() * half;
        let room = to.size() * 0.5;
        let scale = (0..3).map(|k| room[k] / turned[k]).filter(|s| !s.is_nan()).fold(f64::INFINITY, f64::min);
        Self::new(scale, rotation, to.centre() - rotation * from.centre() * scale)
    }

    /// x = Qᵀ (y − t)/s: the way back, as a similarity.
    ///
    /// # Errors
    /// [`SplatError::BadSimilarity`] if 1/s or t/s is not finite.
    pub fn inverse(&self) -> Result<Self, SplatError> {
        let rotation = self.rotation.transpose();
        Self::new(self.scale.recip(), rotation, -(rotation * self.translation) / self.scale)
    }

    /// s.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Q.
    pub fn rotation(&self) -> &Mat3 {
        &self.rotation
    }

    /// t.
    pub fn translation(&self) -> &Vec3 {
        &self.translation
    }

    /// y of x.
    pub fn point(&self, x: &Vec3) -> Vec3 {
        self.rotation * x * self.scale + self.translation
    }

    /// x of y.
    pub fn point_back(&self, y: &Vec3) -> Vec3 {
        self.rotation.tr_mul(&(y - self.translation)) / self.scale
    }

    /// Qᵀ F Q: a deformation gradient in x of one in y.
    pub fn gradient_back(&self, f: &Mat3) -> Mat3 {
        self.rotation.tr_mul(f) * self.rotation
    }

    /// The motion in x of one in y.
    pub fn motion_back_into(&self, samples: DeformationSamples<'_>, moved: &mut Moved) {
        moved.set(samples.count(), |k| {
            (self.point_back(&samples.positions()[k]), self.gradient_back(&samples.gradients()[k]))
        });
    }

    /// A scene as it is in y: means, half-axes and harmonics.
    pub fn apply<E: Element>(&self, splats: &Splats<E>) -> Splats<E> {
        let mut moved = splats.clone();
        for mean in moved.means_mut() {
            let y = self.point(&Vec3::from(tensor::components(mean).map(Into::into)));
            *mean = tensor::vector(tensor::components(&y).map(E::constant));
        }
        let rotation: Matrix3<E> = tensor::constant(&self.rotation);
        let scaled = tensor::scaled(&rotation, E::constant(self.scale));
        moved.axes_mut().iter_mut().for_each(|b| *b = tensor::product(&scaled, b));
        for orientation in moved.orientations_mut() {
            *orientation = tensor::product(&rotation, orientation);
        }
        if splats.orientations().is_none() {
            harmonics::settle_orientations(&mut moved);
        }
        moved
    }
}
