//! How well shaped tetrahedra and triangles are.

use super::{TetMesh, TriMesh};
use crate::tensor::Vec3;

/// Shape measures of one tetrahedron with edges lᵢ, faces Aᵢ, signed volume V, inradius r = 3|V|/ΣAᵢ and
/// circumradius R. All but the edge lengths and the volume are independent of size, position and rotation. Every
/// measure has a defined value for degenerate cells, and none of them is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TetQuality {
    /// V \[m³\]; negative for inverted cells.
    pub volume: f64,
    /// The smallest of the six angles between faces \[rad\], in [0, π]; arccos(1/3) in the regular tetrahedron. 0 if
    /// an edge or a face at it has no extent.
    pub min_dihedral_angle: f64,
    /// The largest of the six angles between faces \[rad\], in [0, π].
    pub max_dihedral_angle: f64,
    /// The shortest edge \[m\].
    pub min_edge: f64,
    /// The longest edge \[m\].
    pub max_edge: f64,
    /// 3 r / R in [0, 1]: 1 regular, 0 flat; blind to inversion.
    pub radius_ratio: f64,
    /// max l / (2√6 r) in [1, ∞]: 1 regular, ∞ flat; blind to inversion.
    pub aspect_ratio: f64,
    /// sign(V) 12 (3|V|)^⅔ / Σ lᵢ² in [−1, 1]: 1 regular, 0 flat, negative inverted.
    pub mean_ratio: f64,
}

/// Shape measures of one triangle with edges lᵢ, area A, inradius r and circumradius R; never NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleQuality {
    /// A \[m²\].
    pub area: f64,
    /// The smallest angle \[rad\], in [0, π/3]. 0 at an edge without length.
    pub min_angle: f64,
    /// The largest angle \[rad\], in [0, π].
    pub max_angle: f64,
    /// The shortest edge \[m\].
    pub min_edge: f64,
    /// The longest edge \[m\].
    pub max_edge: f64,
    /// 2 r / R in [0, 1]: 1 equilateral, 0 flat.
    pub radius_ratio: f64,
    /// max l / (2√3 r) in [1, ∞]: 1 equilateral, ∞ flat.
    pub aspect_ratio: f64,
    /// 4√3 A / Σ lᵢ² in [0, 1]: 1 equilateral, 0 flat.
    pub mean_ratio: f64,
}

/// An extreme value over all cells, and the first cell that has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// The value.
    pub value: f64,
    /// The cell's index.
    pub cell: usize,
}

/// The worst of each measure over the tetrahedra of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QualitySummary {
    /// The smallest signed volume \[m³\].
    pub volume: Worst,
    /// The smallest dihedral angle \[rad\].
    pub min_dihedral_angle: Worst,
    /// The largest dihedral angle \[rad\].
    pub max_dihedral_angle: Worst,
    /// The shortest edge \[m\].
    pub min_edge: Worst,
    /// The longest edge \[m\].
    pub max_edge: Worst,
    /// The smallest radius ratio.
    pub radius_ratio: Worst,
    /// The largest aspect ratio.
    pub aspect_ratio: Worst,
    /// The smallest mean ratio.
    pub mean_ratio: Worst,
}

/// The shape measures of the tetrahedron with these corners \[m\].
///
/// The angle at the edge from p along e, between the faces that hold u and v (both from p), is
/// `atan2(|m × n|, m · n)` with the face normals m = e × u, n = e × v, where |m × n| = |e| · 6|V| by the identity
/// (e × u) × (e × v) = e (e · u × v). Unlike the arccos of normalised normals it loses no digits near 0 and π. The
/// circumradius is `|u² (v × w) + v² (w × u) + w² (u × v)| / 12|V|` for the edges u, v, w from one corner. Lengths are
/// divided by the largest edge component first, so that nothing overflows or underflows for cells of any size.
///
/// # Reference
/// Liu and Joe 1994, "Relationship between tetrahedron shape measures", BIT 34, §2: radius ratio and mean ratio.
pub fn tet_quality(corners: &[Vec3; 4]) -> TetQuality {
    let (size, [u, v, w]) = scaled_edges(corners);
    if size == 0.0 {
        return degenerate_tet();
    }
    let (normals, edges) = ([u.cross(&v), v.cross(&w), w.cross(&u)], [u, v, w, v - u, w - v, u - w]);
    let opposite = (v - u).cross(&(w - u));
    let six_volumes = u.cross(&v).dot(&w);
    let (min_dihedral_angle, max_dihedral_angle) = dihedral_range([u, v, w], six_volumes);
    let lengths = edges.map(|e| e.norm());
    let (min_edge, max_edge) = range(&lengths);
    let face_sum = opposite.norm() + normals.iter().map(|n| n.norm()).sum::<f64>();
    let circum =
        (normals[1] * u.norm_squared() + normals[2] * v.norm_squared() + normals[0] * w.norm_squared())
            .norm();
    // With 2A summed: r = 6|V| / Σ2A and R = circum / (2 · 6|V|).
    let inradius = ratio(six_volumes.abs(), face_sum, 0.0);
    let square_sum: f64 = lengths.iter().map(|l| l * l).sum();
    TetQuality {
        volume: super::tet_volume(corners),
        min_dihedral_angle,
        max_dihedral_angle,
        min_edge: min_edge * size,
        max_edge: max_edge * size,
        radius_ratio: ratio(6.0 * inradius * six_volumes.abs(), circum, 0.0).min(1.0),
        aspect_ratio: ratio(max_edge, 24.0_f64.sqrt() * inradius, f64::INFINITY).max(1.0),
        mean_ratio: six_volumes.signum() * 12.0 * (six_volumes.abs() * 0.5).cbrt().powi(2) / square_sum,
    }
}

