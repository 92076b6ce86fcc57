//! The energy of active pairs and its derivatives, one [`Stencil`] for each kind of closest features.
//!
//! The energy of one pair is
//!
//! E(x) = w κ m(x) b(s(x)),
//!
//! with its weight w (negative for the pairs that the improved maximum operator subtracts), the stiffness κ, the
//! [barrier](crate::barrier) b, the squared distance s of the *primitive* (infinite line or plane) that the contact set
//! found closest, and, for nearly parallel edges only, the mollifier m. Each list borrows the law and its weights, so that
//! a caller makes them on the fly and hands their `…_into` methods to an assembler or a sum. All of them compute four
//! pairs at a time in the lanes of a vector register.
//!
//! # Derivatives
//!
//! All distances are minima of one kind: with weights ω(λ) on the points, linear in the parameters λ of the closest
//! position on the features,
//!
//! s(x) = min over λ of |y|², y = Σᵢ ωᵢ(λ) xᵢ.
//!
//! At the minimum y is orthogonal to the tangents e_k = Σᵢ ∂ωᵢ/∂λ_k xᵢ. Choose parameters for which the tangents are
//! orthonormal, call them t_k, with τ_k = ∂ω/∂λ_k the weight vector of each (the *tilt*), n = y/d, and a⊗b for the vector
//! whose part at point i is aᵢ b. Then (envelope theorem, and elimination of λ from the second variation)
//!
//! - ∇s = 2 d ω⊗n
//! - ½∇²s = (ω⊗n)(ω⊗n)ᵀ + Σ_q (ω⊗q)(ω⊗q)ᵀ − Σ_k [ s (τ_k⊗n)(τ_k⊗n)ᵀ + d (τ_k⊗n)(ω⊗t_k)ᵀ + d (ω⊗t_k)(τ_k⊗n)ᵀ ],
//!
//! where q runs over the directions orthogonal to n and all t_k: two for two points, one for a point and a line, none
//! for planes and pairs of lines. With B′ = w κ b′ and α = w κ (4 s b″ + 2 b′), which is w κ times the second derivative of
//! the barrier with respect to d,
//!
//! ∇²E = α (ω⊗n)(ω⊗n)ᵀ + 2B′ Σ_q (ω⊗q)(ω⊗q)ᵀ − 2B′ Σ_k […].
//!
//! # Projection in the reduced basis
//!
//! Let ω̂, v₁, v₂ be an orthonormal basis of the weight vectors whose entries sum to zero, ω̂ along ω. Every τ_k is in its
//! span (a translation moves no distance). The Hessian of a point and a plane, and of two lines, therefore lives on
//! the five orthonormal vectors ω̂⊗n, v₁⊗n, v₂⊗n, ω̂⊗t₁, ω̂⊗t₂; that of a point and a line on the three ω̂⊗n, v⊗n, ω̂⊗t, and on
//! ω̂⊗q with the eigenvalue 2B′|ω|²; that of two points on ω̂⊗n and two ω̂⊗q. Their span is isometric to R⁵ (R³ + R, R³), so the
//! eigenvalues of the small matrix are those of the whole Hessian, whose others are zero, and replacing them there *is* the
//! projection of the whole Hessian. The small matrices of four pairs are diagonalised at a time, by QR sweeps in lanes.
//!
//! What the projections guarantee, for weights of either sign (w κ is multiplied in before eigenvalues are looked at):
//! [`Projection::None`] is the true Hessian; [`Projection::Clamp`] the nearest positive semi-definite matrix to it;
//! [`Projection::Absolute`] a semi-definite matrix with the same eigenvectors and sizes of curvature, never below the
//! clamped one; [`Curvature::GaussNewton`] is described there.
//!
//! # Accuracy
//!
//! Besides rounding of the barrier (a few units in the last place), rounding of differences of positions changes the
//! gap d of features of length L by ε L/(d sin θ) relatively, and the weights of the closest position by
//! ε (d/L)/sin²θ, where sin θ is the height over the longest edge of a triangle or the sine of the angle of two edges. That is
//! what a rounding of the positions themselves does. Projected Hessians agree with the eigen-decomposition of the whole
//! one to 1e-14 of its largest entry (tests/pair.rs). Results for one pair alone and within a group of eight differ by rounding, because lanes
//! are diagonalised together.
//!
//! # Measured
//!
//! `benches/pair.rs`, one core, nanoseconds a pair, in runs of 32 (a 12×12 decomposition by nalgebra in the same run: 5,600):
//!
//! | | value | gradient | Hessian | projected | Gauss–Newton |
//! |---|---|---|---|---|---|
//! | two points | 8 | 10 | 15 | 16 | 16 |
//! | point, edge | 12 | 16 | 33 | 73 | 33 |
//! | point, triangle; two edges | 13–16 | 22–25 | 80 | 280 | 46 |
//! | nearly parallel edges (four in five) | 86 | 133 | 725 | 1,840 | 326 |

