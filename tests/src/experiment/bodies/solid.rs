//! Solids of linear or ten-node tetrahedra.

use crate::experiment::ExperimentError;
use lagrangian::element::{Mass, MassDistribution, QuadraticMesh, QuadraticTetrahedra, Tetrahedra};
use mechanics_core::law::Hyperelastic;
use mechanics_core::mesh::{TetMesh, tet_volume};
use mechanics_core::potential::Potential;
use mechanics_core::tensor::Vec3;

/// The shape functions.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::experiment) enum Shape {
    Linear,
    TenNode,
}

/// The corners of an element's faces, and the nodes in the middle of the faces' edges (0,1), (1,2) and (2,0).
const FACES: [([usize; 3], [usize; 3]); 4] =
    [([0, 1, 2], [4, 5, 6]), ([0, 1, 3], [4, 8, 7]), ([0, 2, 3], [6, 9, 7]), ([1, 2, 3], [5, 9, 8])];

/// A body of one material.
pub(in crate::experiment) struct Solid {
    /// Nodes at rest (m).
    pub(in crate::experiment) points: Vec<Vec3>,
    /// The elastic energy.
    pub(in crate::experiment) elastic: Box<dyn Potential>,
    cells: Cells,
}

enum Cells {
    Linear(Vec<[u32; 4]>),
    TenNode(Vec<[u32; 10]>),
}

impl Solid {
    /// A body of the tetrahedra of `mesh`, its mid-edge nodes, if any, in the middle of their edges.
    pub(in crate::experiment) fn new<L: Hyperelastic + 'static>(
        law: L,
        mesh: &TetMesh,
        shape: Shape,
    ) -> Result<Self, ExperimentError> {
        match shape {
            Shape::Linear => {
                let term = Tetrahedra::term("elastic", law, mesh).map_err(ExperimentError::stopped)?;
                let cells = Cells::Linear(mesh.cells().to_vec());
                Ok(Self { points: mesh.points().to_vec(), elastic: Box::new(term), cells })
            }
            Shape::TenNode => Self::of_ten_nodes(law, QuadraticMesh::new(mesh)),
        }
    }

    /// A body of ten-node tetrahedra.
    pub(in crate::experiment) fn of_ten_nodes<L: Hyperelastic + 'static>(
        law: L,
        mesh: QuadraticMesh,
    ) -> Result<Self, ExperimentError> {
        let term = QuadraticTetrahedra::term("elastic", law, &mesh).map_err(ExperimentError::stopped)?;
        Ok(Self { points: mesh.points, elastic: Box::new(term), cells: Cells::TenNode(mesh.cells) })
    }

    /// Its mass, of a density (kg/m³).
    pub(in crate::experiment) fn mass(
        &self,
        density: f64,
        distribution: MassDistribution,
    ) -> Result<Mass, ExperimentError> {
        let mut mass = Mass::zeros(self.points.len());
        match &self.cells {
            Cells::Linear(cells) => mass.add_tetrahedra(&self.points, cells, density, distribution),
            Cells::TenNode(cells) => {
                mass.add_quadratic_tetrahedra(&self.points, cells, density, distribution)
            }
        }
        .map_err(ExperimentError::stopped)?;
        Ok(mass)
    }

    /// The points that `held` picks at rest, where they are then.
    pub(in crate::experiment) fn held(&self, held: impl Fn(&Vec3) -> bool) -> Vec<(u32, Vec3)> {
        (0..).zip(&self.points).filter(|(_, x)| held(x)).map(|(i, x)| (i, *x)).collect()
    }

    /// ∫ Nᵢ dA (m²) over the flat part of the surface whose points `on` picks, node by node; a node may come more than
    /// once.
    pub(in crate::experiment) fn face_shares(&self, on: impl Fn(&Vec3) -> bool) -> Vec<(u32, f64)> {
        let mut shares = Vec::new();
        for element in 0..self.count() {
            let nodes = self.nodes(element);
            for (corners, edges) in FACES {
                let [a, b, c] = corners.map(|corner| self.points[nodes[corner] as usize]);
                if !(on(&a) && on(&b) && on(&c)) {
                    continue;
                }
                let third = (b - a).cross(&(c - a)).norm() / 6.0;
                let loaded = match self.cells {
                    Cells::Linear(_) => corners,
                    // Quadratic triangles: corners have no part, each mid-edge node a third.
                    Cells::TenNode(_) => edges,
                };
                shares.extend(loaded.map(|node| (nodes[node], third)));
            }
        }
        shares
    }

    /// The triangles of the surface; the faces of ten-node tetrahedra are cut into four.
    pub(in crate::experiment) fn skin(&self) -> Vec<[u32; 3]> {
        let sorted = |mut corners: [u32; 3]| {
            corners.sort_unstable();
            corners
        };
        let faces = || (0..self.count()).flat_map(|element| FACES.map(|face| (self.nodes(element), face)));
        let mut seen: Vec<[u32; 3]> =
            faces().map(|(nodes, (corners, _))| sorted(corners.map(|corner| nodes[corner]))).collect();
        seen.sort_unstable();
        let mut triangles = Vec::new();
        for (nodes, (corners, edges)) in faces() {
            let [a, b, c] = corners.map(|corner| nodes[corner]);
            let same = |other: &[u32; 3]| *other == sorted([a, b, c]);
            let first = seen.partition_point(|other| *other < sorted([a, b, c]));
            if seen[first..].iter().take_while(|other| same(other)).count() > 1 {
                continue;
            }
            match self.cells {
                Cells::Linear(_) => triangles.push([a, b, c]),
                Cells::TenNode(_) => {
                    let [ab, bc, ca] = edges.map(|node| nodes[node]);
                    triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
                }
            }
        }
        triangles
    }

    /// The smallest ratio of an element's volume, taken by its corners, to that at rest.
    pub(in crate::experiment) fn smallest_volume_ratio(&self, x: &[Vec3]) -> f64 {
        let volume = |x: &[Vec3], element: usize| {
            let nodes = self.nodes(element);
            tet_volume(&std::array::from_fn(|corner| x[nodes[corner] as usize]))
        };
        (0..self.count()).map(|e| volume(x, e) / volume(&self.points, e)).fold(f64::INFINITY, f64::min)
    }

    fn count(&self) -> usize {
        match &self.cells {
            Cells::Linear(cells) => cells.len(),
            Cells::TenNode(cells) => cells.len(),
        }
    }

    fn nodes(&self, element: usize) -> &[u32] {
        match &self.cells {
            Cells::Linear(cells) => &cells[element],
            Cells::TenNode(cells) => &cells[element],
        }
    }
}
