//! The ten-node tetrahedron: quadratic shape functions, for when the error should be small.
//!
//! Corners 0..4, then the nodes of the edges (0,1), (1,2), (0,2), (0,3), (1,3), (2,3), as VTK and Gmsh's files order corners and VTK
//! orders edges. With barycentric coordinates L the shape functions are
//!
//! - Lₐ(2Lₐ − 1) at corner a, and 4 LₐL_b at the middle of the edge (a, b).
//!
//! The rest shape is isoparametric: X(ξ) = Σ Nₐ Xₐ, so ∇Nₐ = J⁻ᵀ ∂Nₐ/∂ξ with J = ∂X/∂ξ. The energy is integrated with four points,
//! at the barycentric coordinates (α, β, β, β) and permutations, α = (5 + 3√5)/20, β = (5 − √5)/20, each with the weight
//! det J/24. That is exact for polynomials of degree two: for straight edges and small strain the stiffness is exact. On
//! each point the element is computed as a linear one is, with ten gradients instead of four.
//!
//! **Where det F > 0 holds.** A law that needs det F > 0 is asked at the quadrature points, and a step is limited so that it holds there:
//! the energy tends to +∞ at these points and nowhere else. Between them and the corners an element may be inside out all the
//! same, by a little, in strong bending; [`jacobian_lower_bound`] tells whether it is.
//!
//! Masses ∫ ρ Nₐ N_b dV have degree four for straight edges and seven for curved ones, so they take a rule of their own: Gauss's with 5³
//! points in collapsed coordinates, exact to degree seven, its weights positive.
//!
//! # Reference
//! Zienkiewicz, Taylor, *The Finite Element Method*, vol. 1, 2000, sections 8.8 and 9.10; Hammer, Marlowe, Stroud, *Numerical
//! integration over simplexes and cones*, MTAC 10 (1956), for the four-point rule; Stroud, *Approximate Calculation of Multiple
//! Integrals*, 1971, section 2.5, for collapsed coordinates.

use super::error::{ElementError, check_points, check_positive};
use super::mass::{Mass, MassDistribution};
use super::packets::{load_points, store_vectors};
use super::tetrahedron::STAY_INSIDE;
use mechanics_core::lanes::{Element, LaneKernel, Packet, dispatch, store_matrices};
use mechanics_core::law::{Domain, Hyperelastic};
use mechanics_core::mesh::TetMesh;
use mechanics_core::projection::Projection;
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Matrix3, Vec3, add_scaled, from_columns, zero};

/// The corners that an edge node lies between, for nodes 4 to 9.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Points of the energy's rule.
const POINTS: usize = 4;

/// What an element keeps for one quadrature point: ten gradients [1/m], a weight \[m³\], and a zero.
type Record = [f64; 32];

/// A mesh of ten-node tetrahedra.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadraticMesh {
    /// Corners as in the linear mesh, then one node per edge \[m\].
    pub points: Vec<Vec3>,
    /// Ten nodes per element.
    pub cells: Vec<[u32; 10]>,
}

impl QuadraticMesh {
    /// The linear mesh with a node at the middle of every edge.
    pub fn new(mesh: &TetMesh) -> Self {
        let mut edges: Vec<[u32; 2]> =
            mesh.cells().iter().flat_map(|cell| EDGES.map(|edge| ordered(edge.map(|a| cell[a])))).collect();
        edges.sort_unstable();
        edges.dedup();
        let middle = |edge: &[u32; 2]| {
            let [a, b] = edge.map(|i| mesh.points()[i as usize]);
            (a + b) * 0.5
        };
        let corners = mesh.points().len();
        let points = mesh.points().iter().copied().chain(edges.iter().map(middle)).collect();
        let node = |edge: [u32; 2]| (corners + edges.partition_point(|other| *other < edge)) as u32;
        let cells = mesh.cells().iter().map(|cell| {
            let mut nodes = [0; 10];
            nodes[..4].copy_from_slice(cell);
            for (target, edge) in nodes[4..].iter_mut().zip(EDGES) {
                *target = node(ordered(edge.map(|a| cell[a])));
            }
            nodes
        });
        Self { cells: cells.collect(), points }
    }
}

