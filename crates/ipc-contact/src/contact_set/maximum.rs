//! The improved maximum operator: what several triangles or edges count twice is subtracted.

use super::narrow::{self, ActiveEdges, Near, Part};
use crate::distance::{self, EdgeEdgeMollifier, Region};
use mechanics_core::parallel;
use std::ops::Range;

/// Edges of a parallel part.
const CHUNK: usize = 4096;

/// The candidates of `range`, moved to the borders between first features, so that each group is in one part.
pub(super) fn whole_groups(candidates: &[[u32; 2]], range: Range<usize>) -> &[[u32; 2]] {
    let border = |index: usize| {
        let Some(before) = index.checked_sub(1) else { return 0 };
        let group = candidates[before][0];
        index + candidates[index..].iter().take_while(|candidate| candidate[0] == group).count()
    };
    &candidates[border(range.start)..border(range.end)]
}

/// Active point–triangle pairs, with the edges and corners that several of a point's triangles share.
pub(super) fn point_triangles(near: &Near<'_>, candidates: &[[u32; 2]]) -> Part {
    let mut part = Part::new();
    let mut shared = SharedFeatures::default();
    for group in candidates.chunk_by(|a, b| a[0] == b[0]) {
        shared.clear();
        for candidate in group {
            if narrow::add_point_triangle(near, candidate, &mut part) {
                shared.add_triangle(near, candidate[1]);
            }
        }
        shared.subtract(near, group[0][0], &mut part);
    }
    part
}

/// The edges and corners of the triangles that are active for one point.
#[derive(Default)]
struct SharedFeatures {
    triangles: usize,
    /// Edges, once for each triangle.
    edges: Vec<u32>,
    /// Corners with their parts in n_v − Σ (m_e − 1).
    corners: Vec<(u32, i32)>,
}

impl SharedFeatures {
    fn clear(&mut self) {
        self.triangles = 0;
        self.edges.clear();
        self.corners.clear();
    }

    fn add_triangle(&mut self, near: &Near<'_>, triangle: u32) {
        self.triangles += 1;
        self.edges.extend(near.mesh.triangle_edges()[triangle as usize]);
        self.corners.extend(near.mesh.triangles()[triangle as usize].map(|corner| (corner, 1)));
    }

    fn subtract(&mut self, near: &Near<'_>, point: u32, part: &mut Part) {
        if self.triangles < 2 {
            return;
        }
        let sample = near.point_sample(point);
        self.edges.sort_unstable();
        for sharing in self.edges.chunk_by(|a, b| a == b).filter(|sharing| sharing.len() > 1) {
            let surplus = sharing.len() as i32 - 1;
            let [a, b] = near.mesh.edges()[sharing[0] as usize];
            self.corners.extend([(a, -surplus), (b, -surplus)]);
            let points = [point, a, b];
            let (region, squared) = distance::point_edge_closest(&near.positions(&points));
            if near.is_active(squared) {
                part.share(region, &points, sample, -surplus);
            }
        }
        self.corners.sort_unstable();
        for corner in self.corners.chunk_by(|a, b| a.0 == b.0) {
            let count = 1 - corner.iter().map(|(_, count)| count).sum::<i32>();
            let points = [point, corner[0].0];
            if count != 0 && near.is_active(distance::point_point(&near.positions(&points))) {
                part.share_points(points, sample, count);
            }
        }
    }
}

/// Active pairs of a loose point and a loose edge, less the ends that several of a point's edges share.
pub(super) fn point_edges(near: &Near<'_>, candidates: &[[u32; 2]]) -> Part {
    let mut part = Part::new();
    let mut ends: Vec<u32> = Vec::new();
    for group in candidates.chunk_by(|a, b| a[0] == b[0]) {
        let point = group[0][0];
        ends.clear();
        for candidate in group {
            if narrow::add_point_edge(near, candidate, &mut part) {
                ends.extend(near.mesh.edges()[candidate[1] as usize]);
            }
        }
        ends.sort_unstable();
        for sharing in ends.chunk_by(|a, b| a == b).filter(|sharing| sharing.len() > 1) {
            let points = [point, sharing[0]];
            if near.is_active(distance::point_point(&near.positions(&points))) {
                part.share_points(points, near.point_sample(point), 1 - sharing.len() as i32);
            }
        }
    }
    part
}

/// For every edge, the ends that several of its active partners share, with negative weights.
pub(super) fn subtracted_edge_ends(near: &Near<'_>, parts: &[Part]) -> Part {
    let neighbours = Neighbours::new(near.mesh.edges().len(), parts);
    let parts = parallel::map_chunks(near.mesh.edges().len(), CHUNK, |edges| {
        let mut part = Part::new();
        let mut ends = Vec::new();
        for edge in edges {
            subtract_ends(near, edge as u32, neighbours.of(edge), &mut ends, &mut part);
        }
        part
    });
    let mut all = Part::new();
    for mut part in parts {
        all.point_points.append(&mut part.point_points);
        all.point_edges.append(&mut part.point_edges);
        all.edge_edges.append(&mut part.edge_edges);
    }
    all
}

