//! Gaussians in tetrahedra.

use super::Moved;
use super::cells::Cells;
use crate::error::SplatError;
use mechanics_core::mesh::{BoundingBox, TetMesh};
use mechanics_core::parallel;
use mechanics_core::tensor::{Mat3, Vec3};

/// Which deformation gradient a Gaussian in a tetrahedron takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TetGradients {
    /// That of its tetrahedron. Neighbours may differ by a jump.
    Constant,
    /// Averaged to the vertices by rest volumes, and interpolated: continuous within the body.
    Smooth,
}

/// Gaussians embedded in a mesh of tetrahedra: x = Σⱼ bⱼ xⱼ over the four vertices of one, bⱼ the barycentric coordinates at rest.
///
/// A mean outside of the body, as those of a captured surface often are by a little, belongs to the nearest tetrahedron, whose affine motion
/// continues beyond it: bⱼ below zero. [`TetBinding::farthest`] says how far outside the farthest one is.
#[derive(Clone, Debug)]
pub struct TetBinding {
    cells: Vec<[u32; 4]>,
    vertices: usize,
    /// Inverses of the edge matrices at rest, and rest volumes.
    inverses: Vec<(Mat3, f64)>,
    gradients: TetGradients,
    /// For each mean its tetrahedron and barycentric coordinates.
    places: Vec<(u32, [f64; 4])>,
    farthest: f64,
    outside: usize,
}

impl TetBinding {
    /// Of a mesh and means at rest.
    ///
    /// # Errors
    /// [`SplatError::NoSamples`] for a mesh without tetrahedra; [`SplatError::FlatTet`]; [`SplatError::BadPoint`].
    pub fn new(mesh: &TetMesh, means: &[Vec3], gradients: TetGradients) -> Result<Self, SplatError> {
        check_points(means, |point, value| SplatError::BadPoint { point, value })?;
        let corners = |t: usize| mesh.corners(t);
        let mut inverses = Vec::with_capacity(mesh.cells().len());
        for t in 0..mesh.cells().len() {
            let edges = edges(&corners(t));
            let inverse = edges.try_inverse().filter(|m| m.iter().all(|x| x.is_finite()));
            inverses.push((inverse.ok_or(SplatError::FlatTet { tet: t })?, edges.determinant().abs() / 6.0));
        }
        let boxes: Vec<BoundingBox> =
            (0..mesh.cells().len()).filter_map(|t| BoundingBox::of(&corners(t))).collect();
        let cells = Cells::new(&boxes).ok_or(SplatError::NoSamples)?;
        let found: Vec<(u32, [f64; 4], f64)> = parallel::map_chunks(means.len(), 256, |range| {
            range.map(|i| place(mesh, &inverses, &cells, &means[i])).collect::<Vec<_>>()
        })
        .concat();
        Ok(Self {
            cells: mesh.cells().to_vec(),
            vertices: mesh.points().len(),
            inverses,
            gradients,
            farthest: found.iter().map(|f| f.2).fold(0.0, f64::max),
            outside: found.iter().filter(|f| f.2 > 0.0).count(),
            places: found.into_iter().map(|(t, b, _)| (t, b)).collect(),
        })
    }

    /// The tetrahedron of mean i and its barycentric coordinates there.
    ///
    /// # Panics
    /// If there is no such mean.
    pub fn place(&self, i: usize) -> (u32, [f64; 4]) {
        self.places[i]
    }

    /// How many means are outside of the body.
    pub fn outside(&self) -> usize {
        self.outside
    }

    /// The largest distance of a mean from the body \[m\]; zero if all are inside.
    pub fn farthest(&self) -> f64 {
        self.farthest
    }

    /// Where the Gaussians are, and how they are deformed, when the vertices are at `positions`.
    ///
    /// # Errors
    /// [`SplatError::SampleCount`] unless there are as many positions as vertices.
    pub fn move_into(&self, positions: &[Vec3], moved: &mut Moved) -> Result<(), SplatError> {
        if positions.len() != self.vertices {
            return Err(SplatError::SampleCount { samples: positions.len(), matter: self.vertices });
        }
        let by_tet: Vec<Mat3> = parallel::map_chunks(self.cells.len(), 1024, |range| {
            range.map(|t| edges(&self.corners(t, positions)) * self.inverses[t].0).collect::<Vec<_>>()
        })
        .concat();
        let by_vertex = match self.gradients {
            TetGradients::Constant => Vec::new(),
            TetGradients::Smooth => self.at_vertices(&by_tet),
        };
        moved.set(self.places.len(), |i| {
            let (t, weights) = self.places[i];
            let t = t as usize;
            let corners = self.corners(t, positions);
            let position = (0..4).map(|k| corners[k] * weights[k]).sum();
            let gradient = match self.gradients {
                TetGradients::Constant => by_tet[t],
                TetGradients::Smooth => {
                    // Not beyond the body: an average that is continued far outside may be anything.
                    let inner = inner_weights(weights);
                    (0..4).map(|k| by_vertex[self.cells[t][k] as usize] * inner[k]).sum()
                }
            };
            (position, gradient)
        });
        Ok(())
    }

