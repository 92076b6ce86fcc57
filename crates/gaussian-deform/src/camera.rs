//! Pinhole cameras.
//!
//! A point p of the world is at p' = W (p − e) for the camera: x to the right, y *down*, z forward, e the eye. It is seen at
//!
//! u = fₓ x/z + cₓ − ½,  v = f_y y/z + c_y − ½
//!
//! in a picture of w × h pixels, where pixel centres have whole numbers: (0, 0) is the centre of the first pixel. The optical axis meets the picture in its principal
//! point (cₓ, c_y), counted from the corner of the first pixel: (w/2, h/2), the middle, unless
//! [`with_principal_point`](Camera::with_principal_point) moves it.

mod error;
mod json;

pub use error::{CameraError, CameraProperty};
pub use json::cameras_from_json;

use crate::splats::Splats;
use mechanics_core::decomposition;
use mechanics_core::lanes::Element;
use mechanics_core::tensor::{self, Mat3, Vec3};

/// The most pixels that a picture may have along one side.
pub const MOST_PIXELS: usize = 16_384;

/// By how much the rows of a rotation may miss length one and right angles: files hold them in single precision.
const ROTATION_TOLERANCE: f64 = 1e-4;

/// A pinhole camera; see the [module](self).
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    size: [usize; 2],
    focal: [f64; 2],
    principal: [f64; 2],
    rotation: Mat3,
    eye: Vec3,
}

/// A camera and the name of the picture that was taken with it.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCamera {
    /// The name of the picture; may be empty.
    pub name: String,
    /// The camera.
    pub camera: Camera,
}

/// A place on a sphere around what is looked at.
///
/// With the unit vector u along `up`, a unit vector s across it (the part of the axis z, or of x where z is within 26° of u, that is
/// perpendicular to it) and t = u × s, the eye is at `target` + `distance` (cos ε (cos α s + sin α t) + sin ε u).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// What is looked at \[m\].
    pub target: Vec3,
    /// From the target to the eye \[m\].
    pub distance: f64,
    /// α, around `up` \[rad\].
    pub azimuth: f64,
    /// ε, over the plane across `up` \[rad\]; strictly between −π/2 and π/2.
    pub elevation: f64,
    /// What is up in the picture; any length.
    pub up: Vec3,
    /// The angle between the upper and the lower edge of the picture \[rad\].
    pub field_of_view: f64,
}

impl Camera {
    /// A picture of `size` = \[width, height\] pixels, focal lengths in pixels, `rotation` W from the world to the camera, `eye` in the world \[m\].
    ///
    /// # Errors
    /// [`CameraError::BadValue`] for a side of no or more than [`MOST_PIXELS`] pixels, for numbers that are not finite and focal lengths that are not
    /// positive; [`CameraError::NotARotation`].
    pub fn new(size: [usize; 2], focal: [f64; 2], rotation: Mat3, eye: Vec3) -> Result<Self, CameraError> {
        for (side, property) in size.into_iter().zip([CameraProperty::Width, CameraProperty::Height]) {
            if !(1..=MOST_PIXELS).contains(&side) {
                return Err(bad(property, side as f64, "from 1 to 16384 pixels"));
            }
        }
        for length in focal {
            if !(length.is_finite() && length > 0.0) {
                return Err(bad(CameraProperty::FocalLength, length, "a positive number of pixels"));
            }
        }
        finite(eye.as_slice(), CameraProperty::Position)?;
        finite(rotation.as_slice(), CameraProperty::Rotation)?;
        let skewness = (rotation * rotation.transpose() - Mat3::identity()).amax();
        let deviation = skewness.max((rotation.determinant() - 1.0).abs());
        if deviation > ROTATION_TOLERANCE {
            return Err(CameraError::NotARotation { deviation });
        }
        Ok(Self { size, focal, principal: size.map(|side| 0.5 * side as f64), rotation, eye })
    }

