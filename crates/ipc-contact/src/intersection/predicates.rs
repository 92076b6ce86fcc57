//! Signs of determinants of f64 coordinates, exact for every finite input.
//!
//! Each predicate has three stages. A floating-point filter decides almost always: if the determinant's size exceeds
//! its error bound, its sign is right. Then Shewchuk's adaptive expansions (crate `robust`), which are exact as long as
//! nothing overflows or underflows: every coordinate zero or of magnitude in [2⁻²⁹⁰, 2³³⁰] ([`EXPANSIONS`]). Outside of
//! that, integers of up to 6,400 bits.
//!
//! # Derivation of the filters
//! Let ε = 2⁻⁵³. A product of three differences, each rounded (1 + ε), rounded twice in multiplying and at most three
//! times in adding up, carries at most (1 + ε)⁸; the sum of the sizes of all products (the permanent) bounds the error by
//! 8.01 ε · permanent, and 1e-15 > 9 ε leaves room for the rounding of the permanent itself. Where a product of two
//! differences underflows, its error of at most 2⁻¹⁰⁷⁵ is multiplied by the third difference: [`UNDERFLOW`] added to each
//! product in the permanent is, times 9 ε, more than that. An underflow in the last product is covered by [`TINY`].
//! Overflow makes the permanent infinite or the determinant NaN, and the comparison false.
//!
//! # Why the expansions are exact in their range
//! A coordinate of magnitude ≥ 2⁻²⁹⁰ is a multiple of 2⁻³⁴², as is every sum and difference, rounded or not. Products of
//! three are multiples of 2⁻¹⁰²⁶, so that no part of an expansion falls below 2⁻¹⁰⁷⁴. At the other end, six products of
//! three differences of at most 2³³¹ stay below 2⁹⁹⁷, which Dekker's splitting (factor 2²⁷) still bears.
//!
//! # Reference
//! J. R. Shewchuk, *Adaptive precision floating-point arithmetic and fast robust geometric predicates*, Discrete Comput.
//! Geom. 18, 1997.

use super::wide::Wide;
use mechanics_core::tensor::Vec3;
use robust::{Coord, Coord3D};

/// 9 ε, see the derivation above.
const RELATIVE: f64 = 1e-15;
/// 2⁻¹⁰⁰⁰.
const UNDERFLOW: f64 = f64::from_bits(23 << 52);
/// 2⁻¹⁰²²: more than the sum of a few roundings to subnormal numbers.
const TINY: f64 = f64::MIN_POSITIVE;
/// Magnitudes of coordinates for which expansions are exact: 2⁻²⁹⁰ to 2³³⁰.
const EXPANSIONS: std::ops::RangeInclusive<f64> =
    f64::from_bits((1023 - 290) << 52)..=f64::from_bits((1023 + 330) << 52);

/// The sign of a number, zero for both zeros.
#[inline]
fn sign_of(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}

/// The sign of `value` if it exceeds its error bound.
#[inline(always)]
fn filtered(value: f64, permanent: f64) -> Option<i8> {
    let bound = RELATIVE * permanent + TINY;
    if value > bound {
        Some(1)
    } else if value < -bound {
        Some(-1)
    } else {
        None
    }
}

fn expansions_are_exact(coordinates: impl IntoIterator<Item = f64>) -> bool {
    coordinates.into_iter().all(|c| c == 0.0 || EXPANSIONS.contains(&c.abs()))
}

/// The plane through a triangle, for filtering many points against it.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaneFilter {
    origin: Vec3,
    normal: Vec3,
    /// Sum of the sizes of the products in each entry of the normal.
    sizes: Vec3,
}

impl PlaneFilter {
    #[inline]
    pub(super) fn new([a, b, c]: [&Vec3; 3]) -> Self {
        let (u, v) = (b - a, c - a);
        let minor = |i: usize, j: usize| {
            let (first, second) = (u[i] * v[j], u[j] * v[i]);
            (first - second, first.abs() + second.abs() + UNDERFLOW)
        };
        let (x, y, z) = (minor(1, 2), minor(2, 0), minor(0, 1));
        Self { origin: *a, normal: Vec3::new(x.0, y.0, z.0), sizes: Vec3::new(x.1, y.1, z.1) }
    }

