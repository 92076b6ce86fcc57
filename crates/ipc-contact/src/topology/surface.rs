//! Points and segments against a surface of triangles.

use super::{check_finite, side_of_moved};
use crate::ContactError;
use crate::collision_mesh::Feature;
use crate::intersection::{orientation, segment_meets_triangle};
use mechanics_core::tensor::Vec3;

/// An oriented surface of triangles, open or closed, in one piece or several. Where its points are is said at each call.
#[derive(Clone, Debug)]
pub struct Surface {
    triangles: Vec<[u32; 3]>,
    point_count: usize,
}

/// A surface without rim: every edge is passed as often one way as the other.
#[derive(Clone, Debug)]
pub struct ClosedSurface(Surface);

/// Where a point is with respect to a closed surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// On this triangle (the first of several).
    On {
        /// The triangle.
        triangle: u32,
    },
    /// Not on the surface, which winds around the point so many times: 0 outside of all of it, 1 inside of one body with
    /// outward normals, −1 with inward normals, 0 again in a cavity whose surface looks into it.
    Off {
        /// The winding number.
        winding: i32,
    },
}

/// How often a segment passes through a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crossings {
    /// In the direction of the triangle's normal.
    pub along: u32,
    /// Against the normal.
    pub against: u32,
}

impl Crossings {
    /// Crossings along the normals less those against.
    pub fn net(&self) -> i32 {
        self.along as i32 - self.against as i32
    }
}

/// Where a point is with respect to a sheet and another point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// On the side of the other point.
    Same,
    /// On the other side.
    Opposite,
}

impl Surface {
    /// The surface of the given triangles, whose normals are (b − a) × (c − a), over `point_count` points.
    ///
    /// # Errors
    /// [`ContactError::PointOutOfRange`] names the first triangle with a point that does not exist.
    pub fn new(triangles: Vec<[u32; 3]>, point_count: usize) -> Result<Self, ContactError> {
        for (t, corners) in triangles.iter().enumerate() {
            if let Some(&point) = corners.iter().find(|&&p| p as usize >= point_count) {
                let feature = Feature::Triangle(t as u32);
                return Err(ContactError::PointOutOfRange { feature, point, points: point_count });
            }
        }
        Ok(Self { triangles, point_count })
    }

    /// The same surface, known to be closed: as many triangles pass each edge from its first point to its second as
    /// from its second to its first.
    ///
    /// # Errors
    /// [`ContactError::OpenSurface`] names an edge of the rim, or one between triangles of contrary orientation.
    pub fn closed(self) -> Result<ClosedSurface, ContactError> {
        let directed = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
        let mut edges: Vec<[u32; 2]> =
            self.triangles.iter().flat_map(directed).filter(|e| e[0] != e[1]).collect();
        let mut reversed: Vec<[u32; 2]> = edges.iter().map(|&[a, b]| [b, a]).collect();
        edges.sort_unstable();
        reversed.sort_unstable();
        match edges.iter().zip(&reversed).find(|(edge, back)| edge != back) {
            Some((edge, back)) => Err(ContactError::OpenSurface { edge: *edge.min(back) }),
            None => Ok(ClosedSurface(self)),
        }
    }

