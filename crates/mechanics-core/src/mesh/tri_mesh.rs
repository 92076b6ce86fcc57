use super::error::{CellKind, MeshError};
use super::points::{self, BoundingBox};
use super::topology;
use crate::tensor::Vec3;
use nalgebra::Rotation3;

/// A triangle mesh, open or closed, with codimensional parts: points \[m\], triangles, free edges (rods, hair), and
/// free points (particles).
///
/// Guaranteed: indices in range, different points within a cell, finite positions, no free point listed twice. A
/// free edge may coincide with a triangle's edge. Which points no cell uses:
/// [`unreferenced_points`](Self::unreferenced_points).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    points: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    free_edges: Vec<[u32; 2]>,
    free_points: Vec<u32>,
}

/// The area vector `(b − a) × (c − a) / 2` \[m²\]: its length is the triangle's area, its direction the normal.
pub fn triangle_area_vector([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a)) * 0.5
}

impl TriMesh {
    /// A mesh of triangles.
    ///
    /// # Errors
    /// A non-finite position, an index out of range, a cell with a repeated vertex, more than 2³² − 1 of either.
    pub fn new(points: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        Self::with_codimensional(points, triangles, Vec::new(), Vec::new())
    }

    /// A mesh of triangles, free edges and free points over one list of points.
    ///
    /// # Errors
    /// As [`new`](Self::new), for each kind of cell; and a free point that is listed twice.
    pub fn with_codimensional(
        points: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        free_edges: Vec<[u32; 2]>,
        free_points: Vec<u32>,
    ) -> Result<Self, MeshError> {
        points::check_points(&points)?;
        points::check_cells(CellKind::Triangle, &triangles, points.len())?;
        points::check_cells(CellKind::Edge, &free_edges, points.len())?;
        check_free_points(&free_points, points.len())?;
        Ok(Self { points, triangles, free_edges, free_points })
    }

    /// The points \[m\].
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// The triangles, as indices of points.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Edges that belong to no triangle, such as a rod's.
    pub fn free_edges(&self) -> &[[u32; 2]] {
        &self.free_edges
    }

    /// Points that stand for themselves, such as particles.
    pub fn free_points(&self) -> &[u32] {
        &self.free_points
    }

