//! Additive conservative advancement with separating planes.
//!
//! # Rounding
//! u = 2⁻⁵³. Corners at the start and at the end are differences of given positions and carry one rounding a component, a dot product
//! of them three more: n · v is off by at most 4 u ‖n‖₁ S to first order, S the largest component of a corner. Corners between, (1 − t) v(0) +
//! t v(1), are off by 4 u (S₀ + S₁) a component in addition. Both together are less than 16 u ‖n‖₁ S with the S of the case, which
//! is taken off every height; what is compared with it, δ |n|, is raised by 32 u. Roots of linear functions have the form
//! a/(a + |b|), in which nothing cancels, and are lowered by 16 u. No error is handed from one advance to the next:
//! every plane is held against the given positions.

use super::direction::{best, closest, support};
use super::sweep::Sweep;
use super::{Detection, Impact, Settings, interval};
use mechanics_core::tensor::dot;

/// Bound on the relative error of a certificate: 16 u, u = 2⁻⁵³.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Added where a product may have been rounded to zero.
const UNDERFLOW: f64 = 64.0 * f64::MIN_POSITIVE;

/// |n|, not less.
#[inline(always)]
fn length(n: &[f64; 3]) -> f64 {
    dot(n, n).sqrt() * (1.0 + ROUNDING) + UNDERFLOW
}

/// |n₁| + |n₂| + |n₃|.
#[inline(always)]
fn sum(n: &[f64; 3]) -> f64 {
    n[0].abs() + n[1].abs() + n[2].abs()
}

/// Lower bounds on n · v for every corner v, of which no component is larger than `size`.
#[inline(always)]
fn project<const K: usize>(n: &[f64; 3], corners: &[[f64; 3]; K], size: f64) -> [f64; K] {
    let error = ROUNDING * (sum(n) * size) + UNDERFLOW;
    corners.map(|v| dot(n, &v) - error)
}

/// The heights of all corners above a plane through the origin, at the start and at the end: lower bounds, times the
/// length of the normal.
struct Heights<const K: usize> {
    first: [f64; K],
    last: [f64; K],
    length: f64,
}

impl<const K: usize> Heights<K> {
    #[inline(always)]
    fn new(sweep: &Sweep<K>, n: &[f64; 3]) -> Self {
        Self {
            first: project(n, &sweep.start, sweep.start_size),
            last: project(n, &sweep.end, sweep.end_size),
            length: length(n),
        }
    }

    /// What is to be subtracted from a height for a distance.
    #[inline(always)]
    fn shift(&self, distance: f64) -> f64 {
        distance * self.length * (1.0 + ROUNDING)
    }

    /// The least height at the start; NaN if any is.
    #[inline(always)]
    fn least(&self) -> f64 {
        let mut least = f64::INFINITY;
        for a in self.first {
            // `min` would lose a NaN.
            least = if a < least || a.is_nan() { a } else { least };
        }
        least
    }

    /// The end of the time over which all corners are certainly higher than `shift`, if `from` lies in it; `from`
    /// otherwise. Infinite if that time does not end.
    #[inline(always)]
    fn until(&self, shift: f64, from: f64) -> f64 {
        let mut until = f64::INFINITY;
        for k in 0..K {
            let (a, b) = (self.first[k] - shift, self.last[k] - shift);
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
    let mut normal = closest(&sweep.start);
    let mut heights = Heights::new(sweep, &normal);
    let mut least = heights.least() - heights.shift(d_min);
    if !(least > 0.0) {
        normal = best(&sweep.start);
        heights = Heights::new(sweep, &normal);
        least = heights.least() - heights.shift(d_min);
        if !(least > 0.0) {
            return refusal(sweep, support(&normal, &sweep.start).max(0.0));
        }
    }
    // What most queries come to: the first plane does for as long as anybody asks.
    let kept_height = (settings.kept_gap * least).min(heights.shift(settings.largest_kept_gap));
    let target = (heights.shift(d_min) + 0.5 * kept_height) * (1.0 + ROUNDING);
    let next = heights.until(target, 0.0);
    if next >= 1.0 {
        return Impact::Free;
    }
    if next > enough {
        return Impact::At(next);
    }
    let gap = least / heights.length * (1.0 - ROUNDING);
    let kept_gap = (settings.kept_gap * gap).min(settings.largest_kept_gap);
    let resolved = (64.0 * f64::EPSILON * sweep.start_size).min(0.5 * gap);
    let advance = Advance { sweep, kept: d_min + kept_gap.max(resolved), target: d_min + 0.5 * kept_gap };
    let plane = Plane { time: 0.0, corners: sweep.start, normal, distance: gap + d_min };
    match settings.detection {
        Detection::Additive => advance.run(plane, next, settings.max_advances, enough),
        Detection::Interval => match advance.run(plane, next, 1, enough) {
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

    /// The end of the time over which a plane does, laid anew if it does not even where it is.
    fn until(&self, plane: &mut Plane<K>) -> f64 {
        let until = self.until_of(plane);
        if until > plane.time || plane.distance <= self.kept {
            return until;
        }
        plane.normal = best(&plane.corners);
        self.until_of(plane)
    }

    fn until_of(&self, plane: &Plane<K>) -> f64 {
        let heights = Heights::new(self.sweep, &plane.normal);
        heights.until(heights.shift(self.target), plane.time)
    }

    /// From a plane that does until `next` to the next one, until the distance is `kept`.
    fn run(&self, mut plane: Plane<K>, mut next: f64, max_advances: usize, enough: f64) -> Impact {
        if !(next > 0.0) {
            return refusal(self.sweep, plane.distance);
        }
        let mut horizon = 1.0;
        for _ in 0..max_advances {
            let Plane { time, distance, .. } = plane;
            let ahead = self.plane((time + horizon).min(1.0));
            let turned =
                if ahead.time > next { turning_plane(self.sweep, &plane, &ahead, self.target) } else { time };
            if turned >= 1.0 {
                return Impact::Free;
            }
            let all_the_way = turned >= ahead.time;
            plane = if all_the_way { ahead } else { self.plane(next.max(turned)) };
            let duration = plane.time - time;
            let trusted = if all_the_way { 4.0 * horizon } else { 4.0 * duration };
            horizon = self.horizon(duration, distance, plane.distance).min(trusted);
            next = self.until(&mut plane);
            if next >= 1.0 {
                return Impact::Free;
            }
            if !(next > plane.time) || next > enough || plane.distance <= self.kept {
                return Impact::At(next);
            }
        }
        Impact::At(next)
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
    let shift = |n: &[f64; 3]| distance * length(n) * (1.0 + ROUNDING);
    let (first, last) = (shift(&n), shift(&m));
    let middle = 0.5 * (first + last) * (1.0 + ROUNDING);
    let mut part: f64 = 1.0;
    let size = sweep.start_size + sweep.end_size;
    let a = project(&n, &from.corners, size);
    let (b, c) = (project(&n, &to.corners, size), project(&m, &from.corners, size));
    let d = project(&m, &to.corners, size);
    for k in 0..K {
        part = part.min(first_root(a[k] - first, 0.5 * (b[k] + c[k]) - middle, d[k] - last));
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
