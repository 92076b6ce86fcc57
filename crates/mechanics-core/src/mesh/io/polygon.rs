//! Polygons cut into triangles.

use crate::mesh::triangle_area_vector;
use crate::tensor::Vec3;

/// The most corners of a polygon that is not a fan: cutting ears takes up to the cube of their number.
const MOST_CORNERS: usize = 256;

/// A triangle of a fan may be turned over by this part of the polygon's area, which is rounding.
const ROUNDING: f64 = 1e-12;

/// What the readers that use [`triangulate`] say when they refuse a polygon.
pub(super) const SUPPORTED: &str =
    "polygons may not cross themselves, nor be concave with more than 256 corners";

/// Cuts a polygon into triangles that all face as it does, as triples of positions in `corners`.
///
/// Which way the polygon faces is the sum of the area vectors of its fan (Newell). A fan from the first corner is
/// kept where no triangle of it is turned over; that covers convex polygons in linear time. Otherwise ears are cut
/// off: corners that turn the polygon's way and whose triangle holds no other corner, of which a simple polygon always
/// has two (Meisters 1975). A polygon without area is cut as a fan.
///
/// # Errors
/// What the culprit is, if the polygon crosses itself or is concave with more corners than [`MOST_CORNERS`].
pub(super) fn triangulate(corners: &[Vec3]) -> Result<Vec<[usize; 3]>, String> {
    let points = scaled(corners);
    let fan: Vec<[usize; 3]> = (1..points.len().saturating_sub(1)).map(|k| [0, k, k + 1]).collect();
    let areas: Vec<Vec3> = fan.iter().map(|t| triangle_area_vector(&t.map(|k| points[k]))).collect();
    let normal: Vec3 = areas.iter().sum();
    let least = -ROUNDING * normal.norm_squared();
    let covered: f64 = areas.iter().map(|area| area.norm()).sum();
    if covered == 0.0 || (normal != Vec3::zeros() && areas.iter().all(|area| area.dot(&normal) >= least)) {
        return Ok(fan);
    }
    if points.len() > MOST_CORNERS {
        return Err(format!("a concave polygon of {} corners", points.len()));
    }
    without_ears(&points, &normal).ok_or_else(|| "a polygon that crosses itself".to_owned())
}

/// The corners relative to the first, the largest component being one, so that no product overflows.
fn scaled(corners: &[Vec3]) -> Vec<Vec3> {
    let half: Vec<Vec3> = corners.iter().map(|p| p * 0.5 - corners[0] * 0.5).collect();
    let size = half.iter().map(|p| p.amax()).fold(0.0, f64::max);
    half.iter().map(|p| p.map(|x| if size > 0.0 { x / size } else { 0.0 })).collect()
}

fn without_ears(points: &[Vec3], normal: &Vec3) -> Option<Vec<[usize; 3]>> {
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::new();
    while left.len() > 3 {
        let n = left.len();
        let around = |k: usize| [left[(k + n - 1) % n], left[k], left[(k + 1) % n]];
        let ear = (0..n).find(|&k| is_ear(points, normal, &left, around(k)))?;
        triangles.push(around(ear));
        left.remove(ear);
    }
    let last = [left[0], left[1], left[2]];
    (side(points, normal, last) >= -ROUNDING * normal.norm_squared()).then(|| triangles.push(last))?;
    Some(triangles)
}

/// Twice the area of the triangle as seen along the normal, times the normal's length.
fn side(points: &[Vec3], normal: &Vec3, triangle: [usize; 3]) -> f64 {
    2.0 * triangle_area_vector(&triangle.map(|k| points[k])).dot(normal)
}

