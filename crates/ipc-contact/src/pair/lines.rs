//! A point and a line.

use super::run::{Primitive, Rule, Run, stencil};
use super::{PairLaw, eigen, minus, times};
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{self, Matrix3};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// Pairs of a point x₀ and the line through x₁ and x₂, closest between them: s = |y|², y = r − λ e with r = x₀ − x₁,
/// e = x₂ − x₁, λ = r·e/|e|².
///
/// The weights are ω = (1, λ − 1, −λ), the tilt τ = (0, −1, 1)/|e|. In the orthonormal basis z₀ = (2, −1, −1)/√6,
/// z₁ = (0, 1, −1)/√2 of the weights that sum to zero, ω = (√(3/2), (2λ − 1)/√2) and τ = (0, −√2/|e|). See the
/// [module](super) page for the rest. Domain: s > 0, |e| > 0.
#[derive(Clone, Copy, Debug)]
pub struct PointEdgePairs<'a, B: ?Sized> {
    /// Barrier and stiffness.
    pub law: PairLaw<'a, B>,
    /// One weight for each pair.
    pub weights: &'a [f64],
}

stencil!(PointEdgePairs, PointLine, 3);

/// Geometry of a point and a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointLine;

/// Point i of z₀ and z₁.
const BASIS: [[f64; 2]; 3] = [[2.0 * SIXTH, 0.0], [-SIXTH, FRAC_1_SQRT_2], [-SIXTH, -FRAC_1_SQRT_2]];
/// 1/√6.
const SIXTH: f64 = 0.408_248_290_463_863_02;

/// √(3/2), the component of every ω along z₀.
const MEAN: f64 = 1.224_744_871_391_589;

impl PointLine {
    /// λ and y.
    #[inline(always)]
    fn foot<S: Scalar>(x: &[[S; 3]; 3]) -> (S, [S; 3]) {
        let (r, e) = (minus(&x[0], &x[1]), minus(&x[2], &x[1]));
        let reciprocal = tensor::dot(&e, &e).recip();
        let lambda = tensor::dot(&r, &e) * reciprocal;
        let y = minus(&r, &times(&e, lambda));
        // Once more, so that y is orthogonal to e to within the rounding of y, not of r.
        (lambda, minus(&y, &times(&e, tensor::dot(&y, &e) * reciprocal)))
    }
}

impl Primitive<3> for PointLine {
    #[inline(always)]
    fn squared_distance<S: Scalar>(x: &[[S; 3]; 3]) -> S {
        let (_, y) = Self::foot(x);
        tensor::dot(&y, &y)
    }

    #[inline(always)]
    fn closest<S: Scalar>(x: &[[S; 3]; 3]) -> ([S; 3], [S; 3]) {
        let (lambda, y) = Self::foot(x);
        ([S::constant(1.0), lambda.offset(-1.0), -lambda], y)
    }

    #[inline(always)]
    fn hessian<S: Scalar>(
        x: &[[S; 3]; 3],
        coefficients: impl FnOnce(S) -> [S; 2],
        rule: Rule,
    ) -> [[Matrix3<S>; 3]; 3] {
        let (lambda, y) = Self::foot(x);
        let s = tensor::dot(&y, &y);
        let d = s.sqrt();
        let n = times(&y, d.recip());
        let e = minus(&x[2], &x[1]);
        let length = tensor::dot(&e, &e).sqrt();
        let t = times(&e, length.recip());
        let [across, along] = coefficients(s);
        let omega = [S::constant(1.0), lambda.offset(-1.0), -lambda];
        // ω̂ = (cos, sin) and v = (−sin, cos) in the basis z₀, z₁.
        let slope = (lambda + lambda).offset(-1.0).scale(FRAC_1_SQRT_2);
        let size_squared = slope.mul_add(slope, S::constant(1.5));
        let size = size_squared.sqrt();
        let (cos, sin) = (S::constant(MEAN) / size, slope / size);
        let hat = times(&omega, size.recip());
        let zero = S::constant(0.0);
        let mut small = [[zero; 3]; 3];
        small[0][0] = along * size_squared;
        let mut last = zero;
        if rule.is_gauss_newton() {
            small[0][0] = rule.projection.apply(small[0][0]);
        } else {
            let tilt = -length.recip().scale(SQRT_2) * d;
            let (a, c) = (tilt * sin, tilt * cos);
            small[0] = [small[0][0] - across * a * a, -across * a * c, -across * a * size];
            small[1] = [small[0][1], -across * c * c, -across * c * size];
            small[2] = [small[0][2], small[1][2], zero];
            if rule.projection != mechanics_core::projection::Projection::None {
                small = eigen::project(&small, rule.projection);
            }
            last = rule.projection.apply(across);
        }
        let mut v = [zero; 3];
        for i in 0..3 {
            v[i] = cos.scale(BASIS[i][1]) - sin.scale(BASIS[i][0]);
        }
        let frame = tensor::from_columns([n, t, tensor::cross(&n, &t)]);
        let mut blocks = [[tensor::zero(); 3]; 3];
        for i in 0..3 {
            for j in 0..=i {
                let near = |a: usize, k: usize| small[0][a].mul_add(hat[k], small[1][a] * v[k]);
                let k = [
                    [hat[i] * near(0, j) + v[i] * near(1, j), hat[i] * near(2, j), zero],
                    [near(2, i) * hat[j], small[2][2] * hat[i] * hat[j], zero],
                    [zero, zero, last * omega[i] * omega[j]],
                ];
                let k = tensor::from_columns(k);
                blocks[i][j] = tensor::product(&frame, &tensor::product_transpose(&k, &frame));
            }
        }
        blocks
    }
}
