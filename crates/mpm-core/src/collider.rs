//! Triangle meshes as obstacles: closed ones, and thin sheets that matter touches from both sides.
//!
//! # Solids
//! A [`SolidMesh`] acts as the shapes of [`boundary`](crate::boundary) do, by the same table: on the velocities of nodes inside or on it,
//! with the gradient of the signed distance as the normal. The distance is exact (the nearest point of the nearest triangle, found in a tree of
//! boxes), its sign that of the angle-weighted normal there. It is looked up in the frame of the collider, and remembered by node with the
//! place y in that frame and the distance d there. A distance grows no faster than its place moves, so:
//!
//! - y unmoved: distance and normal are those remembered. A collider at rest costs a comparison a node.
//! - d > ‖y′ − y‖: the node is still outside, whatever the motion was. The same with the middle of a block of nodes and its radius spares whole
//!   blocks.
//! - else the distance is looked up again, no farther than |d| + ‖y′ − y‖.
//!
//! What is remembered changes no bit of a result, so it is no part of a checkpoint.
//!
//! # What a collider takes
//! Every change of a node's momentum is an impulse on the collider, p = Σ m (v before − v after), with the moment Σ x × p about the origin:
//! [`ColliderLoad`]. Motions are prescribed; who integrates rigid bodies gives them the impulse of a step, and the collider the motion of the next
//! one ([`Simulation::set_collider_motion`](crate::Simulation::set_collider_motion)).

mod check;
mod error;
mod motion;
mod nodes;
mod sheet;
mod surface;
mod tree;
mod triangle;

pub use error::ColliderError;
pub use motion::{Placement, RigidMotion};
pub(crate) use nodes::{BlockMemory, ColliderStage, carried_over};
pub(crate) use sheet::{GAP, MOST_SHEETS, NEUTRAL, Path, SheetReport, Sheets, Sides, Trail};
pub use surface::{Side, SignedDistance};

use crate::{MpmError, Surface};
use mechanics_core::mesh::{self, TriMesh};
use mechanics_core::tensor::Vec3;
use motion::Moment;
use std::sync::Arc;
use surface::TriangleSurface;

/// A closed triangle mesh with an inside and an outside. Cheap to clone.
#[derive(Clone, Debug)]
pub struct SolidMesh(Arc<TriangleSurface>);

impl SolidMesh {
    /// The solid that a mesh encloses, whichever way it is turned; parts within other ones that are turned the other way are holes.
    ///
    /// # Errors
    /// [`ColliderError`] with the first edge that is open, not manifold or between triangles that disagree, the first triangle without
    /// area, the first pair of triangles that intersect, or the first triangle of a part that is inside out.
    pub fn new(mesh: &TriMesh) -> Result<Self, ColliderError> {
        let topology = mesh::Surface::of_triangles(mesh);
        topology.check_closed()?;
        let mut mesh = mesh.clone();
        if mesh.enclosed_volume() < 0.0 {
            mesh.flip();
        }
        let surface = TriangleSurface::new(&mesh)?;
        check::check_self_intersection(&surface)?;
        // The surface numbers its points anew, and keeps the order of the triangles.
        let components = topology.components();
        let mut seen = vec![false; components.count()];
        let mut part = |t: &usize| {
            let part = components.of_point[topology.triangles()[*t][0] as usize] as usize;
            !std::mem::replace(&mut seen[part], true)
        };
        let parts: Vec<usize> = (0..surface.count()).filter(|t| part(t)).collect();
        check::check_sides(&surface, &parts)?;
        Ok(Self(Arc::new(surface)))
    }

    /// The triangles, with normals outward.
    pub fn mesh(&self) -> &TriMesh {
        self.0.mesh()
    }

    /// How a place lies to the surface, in the frame of the mesh.
    pub fn signed_distance(&self, place: [f64; 3]) -> SignedDistance {
        self.0.signed_distance(&place.into(), f64::INFINITY)
    }
}

/// An open (or closed) triangle mesh without thickness, with matter on both sides. Cheap to clone.
#[derive(Clone, Debug)]
pub struct SheetMesh(Arc<TriangleSurface>);

impl SheetMesh {
    /// The sheet that a mesh is.
    ///
    /// # Errors
    /// As [`SolidMesh::new`], but edges may be open and no side is the inner one.
    pub fn new(mesh: &TriMesh) -> Result<Self, ColliderError> {
        let topology = mesh::Surface::of_triangles(mesh);
        topology.check_manifold()?;
        topology.check_oriented()?;
        let surface = TriangleSurface::new(mesh)?;
        check::check_self_intersection(&surface)?;
        Ok(Self(Arc::new(surface)))
    }

    /// The triangles.
    pub fn mesh(&self) -> &TriMesh {
        self.0.mesh()
    }

    /// How a place lies to the sheet, in the frame of the mesh: above zero on the side of the triangles' normals.
    pub fn signed_distance(&self, place: [f64; 3]) -> SignedDistance {
        self.0.signed_distance(&place.into(), f64::INFINITY)
    }
}

/// What a collider is made of.
#[derive(Clone, Debug)]
pub enum ColliderShape {
    /// Full.
    Solid(SolidMesh),
    /// Thin.
    Sheet(SheetMesh),
}

impl ColliderShape {
    fn triangles(&self) -> &TriangleSurface {
        match self {
            Self::Solid(solid) => &solid.0,
            Self::Sheet(sheet) => &sheet.0,
        }
    }
}

impl From<SolidMesh> for ColliderShape {
    fn from(solid: SolidMesh) -> Self {
        Self::Solid(solid)
    }
}

impl From<SheetMesh> for ColliderShape {
    fn from(sheet: SheetMesh) -> Self {
        Self::Sheet(sheet)
    }
}

