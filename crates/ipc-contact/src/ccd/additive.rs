//! Additive conservative advancement with separating planes.

use super::direction::{best, closest, support};
use super::sweep::Sweep;
use super::{Detection, Impact, Settings, interval};
use mechanics_core::tensor::dot;

/// Bound on the relative error of a certificate: 16 u, u = 2⁻⁵³.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Added where a product may have been rounded to zero.
const UNDERFLOW: f64 = 64.0 * f64::MIN_POSITIVE;

/// Lower bound on n · v − δ |n| for every corner v with |v| given or rounded from it, and n as it is.
#[inline(always)]
fn above(n: &[f64; 3], v: &[f64; 3], magnitude: &[f64; 3], shift: f64) -> f64 {
    let size = n[0].abs() * magnitude[0] + n[1].abs() * magnitude[1] + n[2].abs() * magnitude[2];
    dot(n, v) - shift - (ROUNDING * (size + shift) + UNDERFLOW)
}

#[inline(always)]
fn absolute(v: &[f64; 3]) -> [f64; 3] {
    v.map(f64::abs)
}

/// |n|, not less.
#[inline(always)]
fn length(n: &[f64; 3]) -> f64 {
    dot(n, n).sqrt() * (1.0 + ROUNDING) + UNDERFLOW
}

/// The end of the time over which the plane with normal `n` certainly keeps all corners farther than `distance` from
/// the origin, if `from` lies in it; `from` otherwise. Infinite if that time does not end.
#[inline]
fn constant_plane<const K: usize>(sweep: &Sweep<K>, n: &[f64; 3], distance: f64, from: f64) -> f64 {
    let shift = distance * length(n);
    let mut until = f64::INFINITY;
    for k in 0..K {
        let (v, w) = (&sweep.start[k], &sweep.end[k]);
        let a = above(n, v, &absolute(v), shift);
        let b = above(n, w, &absolute(w), shift);
        if a > 0.0 {
            if b > 0.0 {
                continue;
            }
            if b <= 0.0 {
                until = until.min(a / (a - b) * (1.0 - ROUNDING));
                continue;
            }
        } else if b > 0.0 && from > a / (a - b) * (1.0 + ROUNDING) {
            continue;
        }
        return from;
    }
    until.max(from)
}

/// Lower bound on the distance at the start minus `d_min`.
fn starting_gap<const K: usize>(sweep: &Sweep<K>, n: &[f64; 3], d_min: f64) -> f64 {
    let length = length(n);
    let mut least = f64::INFINITY;
    for v in &sweep.start {
        let a = above(n, v, &absolute(v), d_min * length);
        if !(a > 0.0) {
            return 0.0;
        }
        least = least.min(a);
    }
    least / length * (1.0 - ROUNDING)
}

/// Why not even the start is certainly free.
#[cold]
fn refusal<const K: usize>(sweep: &Sweep<K>, distance: f64) -> Impact {
    if sweep.is_finite() { Impact::StartsTooClose { distance } } else { Impact::NonFinite }
}

/// The largest free fraction found; no further than `enough`, beyond which nobody asks.
pub(super) fn advance<const K: usize>(
    sweep: &Sweep<K>,
    d_min: f64,
    settings: &Settings,
    enough: f64,
) -> Impact {
    settings.check(d_min);
    let mut n = closest(&sweep.start);
    let mut gap = starting_gap(sweep, &n, d_min);
    if !(gap > 0.0) {
        n = best(&sweep.start);
        gap = starting_gap(sweep, &n, d_min);
        if !(gap > 0.0) {
            return refusal(sweep, support(&n, &sweep.start).max(0.0));
        }
    }
    let kept_gap = (settings.kept_gap * gap).min(settings.largest_kept_gap);
    let advance = Advance { sweep, kept: d_min + kept_gap, target: d_min + 0.5 * kept_gap };
    match settings.detection {
        Detection::Additive => advance.run(n, gap + d_min, settings.max_advances, enough),
        Detection::Interval => match advance.run(n, gap + d_min, 1, enough) {
            Impact::At(after) if after <= enough => {
                interval::bisect(sweep, advance.target, 0.25 * kept_gap, after, settings)
            }
            answer => answer,
        },
    }
}

/// One query on its way.
struct Advance<'a, const K: usize> {
    sweep: &'a Sweep<K>,
    /// Distance that counts as contact \[m\].
    kept: f64,
    /// Distance that certificates ask for, less than `kept`, so that a plane always reaches further than where it was
    /// laid \[m\].
    target: f64,
}

