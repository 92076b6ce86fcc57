//! The factor that makes the energy of two edges smooth where they become parallel.

use super::{difference, scaled};
use mechanics_core::scalar::Scalar;
use mechanics_core::stencil::LocalHessian;
use mechanics_core::tensor::{Matrix3, Vec3, Vector3, cross, dot, from_entries, vector};

/// m(x) = 1 − (1 − c/ε)² for c < ε and 1 beyond, with c(x) = ‖u × v‖², u = x₁ − x₀, v = x₃ − x₂.
///
/// The squared distance of two segments is not differentiable where they are parallel, because the closest points
/// jump from end to end. Multiplied by m, which vanishes there with its gradient, the energy is once
/// continuously differentiable. ε = 10⁻³ ‖u‖²‖v‖² of the rest lengths: the factor counts below a sine of 0.03.
///
/// # Reference
/// Li et al. 2020, equation 24: e_k(x) = −c²/ε² + 2c/ε, which is the form above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeEdgeMollifier {
    /// ε \[m⁴\].
    pub threshold: f64,
}

/// ε over ‖u‖²‖v‖².
const RELATIVE_THRESHOLD: f64 = 1e-3;

impl EdgeEdgeMollifier {
    /// The mollifier of two edges with these squared rest lengths \[m²\].
    #[inline]
    pub fn from_rest_lengths_squared(first: f64, second: f64) -> Self {
        Self { threshold: RELATIVE_THRESHOLD * first * second }
    }

    /// The mollifier of the edges `rest[0..2]` and `rest[2..4]`.
    pub fn from_rest(rest: &[Vec3; 4]) -> Self {
        Self::from_rest_lengths_squared(
            (rest[1] - rest[0]).norm_squared(),
            (rest[3] - rest[2]).norm_squared(),
        )
    }

    /// c(x) = ‖u × v‖² \[m⁴\].
    #[inline(always)]
    pub fn squared_area<S: Scalar>(x: &[Vector3<S>; 4]) -> S {
        let n = cross(&difference(&x[1], &x[0]), &difference(&x[3], &x[2]));
        dot(&n, &n)
    }

    /// Whether m(x) < 1, that is c < ε. Never where ε is zero (an edge without rest length).
    #[inline]
    pub fn is_active(&self, x: &[Vec3; 4]) -> bool {
        Self::squared_area(x) < self.threshold
    }

    /// m(x), in [0, 1].
    #[inline(always)]
    pub fn value<S: Scalar>(&self, x: &[Vector3<S>; 4]) -> S {
        let c = Self::squared_area(x);
        let one = S::constant(1.0);
        let part = c / S::constant(self.threshold);
        S::select(c.less(S::constant(self.threshold)), part * (S::constant(2.0) - part), one)
    }

    /// ∇m = m′(c) ∇c with m′ = 2(1 − c/ε)/ε; ∂c/∂u = 2 v × n, ∂c/∂v = 2 n × u for n = u × v.
    #[inline(always)]
    pub fn gradient<S: Scalar>(&self, x: &[Vector3<S>; 4]) -> [Vector3<S>; 4] {
        let (first, _) = self.slopes(Self::squared_area(x));
        area_gradient(x).map(|part| vector(scaled(&part, first)))
    }

    /// ∇∇m = m′ ∇∇c + m″ ∇c ∇cᵀ with m″ = −2/ε². From c = ‖u‖²‖v‖² − (u·v)²:
    /// c_uu = 2(‖v‖² I − v vᵀ), c_vv = 2(‖u‖² I − u uᵀ), c_uv = 2(2 u vᵀ − v uᵀ − (u·v) I).
    pub fn hessian(&self, x: &[Vec3; 4]) -> LocalHessian<4> {
        let (first, second) = self.slopes(Self::squared_area(x));
        let slope = area_gradient(x);
        let (u, v) = (difference(&x[1], &x[0]), difference(&x[3], &x[2]));
        let curved = area_hessian(&u, &v);
        let sign = [-1.0, 1.0, -1.0, 1.0];
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let block = &curved[i / 2][j / 2];
                from_entries(|a, b| {
                    first * sign[i] * sign[j] * block[(a, b)] + second * slope[i][a] * slope[j][b]
                })
            })
        })
    }

    /// m′(c) and m″(c).
    #[inline(always)]
    fn slopes<S: Scalar>(&self, c: S) -> (S, S) {
        let (zero, inverse) = (S::constant(0.0), S::constant(1.0 / self.threshold));
        let active = c.less(S::constant(self.threshold));
        let twice = inverse.scale(2.0);
        let first = twice * (S::constant(1.0) - c * inverse);
        (S::select(active, first, zero), S::select(active, -twice * inverse, zero))
    }
}

/// ∇c, one vector per point.
#[inline(always)]
fn area_gradient<S: Scalar>(x: &[Vector3<S>; 4]) -> [[S; 3]; 4] {
    let (u, v) = (difference(&x[1], &x[0]), difference(&x[3], &x[2]));
    let n = cross(&u, &v);
    let (two, minus_two) = (S::constant(2.0), S::constant(-2.0));
    let (by_u, by_v) = (cross(&v, &n), cross(&n, &u));
    [scaled(&by_u, minus_two), scaled(&by_u, two), scaled(&by_v, minus_two), scaled(&by_v, two)]
}

/// c_uu, c_uv; c_vu, c_vv.
fn area_hessian(u: &[f64; 3], v: &[f64; 3]) -> [[Matrix3<f64>; 2]; 2] {
    let (uu, uv, vv) = (dot(u, u), dot(u, v), dot(v, v));
    let identity = |a: usize, b: usize| f64::from(u8::from(a == b));
    let by_uv = from_entries(|a, b| 2.0 * (2.0 * u[a] * v[b] - v[a] * u[b] - uv * identity(a, b)));
    [
        [from_entries(|a, b| 2.0 * (vv * identity(a, b) - v[a] * v[b])), by_uv],
        [by_uv.transpose(), from_entries(|a, b| 2.0 * (uu * identity(a, b) - u[a] * u[b]))],
    ]
}
