//! Which closest features are active, with which weight: the pairs that a barrier sums over.
//!
//! Each candidate point–triangle and edge–edge pair is put down to its closest features ([`Region`]): point–point,
//! point–edge, point–triangle or edge–edge. It is *active* where its squared distance s is below the activation ŝ. Several
//! candidates that meet in the same features (a point next to an edge that two triangles share) become one pair
//! with the sum of their weights. Edge–edge pairs whose [mollifier](EdgeEdgeMollifier) is below one
//! keep all four points whatever their closest features are, because the factor depends on all four.
//!
//! # Weights
//! [`Weighting::Unit`] is the barrier of Li et al. 2020: a sum over all candidates, so a pair's weight is how many
//! candidates meet in it.
//!
//! [`Weighting::Area`] is a quadrature of the potential ½ ∫ max over y of b(d(x, y)) dx over both surfaces, whose force
//! converges under refinement (Li et al. 2023). The maximum over a neighbourhood of triangles is written with sums, so that
//! it stays smooth: with each sum taken over the triangles t, their edges e and corners v that are active for a point p,
//!
//! max ≈ Σ_t b(p, t) − Σ_e (m_e − 1) b(p, e) + Σ_v c_v b(p, v), c_v = 1 − [n_v − Σ_{e ∋ v} (m_e − 1)],
//!
//! where m_e of these triangles share the edge e and n_v the corner v. For p over a triangle, edge or corner whose neighbours
//! are not active otherwise, the sum is exactly one b, whatever the mesh: the coefficients are those of inclusion and
//! exclusion. An active edge or corner has all its triangles active, so m and n are numbers of the mesh, less those triangles
//! that the filters take out; counting them among the active ones makes the sum right next to filtered pairs, too.
//! Likewise for an edge i and the edges j, with ends v,
//!
//! max ≈ Σ_j m_ij b(i, j) − Σ_v (Σ_{j ∋ v} m_ij − 1) b(i, v), over ends v that two or more active edges share.
//!
//! The mollifier m_ij stands in both sums. (With m in the first sum only, as published, stacked meshes with
//! parallel edges can have a negative coefficient in all, and an energy that is not bounded below.) For equal
//! meshes exactly on each other, where every edge's parallel partner is switched off, the edges' sum is twice the
//! integral.
//!
//! Each candidate stands for a part of the area: a point for its [`point_area`](CollisionMesh::point_area)/4 (½ of
//! the potential, ½ because points and edges are two quadratures of the same integral) or half of it for a loose
//! point, which has no edges; an edge–edge pair for the sum of both [`edge_area`](CollisionMesh::edge_area)s over
//! 4; a pair of loose points for the half of the sum of areas; a point and a half-space for all of the point's
//! area, both sides being the same integral.
//!
//! A weight may be negative. Pairs whose weights sum to exactly zero are left out; counts are integers per sampled feature
//! until the end, so that what should cancel does.
//!
//! # Order
//! Point–points and point–edges ascend by their points, lower first within a pair or edge. Point–triangles and edge–edges
//! are in the order of the candidates. The result has the same bits for any number of threads.
//!
//! # Reference
//! M. Li et al., *Incremental Potential Contact*, ACM Trans. Graph. 39(4), 2020. M. Li, Z. Ferguson, T. Schneider, T. Langlois,
//! D. Zorin, D. Panozzo, C. Jiang, D. M. Kaufman, *Convergent Incremental Potential Contact*, arXiv 2307.15908, 2023.

mod cull;
mod maximum;
mod merge;
mod narrow;

use crate::broad_phase::Candidates;
use crate::collision_mesh::CollisionMesh;
use crate::distance::{EdgeEdgeMollifier, Region};
use mechanics_core::tensor::Vec3;

/// How much each candidate counts. See the [module](self) page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weighting {
    /// One each.
    #[default]
    Unit,
    /// Rest areas \[m²\], with the improved maximum operator.
    Area,
}

/// Pairs with `N` points each.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPairs<const N: usize> {
    /// Numbers of the points.
    pub points: Vec<[u32; N]>,
    /// One for each: dimensionless or m², see [`Weighting`].
    pub weights: Vec<f64>,
}

impl<const N: usize> Default for ContactPairs<N> {
    fn default() -> Self {
        Self { points: Vec::new(), weights: Vec::new() }
    }
}

impl<const N: usize> ContactPairs<N> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    fn push(&mut self, points: [u32; N], weight: f64) {
        self.points.push(points);
        self.weights.push(weight);
    }

    fn clear(&mut self) {
        self.points.clear();
        self.weights.clear();
    }

    fn append(&mut self, other: &mut Self) {
        self.points.append(&mut other.points);
        self.weights.append(&mut other.weights);
    }
}

/// Pairs of two edges: interiors that are closest, and nearly parallel edges whatever is closest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgeEdgeContacts {
    /// Numbers of the points, first edge first.
    pub points: Vec<[u32; 4]>,
    /// One for each: dimensionless or m², see [`Weighting`].
    pub weights: Vec<f64>,
    /// The mollifier of each; one for edges that are not nearly parallel.
    pub mollifiers: Vec<EdgeEdgeMollifier>,
    /// Whose squared distance each stands for, by the places of its points: both edges' interiors for all but nearly
    /// parallel ones.
    ///
    /// A pair with a negative weight is the distance of one edge's end to the other edge, times the mollifier of the
    /// pair; the two edges may be closer than that.
    pub regions: Vec<Region>,
}

