//! Two points.

use super::run::{Primitive, Rule, Run, stencil};
use super::{PairLaw, minus};
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Matrix3};

/// Pairs of two points: s = |x₀ − x₁|².
///
/// With n along the gap, ∇²E = α nnᵀ + 2B′ (I − nnᵀ) on the diagonal and its negative beside it: its eigenvalues are
/// 2α and twice 4B′, see the [module](super) page. Domain: s > 0.
#[derive(Clone, Copy, Debug)]
pub struct PointPointPairs<'a, B: ?Sized> {
    /// Barrier and stiffness.
    pub law: PairLaw<'a, B>,
    /// One weight for each pair.
    pub weights: &'a [f64],
}

stencil!(PointPointPairs, PointPoint, 2);

/// Geometry of two points.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointPoint;

impl Primitive<2> for PointPoint {
    #[inline(always)]
    fn squared_distance<S: Scalar>(x: &[[S; 3]; 2]) -> S {
        let y = minus(&x[0], &x[1]);
        tensor::dot(&y, &y)
    }

    #[inline(always)]
    fn closest<S: Scalar>(x: &[[S; 3]; 2]) -> ([S; 2], [S; 3]) {
        ([S::constant(1.0), S::constant(-1.0)], minus(&x[0], &x[1]))
    }

    #[inline(always)]
    fn hessian<S: Scalar>(
        x: &[[S; 3]; 2],
        coefficients: impl FnOnce(S) -> [S; 2],
        rule: Rule,
    ) -> [[Matrix3<S>; 2]; 2] {
        let y = minus(&x[0], &x[1]);
        let s = tensor::dot(&y, &y);
        let [across, along] = coefficients(s);
        let along = rule.projection.apply(along);
        let across = if rule.is_gauss_newton() { S::constant(0.0) } else { rule.projection.apply(across) };
        let difference = (along - across) / s;
        let block = tensor::from_entries(|i, j| {
            let radial = difference * y[i] * y[j];
            if i == j { radial + across } else { radial }
        });
        let opposite = tensor::scaled(&block, S::constant(-1.0));
        [[block, opposite], [opposite, block]]
    }
}