mod edges;
mod eigen;
mod half_space;
mod lines;
mod planar;
mod points;
mod run;

pub use edges::EdgeEdgePairs;
pub use half_space::HalfSpacePairs;
pub use lines::PointEdgePairs;
pub use planar::PointTrianglePairs;
pub use points::PointPointPairs;

use crate::barrier::Barrier;
use mechanics_core::scalar::Scalar;
#[cfg(doc)]
use mechanics_core::{projection::Projection, stencil::Stencil};

/// Which Hessian the projections act on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curvature {
    /// All of it: the projection of ∇²E, exact.
    #[default]
    Full,
    /// Its part along the gap, w κ m (d²b/dd²) ∇d ∇dᵀ, of rank one: the change of the gap's direction and of the
    /// mollifier are left out.
    ///
    /// It is positive semi-definite for w > 0 and every barrier convex in d (all of this crate), equal to the clamped Hessian
    /// for two points, and cheap. It is *not* an upper bound of the Hessian, so Newton's method takes more iterations
    /// where pairs slide. `Projection::None` ignores it and gives the true Hessian.
    GaussNewton,
}

/// What the pairs of all lists share.
#[derive(Debug)]
pub struct PairLaw<'a, B: ?Sized> {
    /// The barrier b.
    pub barrier: &'a B,
    /// κ > 0; its unit makes κ times weight times b joules, see [`barrier`](crate::barrier).
    pub stiffness: f64,
    /// Which Hessian the projections act on.
    pub curvature: Curvature,
}

impl<B: ?Sized> Clone for PairLaw<'_, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B: ?Sized> Copy for PairLaw<'_, B> {}

impl<B: Barrier + ?Sized> PairLaw<'_, B> {
    /// w κ b.
    #[inline]
    fn energy(&self, weight: f64, squared_distance: f64) -> f64 {
        weight * self.stiffness * self.barrier.value(squared_distance)
    }

    /// w κ b′.
    #[inline]
    fn first(&self, weight: f64, squared_distance: f64) -> f64 {
        weight * self.stiffness * self.barrier.first(squared_distance)
    }

    /// [2 w κ b′, w κ (4 s b″ + 2 b′)]: the coefficients of the Hessian across and along the gap.
    #[inline]
    fn across_and_along(&self, weight: f64, squared_distance: f64) -> [f64; 2] {
        let factor = weight * self.stiffness;
        let [first, second] = self.barrier.first_and_second(squared_distance);
        let across = 2.0 * first;
        [factor * across, factor * (4.0 * squared_distance * second + across)]
    }
}

/// a − b.
#[inline(always)]
fn minus<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> [S; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a · factor. A loop, not `map`, whose closure would be compiled without vector instructions.
#[inline(always)]
fn times<S: Scalar, const N: usize>(a: &[S; N], factor: S) -> [S; N] {
    let mut product = *a;
    for i in 0..N {
        product[i] = a[i] * factor;
    }
    product
}