/// An edge that is near another, with their mollifier if it is active.
type Neighbour = (u32, Option<EdgeEdgeMollifier>);

/// Active partners of each edge, in the order of the candidates.
struct Neighbours {
    /// Where each edge's partners start, and the number of all.
    starts: Vec<usize>,
    partners: Vec<Neighbour>,
}

impl Neighbours {
    /// A counting sort of all active pairs, both ways round.
    fn new(edges: usize, parts: &[Part]) -> Self {
        let pairs = || parts.iter().flat_map(|part| &part.active_edges);
        let mut starts = vec![0; edges + 1];
        for pair in pairs() {
            for edge in pair.edges {
                starts[edge as usize + 1] += 1;
            }
        }
        for edge in 0..edges {
            starts[edge + 1] += starts[edge];
        }
        let mut next = starts.clone();
        let mut partners = vec![(0, None); starts[edges]];
        for &ActiveEdges { edges: [a, b], mollifier } in pairs() {
            for [edge, partner] in [[a, b], [b, a]] {
                partners[next[edge as usize]] = (partner, mollifier);
                next[edge as usize] += 1;
            }
        }
        Self { starts, partners }
    }

    fn of(&self, edge: usize) -> &[Neighbour] {
        &self.partners[self.starts[edge]..self.starts[edge + 1]]
    }
}

/// Subtracts (Σ m_ij − 1) b(i, v) for the edge i and every end v that two or more of its partners j share.
fn subtract_ends(
    near: &Near<'_>,
    edge: u32,
    partners: &[Neighbour],
    ends: &mut Vec<(u32, u32)>,
    part: &mut Part,
) {
    if partners.len() < 2 {
        return;
    }
    ends.clear();
    for (index, (partner, _)) in (0..).zip(partners) {
        ends.extend(near.mesh.edges()[*partner as usize].map(|end| (end, index)));
    }
    ends.sort_unstable();
    let [a, b] = near.mesh.edges()[edge as usize];
    for sharing in ends.chunk_by(|a, b| a.0 == b.0).filter(|sharing| sharing.len() > 1) {
        let points = [sharing[0].0, a, b];
        let (region, squared) = distance::point_edge_closest(&near.positions(&points));
        if !near.is_active(squared) {
            continue;
        }
        let mut count = 1;
        for &(end, index) in sharing {
            let (partner, mollifier) = partners[index as usize];
            match mollifier {
                Some(mollifier) => {
                    let pair = [edge, partner];
                    subtract_mollified(near, pair, end, region, mollifier, part);
                }
                None => count -= 1,
            }
        }
        if count != 0 {
            part.share(region, &points, near.edge_sample(edge), count);
        }
    }
}

/// −m_ij b(i, v), on the four points of both edges because m depends on them.
fn subtract_mollified(
    near: &Near<'_>,
    [edge, partner]: [u32; 2],
    end: u32,
    region: Region,
    mollifier: EdgeEdgeMollifier,
    part: &mut Part,
) {
    let ([a, b], [c, d]) = (near.mesh.edges()[edge as usize], near.mesh.edges()[partner as usize]);
    let end_place = if end == c { 2 } else { 3 };
    // The point of the region is the end; its edge is the first of the four points' edges.
    let place = |k: u8| if k == 0 { end_place } else { k - 1 };
    let region = match region {
        Region::PointPoint(places) => Region::PointPoint(places.map(place)),
        Region::PointEdge(places) => Region::PointEdge(places.map(place)),
        Region::PointTriangle(_) | Region::EdgeEdge(_) => return,
    };
    part.edge_edges.push([a, b, c, d], -near.unit(near.edge_sample(edge)), mollifier, region);
}

#[cfg(test)]
mod tests {
    use super::whole_groups;

    #[test]
    fn groups_are_in_one_part_each_and_none_is_lost() {
        let lengths = [3_u32, 1, 1, 7, 2, 1, 5, 12, 1];
        let groups = (0..).zip(lengths).flat_map(|(group, length)| (0..length).map(move |k| [group, k]));
        let candidates: Vec<[u32; 2]> = groups.collect();
        let count = candidates.len();
        for chunk in 1..=count + 1 {
            let starts = (0..count).step_by(chunk);
            let parts: Vec<_> =
                starts.map(|k| whole_groups(&candidates, k..(k + chunk).min(count))).collect();
            assert_eq!(parts.concat(), candidates);
            let firsts = parts.iter().filter_map(|part| Some([part.first()?[0], part.last()?[0]]));
            let firsts: Vec<[u32; 2]> = firsts.collect();
            assert!(firsts.windows(2).all(|pair| pair[0][1] < pair[1][0]), "a group is split, chunk {chunk}");
        }
    }
}