fn ordered([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Ten-node tetrahedra of one material.
#[derive(Clone, Debug)]
pub struct QuadraticTetrahedra<L> {
    law: L,
    rest: Vec<[Record; POINTS]>,
}

impl<L: Hyperelastic> QuadraticTetrahedra<L> {
    /// The elements `cells` with their nodes at rest in `points` \[m\].
    ///
    /// # Errors
    /// [`ElementError`] names the element that folds over or is inside out at rest, or the node that is wrong.
    pub fn new(law: L, points: &[Vec3], cells: &[[u32; 10]]) -> Result<Self, ElementError> {
        check_points(points, cells)?;
        let rest = cells
            .iter()
            .enumerate()
            .map(|(element, cell)| rest_records(element, &cell.map(|i| points[i as usize])))
            .collect::<Result<_, _>>()?;
        Ok(Self { law, rest })
    }

    /// The elastic energy of a mesh at rest, as a term.
    ///
    /// # Errors
    /// [`ElementError`] as [`new`](Self::new), or the node that belongs to no element.
    pub fn term(
        name: impl Into<String>,
        law: L,
        mesh: &QuadraticMesh,
    ) -> Result<StencilTerm<Self, 10>, ElementError> {
        let mut used = vec![false; mesh.points.len()];
        let stencil = Self::new(law, &mesh.points, &mesh.cells)?;
        mesh.cells.as_flattened().iter().for_each(|&i| used[i as usize] = true);
        if let Some(point) = used.iter().position(|used| !used) {
            return Err(ElementError::Unreferenced { point: point as u32 });
        }
        Ok(StencilTerm::new(name, stencil, mesh.cells.clone())?)
    }

    /// F at a quadrature point of an element with its nodes at `x`.
    fn deformation_gradient(&self, element: usize, point: usize, x: &[Vec3; 10]) -> Mat3 {
        gradient_of(&self.rest[element][point], &x.map(Into::into))
    }
}

impl Mass {
    /// Adds ten-node tetrahedra of density ρ [kg/m³], their nodes at rest in `points` \[m\].
    ///
    /// # Errors
    /// [`ElementError`] names the density, element or node that is wrong; nothing has changed then.
    pub fn add_quadratic_tetrahedra(
        &mut self,
        points: &[Vec3],
        cells: &[[u32; 10]],
        density: f64,
        distribution: MassDistribution,
    ) -> Result<(), ElementError> {
        check_positive("density", "material", 0, density)?;
        check_points(points, cells)?;
        let rule = collapsed_rule();
        let shapes: Vec<([f64; 10], [Vec3; 10], f64)> =
            rule.iter().map(|(xi, weight)| (shape(xi), shape_derivatives(xi), *weight)).collect();
        let mut local = Vec::with_capacity(cells.len());
        for (element, cell) in cells.iter().enumerate() {
            let x = cell.map(|i| points[i as usize]);
            let mut masses = [[0.0; 10]; 10];
            for (values, derivatives, weight) in &shapes {
                let volume = weight * positive_determinant(element, &jacobian(&x, derivatives))?;
                for (a, b) in (0..10).flat_map(|a| (0..=a).map(move |b| (a, b))) {
                    masses[a][b] += density * volume * values[a] * values[b];
                }
            }
            local.push(masses);
        }
        self.add_elements(cells, distribution, |element| local[element])
    }
}

/// The values of the shape functions at ξ, the barycentric coordinates of corners 1, 2, 3.
fn shape(xi: &Vec3) -> [f64; 10] {
    let l = [1.0 - xi.sum(), xi.x, xi.y, xi.z];
    std::array::from_fn(|a| match a.checked_sub(4) {
        None => l[a] * (2.0 * l[a] - 1.0),
        Some(edge) => 4.0 * l[EDGES[edge][0]] * l[EDGES[edge][1]],
    })
}

/// ∂Nₐ/∂ξ.
fn shape_derivatives(xi: &Vec3) -> [Vec3; 10] {
    let l = [1.0 - xi.sum(), xi.x, xi.y, xi.z];
    let dl = [Vec3::repeat(-1.0), Vec3::x(), Vec3::y(), Vec3::z()];
    std::array::from_fn(|a| match a.checked_sub(4) {
        None => dl[a] * (4.0 * l[a] - 1.0),
        Some(edge) => {
            let [b, c] = EDGES[edge];
            (dl[b] * l[c] + dl[c] * l[b]) * 4.0
        }
    })
}

/// A lower bound of det ∂x/∂ξ over a whole element with its nodes at `x`, six times the volume \[m³\] if its edges are straight.
///
/// Positive, it certifies (up to rounding) that the element is nowhere inside out: det F = det ∂x/∂ξ / det ∂X/∂ξ. Not positive, it says
/// nothing but that the element bends strongly.
///
/// ∂x/∂ξ is affine in the barycentric coordinates, Σ Lₖ Jₖ with Jₖ at corner k, and the determinant linear in each column, so that with
/// the columns Jₖ¹, Jₖ², Jₖ³
///
/// det ∂x/∂ξ = Σᵢⱼₖ LᵢLⱼLₖ det \[Jᵢ¹ Jⱼ² Jₖ³\] = Σ_{i≤j≤k} B_ijk b_ijk,
///
/// Bernstein's cubics B, and b the mean of the determinants over the permutations of i, j, k. The cubics are
/// not negative and sum to one, so the smallest of the twenty b is a bound, attained at a corner if it belongs to one.
///
/// # Reference
/// A. Johnen, J.-F. Remacle, C. Geuzaine, *Geometrical validity of curvilinear finite elements*, J. Comput. Phys. 233 (2013),
/// section 3.
pub fn jacobian_lower_bound(x: &[Vec3; 10]) -> f64 {
    let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    let jacobians = corners.map(|xi| jacobian(x, &shape_derivatives(&xi)));
    let mixed = |[i, j, k]: [usize; 3]| {
        jacobians[i].column(0).dot(&jacobians[j].column(1).cross(&jacobians[k].column(2)))
    };
    let mean = |i: usize, j: usize, k: usize| {
        let orders = [[i, j, k], [j, k, i], [k, i, j], [i, k, j], [k, j, i], [j, i, k]];
        orders.map(mixed).iter().sum::<f64>() / 6.0
    };
    let triples = (0..4).flat_map(|i| (i..4).flat_map(move |j| (j..4).map(move |k| (i, j, k))));
    triples.map(|(i, j, k)| mean(i, j, k)).fold(f64::INFINITY, f64::min)
}

/// J = Σ Xₐ ⊗ ∂Nₐ/∂ξ.
fn jacobian(x: &[Vec3; 10], derivatives: &[Vec3; 10]) -> Mat3 {
    x.iter().zip(derivatives).map(|(x, d)| x * d.transpose()).sum()
}

fn positive_determinant(element: usize, jacobian: &Mat3) -> Result<f64, ElementError> {
    let determinant = jacobian.determinant();
    if determinant > 0.0 { Ok(determinant) } else { Err(ElementError::RestFold { element, determinant }) }
}

fn rest_records(element: usize, x: &[Vec3; 10]) -> Result<[Record; POINTS], ElementError> {
    let root = 5.0_f64.sqrt();
    let (alpha, beta) = ((5.0 + 3.0 * root) / 20.0, (5.0 - root) / 20.0);
    let mut records = [[0.0; 32]; POINTS];
    for (point, record) in records.iter_mut().enumerate() {
        let xi = Vec3::from_fn(|k, _| if k + 1 == point { alpha } else { beta });
        let derivatives = shape_derivatives(&xi);
        let jacobian = jacobian(x, &derivatives);
        let determinant = positive_determinant(element, &jacobian)?;
        let inverse = jacobian.try_inverse().ok_or(ElementError::RestFold { element, determinant })?;
        for a in 0..10 {
            let gradient = inverse.tr_mul(&derivatives[a]);
            record[3 * a..3 * a + 3].copy_from_slice(gradient.as_slice());
        }
        record[30] = determinant / 24.0;
    }
    Ok(records)
}

/// Nodes ξ and weights of the rule for masses; the weights sum to the volume ⅙ of the unit tetrahedron.
fn collapsed_rule() -> Vec<(Vec3, f64)> {
    let line = gauss_legendre();
    let mut rule = Vec::with_capacity(125);
    for (u, wu) in line {
        for (v, wv) in line {
            for (w, ww) in line {
                let (rest, remainder) = (1.0 - w, 1.0 - v);
                let xi = Vec3::new(u * remainder * rest, v * rest, w);
                rule.push((xi, wu * wv * ww * rest * rest * remainder));
            }
        }
    }
    rule
}

/// Gauss's rule with five points on \[0, 1\]: the roots 0 and ±⅓√(5 ∓ 2√(10/7)) of Legendre's P₅, with the weights
/// 128/225 and (322 ± 13√70)/900, moved from \[−1, 1\].
fn gauss_legendre() -> [(f64, f64); 5] {
    let inner = (5.0 - 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0;
    let outer = (5.0 + 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0;
    let (near, far) = ((322.0 + 13.0 * 70.0_f64.sqrt()) / 900.0, (322.0 - 13.0 * 70.0_f64.sqrt()) / 900.0);
    let centre = 128.0 / 225.0;
    [(-outer, far), (-inner, near), (0.0, centre), (inner, near), (outer, far)]
        .map(|(x, w)| (0.5 * (1.0 + x), 0.5 * w))
}

/// F = Σₐ xₐ ⊗ ∇Nₐ, the positions taken relative to node 0 since the gradients sum to zero.
#[inline(always)]
fn gradient_of<S: Scalar>(rest: &[S; 32], x: &[[S; 3]; 10]) -> Matrix3<S> {
    let mut columns = [[S::constant(0.0); 3]; 3];
    for a in 1..10 {
        for i in 0..3 {
            let edge = x[a][i] - x[0][i];
            for j in 0..3 {
                columns[j][i] = edge.mul_add(rest[3 * a + j], columns[j][i]);
            }
        }
    }
    from_columns(columns)
}

#[inline(always)]
fn add_forces<S: Scalar, L: Hyperelastic>(
    law: &L,
    rest: &[S; 32],
    x: &[[S; 3]; 10],
    forces: &mut [[S; 3]; 10],
) {
    let stress = law.first_piola(&gradient_of(rest, x));
    for a in 0..10 {
        for j in 0..3 {
            let scaled = rest[3 * a + j] * rest[30];
            for i in 0..3 {
                forces[a][i] = stress[(i, j)].mul_add(scaled, forces[a][i]);
            }
        }
    }
}

/// Blocks (a, b), b ≤ a, of the Hessian, row by row.
type LowerTriangle<S> = [Matrix3<S>; 55];

#[inline(always)]
fn add_stiffness<S: Scalar, L: Hyperelastic>(
    law: &L,
    rest: &[S; 32],
    x: &[[S; 3]; 10],
    projection: Projection,
    blocks: &mut LowerTriangle<S>,
) {
    let stiffness = law.stiffness(&gradient_of(rest, x), projection);
    let mut at = 0;
    for a in 0..10 {
        for b in 0..=a {
            let (ga, gb) = (gradient(rest, a), gradient(rest, b));
            blocks[at] = add_scaled(&blocks[at], rest[30], &stiffness.contraction(&ga, &gb));
            at += 1;
        }
    }
}

#[inline(always)]
fn gradient<S: Scalar>(rest: &[S; 32], node: usize) -> [S; 3] {
    [rest[3 * node], rest[3 * node + 1], rest[3 * node + 2]]
}

impl<L: Hyperelastic> Stencil<10> for QuadraticTetrahedra<L> {
    fn value(&self, element: usize, x: &[Vec3; 10]) -> f64 {
        let x = x.map(Into::into);
        let energy = |rest: &Record| self.law.energy_density(&gradient_of(rest, &x)) * rest[30];
        self.rest[element].iter().map(energy).sum()
    }

    fn gradient(&self, element: usize, x: &[Vec3; 10]) -> [Vec3; 10] {
        let x = x.map(Into::into);
        let mut forces = [[0.0; 3]; 10];
        for rest in &self.rest[element] {
            add_forces(&self.law, rest, &x, &mut forces);
        }
        forces.map(Vec3::from)
    }

    fn hessian(&self, element: usize, x: &[Vec3; 10], projection: Projection) -> LocalHessian<10> {
        let mut hessian = [[[Mat3::zeros(); 10]; 10]];
        let rest = &self.rest[element..=element];
        HessianKernel { law: &self.law, rest, x: &[*x], projection, hessians: &mut hessian }.one_by_one();
        hessian[0]
    }

    /// det F stays positive at the quadrature points; elsewhere it may not, see the module.
    fn limit_step(&self, element: usize, x: &[Vec3; 10], p: &[Vec3; 10]) -> f64 {
        if self.law.domain() == Domain::EveryDeformation {
            return 1.0;
        }
        let limit = |point: usize| {
            let f = self.deformation_gradient(element, point, x);
            let df = self.deformation_gradient(element, point, p);
            (STAY_INSIDE * self.law.largest_step(&f, &df)).min(1.0)
        };
        (0..POINTS).map(limit).fold(1.0, f64::min)
    }

    fn values_into(&self, first: usize, x: &[[Vec3; 10]], values: &mut [f64]) {
        dispatch(ValueKernel { law: &self.law, rest: &self.rest[first..first + x.len()], x, values });
    }

    fn gradients_into(&self, first: usize, x: &[[Vec3; 10]], gradients: &mut [[Vec3; 10]]) {
        dispatch(GradientKernel { law: &self.law, rest: &self.rest[first..first + x.len()], x, gradients });
    }

    fn hessians_into(
        &self,
        first: usize,
        x: &[[Vec3; 10]],
        projection: Projection,
        hessians: &mut [LocalHessian<10>],
    ) {
        let rest = &self.rest[first..first + x.len()];
        dispatch(HessianKernel { law: &self.law, rest, x, projection, hessians });
    }
}

const LANES: usize = <f64 as Element>::LANES;

/// The records of one quadrature point of up to four consecutive elements; lanes beyond the last element repeat it.
#[inline(always)]
fn load_rest<P: Packet<Element = f64>>(rest: &[[Record; POINTS]], point: usize) -> [P; 32] {
    let last = rest.len() - 1;
    let mut numbers = [P::constant(0.0); 32];
    for block in 0..8 {
        let at = 4 * block;
        let mut rows = [
            P::load(&rest[0][point][at..]),
            P::load(&rest[last.min(1)][point][at..]),
            P::load(&rest[last.min(2)][point][at..]),
            P::load(&rest[last.min(3)][point][at..]),
        ];
        P::transpose(&mut rows);
        numbers[at..at + 4].copy_from_slice(&rows);
    }
    numbers
}

struct ValueKernel<'a, L> {
    law: &'a L,
    rest: &'a [[Record; POINTS]],
    x: &'a [[Vec3; 10]],
    values: &'a mut [f64],
}

impl<L: Hyperelastic> LaneKernel<f64> for ValueKernel<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let parts = self.rest.chunks(LANES).zip(self.x.chunks(LANES)).zip(self.values.chunks_mut(LANES));
        for ((rest, x), values) in parts {
            let x = load_points::<P, 10>(x);
            let mut sum = P::constant(0.0);
            for point in 0..POINTS {
                let rest = load_rest::<P>(rest, point);
                sum += self.law.energy_density(&gradient_of(&rest, &x)) * rest[30];
            }
            sum.store_prefix(values);
        }
    }
}

struct GradientKernel<'a, L> {
    law: &'a L,
    rest: &'a [[Record; POINTS]],
    x: &'a [[Vec3; 10]],
    gradients: &'a mut [[Vec3; 10]],
}

