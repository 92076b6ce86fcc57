//! Squared distances between points, edges and triangles: which features are closest, how far apart they are, and the
//! derivatives of that.
//!
//! A pair of triangles meets in one of four *primitives*: point–point, point–line, point–plane, line–line.
//! [`PointPoint`], [`PointLine`], [`PointPlane`] and [`LineLine`] give the squared distance of a primitive, whose lines
//! and planes are infinite, with gradient and Hessian ([`SquaredDistance`]). [`point_edge_region`],
//! [`point_triangle_region`] and [`edge_edge_region`] say which primitive realises the distance of two *bounded*
//! features, and [`point_edge`], [`point_triangle`], [`edge_edge`] are those distances. [`EdgeEdgeMollifier`] makes
//! the barrier of an edge–edge pair smooth where the edges become parallel.
//!
//! # One formula for all derivatives
//!
//! Every primitive is a minimum over points of two flat sets: s(x) = min over u of ‖r(x, u)‖² with the difference
//! r = Σᵢ wᵢ(u) xᵢ, whose weights wᵢ are affine in the parameters u: none for two points, one for a point and a line,
//! two for a point and a plane or for two lines. With tangents t_a = ∂r/∂u_a and their Gram matrix G_ab = t_a·t_b,
//! the minimum is where r is normal to every t_a, and (as for every minimum)
//!
//! - ∇ᵢs = 2 wᵢ r, because the change of u does not count at first order;
//! - ∇ᵢ∇ⱼs = f_ij − f_iu f_uu⁻¹ f_uj for f = ‖r(x, u)‖², a Schur complement. With f_ij = 2wᵢwⱼ I,
//!   f_ia = 2(wᵢ,a r + wᵢ t_a) and f_ab = 2G_ab.
//!
//! Writing gᵢ = Σ_ab t_a G⁻¹_ab wᵢ,b, a tangent vector per point that says how its weight varies along the flat set, and
//! N = I − Σ_ab t_a G⁻¹_ab t_bᵀ, the projector onto the normal space in which r lies,
//!
//! ½ ∇ᵢ∇ⱼs = wᵢwⱼ N − wᵢ gⱼ rᵀ − wⱼ r gᵢᵀ − (gᵢ·gⱼ) r rᵀ.
//!
//! Nothing in it cancels: it is accurate for d → 0, where only the first term is left. Both sums Σwᵢ and Σgᵢ are zero
//! (translations do not change a distance). [`Separation`] holds r, w, g and N.
//!
//! # Accuracy and domain
//!
//! Rounding of the difference r is of the order of ε times the lengths of the features (and ε/sin θ relative to itself
//! for features at an angle θ), so a distance d between features of length L has a relative error of about ε(L/d +
//! 1/sin θ), which is what rounding of the positions themselves does to it. Lengths may be from 1e-70 to 1e70 m: fourth
//! powers must neither vanish nor overflow.
//!
//! # Degenerate features
//!
//! A primitive with a line of no length or a plane of no area has no value (NaN). The bounded distances are always
//! defined: an edge of zero length is its first point; a triangle whose height is below [`FLATNESS`] of its longest
//! edge is its three edges; two edges at an angle whose sine is below [`FLATNESS`] are closest at an end of one of
//! them, which for parallel edges is true. A NaN among the positions gives a NaN distance; nothing panics.
//!
//! # Reference
//! M. Li et al., *Incremental Potential Contact*, ACM Trans. Graph. 39(4), 2020, section 3 and supplement. The closest-point regions are
//! those of C. Ericson, *Real-Time Collision Detection*, 2005, chapter 5.

mod mollifier;
mod primitive;
mod region;

pub use mollifier::EdgeEdgeMollifier;
pub use primitive::{LineLine, PointLine, PointPlane, PointPoint};
pub use region::{
    FLATNESS, Region, edge_edge, edge_edge_closest, edge_edge_region, point_edge, point_edge_closest,
    point_edge_region, point_point, point_triangle, point_triangle_closest, point_triangle_region,
};

use mechanics_core::scalar::Scalar;
use mechanics_core::tensor::{
    Matrix3, Vector3, columns, components, dot, from_entries, transpose, vector, zero,
};

