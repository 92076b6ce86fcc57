//! The tetrahedron with linear shape functions, total Lagrangian.
//!
//! With rest edges Dₘ = (X₁ − X₀, X₂ − X₀, X₃ − X₀) the rows of Dₘ⁻¹ are the rest gradients ∇N₁, ∇N₂, ∇N₃ of the last three
//! shape functions; ∇N₀ is minus their sum. All of them are constant, and so is
//!
//! - F = ∂x/∂X = Σₐ₌₁..₃ (xₐ − x₀) ⊗ ∇Nₐ.
//!
//! The energy is V ψ(F) with the rest volume V = det Dₘ / 6. With P = ∂ψ/∂F,
//!
//! - force on the element at node a, the gradient: V P ∇Nₐ, and minus the sum of the others at node 0;
//! - Hessian between nodes a and b: Kᵢₖ = V Σⱼₗ ∇Nₐⱼ (∂Pᵢⱼ/∂Fₖₗ) ∇N_bₗ.
//!
//! **Projection.** The Hessian is V Bᵀ (∂P/∂F) B with B the linear map from node positions to F, so it is positive
//! semi-definite if ∂P/∂F is. The law replaces the eigenvalues of ∂P/∂F, which it knows in closed form; no 12×12
//! eigen-problem is solved.
//!
//! Elements are computed four at a time, one a lane.
//!
//! # Reference
//! Bonet, Wood, *Nonlinear Continuum Mechanics for Finite Element Analysis*, 2nd ed., 2008, chapters 7 and 9; Teran,
//! Sifakis, Irving, Fedkiw, *Robust quasistatic finite elements and flesh simulation* (SCA 2005), section 6, for the projection.

use super::error::{ElementError, check_points, check_volume};
use super::packets::{load_points, load_records, store_vectors};
use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch, store_matrices};
use mechanics_core::law::{Domain, Hyperelastic};
use mechanics_core::mesh::TetMesh;
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Matrix3, Vec3, from_entries, transpose};

/// A Newton step goes at most this part of the way to the first inversion: at the inversion itself the energy of a law
/// with [`Domain::PositiveVolume`] is infinite.
pub(super) const STAY_INSIDE: f64 = 0.9;

/// Linear tetrahedra of one material.
#[derive(Clone, Debug)]
pub struct Tetrahedra<L> {
    law: L,
    /// ∇N₁, ∇N₂, ∇N₃ [1/m], V \[m³\], and two zeros, so that records load in blocks of four.
    rest: Vec<[f64; 12]>,
}

impl<L: Hyperelastic> Tetrahedra<L> {
    /// The elements `cells` with their vertices at rest in `points` \[m\].
    ///
    /// # Errors
    /// [`ElementError`] names the element that is flat or inside out at rest, or the vertex that does not exist or rests
    /// at a place that is not finite.
    pub fn new(law: L, points: &[Vec3], cells: &[[u32; 4]]) -> Result<Self, ElementError> {
        check_points(points, cells)?;
        let rest = cells
            .iter()
            .enumerate()
            .map(|(element, cell)| rest_record(element, &cell.map(|i| points[i as usize])))
            .collect::<Result<_, _>>()?;
        Ok(Self { law, rest })
    }

    /// The elastic energy of a mesh at rest, as a term.
    ///
    /// # Errors
    /// [`ElementError`] names the element that is flat or inside out at rest, or the vertex that belongs to none.
    pub fn term(
        name: impl Into<String>,
        law: L,
        mesh: &TetMesh,
    ) -> Result<StencilTerm<Self, 4>, ElementError> {
        if let Some(&point) = mesh.unreferenced_points().first() {
            return Err(ElementError::Unreferenced { point });
        }
        let stencil = Self::new(law, mesh.points(), mesh.cells())?;
        Ok(StencilTerm::new(name, stencil, mesh.cells().to_vec())?)
    }

    /// The law.
    pub fn law(&self) -> &L {
        &self.law
    }

