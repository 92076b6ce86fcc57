//! Points inside of closed surfaces, and sides of sheets.

use super::peers;
use super::random::Random;
use ipc_contact::ContactError;
use ipc_contact::collision_mesh::Feature;
use ipc_contact::topology::{Location, Side, Surface};
use mechanics_core::tensor::Vec3;
use std::f64::consts::PI;

/// The eight corners of a box and its twelve triangles, outward, numbered from `first` on.
fn cuboid(low: &Vec3, high: &Vec3, first: u32) -> ([Vec3; 8], Vec<[u32; 3]>) {
    let corner = |k: usize| Vec3::from_fn(|axis, _| if k >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let split = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    let triangles = faces.into_iter().flat_map(split).map(|t| t.map(|p| p + first)).collect();
    (std::array::from_fn(corner), triangles)
}

/// Overlapping boxes with integer corners, asked about at integer and half-integer points: rays run along faces, edges and
/// corners. The winding number is the number of boxes around the point.
#[test]
fn winding_number_counts_the_boxes_around_a_point() {
    let mut random = Random(1);
    let (mut on, mut deepest) = (0, 0);
    for _ in 0..150 {
        let (mut x, mut triangles, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..4 {
            let low = random.grid_point(-3, 1);
            let high = low + random.grid_point(1, 4);
            let (corners, faces) = cuboid(&low, &high, x.len() as u32);
            x.extend(corners);
            triangles.extend(faces);
            boxes.push((low, high));
        }
        let surface = Surface::new(triangles, x.len()).unwrap().closed().unwrap();
        for _ in 0..60 {
            let p = random.grid_point(-8, 12) / 2.0;
            let inside = |(low, high): &&(Vec3, Vec3)| (0..3).all(|k| low[k] < p[k] && p[k] < high[k]);
            let within = |(low, high): &&(Vec3, Vec3)| (0..3).all(|k| low[k] <= p[k] && p[k] <= high[k]);
            let [inside, within] = [boxes.iter().filter(inside).count(), boxes.iter().filter(within).count()];
            match surface.locate(&x, &p).unwrap() {
                Location::On { triangle } => {
                    on += 1;
                    assert!(within > inside, "{p:?} is on no box, but on triangle {triangle}?");
                }
                Location::Off { winding } => {
                    assert_eq!(winding, inside as i32, "{p:?}");
                    assert_eq!(within, inside, "{p:?} is on a box");
                    deepest = deepest.max(winding);
                    let angle = surface.surface().solid_angle(&x, &p);
                    assert!((angle - 4.0 * PI * f64::from(winding)).abs() < 1e-12, "{angle} at {p:?}");
                }
            }
        }
    }
    assert!(on > 500 && deepest >= 3, "{on} on the surface, {deepest} deep");
}

/// A turned sphere at three scales, and points within rounding of its facets: the exact side of the facet's plane decides,
/// because the surface is convex.
#[test]
fn points_next_to_a_facet_are_on_its_side() {
    let mut random = Random(2);
    let (sphere, triangles) = peers::icosphere(2);
    for scale in [1e-8, 1.0, 1e8] {
        let shift = random.point() * 3.0;
        let x: Vec<Vec3> = sphere.iter().map(|p| (p + shift) * scale).collect();
        let surface = Surface::new(triangles.clone(), x.len()).unwrap().closed().unwrap();
        let mut counts = [0; 3];
        for _ in 0..300 {
            let [a, b, c] =
                triangles[random.integer(0, triangles.len() as i64 - 1) as usize].map(|p| x[p as usize]);
            let (u, v) = (0.1 + 0.4 * random.unit(), 0.1 + 0.4 * random.unit());
            let p = a * (1.0 - u - v) + b * u + c * v;
            // The bare determinant, sign reversed: positive below, which is inside.
            let [ra, rb, rc, rp] = [a, b, c, p].map(|p| robust::Coord3D { x: p.x, y: p.y, z: p.z });
            let side = robust::orient3d(ra, rb, rc, rp);
            let expected = if side > 0.0 {
                0
            } else if side < 0.0 {
                1
            } else {
                2
            };
            let found = match surface.locate(&x, &p).unwrap() {
                Location::Off { winding: 1 } => 0,
                Location::Off { winding: 0 } => 1,
                Location::On { .. } => 2,
                other => panic!("{other:?}"),
            };
            assert_eq!(found, expected, "{p:?}");
            counts[found] += 1;
        }
        assert!(counts[0] > 50 && counts[1] > 50, "{counts:?}");
    }
}

/// A cavity, and a surface turned inside out.
#[test]
fn orientation_counts() {
    let (outer, triangles) = cuboid(&Vec3::repeat(-2.0), &Vec3::repeat(2.0), 0);
    let (inner, hollow) = cuboid(&Vec3::repeat(-1.0), &Vec3::repeat(1.0), 8);
    let reversed: Vec<[u32; 3]> = hollow.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let x: Vec<Vec3> = outer.into_iter().chain(inner).collect();
    let all = [triangles, reversed.clone()].concat();
    let shell = Surface::new(all, 16).unwrap().closed().unwrap();
    for (p, winding) in [(0.0, 0), (1.5, 1), (2.5, 0)] {
        assert_eq!(shell.locate(&x, &Vec3::new(p, 0.0, 0.0)).unwrap(), Location::Off { winding });
    }
    let inside_out = Surface::new(reversed, 16).unwrap().closed().unwrap();
    assert_eq!(inside_out.locate(&x, &Vec3::zeros()).unwrap(), Location::Off { winding: -1 });
}

/// A flat sheet of integer points, segments between integer points through its inside: through corners, through edges,
/// along edges' planes. The heights of the ends decide.
#[test]
fn sides_of_a_flat_sheet_are_those_of_heights() {
    let n = 7;
    let x: Vec<Vec3> = (0..n * n).map(|k| Vec3::new((k / n) as f64, (k % n) as f64, 0.0)).collect();
    let sheet = Surface::new(peers::sheet(n, 0), n * n).unwrap();
    let mut random = Random(4);
    let (mut past, mut through) = (0, 0);
    for _ in 0..4000 {
        let [from, to] = [0, 1].map(|_| random.grid_point(-3, 9));
        if from.z == 0.0 || to.z == 0.0 {
            continue;
        }
        // Where the segment has the height 0, multiplied by the difference of heights.
        let height = from.z - to.z;
        let at = |k: usize| (from.z * to[k] - to.z * from[k]) * height.signum();
        let within = |k: usize| 0.0 < at(k) && at(k) < (n - 1) as f64 * height.abs();
        let outside = |k: usize| at(k) < 0.0 || at(k) > (n - 1) as f64 * height.abs();
        let crossings = sheet.crossings(&x, &from, &to).unwrap();
        let side = sheet.side_of_sheet(&x, &to, &from).unwrap();
        if from.z * to.z < 0.0 && within(0) && within(1) {
            assert_eq!(crossings.net(), if to.z > 0.0 { 1 } else { -1 }, "{from:?} {to:?}");
            assert_eq!(crossings.along + crossings.against, 1, "{from:?} {to:?}");
            assert_eq!(side, Side::Opposite);
            through += 1;
        } else if from.z * to.z > 0.0 || outside(0) || outside(1) {
            assert_eq!((crossings.along, crossings.against, side), (0, 0, Side::Same), "{from:?} {to:?}");
            past += 1;
        }
    }
    assert!(through > 400 && past > 400, "{through} through, {past} past");
}

/// What [`ipc_contact::intersection`] does not see: the upper of two sheets has passed right through the lower one.
#[test]
fn sheet_that_has_passed_right_through_is_on_the_other_side() {
    let scene = peers::cloth(30);
    let lower = Surface::new(peers::sheet(30, 0), 1800).unwrap();
    let inner = (900..1800).filter(|k| (1..28).contains(&(k % 900 / 30)) && (1..28).contains(&(k % 30)));
    for point in inner {
        // Up from each point, over the part of the lower sheet that lies under the upper one.
        let above = |x: &[Vec3]| Vec3::new(x[point].x, x[point].y, 1.0);
        let side = |x: &[Vec3]| lower.side_of_sheet(x, &above(x), &x[point]).unwrap();
        assert_eq!((side(&scene.start), side(&scene.end)), (Side::Same, Side::Opposite));
        let jump = lower.solid_angle(&scene.start, &scene.start[point])
            - lower.solid_angle(&scene.end, &scene.end[point]);
        assert!(jump.abs() > 1.9 * PI, "{jump}");
    }
}

#[test]
fn what_cannot_be_answered_is_refused_by_name() {
    let (x, triangles) = cuboid(&Vec3::zeros(), &Vec3::repeat(1.0), 0);
    let open = Surface::new(triangles[1..].to_vec(), 8).unwrap();
    assert_eq!(open.clone().closed().unwrap_err(), ContactError::OpenSurface { edge: [0, 2] });
    let error = Surface::new(vec![[0, 1, 2], [0, 1, 8]], 8).unwrap_err();
    assert_eq!(error, ContactError::PointOutOfRange { feature: Feature::Triangle(1), point: 8, points: 8 });
    let touching = Vec3::new(0.5, 0.25, 1.0);
    let error = open.crossings(&x, &Vec3::repeat(9.0), &touching).unwrap_err();
    assert_eq!(error, ContactError::OnSurface { triangle: 1, position: touching.into() });
    let nowhere = Vec3::new(0.0, f64::NAN, 0.0);
    assert!(matches!(open.crossings(&x, &nowhere, &touching), Err(ContactError::NonFiniteQuery { .. })));
    let mut broken = x;
    broken[3].x = f64::INFINITY;
    let closed = Surface::new(triangles, 8).unwrap().closed().unwrap();
    assert!(matches!(closed.locate(&broken, &touching), Err(ContactError::NonFinite { point: 3, .. })));
}

/// A surface of the largest and of the smallest numbers there are.
#[test]
fn sizes_at_the_end_of_the_range_are_no_exception() {
    for size in [f64::MAX, 5e-324 * 4.0] {
        let (x, triangles) = cuboid(&Vec3::repeat(-size), &Vec3::repeat(size), 0);
        let surface = Surface::new(triangles, 8).unwrap().closed().unwrap();
        let at = |a: f64, b: f64, c: f64| surface.locate(&x, &(Vec3::new(a, b, c) * size)).unwrap();
        assert_eq!(at(0.5, 0.0, 0.25), Location::Off { winding: 1 });
        assert!(matches!(at(1.0, 0.0, 0.25), Location::On { .. }));
        assert!(matches!(at(0.0, 0.0, 1.0), Location::On { .. }));
    }
    let (x, triangles) = cuboid(&Vec3::zeros(), &Vec3::repeat(5e-324), 0);
    let surface = Surface::new(triangles, 8).unwrap().closed().unwrap();
    assert_eq!(surface.locate(&x, &Vec3::new(0.0, 0.0, 1e-323)).unwrap(), Location::Off { winding: 0 });
}
