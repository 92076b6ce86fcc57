//! Finding hinges, and their rest state.

use crate::element::thin_error::{ThinError, positive};
use mechanics_core::law::Lame;
use mechanics_core::mesh::{MeshError, TriMesh};
use mechanics_core::tensor::Vec3;

/// What the rest angles of hinges are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RestAngle {
    /// Those of the rest mesh: a folded or rounded shell keeps its shape.
    #[default]
    OfMesh,
    /// Zero: the sheet would like to be flat.
    Flat,
}

/// An interior edge of a triangle mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hinge {
    /// The edge's ends as the first triangle runs through them, that triangle's third corner, the second's.
    pub points: [u32; 4],
    /// The two triangles.
    pub triangles: [u32; 2],
}

/// D = E t³/(12(1 − ν²)) \[J\]: the moment per length \[N\] that bends a plate of Young's modulus E \[Pa\], Poisson's ratio ν
/// and thickness t \[m\] into a cylinder, per curvature [1/m].
///
/// # Errors
/// A parameter out of range.
///
/// # Reference
/// S. P. Timoshenko, S. Woinowsky-Krieger, *Theory of Plates and Shells*, 2nd ed., 1959, equation (3).
pub fn flexural_rigidity(young_modulus: f64, poisson_ratio: f64, thickness: f64) -> Result<f64, ThinError> {
    Lame::from_young_poisson(young_modulus, poisson_ratio)?;
    let thickness = positive("the thickness", thickness)?;
    let rigidity = young_modulus * thickness.powi(3) / (12.0 * (1.0 - poisson_ratio * poisson_ratio));
    positive("the flexural rigidity", rigidity)
}

/// All interior edges of `mesh`, ordered by their points; edges of one triangle only are not among them.
///
/// # Errors
/// [`MeshError::NonManifoldEdge`] for an edge of three or more triangles, [`MeshError::OpposedTriangles`] for
/// neighbours that run along their edge in the same direction.
pub fn hinges_of(mesh: &TriMesh) -> Result<Vec<Hinge>, MeshError> {
    // (edge ascending, triangle, corner opposite, whether the triangle runs from the smaller end to the larger)
    let mut sides: Vec<([u32; 2], u32, u32, bool)> = Vec::with_capacity(3 * mesh.triangles().len());
    for (triangle, &[a, b, c]) in (0..).zip(mesh.triangles()) {
        for [from, to, opposite] in [[a, b, c], [b, c, a], [c, a, b]] {
            sides.push(([from.min(to), from.max(to)], triangle, opposite, from < to));
        }
    }
    sides.sort_unstable();
    let mut hinges = Vec::new();
    for group in sides.chunk_by(|p, q| p.0 == q.0) {
        match group {
            [(edge, first, one, ascending), (_, second, two, other)] => {
                let triangles = [*first, *second];
                if ascending == other {
                    return Err(MeshError::OpposedTriangles { edge: *edge, triangles });
                }
                let [from, to] = if *ascending { *edge } else { [edge[1], edge[0]] };
                hinges.push(Hinge { points: [from, to, *one, *two], triangles });
            }
            [_, _, _, ..] => return Err(MeshError::NonManifoldEdge { edge: group[0].0, count: group.len() }),
            _ => {}
        }
    }
    Ok(hinges)
}

/// The normals of a hinge's triangles, twice the areas long.
pub(super) fn normals(mesh: &TriMesh, hinge: &Hinge) -> Result<[Vec3; 2], ThinError> {
    let mut normals = [Vec3::zeros(); 2];
    for (normal, &triangle) in normals.iter_mut().zip(&hinge.triangles) {
        let triangle = triangle as usize;
        let [a, b, c] = mesh.corners(triangle);
        let longest = (b - a).norm_squared().max((c - a).norm_squared()).max((c - b).norm_squared());
        *normal = (b - a).cross(&(c - a));
        let twice_area = normal.norm();
        if !(twice_area > 1e-12 * longest && twice_area.is_finite()) {
            let points = mesh.triangles()[triangle];
            return Err(ThinError::RestArea { triangle, points, area: 0.5 * twice_area });
        }
    }
    Ok(normals)
}
