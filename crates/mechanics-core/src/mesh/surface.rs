use super::error::MeshError;
use super::tet_mesh::TetMesh;
use super::topology::{self, DisjointSets, Side};
use super::tri_mesh::{TriMesh, triangle_area_vector};
use crate::tensor::Vec3;

/// The boundary of a [`TetMesh`], or a [`TriMesh`], with its topology: what contact, drawing and files look at.
///
/// A surface numbers its own points, without gaps; [`source_points`](Self::source_points) leads back to the mesh it
/// was taken from. Its edges are unique, each with the smaller end first, in ascending order, and include the free
/// edges. The triangles of a positively oriented `TetMesh` have outward normals.
///
/// Topology is combinatorial: it is read off the indices alone, so two triangles that touch without sharing point
/// indices are not neighbours ([`TriMesh::weld`] makes them so).
#[derive(Clone, Debug)]
pub struct Surface {
    mesh: TriMesh,
    source_points: Vec<u32>,
    source_cells: Vec<u32>,
    edges: Vec<[u32; 2]>,
    sides: Vec<Side>,
}

/// The connected parts of a [`Surface`]: points are connected by triangles and free edges.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Components {
    /// For every point of the surface, the number of its component. Components are numbered by their first point.
    pub of_point: Vec<u32>,
    /// For every component, vertices − edges + triangles: 2 for a closed orientable surface without handles, 2 − 2g
    /// with g handles, 1 for a disc or a rod.
    pub euler_characteristics: Vec<i64>,
}

impl Components {
    /// How many components there are.
    pub fn count(&self) -> usize {
        self.euler_characteristics.len()
    }
}

impl Surface {
    /// The boundary of a tetrahedral mesh: the faces that belong to one tetrahedron only.
    ///
    /// The normals point outwards if all volumes are positive ([`TetMesh::check_orientation`]).
    ///
    /// # Errors
    /// [`MeshError::OvercrowdedFace`] and [`MeshError::OpposedTets`] if the mesh has no well-defined boundary.
    pub fn of_tets(volume: &TetMesh) -> Result<Self, MeshError> {
        let faces = topology::boundary_faces(volume.cells())?;
        let triangles = faces.iter().map(|f| f.face).collect();
        let mesh = TriMesh::new(volume.points().to_vec(), triangles)?;
        Ok(Self::build(mesh, faces.iter().map(|f| f.tet).collect()))
    }

    /// The surface that a triangle mesh is, with its free edges and free points.
    pub fn of_triangles(mesh: &TriMesh) -> Self {
        let cells = (0..mesh.triangles().len() as u32).collect();
        Self::build(mesh.clone(), cells)
    }

    fn build(mut mesh: TriMesh, source_cells: Vec<u32>) -> Self {
        let source_points = mesh.remove_unreferenced();
        let edges = mesh.edges();
        let sides = topology::sides(mesh.triangles());
        Self { mesh, source_points, source_cells, edges, sides }
    }

    /// The surface as a triangle mesh, in the surface's own numbering.
    pub fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    /// The surface as a triangle mesh, in the surface's own numbering.
    pub fn into_mesh(self) -> TriMesh {
        self.mesh
    }

    /// The points at the time the surface was taken \[m\].
    pub fn points(&self) -> &[Vec3] {
        self.mesh.points()
    }

    /// The triangles, as indices of the surface's points.
    pub fn triangles(&self) -> &[[u32; 3]] {
        self.mesh.triangles()
    }

    /// The unique edges of triangles and the free edges, smaller end first, ascending.
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// For every point of the surface, the point of the mesh it was taken from; ascending.
    pub fn source_points(&self) -> &[u32] {
        &self.source_points
    }

    /// For every triangle, the tetrahedron or triangle of the mesh it was taken from.
    pub fn source_cells(&self) -> &[u32] {
        &self.source_cells
    }

    /// Edges that belong to exactly one triangle (a hole, a rim), ascending. Free edges are not among them.
    pub fn boundary_edges(&self) -> Vec<[u32; 2]> {
        self.edge_groups().filter(|g| g.len() == 1).map(|g| g[0].edge).collect()
    }

    /// Edges that belong to more than two triangles, ascending.
    pub fn non_manifold_edges(&self) -> Vec<[u32; 2]> {
        self.edge_groups().filter(|g| g.len() > 2).map(|g| g[0].edge).collect()
    }

    /// Points around which the triangles form more than one fan, with the number of fans; ascending.
    pub fn non_manifold_points(&self) -> Vec<(u32, usize)> {
        let triangles = self.triangles();
        let corner = |side: &Side, end: usize| {
            let t = &triangles[side.triangle as usize];
            let k = (0..3).find(|&k| t[k] == side.edge[end]).unwrap_or(0);
            3 * side.triangle + k as u32
        };
        let mut fans = DisjointSets::new(3 * triangles.len());
        for group in self.edge_groups() {
            for side in &group[1..] {
                (0..2).for_each(|end| fans.join(corner(&group[0], end), corner(side, end)));
            }
        }
        let mut count = vec![0_usize; self.points().len()];
        for (c, &point) in triangles.iter().flatten().enumerate() {
            count[point as usize] += usize::from(fans.root(c as u32) == c as u32);
        }
        (0_u32..).zip(count).filter(|&(_, fans)| fans > 1).collect()
    }

