//! The sphere and the ball from the icosahedron.

use super::block::oriented;
use super::check_counts;
use crate::mesh::error::MeshError;
use crate::mesh::points::check_positive;
use crate::mesh::{TetMesh, TriMesh};
use crate::tensor::Vec3;
use std::collections::BTreeMap;

/// A point of the refined icosahedron: weights of icosahedron corners, by ascending corner, that sum up to the
/// layer (0 at the centre). Points of neighbouring pieces are equal exactly if their keys are.
type Key = [(u32, u32); 3];

/// Points numbered in the order in which they are first met.
struct Lattice {
    corners: [Vec3; 12],
    index: BTreeMap<Key, u32>,
    points: Vec<Vec3>,
    scale: f64,
}

impl Lattice {
    fn new(radius: f64, frequency: u32) -> Self {
        let scale = radius / f64::from(frequency);
        Self { corners: icosahedron_corners(), index: BTreeMap::new(), points: Vec::new(), scale }
    }

    /// The point whose weights for the corners of `face` are given: in the direction of the weighted sum of
    /// corners, at the distance `scale` × (sum of the weights) from the centre.
    fn point(&mut self, face: [u32; 3], weights: [u32; 3]) -> u32 {
        let mut key: Key =
            std::array::from_fn(|k| if weights[k] == 0 { (0, 0) } else { (face[k], weights[k]) });
        key.sort_unstable();
        let next = self.points.len() as u32;
        *self.index.entry(key).or_insert_with(|| {
            // Summed in the order of the key, so that all pieces would compute the same bits.
            let sum: Vec3 = key.iter().map(|&(c, w)| self.corners[c as usize] * f64::from(w)).sum();
            let layer: u32 = weights.iter().sum();
            let direction = sum.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            self.points.push(direction * (self.scale * f64::from(layer)));
            next
        })
    }
}

/// A sphere of triangles \[m\] around the origin: every triangle of the icosahedron is cut into `frequency²`, and the
/// points are moved onto the sphere. 10 f² + 2 points, 20 f² triangles. (`frequency` = 2ᵏ gives the same counts as
/// k bisections of an icosphere.)
///
/// The inscribed polyhedron's volume and area fall short by O(1/f²).
///
/// # Errors
/// A radius that is not positive and finite; a frequency of zero or beyond what 32 bits number.
pub fn sphere(radius: f64, frequency: u32) -> Result<TriMesh, MeshError> {
    check_positive("radius", radius)?;
    check_counts("frequency", &[frequency, frequency], 20)?;
    let mut lattice = Lattice::new(radius, frequency);
    let mut triangles = Vec::new();
    let n = frequency;
    for face in ICOSAHEDRON {
        let mut at = |i: u32, j: u32| lattice.point(face, [n - i - j, i, j]);
        for j in 0..n {
            for i in 0..n - j {
                triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    TriMesh::new(lattice.points, triangles)
}

/// A ball of tetrahedra \[m\] around the origin, whose surface is [`sphere`]`(radius, frequency)`: each of the 20
/// pieces that the icosahedron's triangles form with the centre is cut into `frequency³` tetrahedra, and its layers
/// are moved onto spheres. 20 f³ tetrahedra.
///
/// The pieces are cut along Freudenthal's subdivision of the simplex 0 ≤ z ≤ y ≤ x ≤ f: unit cubes cut into six
/// along their diagonal, of which those inside the simplex are kept. On the piece's faces it leaves the regular
/// subdivision of a triangle, whatever the order of its corners, so neighbouring pieces fit.
///
/// # Errors
/// As [`sphere`].
///
/// # Reference
/// Bey 2000, "Simplicial grid refinement: on Freudenthal's algorithm and the optimal number of congruence classes",
/// Numerische Mathematik 85.
pub fn ball(radius: f64, frequency: u32) -> Result<TetMesh, MeshError> {
    check_positive("radius", radius)?;
    check_counts("frequency", &[frequency; 3], 20)?;
    let mut lattice = Lattice::new(radius, frequency);
    let mut tets = Vec::new();
    for face in ICOSAHEDRON {
        for_each_simplex(frequency, |simplex| {
            // x counts the layers; the differences are the weights of the three corners.
            let tet = simplex.map(|[x, y, z]| lattice.point(face, [x - y, y - z, z]));
            tets.push(tet);
        });
    }
    let points = lattice.points;
    let tets = tets.into_iter().map(|tet| oriented(&points, tet)).collect();
    TetMesh::new(points, tets)
}

/// The n³ tetrahedra of Freudenthal's subdivision of 0 ≤ z ≤ y ≤ x ≤ n.
fn for_each_simplex(n: u32, mut visit: impl FnMut([[u32; 3]; 4])) {
    const PATHS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    for x in 0..n {
        for y in 0..=x {
            for z in 0..=y {
                for path in PATHS {
                    let mut corner = [x, y, z];
                    let simplex = std::array::from_fn(|k| {
                        if k > 0 {
                            corner[path[k - 1]] += 1;
                        }
                        corner
                    });
                    if simplex.iter().all(|[x, y, z]| z <= y && y <= x) {
                        visit(simplex);
                    }
                }
            }
        }
    }
}

/// Corners of the icosahedron on the unit sphere: cyclic permutations of (0, ±1, ±φ), normalised.
fn icosahedron_corners() -> [Vec3; 12] {
    let golden = 0.5 + 1.25_f64.sqrt();
    std::array::from_fn(|c| {
        let one = if c & 1 == 0 { 1.0 } else { -1.0 };
        let phi = if c & 2 == 0 { golden } else { -golden };
        let corner = match c / 4 {
            0 => Vec3::new(0.0, one, phi),
            1 => Vec3::new(one, phi, 0.0),
            _ => Vec3::new(phi, 0.0, one),
        };
        corner.normalize()
    })
}

/// The icosahedron's triangles, counter-clockwise seen from outside.
const ICOSAHEDRON: [[u32; 3]; 20] = [
    [0, 1, 8],
    [0, 10, 1],
    [0, 4, 5],
    [0, 8, 4],
    [0, 5, 10],
    [1, 7, 6],
    [1, 6, 8],
    [1, 10, 7],
    [2, 9, 3],
    [2, 3, 11],
    [2, 5, 4],
    [2, 4, 9],
    [2, 11, 5],
    [3, 6, 7],
    [3, 9, 6],
    [3, 7, 11],
    [4, 8, 9],
    [5, 11, 10],
    [6, 9, 8],
    [7, 10, 11],
];
