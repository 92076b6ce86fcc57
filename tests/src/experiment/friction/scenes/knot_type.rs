//! Which knot: the determinant of a closed chain, a number that no motion without passing through can change.
//!
//! Seen along a direction, a chain crosses itself; cut at every undercrossing it falls into as many arcs as there are crossings. A colouring
//! gives each arc a number such that at each crossing twice that of the arc above is the sum of those of both arcs that end below.
//! The determinant is the absolute value of any minor of the matrix of these equations: 1 for a circle, 3 for the
//! trefoil, 5 for the figure of eight.
//!
//! # Reference
//! R. H. Fox, *A quick trip through knot theory*, 1962; C. Livingston, *Knot Theory*, 1993, chapter 3.

use mechanics_core::tensor::Vec3;
use nalgebra::DMatrix;

/// A place where the chain, seen along −z, passes under itself.
struct Crossing {
    /// Where along the chain it is below, and above: the number of the segment and the part of it.
    below: f64,
    above: f64,
}

/// The crossings of a closed chain, in the order in which it passes below.
fn crossings(chain: &[Vec3]) -> Vec<Crossing> {
    let n = chain.len();
    let segment = |i: usize| (chain[i], chain[(i + 1) % n] - chain[i]);
    let mut found = Vec::new();
    for i in 0..n {
        let (a, u) = segment(i);
        for j in i + 2..n {
            if i == 0 && j == n - 1 {
                continue;
            }
            let (b, v) = segment(j);
            let (d, cross) = (b - a, u.xy().perp(&v.xy()));
            let s = d.xy().perp(&v.xy()) / cross;
            let t = d.xy().perp(&u.xy()) / cross;
            if !((0.0..1.0).contains(&s) && (0.0..1.0).contains(&t)) {
                continue;
            }
            let places = [i as f64 + s, j as f64 + t];
            let first_is_above = a.z + s * u.z > b.z + t * v.z;
            let [above, below] = if first_is_above { places } else { [places[1], places[0]] };
            found.push(Crossing { below, above });
        }
    }
    found.sort_by(|a, b| a.below.total_cmp(&b.below));
    found
}

/// The determinant of the knot that a closed chain makes, whose last point is joined to the first. Exact but for the crossings' rounding, as
/// long as the determinant is below 2⁵⁰ or so. The chain is turned a little, so that it need not be in general position.
pub(super) fn determinant(chain: &[Vec3]) -> f64 {
    // Shears as general as any.
    let turned: Vec<Vec3> = chain
        .iter()
        .map(|p| Vec3::new(p.x + 0.137 * p.z + 0.01 * p.y, p.y - 0.0713 * p.z + 0.0173 * p.x, p.z))
        .collect();
    let crossings = crossings(&turned);
    let count = crossings.len();
    if count < 3 {
        return 1.0;
    }
    // Arc k begins at undercrossing k and ends at the next.
    let arc = |place: f64| (crossings.partition_point(|c| c.below < place) + count - 1) % count;
    let mut equations = DMatrix::<f64>::zeros(count, count);
    for (k, crossing) in crossings.iter().enumerate() {
        equations[(k, arc(crossing.above))] += 2.0;
        equations[(k, k)] -= 1.0;
        equations[(k, (k + count - 1) % count)] -= 1.0;
    }
    equations.remove_row(0).remove_column(0).determinant().abs().round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn closed(at: impl Fn(f64) -> [f64; 3]) -> Vec<Vec3> {
        (0..150).map(|k| Vec3::from(at(TAU * f64::from(k) / 150.0))).collect()
    }

    /// Determinants of the tables: trefoil 3, figure of eight 5, torus knot (2, 7) 7; a circle with twists 1.
    #[test]
    fn determinants_are_those_of_the_tables() {
        let torus = |p: f64, q: f64| {
            closed(move |t| {
                let r = 2.0 + (q * t).cos();
                [r * (p * t).cos(), r * (p * t).sin(), -(q * t).sin()]
            })
        };
        assert_eq!(determinant(&torus(2.0, 3.0)), 3.0);
        assert_eq!(determinant(&torus(2.0, 5.0)), 5.0);
        assert_eq!(determinant(&torus(2.0, 7.0)), 7.0);
        assert_eq!(determinant(&torus(3.0, 4.0)), 3.0);
        assert_eq!(determinant(&torus(1.0, 5.0)), 1.0);
        let eight = closed(|t| {
            let r = 2.0 + (2.0 * t).cos();
            [r * (3.0 * t).cos(), r * (3.0 * t).sin(), (4.0 * t).sin()]
        });
        assert_eq!(determinant(&eight), 5.0);
        let flat = closed(|t| [t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos(), t]);
        assert_eq!(determinant(&flat), 1.0);
    }
}
