//! The tetrahedron with linear shape functions, and forces that do not change.
//!
//! With rest edges Dₘ = (X₁ − X₀, X₂ − X₀, X₃ − X₀) the rows of Dₘ⁻¹ are the gradients ∇N₁, ∇N₂, ∇N₃; ∇N₀ is minus their
//! sum. Then F = Σₐ (xₐ − x₀) ⊗ ∇Nₐ, the energy is V ψ(F) with V = det Dₘ / 6, its gradient at node a is V P ∇Nₐ, and its
//! Hessian between nodes a and b is V Σⱼₗ ∇Nₐⱼ (∂Pᵢⱼ/∂Fₖₗ) ∇N_bₗ.
//!
//! # Reference
//! J. Bonet, R. D. Wood, *Nonlinear Continuum Mechanics for Finite Element Analysis*, 2nd ed., 2008, chapter 9.

use super::material::{energy_density, first_piola, stiffness};
use mechanics_core::law::Hyperelastic;
use mechanics_core::mesh::TetMesh;
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// The rest shapes of tetrahedra.
#[derive(Debug)]
pub(crate) struct RestShapes(Vec<RestShape>);

#[derive(Debug)]
struct RestShape {
    /// ∇N₁, ∇N₂, ∇N₃ [1/m].
    gradients: [[f64; 3]; 3],
    /// [m³]
    volume: f64,
}

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
            Ok(RestShape {
                gradients: std::array::from_fn(|a| std::array::from_fn(|j| inverse[(a, j)])),
                volume,
            })
        };
        Ok(Self((0..mesh.cells().len()).map(shape).collect::<Result<_, _>>()?))
    }

    /// F of an element with its nodes at `x` [1].
    pub(crate) fn deformation_gradient(&self, element: usize, x: &[Vec3; 4]) -> Mat3 {
        let gradients = &self.0[element].gradients;
        (0..3).map(|a| (x[a + 1] - x[0]) * Vec3::from(gradients[a]).transpose()).sum()
    }
}

/// Tetrahedra of one material.
pub(crate) struct LinearTetrahedra<L> {
    law: L,
    rest: Arc<RestShapes>,
}

impl<L> LinearTetrahedra<L> {
    pub(crate) fn new(law: L, rest: Arc<RestShapes>) -> Self {
        Self { law, rest }
    }
}

impl<L: Hyperelastic> Stencil<4> for LinearTetrahedra<L> {
    fn value(&self, element: usize, x: &[Vec3; 4]) -> f64 {
        self.rest.0[element].volume * energy_density(&self.law, &self.rest.deformation_gradient(element, x))
    }

    fn gradient(&self, element: usize, x: &[Vec3; 4]) -> [Vec3; 4] {
        let RestShape { gradients, volume } = &self.rest.0[element];
        let stress = first_piola(&self.law, &self.rest.deformation_gradient(element, x)) * *volume;
        let [one, two, three] = gradients.map(|gradient| stress * Vec3::from(gradient));
        [-(one + two + three), one, two, three]
    }

    fn hessian(&self, element: usize, x: &[Vec3; 4], projection: Projection) -> LocalHessian<4> {
        let RestShape { gradients, volume } = &self.rest.0[element];
        let stiffness = stiffness(&self.law, &self.rest.deformation_gradient(element, x), projection);
        let blocks = stiffness.tetrahedron(gradients, *volume);
        let mut hessian = [[Mat3::zeros(); 4]; 4];
        let mut upper = blocks.iter();
        for a in 0..4 {
            for (b, block) in (a..4).zip(upper.by_ref()) {
                hessian[a][b] = *block;
                hessian[b][a] = block.transpose();
            }
        }
        hessian
    }

    fn limit_step(&self, element: usize, x: &[Vec3; 4], p: &[Vec3; 4]) -> f64 {
        // At the limit itself the volume may vanish.
        const STAY_INSIDE: f64 = 0.9;
        let f = self.rest.deformation_gradient(element, x);
        let df = self.rest.deformation_gradient(element, p);
        (STAY_INSIDE * self.law.largest_step(&f, &df)).min(1.0)
    }
}

/// Forces on points that depend on nothing: the energy is −Σ fᵢ · xᵢ.
pub(crate) struct DeadForces {
    /// One a point [N].
    pub(crate) forces: Vec<Vec3>,
}

impl Stencil<1> for DeadForces {
    fn value(&self, point: usize, x: &[Vec3; 1]) -> f64 {
        -self.forces[point].dot(&x[0])
    }

    fn gradient(&self, point: usize, _: &[Vec3; 1]) -> [Vec3; 1] {
        [-self.forces[point]]
    }

    fn hessian(&self, _: usize, _: &[Vec3; 1], _: Projection) -> LocalHessian<1> {
        [[Mat3::zeros()]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mechanics_core::derivatives::check_stencil;
    use mechanics_core::law::{Lame, NeoHookean};

    #[test]
    fn gradient_and_hessian_are_derivatives_of_the_energy() {
        let points =
            vec![Vec3::zeros(), Vec3::new(1.0, 0.1, 0.0), Vec3::new(0.2, 0.9, 0.1), Vec3::new(0.1, 0.2, 1.1)];
        let mesh = TetMesh::new(points.clone(), vec![[0, 1, 2, 3]]).expect("a tetrahedron");
        let rest = Arc::new(RestShapes::of(&mesh).expect("it is not flat"));
        let lame = Lame::from_young_poisson(10.0, 0.3).expect("stable constants");
        let stencil = LinearTetrahedra::new(NeoHookean::new(lame), rest);
        let bend = |p: &Vec3| p + Vec3::new(0.1 * p.y * p.z, 0.2 * p.x, -0.1 * p.x * p.x);
        let x: [Vec3; 4] = std::array::from_fn(|i| bend(&points[i]));
        check_stencil(&stencil, 0, &x).require(1e-6).expect("derivatives agree");
    }
}
