//! Which pairs come near: boxes of features on their way, and the pairs of boxes that overlap.
//!
//! A point on its way from x0 to x1 stays in the box that both span; a feature is always the convex hull of its
//! points, so it stays in the union of their boxes. If two features come within 2 r of each other, their boxes,
//! each larger by r on all sides, overlap. Boxes are rounded outwards, so this holds in floating point at any
//! scale.
//!
//! Overlaps are found by a tree with eight children a node and without pointers, one for each kind of feature,
//! that is refitted from question to question. What is found depends on the boxes in double precision alone: not
//! on the order in the tree, its age, or the number of threads.
//!
//! ```
//! use ipc_contact::broad_phase::{BroadPhase, Candidates};
//! use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
//! use mechanics_core::tensor::Vec3;
//!
//! // A triangle, and a loose point that falls past its plane.
//! let x0 = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(0.2, 0.2, 1.0)];
//! let mut builder = CollisionMeshBuilder::new(&x0);
//! builder.add_object(CollisionObject::new(vec![[0, 1, 2]]));
//! builder.add_object(CollisionObject { points: vec![3], ..Default::default() }.with_thickness(0.01));
//! let mesh = builder.build()?;
//! let mut x1 = x0;
//! x1[3].z = -1.0;
//!
//! let (mut broad_phase, mut candidates) = (BroadPhase::new(&mesh), Candidates::default());
//! broad_phase.candidates(&mesh, &x0, &x0, 0.05, &mut candidates)?;
//! assert!(candidates.is_empty(), "they start 1 m apart");
//! broad_phase.candidates(&mesh, &x0, &x1, 0.05, &mut candidates)?;
//! assert_eq!(candidates.point_triangles, [[3, 0]]);
//! # Ok::<(), ipc_contact::ContactError>(())
//! ```
//!
//! # Limits
//! Nodes are in single precision relative to the median of the points. Features much smaller than 10⁻⁷ of their
//! distance from there, or than 10⁻³⁷ m, are found as surely as others, but no faster than by comparing all with
//! all.

mod boxes;
mod pairs;
mod tree;

use crate::collision_mesh::CollisionMesh;
use crate::error::ContactError;
use boxes::Bounds;
use mechanics_core::tensor::Vec3;
use pairs::{Tally, TooMany};
use tree::{LeafGroup, Scope, Tree};

/// Leaf groups of a parallel part of a query.
const CHUNK: usize = 64;
/// Parallel parts of a query at most.
const PARTS: usize = 512;
/// Leaf groups after which a part looks whether there are too many pairs.
const STRETCH: usize = 8;
/// A search for one kind of pairs is given up at this many (512 MB), and so many more for each feature.
const LARGEST_COUNT: usize = 1 << 26;
const LARGEST_COUNT_PER_FEATURE: usize = 64;

/// Pairs of features that may come near, each list ascending, and the boxes for which they were found.
///
/// # Reuse
/// Candidates are good for as long as no point leaves its box: see [`covers`](Self::covers). Found with a larger
/// inflation than needed, they serve a whole line search, or several iterations.
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
    /// The inflated box of every point, by number; those of points that take no part may be anything.
    boxes: Vec<Bounds>,
}

impl Candidates {
    /// Takes in the pairs of others, none of which is among these.
    pub(crate) fn join(&mut self, others: &Self) {
        let lists = [
            (&mut self.point_triangles, &others.point_triangles),
            (&mut self.edge_edges, &others.edge_edges),
            (&mut self.point_edges, &others.point_edges),
            (&mut self.point_points, &others.point_points),
        ];
        for (list, other) in lists {
            list.extend_from_slice(other);
            list.sort_unstable();
        }
    }

    /// How many pairs there are.
    pub fn len(&self) -> usize {
        self.point_triangles.len() + self.edge_edges.len() + self.point_edges.len() + self.point_points.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Do these candidates hold every pair that a new search for the same mesh with these arguments would find?
    ///
    /// True if for each point of the mesh the box of its way from `x0` to `x1`, inflated by `inflation`, is inside
    /// the box for which the candidates were found. Then the box of every feature is inside its former box, and
    /// boxes that overlap now overlapped then. So, if candidates were found for a way from X0 to X1 with the
    /// inflation r + m, they cover every way with the inflation r whose ends are, coordinate by coordinate, at
    /// most m outside that way's box (less a rounding). False if a position or `inflation` is NaN, and before the
    /// first search.
    ///
    /// # Panics
    /// If `x0` or `x1` has not [`CollisionMesh::point_count`] points.
    pub fn covers(&self, mesh: &CollisionMesh, x0: &[Vec3], x1: &[Vec3], inflation: f64) -> bool {
        let count = mesh.point_count();
        assert!(x0.len() == count && x1.len() == count, "the mesh has {count} points");
        let inside = |p: usize| {
            boxes::is_finite(&x0[p])
                && boxes::is_finite(&x1[p])
                && self.boxes[p].contains(&Bounds::of_segment(&x0[p], &x1[p], inflation))
        };
        self.boxes.len() == count && mesh.vertices().iter().all(|&p| inside(p as usize))
    }
}

/// Between which objects pairs are looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Among {
    /// Any two, or one and itself.
    All,
    /// Each and itself.
    Same,
    /// Any two different ones.
    Different,
}