    /// The rest volume of an element \[m³\].
    ///
    /// # Panics
    /// If there is no such element.
    pub fn rest_volume(&self, element: usize) -> f64 {
        self.rest[element][9]
    }

    /// F of an element with its vertices at `x`.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn deformation_gradient(&self, element: usize, x: &[Vec3; 4]) -> Mat3 {
        gradient_of(&self.rest[element], &x.map(Into::into))
    }
}

/// The record of a rest shape.
fn rest_record(element: usize, corners: &[Vec3; 4]) -> Result<[f64; 12], ElementError> {
    check_volume(element, corners)?;
    let [a, b, c, d] = corners;
    let edges = Mat3::from_columns(&[b - a, c - a, d - a]);
    let volume = edges.determinant() / 6.0;
    let inverse = edges.try_inverse().filter(|_| volume > 0.0);
    let inverse = inverse.filter(|inverse| inverse.iter().all(|entry| entry.is_finite()));
    let Some(inverse) = inverse else {
        return Err(ElementError::RestVolume { element, volume });
    };
    let mut record = [0.0; 12];
    for (k, entry) in record[..9].iter_mut().enumerate() {
        *entry = inverse[(k / 3, k % 3)];
    }
    record[9] = volume;
    Ok(record)
}

/// F = Σₐ (xₐ − x₀) ⊗ ∇Nₐ.
#[inline(always)]
fn gradient_of<S: Scalar>(rest: &[S; 12], x: &[[S; 3]; 4]) -> Matrix3<S> {
    let zero = S::constant(0.0);
    let mut edges = [[zero; 3]; 3];
    for a in 0..3 {
        for i in 0..3 {
            edges[a][i] = x[a + 1][i] - x[0][i];
        }
    }
    from_entries(|i, j| {
        let first = edges[0][i] * rest[j];
        edges[2][i].mul_add(rest[6 + j], edges[1][i].mul_add(rest[3 + j], first))
    })
}

/// V ψ(F).
#[inline(always)]
fn energy<S: Scalar, L: Hyperelastic>(law: &L, rest: &[S; 12], x: &[[S; 3]; 4]) -> S {
    law.energy_density(&gradient_of(rest, x)) * rest[9]
}

/// V P ∇Nₐ.
#[inline(always)]
fn forces<S: Scalar, L: Hyperelastic>(law: &L, rest: &[S; 12], x: &[[S; 3]; 4]) -> [[S; 3]; 4] {
    let stress = law.first_piola(&gradient_of(rest, x));
    let mut forces = [[S::constant(0.0); 3]; 4];
    for a in 0..3 {
        let scaled = [rest[3 * a] * rest[9], rest[3 * a + 1] * rest[9], rest[3 * a + 2] * rest[9]];
        for i in 0..3 {
            let first = stress[(i, 0)] * scaled[0];
            forces[a + 1][i] = stress[(i, 2)].mul_add(scaled[2], stress[(i, 1)].mul_add(scaled[1], first));
        }
    }
    for i in 0..3 {
        forces[0][i] = -(forces[1][i] + forces[2][i] + forces[3][i]);
    }
    forces
}

/// The blocks (a, b) of the Hessian with a ≤ b.
#[inline(always)]
fn stiffness<S: Scalar, L: Hyperelastic>(
    law: &L,
    rest: &[S; 12],
    x: &[[S; 3]; 4],
    projection: Projection,
) -> [Matrix3<S>; 10] {
    let gradients = [[rest[0], rest[1], rest[2]], [rest[3], rest[4], rest[5]], [rest[6], rest[7], rest[8]]];
    law.stiffness(&gradient_of(rest, x), projection).tetrahedron(&gradients, rest[9])
}

/// Row and column of the ten blocks with row ≤ column.
const UPPER: [(usize, usize); 10] =
    [(0, 0), (0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3)];

impl<L: Hyperelastic> Stencil<4> for Tetrahedra<L> {
    fn value(&self, element: usize, x: &[Vec3; 4]) -> f64 {
        energy(&self.law, &self.rest[element], &x.map(Into::into))
    }

