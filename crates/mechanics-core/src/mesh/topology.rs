//! Edges, faces and connected components by sorting: the result never depends on a hash.

use super::error::MeshError;
use crate::tensor::Vec3;

/// The four faces of a tetrahedron; for positive volume their normals point outwards.
pub(super) fn tet_faces(&[a, b, c, d]: &[u32; 4]) -> [[u32; 3]; 4] {
    [[a, c, b], [a, b, d], [b, c, d], [a, d, c]]
}

pub(super) fn tet_edges(&[a, b, c, d]: &[u32; 4]) -> [[u32; 2]; 6] {
    [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]]
}

/// The three edges in the direction in which the triangle runs along them.
pub(super) fn triangle_edges(&[a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

pub(super) fn sorted<const N: usize>(mut cell: [u32; N]) -> [u32; N] {
    cell.sort_unstable();
    cell
}

pub(super) fn unique_edges(edges: impl Iterator<Item = [u32; 2]>) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = edges.map(sorted).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// A face on the boundary, and the tetrahedron it belongs to.
pub(super) struct BoundaryFace {
    pub(super) face: [u32; 3],
    pub(super) tet: u32,
}

/// The faces that belong to one tetrahedron only, in the order of the tetrahedra.
pub(super) fn boundary_faces(cells: &[[u32; 4]]) -> Result<Vec<BoundaryFace>, MeshError> {
    let mut records: Vec<([u32; 3], u32, u8)> = Vec::with_capacity(4 * cells.len());
    for (tet, cell) in cells.iter().enumerate() {
        for (k, face) in tet_faces(cell).into_iter().enumerate() {
            records.push((sorted(face), tet as u32, k as u8));
        }
    }
    records.sort_unstable();
    let face_of = |&(_, tet, k): &([u32; 3], u32, u8)| tet_faces(&cells[tet as usize])[k as usize];
    let mut boundary = Vec::new();
    for group in records.chunk_by(|a, b| a.0 == b.0) {
        match group {
            [one] => boundary.push(*one),
            [p, q] if is_even(face_of(p)) == is_even(face_of(q)) => {
                return Err(MeshError::OpposedTets { face: p.0, tets: [p.1, q.1] });
            }
            [_, _] => {}
            [p, q, r, ..] => {
                return Err(MeshError::OvercrowdedFace { face: p.0, tets: [p.1, q.1, r.1] });
            }
            [] => {}
        }
    }
    boundary.sort_unstable_by_key(|&(_, tet, k)| (tet, k));
    Ok(boundary.iter().map(|record| BoundaryFace { face: face_of(record), tet: record.1 }).collect())
}

/// Whether an even number of exchanges sorts the three.
fn is_even([a, b, c]: [u32; 3]) -> bool {
    ((a < b) as u8 + (b < c) as u8 + (c < a) as u8) == 2
}

/// One side of a triangle: the edge with ascending ends, the triangle, and whether it runs from the smaller end to
/// the larger one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    pub(super) edge: [u32; 2],
    pub(super) triangle: u32,
    pub(super) ascending: bool,
}

/// All sides of all triangles, sorted by edge, then by triangle.
pub(super) fn sides(triangles: &[[u32; 3]]) -> Vec<Side> {
    let of_triangle = |(t, triangle): (usize, &[u32; 3])| {
        triangle_edges(triangle).map(|edge| Side {
            edge: sorted(edge),
            triangle: t as u32,
            ascending: edge[0] < edge[1],
        })
    };
    let mut sides: Vec<Side> = triangles.iter().enumerate().flat_map(of_triangle).collect();
    sides.sort_unstable();
    sides
}

/// Union-find over `0..count`; roots are the smallest member, so that numbering is independent of the order of
/// unions.
pub(super) struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    pub(super) fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    pub(super) fn root(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let above = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = above;
            i = above;
        }
        i
    }

    pub(super) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

/// Merges bitwise equal points (−0 counted as +0) into their first occurrence, keeping the order of first
/// occurrences. Answers the points that are left and, for every old point, its new index.
pub(super) fn weld(points: &[Vec3]) -> (Vec<Vec3>, Vec<u32>) {
    let key = |i: u32| points[i as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_unstable_by_key(|&i| (<[u64; 3]>::from(key(i)), i));
    let mut first = vec![0_u32; points.len()];
    for group in order.chunk_by(|&a, &b| key(a) == key(b)) {
        group.iter().for_each(|&i| first[i as usize] = group[0]);
    }
    let mut kept = Vec::new();
    let mut new_index = vec![0_u32; points.len()];
    for (i, &f) in first.iter().enumerate() {
        if f as usize == i {
            new_index[i] = kept.len() as u32;
            kept.push(points[i]);
        } else {
            new_index[i] = new_index[f as usize];
        }
    }
    (kept, new_index)
}
