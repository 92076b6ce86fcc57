//! How far a whole mesh may move.

use super::sweep::Sweep;
use super::{Impact, Settings, additive, half_space};
use crate::collision_mesh::{Feature, HalfSpace};
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;

/// Queries in a chunk, within which the smallest answer so far spares the rest of longer ones.
const CHUNK: usize = 512;

/// The pairs that may meet, and the features that they name.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pairs<'a> {
    /// Points of each edge.
    pub edges: &'a [[u32; 2]],
    /// Points of each triangle.
    pub triangles: &'a [[u32; 3]],
    /// Half-spaces.
    pub half_spaces: &'a [HalfSpace],
    /// Half-space and point.
    pub half_space_points: &'a [[u32; 2]],
    /// Two points.
    pub point_points: &'a [[u32; 2]],
    /// Point and edge.
    pub point_edges: &'a [[u32; 2]],
    /// Point and triangle.
    pub point_triangles: &'a [[u32; 2]],
    /// Two edges.
    pub edge_edges: &'a [[u32; 2]],
}

/// The pair that limits a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Culprit {
    /// Its features.
    pub features: [Feature; 2],
    /// What its query answered.
    pub impact: Impact,
}

/// How far all points may go from `x` along `p`, x + α p, so that no pair gets closer than `d_min` \[m\]: the largest
/// fraction α ≤ 1 found, and the pair that limits it; 1 and none if nothing is in the way.
///
/// A solver goes to positions that are rounded to double precision, while a query speaks of exact lines. What may lie between
/// them, less than 8 ε max|coordinate| in the distance of two points, is added to the minimum separation. So the guarantee
/// holds for the positions `x + α p` as f64 has them, for the fraction answered and for every smaller one; a pair
/// that starts closer than that is reported as starting too close, with fraction 0.
///
/// The answer has the same bits for any number of threads, the culprit is the first of those with the smallest
/// fraction (half-spaces, then pairs of points, points and edges, points and triangles, edges, each in the order given). A
/// query stops as soon as it is known free *beyond* the smallest fraction in its chunk so far. Its full answer would have
/// been larger still, because an advance never goes back: it could not be the smallest, nor tie with it.
///
/// # Panics
/// If a pair names a feature that does not exist, or a point beyond `x` or `p`.
pub fn limit(
    pairs: &Pairs<'_>,
    x: &[Vec3],
    p: &[Vec3],
    d_min: f64,
    settings: &Settings,
) -> (f64, Option<Culprit>) {
    assert_eq!(x.len(), p.len(), "as many displacements as points");
    let rounding = 8.0 * f64::EPSILON * largest_coordinate(x, p);
    // The pair with an infinite point shall be named, not the first one.
    let d_min = if rounding.is_finite() { d_min + rounding } else { d_min };
    let motion = Motion { x, p, d_min, settings };
    let Pairs { edges, triangles, half_spaces, .. } = *pairs;
    let candidates = [
        smallest(pairs.half_space_points, |&[h, i], _| {
            let [from, to] = motion.ends(&[i]);
            half_space(&from[0], &to[0], &half_spaces[h as usize], motion.d_min, settings)
        })
        .map(|([h, i], impact)| ([Feature::HalfSpace(h), Feature::Point(i)], impact)),
        smallest(pairs.point_points, |&[i, j], enough| {
            let [from, to] = motion.ends(&[i, j]);
            motion.advance(&Sweep::point_point(&from, &to), enough)
        })
        .map(|([i, j], impact)| ([Feature::Point(i), Feature::Point(j)], impact)),
        smallest(pairs.point_edges, |&[i, e], enough| {
            let [a, b] = edges[e as usize];
            let [from, to] = motion.ends(&[i, a, b]);
            motion.advance(&Sweep::point_edge(&from, &to), enough)
        })
        .map(|([i, e], impact)| ([Feature::Point(i), Feature::Edge(e)], impact)),
        smallest(pairs.point_triangles, |&[i, k], enough| {
            let [a, b, c] = triangles[k as usize];
            let [from, to] = motion.ends(&[i, a, b, c]);
            motion.advance(&Sweep::point_triangle(&from, &to), enough)
        })
        .map(|([i, k], impact)| ([Feature::Point(i), Feature::Triangle(k)], impact)),
        smallest(pairs.edge_edges, |&[e, f], enough| {
            let ([a, b], [c, d]) = (edges[e as usize], edges[f as usize]);
            let [from, to] = motion.ends(&[a, b, c, d]);
            motion.advance(&Sweep::edge_edge(&from, &to), enough)
        })
        .map(|([e, f], impact)| ([Feature::Edge(e), Feature::Edge(f)], impact)),
    ];
    let first =
        candidates.into_iter().flatten().reduce(|a, b| if b.1.fraction() < a.1.fraction() { b } else { a });
    let culprit = first.map(|(features, impact)| Culprit { features, impact });
    (culprit.map_or(1.0, |culprit| culprit.impact.fraction()), culprit)
}

/// The straight motion of all points.
struct Motion<'a> {
    x: &'a [Vec3],
    p: &'a [Vec3],
    d_min: f64,
    settings: &'a Settings,
}

impl Motion<'_> {
    /// Positions of some points before and after.
    #[inline]
    fn ends<const N: usize>(&self, points: &[u32; N]) -> [[Vec3; N]; 2] {
        let from = points.map(|i| self.x[i as usize]);
        let to = points.map(|i| self.x[i as usize] + self.p[i as usize]);
        [from, to]
    }

    #[inline]
    fn advance<const K: usize>(&self, sweep: &Sweep<K>, enough: f64) -> Impact {
        additive::advance(sweep, self.d_min, self.settings, enough)
    }
}

/// The first of the pairs with the smallest fraction, if that is below one.
fn smallest(
    pairs: &[[u32; 2]],
    query: impl Fn(&[u32; 2], f64) -> Impact + Sync,
) -> Option<([u32; 2], Impact)> {
    let in_chunk = |range: std::ops::Range<usize>| {
        let mut least = (1.0, None);
        for pair in &pairs[range] {
            let impact = query(pair, least.0);
            if impact.fraction() < least.0 {
                least = (impact.fraction(), Some((*pair, impact)));
            }
        }
        least
    };
    let earlier = |a: (f64, Option<_>), b: (f64, Option<_>)| if b.0 < a.0 { b } else { a };
    parallel::map_chunks(pairs.len(), CHUNK, in_chunk).into_iter().fold((1.0, None), earlier).1
}

/// The largest absolute coordinate before or after; infinite if a coordinate is not finite.
fn largest_coordinate(x: &[Vec3], p: &[Vec3]) -> f64 {
    let size = |i: usize| x[i].amax().max((x[i] + p[i]).amax());
    parallel::minimum(x.len(), 4096, |i| -size(i)).map_or(0.0, |(_, least)| -least)
}