impl<L: Hyperelastic> LaneKernel<f64> for GradientKernel<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let parts = self.rest.chunks(LANES).zip(self.x.chunks(LANES)).zip(self.gradients.chunks_mut(LANES));
        for ((rest, x), gradients) in parts {
            let x = load_points::<P, 10>(x);
            let mut forces = [[P::constant(0.0); 3]; 10];
            for point in 0..POINTS {
                add_forces(self.law, &load_rest::<P>(rest, point), &x, &mut forces);
            }
            store_vectors(&forces, gradients);
        }
    }
}

struct HessianKernel<'a, L> {
    law: &'a L,
    rest: &'a [[Record; POINTS]],
    x: &'a [[Vec3; 10]],
    projection: Projection,
    hessians: &'a mut [LocalHessian<10>],
}

impl<L: Hyperelastic> HessianKernel<'_, L> {
    /// Without lanes.
    fn one_by_one(self) {
        for ((rest, x), hessian) in self.rest.iter().zip(self.x).zip(self.hessians) {
            let x = x.map(Into::into);
            let mut blocks = [Mat3::zeros(); 55];
            for rest in rest {
                add_stiffness(self.law, rest, &x, self.projection, &mut blocks);
            }
            let pairs = (0..10).flat_map(|a| (0..=a).map(move |b| (a, b)));
            for (block, (a, b)) in blocks.iter().zip(pairs) {
                hessian[a][b] = *block;
                hessian[b][a] = block.transpose();
            }
        }
    }
}

impl<L: Hyperelastic> LaneKernel<f64> for HessianKernel<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) {
        let parts = self.rest.chunks(LANES).zip(self.x.chunks(LANES)).zip(self.hessians.chunks_mut(LANES));
        for ((rest, x), hessians) in parts {
            let x = load_points::<P, 10>(x);
            let mut blocks = [zero(); 55];
            for point in 0..POINTS {
                let rest = load_rest::<P>(rest, point);
                add_stiffness(self.law, &rest, &x, self.projection, &mut blocks);
            }
            let mut at = 0;
            for a in 0..10 {
                for b in 0..=a {
                    store_matrices(&blocks[at], hessians.iter_mut().map(|hessian| &mut hessian[a][b]));
                    at += 1;
                }
            }
        }
    }
}
