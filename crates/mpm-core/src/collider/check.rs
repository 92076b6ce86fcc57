//! Whether a surface is a collider: no two triangles meet but in what they share, and the outside is outside.

use super::ColliderError;
use super::surface::TriangleSurface;
use crate::sampling::winding_number;
use mechanics_core::parallel;
use mechanics_core::tensor::Vec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Triangles that a thread takes at a time.
const TRIANGLES: usize = 256;

/// Confirms that no two triangles meet away from what they share; exact for all numbers.
///
/// # Errors
/// [`ColliderError::SelfIntersection`] with the first pair.
pub(super) fn check_self_intersection(surface: &TriangleSurface) -> Result<(), ColliderError> {
    let found = parallel::map_chunks(surface.count(), TRIANGLES, |range| {
        let mut first: Option<[usize; 2]> = None;
        for t in range {
            surface.close_pairs(t, |u| {
                if meet(surface, [t, u]) {
                    let pair = [t, u].map(|k| surface.name(k));
                    let pair = [pair[0].min(pair[1]), pair[0].max(pair[1])];
                    first = Some(first.map_or(pair, |first| first.min(pair)));
                }
            });
        }
        first
    });
    match found.into_iter().flatten().min() {
        Some(triangles) => Err(ColliderError::SelfIntersection { triangles }),
        None => Ok(()),
    }
}

/// Confirms that the outer side of every part of a closed surface has the winding number 0, or 1 where its inner side has 0.
///
/// # Errors
/// [`ColliderError::InsideOut`] with the first triangle of the first part that does not.
pub(super) fn check_sides(surface: &TriangleSurface, parts: &[usize]) -> Result<(), ColliderError> {
    let mesh = surface.mesh();
    let corners: Vec<[Vec3; 3]> = (0..mesh.triangles().len()).map(|t| mesh.corners(t)).collect();
    for &triangle in parts {
        // On the surface itself, the triangle of the place contributes ±½: its solid angle is left out.
        let [a, b, c] = corners[triangle];
        let others = corners.iter().enumerate().filter(|(t, _)| *t != triangle).map(|(_, corners)| corners);
        let winding = winding_number(others, &((a + b + c) / 3.0)) - 0.5;
        if winding.abs() > 0.25 {
            return Err(ColliderError::InsideOut { triangle, winding: winding.round() });
        }
    }
    Ok(())
}

fn meet(surface: &TriangleSurface, pair: [usize; 2]) -> bool {
    let mesh = surface.mesh();
    let names = pair.map(|t| surface.name(t));
    let [first, second] = names.map(|t| mesh.triangles()[t]);
    let at = |point: u32| &mesh.points()[point as usize];
    let shared: Vec<u32> = first.into_iter().filter(|point| second.contains(point)).collect();
    let corners = [first, second].map(|triangle| triangle.map(at));
    let sides = |k: usize| {
        let [a, b, c] = corners[k];
        [[a, b], [b, c], [c, a]]
    };
    match shared[..] {
        [] => (0..2).any(|k| sides(k).iter().any(|side| segment_meets(*side, corners[1 - k]))),
        // What they share besides the corner reaches the side opposite to it in one of them.
        [point] => [first, second].iter().enumerate().any(|(k, triangle)| {
            let at = triangle.iter().position(|p| *p == point).unwrap_or(0);
            segment_meets(sides(k)[(at + 1) % 3], corners[1 - k])
        }),
        // Folded onto each other, or not.
        [_, _] => {
            let apex = second.into_iter().find(|point| !first.contains(point));
            let [a, b, c] = corners[0];
            let normal = |[a, b, c]: [&Vec3; 3]| (b - a).cross(&(c - a));
            apex.is_some_and(|apex| side_of([a, b, c], at(apex)) == 0)
                && normal(corners[0]).dot(&normal(corners[1])) < 0.0
        }
        _ => true,
    }
}

fn coordinates(p: &Vec3) -> Coord3D<f64> {
    Coord3D { x: p.x, y: p.y, z: p.z }
}

fn sign(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}

/// The side of a plane where a point is.
fn side_of([a, b, c]: [&Vec3; 3], p: &Vec3) -> i8 {
    sign(orient3d(coordinates(a), coordinates(b), coordinates(c), coordinates(p)))
}

/// Whether a segment and a triangle, both closed, share a point.
///
/// If its ends are not strictly on the same side of the plane, the segment crosses it; in the triangle, unless the line passes two of
/// its directed sides on strictly opposite sides. In the plane, an end is in the triangle or the segment crosses a side.
fn segment_meets([p, q]: [&Vec3; 2], [a, b, c]: [&Vec3; 3]) -> bool {
    let ends = (side_of([a, b, c], p), side_of([a, b, c], q));
    match ends {
        (0, 0) => meets_in_plane([p, q], [a, b, c]),
        (first, second) if first == second => false,
        _ => {
            let turns = [[a, b], [b, c], [c, a]].map(|[from, to]| side_of([p, q, from], to));
            !(turns.contains(&1) && turns.contains(&-1))
        }
    }
}

fn meets_in_plane([p, q]: [&Vec3; 2], [a, b, c]: [&Vec3; 3]) -> bool {
    // Along the axis in which the triangle is largest; it is not flat.
    let drop = (b - a).cross(&(c - a)).iamax();
    let flat = |x: &Vec3| Coord { x: x[(drop + 1) % 3], y: x[(drop + 2) % 3] };
    let turn = |a: &Vec3, b: &Vec3, c: &Vec3| sign(orient2d(flat(a), flat(b), flat(c)));
    let sides = [[a, b], [b, c], [c, a]];
    let inside = |x: &Vec3| {
        let turns = sides.map(|[from, to]| turn(from, to, x));
        !(turns.contains(&1) && turns.contains(&-1))
    };
    let crosses = |[a, b]: [&Vec3; 2]| turn(p, q, a) * turn(p, q, b) < 0 && turn(a, b, p) * turn(a, b, q) < 0;
    inside(p) || inside(q) || sides.into_iter().any(crosses)
}
