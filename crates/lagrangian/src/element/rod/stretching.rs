//! The energy of a rod's edges.

use super::rest_lengths;
use crate::element::thin_error::{ThinError, positive};
use mechanics_core::mesh::TriMesh;
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

/// E = ½ (EA/ℓ̄) (ℓ − ℓ̄)² for each edge, ℓ = |x₁ − x₀|, ℓ̄ its rest length: force and strain are proportional, the force
/// is EA (ℓ/ℓ̄ − 1) along the unit tangent t.
///
/// The Hessian by the edge is (EA/ℓ̄) t⊗t + (EA/ℓ̄)(1 − ℓ̄/ℓ)(1 − t⊗t); its two eigenvalues are projected. An edge without
/// length has no tangent: it then exerts no force, and its Hessian is that of all directions alike.
#[derive(Clone, Debug)]
pub struct RodStretching {
    axial: f64,
    rest: Vec<f64>,
}

impl RodStretching {
    /// The free edges of `mesh`, at rest where they are, of axial stiffness EA \[N\].
    ///
    /// # Errors
    /// A stiffness that is not positive; an edge without length.
    pub fn new(mesh: &TriMesh, axial: f64) -> Result<Self, ThinError> {
        Ok(Self { axial: positive("the axial stiffness", axial)?, rest: rest_lengths(mesh)? })
    }

    /// The sum over the free edges of `mesh`, as a term of the incremental potential.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn term(
        name: impl Into<String>,
        mesh: &TriMesh,
        axial: f64,
    ) -> Result<StencilTerm<Self, 2>, ThinError> {
        Ok(StencilTerm::new(name, Self::new(mesh, axial)?, mesh.free_edges().to_vec())?)
    }

    /// The consistent mass matrix of an edge \[kg\] for a mass per length [kg/m]: μ ℓ̄/6 (1 + δᵢⱼ). For
    /// [`Mass::add_elements`](crate::element::Mass::add_elements).
    pub fn local_mass(&self, edge: usize, mass_per_length: f64) -> [[f64; 2]; 2] {
        let part = mass_per_length * self.rest[edge] / 6.0;
        [[2.0 * part, part], [part, 2.0 * part]]
    }

    /// The force along edge `edge` with its ends at `x` \[N\], positive in tension.
    pub fn tension(&self, edge: usize, x: &[Vec3; 2]) -> f64 {
        self.axial * ((x[1] - x[0]).norm() / self.rest[edge] - 1.0)
    }
}

impl Stencil<2> for RodStretching {
    fn value(&self, element: usize, x: &[Vec3; 2]) -> f64 {
        0.5 * self.axial / self.rest[element] * ((x[1] - x[0]).norm() - self.rest[element]).powi(2)
    }

    fn gradient(&self, element: usize, x: &[Vec3; 2]) -> [Vec3; 2] {
        let tangent = (x[1] - x[0]).try_normalize(0.0).unwrap_or_default();
        let force = tangent * self.tension(element, x);
        [-force, force]
    }

    fn hessian(&self, element: usize, x: &[Vec3; 2], projection: Projection) -> LocalHessian<2> {
        let edge = x[1] - x[0];
        let (length, rest) = (edge.norm(), self.rest[element]);
        let stiffness = self.axial / rest;
        let h = if length > 0.0 {
            let along = edge * edge.transpose() / (length * length);
            let across = projection.apply(stiffness * (1.0 - rest / length));
            along * stiffness + (Mat3::identity() - along) * across
        } else {
            Mat3::from_diagonal_element(stiffness)
        };
        [[h, -h], [-h, h]]
    }
}
