//! Candidates against brute force, on random and adversarial meshes, and against the counts of another system.
#![allow(clippy::unwrap_used)]

#[path = "scenes/peers.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with other tests")]
mod peers;

use ipc_contact::broad_phase::{BroadPhase, Candidates};
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject};
use mechanics_core::tensor::Vec3;
use peers::{PeerScene, cloth};

/// Entry `i` of splitmix64 with this seed, in [0, 1).
fn noise(i: usize, seed: u64) -> f64 {
    let mut z = seed.wrapping_add((i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 * 2.0_f64.powi(-53)
}

fn one_object(scene: &PeerScene) -> CollisionMesh {
    let mut builder = CollisionMeshBuilder::new(&scene.start);
    builder.add_object(CollisionObject::new(scene.triangles.clone()));
    builder.build().unwrap()
}

fn static_and_swept(scene: &PeerScene) -> [Candidates; 2] {
    let mesh = one_object(scene);
    let mut broad = BroadPhase::new(&mesh);
    let inflation = 0.5 * scene.activation_distance;
    let mut found = [Candidates::default(), Candidates::default()];
    broad.candidates(&mesh, &scene.start, &scene.start, inflation, &mut found[0]).unwrap();
    broad.candidates(&mesh, &scene.start, &scene.end, 0.0, &mut found[1]).unwrap();
    found
}

/// The counts are those of ipctk 1.6.1 (LBVH), see the README of the peers' scripts.
#[test]
fn two_sheets_have_as_many_candidates_as_in_the_reference_library() {
    let [at_rest, swept] = static_and_swept(&cloth(100));
    assert_eq!((at_rest.point_triangles.len(), at_rest.edge_edges.len()), (78_408, 272_055));
    assert_eq!((swept.point_triangles.len(), swept.edge_edges.len()), (68_178, 241_160));
}

/// The smallest box of a feature by the definition, without rounding outwards.
fn bounds(points: &[u32], x0: &[Vec3], x1: &[Vec3], inflation: f64) -> (Vec3, Vec3) {
    let places = || points.iter().flat_map(|&p| [x0[p as usize], x1[p as usize]]);
    let low = places().reduce(|a, b| a.inf(&b)).unwrap().add_scalar(-inflation);
    (low, places().reduce(|a, b| a.sup(&b)).unwrap().add_scalar(inflation))
}

/// All pairs of boxes that overlap by a quadratic search; `margin` makes the boxes larger still.
fn brute_force(mesh: &CollisionMesh, x0: &[Vec3], x1: &[Vec3], inflation: f64) -> Candidates {
    let overlap = |a: &[u32], b: &[u32]| {
        let ((al, ah), (bl, bh)) = (bounds(a, x0, x1, inflation), bounds(b, x0, x1, inflation));
        (0..3).all(|k| al[k] <= bh[k] && bl[k] <= ah[k])
    };
    let apart = |a: &[u32], b: &[u32]| {
        a.iter().all(|p| !b.contains(p)) && a.iter().any(|&p| b.iter().any(|&q| mesh.may_touch(p, q)))
    };
    let pair = |a: &[u32], b: &[u32]| apart(a, b) && overlap(a, b);
    let edge = |e: u32| mesh.edges()[e as usize];
    let mut found = Candidates::default();
    for &p in mesh.vertices() {
        let with = (0..).zip(mesh.triangles()).filter(|(_, t)| pair(&[p], &t[..]));
        found.point_triangles.extend(with.map(|(t, _)| [p, t]));
    }
    let edges = mesh.edges().len() as u32;
    for e in 0..edges {
        found.edge_edges.extend((e + 1..edges).filter(|&f| pair(&edge(e), &edge(f))).map(|f| [e, f]));
    }
    for (k, &p) in mesh.loose_points().iter().enumerate() {
        let with = mesh.loose_edges().iter().filter(|&&e| pair(&[p], &edge(e)));
        found.point_edges.extend(with.map(|&e| [p, e]));
        let with = mesh.loose_points()[k + 1..].iter().filter(|&&q| pair(&[p], &[q]));
        found.point_points.extend(with.map(|&q| [p, q]));
    }
    found
}

/// Triangles, loose segments and loose points over random positions of this size.
fn random_mesh(seed: u64, scale: f64, size: f64) -> (CollisionMesh, Vec<Vec3>, Vec<Vec3>) {
    let (triangles, segments, points) = (60_u32, 40_u32, 50_u32);
    let count = 3 * triangles + 2 * segments + points;
    let random =
        |i: usize, s: u64| Vec3::from(std::array::from_fn::<f64, 3, _>(|k| noise(3 * i + k, s) - 0.5));
    let feature_of = |p: u32| match p {
        p if p < 3 * triangles => p / 3,
        p if p < 3 * triangles + 2 * segments => 1000 + p / 2,
        p => 2000 + p,
    };
    let place = |p: u32| random(feature_of(p) as usize, seed) + random(p as usize, seed + 1) * size;
    let rest: Vec<Vec3> = (0..count).map(place).collect();
    let start = rest.iter().map(|x| x * scale).collect();
    let moved = |p: u32| (rest[p as usize] + random(p as usize, seed + 2) * (0.5 * size)) * scale;
    let end = (0..count).map(moved).collect();
    let mut builder = CollisionMeshBuilder::new(&rest);
    builder.add_object(CollisionObject::new((0..triangles).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect()));
    let first = 3 * triangles;
    let segments: Vec<_> = (0..segments).map(|s| [first + 2 * s, first + 2 * s + 1]).collect();
    let loose = CollisionObject { segments, points: (count - points..count).collect(), ..Default::default() };
    builder.add_object(loose.with_thickness(1.0));
    (builder.build().unwrap(), start, end)
}

#[test]
fn random_features_match_brute_force_at_every_scale() {
    for (k, scale) in [1.0, 1e-8, 1e8, 1e-150, 1e100].into_iter().enumerate() {
        for (j, size) in [0.05, 0.5, 2.0].into_iter().enumerate() {
            let (mesh, x0, x1) = random_mesh(17 * k as u64 + 5 * j as u64, scale, size);
            let mut broad = BroadPhase::new(&mesh);
            let mut found = Candidates::default();
            for (a, b) in [(&x0, &x0), (&x0, &x1), (&x1, &x1)] {
                for inflation in [0.0, 0.02 * scale, 0.3 * scale] {
                    broad.candidates(&mesh, a, b, inflation, &mut found).unwrap();
                    let expected = brute_force(&mesh, a, b, inflation);
                    assert_eq!(found, expected, "scale {scale:e}, size {size}, inflation {inflation:e}");
                }
            }
        }
    }
}
