//! From candidates to active pairs.

use super::cull;
use super::maximum;
use super::merge::Share;
use super::{ContactPairs, EdgeEdgeContacts, Weighting};
use crate::broad_phase::Candidates;
use crate::collision_mesh::{CollisionMesh, HalfSpace};
use crate::distance::{self, EdgeEdgeMollifier, Region};
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;

/// Candidates or points of a parallel part.
const CHUNK: usize = 4096;

/// What all candidates share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near<'a> {
    pub(super) mesh: &'a CollisionMesh,
    pub(super) x: &'a [Vec3],
    pub(super) activation_squared: f64,
    pub(super) weighting: Weighting,
}

/// What a run of candidates has found.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) point_points: Vec<Share<2>>,
    pub(super) point_edges: Vec<Share<3>>,
    pub(super) point_triangles: ContactPairs<4>,
    pub(super) edge_edges: EdgeEdgeContacts,
    /// Active pairs of edges, kept for the improved maximum only.
    pub(super) active_edges: Vec<ActiveEdges>,
    /// The smallest squared distance; infinite if nothing is active.
    pub(super) smallest: f64,
}

/// Two edges nearer than the activation distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct ActiveEdges {
    pub(super) edges: [u32; 2],
    /// Their mollifier, if it is active.
    pub(super) mollifier: Option<EdgeEdgeMollifier>,
}

impl Part {
    pub(super) fn new() -> Self {
        Self {
            point_points: Vec::new(),
            point_edges: Vec::new(),
            point_triangles: ContactPairs::default(),
            edge_edges: EdgeEdgeContacts::default(),
            active_edges: Vec::new(),
            smallest: f64::INFINITY,
        }
    }

    pub(super) fn note(&mut self, squared: f64) {
        self.smallest = smaller(self.smallest, squared);
    }

    pub(super) fn share_points(&mut self, [a, b]: [u32; 2], sample: u32, count: i32) {
        self.point_points.push(Share { points: [a.min(b), a.max(b)], sample, count });
    }

    pub(super) fn share_edge(&mut self, [point, a, b]: [u32; 3], sample: u32, count: i32) {
        self.point_edges.push(Share { points: [point, a.min(b), a.max(b)], sample, count });
    }

    /// A share of closest features with fewer points than the pair has.
    pub(super) fn share<const N: usize>(
        &mut self,
        region: Region,
        points: &[u32; N],
        sample: u32,
        count: i32,
    ) {
        match region {
            Region::PointPoint(places) => {
                self.share_points(places.map(|k| points[usize::from(k)]), sample, count);
            }
            Region::PointEdge(places) => {
                self.share_edge(places.map(|k| points[usize::from(k)]), sample, count);
            }
            Region::PointTriangle(_) | Region::EdgeEdge(_) => {}
        }
    }
}

/// The smaller of two, or NaN if one is.
#[inline]
pub(super) fn smaller(a: f64, b: f64) -> f64 {
    if a.is_nan() || a <= b { a } else { b }
}

impl<'a> Near<'a> {
    /// Active unless known to be far: a NaN is active.
    #[inline(always)]
    pub(super) fn is_active(&self, squared: f64) -> bool {
        squared < self.activation_squared || squared.is_nan()
    }

    #[inline(always)]
    pub(super) fn positions<const N: usize>(&self, points: &[u32; N]) -> [Vec3; N] {
        points.map(|p| self.x[p as usize])
    }

    /// The positions of the points of a run of candidates, and how many these are.
    #[inline(always)]
    fn gathered(
        &self,
        run: &[[u32; 2]],
        points: impl Fn(&[u32; 2]) -> [u32; 4],
    ) -> ([[Vec3; 4]; cull::RUN], usize) {
        let mut gathered = [[Vec3::zeros(); 4]; cull::RUN];
        for (gathered, candidate) in gathered.iter_mut().zip(run) {
            // Each in place: an array of copies would be stored number by number and read back in wider registers, which waits.
            for (position, point) in gathered.iter_mut().zip(points(candidate)) {
                *position = self.x[point as usize];
            }
        }
        (gathered, run.len())
    }

