//! What a collision mesh answers and refuses.
#![allow(clippy::unwrap_used)]

use ipc_contact::ContactError;
use ipc_contact::collision_mesh::{
    CollisionMesh, CollisionMeshBuilder, CollisionObject, Feature, Groups, HalfSpace, SelfContact,
};
use mechanics_core::mesh::{BoxSplit, Surface, TriMesh, block, sphere};
use mechanics_core::tensor::Vec3;

/// Two squares of two triangles (points 0 to 3, 4 to 7), a segment (8, 9), two loose points (10, 11), a spare
/// point (12).
fn rest() -> Vec<Vec3> {
    let corner = |k: usize| Vec3::new((k % 2) as f64, (k / 2) as f64, 0.0);
    let mut rest: Vec<Vec3> = (0..4).map(corner).collect();
    rest.extend((0..4).map(|k| corner(k) * 2.0 + Vec3::z()));
    rest.extend((0..5).map(|k| Vec3::new(5.0, 3.0 * k as f64, 0.0)));
    rest
}

fn square(first: u32) -> CollisionObject {
    CollisionObject::new(vec![[first, first + 1, first + 2], [first + 2, first + 1, first + 3]])
}

fn loose() -> CollisionObject {
    CollisionObject { segments: vec![[9, 8]], points: vec![11, 10], ..Default::default() }.with_thickness(0.1)
}

fn build(
    objects: &[CollisionObject],
    change: impl Fn(&mut CollisionMeshBuilder),
) -> Result<CollisionMesh, ContactError> {
    let mut builder = CollisionMeshBuilder::new(&rest());
    objects.iter().for_each(|o| {
        builder.add_object(o.clone());
    });
    change(&mut builder);
    builder.build()
}

#[test]
fn features_are_numbered_and_measured() {
    let mesh = build(&[square(0), square(4), loose()], |_| ()).unwrap();
    assert_eq!((mesh.point_count(), mesh.vertices().len(), mesh.object_count()), (13, 12, 3));
    assert_eq!(mesh.triangles()[2], [4, 5, 6]);
    assert_eq!(mesh.edges().len(), 11);
    assert!(mesh.edges().is_sorted() && mesh.edges().iter().all(|e| e[0] < e[1]));
    for (t, edges) in mesh.triangles().iter().zip(mesh.triangle_edges()) {
        for k in 0..3 {
            let mut ends = [t[k], t[(k + 1) % 3]];
            ends.sort_unstable();
            assert_eq!(mesh.edges()[edges[k] as usize], ends);
        }
    }
    assert_eq!((mesh.loose_edges(), mesh.loose_points()), (&[10][..], &[10, 11][..]));
    assert_eq!(mesh.edges()[10], [8, 9]);
    // Squares of area 1 and 4: a corner of two triangles has two thirds of half of it, a diagonal too.
    let areas: Vec<f64> = (0..13).map(|p| mesh.point_area(p)).collect();
    let third = 1.0 / 6.0;
    let thirds = [1.0, 2.0, 2.0, 1.0, 4.0, 8.0, 8.0, 4.0].map(|a| a * third);
    let expected: Vec<f64> = thirds.into_iter().chain([0.15, 0.15, 0.01, 0.01, 0.0]).collect();
    areas.iter().zip(&expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-15, "{a} instead of {b}"));
    let edges: f64 = (0..11).map(|e| mesh.edge_area(e)).sum();
    assert!((edges - (1.0 + 4.0 + 0.3)).abs() < 1e-14);
    assert!((mesh.rest_length(10) - 3.0).abs() < 1e-15);
}

/// The sums of the areas of points and of edges are both the surface's; the points of a tetrahedral mesh keep
/// their numbers.
#[test]
fn surfaces_of_meshes_become_objects() {
    let ball = sphere(1.0, 3).unwrap();
    let cube = block(&Vec3::zeros(), &Vec3::repeat(1.0), [3, 3, 3], BoxSplit::Six).unwrap();
    let mut rest = ball.points().to_vec();
    let first = rest.len() as u32;
    rest.extend(cube.points().iter().map(|p| p + Vec3::x() * 3.0));
    let mut builder = CollisionMeshBuilder::new(&rest);
    builder.add_object(CollisionObject::of_mesh(&ball, 0));
    builder.add_object(CollisionObject::of_tets(&cube, first).unwrap());
    let mesh = builder.build().unwrap();
    let points: f64 = (0..mesh.point_count() as u32).map(|p| mesh.point_area(p)).sum();
    let edges: f64 = (0..mesh.edges().len() as u32).map(|e| mesh.edge_area(e)).sum();
    let area = ball.area() + 6.0;
    assert!((points - area).abs() < 1e-12 && (edges - area).abs() < 1e-12, "{points}, {edges}, {area}");
    // 4³ points, of which 2³ are inside.
    assert_eq!(mesh.vertices().len(), ball.points().len() + 64 - 8);
    assert_eq!((mesh.object_of(0), mesh.object_of(first)), (0, 1));
    let surface = Surface::of_tets(&cube).unwrap();
    assert_eq!(mesh.triangles().len(), ball.triangles().len() + surface.triangles().len());
}

