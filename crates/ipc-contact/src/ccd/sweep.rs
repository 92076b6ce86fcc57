//! The moving polygon of differences of two features.

use mechanics_core::tensor::{self, Vec3};

/// The convex polygon of all differences b − a of two features, at the start and at the end of a straight motion.
///
/// The features are closer than d exactly when the polygon is closer than d to the origin. Its corners move along
/// straight lines: a point (K = 1), a segment (2), a triangle (3) or a parallelogram (4), corners in cyclic order. What
/// both features share of their motion and of their place drops out, with the rounding that goes with it: a corner is the
/// correctly rounded difference of two given positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sweep<const K: usize> {
    /// Corners at t = 0 \[m\].
    pub(super) start: [[f64; 3]; K],
    /// Corners at t = 1 \[m\].
    pub(super) end: [[f64; 3]; K],
    /// The largest component of a corner at t = 0 and at t = 1 \[m\].
    pub(super) start_size: f64,
    pub(super) end_size: f64,
}

/// The largest component of a corner.
#[inline(always)]
fn size<const K: usize>(corners: &[[f64; 3]; K]) -> f64 {
    let mut largest = 0.0;
    for c in corners.as_flattened() {
        largest = if c.abs() > largest { c.abs() } else { largest };
    }
    largest
}

/// b − a.
#[inline(always)]
fn difference(b: &Vec3, a: &Vec3) -> [f64; 3] {
    [b.x - a.x, b.y - a.y, b.z - a.z]
}

impl Sweep<1> {
    #[inline(always)]
    pub(super) fn point_point(start: &[Vec3; 2], end: &[Vec3; 2]) -> Self {
        let corners = |x: &[Vec3; 2]| [difference(&x[1], &x[0])];
        Self::new(corners(start), corners(end))
    }
}

impl Sweep<2> {
    #[inline(always)]
    pub(super) fn point_edge(start: &[Vec3; 3], end: &[Vec3; 3]) -> Self {
        let corners = |x: &[Vec3; 3]| [difference(&x[1], &x[0]), difference(&x[2], &x[0])];
        Self::new(corners(start), corners(end))
    }
}

impl Sweep<3> {
    #[inline(always)]
    pub(super) fn point_triangle(start: &[Vec3; 4], end: &[Vec3; 4]) -> Self {
        let corners =
            |x: &[Vec3; 4]| [difference(&x[1], &x[0]), difference(&x[2], &x[0]), difference(&x[3], &x[0])];
        Self::new(corners(start), corners(end))
    }
}

impl Sweep<4> {
    #[inline(always)]
    pub(super) fn edge_edge(start: &[Vec3; 4], end: &[Vec3; 4]) -> Self {
        let corners = |x: &[Vec3; 4]| {
            [
                difference(&x[2], &x[0]),
                difference(&x[2], &x[1]),
                difference(&x[3], &x[1]),
                difference(&x[3], &x[0]),
            ]
        };
        Self::new(corners(start), corners(end))
    }
}

impl<const K: usize> Sweep<K> {
    #[inline(always)]
    fn new(start: [[f64; 3]; K], end: [[f64; 3]; K]) -> Self {
        Self { start, end, start_size: size(&start), end_size: size(&end) }
    }

    /// The corners at time t, each component within 4 u of ((1 − t)|start| + t|end|), u = 2⁻⁵³.
    #[inline(always)]
    pub(super) fn at(&self, t: f64) -> [[f64; 3]; K] {
        let s = 1.0 - t;
        std::array::from_fn(|k| std::array::from_fn(|c| s * self.start[k][c] + t * self.end[k][c]))
    }

    /// Whether every corner is finite, and its square too.
    pub(super) fn is_finite(&self) -> bool {
        self.start.iter().chain(&self.end).all(|corner| tensor::dot(corner, corner).is_finite())
    }
}
