//! Does anything intersect? Decided exactly on the f64 positions, by a way that shares nothing with distances, barrier and
//! continuous collision detection, and so can check them.
//!
//! Two features *intersect* if they share a point: touching is intersecting. Segments and triangles are closed sets,
//! possibly degenerate (an edge of zero length is a point, a triangle of zero area a segment or a point). Surfaces
//! intersect exactly if an edge of one meets a triangle of the other; loose segments and points, which belong to no
//! triangle, are tested among each other as well. The pairs looked at are the ones the mesh lets touch
//! ([`CollisionMesh::features_may_touch`]): features that share a point are skipped, as always in this
//! crate, because they always touch there. (So two triangles folded flat onto each other about a common edge go unseen
//! until a neighbour meets them.)
//!
//! ```
//! use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
//! use ipc_contact::intersection;
//! use mechanics_core::tensor::Vec3;
//!
//! // A triangle and a segment that pierces it.
//! let x = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.2, -1.0], [0.2, 0.2, 1.0]].map(Vec3::from);
//! let mut builder = CollisionMeshBuilder::new(&x);
//! builder.add_object(CollisionObject { triangles: vec![[0, 1, 2]], ..Default::default() });
//! builder.add_object(CollisionObject { segments: vec![[3, 4]], ..Default::default() }.with_thickness(1e-3));
//! let found = intersection::check(&builder.build()?, &x)?;
//!
//! assert_eq!(found[0].to_string(), "edge 3 (points 3, 4) of object 1 meets triangle 0 (points 0, 1, 2) of object 0");
//! # Ok::<(), ipc_contact::ContactError>(())
//! ```
//!
//! # What it cannot see
//! A sheet that has passed right through another: both configurations are free of intersections. See [`crate::topology`].
//!
//! # Cost
//! O(n log n) for n features with O(n) overlapping boxes; two stacked sheets of 40,000 triangles in all take about 40 ms
//! on one core.

mod meeting;
mod predicates;
mod tree;
mod wide;

pub use meeting::{segment_meets_triangle, segments_meet};
pub(crate) use predicates::{Projection, orientation};

use crate::ContactError;
use crate::collision_mesh::{CollisionMesh, Feature};
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;
use predicates::{PlaneFilter, exact_orientation};
use std::ops::ControlFlow;
use tree::{Bounds, BoxTree};

/// Blocks of a tree that one task looks at.
const CHUNK: usize = 64;
/// Blocks after which a search that may stop early asks whether it may.
const ROUND: usize = 16 * CHUNK;

/// A feature with its points and its object, for a reader who does not know how edges are numbered.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Place {
    /// The feature.
    pub feature: Feature,
    /// Its points; none for a half-space.
    pub points: Vec<u32>,
    /// The object it belongs to; none for a half-space.
    pub object: Option<u32>,
}

impl Place {
    pub(crate) fn new(mesh: &CollisionMesh, feature: Feature, points: &[u32]) -> Self {
        let object = points.first().map(|&p| mesh.object_of(p));
        Self { feature, points: points.to_vec(), object }
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.feature)?;
        if let [_, _, ..] = self.points.as_slice() {
            let points: Vec<String> = self.points.iter().map(u32::to_string).collect();
            write!(f, " (points {})", points.join(", "))?;
        }
        self.object.map_or(Ok(()), |object| write!(f, " of object {object}"))
    }
}

/// Two features that share a point, or a point on or beyond the boundary of a half-space.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Intersection {
    /// The feature of lower dimension: a point or an edge.
    pub first: Place,
    /// The other: a point, an edge, a triangle or a half-space.
    pub second: Place,
}

impl std::fmt::Display for Intersection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} meets {}", self.first, self.second)
    }
}

