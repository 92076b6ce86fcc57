//! Continuous collision detection: how far two features may move along straight lines before they meet.
//!
//! Every point of a query moves from `start` to `end` as x(t) = (1 − t) x₀ + t x₁, t ∈ \[0, 1\]. The answer is a
//! fraction of the motion that is *certainly* free: it never exceeds the first time at which the distance of the two
//! features is the minimum separation or less. Rounding is part of the guarantee, not an afterthought: every certificate of
//! freedom carries a bound on its own floating-point error.
//!
//! ```
//! use ipc_contact::ccd::{self, Impact, Settings};
//! use mechanics_core::tensor::Vec3;
//!
//! // A point falls from height 1 to −1 through a triangle at height 0.
//! let start = [Vec3::new(0.2, 0.2, 1.0), Vec3::zeros(), Vec3::x(), Vec3::y()];
//! let end = [Vec3::new(0.2, 0.2, -1.0), Vec3::zeros(), Vec3::x(), Vec3::y()];
//! let impact = ccd::point_triangle(&start, &end, 0.0, &Settings::default());
//! // They meet at 0.5; a gap of 5 % of the first one is left at 0.475.
//! assert!(matches!(impact, Impact::At(t) if (t - 0.475).abs() < 1e-12));
//! ```
//!
//! # Two methods
//! Both features are convex, so that their distance is that of the origin from the convex polygon of all
//! differences b − a: a point, a segment, a triangle or a parallelogram, whose corners move along straight lines.
//!
//! [`Detection::Additive`] walks along the motion from one separating plane to the next. A plane through the origin with any
//! normal n separates for as long as n · v > δ |n| for all corners v, which are linear functions of time; so the walk may go
//! on to where the first of them falls to that. A plane that turns evenly between two normals makes quadratic functions of
//! time and reaches further where features rotate. A badly chosen normal costs steps, never safety.
//!
//! [`Detection::Interval`] bisects time and parameters. Over a box of them the difference stays within the bounds of its
//! values at the eight corners of the box, because it is linear in each; boxes that stay away from the origin are free.
//!
//! # Measured
//! Additive against interval, of the planted degenerate contacts of `tests/ccd`: 0.34–0.44 µs a query (worst 2.6 µs) against 65–1,350 µs
//! (worst 3 ms); with 1e-6 of the gap kept 0.4–1.0 µs (worst 10 µs). Both answer the same 33 of 164 free queries of the public sample with an
//! impact, as does tight inclusion of ipctk 1.6.1 with its tolerance of 1e-6. On 309,338 candidates of two sheets
//! `limit` takes 0.30 of the time of ipctk's additive method, both measured in turn on one busy core.
//!
//! # Reference
//! M. Li, D. M. Kaufman, C. Jiang, *Codimensional incremental potential contact*, ACM Trans. Graph. 40(4), 2021,
//! section 5 (additive advancement). B. Wang, Z. Ferguson, T. Schneider, X. Jiang, M. Attene, D. Panozzo, *A large-scale
//! benchmark and an inclusion-based algorithm for continuous collision detection*, ACM Trans. Graph. 40(5), 2021.

// A comparison with NaN is false: `!(a > 0)` is how a NaN is refused.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use crate::collision_mesh::HalfSpace;
use mechanics_core::tensor::Vec3;

mod additive;
mod direction;
mod interval;
mod limit;
mod sweep;

pub use limit::{Culprit, Pairs, limit};

use sweep::Sweep;

/// What a query answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Impact {
    /// The whole motion is free.
    Free,
    /// The motion is free up to this fraction, which lies in (0, 1).
    At(f64),
    /// At the start the features are closer than the minimum separation, or farther by so little that it cannot be told
    /// in double precision; see [`Settings`] for the bound.
    StartsTooClose {
        /// Their distance at the start, up to rounding \[m\].
        distance: f64,
    },
    /// A coordinate is infinite or NaN, or so large that a product of two is.
    NonFinite,
}

impl Impact {
    /// The fraction that is certainly free: 1 if the whole motion is, 0 if none is.
    pub fn fraction(self) -> f64 {
        match self {
            Self::Free => 1.0,
            Self::At(fraction) => fraction,
            Self::StartsTooClose { .. } | Self::NonFinite => 0.0,
        }
    }
}

/// How a query is answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Detection {
    /// From one separating plane to the next: the faster one by far.
    #[default]
    Additive,
    /// Bisection of time and parameters: independent of closest features, slower.
    Interval,
}

