//! The energy of friction of one pair and its derivatives, for pairs of one to four points.
//!
//! With the velocity v(x) = a (x − x̂) of the [time scheme](mechanics_core::stage), a pair with lagged weights w, normal n and normal
//! force λ slides with
//!
//! u(x) = a (I − n nᵀ) (Σ wᵢ xᵢ − r̂), r̂ = Σ wᵢ x̂ᵢ, y = ‖u‖,
//!
//! and its energy is D(x) = λ P(y)/a with the potential P′ = μ of the [law](crate::law). Since ∂u/∂xᵢ = a wᵢ (I − n nᵀ), with
//! û = u/y,
//!
//! - ∂D/∂xᵢ = wᵢ λ (μ/y) u: the force on point i is −wᵢ λ μ û, against the slip; the forces add up to −Σ wᵢ, which is zero;
//! - ∂²D/∂xᵢ∂xⱼ = wᵢ wⱼ K, K = a λ [ (μ/y) (I − n nᵀ − û ûᵀ) + μ′ û ûᵀ ].
//!
//! K has the eigenvalues a λ μ′ along the slip, a λ μ/y across it and 0 along n, and w wᵀ the one |w|² and zeros: the
//! eigenvalues of the 3N × 3N Hessian are those of K times |w|². Replacing negative ones in K *is* therefore the projection of the
//! whole Hessian. For λ > 0 only the first can be negative, and only where μ falls from μ_s to μ_k; for λ < 0 (area-weighted
//! barrier) all can.
//!
//! μ/y is a polynomial of y below εᵥ, and û ûᵀ comes with μ′ − μ/y = O(y), so that nothing is divided by a slip of zero: there
//! D is at its minimum, the gradient is zero and K = a λ μ_s f₁′(0)/εᵥ (I − n nᵀ).
//!
//! # A floor under the curvature along the slip
//! Beyond εᵥ the curvature along the slip is zero: Newton's method does not see the kink at rest, jumps over it, and where many pairs
//! are about to stick at a tiny εᵥ it may not converge. [`FrictionPairs::floor`] = θ > 0 replaces μ′ by max(μ′, θ μ/y). With θ = 1 that is
//! the quadratic in y that touches the potential and is nowhere below it; a tenth of it is enough to see the kink, and costs little
//! where pairs slide. It is a Hessian for minimisers, no longer the derivative of the gradient; value and gradient are untouched, and so
//! is the minimum.
//!
//! Four pairs are computed at a time in the lanes of a vector register.
//!
//! # Measured
//! `benches/friction.rs`, one core, nanoseconds a pair in runs of 32 (a 12×12 decomposition by nalgebra in the same run: 5,300 to 5,600):
//!
//! | points of the pair | value | gradient | Hessian | projected | projected and assembled |
//! |---|---|---|---|---|---|
//! | 1 | 4.6 | 5.2 | 10 | 11 | |
//! | 2 | 5.4 | 7.6 | 15 | 15 | |
//! | 3 | 5.9 | 8.6 | 19 | 20 | |
//! | 4 | 8.5 | 15 | 25 | 26 | 66 |

mod run;

use crate::law::{SmoothedCoulomb, Strength};
use ipc_contact::normal_force::NormalForce;
use mechanics_core::potential::Demand;
use mechanics_core::projection::Projection;
use mechanics_core::stage::Scheme;
use mechanics_core::stencil::{LocalHessian, Stencil};
use mechanics_core::tensor::Vec3;
use run::Run;

/// What is held constant of a pair while positions are sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaggedPair<const N: usize> {
    /// The weights w of the closest points.
    pub weights: [f64; N],
    /// The unit normal n.
    pub normal: Vec3,
    /// r̂ = Σ wᵢ x̂ᵢ \[m\]: Σ wᵢ xᵢ where the relative velocity is zero.
    pub origin: Vec3,
    /// λ times coefficients \[N\].
    pub strength: Strength<f64>,
}

impl<const N: usize> Default for LaggedPair<N> {
    /// A pair without friction.
    fn default() -> Self {
        let (normal, origin) = (Vec3::zeros(), Vec3::zeros());
        Self { weights: [0.0; N], normal, origin, strength: Strength::default() }
    }
}

