//! How far a step may go before an element inverts.

use super::volume_polynomial::{VolumePolynomial, power_of_two_near, scaled_by_power};
use crate::tensor::Mat3;

/// Steps up to this length are looked at by [`first_inversion`]. A Newton step has length one, and a caller who keeps a
/// distance multiplies the answer by a fraction of at least one half.
pub const LOOK_AHEAD: f64 = 2.0;

/// Relative width to which the bracket of the root is narrowed.
const WIDTH: f64 = 1e-11;

/// A step t > 0 so that det(F + s dF) > 0 for every s in [0, t], in exact arithmetic.
///
/// Returns ∞ if the determinant stays positive on [0, [`LOOK_AHEAD`]], and 0 if det F is not positive or an entry is
/// not finite. Any t > 0 returned is *certified*: rounding errors are bounded and taken off. It is never an over-estimate.
///
/// **How sharp.** Let t* be the true first root. t ≥ (1 − 1e-8) t* where the determinant passes through zero clearly.
/// Where it only touches zero, or comes closer to zero than 1e-22 of p̄(t) = the sum of the absolute values of all products in the
/// expansion of det(F + t dF), it counts as zero: t is then the place where it falls below that, for a touching root
/// about (1 − 1e-10) t*. Likewise det F below 1e-22 p̄(0) counts as zero. A step 1e18 times larger than F is therefore
/// cut even if it is singular and meets no root: whether det dF is zero cannot be told that far. Entries that differ by
/// more than 1e100 in magnitude may cut it further, because products of theirs underflow.
///
/// # Method
/// 1. F and dF are each divided by a power of two near their largest entry; τ is the step in these units.
///    p(τ) = det F + τ cof F : dF + τ² F : cof dF + τ³ det dF, with a bound E(τ) of its rounding error, a cubic with
///    coefficients of one sign.
/// 2. The stationary points of p − E cut \[0, τ_end\] into at most three pieces on which it is monotone. It is positive on
///    a piece if it is at both ends; an error in a stationary point matters to second order only, far below E.
/// 3. On the first piece where that fails p − E decreases through zero. Regula falsi with bisection brackets
///    the zero; the lower end of the bracket is the answer.
/// 4. This is done in double precision with E = 18ε p̄. Unless p + E < 0 just beyond the answer (a
///    clear root), it is done again in double-double arithmetic with E = 1e-22 p̄.
pub fn first_inversion(f: &Mat3, df: &Mat3) -> f64 {
    let entries = f.iter().chain(df.iter());
    if !entries.fold(true, |finite, entry| finite & entry.is_finite()) {
        return 0.0;
    }
    let (power_f, power_df) = (power_of_two_near(f.amax()), power_of_two_near(df.amax()));
    let scaled_f = scaled_by_power(f, -power_f);
    let scaled_df = scaled_by_power(df, -power_df);
    // t = τ 2^(power_f − power_df). Beyond 2^300 the powers of τ would overflow: there nothing is certain.
    let (end, beyond) = match power_df - power_f {
        power @ ..=300 => (LOOK_AHEAD * 2.0_f64.powi(power), None),
        _ => (2.0_f64.powi(300), Some(2.0_f64.powi(300))),
    };

    let quick = VolumePolynomial::in_double(&scaled_f, &scaled_df);
    let tau = match first_root(&quick, end) {
        Some(tau) if !quick.is_negative_at(tau * (1.0 + 1e-8)) => {
            first_root(&VolumePolynomial::in_double_double(&scaled_f, &scaled_df), end)
        }
        answer => answer,
    };
    match tau.or(beyond) {
        None => f64::INFINITY,
        Some(tau) => unscaled(tau, power_f - power_df),
    }
}

/// τ 2^power, rounded towards zero.
fn unscaled(tau: f64, power: i32) -> f64 {
    let half = power / 2;
    let t = tau * 2.0_f64.powi(half) * 2.0_f64.powi(power - half);
    // In the subnormal range the product is rounded, possibly upwards.
    let t = if t < f64::MIN_POSITIVE { t.next_down().max(0.0) } else { t };
    t.min(f64::MAX)
}

/// The end of the interval from 0 on which p > E is certain, if it ends before `end`.
fn first_root<T: super::volume_polynomial::Arithmetic>(p: &VolumePolynomial<T>, end: f64) -> Option<f64> {
    let mut left = 0.0;
    if p.lower_bound(left) <= 0.0 {
        return Some(0.0);
    }
    for right in p.stationary_points(end).into_iter().chain([end]) {
        if p.lower_bound(right) <= 0.0 {
            return Some(last_positive(|tau| p.lower_bound(tau), left, right));
        }
        left = right;
    }
    None
}

/// Where the decreasing function `margin`, positive at `low` and not at `high`, is still positive, close to its zero.
fn last_positive(margin: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut at_low, mut at_high) = (margin(low), margin(high));
    for iteration in 0..200 {
        if high - low <= WIDTH * high {
            break;
        }
        let falsi = low + (high - low) * (at_low / (at_low - at_high));
        let inside = falsi > low && falsi < high;
        let tau = if iteration % 3 == 2 || !inside { middle(low, high) } else { falsi };
        let at_tau = margin(tau);
        // Illinois: the end that stays loses half of its weight.
        if at_tau > 0.0 {
            (low, at_low) = (tau, at_tau);
            at_high *= 0.5;
        } else {
            (high, at_high) = (tau, at_tau);
            at_low *= 0.5;
        }
    }
    low
}

/// The number halfway between two non-negative ones in the order of all `f64`: 64 bisections separate any two,
/// whatever their magnitudes.
fn middle(low: f64, high: f64) -> f64 {
    f64::from_bits(low.to_bits() + (high.to_bits() - low.to_bits()) / 2)
}
