//! What a user states: objects, half-spaces, groups.

use mechanics_core::mesh::{MeshError, Surface, TetMesh, TriMesh};
use mechanics_core::tensor::Vec3;

/// May an object touch itself?
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SelfContact {
    /// Features of the object that share no point may touch.
    #[default]
    Allowed,
    /// The object never touches itself: a rigid obstacle, a stiff body whose self-contact cannot matter.
    Excluded,
}

/// Membership in up to 32 groups. Two objects may touch if each belongs to a group that the other touches; an
/// object's contact with itself is a matter of [`SelfContact`] alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Groups {
    /// Bit k: the object belongs to group k.
    pub member_of: u32,
    /// Bit k: the object may touch members of group k.
    pub touches: u32,
}

impl Groups {
    /// May members of these groups touch members of those?
    pub fn may_touch(self, other: Self) -> bool {
        self.member_of & other.touches != 0 && other.member_of & self.touches != 0
    }
}

impl Default for Groups {
    /// A member of all groups that touches all.
    fn default() -> Self {
        Self { member_of: u32::MAX, touches: u32::MAX }
    }
}

/// The half-space that points are kept out of: a point x is outside, where it may be, if n·x > offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Unit normal n, from the obstacle to where points may be.
    pub normal: Vec3,
    /// Position of the plane along the normal \[m\].
    pub offset: f64,
}

impl HalfSpace {
    /// The half-space behind the plane through `point` \[m\] with a normal of any length. A normal without
    /// direction (zero, NaN) is found by [`CollisionMeshBuilder::build`](super::CollisionMeshBuilder::build),
    /// which names the half-space.
    pub fn through(point: &Vec3, normal: &Vec3) -> Self {
        // Scaled first, so that the norm neither overflows nor underflows.
        let normal = (normal / normal.amax()).normalize();
        Self { normal, offset: normal.dot(point) }
    }

    /// Signed distance of a point, positive outside \[m\].
    #[inline]
    pub fn distance(&self, point: &Vec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// One object of a collision mesh: triangles, loose segments and loose points, by the numbers of the potential's
/// points.
///
/// Edges of triangles take part without being named. Loose segments and loose points have no area of their own: they
/// stand for one by their [`thickness`](Self::thickness).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollisionObject {
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Segments that are no triangle's edge: rods, nets, knives.
    pub segments: Vec<[u32; 2]>,
    /// Points of no triangle and no segment: particles, point clouds.
    pub points: Vec<u32>,
    /// Width of a loose segment and side of the square a loose point stands for \[m\]; needed if there are any. It
    /// enters the rest areas only, not the distance at which contact acts.
    pub thickness: Option<f64>,
    /// May the object touch itself?
    pub self_contact: SelfContact,
    /// Its groups.
    pub groups: Groups,
}

impl CollisionObject {
    /// Triangles alone.
    pub fn new(triangles: Vec<[u32; 3]>) -> Self {
        Self { triangles, ..Self::default() }
    }

    /// The triangles, free edges and free points of a mesh whose point 0 is point `first_point` of the potential.
    /// Free edges and free points that belong to a triangle or free edge anyway add nothing and are left out.
    pub fn of_mesh(mesh: &TriMesh, first_point: u32) -> Self {
        let mut triangle_edges: Vec<[u32; 2]> =
            mesh.triangles().iter().flat_map(super::sorted_edges).collect();
        triangle_edges.sort_unstable();
        let is_loose = |e: &[u32; 2]| triangle_edges.binary_search(e).is_err();
        let mut segments: Vec<_> =
            mesh.free_edges().iter().map(|&e| super::sorted(e)).filter(is_loose).collect();
        segments.sort_unstable();
        segments.dedup();
        let mut used = vec![false; mesh.points().len()];
        mesh.triangles()
            .iter()
            .flatten()
            .chain(segments.iter().flatten())
            .for_each(|&p| used[p as usize] = true);
        let points = mesh.free_points().iter().copied().filter(|&p| !used[p as usize]);
        Self {
            triangles: mesh.triangles().iter().map(|t| t.map(|p| p + first_point)).collect(),
            points: points.map(|p| p + first_point).collect(),
            segments: segments.iter().map(|e| e.map(|p| p + first_point)).collect(),
            ..Self::default()
        }
    }

    /// The surface of a tetrahedral mesh whose point 0 is point `first_point` of the potential; points inside do not
    /// take part.
    ///
    /// # Errors
    /// A mesh without a well-defined surface, see [`Surface::of_tets`].
    pub fn of_tets(mesh: &TetMesh, first_point: u32) -> Result<Self, MeshError> {
        let surface = Surface::of_tets(mesh)?;
        let source = surface.source_points();
        let number = |p: u32| source[p as usize] + first_point;
        Ok(Self::new(surface.triangles().iter().map(|t| t.map(number)).collect()))
    }

    /// The same with a stated thickness \[m\].
    pub fn with_thickness(self, thickness: f64) -> Self {
        Self { thickness: Some(thickness), ..self }
    }

    /// The same with self-contact allowed or not.
    pub fn with_self_contact(self, self_contact: SelfContact) -> Self {
        Self { self_contact, ..self }
    }

    /// The same in these groups.
    pub fn with_groups(self, groups: Groups) -> Self {
        Self { groups, ..self }
    }
}
