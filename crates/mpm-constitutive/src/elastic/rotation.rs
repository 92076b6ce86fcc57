//! The rotation nearest to a deformation gradient, fast.

use mechanics_core::decomposition::polar;
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{
    Matrix3, add_scaled, cofactor, columns, dot, from_entries, norm_squared, scaled,
};

/// Newton steps with a scale, before those without, on lanes that are far from a rotation.
const SCALED_STEPS: usize = 2;
/// Lanes with (‖F‖²/3)^(3/2) below this times det F, and det F between these bounds, need no scale: σ between ½ and 2.2.
const EVEN: f64 = 1.25;
const NEAR_ONE: [f64; 2] = [0.5, 2.0];
/// Steps without a scale at most. Four are enough where det F is as large as [`ORDINARY`] asks.
const MOST_STEPS: usize = 8;
/// Lanes with det F below this times (‖F‖²/3)^(3/2) take the singular value decomposition.
const ORDINARY: f64 = 0.02;

/// The rotation R of F = R S, for any real F, as [`polar`] gives it, at about a third of its cost where F is well
/// conditioned.
///
/// Newton's method for XᵀX = I on rotations, X ← ½(X + X⁻ᵀ), replaces each singular value σ by ½(σ + 1/σ) and keeps the singular
/// vectors: it converges to R from every F with det F > 0, quadratically, with errors eₖ₊₁ ≤ ½eₖ² for e = ‖X − R‖ once σ ≥ 1 (after the
/// first step). Far from rotations the first steps replace X by γX, γ⁴ = ‖X⁻¹‖²/‖X‖², which centres the singular values about one: two roots and two
/// quotients a step, one after the other, that others are spared. X⁻ᵀ = cof X/det X.
/// As all σ ≥ 1 then, no e is larger than det X − 1, which a step makes anyway: a lane stops after the step from (det X − 1)² ≤ ε/2. What one lane
/// gives does not depend on the others.
///
/// Lanes that are inverted, nearly flat, not finite, or so large or small that squares of cofactors leave the range of numbers take
/// [`polar`].
///
/// # Reference
/// Higham, Computing the polar decomposition—with applications (1986).
#[inline(always)]
pub fn nearest_rotation<S: Scalar>(f: &Matrix3<S>) -> Matrix3<S> {
    let size = norm_squared(f).scale(1.0 / 3.0);
    let cubed = size * size.sqrt();
    let (mut x, volume) = step(f);
    let ordinary = cubed.scale(ORDINARY).less(volume);
    let [least, most] = NEAR_ONE.map(S::constant);
    let near = cubed.less(volume.scale(EVEN)).and(least.less(volume)).and(volume.less(most));
    if !near.all() {
        let mut centred = *f;
        for _ in 0..SCALED_STEPS {
            centred = scaled_step(&centred);
        }
        x = select(near, &x, &centred);
    }
    let mut active = ordinary;
    for _ in 0..MOST_STEPS {
        let (next, volume) = step(&x);
        let error = volume.offset(-1.0);
        x = select(active, &next, &x);
        // In this sense, so that NaN (an over- or underflow on the way) never counts as converged.
        active = active.and(error.square().less_equal(S::constant(0.5 * S::EPSILON)).not());
        if !active.any() {
            break;
        }
    }
    let done = ordinary.and(active.not());
    if done.all() {
        return x;
    }
    select(done, &x, &polar(f).rotation)
}

/// ½(X + X⁻ᵀ), and det X.
#[inline(always)]
fn step<S: Scalar>(x: &Matrix3<S>) -> (Matrix3<S>, S) {
    let (cofactor, volume) = cofactor_and_volume(x);
    (scaled(&add_scaled(x, volume.recip(), &cofactor), S::constant(0.5)), volume)
}

/// ½(γX + X⁻ᵀ/γ).
#[inline(always)]
fn scaled_step<S: Scalar>(x: &Matrix3<S>) -> Matrix3<S> {
    let (cofactor, volume) = cofactor_and_volume(x);
    // γ² = ‖cof X‖/(|det X| ‖X‖), halved once for the mean.
    let squared = (norm_squared(&cofactor) / norm_squared(x)).sqrt() / volume.abs();
    let factor = squared.sqrt().scale(0.5);
    let inverse_factor = (factor * volume).recip().scale(0.25);
    add_scaled(&scaled(x, factor), inverse_factor, &cofactor)
}

#[inline(always)]
fn cofactor_and_volume<S: Scalar>(x: &Matrix3<S>) -> (Matrix3<S>, S) {
    let c = cofactor(x);
    let volume = dot(&columns(x)[0], &columns(&c)[0]);
    (c, volume)
}

/// `yes` on the lanes of the mask, `no` elsewhere.
#[inline(always)]
pub(crate) fn select<S: Scalar>(mask: S::Mask, yes: &Matrix3<S>, no: &Matrix3<S>) -> Matrix3<S> {
    let (yes, no) = (columns(yes), columns(no));
    from_entries(|i, j| S::select(mask, yes[j][i], no[j][i]))
}
