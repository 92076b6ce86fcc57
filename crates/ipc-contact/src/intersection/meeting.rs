//! Whether a segment meets a triangle or another segment, by signs alone.

use super::predicates::{self, Projection, orientation};
use mechanics_core::tensor::Vec3;
use std::cmp::Ordering;

/// Whether the closed segment pq and the closed triangle abc share a point. Exact for all finite coordinates; p = q is a
/// point, and a triangle of no area is the segment or the point it covers.
///
/// # Derivation
/// Let s(·) be the side of the plane abc. If p and q are strictly on the same side, there is no common point. If not both
/// are in the plane, the line pq crosses the plane in exactly one point, which is on the segment; it is in the triangle
/// unless the line passes two of the directed edges ab, bc, ca on strictly opposite sides, that is, unless the volumes
/// (p, q, a, b), (p, q, b, c), (p, q, c, a) have both signs. If both are in the plane, a projection along a coordinate axis
/// in which the triangle keeps an area is one-to-one on the plane and leaves a question in two dimensions: p is in the
/// triangle, or the segment meets one of its sides. If there is no such projection, the triangle has no area and is the
/// union of its sides (all volumes are zero then, so that this case is reached).
pub fn segment_meets_triangle([p, q]: [&Vec3; 2], triangle: [&Vec3; 3]) -> bool {
    let [a, b, c] = triangle;
    let sides = (orientation(a, b, c, p), orientation(a, b, c, q));
    segment_meets_triangle_given_sides(sides, [p, q], triangle)
}

/// As [`segment_meets_triangle`], where the sides of p and q of the triangle's plane are known.
pub(super) fn segment_meets_triangle_given_sides(
    sides: (i8, i8),
    [p, q]: [&Vec3; 2],
    [a, b, c]: [&Vec3; 3],
) -> bool {
    match sides {
        (0, 0) => meets_in_plane([p, q], [a, b, c]),
        (first, second) if first == second => false,
        _ => {
            let first = orientation(p, q, a, b);
            let second = orientation(p, q, b, c);
            first * second >= 0 && {
                let third = orientation(p, q, c, a);
                first * third >= 0 && second * third >= 0
            }
        }
    }
}

/// The case of four or five points in one plane.
fn meets_in_plane([p, q]: [&Vec3; 2], [a, b, c]: [&Vec3; 3]) -> bool {
    let sides = [[a, b], [b, c], [c, a]];
    match Projection::ALL.into_iter().find(|along| along.turn(a, b, c) != 0) {
        None => sides.into_iter().any(|side| segments_meet([p, q], side)),
        Some(along) => {
            let turns = sides.map(|[a, b]| along.turn(a, b, p));
            let inside = !(turns.contains(&1) && turns.contains(&-1));
            inside || sides.into_iter().any(|side| meet_in_projection(along, [p, q], side))
        }
    }
}

/// Whether the closed segments pq and ab share a point. Exact for all finite coordinates; either may be a point.
///
/// # Derivation
/// Two segments that meet are in one plane. A projection along a coordinate axis in which some three of the four points
/// are not on a line is one-to-one on that plane and leaves the question in two dimensions. If there is none, all four are
/// on one line in space, along which the lexicographic order of coordinates is monotone: two intervals meet if
/// neither begins after the other's end.
pub fn segments_meet([p, q]: [&Vec3; 2], [a, b]: [&Vec3; 2]) -> bool {
    if predicates::orientation(p, q, a, b) != 0 {
        return false;
    }
    let triples = [[p, q, a], [p, q, b], [a, b, p], [a, b, q]];
    let spread = |along: &Projection| triples.iter().any(|[i, j, k]| along.turn(i, j, k) != 0);
    match Projection::ALL.into_iter().find(spread) {
        Some(along) => meet_in_projection(along, [p, q], [a, b]),
        None => intervals_meet([p, q], [a, b]),
    }
}

/// Segments in one plane, seen along an axis in which that plane is not a line.
///
/// Unless all four are on a line, they meet exactly if neither segment's line has both ends of the other strictly on one
/// side; a segment that is a point has its two ends on the same side of the other's line, or on it.
fn meet_in_projection(along: Projection, [p, q]: [&Vec3; 2], [a, b]: [&Vec3; 2]) -> bool {
    let ends_of_second = (along.turn(p, q, a), along.turn(p, q, b));
    let ends_of_first = (along.turn(a, b, p), along.turn(a, b, q));
    if (ends_of_second, ends_of_first) == ((0, 0), (0, 0)) {
        return intervals_meet([p, q], [a, b]);
    }
    ends_of_second.0 * ends_of_second.1 <= 0 && ends_of_first.0 * ends_of_first.1 <= 0
}

/// Segments on one line.
fn intervals_meet([p, q]: [&Vec3; 2], [a, b]: [&Vec3; 2]) -> bool {
    let [(p, q), (a, b)] = [(p, q), (a, b)].map(|(i, j)| if before(j, i) { (j, i) } else { (i, j) });
    !before(q, a) && !before(b, p)
}

/// Whether `p` comes strictly before `q` in the lexicographic order of coordinates.
fn before(p: &Vec3, q: &Vec3) -> bool {
    let order = p.iter().zip(q.iter()).map(|(a, b)| a.partial_cmp(b).unwrap_or(Ordering::Equal));
    order.fold(Ordering::Equal, Ordering::then) == Ordering::Less
}