    /// The corners of one triangle \[m\].
    ///
    /// # Panics
    /// If there is no triangle `triangle`.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|i| self.points[i as usize])
    }

    /// The area of every triangle \[m²\].
    pub fn areas(&self) -> Vec<f64> {
        (0..self.triangles.len()).map(|t| triangle_area_vector(&self.corners(t)).norm()).collect()
    }

    /// The sum of the triangles' areas \[m²\].
    pub fn area(&self) -> f64 {
        self.areas().iter().sum()
    }

    /// The sum of the free edges' lengths \[m\].
    pub fn free_length(&self) -> f64 {
        self.free_edges.iter().map(|e| (self.points[e[1] as usize] - self.points[e[0] as usize]).norm()).sum()
    }

    /// The volume the triangles enclose, `Σ a · b × c / 6` by the divergence theorem \[m³\]; positive when their
    /// normals point outwards. It has a meaning only for closed, consistently oriented surfaces
    /// ([`Surface::check_closed`](super::Surface::check_closed)). Positions are taken relative to the middle of the
    /// bounding box, so that a mesh far from the origin loses nothing to cancellation.
    pub fn enclosed_volume(&self) -> f64 {
        let Some(bounds) = self.bounding_box() else { return 0.0 };
        let centre = bounds.centre();
        let cone = |t: usize| {
            let [a, b, c] = self.corners(t).map(|p| p - centre);
            a.dot(&b.cross(&c))
        };
        (0..self.triangles.len()).map(cone).sum::<f64>() / 6.0
    }

    /// The centre of mass of the triangles for uniform density per area \[m\]. `None` unless the area is positive.
    pub fn centroid(&self) -> Option<Vec3> {
        let areas = self.areas();
        let total: f64 = areas.iter().sum();
        let middle = |t: usize| self.corners(t).iter().sum::<Vec3>() / 3.0;
        let moment: Vec3 = areas.iter().enumerate().map(|(t, &a)| middle(t) * a).sum();
        (total > 0.0).then(|| moment / total)
    }

    /// The smallest axis-aligned box around all points; `None` if there are none.
    pub fn bounding_box(&self) -> Option<BoundingBox> {
        BoundingBox::of(&self.points)
    }

    /// Points that belong to no triangle and no free edge and are not free points themselves, ascending.
    pub fn unreferenced_points(&self) -> Vec<u32> {
        points::unreferenced(self.points.len(), self.references())
    }

    /// Drops the unreferenced points. Answers, for every point that is left, which point it was.
    pub fn remove_unreferenced(&mut self) -> Vec<u32> {
        let (new_index, kept) = points::renumbering(self.points.len(), self.references());
        self.points = kept.iter().map(|&i| self.points[i as usize]).collect();
        self.triangles.iter_mut().flatten().for_each(|i| *i = new_index[*i as usize]);
        self.free_edges.iter_mut().flatten().for_each(|i| *i = new_index[*i as usize]);
        self.free_points.iter_mut().for_each(|i| *i = new_index[*i as usize]);
        kept
    }

    /// Merges points whose coordinates are bitwise equal (+0 and −0 count as equal) into the first of them, in all
    /// cells, and drops the others. Answers, for every point that was there, its index now.
    ///
    /// # Errors
    /// [`MeshError::RepeatedVertex`] if a cell would be left with a repeated vertex; the mesh is as before.
    pub fn weld(&mut self) -> Result<Vec<u32>, MeshError> {
        let (points, new_index) = topology::weld(&self.points);
        let renumber = |i: u32| new_index[i as usize];
        let triangles = self.triangles.iter().map(|t| t.map(renumber)).collect();
        let edges = self.free_edges.iter().map(|e| e.map(renumber)).collect();
        let mut free_points: Vec<u32> = self.free_points.iter().map(|&i| renumber(i)).collect();
        free_points.sort_unstable();
        free_points.dedup();
        *self = Self::with_codimensional(points, triangles, edges, free_points)?;
        Ok(new_index)
    }

    /// The unique edges of triangles and the free edges, each with its smaller end first, in ascending order.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let of_triangles = self.triangles.iter().flat_map(topology::triangle_edges);
        topology::unique_edges(of_triangles.chain(self.free_edges.iter().copied()))
    }

    /// Turns every triangle over.
    pub fn flip(&mut self) {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }

    /// Appends another mesh; coincident points are not merged ([`weld`](Self::weld) does that). Answers the number
    /// by which the other mesh's point indices were raised.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`], and the mesh is as before.
    pub fn append(&mut self, other: &Self) -> Result<u32, MeshError> {
        points::check_count(self.points.len() + other.points.len())?;
        points::check_count(self.triangles.len() + other.triangles.len())?;
        points::check_count(self.free_edges.len() + other.free_edges.len())?;
        let offset = self.points.len() as u32;
        self.points.extend_from_slice(&other.points);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + offset)));
        self.free_edges.extend(other.free_edges.iter().map(|e| e.map(|i| i + offset)));
        self.free_points.extend(other.free_points.iter().map(|i| i + offset));
        Ok(offset)
    }

    /// Moves every point to `map(point)`. A map that reflects turns the normals of a closed surface inwards: see
    /// [`flip`](Self::flip).
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

    fn references(&self) -> impl Iterator<Item = u32> {
        let edges = self.free_edges.iter().flatten();
        self.triangles.iter().flatten().chain(edges).chain(&self.free_points).copied()
    }
}

fn check_free_points(free_points: &[u32], points: usize) -> Result<(), MeshError> {
    let mut seen = vec![false; points];
    for (cell, &index) in free_points.iter().enumerate() {
        let kind = CellKind::Point;
        match seen.get_mut(index as usize) {
            None => return Err(MeshError::IndexOutOfRange { kind, cell, index, points }),
            Some(true) => return Err(MeshError::RepeatedVertex { kind, cell, vertex: index }),
            Some(seen) => *seen = true,
        }
    }
    Ok(())
}
