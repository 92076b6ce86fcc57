//! A point and a half-space.

use super::PairLaw;
use crate::barrier::Barrier;
use mechanics_core::potential::Demand;
use mechanics_core::projection::Projection;
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::Vec3;

/// Points above half-spaces {x : n·x ≤ o} with unit normals n: the gap is g = n·x − o, s = g².
///
/// The distance has a sign here, so a point at or below the surface has the energy +∞, however deep. ∇E = 2 B′ g n and
/// ∇²E = α nnᵀ, whose one eigenvalue is projected; there is nothing that Gauss–Newton leaves out.
#[derive(Clone, Copy, Debug)]
pub struct HalfSpacePairs<'a, B: ?Sized> {
    /// Barrier and stiffness.
    pub law: PairLaw<'a, B>,
    /// One weight for each pair.
    pub weights: &'a [f64],
    /// Unit normal n and offset o \[m\] of the half-space of each pair.
    pub planes: &'a [(Vec3, f64)],
}

impl<B: ?Sized> HalfSpacePairs<'_, B> {
    /// n, the gap, and its square: zero where the gap is not positive.
    fn gap(&self, pair: usize, x: &Vec3) -> (Vec3, f64, f64) {
        let (normal, offset) = self.planes[pair];
        let gap = normal.dot(x) - offset;
        // NaN stays NaN.
        let squared = if gap <= 0.0 { 0.0 } else { gap * gap };
        (normal, gap, squared)
    }
}

impl<B: Barrier + ?Sized> Stencil<1> for HalfSpacePairs<'_, B> {
    fn value(&self, pair: usize, [x]: &[Vec3; 1]) -> f64 {
        let (_, _, squared) = self.gap(pair, x);
        self.law.energy(self.weights[pair], squared)
    }

    fn gradient(&self, pair: usize, [x]: &[Vec3; 1]) -> [Vec3; 1] {
        let (normal, gap, squared) = self.gap(pair, x);
        [normal * (2.0 * gap * self.law.first(self.weights[pair], squared))]
    }

    fn hessian(&self, pair: usize, [x]: &[Vec3; 1], projection: Projection) -> LocalHessian<1> {
        let (normal, _, squared) = self.gap(pair, x);
        let [_, along] = self.law.across_and_along(self.weights[pair], squared);
        [[normal * normal.transpose() * projection.apply(along)]]
    }

    fn demand(&self) -> Demand {
        Demand::EndPositions
    }
}