/// A time, the corners then, and the plane that separates them from the origin then.
struct Plane<const K: usize> {
    time: f64,
    corners: [[f64; 3]; K],
    normal: [f64; 3],
    distance: f64,
}

impl<const K: usize> Advance<'_, K> {
    fn plane(&self, time: f64) -> Plane<K> {
        let corners = self.sweep.at(time);
        let normal = closest(&corners);
        Plane { time, normal, distance: support(&normal, &corners), corners }
    }

    fn run(&self, normal: [f64; 3], distance: f64, max_advances: usize, enough: f64) -> Impact {
        let mut plane = Plane { time: 0.0, corners: self.sweep.start, normal, distance };
        let mut horizon = 1.0;
        for _ in 0..max_advances {
            let Plane { time, distance, .. } = plane;
            let mut next = constant_plane(self.sweep, &plane.normal, self.target, time);
            if next >= 1.0 {
                return Impact::Free;
            }
            if next > enough || distance <= self.kept && time > 0.0 {
                return Impact::At(next);
            }
            if !(next > time) {
                plane.normal = best(&plane.corners);
                next = constant_plane(self.sweep, &plane.normal, self.target, time);
                if !(next > time) {
                    return if time > 0.0 { Impact::At(time) } else { refusal(self.sweep, distance) };
                }
            }
            let ahead = self.plane((time + horizon).min(1.0));
            let turned =
                if ahead.time > next { turning_plane(self.sweep, &plane, &ahead, self.target) } else { time };
            if turned >= 1.0 {
                return Impact::Free;
            }
            plane = if turned >= ahead.time { ahead } else { self.plane(next.max(turned)) };
            horizon = self.horizon(plane.time - time, distance, plane.distance);
        }
        Impact::At(plane.time)
    }

    /// How long until the distance lies between `target` and `kept`, if it goes on falling as it fell.
    fn horizon(&self, duration: f64, before: f64, now: f64) -> f64 {
        let left = (now - 0.5 * (self.target + self.kept)) * duration;
        if before > now { left / (before - now) } else { 1.0 }
    }
}

/// The end of the time from `from.time` over which the plane that turns evenly from the one to the other keeps all
/// corners farther than `distance` from the origin; `to.time` if it does to the end.
fn turning_plane<const K: usize>(sweep: &Sweep<K>, from: &Plane<K>, to: &Plane<K>, distance: f64) -> f64 {
    let scale = |n: &[f64; 3]| {
        let factor = 1.0 / length(n);
        n.map(|c| factor * c)
    };
    let (n, m) = (scale(&from.normal), scale(&to.normal));
    let (first, last) = (distance * length(&n), distance * length(&m));
    let middle = 0.5 * (first + last);
    let mut part: f64 = 1.0;
    for k in 0..K {
        let (v, w) = (&from.corners[k], &to.corners[k]);
        let size: [f64; 3] = std::array::from_fn(|c| sweep.start[k][c].abs() + sweep.end[k][c].abs());
        let a = above(&n, v, &size, first);
        let b = 0.5 * (above(&n, w, &size, middle) + above(&m, v, &size, middle));
        let c = above(&m, w, &size, last);
        part = part.min(first_root(a, b, c));
    }
    if part >= 1.0 {
        return to.time;
    }
    let reached = from.time + part * (to.time - from.time) * (1.0 - ROUNDING);
    (reached * (1.0 - f64::EPSILON)).max(from.time)
}

/// A number in \[0, 1\] up to which a (1 − s)² + 2 b s (1 − s) + c s² is positive: its first root, rounded down, or 1; 0
/// if it is not positive at 0.
///
/// With w = s/(1 − s) the roots are those of a + 2 b w + c w², and the first positive one, where there is one, is
/// a/(−b + √(b² − a c)), in which nothing cancels that matters.
#[inline]
fn first_root(a: f64, b: f64, c: f64) -> f64 {
    if !(a > 0.0) {
        return 0.0;
    }
    if b >= 0.0 && c >= 0.0 {
        return 1.0;
    }
    let (square, product) = (b * b, a * c);
    let discriminant = square - product + ROUNDING * (square + product.abs()) + UNDERFLOW;
    if discriminant < 0.0 {
        return 1.0;
    }
    let w = a / (discriminant.sqrt() - b) * (1.0 - ROUNDING);
    let s = w / (1.0 + w) * (1.0 - ROUNDING);
    if s > 0.0 { s } else { 0.0 }
}
