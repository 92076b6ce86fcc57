//! Whole meshes: every pair looked at, no other; and what must be refused.

use super::peers;
use super::random::Random;
use ipc_contact::ContactError;
use ipc_contact::collision_mesh::{
    CollisionMesh, CollisionMeshBuilder, CollisionObject, Feature, HalfSpace, SelfContact,
};
use ipc_contact::intersection::{self, Intersection, segment_meets_triangle, segments_meet};
use mechanics_core::parallel::with_threads;
use mechanics_core::tensor::Vec3;

/// Every pair of features by brute force, each as (points, feature).
fn brute_force(mesh: &CollisionMesh, x: &[Vec3]) -> Vec<(Feature, Feature)> {
    let at = |p: u32| &x[p as usize];
    let mut found = Vec::new();
    let edges = (0..mesh.edges().len() as u32).map(|e| (Feature::Edge(e), mesh.edges()[e as usize]));
    let points: Vec<_> = mesh.loose_points().iter().map(|&p| (Feature::Point(p), [p, p])).collect();
    for (feature, ends) in edges.chain(points.clone()) {
        for (t, corners) in mesh.triangles().iter().enumerate() {
            if mesh.features_may_touch(&ends, corners)
                && segment_meets_triangle(ends.map(at), corners.map(at))
            {
                found.push((feature, Feature::Triangle(t as u32)));
            }
        }
    }
    let loose = mesh.loose_edges().iter().map(|&e| (Feature::Edge(e), mesh.edges()[e as usize]));
    let loose: Vec<_> = points.into_iter().chain(loose).collect();
    for (i, (first, a)) in loose.iter().enumerate() {
        for (second, b) in &loose[i + 1..] {
            if mesh.features_may_touch(a, b) && segments_meet(a.map(at), b.map(at)) {
                found.push((*first.min(second), *first.max(second)));
            }
        }
    }
    for (h, half_space) in mesh.half_spaces().iter().enumerate() {
        let below = |&&p: &&u32| half_space.normal.z * at(p).z <= half_space.offset;
        let points =
            mesh.vertices().iter().filter(|&&p| mesh.may_touch_half_space(h as u32, p)).filter(below);
        found.extend(points.map(|&p| (Feature::Point(p), Feature::HalfSpace(h as u32))));
    }
    found.sort_unstable();
    found
}

/// A soup of two objects of triangles, one of segments and one of points, at rest somewhere else.
fn soup(random: &mut Random) -> CollisionMesh {
    let rest: Vec<Vec3> = (0..90).map(|_| random.point()).collect();
    let mut builder = CollisionMeshBuilder::new(&rest);
    let strip = |first: u32| (first..first + 23).map(|p| [p, p + 1, p + 2]).collect();
    let first = builder.add_object(CollisionObject { triangles: strip(0), ..Default::default() });
    builder.add_object(CollisionObject { triangles: strip(25), ..Default::default() }.with_self_contact(
        if random.integer(0, 1) == 0 { SelfContact::Allowed } else { SelfContact::Excluded },
    ));
    let segments = (50..69).map(|p| [p, p + 1]).collect();
    builder.add_object(CollisionObject { segments, ..Default::default() }.with_thickness(0.01));
    let points = (70..90).collect();
    let last = builder.add_object(CollisionObject { points, ..Default::default() }.with_thickness(0.01));
    if random.integer(0, 1) == 0 {
        builder.exclude_objects(first, last);
    }
    builder.script_points((20..30).chain(60..75));
    builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: -2.0 });
    builder.build().unwrap()
}

fn features(found: &[Intersection]) -> Vec<(Feature, Feature)> {
    found.iter().map(|pair| (pair.first.feature, pair.second.feature)).collect()
}

#[test]
fn every_allowed_pair_is_found_and_no_other() {
    let mut random = Random(3);
    let (mut least, mut most) = (usize::MAX, 0);
    for k in 0..120 {
        let mesh = soup(&mut random);
        let range = [2, 6, 20, 60][k % 4];
        let x: Vec<Vec3> =
            (0..90).map(|_| Vec3::from_fn(|_, _| random.integer(-range, range) as f64 * 0.25)).collect();
        let found = intersection::check(&mesh, &x).unwrap();
        assert_eq!(features(&found), brute_force(&mesh, &x));
        assert_eq!(intersection::intersects(&mesh, &x).unwrap(), !found.is_empty());
        (least, most) = (least.min(found.len()), most.max(found.len()));
    }
    assert!(least < 400 && most > 1000, "{least} to {most} intersections");
}