impl Among {
    #[inline(always)]
    fn holds(self, mesh: &CollisionMesh, a: u32, b: u32) -> bool {
        match self {
            Self::All => true,
            Self::Same => mesh.object_of(a) == mesh.object_of(b),
            Self::Different => mesh.object_of(a) != mesh.object_of(b),
        }
    }
}

/// Finds [`Candidates`]; keeps its trees from call to call and refits them.
#[derive(Clone, Debug)]
pub struct BroadPhase {
    /// How many points, edges and triangles the mesh has.
    counts: [usize; 3],
    /// Pairs of one kind at which a search is given up.
    largest_count: usize,
    /// Near the middle of the points.
    origin: [f64; 3],
    points: Tree<1>,
    edges: Tree<2>,
    triangles: Tree<3>,
    loose_points: Tree<1>,
    loose_edges: Tree<2>,
}

impl BroadPhase {
    /// A broad phase for a mesh; trees are built at the first question.
    pub fn new(mesh: &CollisionMesh) -> Self {
        let counts = counts(mesh);
        Self {
            counts,
            largest_count: LARGEST_COUNT + LARGEST_COUNT_PER_FEATURE * counts.iter().sum::<usize>(),
            origin: [0.0; 3],
            points: Tree::default(),
            edges: Tree::default(),
            triangles: Tree::default(),
            loose_points: Tree::default(),
            loose_edges: Tree::default(),
        }
    }

    /// The same, but a search for one kind of pairs is given up where there are more than `largest_count`; 2²⁶ and 64 for each
    /// feature unless said. The memory that a search takes at most is about 32 bytes for each.
    #[must_use]
    pub fn with_largest_count(self, largest_count: usize) -> Self {
        Self { largest_count, ..self }
    }

    /// The pairs of features whose boxes overlap. The box of a feature holds its points all the way along the
    /// straight lines from
    /// `x0` to `x1` \[m\] and is larger by `inflation` \[m\] on every side, so every pair whose distance is
    /// somewhere on the way less than (or equal to) 2 `inflation` is among them, rounding included. With x0 = x1
    /// the question is a static one.
    ///
    /// # Errors
    /// A position of a point of the mesh that is not finite, an inflation that is negative or not finite;
    /// `candidates` is as before. [`ContactError::TooManyCandidates`] if nearly all boxes overlap (positions that have exploded, an inflation as
    /// large as the scene); `candidates` is empty then and covers nothing.
    ///
    /// # Panics
    /// If `x0` or `x1` has not [`CollisionMesh::point_count`] points, or the mesh is not the one this was made for.
    pub fn candidates(
        &mut self,
        mesh: &CollisionMesh,
        x0: &[Vec3],
        x1: &[Vec3],
        inflation: f64,
        candidates: &mut Candidates,
    ) -> Result<(), ContactError> {
        self.candidates_among(Among::All, mesh, [x0, x1], inflation, candidates)
    }

    /// The same for some pairs of objects only.
    pub(crate) fn candidates_among(
        &mut self,
        among: Among,
        mesh: &CollisionMesh,
        [x0, x1]: [&[Vec3]; 2],
        inflation: f64,
        candidates: &mut Candidates,
    ) -> Result<(), ContactError> {
        let count = mesh.point_count();
        assert!(x0.len() == count && x1.len() == count, "the mesh has {count} points");
        boxes::bounds_into(&mut candidates.boxes, mesh.vertices(), x0, x1, inflation)?;
        self.refit(mesh, &candidates.boxes);
        let found = self.search_all(&Filter { mesh, among }, candidates);
        if found.is_err() {
            *candidates = Candidates::default();
        }
        self.counted(found)
    }

    fn search_all(&self, filter: &Filter<'_>, candidates: &mut Candidates) -> Result<(), TooMany> {
        let (points, edges, limit) =
            (filter.mesh.point_count(), filter.mesh.edges().len(), self.largest_count);
        between(filter, &self.points, &self.triangles, points, limit, &mut candidates.point_triangles)?;
        within(filter, &self.edges, edges, limit, &mut candidates.edge_edges)?;
        between(filter, &self.loose_points, &self.loose_edges, points, limit, &mut candidates.point_edges)?;
        within(filter, &self.loose_points, points, limit, &mut candidates.point_points)
    }

    fn counted(&self, found: Result<(), TooMany>) -> Result<(), ContactError> {
        let (limit, features) = (self.largest_count, self.counts.iter().sum());
        found.map_err(|TooMany| ContactError::TooManyCandidates { limit, features })
    }