    /// Checks that every edge belongs to at most two triangles and that the triangles around every point form one
    /// fan, open or closed.
    ///
    /// # Errors
    /// [`MeshError::NonManifoldEdge`] or [`MeshError::NonManifoldVertex`] for the first that does not.
    pub fn check_manifold(&self) -> Result<(), MeshError> {
        if let Some(group) = self.edge_groups().find(|g| g.len() > 2) {
            return Err(MeshError::NonManifoldEdge { edge: group[0].edge, count: group.len() });
        }
        match self.non_manifold_points().first() {
            Some(&(vertex, fans)) => Err(MeshError::NonManifoldVertex { vertex, fans }),
            None => Ok(()),
        }
    }

    /// Checks that any two triangles with a common edge run along it in opposite directions, so that their normals
    /// are on the same side.
    ///
    /// # Errors
    /// [`MeshError::OpposedTriangles`] for the first edge where they do not. Edges of more than two triangles are
    /// left to [`check_manifold`](Self::check_manifold).
    pub fn check_oriented(&self) -> Result<(), MeshError> {
        for group in self.edge_groups() {
            if let [p, q] = group
                && p.ascending == q.ascending
            {
                return Err(MeshError::OpposedTriangles {
                    edge: p.edge,
                    triangles: [p.triangle, q.triangle],
                });
            }
        }
        Ok(())
    }

    /// Checks that the triangles form closed, consistently oriented manifolds, so that they enclose a volume.
    ///
    /// # Errors
    /// Those of [`check_manifold`](Self::check_manifold) and [`check_oriented`](Self::check_oriented), and
    /// [`MeshError::OpenEdge`].
    pub fn check_closed(&self) -> Result<(), MeshError> {
        if let Some(group) = self.edge_groups().find(|g| g.len() == 1) {
            return Err(MeshError::OpenEdge { edge: group[0].edge, triangle: group[0].triangle });
        }
        self.check_manifold()?;
        self.check_oriented()
    }

    /// Vertices − edges + triangles, over all components. Free edges and free points count too.
    pub fn euler_characteristic(&self) -> i64 {
        self.points().len() as i64 - self.edges.len() as i64 + self.triangles().len() as i64
    }

    /// The connected components.
    pub fn components(&self) -> Components {
        let mut sets = DisjointSets::new(self.points().len());
        self.edges.iter().for_each(|e| sets.join(e[0], e[1]));
        let mut of_point = vec![0_u32; self.points().len()];
        let mut euler_characteristics = Vec::new();
        for i in 0..of_point.len() {
            let root = sets.root(i as u32) as usize;
            if root == i {
                of_point[i] = euler_characteristics.len() as u32;
                euler_characteristics.push(0_i64);
            } else {
                of_point[i] = of_point[root];
            }
            euler_characteristics[of_point[i] as usize] += 1;
        }
        let component = |point: u32| of_point[point as usize] as usize;
        self.edges.iter().for_each(|e| euler_characteristics[component(e[0])] -= 1);
        self.triangles().iter().for_each(|t| euler_characteristics[component(t[0])] += 1);
        Components { of_point, euler_characteristics }
    }

    /// The sum of the triangles' areas \[m²\].
    pub fn area(&self) -> f64 {
        self.mesh.area()
    }

    /// The enclosed volume \[m³\]: see [`TriMesh::enclosed_volume`].
    pub fn volume(&self) -> f64 {
        self.mesh.enclosed_volume()
    }

    /// For every point, a third of the areas of its triangles \[m²\]; zero for points of free edges and free points.
    pub fn point_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.points().len()];
        for (t, triangle) in self.triangles().iter().enumerate() {
            let third = triangle_area_vector(&self.mesh.corners(t)).norm() / 3.0;
            triangle.iter().for_each(|&i| areas[i as usize] += third);
        }
        areas
    }

    /// For every edge, in the order of [`edges`](Self::edges), a third of the areas of its triangles \[m²\]; zero for
    /// free edges.
    pub fn edge_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.edges.len()];
        let mut e = 0;
        for group in self.edge_groups() {
            while self.edges[e] != group[0].edge {
                e += 1;
            }
            let area = |s: &Side| triangle_area_vector(&self.mesh.corners(s.triangle as usize)).norm();
            areas[e] = group.iter().map(area).sum::<f64>() / 3.0;
        }
        areas
    }

    /// The sides of triangles, grouped by edge, ascending.
    fn edge_groups(&self) -> impl Iterator<Item = &[Side]> {
        self.sides.chunk_by(|a, b| a.edge == b.edge)
    }
}
