//! A triangle with its neighbours' far corners.

use crate::element::hinge::{dihedral_angle, dihedral_derivatives, dihedral_gradient};
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::{Mat3, Vec3};

/// One of a patch's angles.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PatchHinge {
    /// The four points, as numbers within the patch, ordered as
    /// [`dihedral_angle`](crate::element::hinge::dihedral_angle) has them.
    points: [usize; 4],
    rest: f64,
    /// Squared lengths of the triangles' normals below which they count as collapsed \[m⁴\].
    collapsed: [f64; 2],
}

/// Twice a triangle's area over twice its rest area, below which it has no normal.
const COLLAPSED: f64 = 1e-8;

impl PatchHinge {
    pub(super) fn new(points: [usize; 4], rest: f64, rest_areas: [f64; 2]) -> Self {
        Self { points, rest, collapsed: rest_areas.map(|area| (COLLAPSED * 2.0 * area).powi(2)) }
    }
}

/// ½ Σᵢⱼ Qᵢⱼ (θᵢ − θ̄ᵢ)(θⱼ − θ̄ⱼ) over one to three hinges.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Patch {
    hinges: [PatchHinge; 3],
    count: usize,
    stiffness: [[f64; 3]; 3],
}

impl Patch {
    pub(super) fn new(hinges: Vec<PatchHinge>, stiffness: impl Fn(usize, usize) -> f64) -> Self {
        let mut patch = Self { count: hinges.len(), ..Self::default() };
        for (i, hinge) in hinges.iter().enumerate() {
            patch.hinges[i] = *hinge;
            for j in 0..hinges.len() {
                patch.stiffness[i][j] = stiffness(i, j);
            }
        }
        patch
    }

    fn hinges(&self) -> &[PatchHinge] {
        &self.hinges[..self.count]
    }

    /// Σⱼ Qᵢⱼ (θⱼ − θ̄ⱼ) and the energy; `None` where a triangle has collapsed.
    fn moments<const N: usize>(&self, x: &[Vec3; N]) -> Option<([f64; 3], f64)> {
        let mut turned = [0.0; 3];
        for (turned, hinge) in turned.iter_mut().zip(self.hinges()) {
            let corners = hinge.points.map(|i| x[i]);
            let edge = corners[1] - corners[0];
            let normals = [corners[2], corners[3]].map(|tip| edge.cross(&(tip - corners[0])).norm_squared());
            if normals[0] <= hinge.collapsed[0] || normals[1] <= hinge.collapsed[1] {
                return None;
            }
            *turned = dihedral_angle(&corners) - hinge.rest;
        }
        let moments = self.stiffness.map(|row| row[0] * turned[0] + row[1] * turned[1] + row[2] * turned[2]);
        let work: f64 = moments.iter().zip(turned).map(|(moment, turned)| moment * turned).sum();
        Some((moments, 0.5 * work))
    }

    /// ∇θᵢ over the patch's points.
    fn gradients<const N: usize>(&self, x: &[Vec3; N]) -> [[Vec3; N]; 3] {
        let mut gradients = [[Vec3::zeros(); N]; 3];
        for (gradient, hinge) in gradients.iter_mut().zip(self.hinges()) {
            for (point, g) in hinge.points.iter().zip(dihedral_gradient(&hinge.points.map(|i| x[i]))) {
                gradient[*point] += g;
            }
        }
        gradients
    }
}

/// The patches of `N` points of a [`PlateBending`](super::PlateBending).
///
/// The Hessian is Σᵢⱼ Qᵢⱼ ∇θᵢ⊗∇θⱼ + Σᵢ mᵢ ∇∇θᵢ with the moments m = Q (θ − θ̄). A projection leaves the second part out
/// (Gauss and Newton's approximation), because Q is positive semi-definite.
#[derive(Clone, Debug, Default)]
pub struct Patches<const N: usize>(Vec<Patch>);

impl<const N: usize> Patches<N> {
    pub(super) fn add(&mut self, elements: &mut Vec<[u32; N]>, points: [u32; N], patch: Patch) {
        elements.push(points);
        self.0.push(patch);
    }
}

impl<const N: usize> Stencil<N> for Patches<N> {
    fn value(&self, element: usize, x: &[Vec3; N]) -> f64 {
        self.0[element].moments(x).map_or(0.0, |(_, energy)| energy)
    }

    fn gradient(&self, element: usize, x: &[Vec3; N]) -> [Vec3; N] {
        let patch = &self.0[element];
        let Some((moments, _)) = patch.moments(x) else { return [Vec3::zeros(); N] };
        let gradients = patch.gradients(x);
        std::array::from_fn(|i| (0..patch.count).map(|k| gradients[k][i] * moments[k]).sum())
    }

    fn hessian(&self, element: usize, x: &[Vec3; N], projection: Projection) -> LocalHessian<N> {
        let patch = &self.0[element];
        let mut hessian = [[Mat3::zeros(); N]; N];
        let Some((moments, _)) = patch.moments(x) else { return hessian };
        let gradients = patch.gradients(x);
        // Q ∇θ first: three vectors a point.
        let pulled: [[Vec3; 3]; N] = std::array::from_fn(|j| {
            std::array::from_fn(|k| (0..patch.count).map(|l| gradients[l][j] * patch.stiffness[k][l]).sum())
        });
        for i in 0..N {
            for j in 0..=i {
                for (gradient, pulled) in gradients.iter().zip(&pulled[j]).take(patch.count) {
                    hessian[i][j] += gradient[i] * pulled.transpose();
                }
            }
        }
        if projection == Projection::None {
            for (hinge, moment) in patch.hinges().iter().zip(moments) {
                let second = dihedral_derivatives(&hinge.points.map(|i| x[i])).hessian;
                for (a, &i) in hinge.points.iter().enumerate() {
                    for (b, &j) in hinge.points.iter().enumerate() {
                        if i >= j {
                            hessian[i][j] += second[a][b] * moment;
                        }
                    }
                }
            }
        }
        for i in 0..N {
            for j in 0..i {
                hessian[j][i] = hessian[i][j].transpose();
            }
        }
        hessian
    }
}
