//! A triangle surface that tells how far away it is, on which side, and in which direction.

use super::ColliderError;
use super::tree::{Bounds, Tree};
use super::triangle::{Feature, crossing, nearest};
use mechanics_core::mesh::TriMesh;
use mechanics_core::tensor::Vec3;
use std::collections::BTreeMap;

/// How a place lies to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedDistance {
    /// Below zero inside a solid, or behind a sheet \[m\].
    pub distance: f64,
    /// The gradient of the distance: the unit direction in which it grows. Where many directions are the nearest way, the mean of the
    /// triangles there.
    pub normal: Vec3,
    /// Whether the nearest point is on the rim of a sheet, beyond which the sides are one.
    pub nearest: Side,
}

/// What the nearest point of a surface belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The surface within its rim.
    Surface,
    /// The rim.
    Rim,
}

/// Triangles in the order of their tree, with the normals of their parts.
#[derive(Clone, Debug)]
pub(super) struct TriangleSurface {
    mesh: TriMesh,
    tree: Tree,
    /// Number in the mesh of each triangle.
    names: Vec<u32>,
    corners: Vec<[Vec3; 3]>,
    normals: Vec<Vec3>,
    /// Sums of the normals at the edges and corners, not of unit length.
    edge_normals: Vec<[Vec3; 3]>,
    corner_normals: Vec<[Vec3; 3]>,
    /// Bits of the edges 0, 1, 2 and the corners 0, 1, 2 that are on the rim.
    rims: Vec<u8>,
    /// The diagonal of the box around it \[m\].
    size: f64,
}

/// Relative to the size of the surface, where a place is on an edge or corner but for rounding.
const TOUCHING: f64 = 1e-12;

/// How much larger triangles are for paths that may pass them, in barycentric coordinates.
const OVERLAP: f64 = 1e-9;

impl TriangleSurface {
    /// # Errors
    /// [`ColliderError::Empty`], [`ColliderError::Flat`].
    pub(super) fn new(mesh: &TriMesh) -> Result<Self, ColliderError> {
        let count = mesh.triangles().len();
        if count == 0 {
            return Err(ColliderError::Empty);
        }
        let (areas, size) = (mesh.areas(), mesh.bounding_box().map_or(0.0, |bounds| bounds.size().norm()));
        let flat = |area: f64| !(area > f64::EPSILON * f64::EPSILON * size * size);
        if let Some(triangle) = (0..count).find(|t| flat(areas[*t])) {
            return Err(ColliderError::Flat { triangle, area: areas[triangle] });
        }
        let boxes: Vec<Bounds> = (0..count).map(|t| Bounds::of(&mesh.corners(t))).collect();
        let (tree, names) = Tree::build(&boxes);
        let corners: Vec<[Vec3; 3]> = names.iter().map(|t| mesh.corners(*t as usize)).collect();
        let normals = corners.iter().map(|[a, b, c]| (b - a).cross(&(c - a)).normalize()).collect();
        let none = vec![[Vec3::zeros(); 3]; count];
        let mut surface = Self {
            mesh: mesh.clone(),
            tree,
            names,
            corners,
            normals,
            edge_normals: none.clone(),
            corner_normals: none,
            rims: vec![0; count],
            size,
        };
        surface.sum_normals();
        Ok(surface)
    }