    /// The same camera with another principal point: where the optical axis meets the picture, in pixels to the right of and below the picture's upper left corner.
    ///
    /// Pictures cut out of larger ones have it off the middle, even outside; so do calibrated cameras.
    ///
    /// # Errors
    /// [`CameraError::BadValue`] for numbers that are not finite.
    pub fn with_principal_point(self, principal: [f64; 2]) -> Result<Self, CameraError> {
        finite(&principal, CameraProperty::PrincipalPoint)?;
        Ok(Self { principal, ..self })
    }

    /// From `eye` to `target`, `up` pointing to the upper edge; `field_of_view` is the angle between the upper and the lower edge \[rad\], pixels
    /// are square.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`CameraError::BadValue`] for an angle that is not between 0 and π; [`CameraError::NoDirection`].
    pub fn look_at(
        size: [usize; 2],
        field_of_view: f64,
        eye: Vec3,
        target: Vec3,
        up: Vec3,
    ) -> Result<Self, CameraError> {
        if !(field_of_view > 0.0 && field_of_view < std::f64::consts::PI) {
            return Err(bad(CameraProperty::FieldOfView, field_of_view, "between 0 and pi"));
        }
        finite(eye.as_slice(), CameraProperty::Position)?;
        finite(target.as_slice(), CameraProperty::Target)?;
        finite(up.as_slice(), CameraProperty::Up)?;
        let no_direction = |property| CameraError::NoDirection { property };
        let forward = unit(target - eye).ok_or(no_direction(CameraProperty::Target))?;
        let up = unit(up).ok_or(no_direction(CameraProperty::Up))?;
        let across = forward.cross(&up);
        if across.norm() < 1e-6 {
            return Err(no_direction(CameraProperty::Up));
        }
        let right = across.normalize();
        let down = forward.cross(&right);
        let rotation = Mat3::from_columns(&[right, down, forward]).transpose();
        let focal = 0.5 * size[1] as f64 / (0.5 * field_of_view).tan();
        Self::new(size, [focal, focal], rotation, eye)
    }

    /// From a place on an [orbit](Orbit) to its target.
    ///
    /// # Errors
    /// As [`look_at`](Self::look_at); [`CameraError::BadValue`] for a distance that is not positive, an elevation beyond the poles, and angles
    /// that are not finite.
    pub fn on_orbit(size: [usize; 2], orbit: &Orbit) -> Result<Self, CameraError> {
        let Orbit { target, distance, azimuth, elevation, up, field_of_view } = *orbit;
        if !(distance.is_finite() && distance > 0.0) {
            return Err(bad(CameraProperty::Distance, distance, "a positive length"));
        }
        finite(&[azimuth], CameraProperty::Angle)?;
        if elevation.is_nan() || elevation.abs() >= std::f64::consts::FRAC_PI_2 {
            return Err(bad(CameraProperty::Angle, elevation, "an elevation between -pi/2 and pi/2"));
        }
        finite(up.as_slice(), CameraProperty::Up)?;
        let up = unit(up).ok_or(CameraError::NoDirection { property: CameraProperty::Up })?;
        let axis = if up.z.abs() < 0.9 { Vec3::z() } else { Vec3::x() };
        let start = (axis - up * axis.dot(&up)).normalize();
        let level = start * azimuth.cos() + up.cross(&start) * azimuth.sin();
        let eye = target + (level * elevation.cos() + up * elevation.sin()) * distance;
        Self::look_at(size, field_of_view, eye, target, up)
    }