#[test]
fn free_parts_of_a_mesh_that_belong_to_triangles_add_nothing() {
    let free_edges = vec![[1, 0], [3, 4], [4, 3], [4, 5]];
    let points = rest();
    let mesh = TriMesh::with_codimensional(points, vec![[0, 1, 2]], free_edges, vec![2, 5, 7]).unwrap();
    let object = CollisionObject::of_mesh(&mesh, 0);
    assert_eq!((object.segments, object.points), (vec![[3, 4], [4, 5]], vec![7]));
}

#[test]
fn filters_keep_features_apart() {
    let objects = [square(0), square(4), loose()];
    let open = build(&objects, |_| ()).unwrap();
    assert!(open.may_touch(0, 1) && open.may_touch(0, 4) && open.may_touch(8, 11));
    assert!(!open.may_touch(3, 3) && !open.may_touch(0, 12), "itself, and a point that takes no part");
    assert!(open.features_may_touch(&[0], &[4, 5, 6]) && !open.features_may_touch(&[5], &[4, 5, 6]));

    let apart = build(&objects, |b| {
        b.exclude_objects(1, 0);
    });
    let apart = apart.unwrap();
    assert!(
        !apart.may_touch(0, 4) && !apart.may_touch(7, 3) && apart.may_touch(0, 1) && apart.may_touch(4, 8)
    );

    for stiff in [
        build(&[square(0).with_self_contact(SelfContact::Excluded), square(4)], |_| ()),
        build(&objects, |b| {
            b.exclude_objects(0, 0);
        }),
    ] {
        let stiff = stiff.unwrap();
        assert!(!stiff.may_touch(0, 3) && stiff.may_touch(4, 7) && stiff.may_touch(0, 4));
    }

    // The first is in group 0 and touches group 1; the second is in group 1 and touches group 0 or not.
    for (touches, expected) in [(1, true), (2, false)] {
        let of_first = square(0).with_groups(Groups { member_of: 1, touches: 2 });
        let of_second = square(4).with_groups(Groups { member_of: 2, touches });
        let mesh = build(&[of_first, of_second], |_| ()).unwrap();
        assert_eq!(mesh.may_touch(0, 4), expected);
        assert_eq!(mesh.may_touch(4, 0), expected);
        assert!(mesh.may_touch(0, 3), "self-contact is no matter of groups");
    }
}

#[test]
fn scripted_and_joined_points() {
    let objects = [square(0), square(4)];
    let mesh = build(&objects, |b| {
        b.script_points([0, 1, 2, 4]).join_points(3, 7);
    });
    let mesh = mesh.unwrap();
    assert!(!mesh.may_touch(0, 4) && mesh.may_touch(0, 5) && mesh.may_touch(3, 4));
    assert!(mesh.is_scripted(4) && !mesh.is_scripted(5));
    // A pair is left out only if nothing in it has unknowns.
    assert!(!mesh.features_may_touch(&[4], &[0, 1, 2]) && mesh.features_may_touch(&[4], &[2, 1, 3]));
    assert!(!mesh.may_touch(3, 7) && !mesh.may_touch(7, 3));
    assert!(!mesh.features_may_touch(&[2, 3], &[6, 7]) && mesh.features_may_touch(&[2, 3], &[5, 6]));
}

#[test]
fn half_spaces_keep_out_points_with_unknowns() {
    let mesh = build(&[square(0), square(4)], |b| {
        b.add_half_space(HalfSpace::through(&Vec3::new(1.0, 2.0, 3.0), &Vec3::new(0.0, 0.0, -2e200)));
        b.add_half_space(HalfSpace { normal: Vec3::x(), offset: -1.0 });
        b.script_points([1]).exclude_half_space(1, 1);
    });
    let mesh = mesh.unwrap();
    let [ceiling, wall] = mesh.half_spaces() else { panic!("two half-spaces") };
    assert!((ceiling.distance(&Vec3::new(7.0, 7.0, 1.0)) - 2.0).abs() < 1e-15);
    assert!((wall.distance(&Vec3::new(1.0, 7.0, 1.0)) - 2.0).abs() < 1e-15);
    let touching = |h| (0..13).filter(|&p| mesh.may_touch_half_space(h, p)).collect::<Vec<u32>>();
    assert_eq!((touching(0), touching(1)), (vec![0, 2, 3, 4, 5, 6, 7], vec![0, 2, 3]));
}

