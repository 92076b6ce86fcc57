use super::check_counts;
use crate::mesh::TriMesh;
use crate::mesh::error::MeshError;
use crate::mesh::points::check_positive;
use crate::tensor::Vec3;

/// A torus of triangles \[m\] around the z axis: a tube of radius `minor` whose centre line has radius `major`, with
/// `around` points along the centre line and `across` around the tube. Euler characteristic 0; volume and area fall
/// short of 2π² R r² and 4π² R r by O(h²).
///
/// # Errors
/// Radii that are not positive and finite, `minor` not smaller than `major`, counts below 3.
pub fn torus(major: f64, minor: f64, around: u32, across: u32) -> Result<TriMesh, MeshError> {
    check_positive("major radius", major)?;
    check_positive("minor radius", minor)?;
    check_counts("around or across", &[around, across], 2)?;
    if minor >= major {
        let expected = "less than the major radius";
        return Err(MeshError::BadParameter { parameter: "minor radius", value: minor, expected });
    }
    if around.min(across) < 3 {
        let value = f64::from(around.min(across));
        return Err(MeshError::BadParameter { parameter: "around or across", value, expected: "at least 3" });
    }
    let angle = |i: u32, n: u32| (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos();
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let ((sin_u, cos_u), (sin_v, cos_v)) = (angle(i, around), angle(j, across));
            let radius = major + minor * cos_v;
            points.push(Vec3::new(radius * cos_u, radius * sin_u, minor * sin_v));
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriMesh::new(points, triangles)
}
