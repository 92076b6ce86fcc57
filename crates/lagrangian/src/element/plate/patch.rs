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
    /// 2 tan(θ̄/2).
    rest: f64,
    /// Squared lengths of the triangles' normals below which they count as collapsed \[m⁴\].
    collapsed: [f64; 2],
}

/// Twice a triangle's area over twice its rest area, below which it has no normal.
const COLLAPSED: f64 = 1e-8;

impl PatchHinge {
    pub(super) fn new(points: [usize; 4], rest_angle: f64, rest_areas: [f64; 2]) -> Self {
        let rest = 2.0 * (0.5 * rest_angle).tan();
        Self { points, rest, collapsed: rest_areas.map(|area| (COLLAPSED * 2.0 * area).powi(2)) }
    }
}

/// ½ Σᵢⱼ Qᵢⱼ (uᵢ − ūᵢ)(uⱼ − ūⱼ) over one to three hinges, u = 2 tan(θ/2).
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

    /// `None` where a triangle has collapsed.
    fn bend<const N: usize>(&self, x: &[Vec3; N]) -> Option<Bend> {
        let (mut turned, mut tangents) = ([0.0; 3], [0.0; 3]);
        for (k, hinge) in self.hinges().iter().enumerate() {
            let corners = hinge.points.map(|i| x[i]);
            let edge = corners[1] - corners[0];
            let normals = [corners[2], corners[3]].map(|tip| edge.cross(&(tip - corners[0])).norm_squared());
            if normals[0] <= hinge.collapsed[0] || normals[1] <= hinge.collapsed[1] {
                return None;
            }
            tangents[k] = (0.5 * dihedral_angle(&corners)).tan();
            turned[k] = 2.0 * tangents[k] - hinge.rest;
        }
        let moments = self.stiffness.map(|row| row[0] * turned[0] + row[1] * turned[1] + row[2] * turned[2]);
        let work: f64 = moments.iter().zip(turned).map(|(moment, turned)| moment * turned).sum();
        let slopes = tangents.map(|t| 1.0 + t * t);
        let curvatures = std::array::from_fn(|k| slopes[k] * tangents[k]);
        Some(Bend { energy: 0.5 * work, moments, slopes, curvatures })
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

/// How a patch is bent.
struct Bend {
    energy: f64,
    /// mᵢ = Σⱼ Qᵢⱼ (uⱼ − ūⱼ).
    moments: [f64; 3],
    /// u' = 1 + tan²(θ/2).
    slopes: [f64; 3],
    /// u'' = u' tan(θ/2).
    curvatures: [f64; 3],
}

/// The patches of `N` points of a [`PlateBending`](super::PlateBending).
///
/// The Hessian is Σᵢⱼ Qᵢⱼ u'ᵢ u'ⱼ ∇θᵢ⊗∇θⱼ + Σᵢ mᵢ (u''ᵢ ∇θᵢ⊗∇θᵢ + u'ᵢ ∇∇θᵢ). Q is positive semi-definite; a projection leaves out the
/// second angles' derivatives and those mᵢ u''ᵢ that are negative (Gauss and Newton's approximation, stiff enough near a
/// fold).
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
        self.0[element].bend(x).map_or(0.0, |bend| bend.energy)
    }

    fn gradient(&self, element: usize, x: &[Vec3; N]) -> [Vec3; N] {
        let patch = &self.0[element];
        let Some(Bend { moments, slopes, .. }) = patch.bend(x) else { return [Vec3::zeros(); N] };
        let gradients = patch.gradients(x);
        std::array::from_fn(|i| (0..patch.count).map(|k| gradients[k][i] * (moments[k] * slopes[k])).sum())
    }

    fn hessian(&self, element: usize, x: &[Vec3; N], projection: Projection) -> LocalHessian<N> {
        let patch = &self.0[element];
        let mut hessian = [[Mat3::zeros(); N]; N];
        let Some(Bend { moments, slopes, curvatures, .. }) = patch.bend(x) else { return hessian };
        let gradients = patch.gradients(x);
        let weight = |k: usize, l: usize| {
            let own = if k == l { projection.apply(moments[k] * curvatures[k]) } else { 0.0 };
            patch.stiffness[k][l] * slopes[k] * slopes[l] + own
        };
        // The weighted gradients first: three vectors a point.
        let pulled: [[Vec3; 3]; N] = std::array::from_fn(|j| {
            std::array::from_fn(|k| (0..patch.count).map(|l| gradients[l][j] * weight(k, l)).sum())
        });
        for i in 0..N {
            for j in 0..=i {
                for (gradient, pulled) in gradients.iter().zip(&pulled[j]).take(patch.count) {
                    hessian[i][j] += gradient[i] * pulled.transpose();
                }
            }
        }
        if projection == Projection::None {
            for (k, hinge) in patch.hinges().iter().enumerate() {
                let second = dihedral_derivatives(&hinge.points.map(|i| x[i])).hessian;
                for (a, &i) in hinge.points.iter().enumerate() {
                    for (b, &j) in hinge.points.iter().enumerate() {
                        if i >= j {
                            hessian[i][j] += second[a][b] * (moments[k] * slopes[k]);
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