/// All intersections at the positions `x`, in ascending order; empty if there are none.
///
/// Exact for all finite positions, of whatever size. The result does not depend on the number of threads.
///
/// # Errors
/// [`ContactError::NonFinite`] names the first point of the mesh whose position is infinite or NaN.
///
/// # Panics
/// If `x` has not as many points as the mesh.
pub fn check(mesh: &CollisionMesh, x: &[Vec3]) -> Result<Vec<Intersection>, ContactError> {
    let search = Search::new(mesh, x)?;
    let mut found = search.half_spaces();
    for task in search.tasks() {
        let parts = parallel::map_chunks(task.block_count(), CHUNK, |blocks| {
            let mut part = Vec::new();
            for block in blocks {
                // Always goes on: every pair is wanted.
                let _ = search.block(&task, block, &mut |pair| {
                    part.push(pair);
                    ControlFlow::Continue(())
                });
            }
            part
        });
        found.extend(parts.into_iter().flatten());
    }
    found.sort_unstable();
    Ok(found)
}

/// Whether anything intersects at the positions `x`: as [`check`], but stops soon after the first pair.
///
/// # Errors
/// As [`check`].
///
/// # Panics
/// As [`check`].
pub fn intersects(mesh: &CollisionMesh, x: &[Vec3]) -> Result<bool, ContactError> {
    let search = Search::new(mesh, x)?;
    if !search.half_spaces().is_empty() {
        return Ok(true);
    }
    let meets = |task: &Task, block| search.block(task, block, &mut |_| ControlFlow::Break(())).is_break();
    Ok(search.tasks().any(|task| {
        (0..task.block_count()).step_by(ROUND).any(|first| {
            let count = ROUND.min(task.block_count() - first);
            let found =
                parallel::map_chunks(count, CHUNK, |mut blocks| blocks.any(|k| meets(&task, first + k)));
            found.contains(&true)
        })
    }))
}

/// An edge, or a point as an edge of no length.
#[derive(Clone, Copy, Debug)]
struct Segment {
    feature: Feature,
    ends: [u32; 2],
}

/// A mesh and where its points are.
struct Search<'a> {
    mesh: &'a CollisionMesh,
    x: &'a [Vec3],
}

/// What is looked for in what.
enum Task {
    /// Each triangle against each edge and loose point.
    Triangles { tree: BoxTree, segments: Vec<Segment>, others: BoxTree },
    /// Loose edges and points against each other.
    Segments { tree: BoxTree, segments: Vec<Segment> },
}

impl Task {
    fn block_count(&self) -> usize {
        match self {
            Self::Triangles { tree, .. } | Self::Segments { tree, .. } => tree.block_count(),
        }
    }
}

impl<'a> Search<'a> {
    fn new(mesh: &'a CollisionMesh, x: &'a [Vec3]) -> Result<Self, ContactError> {
        assert_eq!(x.len(), mesh.point_count(), "as many positions as points of the collision mesh");
        let wrong = mesh.vertices().iter().find(|&&p| x[p as usize].iter().any(|c| !c.is_finite()));
        match wrong {
            Some(&p) => Err(ContactError::NonFinite { point: p as usize, position: x[p as usize].into() }),
            None => Ok(Self { mesh, x }),
        }
    }

    fn positions<const N: usize>(&self, points: [u32; N]) -> [&'a Vec3; N] {
        points.map(|p| &self.x[p as usize])
    }

    fn half_spaces(&self) -> Vec<Intersection> {
        let mut found = Vec::new();
        for (h, half_space) in self.mesh.half_spaces().iter().enumerate() {
            let meets = |&&p: &&u32| {
                let side =
                    || predicates::side_of_plane(&half_space.normal, half_space.offset, &self.x[p as usize]);
                self.mesh.may_touch_half_space(h as u32, p) && side() <= 0
            };
            found.extend(self.mesh.vertices().iter().filter(meets).map(|&p| Intersection {
                first: Place::new(self.mesh, Feature::Point(p), &[p]),
                second: Place::new(self.mesh, Feature::HalfSpace(h as u32), &[]),
            }));
        }
        found
    }

    fn tree(&self, segments: &[Segment]) -> BoxTree {
        let bounds: Vec<Bounds> = segments.iter().map(|s| Bounds::around(self.positions(s.ends))).collect();
        BoxTree::new(&bounds)
    }

