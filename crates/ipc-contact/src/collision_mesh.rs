//! What may touch: triangles, segments and single points of one or more objects, and which of them may not.
//!
//! A mesh is stated to a [`CollisionMeshBuilder`], which checks it:
//!
//! ```
//! use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject, HalfSpace};
//! use mechanics_core::mesh::{BoxSplit, block};
//! use mechanics_core::tensor::Vec3;
//!
//! // A cube of tetrahedra (points 0 to 26), a knife above it (points 27 and 28), and a floor.
//! let cube = block(&Vec3::zeros(), &Vec3::new(1.0, 1.0, 1.0), [2, 2, 2], BoxSplit::Six)?;
//! let mut rest = cube.points().to_vec();
//! rest.extend([Vec3::new(-0.5, 0.5, 1.2), Vec3::new(1.5, 0.5, 1.2)]);
//!
//! let mut builder = CollisionMeshBuilder::new(&rest);
//! builder.add_object(CollisionObject::of_tets(&cube, 0)?);
//! let knife = CollisionObject { segments: vec![[27, 28]], ..Default::default() };
//! builder.add_object(knife.with_thickness(1e-3));
//! builder.add_half_space(HalfSpace::through(&Vec3::new(0.0, 0.0, -0.1), &Vec3::z()));
//! builder.script_points([27, 28]);
//! let mesh = builder.build()?;
//!
//! assert_eq!((mesh.triangles().len(), mesh.edges().len(), mesh.vertices().len()), (48, 73, 28));
//! assert!(mesh.may_touch(0, 27) && !mesh.may_touch(27, 28));
//! let area: f64 = mesh.vertices().iter().map(|&p| mesh.point_area(p)).sum();
//! assert!((area - 6.002).abs() < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod build;
mod object;

pub use build::CollisionMeshBuilder;
pub use object::{CollisionObject, Groups, HalfSpace, SelfContact};

use mechanics_core::tensor::Vec3;

/// The object of points that take no part.
const NO_OBJECT: u32 = u32::MAX;

/// A feature of a collision mesh, by its number in the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Feature {
    /// Point, by its number among all points.
    Point(u32),
    /// Edge.
    Edge(u32),
    /// Triangle.
    Triangle(u32),
    /// Analytic half-space.
    HalfSpace(u32),
}

impl std::fmt::Display for Feature {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Point(n) => write!(f, "point {n}"),
            Self::Edge(n) => write!(f, "edge {n}"),
            Self::Triangle(n) => write!(f, "triangle {n}"),
            Self::HalfSpace(n) => write!(f, "half-space {n}"),
        }
    }
}

/// The features of all objects that may touch, over the points of the incremental potential.
///
/// Numbers of points are those of the potential's `x`; the points of a mesh need not be all of them. Every feature
/// belongs to one object; triangles are numbered object after object, in the order they were given. Guaranteed by
/// [`CollisionMeshBuilder::build`]: numbers in range, different points within a feature, no feature twice, finite
/// rest positions, positive rest areas.
///
/// # Which pairs are asked about
/// Two features may touch if they share no point and no [joined](CollisionMeshBuilder::join_points) points, if not
/// all of their points are scripted, and if their objects' groups, excluded pairs and self-contact allow it. The
/// pairs that the distance between two meshes needs, and no more: each point and each triangle, each two edges,
/// each loose point and each loose edge, each two loose points. The distance of every other pair is that of one of
/// these: the distance from a loose point to a triangle's edge, for instance, is not less than that to the
/// triangle.
///
/// # Rest areas
/// The area-weighted barrier asks how much area a feature stands for, so that the sum over points and the sum over
/// edges are each the area of the surface: a point stands for a third of its triangles, an edge for a third of its
/// triangles. A loose segment of length l in an object of thickness t stands for l t, each of its ends for l t /
/// 2; a loose point for t².
#[derive(Clone, Debug)]
pub struct CollisionMesh {
    /// Rest positions.
    rest: Vec<Vec3>,
    /// Points that take part, ascending.
    vertices: Vec<u32>,
    /// Edges of triangles and segments, lower point first, ascending, each once.
    edges: Vec<[u32; 2]>,
    triangles: Vec<[u32; 3]>,
    /// Edge k joins corners k and k + 1 (mod 3).
    triangle_edges: Vec<[u32; 3]>,
    loose_edges: Vec<u32>,
    loose_points: Vec<u32>,
    /// Per point: the object it belongs to, or `NO_OBJECT`.
    object_of_point: Vec<u32>,
    /// Per point: has it no unknowns?
    scripted: Vec<bool>,
    /// Pairs of points that count as one, both ways round, ascending.
    joined: Vec<[u32; 2]>,
    half_spaces: Vec<HalfSpace>,
    /// Half-space and object, ascending.
    excluded_half_spaces: Vec<[u32; 2]>,
    objects: Objects,
    filters: Filters,
    /// Per point (m²), per edge (m²): rest areas.
    point_area: Vec<f64>,
    edge_area: Vec<f64>,
}

