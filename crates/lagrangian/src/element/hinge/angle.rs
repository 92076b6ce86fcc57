//! The dihedral angle and its derivatives.

use mechanics_core::stencil::LocalHessian;
use mechanics_core::tensor::{Mat3, Vec3};

/// ∇θ and ∇∇θ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleDerivatives {
    /// ∂θ/∂xᵢ [1/m].
    pub gradient: [Vec3; 4],
    /// ∂²θ/∂xᵢ∂xⱼ [1/m²].
    pub hessian: LocalHessian<4>,
}

/// Normals of (x₀, x₁, x₂) and (x₁, x₀, x₃), twice the areas long \[m²\].
pub(super) fn normals(x: &[Vec3; 4]) -> [Vec3; 2] {
    let e = x[1] - x[0];
    [e.cross(&(x[2] - x[0])), (x[3] - x[0]).cross(&e)]
}

/// The angle θ ∈ (−π, π] between the triangles (x₀, x₁, x₂) and (x₁, x₀, x₃): zero when flat, positive when x₂ and x₃
/// rise to the side that the normals m₁ = e × (x₂ − x₀), m₂ = (x₃ − x₀) × e point to, e = x₁ − x₀.
///
/// - θ = atan2((m₂ × m₁)·e/|e|, m₁·m₂),
///
/// accurate for all angles (no arc cosine) and without normalising. As m₂ × m₁ is parallel to e, its product with
/// e/|e| has its length. Zero where a triangle has no area.
pub fn dihedral_angle(x: &[Vec3; 4]) -> f64 {
    let e = x[1] - x[0];
    let [m1, m2] = normals(x);
    // (m₂ × m₁)·e = (m₂ × (e × a))·e = (e (m₂·a) − a (m₂·e))·e = |e|² (m₂·a), because m₂·e = 0.
    let sine = m2.dot(&(x[2] - x[0])) * e.norm();
    let cosine = m1.dot(&m2);
    if sine == 0.0 && cosine == 0.0 { 0.0 } else { sine.atan2(cosine) }
}

/// One triangle's part: with e the edge, a the wing from x₀, m = e × a,
///
/// - g = |e| m/|m|²: moving the wing's tip by δ turns the triangle about the edge by g·δ (g is along the normal, one
///   over the height long);
/// - τ = a·e/|e|²: where the foot of the height is on the edge. The edge's ends get −(1 − τ) g and −τ g, so that
///   translations and rotations do not change θ.
struct Wing {
    g: Vec3,
    foot: f64,
    m: Vec3,
    a: Vec3,
}

impl Wing {
    fn new(e: &Vec3, a: Vec3) -> Self {
        let m = e.cross(&a);
        Self { g: m * (e.norm() / m.norm_squared()), foot: a.dot(e) / e.norm_squared(), m, a }
    }

    /// −(1 − τ) g, −τ g, g.
    fn gradient(&self) -> [Vec3; 3] {
        [self.g * (self.foot - 1.0), self.g * -self.foot, self.g]
    }

    /// The derivatives of [`gradient`](Self::gradient) by (x₀, x₁, tip). With n = m/|m|, R = (1 − 2 n⊗n)/|m|²
    /// (the derivative of m/|m|² by m), dm = e × da − a × de:
    ///
    /// - dg = (m/|m|²)(e·de)/|e| + |e| R dm,
    /// - dτ = (e·da + (a − 2τe)·de)/|e|²,
    /// - de = dx₁ − dx₀, da = d(tip) − dx₀.
    fn jacobian(&self, e: &Vec3) -> [[Mat3; 3]; 3] {
        let (length, size) = (e.norm(), self.m.norm_squared());
        let r = (Mat3::identity() - self.m * self.m.transpose() * (2.0 / size)) * (length / size);
        let g_a = r * e.cross_matrix();
        let g_e = self.m * e.transpose() * (1.0 / (size * length)) - r * self.a.cross_matrix();
        let foot_a = e / (length * length);
        let foot_e = (self.a - e * (2.0 * self.foot)) / (length * length);
        let g = [-(g_e + g_a), g_e, g_a];
        let foot = [-(foot_e + foot_a), foot_e, foot_a];
        let by = |j: usize| {
            let along = self.g * foot[j].transpose();
            [g[j] * (self.foot - 1.0) + along, g[j] * -self.foot - along, g[j]]
        };
        let columns = [by(0), by(1), by(2)];
        std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
    }
}

fn wings(x: &[Vec3; 4]) -> (Vec3, [Wing; 2]) {
    let e = x[1] - x[0];
    (e, [Wing::new(&e, x[2] - x[0]), Wing::new(&e, x[3] - x[0])])
}

/// ∂θ/∂xᵢ alone, in a third of the time; not finite where a triangle has no area.
pub fn dihedral_gradient(x: &[Vec3; 4]) -> [Vec3; 4] {
    let (_, [one, two]) = wings(x);
    // The normal of the second wing as seen from the same edge is −m₂: its part counts negatively.
    let ([a0, a1, a2], [b0, b1, b3]) = (one.gradient(), two.gradient());
    [a0 - b0, a1 - b1, a2, -b3]
}

/// The gradient and Hessian of [`dihedral_angle`] in closed form; not finite where a triangle has no area.
///
/// θ's gradient is a sum of one vector field per triangle (`Wing` in the source), so the Hessian is the sum of their
/// Jacobians; x₂ and x₃ are not coupled.
///
/// # Reference
/// For comparison: R. Tamstorf, E. Grinspun, *Discrete bending forces and their Jacobians*, Graphical Models 75 (2013).
pub fn dihedral_derivatives(x: &[Vec3; 4]) -> AngleDerivatives {
    let (e, [one, two]) = wings(x);
    let (a, b) = (one.jacobian(&e), two.jacobian(&e));
    let mut hessian = [[Mat3::zeros(); 4]; 4];
    let (first, second) = ([0, 1, 2], [0, 1, 3]);
    for i in 0..3 {
        for j in 0..3 {
            hessian[first[i]][first[j]] += a[i][j];
            hessian[second[i]][second[j]] -= b[i][j];
        }
    }
    AngleDerivatives { gradient: dihedral_gradient(x), hessian }
}