    fn gradient(&self, element: usize, x: &[Vec3; 4]) -> [Vec3; 4] {
        forces(&self.law, &self.rest[element], &x.map(Into::into)).map(Vec3::from)
    }

    fn hessian(&self, element: usize, x: &[Vec3; 4], projection: Projection) -> LocalHessian<4> {
        let blocks = stiffness(&self.law, &self.rest[element], &x.map(Into::into), projection);
        let mut hessian = [[Mat3::zeros(); 4]; 4];
        for (block, (a, b)) in blocks.iter().zip(UPPER) {
            hessian[a][b] = *block;
            hessian[b][a] = block.transpose();
        }
        hessian
    }

    fn limit_step(&self, element: usize, x: &[Vec3; 4], p: &[Vec3; 4]) -> f64 {
        if self.law.domain() == Domain::EveryDeformation {
            return 1.0;
        }
        let f = self.deformation_gradient(element, x);
        let df = self.deformation_gradient(element, p);
        (STAY_INSIDE * self.law.largest_step(&f, &df)).min(1.0)
    }

    fn values_into(&self, first: usize, x: &[[Vec3; 4]], values: &mut [f64]) {
        dispatch(Values { law: &self.law, rest: &self.rest[first..first + x.len()], x, values });
    }

    fn gradients_into(&self, first: usize, x: &[[Vec3; 4]], gradients: &mut [[Vec3; 4]]) {
        dispatch(Gradients { law: &self.law, rest: &self.rest[first..first + x.len()], x, gradients });
    }

    fn hessians_into(
        &self,
        first: usize,
        x: &[[Vec3; 4]],
        projection: Projection,
        hessians: &mut [LocalHessian<4>],
    ) {
        let rest = &self.rest[first..first + x.len()];
        dispatch(Hessians { law: &self.law, rest, x, projection, hessians });
    }
}

const LANES: usize = <f64 as Element>::LANES;

struct Values<'a, L> {
    law: &'a L,
    rest: &'a [[f64; 12]],
    x: &'a [[Vec3; 4]],
    values: &'a mut [f64],
}

impl<L: Hyperelastic> LaneKernel<f64> for Values<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let parts = self.rest.chunks(LANES).zip(self.x.chunks(LANES)).zip(self.values.chunks_mut(LANES));
        for ((rest, x), values) in parts {
            energy(self.law, &load_records::<P>(rest), &load_points(x)).store_prefix(values);
        }
    }
}

struct Gradients<'a, L> {
    law: &'a L,
    rest: &'a [[f64; 12]],
    x: &'a [[Vec3; 4]],
    gradients: &'a mut [[Vec3; 4]],
}

impl<L: Hyperelastic> LaneKernel<f64> for Gradients<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let parts = self.rest.chunks(LANES).zip(self.x.chunks(LANES)).zip(self.gradients.chunks_mut(LANES));
        for ((rest, x), gradients) in parts {
            store_vectors(&forces(self.law, &load_records::<P>(rest), &load_points(x)), gradients);
        }
    }
}

struct Hessians<'a, L> {
    law: &'a L,
    rest: &'a [[f64; 12]],
    x: &'a [[Vec3; 4]],
    projection: Projection,
    hessians: &'a mut [LocalHessian<4>],
}

impl<L: Hyperelastic> LaneKernel<f64> for Hessians<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let parts = self.rest.chunks(LANES).zip(self.x.chunks(LANES)).zip(self.hessians.chunks_mut(LANES));
        for ((rest, x), hessians) in parts {
            let blocks = stiffness(self.law, &load_records::<P>(rest), &load_points(x), self.projection);
            for n in 0..10 {
                let (a, b) = UPPER[n];
                let lower = transpose(&blocks[n]);
                store_matrices(&lower, hessians.iter_mut().map(|hessian| &mut hessian[b][a]));
            }
        }
    }
}