    /// The same view in a picture of another size: focal lengths and the principal point grow as the sides do.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn resized(&self, size: [usize; 2]) -> Result<Self, CameraError> {
        let grown = |lengths: [f64; 2]| [0, 1].map(|k| lengths[k] * size[k] as f64 / self.size[k] as f64);
        Self::new(size, grown(self.focal), self.rotation, self.eye)?
            .with_principal_point(grown(self.principal))
    }

    /// The camera after the motion p ↦ R p + t of the world: it sees a scene that has moved along as this one sees the scene that has not.
    ///
    /// # Errors
    /// [`CameraError::NotARotation`], [`CameraError::BadValue`].
    pub fn moved(&self, rotation: &Mat3, translation: &Vec3) -> Result<Self, CameraError> {
        let turned = self.rotation * rotation.transpose();
        let moved = Self::new(self.size, self.focal, turned, rotation * self.eye + translation)?;
        moved.with_principal_point(self.principal)
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.size[0]
    }

    /// Rows of pixels.
    pub fn height(&self) -> usize {
        self.size[1]
    }

    /// fₓ and f_y \[pixels\].
    pub fn focal(&self) -> [f64; 2] {
        self.focal
    }

    /// cₓ and c_y \[pixels\]: see [`with_principal_point`](Self::with_principal_point).
    pub fn principal_point(&self) -> [f64; 2] {
        self.principal
    }

    /// W, from the world to the camera.
    pub fn rotation(&self) -> &Mat3 {
        &self.rotation
    }

    /// e, in the world \[m\].
    pub fn eye(&self) -> &Vec3 {
        &self.eye
    }

    /// W (p − e): to the right, down, forward \[m\].
    pub fn view(&self, point: &Vec3) -> Vec3 {
        self.rotation * (point - self.eye)
    }

    /// Where a point is seen \[pixels\]; `None` if it is not in front of the eye.
    pub fn project(&self, point: &Vec3) -> Option<[f64; 2]> {
        let view = self.view(point);
        let place = |k: usize| self.focal[k] * view[k] / view.z + (self.principal[k] - 0.5);
        (view.z > 0.0).then(|| [place(0), place(1)])
    }

    /// Whether the eye is outside all ellipsoids (x − μ)ᵀ A⁻¹ (x − μ) ≤ `deviations`².
    ///
    /// From inside of a Gaussian nothing sensible can be seen: one that is in front of the near plane is smeared over the whole picture, one that is
    /// not is left out. Pictures of such a scene are made all the same; whoever places a camera asks here.
    ///
    /// # Errors
    /// [`CameraError::InsideSplat`] with the first Gaussian around the eye.
    pub fn require_outside<E: Element>(
        &self,
        splats: &Splats<E>,
        deviations: f64,
    ) -> Result<(), CameraError> {
        for (splat, (mean, axes)) in splats.means().iter().zip(splats.axes()).enumerate() {
            let offset = self.eye - mean.map(Into::into);
            let axes: Mat3 = axes.map(Into::into);
            // No Gaussian reaches further than its axes are long together.
            if offset.norm_squared() <= deviations * deviations * tensor::norm_squared(&axes) {
                let distance = deviations_from(&axes, &offset);
                if distance <= deviations {
                    return Err(CameraError::InsideSplat { splat, deviations: distance });
                }
            }
        }
        Ok(())
    }
}

/// ‖B⁺ r‖, infinite where r has a component along an axis of no length.
fn deviations_from(axes: &Mat3, offset: &Vec3) -> f64 {
    let svd = decomposition::svd(axes);
    let along = svd.u.transpose() * offset;
    let square = |k: usize| {
        let (r, s) = (along[k], svd.sigma[k].abs());
        if r == 0.0 { 0.0 } else { (r / s).powi(2) }
    };
    (square(0) + square(1) + square(2)).sqrt()
}

fn bad(property: CameraProperty, value: f64, wanted: &'static str) -> CameraError {
    CameraError::BadValue { property, value, wanted }
}

fn finite(numbers: &[f64], property: CameraProperty) -> Result<(), CameraError> {
    match numbers.iter().find(|x| !x.is_finite()) {
        None => Ok(()),
        Some(&value) => Err(bad(property, value, "a finite number")),
    }
}

/// `None` for a vector without a direction.
fn unit(a: Vec3) -> Option<Vec3> {
    let length = a.norm();
    (length > 0.0 && length.is_finite()).then(|| a / length)
}