/// Every refusal names its culprit.
#[test]
fn bad_input_is_refused_by_name() {
    use ContactError as E;
    let refused = |objects: &[CollisionObject]| build(objects, |_| ()).unwrap_err();
    let triangles = |t: &[[u32; 3]]| CollisionObject::new(t.to_vec());
    let triangle = Feature::Triangle;
    assert_eq!(
        refused(&[square(0), triangles(&[[4, 5, 13]])]),
        E::PointOutOfRange { feature: triangle(2), point: 13, points: 13 }
    );
    assert_eq!(refused(&[triangles(&[[4, 5, 4]])]), E::RepeatedPoint { feature: triangle(0), point: 4 });
    let twice = triangles(&[[0, 1, 2], [3, 2, 1], [2, 0, 1]]);
    assert_eq!(refused(&[twice]), E::RepeatedFeature { feature: triangle(2), earlier: triangle(0) });
    assert_eq!(refused(&[square(0), square(2)]), E::PointOfTwoObjects { point: 2, objects: [0, 1] });
    let with_segments = |segments: &[[u32; 2]]| CollisionObject { segments: segments.to_vec(), ..square(0) };
    for segments in [&[[2, 1]][..], &[[8, 9], [9, 8]]] {
        let mut points = segments[0];
        points.sort_unstable();
        assert_eq!(refused(&[with_segments(segments).with_thickness(1.0)]), E::RepeatedSegment { points });
    }
    assert_eq!(refused(&[with_segments(&[[8, 9]])]), E::BadThickness { object: 0, thickness: None });
    for thickness in [0.0, -1.0, f64::INFINITY] {
        let object = loose().with_thickness(thickness);
        assert_eq!(refused(&[object]), E::BadThickness { object: 0, thickness: Some(thickness) });
    }
    let with_points =
        |points: &[u32]| CollisionObject { points: points.to_vec(), ..square(0) }.with_thickness(1.0);
    assert_eq!(refused(&[with_points(&[1])]), E::LoosePointInUse { point: 1, feature: triangle(0) });
    let point = Feature::Point(9);
    assert_eq!(refused(&[with_points(&[9, 9])]), E::RepeatedFeature { feature: point, earlier: point });
    // Points 8 to 12 lie on a line.
    assert_eq!(refused(&[triangles(&[[8, 9, 10]])]), E::ZeroSize { feature: triangle(0), size: 0.0 });
}

#[test]
fn bad_positions_filters_and_half_spaces_are_refused_by_name() {
    use ContactError as E;
    let mut positions = rest();
    positions[12].y = f64::NEG_INFINITY;
    let error = CollisionMeshBuilder::new(&positions).build().unwrap_err();
    assert_eq!(error, E::NonFinite { point: 12, position: [5.0, f64::NEG_INFINITY, 0.0] });
    let mut positions = rest();
    positions[9] = positions[8];
    let mut builder = CollisionMeshBuilder::new(&positions);
    builder.add_object(loose());
    assert_eq!(builder.build().unwrap_err(), E::ZeroSize { feature: Feature::Edge(0), size: 0.0 });

    let refused = |change: &dyn Fn(&mut CollisionMeshBuilder)| build(&[square(0)], change).unwrap_err();
    let missing = |point| E::PointOutOfRange { feature: Feature::Point(point), point, points: 13 };
    assert_eq!(
        refused(&|b| {
            b.script_points([3, 99]);
        }),
        missing(99)
    );
    assert_eq!(
        refused(&|b| {
            b.join_points(3, 13);
        }),
        missing(13)
    );
    assert_eq!(
        refused(&|b| {
            b.exclude_objects(0, 1);
        }),
        E::ObjectOutOfRange { object: 1, objects: 1 }
    );
    let floor = HalfSpace::through(&Vec3::zeros(), &Vec3::z());
    let excluded = |half_space, object| {
        move |b: &mut CollisionMeshBuilder| {
            b.add_half_space(floor);
            b.exclude_half_space(half_space, object);
        }
    };
    assert_eq!(refused(&excluded(1, 0)), E::HalfSpaceOutOfRange { half_space: 1, half_spaces: 1 });
    assert_eq!(refused(&excluded(0, 4)), E::ObjectOutOfRange { object: 4, objects: 1 });
    for normal in [Vec3::zeros(), Vec3::new(0.0, f64::NAN, 1.0), Vec3::repeat(f64::INFINITY)] {
        let error = refused(&|b| {
            b.add_half_space(HalfSpace::through(&Vec3::zeros(), &normal));
        });
        assert!(matches!(error, E::BadHalfSpace { half_space: 0, .. }), "{error}");
    }
    let error = refused(&|b| {
        b.add_half_space(HalfSpace { normal: Vec3::repeat(1.0), offset: 0.0 });
    });
    assert!(matches!(error, E::BadHalfSpace { half_space: 0, .. }), "{error}");
}