    /// The number under which shares of a point are counted.
    #[inline(always)]
    pub(super) fn point_sample(&self, point: u32) -> u32 {
        match self.weighting {
            Weighting::Unit => 0,
            Weighting::Area => point,
        }
    }

    /// The number under which shares of an edge are counted.
    #[inline(always)]
    pub(super) fn edge_sample(&self, edge: u32) -> u32 {
        match self.weighting {
            Weighting::Unit => 0,
            Weighting::Area => self.mesh.point_count() as u32 + edge,
        }
    }

    /// The weight of one share of a sample.
    #[inline(always)]
    pub(super) fn unit(&self, sample: u32) -> f64 {
        let points = self.mesh.point_count() as u32;
        match self.weighting {
            Weighting::Unit => 1.0,
            Weighting::Area if sample < points => {
                let is_loose = self.mesh.loose_points().binary_search(&sample).is_ok();
                self.mesh.point_area(sample) * if is_loose { 0.5 } else { 0.25 }
            }
            Weighting::Area => 0.25 * self.mesh.edge_area(sample - points),
        }
    }

    pub(super) fn half_space_weight(&self, point: u32) -> f64 {
        match self.weighting {
            Weighting::Unit => 1.0,
            Weighting::Area => self.mesh.point_area(point),
        }
    }

    /// Points nearer to a half-space than the activation distance, with their signed distances, in order.
    pub(super) fn half_space_distances(&self, number: u32, half_space: &HalfSpace) -> Vec<Vec<(u32, f64)>> {
        let (points, activation) = (self.mesh.vertices(), self.activation_squared.sqrt());
        parallel::map_chunks(points.len(), CHUNK, |range| {
            let near = points[range].iter().filter_map(|&point| {
                let distance = half_space.distance(&self.x[point as usize]);
                let is_near = distance < activation || distance.is_nan();
                let is_active = is_near && self.mesh.may_touch_half_space(number, point);
                is_active.then_some((point, distance))
            });
            near.collect()
        })
    }

    /// The weight of a whole edge–edge pair.
    #[inline(always)]
    fn edge_pair_weight(&self, [a, b]: [u32; 2]) -> f64 {
        match self.weighting {
            Weighting::Unit => 1.0,
            Weighting::Area => 0.25 * (self.mesh.edge_area(a) + self.mesh.edge_area(b)),
        }
    }

    /// Squared length of an edge at rest.
    fn rest_length_squared(&self, edge: u32) -> f64 {
        let [a, b] = self.mesh.edges()[edge as usize].map(|p| self.mesh.rest()[p as usize]);
        (b - a).norm_squared()
    }
}

/// All active pairs of the mesh's features, in parts in the order of the candidates.
pub(super) fn mesh_pairs(near: &Near<'_>, candidates: &Candidates) -> Vec<Part> {
    let (triangles, edges) = (&candidates.point_triangles, &candidates.edge_edges);
    let (loose, points) = (&candidates.point_edges, &candidates.point_points);
    let mut parts = parallel::map_chunks(triangles.len(), CHUNK, |range| match near.weighting {
        Weighting::Unit => point_triangles(near, &triangles[range]),
        Weighting::Area => maximum::point_triangles(near, maximum::whole_groups(triangles, range)),
    });
    parts.extend(parallel::map_chunks(edges.len(), CHUNK, |range| edge_edges(near, &edges[range])));
    parts.extend(parallel::map_chunks(loose.len(), CHUNK, |range| match near.weighting {
        Weighting::Unit => point_edges(near, &loose[range]),
        Weighting::Area => maximum::point_edges(near, maximum::whole_groups(loose, range)),
    }));
    parts.extend(parallel::map_chunks(points.len(), CHUNK, |range| point_points(near, &points[range])));
    parts
}

fn point_triangles(near: &Near<'_>, candidates: &[[u32; 2]]) -> Part {
    let mut part = Part::new();
    for run in candidates.chunks(cull::RUN) {
        let points = |&[point, triangle]: &[u32; 2]| {
            let [a, b, c] = near.mesh.triangles()[triangle as usize];
            [point, a, b, c]
        };
        let (x, count) = near.gathered(run, points);
        let apart = cull::apart_point_triangles(&x[..count], near.activation_squared);
        for (candidate, _) in run.iter().zip(apart).filter(|(_, apart)| !apart) {
            add_point_triangle(near, candidate, &mut part);
        }
    }
    part
}

