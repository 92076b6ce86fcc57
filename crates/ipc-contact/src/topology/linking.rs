//! How often two closed chains are linked.

use super::{check_finite, side_of_moved};
use crate::ContactError;
use crate::intersection::{orientation, segments_meet};
use mechanics_core::tensor::Vec3;

/// The linking number of two closed polygons, whose last points are joined to their first: how often the second passes
/// through a surface spanned by the first, along its normal by the right-hand rule less against. An integer that no
/// motion without touching can change. Symmetric in its arguments; the sign changes with the direction of either. Exact for
/// all finite positions. Time is the product of the lengths.
///
/// # Derivation
/// By Gauss, lk = 1/4π ∮∮ (x − y)·(dx × dy)/|x − y|³, which is the intersection number of the second chain with any
/// oriented surface whose boundary is the first: here the fan of triangles (w, aᵢ, aᵢ₊₁) with the apex w at a₀, moved by
/// (δ², δ³, δ) for an arbitrarily small δ > 0. The segment pq passes through such a triangle if p and q are strictly on
/// opposite sides of its plane and the line pq passes its three sides the same way round. The moved apex leaves these
/// signs zero only if (i) p, or q, is on the line of aᵢaᵢ₊₁, or (ii) aᵢ, or aᵢ₊₁, is on the line pq, or (iii) the lines
/// pq and aᵢaᵢ₊₁ meet. As the chains do not touch, in none of these cases does the segment meet the moved triangle:
/// (i) it meets the plane only in that point of the triangle's border line, or lies in the plane of moved apex and border
/// with that line in common, outside of the border; (ii) the common point of line and plane is not on the segment;
/// (iii) the point where the lines meet is on the border's line outside of the border (and if they are parallel, p and q
/// are on the same side).
///
/// # Errors
/// [`ContactError::ChainsTouch`] names the first two segments that share a point, [`ContactError::NonFiniteQuery`] a
/// position that is infinite or NaN.
pub fn linking_number(first: &[Vec3], second: &[Vec3]) -> Result<i32, ContactError> {
    check_finite(first)?;
    check_finite(second)?;
    check_apart(first, second)?;
    let Some(apex) = first.first() else { return Ok(0) };
    Ok(segments(first).map(|border| passages(apex, border, second)).sum())
}

/// Each point and the one after it, round to the first.
fn segments(chain: &[Vec3]) -> impl Iterator<Item = [&Vec3; 2]> {
    chain.iter().zip(chain.iter().cycle().skip(1)).map(|(a, b)| [a, b])
}

fn check_apart(first: &[Vec3], second: &[Vec3]) -> Result<(), ContactError> {
    let apart = |[a, b]: [&Vec3; 2], [p, q]: [&Vec3; 2]| {
        (0..3).any(|k| a[k].max(b[k]) < p[k].min(q[k]) || p[k].max(q[k]) < a[k].min(b[k]))
    };
    for (i, border) in segments(first).enumerate() {
        for (j, segment) in segments(second).enumerate() {
            if !apart(border, segment) && segments_meet(border, segment) {
                return Err(ContactError::ChainsTouch { segments: [i as u32, j as u32] });
            }
        }
    }
    Ok(())
}

/// Passages of a chain through the triangle of a moved apex and a border segment, along its normal less against.
fn passages(apex: &Vec3, [a, b]: [&Vec3; 2], chain: &[Vec3]) -> i32 {
    // (w, a, b, p) and (a, b, p, w) differ by an odd permutation.
    let sides: Vec<i8> = chain.iter().map(|p| -side_of_moved(a, b, p, apex)).collect();
    let ends = sides.iter().zip(sides.iter().cycle().skip(1));
    let passage = |([p, q], (&start, &end)): ([&Vec3; 2], (&i8, &i8))| {
        if start * end >= 0 {
            return 0;
        }
        let turns = [orientation(p, q, a, b), side_of_moved(p, q, b, apex), -side_of_moved(p, q, a, apex)];
        if turns == [end; 3] || turns == [-end; 3] { i32::from(end) } else { 0 }
    };
    segments(chain).zip(ends).map(passage).sum()
}