    fn corners(&self, t: usize, positions: &[Vec3]) -> [Vec3; 4] {
        self.cells[t].map(|v| positions[v as usize])
    }

    /// Gradients averaged over the tetrahedra around each vertex, weighted by rest volumes.
    fn at_vertices(&self, by_tet: &[Mat3]) -> Vec<Mat3> {
        let mut sums = vec![(Mat3::zeros(), 0.0); self.vertices];
        for ((cell, f), (_, volume)) in self.cells.iter().zip(by_tet).zip(&self.inverses) {
            for &v in cell {
                let (sum, weight) = &mut sums[v as usize];
                *sum += f * *volume;
                *weight += volume;
            }
        }
        sums.into_iter().map(|(sum, weight)| sum / weight).collect()
    }
}

/// Barycentric coordinates without what is below zero.
fn inner_weights(weights: [f64; 4]) -> [f64; 4] {
    let positive = weights.map(|w| w.max(0.0));
    let sum: f64 = positive.iter().sum();
    positive.map(|w| w / sum)
}

/// Columns x₁ − x₀, x₂ − x₀, x₃ − x₀.
fn edges([a, b, c, d]: &[Vec3; 4]) -> Mat3 {
    Mat3::from_columns(&[b - a, c - a, d - a])
}

/// The tetrahedron around x, the first of several, or the nearest; its barycentric coordinates; the distance to it.
fn place(mesh: &TetMesh, inverses: &[(Mat3, f64)], cells: &Cells, x: &Vec3) -> (u32, [f64; 4], f64) {
    let coordinates = |t: u32| {
        let b = inverses[t as usize].0 * (x - mesh.corners(t as usize)[0]);
        [1.0 - b.x - b.y - b.z, b.x, b.y, b.z]
    };
    let around = cells.at(x).iter().find(|&&t| coordinates(t).iter().all(|&b| b >= 0.0));
    if let Some(&t) = around {
        return (t, coordinates(t), 0.0);
    }
    let mut best = (f64::INFINITY, u32::MAX);
    cells.nearest(x, |t| {
        let distance = distance_squared(&mesh.corners(t as usize), x);
        if (distance, t) < best {
            best = (distance, t);
        }
        best.0.sqrt()
    });
    (best.1, coordinates(best.1), best.0.sqrt())
}

/// The squared distance from x, which is outside, to a tetrahedron: to the nearest of its faces.
fn distance_squared([a, b, c, d]: &[Vec3; 4], x: &Vec3) -> f64 {
    let faces = [[a, b, c], [a, b, d], [a, c, d], [b, c, d]];
    faces
        .into_iter()
        .map(|face| (nearest_on_triangle(face, x) - x).norm_squared())
        .fold(f64::INFINITY, f64::min)
}

/// The point of a triangle nearest to x.
///
/// In the coordinates of the plane, x is inside all three edges and its foot is the answer, or the answer is the nearest point of the three edges.
fn nearest_on_triangle([a, b, c]: [&Vec3; 3], x: &Vec3) -> Vec3 {
    let normal = (b - a).cross(&(c - a));
    let inside = |p: &Vec3, q: &Vec3| (q - p).cross(&(x - p)).dot(&normal) >= 0.0;
    if normal.norm_squared() > 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
        return x - normal * ((x - a).dot(&normal) / normal.norm_squared());
    }
    let on_edge = |p: &Vec3, q: &Vec3| {
        let along = q - p;
        let share = (x - p).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        p + along * share.clamp(0.0, 1.0)
    };
    let candidates = [on_edge(a, b), on_edge(b, c), on_edge(c, a)];
    let distance = |p: &Vec3| (p - x).norm_squared();
    candidates
        .into_iter()
        .fold(candidates[0], |best, p| if distance(&p) < distance(&best) { p } else { best })
}

/// The first point with a number that is not finite, as an error.
pub(super) fn check_points(
    points: &[Vec3],
    error: impl Fn(usize, f64) -> SplatError,
) -> Result<(), SplatError> {
    for (i, x) in points.iter().enumerate() {
        if let Some(&value) = x.iter().find(|x| !x.is_finite()) {
            return Err(error(i, value));
        }
    }
    Ok(())
}