    /// Normals of edges are sums of two, normals of corners are weighted by angles: with them the sign of the distance is right whichever
    /// triangle of an edge or corner is taken for the nearest one.
    ///
    /// # Reference
    /// J. A. Bærentzen, H. Aanæs, *Signed distance computation using the angle weighted pseudonormal*, IEEE Trans. Vis. Comput. Graph.
    /// 11(3), 2005, theorem in section 3.
    fn sum_normals(&mut self) {
        let mut edges: BTreeMap<[u32; 2], (Vec3, u32)> = BTreeMap::new();
        let mut points = vec![Vec3::zeros(); self.mesh.points().len()];
        for (t, name) in self.names.iter().enumerate() {
            let numbers = self.mesh.triangles()[*name as usize];
            for k in 0..3 {
                let edge = edges.entry(edge_of(&numbers, k)).or_insert((Vec3::zeros(), 0));
                edge.0 += self.normals[t];
                edge.1 += 1;
                let [at, next, last] = [0, 1, 2].map(|step| self.corners[t][(k + step) % 3]);
                let angle = (next - at).angle(&(last - at));
                points[numbers[k] as usize] += self.normals[t] * angle;
            }
        }
        let mut on_rim = vec![false; points.len()];
        for (edge, _) in edges.iter().filter(|(_, sum)| sum.1 == 1) {
            edge.iter().for_each(|point| on_rim[*point as usize] = true);
        }
        for (t, name) in self.names.iter().enumerate() {
            let numbers = self.mesh.triangles()[*name as usize];
            for k in 0..3 {
                if let Some((normal, count)) = edges.get(&edge_of(&numbers, k)) {
                    self.edge_normals[t][k] = *normal;
                    self.rims[t] |= u8::from(*count == 1) << k;
                }
                self.corner_normals[t][k] = points[numbers[k] as usize];
                self.rims[t] |= u8::from(on_rim[numbers[k] as usize]) << (3 + k);
            }
        }
    }

    pub(super) fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    /// The signed distance of a place, which is not farther away than `within` \[m\].
    ///
    /// The same bits for every `within` that is large enough.
    pub(super) fn signed_distance(&self, place: &Vec3, within: f64) -> SignedDistance {
        let mut found = None;
        let mut best = f64::INFINITY;
        self.tree.visit_nearest(place, within * within * (1.0 + 1e-9), |t| {
            let point = nearest(&self.corners[t], place);
            let square = (place - point.point).norm_squared();
            // Of equally near ones the first, in whatever order they are looked at.
            if square < best || (square == best && found.is_some_and(|(first, _)| t < first)) {
                best = square;
                found = Some((t, point));
            }
            square
        });
        let Some((t, point)) = found else {
            return self.signed_distance(place, f64::INFINITY);
        };
        let offset = place - point.point;
        let (normal, bit) = match point.feature {
            Feature::Face => {
                let (normal, nearest) = (self.normals[t], Side::Surface);
                return SignedDistance {
                    distance: normal.dot(&(place - self.corners[t][0])),
                    normal,
                    nearest,
                };
            }
            Feature::Edge(k) => (self.edge_normals[t][k], k),
            Feature::Corner(k) => (self.corner_normals[t][k], 3 + k),
        };
        let nearest = if self.rims[t] >> bit & 1 == 1 { Side::Rim } else { Side::Surface };
        let length = offset.norm();
        let sign = if offset.dot(&normal) < 0.0 { -1.0 } else { 1.0 };
        if length <= TOUCHING * self.size {
            return SignedDistance { distance: sign * length, normal: normal.normalize(), nearest };
        }
        SignedDistance { distance: sign * length, normal: offset * (sign / length), nearest }
    }

    /// Where the straight path from p to q first passes the surface: as part of the path, with the normal there.
    pub(super) fn first_crossing(&self, p: &Vec3, q: &Vec3) -> Option<(f64, Vec3)> {
        let mut first: Option<(f64, usize)> = None;
        let around = Bounds::of(&[*p, *q]).grown(OVERLAP * self.size);
        self.tree.visit_meeting(&around, |t| {
            if let Some(part) = crossing(&self.corners[t], [p, q], OVERLAP)
                && first.is_none_or(|first| (part, t) < first)
            {
                first = Some((part, t));
            }
        });
        first.map(|(part, t)| (part, self.normals[t]))
    }

    /// Pairs of triangles (t, u), t < u, whose boxes meet, for a range of t; in the order of the tree.
    pub(super) fn close_pairs(&self, t: usize, mut visit: impl FnMut(usize)) {
        self.tree.visit_meeting(&Bounds::of(&self.corners[t]), |u| {
            if u > t {
                visit(u);
            }
        });
    }

    /// The number in the mesh of a triangle of the tree.
    pub(super) fn name(&self, t: usize) -> usize {
        self.names[t] as usize
    }

    pub(super) fn count(&self) -> usize {
        self.names.len()
    }
}

/// The ends of edge `k`, the smaller one first.
fn edge_of(triangle: &[u32; 3], k: usize) -> [u32; 2] {
    let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
    [a.min(b), a.max(b)]
}