impl EdgeEdgeContacts {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    fn push(&mut self, points: [u32; 4], weight: f64, mollifier: EdgeEdgeMollifier, region: Region) {
        self.points.push(points);
        self.weights.push(weight);
        self.mollifiers.push(mollifier);
        self.regions.push(region);
    }

    fn clear(&mut self) {
        self.points.clear();
        self.weights.clear();
        self.mollifiers.clear();
        self.regions.clear();
    }

    fn append(&mut self, other: &mut Self) {
        self.points.append(&mut other.points);
        self.weights.append(&mut other.weights);
        self.mollifiers.append(&mut other.mollifiers);
        self.regions.append(&mut other.regions);
    }
}

/// The active pairs at given positions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactSet {
    /// Points near a half-space; those behind its plane are among them.
    pub half_spaces: ContactPairs<1>,
    /// The half-space of each of them.
    pub half_space_numbers: Vec<u32>,
    /// Pairs of points, lower first.
    pub point_points: ContactPairs<2>,
    /// A point and the interior of an edge, lower end first.
    pub point_edges: ContactPairs<3>,
    /// A point and the interior of a triangle.
    pub point_triangles: ContactPairs<4>,
    /// The interiors of two edges, and nearly parallel edges with their mollifiers.
    pub edge_edges: EdgeEdgeContacts,
    /// The smallest of all their squared distances \[m²\].
    smallest: Option<f64>,
}

impl ContactSet {
    /// The active pairs among `candidates` at the positions `x` \[m\]: those with s < `activation_squared` \[m²\].
    ///
    /// A pair whose distance is NaN is active, so that the NaN shows in the energy. Candidates must hold every pair that can be
    /// active; more do no harm.
    ///
    /// # Panics
    /// If `x` has not as many points as the mesh.
    pub fn new(
        mesh: &CollisionMesh,
        candidates: &Candidates,
        x: &[Vec3],
        activation_squared: f64,
        weighting: Weighting,
    ) -> Self {
        let mut set = Self::default();
        set.rebuild(mesh, candidates, x, activation_squared, weighting);
        set
    }

    /// The same, in the memory of an older set.
    ///
    /// # Panics
    /// If `x` has not as many points as the mesh.
    pub fn rebuild(
        &mut self,
        mesh: &CollisionMesh,
        candidates: &Candidates,
        x: &[Vec3],
        activation_squared: f64,
        weighting: Weighting,
    ) {
        assert_eq!(x.len(), mesh.point_count(), "positions and mesh have different numbers of points");
        self.clear();
        let near = narrow::Near { mesh, x, activation_squared, weighting };
        let mut parts = narrow::mesh_pairs(&near, candidates);
        if weighting == Weighting::Area {
            parts.push(maximum::subtracted_edge_ends(&near, &parts));
        }
        self.collect(&near, parts);
        self.add_half_spaces(&near);
    }

    /// How many active pairs there are.
    pub fn len(&self) -> usize {
        self.half_spaces.len()
            + self.point_points.len()
            + self.point_edges.len()
            + self.point_triangles.len()
            + self.edge_edges.len()
    }

    /// Is nothing active?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The smallest squared distance among the active pairs \[m²\], NaN if any is; `None` if there are none.
    pub fn smallest_squared_distance(&self) -> Option<f64> {
        self.smallest
    }

    fn clear(&mut self) {
        self.half_spaces.clear();
        self.half_space_numbers.clear();
        self.point_points.clear();
        self.point_edges.clear();
        self.point_triangles.clear();
        self.edge_edges.clear();
        self.smallest = None;
    }

    /// Puts the parts together in their order and merges what several of them hold.
    fn collect(&mut self, near: &narrow::Near<'_>, parts: Vec<narrow::Part>) {
        let (mut point_points, mut point_edges) = (Vec::new(), Vec::new());
        for mut part in parts {
            self.point_triangles.append(&mut part.point_triangles);
            self.edge_edges.append(&mut part.edge_edges);
            point_points.append(&mut part.point_points);
            point_edges.append(&mut part.point_edges);
            self.note(part.smallest);
        }
        merge::merge_into(near, point_points, &mut self.point_points);
        merge::merge_into(near, point_edges, &mut self.point_edges);
    }

    fn add_half_spaces(&mut self, near: &narrow::Near<'_>) {
        for (number, half_space) in (0..).zip(near.mesh.half_spaces()) {
            let distances = near.half_space_distances(number, half_space);
            for (point, distance) in distances.into_iter().flatten() {
                self.half_spaces.push([point], near.half_space_weight(point));
                self.half_space_numbers.push(number);
                // Behind the plane nothing is left; NaN stays NaN.
                self.note(if distance <= 0.0 { 0.0 } else { distance * distance });
            }
        }
    }

    /// Takes a squared distance into account; infinity stands for none.
    fn note(&mut self, squared: f64) {
        if squared != f64::INFINITY {
            self.smallest = Some(narrow::smaller(self.smallest.unwrap_or(squared), squared));
        }
    }
}
