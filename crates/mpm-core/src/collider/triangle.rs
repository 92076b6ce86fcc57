//! The point of a triangle that is nearest to a place.

use mechanics_core::tensor::Vec3;

/// Which part of a triangle a point belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    Face,
    /// From corner k to corner k + 1.
    Edge(usize),
    Corner(usize),
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub(super) feature: Feature,
    pub(super) point: Vec3,
}

/// The nearest point of the triangle to a place.
///
/// With the corners a, b, c and p the place, the signs of (p − corner)·(side from it) tell whether p lies beyond a corner, and the areas
/// of the projected triangles pab, pbc, pca (up to a common factor the barycentric coordinates of the projection) whether it lies
/// beyond a side or above the face.
///
/// # Reference
/// C. Ericson, *Real-Time Collision Detection*, Morgan Kaufmann 2005, section 5.1.5.
pub(super) fn nearest([a, b, c]: &[Vec3; 3], place: &Vec3) -> Nearest {
    let corner = |k, point: &Vec3| Nearest { feature: Feature::Corner(k), point: *point };
    let side =
        |k, from: &Vec3, to: Vec3, part: f64| Nearest { feature: Feature::Edge(k), point: from + to * part };
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let pa = place - a;
    let (ab_a, ac_a) = (ab.dot(&pa), ac.dot(&pa));
    if ab_a <= 0.0 && ac_a <= 0.0 {
        return corner(0, a);
    }
    let pb = place - b;
    let (ab_b, ac_b) = (ab.dot(&pb), ac.dot(&pb));
    if ab_b >= 0.0 && ac_b <= ab_b {
        return corner(1, b);
    }
    let above_ab = ab_a * ac_b - ab_b * ac_a;
    if above_ab <= 0.0 && ab_a >= 0.0 && ab_b <= 0.0 {
        return side(0, a, ab, ab_a / (ab_a - ab_b));
    }
    let pc = place - c;
    let (ab_c, ac_c) = (ab.dot(&pc), ac.dot(&pc));
    if ac_c >= 0.0 && ab_c <= ac_c {
        return corner(2, c);
    }
    let above_ca = ab_c * ac_a - ab_a * ac_c;
    if above_ca <= 0.0 && ac_a >= 0.0 && ac_c <= 0.0 {
        return side(2, c, -ac, -ac_c / (ac_a - ac_c));
    }
    let above_bc = ab_b * ac_c - ab_c * ac_b;
    let (from_b, from_c) = (ac_b - ab_b, ab_c - ac_c);
    if above_bc <= 0.0 && from_b >= 0.0 && from_c >= 0.0 {
        return side(1, b, bc, from_b / (from_b + from_c));
    }
    let whole = above_ab + above_bc + above_ca;
    let point = a + ab * (above_ca / whole) + ac * (above_ab / whole);
    Nearest { feature: Feature::Face, point }
}

/// Where the segment from p to q first passes through the triangle, as part of the segment; triangles are taken larger by `margin` in
/// barycentric coordinates, so that nothing slips through between two of them. `None` for a segment in the plane.
pub(super) fn crossing([a, b, c]: &[Vec3; 3], [p, q]: [&Vec3; 2], margin: f64) -> Option<f64> {
    let normal = (b - a).cross(&(c - a));
    let (from, to) = (normal.dot(&(p - a)), normal.dot(&(q - a)));
    if from * to > 0.0 || from == to {
        return None;
    }
    let part = from / (from - to);
    let at = p + (q - p) * part;
    let square = normal.norm_squared();
    let inside = [[a, b], [b, c], [c, a]]
        .iter()
        .all(|[from, to]| normal.dot(&(*to - *from).cross(&(at - *from))) >= -margin * square);
    inside.then_some(part)
}
