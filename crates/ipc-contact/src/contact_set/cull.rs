//! Pairs that are certainly apart, told four at a time: most candidates, whose closest features nobody needs to know.
//!
//! A direction n separates two convex sets A and B by (min over A of n·a − max over B of n·b)/|n|, and that is at most their
//! distance, *whatever n is*. So an n that was found carelessly culls less, but never a pair that is near.
//!
//! - **Two edges**: n is the difference of the closest points, found without cases (the closest point of the first line, both
//!   parameters clamped in turn): the bound is their distance then, but for edges that are almost parallel.
//! - **A point and a triangle**: the distance from the plane, and for each side the distance in the plane from the line through it,
//!   outwards; their squares add. Beyond a corner the bound is less than the distance.
//!
//! # Rounding
//! With L² the sum of the squared lengths that take part, the bound g on the distance is wrong by less than 10⁻¹² L (triangles with an
//! angle whose sine is below 10⁻³ are kept unseen). Because (a + b)² ≤ (1 + δ)a² + (1 + 1/δ)b², a pair with
//! g² > (1 + 2·10⁻⁶) ŝ + 10⁻¹⁸ L² is farther apart than √ŝ. NaN is never apart.
//!
//! # Reference
//! The clamping is that of C. Ericson, *Real-Time Collision Detection*, 2005, section 5.1.9.

use mechanics_core::lanes::{self, LaneKernel, Packet};
use mechanics_core::scalar::{Mask, Scalar};
use mechanics_core::tensor::{Vec3, cross, dot};

/// Pairs looked at by one call.
pub(super) const RUN: usize = 64;

/// Lanes of a packet of `f64`.
const LANES: usize = 4;
/// ŝ is enlarged by this part …
const RELATIVE: f64 = 2e-6;
/// … and by this part of the squared lengths.
const ROUNDING: f64 = 1e-18;
/// Triangles whose squared sine at the first corner is less are not looked at.
const FLAT: f64 = 1e-6;

/// Which pairs of edges x₀x₁ and x₂x₃ are certainly at least as far apart as the root of `squared`.
pub(super) fn apart_edges(x: &[[Vec3; 4]], squared: f64) -> [bool; RUN] {
    lanes::dispatch(Cull { x, squared, bound: Kind::Edges })
}

/// Which points x₀ are certainly at least as far from their triangles x₁x₂x₃.
pub(super) fn apart_point_triangles(x: &[[Vec3; 4]], squared: f64) -> [bool; RUN] {
    lanes::dispatch(Cull { x, squared, bound: Kind::PointTriangle })
}

#[derive(Clone, Copy)]
enum Kind {
    Edges,
    PointTriangle,
}

struct Cull<'a> {
    x: &'a [[Vec3; 4]],
    squared: f64,
    bound: Kind,
}

impl LaneKernel<f64> for Cull<'_> {
    type Output = [bool; RUN];
    #[inline(always)]
    fn run<P: Packet<Element = f64>>(self) -> [bool; RUN] {
        let mut apart = [false; RUN];
        let (one, zero) = (P::constant(1.0), P::constant(0.0));
        let squared = P::constant(self.squared);
        for (apart, x) in apart.chunks_mut(LANES).zip(self.x.chunks(LANES)) {
            let x = load::<P>(x);
            let mask = match self.bound {
                Kind::Edges => edges_are_apart(&x, squared),
                Kind::PointTriangle => point_and_triangle_are_apart(&x, squared),
            };
            let lanes = P::select(mask, one, zero).to_lanes();
            for (apart, lane) in apart.iter_mut().zip(lanes.as_ref()) {
                *apart = *lane != 0.0;
            }
        }
        apart
    }
}

/// Component k of point a of pair i on lane i of `[a][k]`; lanes beyond the last pair repeat it.
#[inline(always)]
fn load<P: Packet<Element = f64>>(x: &[[Vec3; 4]]) -> [[P; 3]; 4] {
    let last = x.len() - 1;
    let pairs = [&x[0], &x[last.min(1)], &x[last.min(2)], &x[last.min(3)]];
    let mut points = [[P::constant(0.0); 3]; 4];
    for a in 0..4 {
        for k in 0..3 {
            points[a][k] = P::from_lanes([pairs[0][a][k], pairs[1][a][k], pairs[2][a][k], pairs[3][a][k]]);
        }
    }
    points
}