impl<const N: usize> LaggedPair<N> {
    /// The pair that `force` presses with the `strength`.
    ///
    /// # Panics
    /// If the force has not N points, or x̂ not all of them.
    pub fn new(force: &NormalForce, strength: Strength<f64>, scheme: &Scheme<'_>) -> Self {
        let weights: [f64; N] = std::array::from_fn(|i| force.weights()[i]);
        let origin = force.points().iter().zip(&weights);
        let origin = origin.map(|(&point, &weight)| scheme.velocity_origin[point as usize] * weight).sum();
        Self { weights, normal: force.normal, origin, strength }
    }

    /// The part of Σ wᵢ dᵢ across the normal.
    #[inline]
    pub fn tangential(&self, vectors: &[Vec3; N]) -> Vec3 {
        self.across(&self.weighted(vectors))
    }

    /// Σ wᵢ xᵢ.
    #[inline]
    fn weighted(&self, vectors: &[Vec3; N]) -> Vec3 {
        let mut sum = vectors[0] * self.weights[0];
        for (vector, &weight) in vectors.iter().zip(&self.weights).skip(1) {
            sum += vector * weight;
        }
        sum
    }

    #[inline]
    fn across(&self, vector: &Vec3) -> Vec3 {
        vector - self.normal * self.normal.dot(vector)
    }
}

/// Pairs of N points each with friction.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionPairs<const N: usize> {
    /// The law of all of them.
    pub law: SmoothedCoulomb,
    /// a of the time scheme [1/s].
    pub velocity_factor: f64,
    /// θ ≥ 0: the least curvature along the slip in parts of that across; zero for the true Hessian. See the [module](self) page.
    pub floor: f64,
    /// One for each pair.
    pub pairs: Vec<LaggedPair<N>>,
}

impl<const N: usize> FrictionPairs<N> {
    /// u [m/s]: the tangential velocity of a pair's first closest point relative to the second.
    #[inline]
    pub fn slip_velocity(&self, pair: usize, x: &[Vec3; N]) -> Vec3 {
        let pair = &self.pairs[pair];
        pair.across(&(pair.weighted(x) - pair.origin)) * self.velocity_factor
    }

    /// The friction force −λ μ û \[N\] on the first feature of a pair, and that on the second with the other sign.
    pub fn force(&self, pair: usize, x: &[Vec3; N]) -> Vec3 {
        let slip = self.slip_velocity(pair, x);
        slip * -self.law.force_over_speed(self.pairs[pair].strength, slip.norm())
    }

    fn run<'a>(&'a self, first: usize, x: &'a [[Vec3; N]]) -> Run<'a, N> {
        let pairs = &self.pairs[first..first + x.len()];
        Run { law: self.law, velocity_factor: self.velocity_factor, floor: self.floor, pairs, x }
    }
}

impl<const N: usize> Stencil<N> for FrictionPairs<N> {
    fn value(&self, pair: usize, x: &[Vec3; N]) -> f64 {
        let mut value = [0.0];
        self.values_into(pair, std::slice::from_ref(x), &mut value);
        value[0]
    }

    fn gradient(&self, pair: usize, x: &[Vec3; N]) -> [Vec3; N] {
        let mut gradient = [[Vec3::zeros(); N]];
        self.gradients_into(pair, std::slice::from_ref(x), &mut gradient);
        gradient[0]
    }

    /// The lower triangle.
    fn hessian(&self, pair: usize, x: &[Vec3; N], projection: Projection) -> LocalHessian<N> {
        let mut hessian = [[[Default::default(); N]; N]];
        self.hessians_into(pair, std::slice::from_ref(x), projection, &mut hessian);
        hessian[0]
    }

    /// The lists change with contact, which demands end positions; and the slip is that of the end.
    fn demand(&self) -> Demand {
        Demand::EndPositions
    }

    fn values_into(&self, first: usize, x: &[[Vec3; N]], values: &mut [f64]) {
        self.run(first, x).values(values);
    }

    fn gradients_into(&self, first: usize, x: &[[Vec3; N]], gradients: &mut [[Vec3; N]]) {
        self.run(first, x).gradients(gradients);
    }

    fn hessians_into(
        &self,
        first: usize,
        x: &[[Vec3; N]],
        projection: Projection,
        hessians: &mut [LocalHessian<N>],
    ) {
        self.run(first, x).hessians(projection, hessians);
    }
}
