//! How far a step may go.

use super::CloseFeatures;
use super::neighbourhood::Neighbourhood;
use crate::broad_phase::Candidates;
use crate::ccd::{self, Impact, Settings};
use crate::collision_mesh::{CollisionMesh, Feature};
use crate::error::ContactError;
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;

/// Queries of one task.
const CHUNK: usize = 256;

/// How far into a step one search for candidates looks, in lengths of the longest edge or of the reach.
const STRIDE: f64 = 8.0;

/// Continuous detection for one mesh.
#[derive(Clone, Debug)]
pub(super) struct Detection {
    settings: Settings,
    /// d_min \[m\].
    minimum_separation: f64,
    /// The largest displacement for which candidates are searched at once \[m\].
    stride: f64,
    queries: u64,
}

/// The part of a step that is free, and the pair that ends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limit {
    pub(super) fraction: f64,
    pub(super) pair: Option<[Feature; 2]>,
}

impl Limit {
    const FULL: Self = Self { fraction: 1.0, pair: None };

    fn or_sooner(self, fraction: f64, pair: [Feature; 2]) -> Self {
        if fraction < self.fraction { Self { fraction, pair: Some(pair) } } else { self }
    }
}

impl Detection {
    /// Leaves each pair `kept_gap` of its gap, or half of the activation distance if that is less.
    pub(super) fn new(
        mesh: &CollisionMesh,
        activation_distance: f64,
        minimum_separation: f64,
        kept_gap: f64,
    ) -> Self {
        let longest = (0..mesh.edges().len() as u32).map(|edge| mesh.rest_length(edge)).fold(0.0, f64::max);
        let settings =
            Settings { kept_gap, largest_kept_gap: 0.5 * activation_distance, ..Settings::default() };
        let stride = STRIDE * longest.max(activation_distance + minimum_separation);
        Self { settings, minimum_separation, stride, queries: 0 }
    }

    /// Queries asked so far.
    pub(super) fn queries(&self) -> u64 {
        self.queries
    }

    /// The free part of the step from `x` to `x + p`.
    ///
    /// A long step is looked at piece by piece: up to one stride first, then up to twice as far, and so on. Boxes of
    /// a whole long step would hold most of the scene, though most of it is never reached because something is hit
    /// before. Where the pieces end depends on `p` alone, so that the answer does not depend on candidates known
    /// before.
    ///
    /// # Errors
    /// If a pair touches at `x`, up to rounding.
    pub(super) fn limit(
        &mut self,
        mesh: &CollisionMesh,
        neighbourhood: &mut Neighbourhood,
        x: &[Vec3],
        p: &[Vec3],
    ) -> Result<Limit, ContactError> {
        let planes = self.limit_by_half_spaces(mesh, x, p)?;
        let longest = mesh.vertices().iter().map(|&point| p[point as usize].norm()).fold(0.0, f64::max);
        let mut end = vec![Vec3::zeros(); x.len()];
        let mut part = (self.stride / longest).min(planes.fraction);
        loop {
            for ((end, x), p) in end.iter_mut().zip(x).zip(p) {
                *end = x + p * part;
            }
            if !neighbourhood.covers(mesh, x, &end) {
                neighbourhood.search(mesh, x, &end)?;
            }
            let found = self.limit_by_pairs(mesh, neighbourhood.candidates(), x, &end)?;
            if found.pair.is_some() {
                return Ok(Limit { fraction: part * found.fraction, ..found });
            }
            if part >= planes.fraction {
                return Ok(planes);
            }
            part = (2.0 * part).min(planes.fraction);
        }
    }

    /// The gap of a point moves evenly from g₀ to g₁, and passes what is to be kept, k, at (g₀ − k)/(g₀ − g₁).
    fn limit_by_half_spaces(
        &mut self,
        mesh: &CollisionMesh,
        x: &[Vec3],
        p: &[Vec3],
    ) -> Result<Limit, ContactError> {
        let mut limit = Limit::FULL;
        for (plane, number) in mesh.half_spaces().iter().zip(0..) {
            for &point in mesh.vertices().iter().filter(|&&point| mesh.may_touch_half_space(number, point)) {
                let pair = [Feature::Point(point), Feature::HalfSpace(number)];
                let distance = plane.distance(&x[point as usize]);
                let gap = distance - self.minimum_separation;
                if gap.is_nan() || gap <= 0.0 {
                    return Err(self.too_close(mesh, pair, distance));
                }
                let kept = (self.settings.kept_gap * gap).min(self.settings.largest_kept_gap);
                let approach = -plane.normal.dot(&p[point as usize]);
                if gap - approach < kept {
                    limit = limit.or_sooner((gap - kept) / approach, pair);
                }
            }
        }
        Ok(limit)
    }