    fn corners<'a>(&self, x: &'a [Vec3], t: usize) -> [&'a Vec3; 3] {
        self.triangles[t].map(|p| &x[p as usize])
    }

    fn check_positions(&self, x: &[Vec3], queries: &[Vec3]) -> Result<(), ContactError> {
        assert_eq!(x.len(), self.point_count, "as many positions as points of the surface");
        let wrong = |&p: &usize| x[p].iter().any(|c| !c.is_finite());
        match self.triangles.iter().flatten().map(|&p| p as usize).find(wrong) {
            Some(point) => Err(ContactError::NonFinite { point, position: x[point].into() }),
            None => check_finite(queries),
        }
    }

    /// The first triangle that contains the point, exactly.
    fn triangle_at(&self, x: &[Vec3], point: &Vec3) -> Option<u32> {
        let contains = |&t: &usize| {
            let corners = self.corners(x, t);
            spans(corners, point, point) && segment_meets_triangle([point, point], corners)
        };
        (0..self.triangles.len()).find(contains).map(|t| t as u32)
    }

    /// How often the segment from `from` to `to` passes through the surface at the positions `x`. The sum is exact: where
    /// the segment meets an edge, a corner or a triangle lengthwise, `to` is thought to be moved by (δ², δ³, δ) for
    /// an arbitrarily small δ > 0, so that each passage is counted once. Time is linear in the number of triangles.
    ///
    /// # Errors
    /// [`ContactError::OnSurface`] if an end is on the surface, [`ContactError::NonFinite`] and
    /// [`ContactError::NonFiniteQuery`] name positions that are infinite or NaN.
    ///
    /// # Panics
    /// If `x` has not as many points as the surface.
    pub fn crossings(&self, x: &[Vec3], from: &Vec3, to: &Vec3) -> Result<Crossings, ContactError> {
        self.check_positions(x, &[*from, *to])?;
        for end in [from, to] {
            if let Some(triangle) = self.triangle_at(x, end) {
                return Err(ContactError::OnSurface { triangle, position: (*end).into() });
            }
        }
        Ok(self.crossings_off_surface(x, from, to))
    }

    fn crossings_off_surface(&self, x: &[Vec3], from: &Vec3, to: &Vec3) -> Crossings {
        let mut crossings = Crossings::default();
        for t in 0..self.triangles.len() {
            match crossing(from, to, self.corners(x, t)) {
                1 => crossings.along += 1,
                -1 => crossings.against += 1,
                _ => {}
            }
        }
        crossings
    }

    /// Whether `point` is on the same side of an open sheet as `reference`: whether the segment between them passes
    /// through the sheet an even number of times. Says nothing of points past the rim: take a reference for which the
    /// segment stays within the sheet's shadow.
    ///
    /// # Errors
    /// As [`crossings`](Self::crossings).
    ///
    /// # Panics
    /// As [`crossings`](Self::crossings).
    pub fn side_of_sheet(&self, x: &[Vec3], reference: &Vec3, point: &Vec3) -> Result<Side, ContactError> {
        let crossings = self.crossings(x, point, reference)?;
        Ok(if (crossings.along + crossings.against) % 2 == 0 { Side::Same } else { Side::Opposite })
    }

    /// The solid angle under which the surface is seen from `point` \[sr\], positive where it is seen from behind (against
    /// its normals): 4π inside a closed surface with outward normals, 0 outside; it jumps by 4π where the point passes
    /// through a sheet, and a sheet seen from close to its middle has about ±2π. In floating point: an error of about
    /// 1e-15 a triangle, and of up to 4π on the surface itself.
    ///
    /// # Panics
    /// If `x` has not as many points as the surface.
    ///
    /// # Reference
    /// A. van Oosterom, J. Strackee, *The solid angle of a plane triangle*, IEEE Trans. Biomed. Eng. 30(2), 1983, eq. 8.
    pub fn solid_angle(&self, x: &[Vec3], point: &Vec3) -> f64 {
        assert_eq!(x.len(), self.point_count, "as many positions as points of the surface");
        let angle = |t: usize| {
            let [a, b, c] = self.corners(x, t).map(|corner| corner - point);
            let [la, lb, lc] = [a, b, c].map(|side| side.norm());
            let volume = a.dot(&b.cross(&c));
            2.0 * volume.atan2(la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb)
        };
        (0..self.triangles.len()).map(angle).sum()
    }
}

impl ClosedSurface {
    /// The surface.
    pub fn surface(&self) -> &Surface {
        &self.0
    }

    /// Where a point is, at the positions `x`; exact for all finite positions. The surface may intersect itself. Time is
    /// linear in the number of triangles.
    ///
    /// # Derivation
    /// The winding number of a closed surface around a point is the number of times that a path from the point to
    /// infinity passes through it along the normals, less the times against. The path goes straight up to the height of
    /// the surface's highest point and from there, moved by (δ², δ³, δ), on to infinity above everything.
    ///
    /// # Errors
    /// [`ContactError::NonFinite`] and [`ContactError::NonFiniteQuery`] name positions that are infinite or NaN.
    ///
    /// # Panics
    /// If `x` has not as many points as the surface.
    pub fn locate(&self, x: &[Vec3], point: &Vec3) -> Result<Location, ContactError> {
        let surface = &self.0;
        surface.check_positions(x, &[*point])?;
        if let Some(triangle) = surface.triangle_at(x, point) {
            return Ok(Location::On { triangle });
        }
        let heights = surface.triangles.iter().flatten().map(|&p| x[p as usize].z);
        let top = Vec3::new(point.x, point.y, heights.fold(point.z, f64::max));
        Ok(Location::Off { winding: surface.crossings_off_surface(x, point, &top).net() })
    }
}

/// Whether the boxes around a triangle and around a segment share a point.
fn spans(corners: [&Vec3; 3], from: &Vec3, to: &Vec3) -> bool {
    (0..3).all(|k| {
        let (low, high) = if from[k] <= to[k] { (from[k], to[k]) } else { (to[k], from[k]) };
        corners.iter().any(|c| c[k] <= high) && corners.iter().any(|c| c[k] >= low)
    })
}

/// 1 if the segment passes through the triangle along its normal, −1 against it, 0 if it does not pass. Neither end is in
/// the triangle; the end `to` is thought to be moved, see [`side_of_moved`].
///
/// If `from` is in the triangle's plane, the moved segment leaves the plane at once and does not come back. If it is
/// not, the plane through `from` and an edge is a plane, and the moved end is strictly on one side of it: no case is left
/// open.
fn crossing(from: &Vec3, to: &Vec3, corners: [&Vec3; 3]) -> i8 {
    let [a, b, c] = corners;
    if !spans(corners, from, to) {
        return 0;
    }
    let start = orientation(a, b, c, from);
    let end = side_of_moved(a, b, c, to);
    if start == 0 || start == end {
        return 0;
    }
    let passed = [[a, b], [b, c], [c, a]].map(|[first, second]| side_of_moved(from, first, second, to));
    if passed == [passed[0]; 3] { end } else { 0 }
}