fn object(scene: &peers::PeerScene) -> CollisionMesh {
    let mut builder = CollisionMeshBuilder::new(&scene.start);
    builder.add_object(CollisionObject { triangles: scene.triangles.clone(), ..Default::default() });
    builder.build().unwrap()
}

/// The peers' scenes start free, and one point pushed through the other sheet is found with its neighbours, by any number of
/// threads alike.
#[test]
fn one_point_pushed_through_a_sheet_is_found() {
    let scene = peers::cloth(40);
    let mesh = object(&scene);
    assert_eq!(intersection::check(&mesh, &scene.start).unwrap(), []);
    for point in [1600 + 5 * 40 + 7, 1600 + 20 * 40 + 20, 33 * 40 + 11] {
        let mut x = scene.start.clone();
        x[point].z += if point < 1600 { 6e-4 } else { -6e-4 };
        let found = with_threads(1, || intersection::check(&mesh, &x)).unwrap();
        assert!(!found.is_empty());
        for pair in &found {
            let named = pair.first.points.iter().chain(&pair.second.points).any(|&p| p as usize == point);
            assert!(named, "{pair} does not name point {point}");
        }
        for threads in [2, 3, 8] {
            assert_eq!(with_threads(threads, || intersection::check(&mesh, &x)).unwrap(), found);
            assert!(with_threads(threads, || intersection::intersects(&mesh, &x)).unwrap());
        }
    }
}

/// A sheet that has passed right through the other is free of intersections again: stated, and looked for elsewhere.
#[test]
fn sheet_that_has_passed_right_through_is_not_seen() {
    let scene = peers::cloth(40);
    assert!(!intersection::intersects(&object(&scene), &scene.end).unwrap());
}

/// On the plane is touching, one unit in the last place above it is not, for normals that do not multiply exactly.
#[test]
fn half_spaces_are_exact_to_the_last_bit() {
    let normal = Vec3::new(1.0, 2.0, -2.0) / 3.0;
    let mut builder = CollisionMeshBuilder::new(&[Vec3::zeros()]);
    builder.add_object(CollisionObject { points: vec![0], ..Default::default() }.with_thickness(1.0));
    builder.add_half_space(HalfSpace { normal, offset: 0.0 });
    let mesh = builder.build().unwrap();
    let meets = |p: Vec3| intersection::intersects(&mesh, &[p]).unwrap();
    // 2/3 rounded is twice 1/3 rounded, so these two are on the plane exactly.
    for size in [f64::MIN_POSITIVE, 1e-200, 1.0, 1e300] {
        let p = Vec3::new(2.0, 1.0, 2.0) * size;
        assert!(meets(p) && meets(Vec3::new(2.0, -1.0, 0.0) * size));
        assert!(!meets(Vec3::new(p.x.next_up(), p.y, p.z)) && meets(Vec3::new(p.x.next_down(), p.y, p.z)));
        assert!(!meets(Vec3::new(p.x, p.y, p.z.next_down())) && meets(Vec3::new(p.x, p.y, p.z.next_up())));
    }
}

#[test]
fn culprits_are_named_and_other_points_do_not_matter() {
    let rest = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vec3::from);
    let mut builder = CollisionMeshBuilder::new(&rest);
    builder.add_object(CollisionObject { triangles: vec![[0, 1, 2]], ..Default::default() });
    let mesh = builder.build().unwrap();
    let mut x = rest;
    x[3].x = f64::NAN;
    assert_eq!(intersection::check(&mesh, &x).unwrap(), []);
    x[2].y = f64::INFINITY;
    let error = intersection::check(&mesh, &x).unwrap_err();
    assert_eq!(error, ContactError::NonFinite { point: 2, position: [0.0, f64::INFINITY, 0.0] });
    assert_eq!(intersection::intersects(&mesh, &x).unwrap_err(), error);
}

#[test]
fn empty_mesh_meets_nothing() {
    let mesh = CollisionMeshBuilder::new(&[]).build().unwrap();
    assert_eq!(intersection::check(&mesh, &[]).unwrap(), []);
    assert!(!intersection::intersects(&mesh, &[]).unwrap());
}

/// All points in one place: every pair that may touch does, and boxes of no extent are sorted without trouble.
#[test]
fn all_points_in_one_place_meet() {
    let mesh = soup(&mut Random(8));
    for size in [0.0, 1.0, 1e300, f64::MAX, 5e-324] {
        let x = vec![Vec3::new(size, -size, size); 90];
        let found = intersection::check(&mesh, &x).unwrap();
        assert_eq!(features(&found), brute_force(&mesh, &x));
        assert!(found.len() > 1000);
    }
}
