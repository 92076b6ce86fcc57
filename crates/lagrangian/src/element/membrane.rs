//! Sheets that resist stretching: triangles with linear shape functions in plane stress.
//!
//! A rest triangle with corners X₀, X₁, X₂ gets two orthonormal tangents t₁, t₂; in them its edges are the columns of
//! the 2×2 matrix Dₘ = (X₁ − X₀, X₂ − X₀). Deformed, the edges are the columns of the 3×2 matrix
//! Dₛ = (x₁ − x₀, x₂ − x₀), and the deformation gradient
//!
//! - F = Dₛ Dₘ⁻¹ = Σₐ xₐ ⊗ ∇Nₐ (3×2), with ∇N₁, ∇N₂ the rows of Dₘ⁻¹ and ∇N₀ = −∇N₁ − ∇N₂,
//!
//! maps rest tangents to tangents in space. With rest area A, thickness t and a law's energy W(F) per rest volume:
//!
//! - E = A t W(F),  ∂E/∂xₐ = A t P ∇Nₐ with P = ∂W/∂F (3×2),
//! - ∂²E/∂xₐ∂x_b = A t Σ_{jl} ∇Nₐⱼ (∂P_{·j}/∂F_{·l}) ∇N_{bl}.
//!
//! A rigid motion turns F into R F, and every law here depends on FᵀF alone. A sheet resists no bending by itself: see
//! [`hinge`](super::hinge).
//!
//! | law | energy per volume | projection |
//! |---|---|---|
//! | [`NeoHookeanSheet`] | neo-Hookean with the thickness stretch that makes σ₃₃ = 0 | closed form |
//! | [`SaintVenantKirchhoffSheet`] | quadratic in the Green strain | closed form |
//! | [`OrthotropicSheet`] | the same with two fibre directions | 6×6 eigenvalues |
//! | [`LinearMembranes`] (a stencil of its own) | small displacements | none needed |
//!
//! # Reference
//! J. Bonet, R. D. Wood, *Nonlinear Continuum Mechanics for Finite Element Analysis*, 2nd ed., 2008, chapters 6 and 9.

mod isotropic;
mod linear;
mod neo_hookean;
mod orthotropic;
mod principal;
mod rest;
mod saint_venant_kirchhoff;

pub use isotropic::{InvariantDerivatives, IsotropicSheet, PlaneStrain};
pub use linear::LinearMembranes;
pub use neo_hookean::NeoHookeanSheet;
pub use orthotropic::OrthotropicSheet;
pub use rest::RestTriangle;
pub use saint_venant_kirchhoff::SaintVenantKirchhoffSheet;

pub(crate) use principal::{Principal, PrincipalStiffness};

use super::thin_error::{ThinError, positive};
use mechanics_core::mesh::TriMesh;
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};

/// A 3×2 matrix: the deformation gradient of a sheet, or the stress that goes with it.
pub type Mat3x2 = nalgebra::Matrix3x2<f64>;
/// A 6×6 matrix ∂P/∂F, with component (i, j) of a 3×2 matrix at 3 j + i.
pub type SheetStiffness = nalgebra::SMatrix<f64, 6, 6>;

/// An elastic law of sheets in plane stress: an energy W(F) per rest volume of a 3×2 deformation gradient.
pub trait SheetLaw: Send + Sync {
    /// W(F) [J/m³]; `+∞` outside the law's domain.
    fn energy_density(&self, f: &Mat3x2) -> f64;

    /// P = ∂W/∂F \[Pa\].
    fn first_piola(&self, f: &Mat3x2) -> Mat3x2;

    /// ∂P/∂F \[Pa\], projected as asked.
    fn stiffness(&self, f: &Mat3x2, projection: Projection) -> SheetStiffness;
}

/// Membrane triangles of one law and one thickness.
#[derive(Clone, Debug)]
pub struct Membranes<L> {
    law: L,
    thickness: f64,
    rest: Vec<RestTriangle>,
}

impl<L: SheetLaw> Membranes<L> {
    /// The triangles of `mesh`, at rest where they are, of thickness `thickness` \[m\]; t₁ runs along each triangle's
    /// first edge.
    ///
    /// # Errors
    /// A thickness that is not positive; a triangle without area.
    pub fn new(mesh: &TriMesh, law: L, thickness: f64) -> Result<Self, ThinError> {
        let thickness = positive("the thickness", thickness)?;
        let rest =
            (0..mesh.triangles().len()).map(|t| RestTriangle::of(mesh, t)).collect::<Result<_, _>>()?;
        Ok(Self { law, thickness, rest })
    }

