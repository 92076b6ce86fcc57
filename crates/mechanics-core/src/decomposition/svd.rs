//! Singular value decomposition.

use super::jacobi::{self, EXACT_SWEEPS_LIMIT, SORTING, TOLERANCE_IN_EPSILONS};
use crate::scalar::{Mask, Scalar};
use crate::tensor::{self, Matrix3};

/// F = U diag(σ) Vᵀ. See [`svd`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Svd<S> {
    /// U, a rotation.
    pub u: Matrix3<S>,
    /// σ₀ ≥ σ₁ ≥ |σ₂|; σ₂ has the sign of det F.
    pub sigma: [S; 3],
    /// V, a rotation.
    pub v: Matrix3<S>,
}

impl<S: Scalar> Svd<S> {
    /// The decomposition of the identity.
    #[inline(always)]
    pub fn identity() -> Self {
        let one = S::constant(1.0);
        let identity = tensor::multiple_of_identity(one);
        Self { u: identity, sigma: [one; 3], v: identity }
    }
}

/// The singular value decomposition with rotations: F = U diag(σ) Vᵀ, det U = det V = +1, σ₀ ≥ σ₁ ≥ |σ₂|, and σ₂
/// with the sign of det F. Accuracy, domain and NaN: see the [module](super) page.
///
/// # Derivation
///
/// 1. F is scaled by a power of two to order one.
/// 2. Cyclic Jacobi sweeps on FᵀF with approximate, unnormalised rotations give V (a quaternion). Squaring F
///    leaves errors of ε σ₀² in FᵀF: the columns of B = F V are orthogonal only to ε σ₀/σ₁ and so on.
/// 3. One exact sweep of one-sided Jacobi (Hestenes) on B: the rotation of two columns that makes them
///    orthogonal and puts the longer first is applied to B and V alike. Its angle comes from the columns
///    themselves, so the error of step 2 is gone, and so is that of unfinished sweeps, to third order.
/// 4. u₀ = b₀/|b₀|; u₁ = b₁ without its part along u₀, normalised; u₂ = u₀ × u₁, whence det U = 1; σᵢ = uᵢ · bᵢ, and
///    σ₂ takes the sign by itself. Where b₁ is but rounding noise along u₀ (rank one), u₁ is any direction
///    across u₀.
/// 5. What step 4 drops is u₀·b₁, u₀·b₂ and u₁·b₂. Where one exceeds rounding, step 3 is repeated on that lane (σ₀/σ₂ beyond
///    about 1/√ε, a few unlucky matrices in a million otherwise).
///
/// # Reference
/// Steps 1, 2: McAdams et al. (2011), as cited at the sweeps. Step 3: Hestenes (1958), *Inversion of matrices by
/// biorthogonalization and related results*; the ordering rotation as in de Rijk (1989), *A one-sided Jacobi
/// algorithm for computing the singular value decomposition on a vector computer*.
#[inline(always)]
pub fn svd<S: Scalar>(f: &Matrix3<S>) -> Svd<S> {
    decompose(f, jacobi::sweeps_needed::<S>(), EXACT_SWEEPS_LIMIT)
}

/// The most sweeps that [`svd_with_sweeps`] makes: beyond, the unnormalised rotation may overflow in `f32`.
pub const MOST_SWEEPS: usize = 8;

/// [`svd`] in constant time: `sweeps` approximate sweeps and one exact sweep, never more. The factors are as
/// orthogonal as those of [`svd`]; the reconstruction is as good as the number of sweeps allows. Four (`f64`) or three
/// (`f32`) leave nothing to be gained.
///
/// # Panics
/// If `sweeps` is more than [`MOST_SWEEPS`].
#[inline(always)]
pub fn svd_with_sweeps<S: Scalar>(f: &Matrix3<S>, sweeps: usize) -> Svd<S> {
    assert!(sweeps <= MOST_SWEEPS, "so many sweeps would overflow");
    decompose(f, sweeps, 1)
}

#[inline(always)]
fn decompose<S: Scalar>(f: &Matrix3<S>, sweeps: usize, exact_sweeps: usize) -> Svd<S> {
    let unit = jacobi::normaliser(jacobi::entry_sum(f));
    let f = tensor::scaled(f, unit);
    let mut v = jacobi::approximate_eigenvectors(&tensor::transpose_product(&f, &f), sweeps);
    let mut b = *tensor::columns(&tensor::product(&f, &tensor::from_columns(v)));
    let mut active = jacobi::every_lane::<S>();
    let mut exact = 0;
    let (u, sigma) = loop {
        exact_sweep(&mut b, &mut v, active);
        exact += 1;
        let (u, sigma) = orthonormal_frame(&b);
        if exact == exact_sweeps {
            break (u, sigma);
        }
        active = unfinished(&b, &u, sigma[0]);
        if !active.any() {
            break (u, sigma);
        }
    };
    jacobi::orthonormalise(&mut v);
    let scale = unit.recip();
    // Equal ones may come out of order by a rounding error.
    let middle = sigma[1].max(sigma[2].abs());
    let largest = sigma[0].max(middle);
    Svd {
        u: tensor::from_columns(u),
        sigma: [largest * scale, middle * scale, sigma[2] * scale],
        v: tensor::from_columns(v),
    }
}

