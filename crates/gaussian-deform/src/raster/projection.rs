//! The projection of a Gaussian onto the image plane.

use crate::camera::Camera;
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Matrix3};

/// What is added to both variances on the image plane \[pixel²\]: a Gaussian that is smaller than a pixel is still seen.
pub const LOW_PASS: f64 = 0.3;

/// Gaussians whose means are not further in front of the eye than this are left out \[m\].
pub const NEAR: f64 = 0.2;

/// Directions at which the projection is linearised end beyond the picture's edges by this share of the picture's half side.
const BEYOND: f64 = 0.3;

/// The least factor by which [`Antialiasing::Present`](super::Antialiasing::Present) diminishes an opacity, squared.
const LEAST_SHARE: f64 = 2.5e-5;

/// A camera in the numbers that formulas run on.
#[derive(Clone, Copy, Debug)]
pub struct View<S> {
    rows: [[S; 3]; 3],
    eye: [S; 3],
    focal: [S; 2],
    middle: [S; 2],
    /// The least and the largest tangent at which the projection is linearised.
    limits: [[S; 2]; 2],
}

/// A Gaussian on the image plane.
#[derive(Clone, Copy, Debug)]
pub struct Projection<S> {
    /// The mean as the camera has it: to the right, down, forward \[m\]. Nothing else means anything where this is not in front of [`NEAR`].
    pub position: [S; 3],
    /// Where the mean is seen \[pixels\].
    pub place: [S; 2],
    /// The covariance xx, xy, yy with the low-pass \[pixel²\].
    pub covariance: [S; 3],
    /// The determinant of the covariance \[pixel⁴\].
    pub determinant: S,
    /// The determinant of the covariance without the low-pass \[pixel⁴\].
    pub sharp_determinant: S,
}

impl<S: Scalar> View<S> {
    /// The view of a camera. Inlined, and with loops: in a kernel over lanes closures would be calls.
    #[inline(always)]
    pub fn new(camera: &Camera) -> Self {
        let size = [camera.width() as f64, camera.height() as f64];
        let (focal, principal) = (camera.focal(), camera.principal_point());
        let zero = S::constant(0.0);
        let mut view = Self {
            rows: [[zero; 3]; 3],
            eye: [zero; 3],
            focal: [zero; 2],
            middle: [zero; 2],
            limits: [[zero; 2]; 2],
        };
        for i in 0..3 {
            view.eye[i] = S::constant(camera.eye()[i]);
            for j in 0..3 {
                view.rows[i][j] = S::constant(camera.rotation()[(i, j)]);
            }
        }
        for k in 0..2 {
            let margin = BEYOND * 0.5 * size[k];
            let (least, most) = (-(principal[k] + margin), size[k] - principal[k] + margin);
            view.limits[k] = [S::constant(least / focal[k]), S::constant(most / focal[k])];
            view.focal[k] = S::constant(focal[k]);
            view.middle[k] = S::constant(principal[k] - 0.5);
        }
        view
    }

    /// From the eye to a mean, in the world \[m\].
    #[inline(always)]
    pub fn offset(&self, mean: [S; 3]) -> [S; 3] {
        [mean[0] - self.eye[0], mean[1] - self.eye[1], mean[2] - self.eye[2]]
    }

    /// The projection of the Gaussian with covariance B Bᵀ whose mean is at `offset` from the eye.
    ///
    /// Around the mean p' = (x, y, z) the map to the image plane is linear with the Jacobian
    ///
    /// J = \[fₓ/z, 0, −fₓ x/z²; 0, f_y/z, −f_y y/z²\],
    ///
    /// where x/z and y/z are cut off 0.3 half sides beyond the picture's edges (at 1.3 times their tangents, if the axis is in the middle): farther out the linear map is useless. With the rows
    /// r₁, r₂ of J W B the covariance is a = r₁·r₁ + 0.3, b = r₁·r₂, c = r₂·r₂ + 0.3, and its determinant
    ///
    /// a c − b² = ‖r₁ × r₂‖² + 0.3 (r₁·r₁ + r₂·r₂) + 0.09
    ///
    /// is a sum of positive terms (Lagrange's identity): a needle a thousand pixels long keeps its width, also in single precision.
    ///
    /// # Reference
    /// Zwicker, Pfister, van Baar, Gross (2001), eq. 26–31; Kerbl et al. (2023), eq. 5. The cut and the low-pass are those of the latter's
    /// published program.
    #[inline(always)]
    pub fn project(&self, offset: [S; 3], axes: &Matrix3<S>) -> Projection<S> {
        let [w0, w1, w2] = &self.rows;
        let position = [tensor::dot(w0, &offset), tensor::dot(w1, &offset), tensor::dot(w2, &offset)];
        let inverse_depth = position[2].recip();
        let mut place = self.middle;
        let mut rows = [[S::constant(0.0); 3]; 2];
        for (k, w) in [w0, w1].into_iter().enumerate() {
            let tangent = position[k] * inverse_depth;
            place[k] = self.focal[k].mul_add(tangent, place[k]);
            let cut = tangent.min(self.limits[k][1]).max(self.limits[k][0]);
            let scale = self.focal[k] * inverse_depth;
            let along =
                [(w[0] - cut * w2[0]) * scale, (w[1] - cut * w2[1]) * scale, (w[2] - cut * w2[2]) * scale];
            for (entry, axis) in rows[k].iter_mut().zip(tensor::columns(axes)) {
                *entry = tensor::dot(axis, &along);
            }
        }
        let [r1, r2] = rows;
        let low_pass = S::constant(LOW_PASS);
        let (xx, xy, yy) = (tensor::dot(&r1, &r1), tensor::dot(&r1, &r2), tensor::dot(&r2, &r2));
        let normal = tensor::cross(&r1, &r2);
        let area = tensor::dot(&normal, &normal);
        Projection {
            position,
            place,
            covariance: [xx + low_pass, xy, yy + low_pass],
            determinant: (xx + yy).mul_add(low_pass, area).offset(LOW_PASS * LOW_PASS),
            sharp_determinant: area,
        }
    }
}

impl<S: Scalar> Projection<S> {
    /// Three standard deviations along the longer half-axis, not yet rounded up to whole pixels as the original rules have it \[pixels\].
    #[inline(always)]
    pub fn reach(&self) -> S {
        let [a, b, c] = self.covariance;
        let difference = (a - c).scale(0.5);
        let spread = difference.mul_add(difference, b * b).max(S::constant(0.1)).sqrt();
        ((a + c).scale(0.5) + spread).sqrt().scale(3.0)
    }

    /// √(det Σ₀/det Σ), Σ₀ without the low-pass, at least 0.005: by how much the low-pass has to diminish the opacity so that the Gaussian's whole, 2π o √det Σ, stays what it was.
    ///
    /// # Reference
    /// Yu, Chen, Huang, Sattler, Geiger (2024), *Mip-Splatting: Alias-free 3D Gaussian Splatting*, the two-dimensional filter. The least value is that of the program of Kerbl et al. with antialiasing.
    #[inline(always)]
    pub fn sharpness(&self) -> S {
        (self.sharp_determinant / self.determinant).max(S::constant(LEAST_SHARE)).sqrt()
    }
}