    /// The edges and triangles (number of the edge, number of the triangle) that may touch by the filters of the
    /// mesh, share no point, and have overlapping boxes at `x` \[m\]; ascending.
    ///
    /// # Errors
    /// A position of a point of the mesh that is not finite; [`ContactError::TooManyCandidates`].
    ///
    /// # Panics
    /// If `x` has not [`CollisionMesh::point_count`] points, or the mesh is not the one this was made for.
    pub fn edge_triangles(
        &mut self,
        mesh: &CollisionMesh,
        x: &[Vec3],
    ) -> Result<Vec<[u32; 2]>, ContactError> {
        assert!(x.len() == mesh.point_count(), "the mesh has {} points", mesh.point_count());
        let mut boxes = Vec::new();
        boxes::bounds_into(&mut boxes, mesh.vertices(), x, x, 0.0)?;
        self.refit(mesh, &boxes);
        let mut pairs = Vec::new();
        let filter = Filter { mesh, among: Among::All };
        let (edges, limit) = (mesh.edges().len(), self.largest_count);
        self.counted(between(&filter, &self.edges, &self.triangles, edges, limit, &mut pairs))?;
        Ok(pairs)
    }

    fn refit(&mut self, mesh: &CollisionMesh, boxes: &[Bounds]) {
        assert!(self.counts == counts(mesh), "this broad phase was made for another mesh");
        // The point in the middle of the order stands for the median, so that the origin follows the points.
        self.origin = match self.points.leaves.get(self.points.leaves.len() / 2) {
            None => middle(mesh.vertices(), boxes),
            Some(group) => boxes[group.corners[0][0] as usize].centre(),
        };
        let origin = &self.origin;
        let edge = |e: u32| (e, mesh.edges()[e as usize]);
        let point = |&p: &u32| (p, [p]);
        refit(&mut self.points, boxes, origin, || mesh.vertices().iter().map(point).collect());
        refit(&mut self.edges, boxes, origin, || (0..mesh.edges().len() as u32).map(edge).collect());
        refit(&mut self.triangles, boxes, origin, || (0..).zip(mesh.triangles().iter().copied()).collect());
        refit(&mut self.loose_points, boxes, origin, || mesh.loose_points().iter().map(point).collect());
        refit(&mut self.loose_edges, boxes, origin, || mesh.loose_edges().iter().map(|&e| edge(e)).collect());
    }
}

fn counts(mesh: &CollisionMesh) -> [usize; 3] {
    [mesh.point_count(), mesh.edges().len(), mesh.triangles().len()]
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

/// The median of the boxes' middles, axis by axis: single precision is finest there, and a stray point does not
/// move it.
fn middle(vertices: &[u32], boxes: &[Bounds]) -> [f64; 3] {
    std::array::from_fn(|k| {
        let mut middles: Vec<f64> = vertices.iter().map(|&p| boxes[p as usize].centre()[k]).collect();
        let half = middles.len() / 2;
        if middles.is_empty() { 0.0 } else { *middles.select_nth_unstable_by(half, f64::total_cmp).1 }
    })
}

/// Which of the overlapping pairs are wanted.
struct Filter<'a> {
    mesh: &'a CollisionMesh,
    among: Among,
}

/// Overwrites `pairs` with the overlapping pairs of features of two trees that may touch, ascending.
fn between<const N: usize, const M: usize>(
    filter: &Filter<'_>,
    a: &Tree<N>,
    b: &Tree<M>,
    rows: usize,
    limit: usize,
    pairs: &mut Vec<[u32; 2]>,
) -> Result<(), TooMany> {
    search(filter, a, b, Scope::Between, rows, limit, pairs)
}

/// Overwrites `pairs` with the overlapping pairs of features of one tree that may touch, lower number first,
/// ascending.
fn within<const N: usize>(
    filter: &Filter<'_>,
    tree: &Tree<N>,
    rows: usize,
    limit: usize,
    pairs: &mut Vec<[u32; 2]>,
) -> Result<(), TooMany> {
    search(filter, tree, tree, Scope::Within, rows, limit, pairs)
}

fn search<const N: usize, const M: usize>(
    filter: &Filter<'_>,
    a: &Tree<N>,
    b: &Tree<M>,
    scope: Scope,
    rows: usize,
    limit: usize,
    pairs: &mut Vec<[u32; 2]>,
) -> Result<(), TooMany> {
    let count = if b.leaves.is_empty() { 0 } else { a.leaves.len() };
    let chunk = CHUNK.max(count.div_ceil(PARTS));
    let tally = Tally::new(limit);
    pairs::ascending_into(pairs, rows, count.div_ceil(chunk), &tally, |part, found| {
        let end = ((part + 1) * chunk).min(count);
        for first in (part * chunk..end).step_by(STRETCH) {
            if tally.is_over() {
                return;
            }
            let before = found.len();
            let groups = first..(first + STRETCH).min(end);
            a.overlaps(groups, b, scope, |g: &LeafGroup<N>, i, h: &LeafGroup<M>, j| {
                let (a, b) = (&g.corners[i], &h.corners[j]);
                if filter.among.holds(filter.mesh, a[0], b[0]) && filter.mesh.features_may_touch(a, b) {
                    let [m, n] = [g.numbers[i], h.numbers[j]];
                    let swapped = scope == Scope::Within && n < m;
                    found.push(if swapped { [n, m] } else { [m, n] });
                }
            });
            tally.add(found.len() - before);
        }
    })
}