/// One-sided Jacobi over the pairs of columns of B, the same rotations on V.
#[inline(always)]
fn exact_sweep<S: Scalar>(b: &mut [[S; 3]; 3], v: &mut [[S; 3]; 3], active: S::Mask) {
    for [p, q] in SORTING {
        let (pp, qq, pq) = (tensor::dot(&b[p], &b[p]), tensor::dot(&b[q], &b[q]), tensor::dot(&b[p], &b[q]));
        let rotation = jacobi::ordering_rotation(pp, qq, pq, active);
        jacobi::rotate(b, [p, q], rotation);
        jacobi::rotate(v, [p, q], rotation);
    }
}

/// U and σ from the sorted, nearly orthogonal columns of B.
#[inline(always)]
fn orthonormal_frame<S: Scalar>(b: &[[S; 3]; 3]) -> ([[S; 3]; 3], [S; 3]) {
    let (zero, one) = (S::constant(0.0), S::constant(1.0));
    let length_squared = tensor::dot(&b[0], &b[0]);
    let inverse = length_squared.sqrt().recip();
    let vanishes = length_squared.less_equal(zero);
    let first = [
        S::select(vanishes, one, b[0][0] * inverse),
        S::select(vanishes, zero, b[0][1] * inverse),
        S::select(vanishes, zero, b[0][2] * inverse),
    ];
    let second = second_direction(&first, &b[1]);
    let third = tensor::cross(&first, &second);
    let sigma = [tensor::dot(&first, &b[0]), tensor::dot(&second, &b[1]), tensor::dot(&third, &b[2])];
    ([first, second, third], sigma)
}

/// The direction of `b` across the unit vector `u`; any direction across `u` where `b` points along it.
#[inline(always)]
fn second_direction<S: Scalar>(u: &[S; 3], b: &[S; 3]) -> [S; 3] {
    let across = jacobi::without(b, u, tensor::dot(u, b));
    let length_squared = tensor::dot(&across, &across);
    let inverse = length_squared.sqrt().recip();
    let unit = [across[0] * inverse, across[1] * inverse, across[2] * inverse];
    // Once more: where the subtraction cancelled digits, its rounding error has just been magnified.
    let unit = jacobi::without(&unit, u, tensor::dot(u, &unit));
    // By construction b is along u only where it is rounding noise; a 64th of noise is nothing.
    let noise = length_squared.less_equal(tensor::dot(b, b).scale(1.0 / 4096.0));
    if !noise.any() {
        return unit;
    }
    let any = perpendicular(u);
    [S::select(noise, any[0], unit[0]), S::select(noise, any[1], unit[1]), S::select(noise, any[2], unit[2])]
}

/// A unit vector across the unit vector `u`.
///
/// # Reference
/// Duff, Burgess, Christensen, Hery, Kensler, Liani, Villemin (2017), *Building an orthonormal basis, revisited*.
#[inline(always)]
fn perpendicular<S: Scalar>([x, y, z]: &[S; 3]) -> [S; 3] {
    let one = S::constant(1.0);
    let sign = S::select(z.less(S::constant(0.0)), -one, one);
    let a = -(sign + *z).recip();
    [*x * *y * a, y.square().mul_add(a, sign), -*y]
}

/// The lanes on which B is not yet upper triangular in the basis U, up to rounding.
#[inline(always)]
fn unfinished<S: Scalar>(b: &[[S; 3]; 3], u: &[[S; 3]; 3], largest: S) -> S::Mask {
    let tolerance = largest.scale(TOLERANCE_IN_EPSILONS * S::EPSILON);
    let overlaps = [overlap(&u[0], &b[1]), overlap(&u[0], &b[2]), overlap(&u[1], &b[2])];
    tolerance.less(overlaps[0]).or(tolerance.less(overlaps[1])).or(tolerance.less(overlaps[2]))
}

/// |a·b|.
#[inline(always)]
fn overlap<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> S {
    tensor::dot(a, b).abs()
}