/// How close to the first contact an answer comes.
///
/// # Guarantee
/// Whatever the settings, an answer is never too large. A pair that starts farther apart than d_min + 256 ε R (ε = 2⁻⁵²,
/// R the largest distance of a point of the one feature from a point of the other at the start) is never
/// [`Impact::StartsTooClose`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The method.
    pub detection: Detection,
    /// The part of the gap at the start (distance minus minimum separation) that counts as contact: up to the answer
    /// the gap is more than half of that, and a gap that is never as small as that, or as 64 ε R where that is more and the
    /// start is farther, does not end the motion. In (0, 1).
    pub kept_gap: f64,
    /// The same as a length, where that is less \[m\]: a pair that is far apart may come this close in one step. A pair whose
    /// gap stays larger is free, whatever `kept_gap`.
    pub largest_kept_gap: f64,
    /// Advances after which the answer is what has been found free so far; of the additive method.
    pub max_advances: usize,
    /// Boxes after which the answer is what has been found free so far; of the interval method.
    pub max_boxes: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            detection: Detection::Additive,
            kept_gap: 0.1,
            largest_kept_gap: f64::INFINITY,
            max_advances: 200,
            max_boxes: 20_000,
        }
    }
}

impl Settings {
    fn check(&self, d_min: f64) {
        let Self { kept_gap, .. } = self;
        assert!(
            *kept_gap > 0.0 && *kept_gap < 1.0,
            "the part of a gap to be kept lies in (0, 1), it is {kept_gap}"
        );
        assert!(d_min >= 0.0 && d_min.is_finite(), "a minimum separation is zero or more, it is {d_min}");
    }
}

/// Two moving points.
///
/// In this query and the next three `start` and `end` are the positions of the points at t = 0 and t = 1 \[m\], and `d_min` is the
/// minimum separation \[m\].
///
/// # Panics
/// If `d_min` is negative or not finite, or the part of the gap to be kept is not in (0, 1).
pub fn point_point(start: &[Vec3; 2], end: &[Vec3; 2], d_min: f64, settings: &Settings) -> Impact {
    additive::advance(&Sweep::point_point(start, end), d_min, settings, 1.0)
}

/// A moving point and a moving edge: the point, then both ends of the edge. An edge of no length is a point.
///
/// # Panics
/// As [`point_point`].
pub fn point_edge(start: &[Vec3; 3], end: &[Vec3; 3], d_min: f64, settings: &Settings) -> Impact {
    additive::advance(&Sweep::point_edge(start, end), d_min, settings, 1.0)
}

/// A moving point and a moving triangle: the point, then the three corners. A triangle of no area is its longest edge.
///
/// # Panics
/// As [`point_point`].
pub fn point_triangle(start: &[Vec3; 4], end: &[Vec3; 4], d_min: f64, settings: &Settings) -> Impact {
    additive::advance(&Sweep::point_triangle(start, end), d_min, settings, 1.0)
}

/// Two moving edges: both ends of the one, then both of the other. An edge of no length is a point.
///
/// # Panics
/// As [`point_point`].
pub fn edge_edge(start: &[Vec3; 4], end: &[Vec3; 4], d_min: f64, settings: &Settings) -> Impact {
    additive::advance(&Sweep::edge_edge(start, end), d_min, settings, 1.0)
}

/// A moving point and a half-space, which stands still. The distance n · x − offset, with the normal taken as given, is linear in
/// time: the answer is the time at which three quarters of the gap to be kept are left, whatever the method.
///
/// # Panics
/// As [`point_point`].
pub fn half_space(start: &Vec3, end: &Vec3, obstacle: &HalfSpace, d_min: f64, settings: &Settings) -> Impact {
    settings.check(d_min);
    let HalfSpace { normal, offset } = obstacle;
    // Lower bounds: five roundings, none of which is larger than ε times the sum of magnitudes.
    let gap = |x: &Vec3| {
        let size = normal.abs().dot(&x.abs()) + offset.abs() + d_min;
        normal.dot(x) - offset - d_min - (4.0 * f64::EPSILON * size + f64::MIN_POSITIVE)
    };
    let (first, last) = (gap(start), gap(end));
    if !first.is_finite() || !last.is_finite() {
        return Impact::NonFinite;
    }
    if first <= 0.0 {
        return Impact::StartsTooClose { distance: normal.dot(start) - offset };
    }
    let kept = 0.75 * (settings.kept_gap * first).min(settings.largest_kept_gap);
    if last >= kept {
        Impact::Free
    } else {
        Impact::At((first - kept) / (first - last) * (1.0 - 4.0 * f64::EPSILON))
    }
}
