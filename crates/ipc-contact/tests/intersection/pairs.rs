//! One segment against one triangle or segment.

use super::oracle::hulls_meet;
use super::random::Random;
use ipc_contact::intersection::{segment_meets_triangle, segments_meet};
use mechanics_core::tensor::Vec3;

/// Checks both predicates on five points, and answers what was found.
fn check(points: &[Vec3; 5], what: &str) -> (bool, bool) {
    let [p, q, a, b, c] = points;
    let triangle = segment_meets_triangle([p, q], [a, b, c]);
    assert_eq!(triangle, hulls_meet(&[*p, *q], &[*a, *b, *c]), "{what}: segment and triangle {points:?}");
    let segment = segments_meet([p, q], [a, b]);
    assert_eq!(segment, hulls_meet(&[*p, *q], &[*a, *b]), "{what}: two segments {points:?}");
    (triangle, segment)
}

/// Points of a small grid: nearly every configuration is degenerate in some way.
#[test]
fn grid_points_agree_with_rational_arithmetic() {
    for (range, count) in [(1, 1200), (2, 1200), (4, 800)] {
        let mut random = Random(range as u64);
        let (mut met, mut missed, mut touching) = (0, 0, 0);
        for _ in 0..count {
            let points: [Vec3; 5] = std::array::from_fn(|_| random.grid_point(-range, range));
            let found = check(&points, "grid");
            (met, missed) = (met + i32::from(found.0), missed + i32::from(!found.0));
            touching += i32::from(found.1);
        }
        assert!(
            met > 50 && missed > 100 && (range == 4 || touching > 30),
            "{range}: {met} {missed} {touching}"
        );
    }
}

/// All five points in one plane, on one line, or coincident: what the general case never reaches.
#[test]
fn planar_linear_and_coincident_points_agree_with_rational_arithmetic() {
    let mut random = Random(5);
    for k in 0..1500 {
        let [u, v] = [0, 1].map(|_| random.grid_point(-2, 2));
        let dimension = [2, 2, 1, 0][k % 4];
        let points: [Vec3; 5] = std::array::from_fn(|_| {
            let [i, j] = [0, 1].map(|_| random.integer(-2, 2) as f64);
            Vec3::new(1.0, 2.0, 3.0)
                + match dimension {
                    2 => u * i + v * j,
                    1 => u * i,
                    _ => u * f64::from(i > 1.0),
                }
        });
        check(&points, "degenerate");
    }
}

/// Contacts planted by rounding: a point on the triangle, moved by a few units in the last place or not at all.
#[test]
fn near_touching_points_agree_with_rational_arithmetic_at_every_scale() {
    let mut random = Random(11);
    for scale in [1e-8, 1.0, 1e8] {
        let mut met = 0;
        for _ in 0..200 {
            let mut points: [Vec3; 5] =
                std::array::from_fn(|_| random.point() * scale + Vec3::new(1.0, 1.0, 1.0) * scale);
            let [a, b, c] = [points[2], points[3], points[4]];
            let weights = [random.unit(), random.unit() * f64::from(random.integer(0, 1) as i32)];
            // On the triangle or on one of its edges, as well as rounding can.
            points[1] = a + ((b - a) * (1.0 - weights[1]) + (c - a) * weights[1]) * weights[0];
            let ulps = random.integer(-2, 2);
            let moved = points[1].x.to_bits() as i64 + ulps;
            points[1].x = f64::from_bits(moved as u64);
            met += i32::from(check(&points, "near").0);
        }
        assert!((20..180).contains(&met), "{met} of 200 at scale {scale}");
    }
}

/// Sizes at which expansions overflow or underflow, and mixtures of them.
#[test]
fn extreme_sizes_agree_with_rational_arithmetic() {
    let mut random = Random(13);
    let exponents = [-1074, -1060, -700, -330, -292, 0, 325, 340, 700, 1020];
    for k in 0..80 {
        let uniform = exponents[k % exponents.len()];
        let mut size = || {
            let any = exponents[random.integer(0, 9) as usize];
            let integer = random.integer(-3, 3) as f64;
            // 2^-1074 only comes out of two factors.
            let exponent = if k % 3 == 0 { any } else { uniform };
            integer * f64::from(exponent / 2).exp2() * f64::from(exponent - exponent / 2).exp2()
        };
        let points: [Vec3; 5] = std::array::from_fn(|_| Vec3::from_fn(|_, _| size()));
        check(&points, "extreme");
    }
}

/// Grids of integers scaled by a power of two keep their answer, through every stage of the predicates.
#[test]
fn answers_do_not_depend_on_the_unit_of_length() {
    let mut random = Random(17);
    for _ in 0..2000 {
        let points: [Vec3; 5] = std::array::from_fn(|_| random.grid_point(-3, 3));
        let answer = |factor: f64| {
            let [p, q, a, b, c] = points.map(|p| p * factor);
            (segment_meets_triangle([&p, &q], [&a, &b, &c]), segments_meet([&p, &q], [&a, &b]))
        };
        for exponent in [-1073, -1000, -400, -27, 27, 400, 1000, 1022] {
            let factor = f64::from(exponent / 2).exp2() * f64::from(exponent - exponent / 2).exp2();
            assert_eq!(answer(factor), answer(1.0), "2^{exponent} {points:?}");
        }
    }
}