    fn limit_by_pairs(
        &mut self,
        mesh: &CollisionMesh,
        candidates: &Candidates,
        x: &[Vec3],
        end: &[Vec3],
    ) -> Result<Limit, ContactError> {
        self.queries += candidates.len() as u64;
        let query = Query { mesh, x, end, d_min: self.minimum_separation, settings: &self.settings };
        let mut limit = Limit::FULL;
        let point_triangle = |[p, t]: [u32; 2]| query.point_triangle(p, t);
        limit = self.first(limit, &query, &candidates.point_triangles, POINT_TRIANGLE, point_triangle)?;
        let edge_edge = |[a, b]: [u32; 2]| query.edge_edge(a, b);
        limit = self.first(limit, &query, &candidates.edge_edges, EDGE_EDGE, edge_edge)?;
        let point_edge = |[p, e]: [u32; 2]| query.point_edge(p, e);
        limit = self.first(limit, &query, &candidates.point_edges, POINT_EDGE, point_edge)?;
        let point_point = |[p, q]: [u32; 2]| query.point_point(p, q);
        self.first(limit, &query, &candidates.point_points, POINT_POINT, point_point)
    }

    /// The sooner of `limit` and the first impact of a list of pairs.
    fn first(
        &self,
        limit: Limit,
        query: &Query<'_>,
        pairs: &[[u32; 2]],
        kind: Kind,
        impact: impl Fn([u32; 2]) -> Impact + Sync,
    ) -> Result<Limit, ContactError> {
        let fraction = |k: usize| match impact(pairs[k]) {
            Impact::Free => 1.0,
            Impact::At(fraction) => fraction,
            Impact::StartsTooClose { .. } => -1.0,
            Impact::NonFinite => f64::NAN,
        };
        let Some((k, fraction)) = parallel::minimum(pairs.len(), CHUNK, fraction) else { return Ok(limit) };
        let pair = kind(pairs[k]);
        if fraction >= 0.0 {
            return Ok(limit.or_sooner(fraction, pair));
        }
        Err(match impact(pairs[k]) {
            Impact::StartsTooClose { distance } => self.too_close(query.mesh, pair, distance),
            _ => query.non_finite(),
        })
    }

    fn too_close(&self, mesh: &CollisionMesh, pair: [Feature; 2], distance: f64) -> ContactError {
        let pairs = vec![CloseFeatures::new(mesh, pair, distance)];
        ContactError::TooClose { pairs, minimum_separation: self.minimum_separation }
    }
}

/// Two numbers as the features that they are.
type Kind = fn([u32; 2]) -> [Feature; 2];

const POINT_TRIANGLE: Kind = |[p, t]| [Feature::Point(p), Feature::Triangle(t)];
const EDGE_EDGE: Kind = |[a, b]| [Feature::Edge(a), Feature::Edge(b)];
const POINT_EDGE: Kind = |[p, e]| [Feature::Point(p), Feature::Edge(e)];
const POINT_POINT: Kind = |[p, q]| [Feature::Point(p), Feature::Point(q)];

/// A mesh on its way.
struct Query<'a> {
    mesh: &'a CollisionMesh,
    x: &'a [Vec3],
    end: &'a [Vec3],
    d_min: f64,
    settings: &'a Settings,
}

impl Query<'_> {
    fn at<const N: usize>(&self, points: [u32; N]) -> [[Vec3; N]; 2] {
        [points.map(|p| self.x[p as usize]), points.map(|p| self.end[p as usize])]
    }

    fn point_triangle(&self, p: u32, t: u32) -> Impact {
        let [a, b, c] = self.mesh.triangles()[t as usize];
        let [start, end] = self.at([p, a, b, c]);
        ccd::point_triangle(&start, &end, self.d_min, self.settings)
    }

    fn edge_edge(&self, a: u32, b: u32) -> Impact {
        let ([a, b], [c, d]) = (self.mesh.edges()[a as usize], self.mesh.edges()[b as usize]);
        let [start, end] = self.at([a, b, c, d]);
        ccd::edge_edge(&start, &end, self.d_min, self.settings)
    }

    fn point_edge(&self, p: u32, e: u32) -> Impact {
        let [a, b] = self.mesh.edges()[e as usize];
        let [start, end] = self.at([p, a, b]);
        ccd::point_edge(&start, &end, self.d_min, self.settings)
    }

    fn point_point(&self, p: u32, q: u32) -> Impact {
        let [start, end] = self.at([p, q]);
        ccd::point_point(&start, &end, self.d_min, self.settings)
    }

    fn non_finite(&self) -> ContactError {
        let wrong = |x: &[Vec3]| x.iter().position(|x| !x.iter().all(|c| c.is_finite())).map(|point| (point, x[point]));
        let (point, position) = wrong(self.x).or_else(|| wrong(self.end)).unwrap_or((0, Vec3::zeros()));
        ContactError::NonFinite { point, position: position.into() }
    }
}