/// Is there anything that keeps features apart which share no point?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Filters {
    None,
    Some,
}

/// Filters by object.
#[derive(Clone, Debug)]
struct Objects {
    self_contact: Vec<SelfContact>,
    groups: Vec<Groups>,
    /// Pairs of different objects, lower first, ascending.
    excluded: Vec<[u32; 2]>,
}

impl Objects {
    #[inline]
    fn may_touch(&self, a: u32, b: u32) -> bool {
        if a == b {
            return self.self_contact[a as usize] == SelfContact::Allowed;
        }
        self.groups[a as usize].may_touch(self.groups[b as usize])
            && (self.excluded.is_empty() || self.excluded.binary_search(&sorted([a, b])).is_err())
    }
}

impl CollisionMesh {
    /// How many points the potential has; numbers of points are below it.
    pub fn point_count(&self) -> usize {
        self.rest.len()
    }

    /// Points that take part, ascending.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Edges of triangles and loose segments, lower point first, ascending, each once.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// Triangles, as they were given, object after object.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The edges of each triangle: edge k joins its corners k and k + 1 (mod 3).
    pub fn triangle_edges(&self) -> &[[u32; 3]] {
        &self.triangle_edges
    }

    /// Numbers of the edges that belong to no triangle, ascending.
    pub fn loose_edges(&self) -> &[u32] {
        &self.loose_edges
    }

    /// Points that belong to no edge, ascending.
    pub fn loose_points(&self) -> &[u32] {
        &self.loose_points
    }

    /// Half-spaces that points are kept out of.
    pub fn half_spaces(&self) -> &[HalfSpace] {
        &self.half_spaces
    }

    /// How many objects there are.
    pub fn object_count(&self) -> usize {
        self.objects.groups.len()
    }

    /// The object that a point belongs to.
    ///
    /// # Panics
    /// If the point takes no part: it is not among [`vertices`](Self::vertices).
    pub fn object_of(&self, point: u32) -> u32 {
        let object = self.object_of_point[point as usize];
        assert!(object != NO_OBJECT, "point {point} belongs to no object");
        object
    }

    /// May an object touch itself?
    ///
    /// # Panics
    /// If there is no such object.
    pub fn self_contact(&self, object: u32) -> SelfContact {
        self.objects.self_contact[object as usize]
    }

    /// Has the point no unknowns?
    pub fn is_scripted(&self, point: u32) -> bool {
        self.scripted[point as usize]
    }

    /// May two points touch? Not a point and itself, not two scripted points, and not points that take no part.
    pub fn may_touch(&self, a: u32, b: u32) -> bool {
        a != b && self.filters_let_touch(&[a], &[b])
    }

    /// May two features of the mesh touch, each given by its points?
    #[inline]
    pub fn features_may_touch<const N: usize, const M: usize>(&self, a: &[u32; N], b: &[u32; M]) -> bool {
        !a.iter().any(|p| b.contains(p)) && (self.filters == Filters::None || self.filters_let_touch(a, b))
    }

    /// What the filters say to two features without a common point.
    fn filters_let_touch(&self, a: &[u32], b: &[u32]) -> bool {
        let [object_a, object_b] = [a[0], b[0]].map(|p| self.object_of_point[p as usize]);
        object_a != NO_OBJECT
            && object_b != NO_OBJECT
            && self.objects.may_touch(object_a, object_b)
            && !a.iter().chain(b).all(|&p| self.scripted[p as usize])
            && (self.joined.is_empty() || !a.iter().any(|&p| b.iter().any(|&q| self.are_joined(p, q))))
    }

    fn are_joined(&self, a: u32, b: u32) -> bool {
        self.joined.binary_search(&[a, b]).is_ok()
    }

    /// Is a point kept out of a half-space? Not if it is scripted, takes no part, or belongs to an object that the
    /// half-space lets pass.
    pub fn may_touch_half_space(&self, half_space: u32, point: u32) -> bool {
        let object = self.object_of_point[point as usize];
        object != NO_OBJECT
            && !self.scripted[point as usize]
            && self.excluded_half_spaces.binary_search(&[half_space, object]).is_err()
    }

    /// Rest area that a point stands for \[m²\]; zero if it takes no part.
    pub fn point_area(&self, point: u32) -> f64 {
        self.point_area[point as usize]
    }

    /// Rest area that an edge stands for \[m²\].
    pub fn edge_area(&self, edge: u32) -> f64 {
        self.edge_area[edge as usize]
    }

    /// Length of an edge at rest \[m\].
    pub fn rest_length(&self, edge: u32) -> f64 {
        let [a, b] = self.edges[edge as usize].map(|p| self.rest[p as usize]);
        (b - a).norm()
    }

    /// Rest positions of all points \[m\].
    pub fn rest(&self) -> &[Vec3] {
        &self.rest
    }
}

/// The pair, lower first.
fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The edges of a triangle, lower point first; edge k joins corners k and k + 1 (mod 3).
fn sorted_edges(&[a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(sorted)
}
