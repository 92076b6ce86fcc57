//! What a contact set must not depend on, and hard input.

use crate::peers;
use crate::reference::{candidates_of, mesh_of};
use ipc_contact::broad_phase::{BroadPhase, Candidates};
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject, HalfSpace};
use ipc_contact::contact_set::{ContactSet, Weighting};
use mechanics_core::parallel::with_threads;
use mechanics_core::tensor::Vec3;

const WEIGHTINGS: [Weighting; 2] = [Weighting::Unit, Weighting::Area];

#[test]
fn sets_have_the_same_bits_for_any_number_of_threads() {
    for scene in [peers::cloth(100), peers::spheres(3)] {
        let mesh = mesh_of(&scene);
        let candidates = candidates_of(&scene, &mesh);
        let activation = scene.activation_distance.powi(2);
        for weighting in WEIGHTINGS {
            let with = |threads| {
                with_threads(threads, || {
                    ContactSet::new(&mesh, &candidates, &scene.start, activation, weighting)
                })
            };
            let one = with(1);
            assert!(one.len() > 5_000);
            for threads in [2, 3, 8] {
                assert!(with(threads) == one, "{threads} threads, {weighting:?}");
            }
        }
    }
}

#[test]
fn a_set_in_old_memory_is_a_new_set() {
    let scene = peers::spheres(2);
    let mesh = mesh_of(&scene);
    let candidates = candidates_of(&scene, &mesh);
    let activation = scene.activation_distance.powi(2);
    let mut set = ContactSet::new(&mesh, &candidates, &scene.start, activation, Weighting::Area);
    set.rebuild(&mesh, &candidates, &scene.start, 0.5 * activation, Weighting::Unit);
    assert_eq!(set, ContactSet::new(&mesh, &candidates, &scene.start, 0.5 * activation, Weighting::Unit));
    set.rebuild(&mesh, &Candidates::default(), &scene.start, activation, Weighting::Unit);
    assert!(set.is_empty() && set.smallest_squared_distance().is_none());
}

/// Two loose points, a chain of two loose edges, a triangle, and a floor.
fn loose_features() -> (CollisionMesh, Vec<Vec3>) {
    let x = vec![
        Vec3::new(0.0, 0.0, 1.05),
        Vec3::new(0.0, 0.05, 1.05),
        // The chain bends at the point under the first loose point.
        Vec3::new(-1.0, 0.0, 1.0),
        Vec3::new(0.0, 0.0, 1.0),
        Vec3::new(1.0, 0.0, 0.9),
        Vec3::new(-2.0, -1.0, 0.95),
        Vec3::new(0.3, -1.0, 0.95),
        Vec3::new(-1.0, 2.0, 0.95),
        Vec3::new(5.0, 5.0, 0.01),
        Vec3::new(6.0, 5.0, -0.02),
    ];
    let mut builder = CollisionMeshBuilder::new(&x);
    let object = |o: CollisionObject| o.with_thickness(0.1);
    builder.add_object(object(CollisionObject { points: vec![0, 1, 8, 9], ..Default::default() }));
    builder.add_object(object(CollisionObject { segments: vec![[2, 3], [3, 4]], ..Default::default() }));
    builder.add_object(CollisionObject::new(vec![[5, 6, 7]]));
    builder.add_half_space(HalfSpace::through(&Vec3::zeros(), &Vec3::z()));
    (builder.build().unwrap(), x)
}

fn near(mesh: &CollisionMesh, x: &[Vec3], activation: f64, weighting: Weighting) -> ContactSet {
    let mut candidates = Candidates::default();
    BroadPhase::new(mesh).candidates(mesh, x, x, 0.5 * activation, &mut candidates).unwrap();
    ContactSet::new(mesh, &candidates, x, activation * activation, weighting)
}

#[test]
fn loose_points_and_edges_and_half_spaces_are_found() {
    let (mesh, x) = loose_features();
    let set = near(&mesh, &x, 0.08, Weighting::Unit);
    // Both loose points with each other, and each with the chain's corner from both of its edges.
    assert_eq!(set.point_points.points, [[0, 1], [0, 3], [1, 3]]);
    assert_eq!(set.point_points.weights, [1.0, 2.0, 2.0]);
    assert!(set.point_edges.is_empty());
    // The chain's end over the triangle, and its first edge over the triangle's edge.
    assert_eq!(set.point_triangles.points, [[2, 5, 6, 7]]);
    assert_eq!(set.edge_edges.points, [[2, 3, 6, 7]]);
    assert_eq!(set.half_spaces.points, [[8], [9]]);
    assert_eq!(set.half_space_numbers, [0, 0]);
    assert_eq!(set.smallest_squared_distance(), Some(0.0), "a point is behind the plane");

    let set = near(&mesh, &x, 0.08, Weighting::Area);
    assert_eq!(set.point_points.points, [[0, 1], [0, 3], [1, 3]]);
    // Half of both areas (0.01 m² each), and the corner once: twice half the area, less once.
    for (weight, expected) in set.point_points.weights.iter().zip([0.01, 0.005, 0.005]) {
        assert!((weight - expected).abs() < 1e-17);
    }
    assert!(set.half_spaces.weights.iter().all(|w| (w - 0.01).abs() < 1e-17));
}

#[test]
fn a_position_that_is_not_a_number_shows_and_does_not_panic() {
    let scene = peers::spheres(2);
    let mesh = mesh_of(&scene);
    let candidates = candidates_of(&scene, &mesh);
    let point = candidates.point_triangles[candidates.point_triangles.len() / 2][0];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for weighting in WEIGHTINGS {
            let mut x = scene.start.clone();
            x[point as usize][1] = bad;
            let set = ContactSet::new(&mesh, &candidates, &x, 4e-4, weighting);
            assert!(bad.is_infinite() || set.smallest_squared_distance().unwrap().is_nan());
        }
    }
}

#[test]
#[should_panic(expected = "different numbers of points")]
fn positions_of_another_mesh_are_refused() {
    let (mesh, x) = loose_features();
    ContactSet::new(&mesh, &Candidates::default(), &x[1..], 1.0, Weighting::Unit);
}
