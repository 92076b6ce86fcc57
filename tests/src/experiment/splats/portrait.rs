//! Cameras that show the whole of a scene of splats, and its pictures in reports.

use gaussian_deform::camera::{Camera, CameraError, Orbit};
use mechanics_core::mesh::BoundingBox;
use mechanics_core::tensor::Vec3;

/// The angle between the upper and the lower edge \[rad\].
const FIELD_OF_VIEW: f64 = 0.6;

/// From `azimuth` around and `elevation` over the middle of a box \[rad\], so far away that all of it fits between the upper and the lower edge.
///
/// # Errors
/// What a camera cannot be made of.
pub(crate) fn camera_on(
    bounds: &BoundingBox,
    size: [usize; 2],
    up: Vec3,
    (azimuth, elevation): (f64, f64),
) -> Result<Camera, CameraError> {
    let radius = 0.5 * bounds.size().norm();
    let narrow = (0.5 * FIELD_OF_VIEW).tan() * (size[0] as f64 / size[1] as f64).min(1.0);
    let distance = radius / narrow.atan().sin();
    let orbit =
        Orbit { target: bounds.centre(), distance, azimuth, elevation, up, field_of_view: FIELD_OF_VIEW };
    Camera::on_orbit(size, &orbit)
}
