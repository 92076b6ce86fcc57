//! Jacobi rotations: a cheap, approximate one for whole sweeps and an exact, ordering one for the last.

use crate::scalar::{Mask, Scalar};
use crate::tensor::{self, Matrix3};

/// Exact sweeps at most. Three are enough for every matrix met; the bound makes an endless loop impossible.
pub(super) const EXACT_SWEEPS_LIMIT: usize = 12;

/// What the exact sweeps may leave off the diagonal, in units of ε times the largest singular value. Rounding leaves
/// about one; three of them at this size keep the promised accuracy.
pub(super) const TOLERANCE_IN_EPSILONS: f64 = 3.0;

/// The three index pairs of a sweep with the third index, in cyclic order, so that the rotation that takes
/// e_p towards e_q turns about +e_r.
const CYCLIC: [[usize; 3]; 3] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];

/// The pairs of an exact sweep: rotations that put the larger first, in this order, sort.
pub(super) const SORTING: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];

/// Approximate sweeps after which one exact sweep almost always finishes: four in double precision, three in single.
#[inline(always)]
pub(super) fn sweeps_needed<S: Scalar>() -> usize {
    if S::EPSILON < 1e-10 { 4 } else { 3 }
}

/// A power of two that brings `magnitude` near one; NaN where that is impossible (not finite, or too large).
#[inline(always)]
pub(super) fn normaliser<S: Scalar>(magnitude: S) -> S {
    let factor = magnitude.reciprocal_power_of_two();
    S::select(S::constant(0.0).less(factor), factor, S::constant(f64::NAN))
}

/// The sum of |entries|: between ‖A‖ and 3 ‖A‖, and NaN if any entry is (a maximum by comparisons forgets NaN).
#[inline(always)]
pub(super) fn entry_sum<S: Scalar>(a: &Matrix3<S>) -> S {
    // A loop: a closure is not always inlined, and then runs without vector instructions.
    let mut sums = [S::constant(0.0); 3];
    for (sum, column) in sums.iter_mut().zip(tensor::columns(a)) {
        *sum = column[0].abs() + column[1].abs() + column[2].abs();
    }
    sums[0] + sums[1] + sums[2]
}

/// The orthogonal V, det V = +1, for which Vᵀ S V is nearly diagonal, after `sweeps` cyclic Jacobi sweeps over the
/// symmetric `s`, whose entries are of order one. Only its lower triangle is read.
///
/// Nothing is normalised on the way: the rotation by θ in the plane (p, q) is kept as an unnormalised quaternion
/// (h, k) ∝ (cos θ/2, sin θ/2), and S is conjugated by its unnormalised matrix with entries C = h² − k², D = 2hk in the
/// plane and n = h² + k² on the third axis. That multiplies S by n², which changes no angle, and saves every
/// square root and division but one at the end. A power of two keeps n between 1 and 4.7, so that four sweeps multiply S
/// by less than 4.7²⁴ = 10¹⁶ and the squares of its entries stay below 10³⁵; after every four sweeps another power of
/// two takes that growth out.
///
/// # Reference
/// The unnormalised quaternion in place of a matrix is due to McAdams, Selle, Tamstorf, Teran, Sifakis (2011),
/// *Computing the Singular Value Decomposition of 3×3 matrices with minimal branching and elementary floating point
/// operations*, section 2. Their angle, tan θ/2 ≈ S_pq / (2 d) or π/4, needs about one sweep more than the one below.
#[inline(always)]
pub(super) fn approximate_eigenvectors<S: Scalar>(s: &Matrix3<S>, sweeps: usize) -> [[S; 3]; 3] {
    let c = tensor::columns(s);
    let mut diagonal = [c[0][0], c[1][1], c[2][2]];
    // Entry r is the off-diagonal entry of the pair without r.
    let mut off = [c[1][2], c[0][2], c[0][1]];
    let mut vector = [S::constant(0.0); 3];
    let mut real = S::constant(1.0);
    for sweep in 0..sweeps {
        if sweep % 4 == 0 && sweep > 0 {
            let unit = (size(diagonal) + size(off)).reciprocal_power_of_two();
            for entry in diagonal.iter_mut().chain(&mut off) {
                *entry *= unit;
            }
        }
        for [p, q, r] in CYCLIC {
            off[r] = without_dust(off[r], diagonal[p].abs() + diagonal[q].abs());
            let (h, k) = half_angle(diagonal[p] - diagonal[q], off[r]);
            conjugate(&mut diagonal, &mut off, [p, q, r], h, k);
            let (w, x) = (real, vector);
            real = h * w - k * x[r];
            vector[r] = h.mul_add(x[r], k * w);
            vector[p] = h.mul_add(x[p], k * x[q]);
            vector[q] = h * x[q] - k * x[p];
        }
    }
    rotation_columns(real, vector)
}

