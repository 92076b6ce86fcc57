//! Signed distances of another library, for tests and benches.

use mechanics_core::mesh::TriMesh;
use mechanics_core::tensor::Vec3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{TriMesh as Mesh, TriMeshFlags};

pub(crate) struct Parry(Mesh);

impl Parry {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let points = mesh.points().iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
        Self(Mesh::with_flags(points, mesh.triangles().to_vec(), TriMeshFlags::ORIENTED).unwrap())
    }

    /// The distance, and its gradient away from the surface.
    pub(crate) fn signed_distance(&self, place: &Vec3) -> (f64, Vec3) {
        let found = self.0.project_local_point(Vector::new(place.x, place.y, place.z), false);
        let offset = place - Vec3::new(found.point.x, found.point.y, found.point.z);
        let sign = if found.is_inside { -1.0 } else { 1.0 };
        (sign * offset.norm(), sign * offset.normalize())
    }
}