#[inline(always)]
fn minus<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> [S; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + factor · b.
#[inline(always)]
fn plus_times<S: Scalar>(a: &[S; 3], factor: S, b: &[S; 3]) -> [S; 3] {
    [b[0].mul_add(factor, a[0]), b[1].mul_add(factor, a[1]), b[2].mul_add(factor, a[2])]
}

#[inline(always)]
fn clamped<S: Scalar>(a: S) -> S {
    a.max(S::constant(0.0)).min(S::constant(1.0))
}

/// ŝ with what rounding may add.
#[inline(always)]
fn enlarged<S: Scalar>(squared: S, lengths: S) -> S {
    squared.scale(1.0 + RELATIVE) + lengths.scale(ROUNDING)
}

#[inline(always)]
fn edges_are_apart<S: Scalar>(x: &[[S; 3]; 4], squared: S) -> S::Mask {
    let (u, v, e) = (minus(&x[1], &x[0]), minus(&x[3], &x[2]), minus(&x[0], &x[2]));
    let (uu, vv, uv) = (dot(&u, &u), dot(&v, &v), dot(&u, &v));
    let (ue, ve) = (dot(&u, &e), dot(&v, &e));
    // Where the lines are parallel s is anything; a NaN becomes zero or one, and where it does not, nothing is apart.
    let s = clamped((uv * ve - ue * vv) / (uu * vv - uv * uv));
    let t = clamped((uv * s + ve) / vv);
    let s = clamped((uv * t - ue) / uu);
    let n = plus_times(&plus_times(&e, s, &u), -t, &v);
    let (along_first, along_second, start) = (dot(&n, &u), dot(&n, &v), dot(&n, &e));
    let zero = S::constant(0.0);
    let gap = start + along_first.min(zero) - along_second.max(zero);
    let least = enlarged(squared, uu + vv + dot(&e, &e)) * dot(&n, &n);
    zero.less(gap).and(least.less(gap * gap))
}

#[inline(always)]
fn point_and_triangle_are_apart<S: Scalar>(x: &[[S; 3]; 4], squared: S) -> S::Mask {
    let (u, v, e) = (minus(&x[2], &x[1]), minus(&x[3], &x[1]), minus(&x[0], &x[1]));
    let w = minus(&v, &u);
    let n = cross(&u, &v);
    let (uu, vv, ee) = (dot(&u, &u), dot(&v, &v), dot(&e, &e));
    let (area, height) = (dot(&n, &n), dot(&n, &e));
    // All times |n|²: the squared distance from the plane, and what is to be exceeded.
    let (normal, least) = (height * height, enlarged(squared, uu + vv + ee) * area);
    let zero = S::constant(0.0);
    let mut apart = least.less(normal);
    for (side, from) in [(&u, &e), (&w, &minus(&e, &u)), (&minus(&zero_vector(), &v), &e)] {
        // |side × n|² = |side|² |n|², so that |n|² times the squared distance from the side's line is (…)²/|side|².
        let (outwards, length) = (dot(&cross(side, &n), from), dot(side, side));
        let beyond = zero.less(outwards).and((least * length).less(normal * length + outwards * outwards));
        apart = apart.or(beyond);
    }
    apart.and((uu * vv).scale(FLAT).less(area))
}

#[inline(always)]
fn zero_vector<S: Scalar>() -> [S; 3] {
    [S::constant(0.0); 3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distance;

    /// Numbers in [−1, 1).
    struct Random(u64);

    impl Random {
        fn number(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn vector(&mut self) -> Vec3 {
            Vec3::new(self.number(), self.number(), self.number())
        }
    }

    /// Pairs at all angles, many of them nearly parallel, flat, touching or of no length, at all scales and far from the origin.
    fn pairs(random: &mut Random) -> Vec<[Vec3; 4]> {
        let pair = |random: &mut Random| {
            let scale = 10f64.powf(6.0 * random.number());
            let small = |random: &mut Random| 10f64.powf(8.0 * (random.number() - 1.0));
            let mut x = [(); 4].map(|()| random.vector());
            if random.number() > 0.0 {
                x[3] = x[2] + (x[1] - x[0]) * random.number() + random.vector() * small(random);
            }
            if random.number() > 0.5 {
                x[2] = x[1] + random.vector() * small(random);
            }
            if random.number() > 0.9 {
                x[1] = x[0];
            }
            let away = random.vector() * (100.0 * small(random));
            x.map(|x| (x + away) * scale)
        };
        (0..RUN).map(|_| pair(random)).collect()
    }

    /// The exact distance is what `region.rs` is tested for; here a pair culled is one that it finds far.
    #[test]
    fn what_is_apart_is_far_and_little_that_is_far_is_kept() {
        let mut random = Random(7);
        let (mut far, mut culled) = ([0, 0], [0, 0]);
        for _ in 0..4000 {
            let x = pairs(&mut random);
            let size = (x[0][0] - x[0][3]).norm();
            let activation = size * 10f64.powf(3.0 * (random.number() - 1.0));
            let squared = activation * activation;
            let (edges, triangles) = (apart_edges(&x, squared), apart_point_triangles(&x, squared));
            for (k, x) in x.iter().enumerate() {
                let distances = [distance::edge_edge(x), distance::point_triangle(x)];
                for (kind, apart) in [edges[k], triangles[k]].into_iter().enumerate() {
                    assert!(
                        !apart || distances[kind] >= squared,
                        "{kind}: {x:?} at {} for {squared}",
                        distances[kind]
                    );
                    far[kind] += u32::from(distances[kind] > 1.01 * squared);
                    culled[kind] += u32::from(apart);
                }
            }
        }
        assert!(10 * culled[0] > 9 * far[0], "edges: {} of {}", culled[0], far[0]);
        assert!(10 * culled[1] > 7 * far[1], "triangles: {} of {}", culled[1], far[1]);
    }

    #[test]
    fn nan_is_not_apart() {
        let x = [[Vec3::repeat(f64::NAN), Vec3::x(), Vec3::y(), Vec3::z()]; 3];
        assert_eq!(apart_edges(&x, 1e-6)[..3], [false; 3]);
        assert_eq!(apart_point_triangles(&x, 1e-6)[..3], [false; 3]);
    }
}
