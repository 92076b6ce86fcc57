//! The geometrically linear membrane.

use super::{Mat3x2, RestTriangle, SheetStiffness};
use crate::element::thin_error::{ThinError, positive};
use mechanics_core::law::Lame;
use mechanics_core::mesh::TriMesh;
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::Vec3;

/// Membrane triangles of linear elasticity in plane stress: displacements so small that the strain is
/// ε_{jl} = ½ (tⱼ · ∂_l u + t_l · ∂ⱼ u) = ½ (tⱼ·F_l + t_l·Fⱼ) − δ_{jl}, with the rest tangents t and F's columns Fⱼ.
///
/// - E = A t (μ ε:ε + ½λ' (tr ε)²),  λ' = E_Y ν/(1 − ν²),
///
/// a quadratic form whose Hessian is the constant, positive semi-definite matrix of the constant-strain triangle.
/// Displacements out of the plane cost nothing, rotations cost (they are not small): for benchmarks of linear
/// elasticity, such as Cook's membrane.
///
/// # Reference
/// M. J. Turner, R. W. Clough, H. C. Martin, L. J. Topp, *Stiffness and deflection analysis of complex structures*,
/// J. Aeronaut. Sci. 23 (1956).
#[derive(Clone, Debug)]
pub struct LinearMembranes {
    mu: f64,
    lambda: f64,
    thickness: f64,
    rest: Vec<RestTriangle>,
}

impl LinearMembranes {
    /// The triangles of `mesh`, at rest where they are: Young's modulus \[Pa\], Poisson's ratio, thickness \[m\].
    ///
    /// # Errors
    /// A parameter out of range; a triangle without area.
    pub fn new(
        mesh: &TriMesh,
        young_modulus: f64,
        poisson_ratio: f64,
        thickness: f64,
    ) -> Result<Self, ThinError> {
        let lame = Lame::from_young_poisson(young_modulus, poisson_ratio)?;
        let lambda = young_modulus * poisson_ratio / (1.0 - poisson_ratio * poisson_ratio);
        let thickness = positive("the thickness", thickness)?;
        let rest =
            (0..mesh.triangles().len()).map(|t| RestTriangle::of(mesh, t)).collect::<Result<_, _>>()?;
        Ok(Self { mu: lame.mu(), lambda, thickness, rest })
    }

    /// The sum over the triangles of `mesh`, as a term of the incremental potential.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn term(
        name: impl Into<String>,
        mesh: &TriMesh,
        young_modulus: f64,
        poisson_ratio: f64,
        thickness: f64,
    ) -> Result<StencilTerm<Self, 3>, ThinError> {
        let stencil = Self::new(mesh, young_modulus, poisson_ratio, thickness)?;
        Ok(StencilTerm::new(name, stencil, mesh.triangles().to_vec())?)
    }

    /// ε₁₁, ε₂₂, ε₁₂.
    fn strain(rest: &RestTriangle, x: &[Vec3; 3]) -> [f64; 3] {
        let f = rest.deformation_gradient(x);
        let [t1, t2] = rest.tangents();
        let (a, b) = (f.column(0), f.column(1));
        [t1.dot(&a) - 1.0, t2.dot(&b) - 1.0, 0.5 * (t1.dot(&b) + t2.dot(&a))]
    }

    /// The stress σ₁₁, σ₂₂, σ₁₂ \[Pa\] of a triangle with its corners at `x`.
    pub fn stress(&self, triangle: usize, x: &[Vec3; 3]) -> [f64; 3] {
        let [e11, e22, e12] = Self::strain(&self.rest[triangle], x);
        let pressure = self.lambda * (e11 + e22);
        [2.0 * self.mu * e11 + pressure, 2.0 * self.mu * e22 + pressure, 2.0 * self.mu * e12]
    }

    fn volume(&self, triangle: usize) -> f64 {
        self.rest[triangle].area() * self.thickness
    }
}

impl Stencil<3> for LinearMembranes {
    fn value(&self, element: usize, x: &[Vec3; 3]) -> f64 {
        let [e11, e22, e12] = Self::strain(&self.rest[element], x);
        let (squares, trace) = (e11 * e11 + e22 * e22 + 2.0 * e12 * e12, e11 + e22);
        self.volume(element) * (self.mu * squares + 0.5 * self.lambda * trace * trace)
    }

    fn gradient(&self, element: usize, x: &[Vec3; 3]) -> [Vec3; 3] {
        let [s11, s22, s12] = self.stress(element, x);
        let rest = &self.rest[element];
        let [t1, t2] = rest.tangents();
        let stress = Mat3x2::from_columns(&[t1 * s11 + t2 * s12, t1 * s12 + t2 * s22]);
        rest.forces(&(stress * self.volume(element)))
    }

    fn hessian(&self, element: usize, _: &[Vec3; 3], _: Projection) -> LocalHessian<3> {
        let rest = &self.rest[element];
        let [t1, t2] = rest.tangents();
        // Rows of ε as linear forms on F's six components; μ ε:ε counts ε₁₂ twice.
        let form = |a: Vec3, b: Vec3| nalgebra::SVector::<f64, 6>::from_iterator(a.iter().chain(&b).copied());
        let (e11, e22) = (form(*t1, Vec3::zeros()), form(Vec3::zeros(), *t2));
        let e12 = form(t2 * 0.5, t1 * 0.5);
        let trace = e11 + e22;
        let stiffness: SheetStiffness =
            (e11 * e11.transpose() + e22 * e22.transpose() + e12 * e12.transpose() * 2.0) * (2.0 * self.mu)
                + trace * trace.transpose() * self.lambda;
        rest.blocks(&(stiffness * self.volume(element)))
    }
}
