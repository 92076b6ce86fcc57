//! What is measured of linear tetrahedra: their deformation gradients.
//!
//! With rest edges Dₘ = (X₁ − X₀, X₂ − X₀, X₃ − X₀) the rows of Dₘ⁻¹ are the gradients ∇N₁, ∇N₂, ∇N₃ of the shape functions. Then
//! F = Σₐ (xₐ − x₀) ⊗ ∇Nₐ.

use mechanics_core::mesh::TetMesh;
use mechanics_core::tensor::{Mat3, Vec3};

/// The rest shapes of tetrahedra: of each ∇N₁, ∇N₂, ∇N₃ [1/m].
#[derive(Debug)]
pub(crate) struct RestShapes(Vec<[[f64; 3]; 3]>);

/// A tetrahedron that is flat or inside out at rest.
#[derive(Debug, thiserror::Error)]
#[error("tetrahedron {cell} has the rest volume {volume:e} m³; it must be positive")]
pub(crate) struct RestShapeError {
    cell: usize,
    volume: f64,
}

impl RestShapes {
    pub(crate) fn of(mesh: &TetMesh) -> Result<Self, RestShapeError> {
        let shape = |cell: usize| {
            let [a, b, c, d] = mesh.corners(cell);
            let edges = Mat3::from_columns(&[b - a, c - a, d - a]);
            let volume = edges.determinant() / 6.0;
            let inverse =
                edges.try_inverse().filter(|_| volume > 0.0).ok_or(RestShapeError { cell, volume })?;
            Ok(std::array::from_fn(|a| std::array::from_fn(|j| inverse[(a, j)])))
        };
        Ok(Self((0..mesh.cells().len()).map(shape).collect::<Result<_, _>>()?))
    }

    /// F of an element with its nodes at `x` [1].
    pub(crate) fn deformation_gradient(&self, element: usize, x: &[Vec3; 4]) -> Mat3 {
        let gradients = &self.0[element];
        (0..3).map(|a| (x[a + 1] - x[0]) * Vec3::from(gradients[a]).transpose()).sum()
    }
}
