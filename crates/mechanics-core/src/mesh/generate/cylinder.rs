use super::block::oriented;
use super::check_counts;
use crate::mesh::error::MeshError;
use crate::mesh::points::check_positive;
use crate::mesh::topology::sorted;
use crate::mesh::{TetMesh, TriMesh};
use crate::tensor::Vec3;

/// Whether a cylinder's surface has its two discs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CylinderEnds {
    /// With both discs: a closed surface.
    Closed,
    /// Only the side: a tube.
    Open,
}

/// A disc in concentric rings: the centre, then ring k = 1 … rings with 6 k points, counter-clockwise from +x.
struct Disc {
    points: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Disc {
    fn new(radius: f64, rings: u32) -> Self {
        let mut points = vec![[0.0, 0.0]];
        for k in 1..=rings {
            let r = radius * f64::from(k) / f64::from(rings);
            points.extend((0..6 * k).map(|j| {
                let (sine, cosine) = (std::f64::consts::TAU * f64::from(j) / f64::from(6 * k)).sin_cos();
                [r * cosine, r * sine]
            }));
        }
        let mut triangles = Vec::new();
        for k in 1..=rings {
            for sector in 0..6 {
                for j in 0..k {
                    let (inner, outer) = (sector * (k - 1) + j, sector * k + j);
                    triangles.push([
                        ring_point(k, outer),
                        ring_point(k, outer + 1),
                        ring_point(k - 1, inner),
                    ]);
                    if j + 1 < k {
                        let next = ring_point(k - 1, inner + 1);
                        triangles.push([ring_point(k - 1, inner), ring_point(k, outer + 1), next]);
                    }
                }
            }
        }
        Self { points, triangles }
    }

    fn at_height(&self, z: f64) -> impl Iterator<Item = Vec3> {
        self.points.iter().map(move |p| Vec3::new(p[0], p[1], z))
    }
}

/// The index of point `j` (cyclic) of ring `k`: 1 + 6 (1 + … + (k − 1)) points come before the ring.
fn ring_point(k: u32, j: u32) -> u32 {
    if k == 0 { 0 } else { 1 + 3 * k * (k - 1) + j % (6 * k) }
}

/// A solid cylinder of tetrahedra \[m\] around the z axis, from z = 0 to `height`: a disc of `rings` concentric rings
/// (6 `rings`² triangles, 6 `rings` points on the rim), drawn out into `layers` layers of prisms, each cut into
/// three tetrahedra. 18 rings² layers cells.
///
/// Every quadrilateral between two prisms is cut along the diagonal from the lower level's smaller point index to
/// the upper level's larger one, so neighbours agree. The volume is that of the prism over the regular polygon with
/// n = 6 `rings` corners: `½ n sin(2π/n) radius² height`.
///
/// # Errors
/// A radius or height that is not positive and finite; a count of zero, or beyond what 32 bits number.
pub fn cylinder(radius: f64, height: f64, rings: u32, layers: u32) -> Result<TetMesh, MeshError> {
    check_positive("radius", radius)?;
    check_positive("height", height)?;
    check_counts("rings or layers", &[rings, rings, layers], 18)?;
    let disc = Disc::new(radius, rings);
    let points: Vec<Vec3> =
        (0..=layers).flat_map(|k| disc.at_height(height * f64::from(k) / f64::from(layers))).collect();
    let level = disc.points.len() as u32;
    let prism = |k: u32, triangle: [u32; 3]| {
        let [a, b, c] = sorted(triangle).map(|i| i + k * level);
        let [d, e, f] = [a, b, c].map(|i| i + level);
        [[a, b, c, f], [a, b, e, f], [a, d, e, f]]
    };
    let tets = (0..layers)
        .flat_map(|k| disc.triangles.iter().flat_map(move |&t| prism(k, t)))
        .map(|tet| oriented(&points, tet))
        .collect();
    TetMesh::new(points, tets)
}

/// The surface of a cylinder \[m\] around the z axis, from z = 0 to `height`, with outward normals: 6 `rings` points
/// around, `layers` rows of quadrilaterals cut into two triangles, and for [`CylinderEnds::Closed`] two discs of 6
/// `rings`² triangles.
///
/// # Errors
/// As [`cylinder`].
pub fn cylinder_surface(
    radius: f64,
    height: f64,
    rings: u32,
    layers: u32,
    ends: CylinderEnds,
) -> Result<TriMesh, MeshError> {
    check_positive("radius", radius)?;
    check_positive("height", height)?;
    check_counts("rings or layers", &[rings, rings.max(layers)], 12)?;
    let disc = Disc::new(radius, rings);
    let around = 6 * rings;
    let rim = ring_point(rings, 0) as usize;
    // The side's levels first; a closed cylinder's inner disc points follow, bottom then top.
    let mut points: Vec<Vec3> = (0..=layers)
        .flat_map(|k| disc.at_height(height * f64::from(k) / f64::from(layers)).skip(rim))
        .collect();
    let mut triangles = Vec::new();
    for k in 0..layers {
        for j in 0..around {
            let [a, b] = [j, (j + 1) % around].map(|j| k * around + j);
            triangles.extend([[a, b, b + around], [a, b + around, a + around]]);
        }
    }
    if ends == CylinderEnds::Closed {
        for (z, level) in [(0.0, 0), (height, layers)] {
            let inner = points.len() as u32;
            points.extend(disc.at_height(z).take(rim));
            let renumber =
                |i: u32| if (i as usize) < rim { inner + i } else { level * around + i - rim as u32 };
            let turn = |[a, b, c]: [u32; 3]| if level == 0 { [a, c, b] } else { [a, b, c] };
            triangles.extend(disc.triangles.iter().map(|t| turn(t.map(renumber))));
        }
    }
    TriMesh::new(points, triangles)
}
