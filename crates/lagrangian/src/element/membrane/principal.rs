//! Principal stretches of a 3×2 matrix and the eigen-system of isotropic stiffness in them.

use super::{Mat3x2, SheetStiffness};
use mechanics_core::projection::Projection;
use mechanics_core::tensor::Vec3;

/// F = Σᵢ σᵢ uᵢ ⊗ vᵢ with σ₁ ≥ σ₂ ≥ 0, u₁, u₂, n orthonormal in space and v₁, v₂ in the rest plane.
///
/// v₁ is the direction at the angle ½ atan2(2 C₁₂, C₁₁ − C₂₂) with C = FᵀF; the image F v₁ gives σ₁ u₁, and what F v₂ has
/// perpendicular to it gives σ₂ u₂. Where a stretch vanishes its direction is any that completes the frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Principal {
    pub(crate) stretches: [f64; 2],
    pub(crate) left: [Vec3; 2],
    pub(crate) normal: Vec3,
    pub(crate) right: [[f64; 2]; 2],
}

impl Principal {
    pub(crate) fn of(f: &Mat3x2) -> Self {
        let [first, second]: [Vec3; 2] = [f.column(0).into(), f.column(1).into()];
        let half_gap = 0.5 * (first - second).dot(&(first + second));
        let [c, s] = half_angle(half_gap, first.dot(&second));
        let images = [first * c + second * s, second * c - first * s];
        let one = images[0].norm();
        let left = if one > 0.0 { images[0] / one } else { Vec3::x() };
        let rest = images[1] - left * left.dot(&images[1]);
        let two = rest.norm();
        let next = if two > f64::EPSILON * one { rest / two } else { perpendicular(&left) };
        // Made perpendicular once more: for a small σ₂ rounding has tilted it.
        let next = (next - left * left.dot(&next)).normalize();
        Self {
            stretches: [one, two],
            left: [left, next],
            normal: left.cross(&next),
            right: [[c, s], [-s, c]],
        }
    }
}

/// Cosine and sine of half the angle of (x, y); (1, 0) at the origin.
fn half_angle(x: f64, y: f64) -> [f64; 2] {
    let r = x.hypot(y);
    if r == 0.0 {
        return [1.0, 0.0];
    }
    let larger = (0.5 * (1.0 + x.abs() / r)).sqrt();
    let smaller = 0.5 * y.abs() / (r * larger);
    let [c, s] = if x >= 0.0 { [larger, smaller] } else { [smaller, larger] };
    [c, s.copysign(y)]
}

fn perpendicular(v: &Vec3) -> Vec3 {
    v.cross(&Vec3::ith(v.iamin(), 1.0)).normalize()
}

/// The eigenvalues of ∂²W/∂F² for an isotropic W(σ₁, σ₂), W,ᵢ its derivatives.
///
/// The 6×6 matrix splits, in the orthonormal basis of rank-one matrices of the [`Principal`] frame, into
///
/// - a 2×2 block of W,ᵢⱼ on u₁⊗v₁ and u₂⊗v₂,
/// - (W,₁ − W,₂)/(σ₁ − σ₂) on (u₁⊗v₂ + u₂⊗v₁)/√2 (shear),
/// - (W,₁ + W,₂)/(σ₁ + σ₂) on (u₁⊗v₂ − u₂⊗v₁)/√2 (rotation within the sheet),
/// - W,₁/σ₁ on n⊗v₁ and W,₂/σ₂ on n⊗v₂ (tilting out of the plane: the tension in each direction).
///
/// # Reference
/// B. Smith, F. de Goes, T. Kim, *Analytic eigensystems for isotropic distortion energies*, ACM Trans. Graph. 38(1),
/// 2019, section 4; the out-of-plane pair is the rank-one case σ₃ = 0 of theirs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PrincipalStiffness {
    /// W,₁₁, W,₁₂, W,₂₂.
    pub(crate) scaling: [f64; 3],
    pub(crate) shear: f64,
    pub(crate) rotation: f64,
    pub(crate) tilting: [f64; 2],
}

impl PrincipalStiffness {
    /// The 6×6 matrix with its eigenvalues replaced as `projection` says.
    pub(crate) fn assembled(&self, frame: &Principal, projection: Projection) -> SheetStiffness {
        let Principal { left: [u1, u2], normal, right: [v1, v2], .. } = frame;
        let dyad = |u: &Vec3, v: &[f64; 2]| Dyad([u * v[0], u * v[1]]);
        let (q11, q22, q12, q21) = (dyad(u1, v1), dyad(u2, v2), dyad(u1, v2), dyad(u2, v1));
        let [a, b, d] = projected_pair(self.scaling, projection);
        let (shear, rotation) = (projection.apply(self.shear), projection.apply(self.rotation));
        let (even, odd) = (0.5 * (shear + rotation), 0.5 * (shear - rotation));
        let tilting = self.tilting.map(|value| projection.apply(value));
        let (t1, t2) = (dyad(normal, v1), dyad(normal, v2));
        // K = Σ over pairs of dyads; each row is a dyad times a vector, so that K = Σ q ⊗ (row of q).
        let terms = [
            (q11, q11 * a + q22 * b),
            (q22, q11 * b + q22 * d),
            (q12, q12 * even + q21 * odd),
            (q21, q12 * odd + q21 * even),
            (t1, t1 * tilting[0]),
            (t2, t2 * tilting[1]),
        ];
        let mut k = SheetStiffness::zeros();
        for (Dyad(q), Dyad(r)) in terms {
            for j in 0..2 {
                for l in 0..2 {
                    for i in 0..3 {
                        for m in 0..3 {
                            k[(3 * j + i, 3 * l + m)] += q[j][i] * r[l][m];
                        }
                    }
                }
            }
        }
        k
    }
}

/// The columns of a 3×2 matrix.
#[derive(Clone, Copy)]
struct Dyad([Vec3; 2]);

impl std::ops::Mul<f64> for Dyad {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|c| c * factor))
    }
}

impl std::ops::Add for Dyad {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

/// f(A) for A = [[a, b], [b, d]] and f the projection of eigenvalues m ± r:
/// f(A) = ½ (f₊ + f₋) I + ½ (f₊ − f₋)/r (A − m I).
fn projected_pair([a, b, d]: [f64; 3], projection: Projection) -> [f64; 3] {
    let (mean, half) = (0.5 * (a + d), 0.5 * (a - d));
    let r = half.hypot(b);
    if projection == Projection::None || mean - r >= 0.0 {
        return [a, b, d];
    }
    let (high, low) = (projection.apply(mean + r), projection.apply(mean - r));
    let (middle, slope) = (0.5 * (high + low), if r > 0.0 { 0.5 * (high - low) / r } else { 0.0 });
    [middle + slope * half, slope * b, middle - slope * half]
}