fn is_ear(points: &[Vec3], normal: &Vec3, left: &[usize], [a, b, c]: [usize; 3]) -> bool {
    let holds = |p: usize| {
        [[a, b, p], [b, c, p], [c, a, p]].into_iter().all(|part| side(points, normal, part) >= 0.0)
    };
    side(points, normal, [a, b, c]) > 0.0
        && !left.iter().any(|&p| {
            // A corner that a bridge to a hole visits twice touches the ear, and does no harm.
            ![a, b, c].iter().any(|&corner| points[corner] == points[p]) && holds(p)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn flat(corners: &[[f64; 2]]) -> Vec<Vec3> {
        corners.iter().map(|p| Vec3::new(p[0], p[1], 3.0)).collect()
    }

    /// The signed area by the shoelace formula.
    fn shoelace(corners: &[[f64; 2]]) -> f64 {
        let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
        0.5 * pairs.map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum::<f64>()
    }

    /// A star with `n` points, its inner corners at `inner` of the radius, started at corner `first`.
    fn star(n: usize, inner: f64, first: usize) -> Vec<[f64; 2]> {
        let corner = |k: usize| {
            let (sine, cosine) = (TAU * (k + first) as f64 / (2 * n) as f64).sin_cos();
            let radius = if (k + first).is_multiple_of(2) { 1.0 } else { inner };
            [radius * cosine, radius * sine]
        };
        (0..2 * n).map(corner).collect()
    }

    #[test]
    fn triangles_of_simple_polygons_cover_the_area_once_and_face_one_way() {
        let comb = |teeth: usize| {
            let top = |k: usize| [(2 * teeth - k) as f64, if k.is_multiple_of(2) { 1.0 } else { 5.0 }];
            [[0.0, 0.0], [2.0 * teeth as f64, 0.0]].into_iter().chain((0..=2 * teeth).map(top)).collect()
        };
        let mut polygons: Vec<Vec<[f64; 2]>> = vec![
            vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]],
            vec![[1.0, 1.0], [1.0, 2.0], [0.0, 2.0], [0.0, 0.0], [2.0, 0.0], [2.0, 1.0]],
            vec![[0.0, 0.0], [4.0, -1.0], [1.0, 0.0], [4.0, 1.0]],
            vec![[4.0, 1.0], [0.0, 0.0], [4.0, -1.0], [1.0, 0.0]],
            comb(40),
        ];
        polygons.extend((0..14).map(|first| star(7, 0.2, first)));
        for mut polygon in polygons {
            for scale in [1.0, 1e-160, 1e300] {
                for _ in 0..2 {
                    let corners: Vec<Vec3> = flat(&polygon).iter().map(|p| p * scale).collect();
                    let triangles = triangulate(&corners).unwrap();
                    assert_eq!(triangles.len(), polygon.len() - 2);
                    let parts = triangles.iter().map(|t| shoelace(&t.map(|k| polygon[k])));
                    let area = shoelace(&polygon);
                    assert!(parts.clone().all(|part| part * area >= 0.0), "{polygon:?}: {triangles:?}");
                    assert!((parts.sum::<f64>() - area).abs() < 1e-12 * area.abs(), "{polygon:?}");
                    polygon.reverse();
                }
            }
        }
    }

    #[test]
    fn polygons_without_a_meaning_are_refused_and_flat_ones_are_not() {
        let bow_tie = flat(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
        let lopsided = flat(&[[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 1.0]]);
        for crossed in [bow_tie, lopsided] {
            assert_eq!(triangulate(&crossed).unwrap_err(), "a polygon that crosses itself");
        }
        assert!(triangulate(&flat(&star(200, 0.2, 1))).unwrap_err().contains("400 corners"));
        let line = flat(&[[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [2.0, 0.0]]);
        assert_eq!(triangulate(&line).unwrap(), [[0, 1, 2], [0, 2, 3]]);
        let circle: Vec<Vec3> = (0..5000)
            .map(|k| TAU * f64::from(k) / 5000.0)
            .map(|t| Vec3::new(t.cos(), t.sin(), 0.0))
            .collect();
        assert_eq!(
            triangulate(&circle).unwrap().len(),
            4998,
            "convex polygons may have any number of corners"
        );
    }
}