    fn tasks(&self) -> impl Iterator<Item = Task> {
        let triangles = (!self.mesh.triangles().is_empty()).then(|| {
            let segments = self.segments(0..self.mesh.edges().len() as u32);
            let bounds = |t: &[u32; 3]| Bounds::around(self.positions(*t));
            let corners = || BoxTree::new(&self.mesh.triangles().iter().map(bounds).collect::<Vec<_>>());
            let (tree, others) = parallel::join(corners, || self.tree(&segments));
            Task::Triangles { tree, segments, others }
        });
        let loose = self.segments(self.mesh.loose_edges().iter().copied());
        let loose = (!loose.is_empty()).then(|| Task::Segments { tree: self.tree(&loose), segments: loose });
        triangles.into_iter().chain(loose)
    }

    /// The given edges and all loose points.
    fn segments(&self, edges: impl Iterator<Item = u32>) -> Vec<Segment> {
        let edge = |e| Segment { feature: Feature::Edge(e), ends: self.mesh.edges()[e as usize] };
        let point = |&p| Segment { feature: Feature::Point(p), ends: [p, p] };
        edges.map(edge).chain(self.mesh.loose_points().iter().map(point)).collect()
    }

    /// Calls `report` for each intersection of an item in a block of the task's tree.
    fn block(
        &self,
        task: &Task,
        block: usize,
        report: &mut impl FnMut(Intersection) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        match task {
            Task::Triangles { tree, segments, others } => {
                let items = tree.items(block);
                let planes: [PlaneFilter; tree::WIDTH] = std::array::from_fn(|k| {
                    let t = items[k.min(items.len() - 1)] as usize;
                    PlaneFilter::new(self.positions(self.mesh.triangles()[t]))
                });
                tree.pairs_of_block(block, others, &mut |k, s| {
                    let segment = segments[s as usize];
                    if self.segment_meets_triangle(segment, items[k], &planes[k]) {
                        report(self.pair_with_triangle(segment, items[k]))?;
                    }
                    ControlFlow::Continue(())
                })
            }
            Task::Segments { tree, segments } => tree.pairs_of_block(block, tree, &mut |k, j| {
                let i = tree.items(block)[k];
                let (first, second) = (segments[i as usize], segments[j as usize]);
                if i < j && self.segments_meet(first, second) {
                    report(self.pair(first, second))?;
                }
                ControlFlow::Continue(())
            }),
        }
    }

    #[inline]
    fn segment_meets_triangle(&self, segment: Segment, t: u32, plane: &PlaneFilter) -> bool {
        let [p, q] = self.positions(segment.ends);
        let sides = (plane.side(p), plane.side(q));
        if let (Some(first), Some(second)) = sides
            && first == second
        {
            return false;
        }
        let points = self.mesh.triangles()[t as usize];
        if !self.mesh.features_may_touch(&segment.ends, &points) {
            return false;
        }
        let [a, b, c] = self.positions(points);
        let exact = |side: Option<i8>, p| side.unwrap_or_else(|| exact_orientation(a, b, c, p));
        meeting::segment_meets_triangle_given_sides((exact(sides.0, p), exact(sides.1, q)), [p, q], [a, b, c])
    }

    fn segments_meet(&self, first: Segment, second: Segment) -> bool {
        self.mesh.features_may_touch(&first.ends, &second.ends)
            && segments_meet(self.positions(first.ends), self.positions(second.ends))
    }

    fn place(&self, segment: Segment) -> Place {
        match segment.feature {
            Feature::Point(p) => Place::new(self.mesh, segment.feature, &[p]),
            _ => Place::new(self.mesh, segment.feature, &segment.ends),
        }
    }

    fn pair_with_triangle(&self, segment: Segment, t: u32) -> Intersection {
        let points = &self.mesh.triangles()[t as usize];
        Intersection {
            first: self.place(segment),
            second: Place::new(self.mesh, Feature::Triangle(t), points),
        }
    }

    fn pair(&self, first: Segment, second: Segment) -> Intersection {
        let (first, second) = (self.place(first), self.place(second));
        if first.feature <= second.feature {
            Intersection { first, second }
        } else {
            Intersection { first: second, second: first }
        }
    }
}
