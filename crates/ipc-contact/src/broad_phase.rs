//! Which pairs come near: boxes of features on their way, and the pairs of boxes that overlap.

mod boxes;
mod tree;

use crate::collision_mesh::CollisionMesh;
use crate::error::ContactError;
use boxes::Bounds;
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;
use tree::{LeafGroup, Tree};

/// Leaf groups of a parallel part of a query.
const CHUNK: usize = 64;

/// Pairs of features that may come near, each list ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Candidates {
    /// Numbers of a point and of a triangle.
    pub point_triangles: Vec<[u32; 2]>,
    /// Numbers of two edges, lower first.
    pub edge_edges: Vec<[u32; 2]>,
    /// Numbers of a loose point and of a loose edge.
    pub point_edges: Vec<[u32; 2]>,
    /// Numbers of two loose points, lower first.
    pub point_points: Vec<[u32; 2]>,
}

impl Candidates {
    /// How many pairs there are.
    pub fn len(&self) -> usize {
        self.point_triangles.len() + self.edge_edges.len() + self.point_edges.len() + self.point_points.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Finds [`Candidates`]; keeps its trees from call to call and refits them.
#[derive(Clone, Debug, Default)]
pub struct BroadPhase {
    boxes: Vec<Bounds>,
    /// Near the middle of the points when the trees were built.
    origin: [f64; 3],
    points: Tree<1>,
    edges: Tree<2>,
    triangles: Tree<3>,
    loose_points: Tree<1>,
    loose_edges: Tree<2>,
}

impl BroadPhase {
    /// A broad phase for a mesh; all work is left to the first question.
    pub fn new(_mesh: &CollisionMesh) -> Self {
        Self::default()
    }

    /// The pairs of features whose boxes overlap. The box of a feature holds its points all the way along the straight lines from
    /// `x0` to `x1` \[m\] and is larger by `inflation` \[m\] on every side, so every pair whose distance is somewhere on the way
    /// less than (or equal to) 2 `inflation` is among them, rounding included. With x0 = x1 the question is a static one.
    ///
    /// # Errors
    /// A position of a point of the mesh that is not finite, an inflation that is negative or not finite; `candidates` is as before.
    ///
    /// # Panics
    /// If `x0` or `x1` has not [`CollisionMesh::point_count`] points.
    pub fn candidates(
        &mut self,
        mesh: &CollisionMesh,
        x0: &[Vec3],
        x1: &[Vec3],
        inflation: f64,
        candidates: &mut Candidates,
    ) -> Result<(), ContactError> {
        let count = mesh.point_count();
        assert!(x0.len() == count && x1.len() == count, "the mesh has {count} points");
        boxes::bounds_into(&mut self.boxes, mesh.vertices(), x0, x1, inflation)?;
        self.refit(mesh);
        candidates.point_triangles = between(mesh, &self.points, &self.triangles);
        candidates.edge_edges = within(mesh, &self.edges);
        candidates.point_edges = between(mesh, &self.loose_points, &self.loose_edges);
        candidates.point_points = within(mesh, &self.loose_points);
        Ok(())
    }

    /// The edges and triangles (number of the edge, number of the triangle) that may touch by the filters of the mesh, share
    /// no point, and have overlapping boxes at `x` \[m\]; ascending.
    ///
    /// # Errors
    /// A position of a point of the mesh that is not finite.
    ///
    /// # Panics
    /// If `x` has not [`CollisionMesh::point_count`] points.
    pub fn edge_triangles(
        &mut self,
        mesh: &CollisionMesh,
        x: &[Vec3],
    ) -> Result<Vec<[u32; 2]>, ContactError> {
        assert!(x.len() == mesh.point_count(), "the mesh has {} points", mesh.point_count());
        boxes::bounds_into(&mut self.boxes, mesh.vertices(), x, x, 0.0)?;
        self.refit(mesh);
        Ok(between(mesh, &self.edges, &self.triangles))
    }

    fn refit(&mut self, mesh: &CollisionMesh) {
        if self.edges.leaves.is_empty() && self.points.leaves.is_empty() {
            self.origin = middle(mesh.vertices(), &self.boxes);
        }
        let Self { boxes, origin, .. } = self;
        let edge = |e: u32| (e, mesh.edges()[e as usize]);
        let point = |&p: &u32| (p, [p]);
        refit(&mut self.points, boxes, origin, || mesh.vertices().iter().map(point).collect());
        refit(&mut self.edges, boxes, origin, || (0..mesh.edges().len() as u32).map(edge).collect());
        refit(&mut self.triangles, boxes, origin, || (0..).zip(mesh.triangles().iter().copied()).collect());
        refit(&mut self.loose_points, boxes, origin, || mesh.loose_points().iter().map(point).collect());
        refit(&mut self.loose_edges, boxes, origin, || mesh.loose_edges().iter().map(|&e| edge(e)).collect());
    }
}

/// Refits a tree; builds it anew if there is none, or if the features have moved so that its order no longer fits.
fn refit<const N: usize>(
    tree: &mut Tree<N>,
    boxes: &[Bounds],
    origin: &[f64; 3],
    features: impl Fn() -> Vec<(u32, [u32; N])>,
) {
    tree.refit(boxes, origin);
    if tree.leaves.is_empty() || tree.has_degraded() {
        *tree = Tree::build(&features(), boxes, origin);
    }
}

/// The median of the boxes' middles, axis by axis: single precision is finest there, and a stray point does not move it.
fn middle(vertices: &[u32], boxes: &[Bounds]) -> [f64; 3] {
    std::array::from_fn(|k| {
        let mut middles: Vec<f64> = vertices.iter().map(|&p| boxes[p as usize].centre()[k]).collect();
        let half = middles.len() / 2;
        if middles.is_empty() { 0.0 } else { *middles.select_nth_unstable_by(half, f64::total_cmp).1 }
    })
}

/// Overlapping pairs of features of two trees, ascending.
fn between<const N: usize, const M: usize>(mesh: &CollisionMesh, a: &Tree<N>, b: &Tree<M>) -> Vec<[u32; 2]> {
    if b.leaves.is_empty() {
        return Vec::new();
    }
    let parts = parallel::map_chunks(a.leaves.len(), CHUNK, |groups| {
        let mut pairs = Vec::new();
        a.overlaps_with(groups, b, |g: &LeafGroup<N>, i, h: &LeafGroup<M>, j| {
            if mesh.features_may_touch(&g.corners[i], &h.corners[j]) {
                pairs.push([g.numbers[i], h.numbers[j]]);
            }
        });
        pairs
    });
    ascending(parts)
}

/// Overlapping pairs of features of one tree, ascending.
fn within<const N: usize>(mesh: &CollisionMesh, tree: &Tree<N>) -> Vec<[u32; 2]> {
    let parts = parallel::map_chunks(tree.leaves.len(), CHUNK, |groups| {
        let mut pairs = Vec::new();
        tree.overlaps_within(groups, |g, i, h, j| {
            if mesh.features_may_touch(&g.corners[i], &h.corners[j]) {
                let (a, b) = (g.numbers[i], h.numbers[j]);
                pairs.push([a.min(b), a.max(b)]);
            }
        });
        pairs
    });
    ascending(parts)
}

fn ascending(parts: Vec<Vec<[u32; 2]>>) -> Vec<[u32; 2]> {
    let mut pairs = parts.concat();
    pairs.sort_unstable();
    pairs
}
