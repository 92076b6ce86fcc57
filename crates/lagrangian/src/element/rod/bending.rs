//! The energy of a rod's joints.

use super::joints::joints_of;
use super::rest_lengths;
use crate::element::thin_error::{ThinError, positive};
use mechanics_core::mesh::TriMesh;
use mechanics_core::projection::{Projection, project_symmetric};
use mechanics_core::stencil::{LocalHessian, Stencil, StencilTerm};
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::SMatrix;

/// E = ½ (EI/ℓ̄ᵢ) |κb|² at each joint between two edges e₀ = x₁ − x₀, e₁ = x₂ − x₁, with the length ℓ̄ᵢ = ½(|ē₀| + |ē₁|) of rod
/// that the joint stands for and the curvature binormal
///
/// - κb = 2 e₀ × e₁/(|e₀||e₁| + e₀·e₁),  |κb| = 2 tan(φ/2),
///
/// φ the turning angle: the integral of the curvature over the joint's length, of an arc inscribed to the polyline
/// (Bergou et al. 2008, equation (1), with the present lengths, so that |κb| is a function of the angle alone when the rod
/// stretches). It grows without bound as φ → π: a joint never folds through itself.
///
/// With unit tangents t₀, t₁ and c = t₀·t₁ it is |κb|² = K(c) = 4(1 − c)/(1 + c), so
///
/// - K' = −8/(1 + c)²,  K'' = 16/(1 + c)³,
/// - ∂c/∂e₀ = p/|e₀|, p = t₁ − c t₀,  ∂c/∂e₁ = q/|e₁|, q = t₀ − c t₁,
/// - ∂²c/∂e₀² = −(p⊗t₀ + t₀⊗p + c (1 − t₀⊗t₀))/|e₀|²,  likewise e₁ with q,
/// - ∂²c/∂e₀∂e₁ = (1 − t₀⊗t₀)(1 − t₁⊗t₁)/(|e₀||e₁|).
///
/// The value is taken as 4|t₀ × t₁|²/(1 + c)², which small angles do not spoil. The Hessian is projected as the 6×6
/// matrix by the two edges. A joint with an edge shorter than 10⁻⁸ of its rest length has no angle: no energy, no force.
#[derive(Clone, Debug)]
pub struct RodBending {
    points: Vec<[u32; 3]>,
    joints: Vec<Joint>,
}

#[derive(Clone, Copy, Debug)]
struct Joint {
    /// EI/ℓ̄ᵢ \[J\].
    stiffness: f64,
    /// Lengths below which an edge counts as collapsed \[m\].
    collapsed: [f64; 2],
}

const COLLAPSED: f64 = 1e-8;

/// What the derivatives are made of.
struct Turn {
    lengths: [f64; 2],
    tangents: [Vec3; 2],
    cosine: f64,
}

impl RodBending {
    /// A joint at every point of `mesh` in which two free edges meet, for the flexural rigidity EI [N m²].
    ///
    /// # Errors
    /// A rigidity that is not positive; an edge without length; a point in which more than two edges meet.
    pub fn new(mesh: &TriMesh, flexural: f64) -> Result<Self, ThinError> {
        let flexural = positive("the flexural rigidity", flexural)?;
        let rest = rest_lengths(mesh)?;
        let of = |joint: &super::joints::Joint| {
            let lengths = joint.edges.map(|edge| rest[edge]);
            let stiffness = flexural / (0.5 * (lengths[0] + lengths[1]));
            Joint { stiffness, collapsed: lengths.map(|length| COLLAPSED * length) }
        };
        let found = joints_of(mesh)?;
        let (points, joints) =
            (found.iter().map(|joint| joint.points).collect(), found.iter().map(of).collect());
        Ok(Self { points, joints })
    }

    /// The sum over all joints, as a term of the incremental potential.
    ///
    /// # Errors
    /// If an edge is listed twice, so that a joint leads back to its start.
    pub fn term(self, name: impl Into<String>) -> Result<StencilTerm<Self, 3>, ThinError> {
        let points = self.points.clone();
        Ok(StencilTerm::new(name, self, points)?)
    }

    /// The points of every joint.
    pub fn points(&self) -> &[[u32; 3]] {
        &self.points
    }