    /// The same with t₁ along the part of `fibre` in each triangle's plane: what an orthotropic law calls its first
    /// direction.
    ///
    /// # Errors
    /// As [`new`](Self::new); and a triangle that `fibre` is perpendicular to.
    pub fn with_fibre(mesh: &TriMesh, law: L, thickness: f64, fibre: &Vec3) -> Result<Self, ThinError> {
        let thickness = positive("the thickness", thickness)?;
        let rest = |t| RestTriangle::along(mesh, t, fibre);
        let rest = (0..mesh.triangles().len()).map(rest).collect::<Result<_, _>>()?;
        Ok(Self { law, thickness, rest })
    }

    /// The sum over the triangles of `mesh`, at rest where they are, as a term of the incremental potential.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn term(
        name: impl Into<String>,
        mesh: &TriMesh,
        law: L,
        thickness: f64,
    ) -> Result<StencilTerm<Self, 3>, ThinError> {
        Ok(StencilTerm::new(name, Self::new(mesh, law, thickness)?, mesh.triangles().to_vec())?)
    }

    /// The law.
    pub fn law(&self) -> &L {
        &self.law
    }

    /// The thickness \[m\].
    pub fn thickness(&self) -> f64 {
        self.thickness
    }

    /// The rest shapes.
    pub fn rest(&self) -> &[RestTriangle] {
        &self.rest
    }

    /// F of a triangle with its corners at `x`.
    pub fn deformation_gradient(&self, triangle: usize, x: &[Vec3; 3]) -> Mat3x2 {
        self.rest[triangle].deformation_gradient(x)
    }

    /// The consistent mass matrix of a triangle \[kg\] for a density [kg/m³]: ρ A t/12 (1 + δᵢⱼ). For
    /// [`Mass::add_elements`](super::Mass::add_elements).
    pub fn local_mass(&self, triangle: usize, density: f64) -> [[f64; 3]; 3] {
        let part = density * self.volume(triangle) / 12.0;
        [[2.0 * part, part, part], [part, 2.0 * part, part], [part, part, 2.0 * part]]
    }

    fn volume(&self, triangle: usize) -> f64 {
        self.rest[triangle].area() * self.thickness
    }
}

impl<L: SheetLaw> Stencil<3> for Membranes<L> {
    fn value(&self, element: usize, x: &[Vec3; 3]) -> f64 {
        self.volume(element) * self.law.energy_density(&self.deformation_gradient(element, x))
    }

    fn gradient(&self, element: usize, x: &[Vec3; 3]) -> [Vec3; 3] {
        let stress = self.law.first_piola(&self.deformation_gradient(element, x)) * self.volume(element);
        self.rest[element].forces(&stress)
    }

    fn hessian(&self, element: usize, x: &[Vec3; 3], projection: Projection) -> LocalHessian<3> {
        let stiffness = self.law.stiffness(&self.deformation_gradient(element, x), projection);
        self.rest[element].blocks(&(stiffness * self.volume(element)))
    }
}

impl RestTriangle {
    /// P ∇Nₐ for the three corners.
    pub(crate) fn forces(&self, stress: &Mat3x2) -> [Vec3; 3] {
        let [one, two] = self.gradients().map(|g| stress.column(0) * g[0] + stress.column(1) * g[1]);
        [-(one + two), one, two]
    }

    /// Σ_{jl} ∇Nₐⱼ K_{jl} ∇N_{bl} for all pairs of corners, K given by its four 3×3 blocks.
    pub(crate) fn blocks(&self, stiffness: &SheetStiffness) -> LocalHessian<3> {
        let block = |j: usize, l: usize| -> Mat3 { stiffness.fixed_view::<3, 3>(3 * j, 3 * l).into_owned() };
        let (k00, k10, k11) = (block(0, 0), block(1, 0), block(1, 1));
        let k01 = k10.transpose();
        let [g1, g2] = *self.gradients();
        let pair = |a: [f64; 2], b: [f64; 2]| {
            k00 * (a[0] * b[0]) + k01 * (a[0] * b[1]) + k10 * (a[1] * b[0]) + k11 * (a[1] * b[1])
        };
        let (h11, h21, h22) = (pair(g1, g1), pair(g2, g1), pair(g2, g2));
        let (h12, h10, h20) = (h21.transpose(), -(h11 + h21.transpose()), -(h21 + h22));
        let h00 = -(h10 + h20);
        [[h00, h10.transpose(), h20.transpose()], [h10, h11, h12], [h20, h21, h22]]
    }
}
