//! Rest shapes of triangles.

use super::Mat3x2;
use crate::element::thin_error::ThinError;
use mechanics_core::mesh::TriMesh;
use mechanics_core::tensor::Vec3;

/// Twice a triangle's area over its longest edge squared, below which it counts as a line.
const FLAT: f64 = 1e-12;

/// The rest shape of a triangle. See the [module](super) page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestTriangle {
    /// ∇N₁ and ∇N₂ in (t₁, t₂) [1/m].
    gradients: [[f64; 2]; 2],
    area: f64,
    tangents: [Vec3; 2],
}

impl RestTriangle {
    /// Triangle `triangle` of `mesh`, t₁ along its first edge.
    ///
    /// # Errors
    /// [`ThinError::RestArea`].
    pub fn of(mesh: &TriMesh, triangle: usize) -> Result<Self, ThinError> {
        let [a, b, _] = mesh.corners(triangle);
        Self::along(mesh, triangle, &(b - a))
    }

    /// Triangle `triangle` of `mesh`, t₁ along the part of `fibre` in its plane.
    ///
    /// # Errors
    /// [`ThinError::RestArea`], [`ThinError::FibreDirection`].
    pub fn along(mesh: &TriMesh, triangle: usize, fibre: &Vec3) -> Result<Self, ThinError> {
        let [a, b, c] = mesh.corners(triangle);
        let edges = [b - a, c - a];
        let normal = edges[0].cross(&edges[1]);
        let longest = edges[0].norm().max(edges[1].norm()).max((c - b).norm());
        let twice_area = normal.norm();
        if !(twice_area > FLAT * longest * longest && twice_area.is_finite()) {
            let points = mesh.triangles()[triangle];
            return Err(ThinError::RestArea { triangle, points, area: 0.5 * twice_area });
        }
        let normal = normal / twice_area;
        let within = fibre - normal * normal.dot(fibre);
        let size = within.norm();
        if !(size > 1e-8 * fibre.norm() && size.is_finite()) {
            return Err(ThinError::FibreDirection { triangle, direction: (*fibre).into() });
        }
        let first = within / size;
        let tangents = [first, normal.cross(&first)];
        let [[p, q], [r, s]] = edges.map(|edge| tangents.map(|t| t.dot(&edge)));
        // Dₘ = [[p, r], [q, s]]; the rows of its inverse.
        let determinant = p * s - q * r;
        let gradients = [[s / determinant, -r / determinant], [-q / determinant, p / determinant]];
        Ok(Self { gradients, area: 0.5 * twice_area, tangents })
    }

    /// ∇N₁ and ∇N₂ in (t₁, t₂) [1/m].
    pub fn gradients(&self) -> &[[f64; 2]; 2] {
        &self.gradients
    }

    /// The area \[m²\].
    pub fn area(&self) -> f64 {
        self.area
    }

    /// t₁ and t₂.
    pub fn tangents(&self) -> &[Vec3; 2] {
        &self.tangents
    }

    /// F with the corners at `x`.
    pub fn deformation_gradient(&self, x: &[Vec3; 3]) -> Mat3x2 {
        let edges = [x[1] - x[0], x[2] - x[0]];
        let [g1, g2] = self.gradients;
        Mat3x2::from_columns(&[edges[0] * g1[0] + edges[1] * g2[0], edges[0] * g1[1] + edges[1] * g2[1]])
    }
}
