//! Which primitive realises the distance of two bounded features.

use super::{LineLine, PointLine, PointPlane, PointPoint, Separation, SquaredDistance, difference};
use mechanics_core::stencil::LocalHessian;
use mechanics_core::tensor::{Mat3, Vec3, cross, dot};

/// Relative size below which a triangle (height over longest edge) counts as its edges, and two edges (sine of their
/// angle) as parallel.
///
/// The distance is wrong by less than this times the longest edge there, always too large. A much smaller value would
/// trust normals that are mostly rounding.
pub const FLATNESS: f64 = 1e-8;

/// The closest features of a pair: a primitive and, by their places in the pair, its points.
///
/// Two points ascend; else a single point comes first, and edges and triangles are in the order of the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Region {
    /// Two points.
    PointPoint([u8; 2]),
    /// A point and the interior of the edge between the other two.
    PointEdge([u8; 3]),
    /// A point and the interior of a triangle.
    PointTriangle([u8; 4]),
    /// The interiors of two edges.
    EdgeEdge([u8; 4]),
}

impl Region {
    /// s of this region's primitive \[m²\].
    pub fn value<const N: usize>(&self, x: &[Vec3; N]) -> f64 {
        match self {
            Self::PointPoint(places) => PointPoint::value(&pick(x, places)),
            Self::PointEdge(places) => PointLine::value(&pick(x, places)),
            Self::PointTriangle(places) => PointPlane::value(&pick(x, places)),
            Self::EdgeEdge(places) => LineLine::value(&pick(x, places)),
        }
    }

    /// ∇s \[m\] with respect to all points of the pair; zero for those that this region leaves out.
    pub fn gradient<const N: usize>(&self, x: &[Vec3; N]) -> [Vec3; N] {
        match self {
            Self::PointPoint(places) => spread_gradient(places, &PointPoint::gradient(&pick(x, places))),
            Self::PointEdge(places) => spread_gradient(places, &PointLine::gradient(&pick(x, places))),
            Self::PointTriangle(places) => spread_gradient(places, &PointPlane::gradient(&pick(x, places))),
            Self::EdgeEdge(places) => spread_gradient(places, &LineLine::gradient(&pick(x, places))),
        }
    }

    /// ∇∇s with respect to all points of the pair; zero for those that this region leaves out.
    pub fn hessian<const N: usize>(&self, x: &[Vec3; N]) -> LocalHessian<N> {
        match self {
            Self::PointPoint(places) => spread_hessian(places, &PointPoint::hessian(&pick(x, places))),
            Self::PointEdge(places) => spread_hessian(places, &PointLine::hessian(&pick(x, places))),
            Self::PointTriangle(places) => spread_hessian(places, &PointPlane::hessian(&pick(x, places))),
            Self::EdgeEdge(places) => spread_hessian(places, &LineLine::hessian(&pick(x, places))),
        }
    }

    /// The closest points: r = Σ wᵢxᵢ \[m\] and wᵢ, barycentric weights of the points of one feature, and minus those of the
    /// other's.
    pub fn weights<const N: usize>(&self, x: &[Vec3; N]) -> (Vec3, [f64; N]) {
        match self {
            Self::PointPoint(places) => spread_weights(places, &PointPoint::separation(&pick(x, places))),
            Self::PointEdge(places) => spread_weights(places, &PointLine::separation(&pick(x, places))),
            Self::PointTriangle(places) => spread_weights(places, &PointPlane::separation(&pick(x, places))),
            Self::EdgeEdge(places) => spread_weights(places, &LineLine::separation(&pick(x, places))),
        }
    }
}

fn pick<const N: usize, const M: usize>(x: &[Vec3; N], places: &[u8; M]) -> [Vec3; M] {
    places.map(|place| x[usize::from(place)])
}

fn spread_gradient<const N: usize, const M: usize>(places: &[u8; M], gradient: &[Vec3; M]) -> [Vec3; N] {
    let mut spread = [Vec3::zeros(); N];
    for (place, part) in places.iter().zip(gradient) {
        spread[usize::from(*place)] = *part;
    }
    spread
}

fn spread_hessian<const N: usize, const M: usize>(
    places: &[u8; M],
    hessian: &LocalHessian<M>,
) -> LocalHessian<N> {
    let mut spread = [[Mat3::zeros(); N]; N];
    for (i, row) in places.iter().zip(hessian) {
        for (j, block) in places.iter().zip(row) {
            spread[usize::from(*i)][usize::from(*j)] = *block;
        }
    }
    spread
}

fn spread_weights<const N: usize, const M: usize>(
    places: &[u8; M],
    separation: &Separation<f64, M>,
) -> (Vec3, [f64; N]) {
    let mut spread = [0.0; N];
    for (place, weight) in places.iter().zip(separation.weights) {
        spread[usize::from(*place)] = weight;
    }
    (separation.difference.into(), spread)
}

#[inline(always)]
fn ascending(a: u8, b: u8) -> [u8; 2] {
    [a.min(b), a.max(b)]
}

/// The smaller of two, the first of equals, NaN if one is.
#[inline(always)]
fn nearer(a: (Region, f64), b: (Region, f64)) -> (Region, f64) {
    if b.1 < a.1 || b.1.is_nan() { b } else { a }
}

/// The nearer of `nearest` and the point and edge at `side`, if that side's constraint is violated: its `slack` is not
/// positive.
///
/// The minimum of a convex function over a convex set lies on a side whose constraint the unconstrained minimum violates:
/// along the segment from the one to the other the function falls, so that the segment leaves the set at once.
#[inline(always)]
fn nearer_side(nearest: (Region, f64), x: &[Vec3; 4], slack: f64, side: [u8; 3]) -> (Region, f64) {
    if slack > 0.0 { nearest } else { nearer(nearest, point_edge_at(x, side)) }
}

