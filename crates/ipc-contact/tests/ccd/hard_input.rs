//! Input at the edges: touching, NaN, no motion, no extent, every scale; and the queries other than the two big ones.

use crate::planted::{self, FAMILIES, Pair, Query};
use crate::random::Random;
use crate::{BOTH, ask, settings};
use ipc_contact::ccd::{self, Impact};
use ipc_contact::collision_mesh::HalfSpace;
use mechanics_core::tensor::Vec3;

/// A pair at an exactly known distance: a whole-numbered contact, one feature lifted along the whole-numbered normal.
fn lifted(seed: u64) -> (Pair, [Vec3; 4], f64) {
    let mut random = Random(seed);
    let r = &mut random;
    let size = 1 << r.integer(1, 7);
    let mut vector = |size: i64| Vec3::from_fn(|_, _| r.integer(-size, size) as f64);
    // Slivers: the second direction differs from the first by a step or two.
    let e = vector(size);
    let f = if seed.is_multiple_of(2) { vector(size) } else { e + vector(2) };
    let origin = vector(1 << 8);
    let normal = e.cross(&f);
    let height = 0.5_f64.powi(random.integer(0, 40) as i32);
    let lift = height * normal;
    if seed % 4 < 2 {
        let corner = origin - 0.25 * (e + f);
        (Pair::PointTriangle, [origin + lift, corner, corner + e, corner + f], lift.norm())
    } else {
        (
            Pair::EdgeEdge,
            [origin - 0.25 * e + lift, origin + e + lift, origin - f, origin + 0.5 * f],
            lift.norm(),
        )
    }
}

/// The bound that [`ccd::Settings`] states, over slivers and distances down to the bound.
#[test]
fn no_pair_beyond_the_bound_is_refused() {
    let (mut refused, mut near) = (0, 0);
    for seed in 0..100_000 {
        let (pair, start, distance) = lifted(seed);
        let apart = |i: usize, j: usize| (start[i] - start[j]).norm();
        let split = if pair == Pair::PointTriangle { 1 } else { 2 };
        let across = (0..split).flat_map(|i| (split..4).map(move |j| apart(i, j))).fold(0.0, f64::max);
        let bound = 256.0 * f64::EPSILON * across;
        let query = Query { pair, start, end: start, contact: f64::NAN, separation: 0.0, family: "lifted" };
        let (impact, _) = ask(&query, &settings(BOTH[0], 0.1));
        if distance > bound {
            assert_eq!(impact, Impact::Free, "{seed}: {distance:e} against {bound:e}, {query:?}");
            near += u32::from(distance < 1e3 * bound);
        } else {
            refused += u32::from(impact != Impact::Free);
        }
    }
    println!("of pairs within 1000 times the bound {near} were not refused; {refused} below it were");
}

/// Lifted pairs that start almost touching and move together, or slide, or part: nothing happens to them.
#[test]
fn motion_without_approach_is_free() {
    for seed in 0..20_000 {
        let (pair, start, distance) = lifted(seed);
        if distance == 0.0 {
            continue;
        }
        let mut random = Random(!seed);
        let common = Vec3::from_fn(|_, _| random.signed()) * 100.0;
        let moving = if pair == Pair::PointTriangle { 0..1 } else { 0..2 };
        let normal = match pair {
            Pair::EdgeEdge => (start[1] - start[0]).cross(&(start[3] - start[2])),
            _ => (start[2] - start[1]).cross(&(start[3] - start[1])),
        };
        for apart in [0.0, 1.0, 1e6] {
            let end = std::array::from_fn(|k| {
                let lift = if moving.contains(&k) { apart } else { 0.0 };
                start[k] + common + lift * normal
            });
            let query = Query { pair, start, end, contact: f64::NAN, separation: 0.0, family: "parting" };
            for detection in BOTH {
                let (impact, _) = ask(&query, &settings(detection, 0.1));
                // Positions are rounded when the common motion is added: by less than 1e-9 of 2^20.
                assert!(impact == Impact::Free || distance < 1e-8, "{seed} {impact:?} {distance:e}");
            }
        }
    }
}