/// An off-diagonal below ε² of its diagonal, far below the rounding of S, is zero. Near the identity products of such numbers are
/// subnormal in `f32`, and an operation on a subnormal number takes some hundred cycles: without this line a matrix takes 35 ns more.
#[inline(always)]
fn without_dust<S: Scalar>(off: S, diagonal: S) -> S {
    let dust = off.abs().less(diagonal.scale(S::EPSILON * S::EPSILON));
    S::select(dust, S::constant(0.0), off)
}

/// An unnormalised (h, k) ∝ (cos θ/2, sin θ/2), h in [1, 2), for `difference` d = S_pp − S_qq and `off` = S_pq.
///
/// The rotation that annihilates S_pq turns by θ with tan 2θ = y = 2 S_pq / d, |θ| ≤ π/4. The function wanted,
/// tan(¼ arctan y) = y/4 − 5/64 y³ + …, is replaced by
///
/// r(y) = y (1 + β|y|) / (4 (1 + β|y|) + γ y²) = y/4 − γ/16 y³ + …,
///
/// which needs no root, no division and no comparison when it is kept as a fraction. γ = 5/4 would match the cubic
/// term and β = γ tan π/8 the limit |y| → ∞. The values taken leave |θ| wrong by 3.5 degrees at most, and the off-diagonal
/// falls cubically at the end; they were chosen among such pairs by counting unfinished matrices.
#[inline(always)]
fn half_angle<S: Scalar>(difference: S, off: S) -> (S, S) {
    const BETA: f64 = 0.58;
    const GAMMA: f64 = 1.4;
    let twice = off + off;
    let size = difference.abs();
    let w = twice.abs().mul_add(S::constant(BETA), size);
    // The smallest number there is makes the rotation of a multiple of the identity the identity.
    let rest = (twice * twice).mul_add(S::constant(GAMMA), S::constant(S::MIN_POSITIVE));
    let h = (size * w).mul_add(S::constant(4.0), rest);
    let k = twice * w.copysign(difference);
    let unit = h.reciprocal_power_of_two();
    (h * unit, k * unit)
}

/// S ← Qᵀ S Q for the unnormalised rotation of the quaternion (h, k e_r).
#[inline(always)]
fn conjugate<S: Scalar>(diagonal: &mut [S; 3], off: &mut [S; 3], [p, q, r]: [usize; 3], h: S, k: S) {
    let (hh, kk) = (h.square(), k.square());
    let (c, n) = (hh - kk, hh + kk);
    let d = (h + h) * k;
    let (a, b, m) = (diagonal[p], diagonal[q], off[r]);
    // Rows p and q of Qᵀ S within the plane.
    let (pp, pq) = (c.mul_add(a, d * m), c.mul_add(m, d * b));
    let (qp, qq) = (c * m - d * a, c * b - d * m);
    diagonal[p] = c.mul_add(pp, d * pq);
    diagonal[q] = c * qq - d * qp;
    off[r] = c * pq - d * pp;
    diagonal[r] *= n.square();
    let (nc, nd) = (n * c, n * d);
    let (rp, rq) = (off[q], off[p]);
    off[q] = nc.mul_add(rp, nd * rq);
    off[p] = nc * rq - nd * rp;
}