/// Are all constraints satisfied?
#[inline(always)]
fn are_positive<const SIDES: usize>(slacks: &[f64; SIDES]) -> bool {
    slacks.iter().all(|slack| *slack > 0.0)
}

/// s of two points \[m²\].
#[inline]
pub fn point_point(x: &[Vec3; 2]) -> f64 {
    PointPoint::value(x)
}

/// Region and s \[m²\] of the point `x[0]` and the edge from `x[1]` to `x[2]`.
///
/// With t = x₂ − x₁ and e = x₀ − x₁: the start for e·t ≤ 0 (an edge of zero length among them), the end for
/// e·t ≥ t·t, the line between.
#[inline]
pub fn point_edge_closest(x: &[Vec3; 3]) -> (Region, f64) {
    point_edge_at(x, [0, 1, 2])
}

/// The same for three of the points of a pair.
#[inline(always)]
fn point_edge_at<const N: usize>(x: &[Vec3; N], places: [u8; 3]) -> (Region, f64) {
    let points = pick(x, &places);
    let [point, start, end] = places;
    let (t, e) = (difference(&points[2], &points[1]), difference(&points[0], &points[1]));
    let (along, length) = (dot(&e, &t), dot(&t, &t));
    if along <= 0.0 {
        (Region::PointPoint(ascending(point, start)), dot(&e, &e))
    } else if along >= length {
        (Region::PointPoint(ascending(point, end)), PointPoint::value(&[points[0], points[2]]))
    } else {
        (Region::PointEdge(places), PointLine::value(&points))
    }
}

/// Region and s \[m²\] of the point `x[0]` and the triangle `x[1..4]`.
///
/// The face if the foot on its plane has positive barycentric coordinates, else the nearest of the three edges. A
/// triangle that is flatter than [`FLATNESS`] is its edges.
#[inline]
pub fn point_triangle_closest(x: &[Vec3; 4]) -> (Region, f64) {
    let (u, v, w) = (difference(&x[2], &x[1]), difference(&x[3], &x[1]), difference(&x[3], &x[2]));
    let n = cross(&u, &v);
    let area = dot(&n, &n);
    let longest = dot(&u, &u).max(dot(&v, &v)).max(dot(&w, &w));
    let whole = Region::PointTriangle([0, 1, 2, 3]);
    if area.is_nan() {
        return (whole, f64::NAN);
    }
    let mut slacks = [0.0; 3];
    if area > FLATNESS * FLATNESS * longest * longest {
        let separation = PointPlane::separation(x);
        let [_, a, b, c] = separation.weights;
        slacks = [-c, -a, -b];
        if are_positive(&slacks) {
            return (whole, separation.value());
        }
    }
    // Each side opposite the corner whose weight is looked at; places ascend.
    let nearest = nearer_side((whole, f64::INFINITY), x, slacks[0], [0, 1, 2]);
    let nearest = nearer_side(nearest, x, slacks[1], [0, 2, 3]);
    nearer_side(nearest, x, slacks[2], [0, 1, 3])
}

/// Region and s \[m²\] of the edge from `x[0]` to `x[1]` and the edge from `x[2]` to `x[3]`.
///
/// Both interiors if the closest points of the two lines lie in them, else the nearest pair of an end and an edge: a
/// convex quadratic over the unit square has its minimum inside or on the boundary. Edges whose angle has a sine below
/// [`FLATNESS`] have their smallest distance at an end, to within rounding; among equals the first in the order ends
/// of the first edge, ends of the second.
#[inline]
pub fn edge_edge_closest(x: &[Vec3; 4]) -> (Region, f64) {
    let (u, v) = (difference(&x[1], &x[0]), difference(&x[3], &x[2]));
    let n = cross(&u, &v);
    let area = dot(&n, &n);
    let whole = Region::EdgeEdge([0, 1, 2, 3]);
    if area.is_nan() {
        return (whole, f64::NAN);
    }
    let mut slacks = [0.0; 4];
    if area > FLATNESS * FLATNESS * dot(&u, &u) * dot(&v, &v) {
        let separation = LineLine::separation(x);
        let [a, b, c, d] = separation.weights;
        slacks = [b, a, -d, -c];
        if are_positive(&slacks) {
            return (whole, separation.value());
        }
    }
    let nearest = nearer_side((whole, f64::INFINITY), x, slacks[0], [0, 2, 3]);
    let nearest = nearer_side(nearest, x, slacks[1], [1, 2, 3]);
    let nearest = nearer_side(nearest, x, slacks[2], [2, 0, 1]);
    nearer_side(nearest, x, slacks[3], [3, 0, 1])
}

/// The region of [`point_edge_closest`].
pub fn point_edge_region(x: &[Vec3; 3]) -> Region {
    point_edge_closest(x).0
}

/// The region of [`point_triangle_closest`].
pub fn point_triangle_region(x: &[Vec3; 4]) -> Region {
    point_triangle_closest(x).0
}

/// The region of [`edge_edge_closest`].
pub fn edge_edge_region(x: &[Vec3; 4]) -> Region {
    edge_edge_closest(x).0
}

/// Squared distance of the point `x[0]` and the edge `x[1..3]` \[m²\].
pub fn point_edge(x: &[Vec3; 3]) -> f64 {
    point_edge_closest(x).1
}

/// Squared distance of the point `x[0]` and the triangle `x[1..4]` \[m²\].
pub fn point_triangle(x: &[Vec3; 4]) -> f64 {
    point_triangle_closest(x).1
}

/// Squared distance of the edges `x[0..2]` and `x[2..4]` \[m²\].
pub fn edge_edge(x: &[Vec3; 4]) -> f64 {
    edge_edge_closest(x).1
}
