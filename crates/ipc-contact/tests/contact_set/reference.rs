//! The figures of the reference library (ipctk 1.6.1) on the scenes of the peers' scripts, as their README lists them.

use crate::energy;
use crate::peers::{self, PeerScene};
use ipc_contact::broad_phase::{BroadPhase, Candidates};
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact_set::{ContactSet, Weighting};

pub(crate) fn mesh_of(scene: &PeerScene) -> CollisionMesh {
    let mut builder = CollisionMeshBuilder::new(&scene.start);
    builder.add_object(CollisionObject::new(scene.triangles.clone()));
    builder.build().unwrap()
}

pub(crate) fn candidates_of(scene: &PeerScene, mesh: &CollisionMesh) -> Candidates {
    let mut candidates = Candidates::default();
    let inflation = 0.5 * scene.activation_distance;
    BroadPhase::new(mesh).candidates(mesh, &scene.start, &scene.start, inflation, &mut candidates).unwrap();
    candidates
}

struct Expected {
    /// Point–point, point–edge, edge–edge, point–triangle.
    counts: [usize; 4],
    distance: f64,
    value: f64,
    gradient: f64,
    hessian: f64,
}

fn compare(scene: &PeerScene, expected: &Expected) {
    let mesh = mesh_of(scene);
    let candidates = candidates_of(scene, &mesh);
    let activation = scene.activation_distance.powi(2);
    let set = ContactSet::new(&mesh, &candidates, &scene.start, activation, Weighting::Unit);
    let counts =
        [set.point_points.len(), set.point_edges.len(), set.edge_edges.len(), set.point_triangles.len()];
    let sums = energy::sums(&set, &scene.start, activation);
    let distance = set.smallest_squared_distance().unwrap().sqrt();
    let figures = [distance, sums.value, sums.gradient_norm(), sums.hessian_norm()];
    println!("{counts:?} {figures:?}");
    assert_eq!(counts, expected.counts);
    let expected = [expected.distance, expected.value, expected.gradient, expected.hessian];
    for (figure, expected) in figures.iter().zip(expected) {
        assert!((figure / expected - 1.0).abs() < 1e-9, "{figure} instead of {expected}");
    }
}

#[test]
fn two_sheets_have_the_contacts_and_energy_of_the_reference_library() {
    let expected = Expected {
        counts: [0, 0, 58_608, 19_602],
        distance: 1.025_720_658_795_239_3e-4,
        value: 1.597_924_847_632_603_2e-7,
        gradient: 9.546_252_496_770_616e-6,
        hessian: 0.033_068_296_823_882_67,
    };
    compare(&peers::cloth(100), &expected);
}

#[test]
fn packed_spheres_have_the_contacts_and_energy_of_the_reference_library() {
    let expected = Expected {
        counts: [30, 972, 3_707, 1_154],
        distance: 0.006,
        value: 0.001_459_080_832_187_395,
        gradient: 0.021_112_762_277_302_282,
        hessian: 4.055_968_071_127_367,
    };
    compare(&peers::spheres(3), &expected);
}
