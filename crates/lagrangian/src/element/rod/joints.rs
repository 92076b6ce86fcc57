//! Where a rod bends and twists: the points in which two of its edges meet.

use crate::element::thin_error::ThinError;
use mechanics_core::mesh::TriMesh;

/// A point in which two free edges of a mesh meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    /// The far point of the first edge, the joint, the far point of the second.
    pub(super) points: [u32; 3],
    /// The two edges, by their numbers in the mesh.
    pub(super) edges: [usize; 2],
}

impl Joint {
    /// +1 for each edge that the mesh lists in the direction from `points[0]` to `points[2]`, −1 for the others.
    pub(super) fn orientations(&self, mesh: &TriMesh) -> [f64; 2] {
        let starts = [self.points[0], self.points[1]];
        let of = |k: usize| if mesh.free_edges()[self.edges[k]][0] == starts[k] { 1.0 } else { -1.0 };
        [of(0), of(1)]
    }
}

/// The joints of a mesh, in the order of their points.
pub(super) fn joints_of(mesh: &TriMesh) -> Result<Vec<Joint>, ThinError> {
    let mut at_point: Vec<Vec<usize>> = vec![Vec::new(); mesh.points().len()];
    for (edge, points) in mesh.free_edges().iter().enumerate() {
        points.iter().for_each(|&point| at_point[point as usize].push(edge));
    }
    let mut joints = Vec::new();
    for (point, edges) in (0_u32..).zip(&at_point) {
        let other = |edge: usize| {
            let [a, b] = mesh.free_edges()[edge];
            if a == point { b } else { a }
        };
        match edges[..] {
            [] | [_] => {}
            [one, two] => {
                joints.push(Joint { points: [other(one), point, other(two)], edges: [one, two] });
            }
            _ => return Err(ThinError::Branch { point, edges: edges.len() }),
        }
    }
    Ok(joints)
}
