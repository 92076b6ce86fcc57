//! What is constrained.

use super::error::PositionError;
use crate::element::ThinError;
use crate::element::hinge::{dihedral_angle, dihedral_gradient, hinges_of};
use mechanics_core::mesh::{TetMesh, TriMesh, tet_volume};
use mechanics_core::tensor::Vec3;
use std::f64::consts::{PI, TAU};

/// Whether a constraint acts to both sides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ConstraintKind {
    /// C(x) = 0.
    #[default]
    Equality,
    /// C(x) ≥ 0: it pushes and does not pull, λ ≥ 0.
    AtLeastZero,
}

/// A family of scalar constraints on `N` particles each, numbered `0..`.
pub trait PositionConstraint<const N: usize>: Send + Sync {
    /// C and ∇C with the particles of `element` at `x`; `None` where C has no gradient.
    fn evaluate(&self, element: usize, x: &[Vec3; N]) -> Option<(f64, [Vec3; N])>;

    /// Whether it acts to both sides.
    fn kind(&self) -> ConstraintKind {
        ConstraintKind::Equality
    }
}

/// C = |x₁ − x₀| − ℓ \[m\]. Compliance in m/N: the inverse of a spring's stiffness.
#[derive(Clone, Debug, PartialEq)]
pub struct Distances {
    rest: Vec<f64>,
}

impl Distances {
    /// The present lengths of `edges` between `points`.
    ///
    /// # Errors
    /// An edge without length.
    ///
    /// # Panics
    /// If an edge names a point that does not exist.
    pub fn new(points: &[Vec3], edges: &[[u32; 2]]) -> Result<Self, ThinError> {
        let length = |(edge, ends): (usize, &[u32; 2])| {
            let length = (points[ends[1] as usize] - points[ends[0] as usize]).norm();
            let sound = length > 0.0 && length.is_finite();
            if sound { Ok(length) } else { Err(ThinError::RestLength { edge, points: *ends, length }) }
        };
        Ok(Self { rest: edges.iter().enumerate().map(length).collect::<Result<_, _>>()? })
    }

    /// The rest lengths \[m\].
    pub fn rest(&self) -> &[f64] {
        &self.rest
    }
}

impl PositionConstraint<2> for Distances {
    fn evaluate(&self, element: usize, x: &[Vec3; 2]) -> Option<(f64, [Vec3; 2])> {
        let edge = x[1] - x[0];
        let length = edge.norm();
        let along = edge / length;
        (length > 0.0).then(|| (length - self.rest[element], [-along, along]))
    }
}

/// C = θ − θ̄ \[rad\], the angle of a hinge ([`dihedral_angle`]) from its rest angle, taken the shorter way round.
/// Compliance in 1/J: the inverse of the moment per angle.
#[derive(Clone, Debug, PartialEq)]
pub struct Bends {
    rest: Vec<f64>,
}

impl Bends {
    /// The hinges of `mesh` at their present angles, with their points.
    ///
    /// # Errors
    /// An edge of three or more triangles; neighbours with opposite normals.
    pub fn new(mesh: &TriMesh) -> Result<(Self, Vec<[u32; 4]>), ThinError> {
        let points: Vec<[u32; 4]> = hinges_of(mesh)?.iter().map(|hinge| hinge.points).collect();
        let angle = |hinge: &[u32; 4]| dihedral_angle(&hinge.map(|i| mesh.points()[i as usize]));
        Ok((Self { rest: points.iter().map(angle).collect() }, points))
    }
}

impl PositionConstraint<4> for Bends {
    fn evaluate(&self, element: usize, x: &[Vec3; 4]) -> Option<(f64, [Vec3; 4])> {
        let gradient = dihedral_gradient(x);
        let sound = gradient.iter().flatten().all(|entry| entry.is_finite());
        let turned = dihedral_angle(x) - self.rest[element];
        let shorter = if turned > PI {
            turned - TAU
        } else if turned < -PI {
            turned + TAU
        } else {
            turned
        };
        sound.then_some((shorter, gradient))
    }
}

/// C = V − V̄ \[m³\], the signed volume of a tetrahedron. Compliance in m³/Pa.
#[derive(Clone, Debug, PartialEq)]
pub struct Volumes {
    rest: Vec<f64>,
}

impl Volumes {
    /// The tetrahedra of `mesh` at their present volumes.
    ///
    /// # Errors
    /// A volume that is not positive.
    pub fn new(mesh: &TetMesh) -> Result<Self, PositionError> {
        let volume = |element: usize| {
            let volume = tet_volume(&mesh.corners(element));
            let sound = volume > 0.0 && volume.is_finite();
            if sound { Ok(volume) } else { Err(PositionError::RestVolume { element, volume }) }
        };
        Ok(Self { rest: (0..mesh.cells().len()).map(volume).collect::<Result<_, _>>()? })
    }
}

impl PositionConstraint<4> for Volumes {
    fn evaluate(&self, element: usize, x: &[Vec3; 4]) -> Option<(f64, [Vec3; 4])> {
        let [a, b, c] = [x[1] - x[0], x[2] - x[0], x[3] - x[0]];
        let [one, two, three] = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|area| area / 6.0);
        let volume = a.dot(&one);
        Some((volume - self.rest[element], [-(one + two + three), one, two, three]))
    }
}

/// C = n·x − d ≥ 0 \[m\]: particles stay on the side of a plane that its unit normal n points to. Compliance in m/N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    normal: Vec3,
    offset: f64,
}

impl Ground {
    /// The plane through `point` \[m\] with normal `normal`, of any length.
    ///
    /// # Errors
    /// A normal that is zero or not finite; a point that is not finite.
    pub fn new(point: &Vec3, normal: &Vec3) -> Result<Self, PositionError> {
        let length = normal.norm();
        let unit = normal / length;
        let offset = unit.dot(point);
        if length > 0.0 && length.is_finite() && offset.is_finite() {
            Ok(Self { normal: unit, offset })
        } else {
            Err(PositionError::Normal { normal: (*normal).into() })
        }
    }
}

impl PositionConstraint<1> for Ground {
    fn evaluate(&self, _: usize, x: &[Vec3; 1]) -> Option<(f64, [Vec3; 1])> {
        Some((self.normal.dot(&x[0]) - self.offset, [self.normal]))
    }

    fn kind(&self) -> ConstraintKind {
        ConstraintKind::AtLeastZero
    }
}