/// The shape measures of the triangle with these corners \[m\]; angles as `atan2(|u × v|, u · v)`.
pub fn triangle_quality(corners: &[Vec3; 3]) -> TriangleQuality {
    let (size, [u, v]) = scaled_edges(corners);
    if size == 0.0 {
        return degenerate_triangle();
    }
    let w = v - u;
    let double_area = u.cross(&v).norm();
    let angles = [u.dot(&v), -u.dot(&w), v.dot(&w)].map(|cosine| double_area.atan2(cosine));
    let (min_angle, max_angle) = range(&angles);
    let lengths = [u.norm(), v.norm(), w.norm()];
    let (min_edge, max_edge) = range(&lengths);
    let perimeter: f64 = lengths.iter().sum();
    let inradius = double_area / perimeter;
    let product: f64 = lengths.iter().product();
    let square_sum: f64 = lengths.iter().map(|l| l * l).sum();
    TriangleQuality {
        area: super::triangle_area_vector(corners).norm(),
        min_angle: if min_edge == 0.0 { 0.0 } else { min_angle },
        max_angle,
        min_edge: min_edge * size,
        max_edge: max_edge * size,
        radius_ratio: ratio(4.0 * inradius * double_area, product, 0.0).min(1.0),
        aspect_ratio: ratio(max_edge, 12.0_f64.sqrt() * inradius, f64::INFINITY).max(1.0),
        mean_ratio: 12.0_f64.sqrt() * double_area / square_sum,
    }
}

impl TetMesh {
    /// The shape measures of every tetrahedron.
    pub fn qualities(&self) -> Vec<TetQuality> {
        (0..self.cells().len()).map(|t| tet_quality(&self.corners(t))).collect()
    }

    /// The worst of each measure with the cell that has it; `None` for a mesh without cells.
    pub fn quality_summary(&self) -> Option<QualitySummary> {
        let all = self.qualities();
        let smallest = |measure: fn(&TetQuality) -> f64| extreme(&all, measure);
        let largest = |measure: fn(&TetQuality) -> f64| {
            extreme(&all, |q| -measure(q)).map(|w| Worst { value: -w.value, ..w })
        };
        Some(QualitySummary {
            volume: smallest(|q| q.volume)?,
            min_dihedral_angle: smallest(|q| q.min_dihedral_angle)?,
            max_dihedral_angle: largest(|q| q.max_dihedral_angle)?,
            min_edge: smallest(|q| q.min_edge)?,
            max_edge: largest(|q| q.max_edge)?,
            radius_ratio: smallest(|q| q.radius_ratio)?,
            aspect_ratio: largest(|q| q.aspect_ratio)?,
            mean_ratio: smallest(|q| q.mean_ratio)?,
        })
    }
}

impl TriMesh {
    /// The shape measures of every triangle.
    pub fn qualities(&self) -> Vec<TriangleQuality> {
        (0..self.triangles().len()).map(|t| triangle_quality(&self.corners(t))).collect()
    }
}

fn extreme(all: &[TetQuality], measure: impl Fn(&TetQuality) -> f64) -> Option<Worst> {
    let values = all.iter().map(measure).enumerate().map(|(cell, value)| Worst { value, cell });
    values.reduce(|best, next| if next.value < best.value { next } else { best })
}

/// The largest edge component, and the edges from the first corner divided by it (or zero).
fn scaled_edges<const N: usize, const E: usize>(corners: &[Vec3; N]) -> (f64, [Vec3; E]) {
    // Halving before subtracting keeps the difference of two huge coordinates finite.
    let half: [Vec3; E] = std::array::from_fn(|k| corners[k + 1] * 0.5 - corners[0] * 0.5);
    let half_size = half.iter().map(|e| e.amax()).fold(0.0, f64::max);
    if half_size == 0.0 {
        return (0.0, [Vec3::zeros(); E]);
    }
    (2.0 * half_size, half.map(|e| e.map(|x| x / half_size)))
}

fn dihedral_range([u, v, w]: [Vec3; 3], six_volumes: f64) -> (f64, f64) {
    // Each edge e with the vectors from its start to the other two corners.
    let around =
        [(u, v, w), (v, w, u), (w, u, v), (v - u, -u, w - u), (w - u, -u, v - u), (w - v, -v, u - v)];
    let angle = |(e, p, q): (Vec3, Vec3, Vec3)| {
        // Adding zero turns −0 into +0, so that a face without extent gives the angle 0 and not π.
        (e.norm() * six_volumes.abs()).atan2(e.cross(&p).dot(&e.cross(&q)) + 0.0)
    };
    range(&around.map(angle))
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)))
}

/// a / b, or `at_zero` if b is zero.
fn ratio(a: f64, b: f64, at_zero: f64) -> f64 {
    if b == 0.0 { at_zero } else { a / b }
}

fn degenerate_tet() -> TetQuality {
    TetQuality {
        volume: 0.0,
        min_dihedral_angle: 0.0,
        max_dihedral_angle: 0.0,
        min_edge: 0.0,
        max_edge: 0.0,
        radius_ratio: 0.0,
        aspect_ratio: f64::INFINITY,
        mean_ratio: 0.0,
    }
}

fn degenerate_triangle() -> TriangleQuality {
    TriangleQuality {
        area: 0.0,
        min_angle: 0.0,
        max_angle: 0.0,
        min_edge: 0.0,
        max_edge: 0.0,
        radius_ratio: 0.0,
        aspect_ratio: f64::INFINITY,
        mean_ratio: 0.0,
    }
}
