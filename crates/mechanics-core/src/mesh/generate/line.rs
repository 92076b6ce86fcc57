use super::check_counts;
use crate::mesh::TriMesh;
use crate::mesh::error::MeshError;
use crate::tensor::Vec3;

/// Whether a polyline's last point is joined to its first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PolylineEnds {
    /// Two ends.
    Open,
    /// A ring.
    Joined,
}

/// The free edges between consecutive points \[m\].
///
/// # Errors
/// Fewer than two points (three for a ring); a position that is not finite.
pub fn polyline(points: Vec<Vec3>, ends: PolylineEnds) -> Result<TriMesh, MeshError> {
    let (needed, expected) = match ends {
        PolylineEnds::Open => (2, "at least 2"),
        PolylineEnds::Joined => (3, "at least 3"),
    };
    if points.len() < needed {
        return Err(MeshError::BadParameter {
            parameter: "number of points",
            value: points.len() as f64,
            expected,
        });
    }
    let last = points.len() as u32 - 1;
    let mut edges: Vec<[u32; 2]> = (0..last).map(|i| [i, i + 1]).collect();
    if ends == PolylineEnds::Joined {
        edges.push([last, 0]);
    }
    TriMesh::with_codimensional(points, Vec::new(), edges, Vec::new())
}

/// A straight rod from one point to another \[m\] as `segments` free edges of equal length.
///
/// # Errors
/// No segments; a position that is not finite.
pub fn rod(from: &Vec3, to: &Vec3, segments: u32) -> Result<TriMesh, MeshError> {
    check_counts("segments", &[segments], 1)?;
    let point = |i: u32| {
        let t = f64::from(i) / f64::from(segments);
        from * (1.0 - t) + to * t
    };
    polyline((0..=segments).map(point).collect(), PolylineEnds::Open)
}
