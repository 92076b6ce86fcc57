//! How far a whole mesh may move.

use super::sweep::Sweep;
use super::{Impact, Settings, additive, half_space};
use crate::collision_mesh::{Feature, HalfSpace};
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;

/// Queries in a chunk, within which the smallest answer so far spares the rest of longer ones.
const CHUNK: usize = 512;

/// Pairs of a list that are looked at first, evenly spread over it.
const SAMPLE: usize = 256;

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
/// query stops as soon as it is known free *beyond* a fraction that another pair has answered. Its full answer would have
/// been larger still, because an advance never goes back: it could not be the smallest, nor tie with it. So it makes no
/// difference to the answer which pairs were asked before it.
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
    let mut ends = vec![Vec3::zeros(); x.len()];
    parallel::map_into(&mut ends, 4096, |i| x[i] + p[i]);
    let motion = Motion { x, ends: &ends, d_min, settings };
    let Pairs { edges, triangles, half_spaces, .. } = *pairs;
    let mut first = First { fraction: 1.0, culprit: None };
    first.among(pairs.half_space_points, [Feature::HalfSpace, Feature::Point], |[h, i], _| {
        let [from, to] = motion.ends(&[i]);
        half_space(&from[0], &to[0], &half_spaces[h as usize], motion.d_min, settings)
    });
    first.among(pairs.point_points, [Feature::Point, Feature::Point], |points, enough| {
        let [from, to] = motion.ends(&points);
        motion.advance(&Sweep::point_point(&from, &to), enough)
    });
    first.among(pairs.point_edges, [Feature::Point, Feature::Edge], |[i, e], enough| {
        let [a, b] = edges[e as usize];
        let [from, to] = motion.ends(&[i, a, b]);
        motion.advance(&Sweep::point_edge(&from, &to), enough)
    });
    first.among(pairs.point_triangles, [Feature::Point, Feature::Triangle], |[i, k], enough| {
        let [a, b, c] = triangles[k as usize];
        let [from, to] = motion.ends(&[i, a, b, c]);
        motion.advance(&Sweep::point_triangle(&from, &to), enough)
    });
    first.among(pairs.edge_edges, [Feature::Edge, Feature::Edge], |[e, f], enough| {
        let ([a, b], [c, d]) = (edges[e as usize], edges[f as usize]);
        let [from, to] = motion.ends(&[a, b, c, d]);
        motion.advance(&Sweep::edge_edge(&from, &to), enough)
    });
    (first.fraction, first.culprit)
}

/// The straight motion of all points.
struct Motion<'a> {
    x: &'a [Vec3],
    ends: &'a [Vec3],
    d_min: f64,
    settings: &'a Settings,
}

impl Motion<'_> {
    /// Positions of some points before and after.
    #[inline]
    fn ends<const N: usize>(&self, points: &[u32; N]) -> [[Vec3; N]; 2] {
        let from = points.map(|i| self.x[i as usize]);
        let to = points.map(|i| self.ends[i as usize]);
        [from, to]
    }

    #[inline]
    fn advance<const K: usize>(&self, sweep: &Sweep<K>, enough: f64) -> Impact {
        additive::advance(sweep, self.d_min, self.settings, enough)
    }
}

/// The first of the pairs so far with the smallest fraction below one.
struct First {
    fraction: f64,
    culprit: Option<Culprit>,
}

impl First {
    /// Goes on with more pairs. `query` is given a pair and the fraction beyond which its answer does not matter: the
    /// smallest known from earlier lists, from a sample of this one, and within a chunk of pairs.
    fn among(
        &mut self,
        pairs: &[[u32; 2]],
        features: [fn(u32) -> Feature; 2],
        query: impl Fn([u32; 2], f64) -> Impact + Sync,
    ) {
        let stride = pairs.len().div_ceil(SAMPLE).max(1);
        let sample = pairs.iter().step_by(stride);
        let known = sample.fold(self.fraction, |known, pair| known.min(query(*pair, known).fraction()));
        let in_chunk = |range: std::ops::Range<usize>| {
            let mut enough = known;
            let mut least = None;
            for &pair in &pairs[range] {
                let impact = query(pair, enough);
                let fraction = impact.fraction();
                // What is known may be this very pair's.
                if fraction < enough || fraction == enough && least.is_none() {
                    enough = fraction;
                    least = Some((pair, impact));
                }
            }
            least
        };
        for ([a, b], impact) in parallel::map_chunks(pairs.len(), CHUNK, in_chunk).into_iter().flatten() {
            if impact.fraction() < self.fraction {
                let features = [features[0](a), features[1](b)];
                *self = Self { fraction: impact.fraction(), culprit: Some(Culprit { features, impact }) };
            }
        }
    }
}

/// The largest absolute coordinate before or after; infinite if a coordinate is not finite.
fn largest_coordinate(x: &[Vec3], p: &[Vec3]) -> f64 {
    let size = |i: usize| x[i].amax().max((x[i] + p[i]).amax());
    parallel::minimum(x.len(), 4096, |i| -size(i)).map_or(0.0, |(_, least)| -least)
}
