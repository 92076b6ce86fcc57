//! The four primitives: what each one's closest points are.

use super::{Separation, SquaredDistance, add_scaled, difference, scaled};
use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{Matrix3, Vector3, cross, dot, from_entries, multiple_of_identity};

/// Two points: r = x₀ − x₁, nothing to minimise over.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointPoint;

impl SquaredDistance<2> for PointPoint {
    #[inline(always)]
    fn separation<S: Scalar>(x: &[Vector3<S>; 2]) -> Separation<S, 2> {
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        Separation {
            difference: difference(&x[0], &x[1]),
            weights: [one, -one],
            weight_gradients: [[zero; 3]; 2],
            normal_projector: multiple_of_identity(one),
        }
    }
}

/// A point x₀ and the line through x₁ and x₂.
///
/// With t = x₂ − x₁ and e = x₀ − x₁ the foot is x₁ + λt, λ = e·t/‖t‖², and r = e − λt. The only tangent of
/// r(λ) is −t, whose dual is −t/‖t‖². The weights 1, λ − 1, −λ give g₀ = 0, g₁ = −t/‖t‖², g₂ = t/‖t‖², and
/// N = I − ttᵀ/‖t‖².
#[derive(Clone, Copy, Debug, Default)]
pub struct PointLine;

impl SquaredDistance<3> for PointLine {
    #[inline(always)]
    fn separation<S: Scalar>(x: &[Vector3<S>; 3]) -> Separation<S, 3> {
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        let (t, e) = (difference(&x[2], &x[1]), difference(&x[0], &x[1]));
        let dual = scaled(&t, dot(&t, &t).recip());
        let lambda = dot(&e, &dual);
        Separation {
            difference: add_scaled(&e, -lambda, &t),
            weights: [one, lambda - one, -lambda],
            weight_gradients: [[zero; 3], dual.map(|entry| -entry), dual],
            normal_projector: from_entries(|i, j| {
                let tangential = t[i] * dual[j];
                if i == j { one - tangential } else { -tangential }
            }),
        }
    }
}

/// The two tangents of a primitive with a unique normal, as dual vectors, and the normal's part of a difference.
struct Normal<S> {
    /// p with p·u = 1, p·v = 0, and q with q·u = 0, q·v = 1, both normal to n.
    dual: [[S; 3]; 2],
    n: [S; 3],
    /// 1/‖n‖².
    inverse: S,
}

impl<S: Scalar> Normal<S> {
    /// n = u × v; p = v × n/‖n‖², q = n × u/‖n‖².
    #[inline(always)]
    fn new(u: &[S; 3], v: &[S; 3]) -> Self {
        let n = cross(u, v);
        let inverse = dot(&n, &n).recip();
        Self { dual: [scaled(&cross(v, &n), inverse), scaled(&cross(&n, u), inverse)], n, inverse }
    }

    /// n(n·e)/‖n‖².
    #[inline(always)]
    fn part_of(&self, e: &[S; 3]) -> [S; 3] {
        scaled(&self.n, dot(&self.n, e) * self.inverse)
    }

    /// nnᵀ/‖n‖².
    #[inline(always)]
    fn projector(&self) -> Matrix3<S> {
        from_entries(|i, j| self.n[i] * self.n[j] * self.inverse)
    }
}

/// A point x₀ and the plane through x₁, x₂, x₃.
///
/// With u = x₂ − x₁, v = x₃ − x₁, n = u × v and e = x₀ − x₁ the foot has the barycentric coordinates λ = p·e (of x₂) and
/// μ = q·e (of x₃), where p = v × n/‖n‖² and q = n × u/‖n‖² are dual to u and v. The difference is
/// r = n(n·e′)/‖n‖² with e′ = e − λu − μv: equal to n(n·e)/‖n‖², but e′ is short, so an error in the direction of n (a
/// sliver) hardly counts. N = nnᵀ/‖n‖². The tangents of r are −u and −v, whose duals are −p and −q; with the weights
/// 1, λ + μ − 1, −λ, −μ: g₀ = 0, g₁ = −p − q, g₂ = p, g₃ = q.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointPlane;

impl SquaredDistance<4> for PointPlane {
    #[inline(always)]
    fn separation<S: Scalar>(x: &[Vector3<S>; 4]) -> Separation<S, 4> {
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        let (u, v, e) = (difference(&x[2], &x[1]), difference(&x[3], &x[1]), difference(&x[0], &x[1]));
        let normal = Normal::new(&u, &v);
        let [p, q] = normal.dual;
        let (lambda, mu) = (dot(&p, &e), dot(&q, &e));
        let short = add_scaled(&add_scaled(&e, -lambda, &u), -mu, &v);
        let minus = S::constant(-1.0);
        Separation {
            difference: normal.part_of(&short),
            weights: [one, lambda + mu - one, -lambda, -mu],
            weight_gradients: [[zero; 3], scaled(&add_scaled(&p, one, &q), minus), p, q],
            normal_projector: normal.projector(),
        }
    }
}

/// The lines through x₀, x₁ and through x₂, x₃.
///
/// With u = x₁ − x₀, v = x₃ − x₂, n = u × v and e = x₀ − x₂, the closest points are x₀ + αu and x₂ + βv. Taking the
/// products of e + αu − βv = r with the dual vectors p and q (p·u = q·v = 1, p·v = q·u = 0, both normal to n) gives
/// α = −p·e and β = q·e. As for a plane, r = n(n·e′)/‖n‖² with the short e′ = e + αu − βv, and N = nnᵀ/‖n‖². The tangents of
/// r are u and −v, whose duals are p and −q; with the weights 1 − α, α, β − 1, −β: g₀ = −p, g₁ = p, g₂ = −q, g₃ = q.
#[derive(Clone, Copy, Debug, Default)]
pub struct LineLine;

impl SquaredDistance<4> for LineLine {
    #[inline(always)]
    fn separation<S: Scalar>(x: &[Vector3<S>; 4]) -> Separation<S, 4> {
        let one = S::constant(1.0);
        let (u, v, e) = (difference(&x[1], &x[0]), difference(&x[3], &x[2]), difference(&x[0], &x[2]));
        let normal = Normal::new(&u, &v);
        let [p, q] = normal.dual;
        let (alpha, beta) = (-dot(&p, &e), dot(&q, &e));
        let short = add_scaled(&add_scaled(&e, alpha, &u), -beta, &v);
        let minus = S::constant(-1.0);
        Separation {
            difference: normal.part_of(&short),
            weights: [one - alpha, alpha, beta - one, -beta],
            weight_gradients: [scaled(&p, minus), p, scaled(&q, minus), q],
            normal_projector: normal.projector(),
        }
    }
}