    /// `None` where an edge has collapsed.
    fn turn(&self, element: usize, x: &[Vec3; 3]) -> Option<Turn> {
        let edges = [x[1] - x[0], x[2] - x[1]];
        let lengths = edges.map(|edge| edge.norm());
        let collapsed = self.joints[element].collapsed;
        if lengths[0] <= collapsed[0] || lengths[1] <= collapsed[1] {
            return None;
        }
        let tangents = [edges[0] / lengths[0], edges[1] / lengths[1]];
        Some(Turn { lengths, tangents, cosine: tangents[0].dot(&tangents[1]) })
    }
}

impl Turn {
    /// ∂c/∂e₀, ∂c/∂e₁.
    fn cosine_gradient(&self) -> [Vec3; 2] {
        let [t0, t1] = self.tangents;
        [(t1 - t0 * self.cosine) / self.lengths[0], (t0 - t1 * self.cosine) / self.lengths[1]]
    }

    /// The blocks (0, 0), (1, 0), (1, 1) of ∂²K/∂e².
    fn curvature_hessian(&self) -> [Mat3; 3] {
        let Self { lengths, tangents: [t0, t1], cosine: c } = *self;
        let [g0, g1] = self.cosine_gradient();
        let across = |t: Vec3| Mat3::identity() - t * t.transpose();
        let own = |g: Vec3, t: Vec3, length: f64| {
            let mixed = g * t.transpose();
            -(mixed + mixed.transpose()) / length - across(t) * (c / (length * length))
        };
        let coupling = across(t1) * across(t0) / (lengths[0] * lengths[1]);
        let first = -8.0 / (1.0 + c).powi(2);
        let second = 16.0 / (1.0 + c).powi(3);
        [
            g0 * g0.transpose() * second + own(g0, t0, lengths[0]) * first,
            g1 * g0.transpose() * second + coupling * first,
            g1 * g1.transpose() * second + own(g1, t1, lengths[1]) * first,
        ]
    }
}

impl Stencil<3> for RodBending {
    fn value(&self, element: usize, x: &[Vec3; 3]) -> f64 {
        let Some(turn) = self.turn(element, x) else { return 0.0 };
        let [t0, t1] = turn.tangents;
        let square = t0.cross(&t1).norm_squared() / (1.0 + turn.cosine).powi(2);
        let folded = turn.cosine <= -1.0 || square.is_nan();
        if folded { f64::INFINITY } else { 2.0 * self.joints[element].stiffness * square }
    }

    fn gradient(&self, element: usize, x: &[Vec3; 3]) -> [Vec3; 3] {
        let Some(turn) = self.turn(element, x) else { return [Vec3::zeros(); 3] };
        let factor = -4.0 * self.joints[element].stiffness / (1.0 + turn.cosine).powi(2);
        let [g0, g1] = turn.cosine_gradient().map(|g| g * factor);
        [-g0, g0 - g1, g1]
    }

    fn hessian(&self, element: usize, x: &[Vec3; 3], projection: Projection) -> LocalHessian<3> {
        let Some(turn) = self.turn(element, x) else { return [[Mat3::zeros(); 3]; 3] };
        let [a, b, d] = turn.curvature_hessian().map(|block| block * (0.5 * self.joints[element].stiffness));
        let mut by_edges = SMatrix::<f64, 6, 6>::zeros();
        by_edges.fixed_view_mut::<3, 3>(0, 0).copy_from(&a);
        by_edges.fixed_view_mut::<3, 3>(3, 0).copy_from(&b);
        by_edges.fixed_view_mut::<3, 3>(3, 3).copy_from(&d);
        let h = project_symmetric(&by_edges, projection);
        let block = |i: usize, j: usize| h.fixed_view::<3, 3>(3 * i, 3 * j).into_owned();
        let (a, b, d) = (block(0, 0), block(1, 0), block(1, 1));
        // Edge e₀ is −1 at x₀ and +1 at x₁; e₁ is −1 at x₁ and +1 at x₂.
        let middle = a - b - b.transpose() + d;
        let (h10, h20, h21) = (b - a, -b, b - d);
        [[a, h10.transpose(), h20.transpose()], [h10, middle, h21.transpose()], [h20, h21, d]]
    }
}