    /// On which side of the plane `p` is: 1 where the normal (b − a) × (c − a) points, −1 on the other side, `None` where
    /// rounding leaves it open.
    #[inline(always)]
    pub(super) fn side(&self, p: &Vec3) -> Option<i8> {
        let w = p - self.origin;
        let value = self.normal.x * w.x + self.normal.y * w.y + self.normal.z * w.z;
        let permanent = self.sizes.x * w.x.abs() + self.sizes.y * w.y.abs() + self.sizes.z * w.z.abs();
        filtered(value, permanent)
    }
}

/// The sign of det\[b − a, c − a, d − a\]: 1 if `d` is on the side of the plane abc where (b − a) × (c − a) points, −1 on
/// the other, 0 if the four points are in one plane. Exact for all finite coordinates.
#[inline]
pub(crate) fn orientation(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> i8 {
    PlaneFilter::new([a, b, c]).side(d).unwrap_or_else(|| exact_orientation(a, b, c, d))
}

#[cold]
pub(super) fn exact_orientation(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> i8 {
    let points = [a, b, c, d];
    if expansions_are_exact(points.iter().flat_map(|p| [p.x, p.y, p.z])) {
        let [a, b, c, d] = points.map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
        return -sign_of(robust::orient3d(a, b, c, d));
    }
    let [u, v, w] = [b, c, d].map(|p| [0, 1, 2].map(|k| Wide::of(p[k]).minus(&Wide::of(a[k]))));
    let minor = |i: usize, j: usize| u[i].times(&v[j]).minus(&u[j].times(&v[i]));
    minor(1, 2).times(&w[0]).plus(&minor(2, 0).times(&w[1])).plus(&minor(0, 1).times(&w[2])).sign()
}

/// A coordinate plane onto which points are projected by leaving out one coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Projection {
    /// y and z.
    AlongX,
    /// z and x.
    AlongY,
    /// x and y.
    AlongZ,
}

impl Projection {
    pub(crate) const ALL: [Self; 3] = [Self::AlongX, Self::AlongY, Self::AlongZ];

    fn apply(self, p: &Vec3) -> [f64; 2] {
        match self {
            Self::AlongX => [p.y, p.z],
            Self::AlongY => [p.z, p.x],
            Self::AlongZ => [p.x, p.y],
        }
    }

    /// The sign of det\[b − a, c − a\] in this projection: 1 if a, b, c turn counter-clockwise, 0 if they are on one line.
    /// It is the sign of that entry of (b − a) × (c − a) which belongs to the axis left out.
    pub(crate) fn turn(self, a: &Vec3, b: &Vec3, c: &Vec3) -> i8 {
        let [a, b, c] = [a, b, c].map(|p| self.apply(p));
        let (left, right) = ((b[0] - a[0]) * (c[1] - a[1]), (b[1] - a[1]) * (c[0] - a[0]));
        filtered(left - right, left.abs() + right.abs()).unwrap_or_else(|| exact_turn(a, b, c))
    }
}

#[cold]
fn exact_turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> i8 {
    if expansions_are_exact([a, b, c].into_iter().flatten()) {
        let [a, b, c] = [a, b, c].map(|p| Coord { x: p[0], y: p[1] });
        return sign_of(robust::orient2d(a, b, c));
    }
    let [u, v] = [b, c].map(|p| [0, 1].map(|k| Wide::of(p[k]).minus(&Wide::of(a[k]))));
    u[0].times(&v[1]).minus(&u[1].times(&v[0])).sign()
}

/// The sign of n·p − o: on which side of the plane {x: n·x = o} a point is. Exact for all finite numbers.
pub(super) fn side_of_plane(normal: &Vec3, offset: f64, p: &Vec3) -> i8 {
    let products = [normal.x * p.x, normal.y * p.y, normal.z * p.z];
    let value = products[0] + products[1] + products[2] - offset;
    let permanent = products[0].abs() + products[1].abs() + products[2].abs() + offset.abs();
    filtered(value, permanent).unwrap_or_else(|| {
        let product = |a: f64, b: f64| Wide::of(a).times(&Wide::of(b));
        (0..3).fold(product(-offset, 1.0), |sum, k| sum.plus(&product(normal[k], p[k]))).sign()
    })
}