/// Columns of the rotation matrix of the unnormalised quaternion (w, x, y, z).
#[inline(always)]
fn rotation_columns<S: Scalar>(w: S, [x, y, z]: [S; 3]) -> [[S; 3]; 3] {
    let twice = S::constant(2.0) / (w.square() + x.square() + y.square() + z.square());
    let one = S::constant(1.0);
    let (tx, ty, tz) = (twice * x, twice * y, twice * z);
    let (wx, wy, wz) = (tx * w, ty * w, tz * w);
    let (xx, yy, zz) = (tx * x, ty * y, tz * z);
    let (xy, xz, yz) = (tx * y, tx * z, ty * z);
    [
        [one - (yy + zz), xy + wz, xz - wy],
        [xy - wz, one - (xx + zz), yz + wx],
        [xz + wy, yz - wx, one - (xx + yy)],
    ]
}

/// (cos θ, sin θ) of the rotation p′ = c p + s q, q′ = c q − s p that diagonalises [[a, m], [m, b]] and puts the
/// larger eigenvalue first; (1, 0) on the lanes that are not `active`.
///
/// With d = a − b and h = √(d² + 4m²), cos 2θ = d/h and sin 2θ = 2m/h. Of the two half-angle formulas the one
/// without cancellation is taken: with l = h + |d| and n = 1/√(l² + 4m²),
/// (c, s) = n (l, 2m) if d ≥ 0, and n (|2m|, ± l) otherwise, ± the sign of m.
#[inline(always)]
pub(super) fn ordering_rotation<S: Scalar>(a: S, b: S, m: S, active: S::Mask) -> (S, S) {
    let zero = S::constant(0.0);
    let (d, twice) = (a - b, m + m);
    let h = d.mul_add(d, twice.square()).sqrt();
    let long = h + d.abs();
    let squared_length = long.mul_add(long, twice.square());
    let ordered = zero.less_equal(d);
    let n = squared_length.sqrt().recip();
    let (short, long) = (twice.abs() * n, long * n);
    let cos = S::select(ordered, long, short);
    let sin = S::select(ordered, short, long).copysign(m);
    // Two equal eigenvalues, or a plane far below the rounding of the rest: nothing to do.
    let idle = squared_length.less(S::constant(4.0 * S::MIN_POSITIVE)).or(active.not());
    (S::select(idle, S::constant(1.0), cos), S::select(idle, zero, sin))
}

/// (p, q) ← (c p + s q, c q − s p).
#[inline(always)]
pub(super) fn rotate<S: Scalar>(columns: &mut [[S; 3]; 3], [p, q]: [usize; 2], (c, s): (S, S)) {
    for i in 0..3 {
        let (a, b) = (columns[p][i], columns[q][i]);
        columns[p][i] = c.mul_add(a, s * b);
        columns[q][i] = c * b - s * a;
    }
}

/// Takes the rounding errors of the products of rotations out of an orthogonal V: one Newton step of 1/√x on its first two columns'
/// lengths, their inner product removed, the third their cross product.
#[inline(always)]
pub(super) fn orthonormalise<S: Scalar>(v: &mut [[S; 3]; 3]) {
    let length = reciprocal_length(&v[0]);
    v[0] = [v[0][0] * length, v[0][1] * length, v[0][2] * length];
    let across = without(&v[1], &v[0], tensor::dot(&v[0], &v[1]));
    let length = reciprocal_length(&across);
    v[1] = [across[0] * length, across[1] * length, across[2] * length];
    v[2] = tensor::cross(&v[0], &v[1]);
}

/// 1/‖a‖ where that is nearly one: (3 − ‖a‖²)/2.
#[inline(always)]
fn reciprocal_length<S: Scalar>(a: &[S; 3]) -> S {
    tensor::dot(a, a).mul_add(S::constant(-0.5), S::constant(1.5))
}

/// |a| + |b| + |c|.
#[inline(always)]
fn size<S: Scalar>([a, b, c]: [S; 3]) -> S {
    a.abs() + b.abs() + c.abs()
}

/// `a − amount · u`.
#[inline(always)]
pub(super) fn without<S: Scalar>(a: &[S; 3], u: &[S; 3], amount: S) -> [S; 3] {
    let minus = -amount;
    [minus.mul_add(u[0], a[0]), minus.mul_add(u[1], a[1]), minus.mul_add(u[2], a[2])]
}

/// The mask that is true on every lane.
#[inline(always)]
pub(super) fn every_lane<S: Scalar>() -> S::Mask {
    S::constant(0.0).less_equal(S::constant(0.0))
}