/// The difference between the closest points of a primitive, and how it depends on the positions. The
/// [module](self) page derives the meaning of each part.
#[derive(Clone, Copy, Debug)]
pub struct Separation<S, const N: usize> {
    /// r = Σ wᵢxᵢ \[m\], from the closest point of the second feature to that of the first.
    pub difference: [S; 3],
    /// wᵢ: barycentric weights of the first feature's points, and minus those of the second's. Their sum is zero.
    pub weights: [S; N],
    /// gᵢ \[1/m\]: tangential; their sum is zero.
    pub weight_gradients: [[S; 3]; N],
    /// N: the projector onto the directions normal to the primitive.
    pub normal_projector: Matrix3<S>,
}

impl<S: Scalar, const N: usize> Separation<S, N> {
    /// s = r·r \[m²\].
    #[inline(always)]
    pub fn value(&self) -> S {
        dot(&self.difference, &self.difference)
    }

    /// ∇ᵢs = 2wᵢ r \[m\].
    #[inline(always)]
    pub fn gradient(&self) -> [Vector3<S>; N] {
        let twice = scaled(&self.difference, S::constant(2.0));
        self.weights.map(|weight| vector(scaled(&twice, weight)))
    }

    /// ∇ᵢ∇ⱼs = 2[wᵢwⱼ N − wᵢ gⱼ rᵀ − wⱼ r gᵢᵀ − (gᵢ·gⱼ) r rᵀ], all blocks.
    #[inline(always)]
    pub fn hessian(&self) -> [[Matrix3<S>; N]; N] {
        let mut hessian = [[zero(); N]; N];
        for i in 0..N {
            for j in 0..=i {
                hessian[i][j] = self.block(i, j);
                if j < i {
                    hessian[j][i] = transpose(&hessian[i][j]);
                }
            }
        }
        hessian
    }

    #[inline(always)]
    fn block(&self, i: usize, j: usize) -> Matrix3<S> {
        let two = S::constant(2.0);
        let (w_i, w_j) = (self.weights[i] * two, self.weights[j] * two);
        let (g_i, g_j) = (&self.weight_gradients[i], &self.weight_gradients[j]);
        let (r, n) = (&self.difference, columns(&self.normal_projector));
        let (normal, radial) = (w_i * self.weights[j], dot(g_i, g_j) * two);
        from_entries(|a, b| {
            normal * n[b][a] - w_i * g_j[a] * r[b] - w_j * r[a] * g_i[b] - radial * r[a] * r[b]
        })
    }
}

/// The squared distance s = d² of a primitive, over its `N` points: lines and planes are infinite.
///
/// Symmetric in the order of the points of a line or plane and of two lines. Values are over any [`Scalar`], so
/// lanes evaluate several pairs at once and jets differentiate them.
pub trait SquaredDistance<const N: usize> {
    /// Difference of the closest points with its weights: the one thing that differs between primitives.
    fn separation<S: Scalar>(x: &[Vector3<S>; N]) -> Separation<S, N>;

    /// s = d² \[m²\].
    #[inline(always)]
    fn value<S: Scalar>(x: &[Vector3<S>; N]) -> S {
        Self::separation(x).value()
    }

    /// ∇s \[m\], one vector per point.
    #[inline(always)]
    fn gradient<S: Scalar>(x: &[Vector3<S>; N]) -> [Vector3<S>; N] {
        Self::separation(x).gradient()
    }

    /// ∇∇s, dimensionless, all blocks.
    #[inline(always)]
    fn hessian<S: Scalar>(x: &[Vector3<S>; N]) -> [[Matrix3<S>; N]; N] {
        Self::separation(x).hessian()
    }
}

/// `a − b`.
#[inline(always)]
fn difference<S: Scalar>(a: &Vector3<S>, b: &Vector3<S>) -> [S; 3] {
    let (a, b) = (components(a), components(b));
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `factor · a`.
#[inline(always)]
fn scaled<S: Scalar>(a: &[S; 3], factor: S) -> [S; 3] {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// `a + factor · b`.
#[inline(always)]
fn add_scaled<S: Scalar>(a: &[S; 3], factor: S, b: &[S; 3]) -> [S; 3] {
    [b[0].mul_add(factor, a[0]), b[1].mul_add(factor, a[1]), b[2].mul_add(factor, a[2])]
}