/// Whether the pair is active.
#[inline(always)]
pub(super) fn add_point_triangle(near: &Near<'_>, &[point, triangle]: &[u32; 2], part: &mut Part) -> bool {
    let [a, b, c] = near.mesh.triangles()[triangle as usize];
    let points = [point, a, b, c];
    let x = near.positions(&points);
    let (region, squared) = distance::point_triangle_closest(&x);
    if !near.is_active(squared) {
        return false;
    }
    part.note(squared);
    let sample = near.point_sample(point);
    if let Region::PointTriangle(_) = region {
        part.point_triangles.push(points, near.unit(sample));
    } else {
        part.share(region, &points, sample, 1);
    }
    true
}

fn edge_edges(near: &Near<'_>, candidates: &[[u32; 2]]) -> Part {
    let mut part = Part::new();
    let points = |edges: &[u32; 2]| {
        let [[a, b], [c, d]] = edges.map(|edge| near.mesh.edges()[edge as usize]);
        [a, b, c, d]
    };
    for run in candidates.chunks(cull::RUN) {
        let (gathered, count) = near.gathered(run, points);
        let apart = cull::apart_edges(&gathered[..count], near.activation_squared);
        for ((edges, x), _) in run.iter().zip(&gathered).zip(apart).filter(|(_, apart)| !apart) {
            let (region, squared) = distance::edge_edge_closest(x);
            if near.is_active(squared) {
                part.note(squared);
                add_edge_edge(near, *edges, &points(edges), x, region, &mut part);
            }
        }
    }
    part
}

fn add_edge_edge(
    near: &Near<'_>,
    edges: [u32; 2],
    points: &[u32; 4],
    x: &[Vec3; 4],
    region: Region,
    part: &mut Part,
) {
    let [first, second] = edges.map(|edge| near.rest_length_squared(edge));
    let mollifier = EdgeEdgeMollifier::from_rest_lengths_squared(first, second);
    let is_mollified = mollifier.is_active(x);
    if is_mollified || matches!(region, Region::EdgeEdge(_)) {
        part.edge_edges.push(*points, near.edge_pair_weight(edges), mollifier, region);
    } else {
        share_edge_pair(near, edges, points, region, part);
    }
    if near.weighting == Weighting::Area {
        part.active_edges.push(ActiveEdges { edges, mollifier: is_mollified.then_some(mollifier) });
    }
}

/// One candidate of weight one, or half of it from each edge's area.
fn share_edge_pair(near: &Near<'_>, [a, b]: [u32; 2], points: &[u32; 4], region: Region, part: &mut Part) {
    part.share(region, points, near.edge_sample(a), 1);
    if near.weighting == Weighting::Area {
        part.share(region, points, near.edge_sample(b), 1);
    }
}

fn point_edges(near: &Near<'_>, candidates: &[[u32; 2]]) -> Part {
    let mut part = Part::new();
    for candidate in candidates {
        add_point_edge(near, candidate, &mut part);
    }
    part
}

/// Whether the pair is active.
pub(super) fn add_point_edge(near: &Near<'_>, &[point, edge]: &[u32; 2], part: &mut Part) -> bool {
    let [a, b] = near.mesh.edges()[edge as usize];
    let points = [point, a, b];
    let (region, squared) = distance::point_edge_closest(&near.positions(&points));
    let is_active = near.is_active(squared);
    if is_active {
        part.note(squared);
        part.share(region, &points, near.point_sample(point), 1);
    }
    is_active
}

fn point_points(near: &Near<'_>, candidates: &[[u32; 2]]) -> Part {
    let mut part = Part::new();
    for &[a, b] in candidates {
        let squared = distance::point_point(&near.positions(&[a, b]));
        if near.is_active(squared) {
            part.note(squared);
            part.share_points([a, b], near.point_sample(a), 1);
            if near.weighting == Weighting::Area {
                part.share_points([a, b], near.point_sample(b), 1);
            }
        }
    }
    part
}