/// A mesh, what its surface does, and how it moves.
#[derive(Clone, Debug)]
pub struct Collider {
    /// Where it is when it is added.
    pub shape: ColliderShape,
    /// What it does.
    pub surface: Surface,
    /// From when it is added on.
    pub motion: RigidMotion,
}

impl Collider {
    /// A collider that stands still.
    pub fn at_rest(shape: impl Into<ColliderShape>, surface: Surface) -> Self {
        Self { shape: shape.into(), surface, motion: RigidMotion::REST }
    }

    /// A collider that moves.
    pub fn moving(shape: impl Into<ColliderShape>, surface: Surface, motion: RigidMotion) -> Self {
        Self { shape: shape.into(), surface, motion }
    }
}

/// A change of momentum, and its moment about the origin of space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impulse {
    /// p \[N s\].
    pub linear: Vec3,
    /// Σ x × p \[N m s\]; about a point c it is this less c × p.
    pub angular: Vec3,
}

impl Impulse {
    pub(crate) fn at(place: &Vec3, linear: Vec3) -> Self {
        Self { linear, angular: place.cross(&linear) }
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.linear += other.linear;
        self.angular += other.angular;
    }
}

/// What matter has given to a collider.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ColliderLoad {
    /// In the last step.
    pub step: Impulse,
    /// Since it was added.
    pub total: Impulse,
}

/// How deep particles may be in a solid at the start, for rounding \[cells\].
const DEPTH: f64 = 1e-6;

/// A collider in its place.
#[derive(Clone, Debug)]
pub(crate) struct PlacedCollider {
    collider: Collider,
    /// Where it was when its motion began.
    start: Placement,
    /// When that was \[s\].
    since: f64,
    pub(crate) load: ColliderLoad,
}

impl PlacedCollider {
    /// # Errors
    /// [`MpmError::Number`] for a motion that is not finite or a coefficient of friction below zero.
    pub(crate) fn new(collider: Collider, time: f64) -> Result<Self, MpmError> {
        collider.motion.check()?;
        collider.surface.check()?;
        Ok(Self { collider, start: Placement::identity(), since: time, load: ColliderLoad::default() })
    }

    /// Where it is at a time.
    pub(crate) fn placement(&self, time: f64) -> Placement {
        self.start.moved(&self.collider.motion, time - self.since)
    }

    /// Goes on from where it is at a time with another motion.
    ///
    /// # Errors
    /// [`MpmError::Number`] for one that is not finite.
    pub(crate) fn set_motion(&mut self, motion: RigidMotion, time: f64) -> Result<(), MpmError> {
        motion.check()?;
        self.start = self.placement(time);
        self.since = time;
        self.collider.motion = motion;
        Ok(())
    }

    /// The mesh where it is at a time.
    pub(crate) fn placed_mesh(&self, time: f64) -> TriMesh {
        let (placement, mut mesh) = (self.placement(time), self.collider.shape.triangles().mesh().clone());
        // Finite points stay finite under a finite motion; if they do not, the mesh is left where it was.
        let _kept = mesh.map_points(|point| placement.place(point));
        mesh
    }

    /// How deep a place is inside of a solid, or 0 for one so near to a sheet that it has no side, in a grid of this spacing \[m\].
    pub(crate) fn depth(&self, place: &Vec3, time: f64, spacing: f64) -> Option<f64> {
        let point = self.placement(time).point_at(place);
        let found = self.collider.shape.triangles().signed_distance(&point, f64::INFINITY);
        match self.collider.shape {
            ColliderShape::Solid(_) => (found.distance < -DEPTH * spacing).then_some(-found.distance),
            ColliderShape::Sheet(_) => (found.distance.abs() <= GAP * spacing).then_some(0.0),
        }
    }

    /// Whether it is a sheet.
    pub(crate) fn is_sheet(&self) -> bool {
        matches!(self.collider.shape, ColliderShape::Sheet(_))
    }

    /// Whether it moves.
    pub(crate) fn moves(&self) -> bool {
        !self.collider.motion.is_rest()
    }

    fn moment(&self, time: f64) -> Moment {
        Moment::new(&self.start, &self.collider.motion, time - self.since)
    }

    /// What a checkpoint must know beside the set-up.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        let motion = &self.collider.motion;
        let ColliderLoad { step, total } = &self.load;
        let mut numbers = vec![self.since];
        numbers.extend(self.start.rotation.as_slice());
        for vector in [&self.start.translation, &step.linear, &step.angular, &total.linear, &total.angular] {
            numbers.extend(vector.as_slice());
        }
        [motion.centre, motion.velocity, motion.angular_velocity]
            .iter()
            .for_each(|vector| numbers.extend(vector));
        numbers
    }

    /// Takes what [`numbers`](Self::numbers) gave; `None` for another number of them.
    pub(crate) fn with_numbers(&self, numbers: &[f64]) -> Option<Self> {
        if numbers.len() != 34 {
            return None;
        }
        let vector = |k: usize| Vec3::from_column_slice(&numbers[10 + 3 * k..13 + 3 * k]);
        let impulse = |k: usize| Impulse { linear: vector(k), angular: vector(k + 1) };
        let motion = RigidMotion {
            centre: vector(5).into(),
            velocity: vector(6).into(),
            angular_velocity: vector(7).into(),
        };
        let rotation = mechanics_core::tensor::Mat3::from_column_slice(&numbers[1..10]);
        Some(Self {
            collider: Collider { motion, ..self.collider.clone() },
            start: Placement { rotation, translation: vector(0) },
            since: numbers[0],
            load: ColliderLoad { step: impulse(1), total: impulse(3) },
        })
    }
}