#[test]
fn touching_pairs_start_too_close() {
    let corner = [Vec3::zeros(), Vec3::zeros(), Vec3::x(), Vec3::y()];
    let crossing = [-Vec3::x(), Vec3::x(), -Vec3::y(), Vec3::y()];
    for detection in BOTH {
        let settings = settings(detection, 0.1);
        let away = |x: &[Vec3; 4]| [x[0] + Vec3::z(), x[1], x[2], x[3]];
        let impact = ccd::point_triangle(&corner, &away(&corner), 0.0, &settings);
        assert_eq!(impact, Impact::StartsTooClose { distance: 0.0 });
        assert_eq!(
            ccd::edge_edge(&crossing, &crossing, 0.0, &settings),
            Impact::StartsTooClose { distance: 0.0 }
        );
        // A distance of one, and a minimum separation above it.
        let lifted = away(&corner);
        assert_eq!(
            ccd::point_triangle(&lifted, &lifted, 1.5, &settings),
            Impact::StartsTooClose { distance: 1.0 }
        );
        assert_eq!(ccd::point_triangle(&lifted, &lifted, 0.999, &settings), Impact::Free);
    }
}

#[test]
fn every_coordinate_that_is_not_finite_is_found() {
    for family in FAMILIES {
        let query = planted::query(family, 5).of_four_points();
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for place in 0..24 {
                let mut query = query.clone();
                let points = if place < 12 { &mut query.start } else { &mut query.end };
                points[place % 12 / 3][place % 3] = bad;
                for detection in BOTH {
                    let (impact, _) = ask(&query, &settings(detection, 0.1));
                    assert_eq!(impact, Impact::NonFinite, "{family} {place} {bad}");
                }
            }
        }
    }
}

/// Two moving points meet at a root of a quadratic.
#[test]
fn points_meet_when_the_quadratic_says() {
    let mut random = Random(1);
    let mut vector = || Vec3::from_fn(|_, _| random.signed());
    let mut hits = 0;
    for _ in 0..20_000 {
        let (start, end) = ([vector(), vector()], [vector(), vector()]);
        let d_min = 0.2;
        let (r, u) = (start[1] - start[0], end[1] - end[0] - start[1] + start[0]);
        if r.norm() < d_min {
            continue;
        }
        let (a, b, c) = (u.dot(&u), r.dot(&u), r.dot(&r) - d_min * d_min);
        let discriminant = b * b - a * c;
        let root = if discriminant > 0.0 { (-b - discriminant.sqrt()) / a } else { f64::NAN };
        let contact = (0.0..=1.0).contains(&root).then_some(root);
        for detection in BOTH {
            let impact = ccd::point_point(&start, &end, d_min, &settings(detection, 1e-6));
            match contact {
                Some(time) => {
                    assert!(impact.fraction() <= time, "{impact:?} after {time}");
                    hits += u32::from(time - impact.fraction() < 1e-4);
                }
                None => assert!(
                    impact == Impact::Free || discriminant.abs() < 1e-4,
                    "{impact:?}, {discriminant:e}"
                ),
            }
        }
    }
    assert!(hits > 1000, "{hits}");
}

#[test]
fn a_point_falls_onto_a_half_space_as_far_as_it_is() {
    let floor = HalfSpace { normal: Vec3::z(), offset: 1.0 };
    let fall = |from: f64, to: f64, d_min: f64| {
        ccd::half_space(
            &Vec3::new(3.0, 4.0, from),
            &Vec3::new(-3.0, 5.0, to),
            &floor,
            d_min,
            &settings(BOTH[0], 1e-3),
        )
    };
    // From 2 to 0 it is at 1.25 after 3/8, and there the gap has gone; 0.75e-3 of the gap is kept.
    let impact = fall(2.0, 0.0, 0.25);
    assert!(matches!(impact, Impact::At(t) if t < 0.375 && t > 0.375 - 0.375e-3), "{impact:?}");
    assert_eq!(fall(2.0, 1.3, 0.25), Impact::Free);
    assert_eq!(fall(1.25, 3.0, 0.25), Impact::StartsTooClose { distance: 0.25 });
    assert_eq!(fall(0.5, 3.0, 0.0), Impact::StartsTooClose { distance: -0.5 });
    assert_eq!(fall(2.0, f64::NAN, 0.0), Impact::NonFinite);
}
