use super::error::{CellKind, MeshError};
use super::points::{self, BoundingBox};
use super::topology;
use crate::tensor::Vec3;
use nalgebra::Rotation3;

/// A tetrahedral mesh: points \[m\] and cells of four point indices.
///
/// Guaranteed: indices in range, four different points per cell, finite positions. Not guaranteed: positive volumes
/// ([`check_orientation`](Self::check_orientation)), conformity ([`check_conforming`](Self::check_conforming)), that
/// every point is used ([`unreferenced_points`](Self::unreferenced_points)).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetMesh {
    points: Vec<Vec3>,
    cells: Vec<[u32; 4]>,
}

/// The signed volume `(b − a) × (c − a) · (d − a) / 6` of a tetrahedron \[m³\].
pub fn tet_volume([a, b, c, d]: &[Vec3; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}

impl TetMesh {
    /// A mesh of these points and cells.
    ///
    /// # Errors
    /// A non-finite position, an index out of range, a cell with a repeated vertex, more than 2³² − 1 of either.
    pub fn new(points: Vec<Vec3>, cells: Vec<[u32; 4]>) -> Result<Self, MeshError> {
        points::check_points(&points)?;
        points::check_cells(CellKind::Tetrahedron, &cells, points.len())?;
        Ok(Self { points, cells })
    }

    /// The points \[m\].
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// The tetrahedra, as indices of points.
    pub fn cells(&self) -> &[[u32; 4]] {
        &self.cells
    }

    /// Takes the mesh apart.
    pub fn into_parts(self) -> (Vec<Vec3>, Vec<[u32; 4]>) {
        (self.points, self.cells)
    }

    /// The corners of one tetrahedron \[m\].
    ///
    /// # Panics
    /// If there is no tetrahedron `tet`.
    pub fn corners(&self, tet: usize) -> [Vec3; 4] {
        self.cells[tet].map(|i| self.points[i as usize])
    }

    /// The signed volume of every tetrahedron \[m³\].
    pub fn volumes(&self) -> Vec<f64> {
        (0..self.cells.len()).map(|t| tet_volume(&self.corners(t))).collect()
    }

    /// The sum of the signed volumes \[m³\].
    pub fn volume(&self) -> f64 {
        self.volumes().iter().sum()
    }

    /// The centre of mass for uniform density \[m\]: Σ V (a + b + c + d)/4 / Σ V. `None` unless the volume is positive.
    pub fn centroid(&self) -> Option<Vec3> {
        let volumes = self.volumes();
        let total: f64 = volumes.iter().sum();
        let middle = |t: usize| self.corners(t).iter().sum::<Vec3>() * 0.25;
        let moment: Vec3 = volumes.iter().enumerate().map(|(t, &v)| middle(t) * v).sum();
        (total > 0.0).then(|| moment / total)
    }

    /// The smallest axis-aligned box around all points; `None` if there are none.
    pub fn bounding_box(&self) -> Option<BoundingBox> {
        BoundingBox::of(&self.points)
    }

    /// Points that belong to no tetrahedron, ascending.
    pub fn unreferenced_points(&self) -> Vec<u32> {
        points::unreferenced(self.points.len(), self.cells.iter().flatten().copied())
    }

    /// Drops the unreferenced points. Answers, for every point that is left, which point it was.
    pub fn remove_unreferenced(&mut self) -> Vec<u32> {
        let (new_index, kept) = points::renumbering(self.points.len(), self.cells.iter().flatten().copied());
        self.points = kept.iter().map(|&i| self.points[i as usize]).collect();
        self.cells.iter_mut().flatten().for_each(|i| *i = new_index[*i as usize]);
        kept
    }

    /// The unique edges, each with its smaller end first, in ascending order.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        topology::unique_edges(self.cells.iter().flat_map(topology::tet_edges))
    }

    /// Checks that every tetrahedron has a positive, finite volume.
    ///
    /// # Errors
    /// [`MeshError::NotPositive`] for the first that has not.
    pub fn check_orientation(&self) -> Result<(), MeshError> {
        for tet in 0..self.cells.len() {
            let volume = tet_volume(&self.corners(tet));
            if !(volume > 0.0 && volume.is_finite()) {
                return Err(MeshError::NotPositive { tet, volume });
            }
        }
        Ok(())
    }

    /// Makes negative volumes positive by exchanging the cell's last two vertices, and answers which cells it
    /// turned. Cells of zero volume are left alone.
    pub fn orient(&mut self) -> Vec<u32> {
        let negative = |t: &usize| tet_volume(&self.corners(*t)) < 0.0;
        let turned: Vec<u32> = (0..self.cells.len()).filter(negative).map(|t| t as u32).collect();
        turned.iter().for_each(|&t| self.cells[t as usize].swap(2, 3));
        turned
    }

    /// Checks that every face belongs to one tetrahedron, or to two that lie on different sides of it.
    ///
    /// # Errors
    /// [`MeshError::OvercrowdedFace`] or [`MeshError::OpposedTets`] for the first face in ascending order for which
    /// that does not hold.
    pub fn check_conforming(&self) -> Result<(), MeshError> {
        topology::boundary_faces(&self.cells).map(|_| ())
    }

    /// Appends the points and cells of another mesh; coincident points are not merged. Answers the number by which
    /// the other mesh's point indices were raised.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`], and the mesh is as before.
    pub fn append(&mut self, other: &Self) -> Result<u32, MeshError> {
        points::check_count(self.points.len() + other.points.len())?;
        points::check_count(self.cells.len() + other.cells.len())?;
        let offset = self.points.len() as u32;
        self.points.extend_from_slice(&other.points);
        self.cells.extend(other.cells.iter().map(|cell| cell.map(|i| i + offset)));
        Ok(offset)
    }

    /// Moves every point to `map(point)`. A map that reflects turns the tetrahedra inside out: see
    /// [`orient`](Self::orient).
    ///
    /// # Errors
    /// [`MeshError::NonFinitePosition`], and the mesh is as before.
    pub fn map_points(&mut self, map: impl Fn(&Vec3) -> Vec3) -> Result<(), MeshError> {
        points::map_points(&mut self.points, map)
    }

    /// Adds `by` \[m\] to every point.
    ///
    /// # Errors
    /// [`MeshError::NonFinitePosition`], and the mesh is as before.
    pub fn translate(&mut self, by: &Vec3) -> Result<(), MeshError> {
        self.map_points(|p| p + by)
    }

    /// Multiplies every point by `factor > 0`, about the origin.
    ///
    /// # Errors
    /// A factor that is not positive, or a point that overflows; the mesh is as before.
    pub fn scale(&mut self, factor: f64) -> Result<(), MeshError> {
        points::check_positive("scale factor", factor)?;
        self.map_points(|p| p * factor)
    }

    /// Rotates every point about the origin.
    ///
    /// # Errors
    /// [`MeshError::NonFinitePosition`] (a rotation that holds a NaN), and the mesh is as before.
    pub fn rotate(&mut self, rotation: &Rotation3<f64>) -> Result<(), MeshError> {
        self.map_points(|p| rotation * p)
    }
}
