//! Candidates against brute force, on random and adversarial meshes, and against the counts of another system.
#![allow(clippy::unwrap_used)]

#[path = "scenes/peers.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with other tests")]
mod peers;

use ipc_contact::ContactError;
use ipc_contact::broad_phase::{BroadPhase, Candidates};
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject};
use mechanics_core::parallel::with_threads;
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

fn lists(c: &Candidates) -> [&Vec<[u32; 2]>; 4] {
    [&c.point_triangles, &c.edge_edges, &c.point_edges, &c.point_points]
}

fn assert_same(found: &Candidates, expected: &Candidates, case: &str) {
    for (found, expected) in lists(found).into_iter().zip(lists(expected)) {
        assert_eq!(found, expected, "{case}");
    }
}

/// Every expected pair is found, each list ascends strictly.
fn assert_holds(found: &Candidates, expected: &Candidates, case: &str) {
    for (found, expected) in lists(found).into_iter().zip(lists(expected)) {
        assert!(found.is_sorted_by(|a, b| a < b), "{case}: not ascending");
        let missed = expected.iter().find(|pair| found.binary_search(pair).is_err());
        assert_eq!(missed, None, "{case}: a pair is missed");
    }
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

/// All pairs of boxes that overlap by a quadratic search.
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
                    let case = format!("scale {scale:e}, size {size}, inflation {inflation:e}");
                    assert_same(&found, &brute_force(&mesh, a, b, inflation), &case);
                }
            }
        }
    }
}

/// A name, positions, triangles.
type Soup = (&'static str, Vec<Vec3>, Vec<[u32; 3]>);

/// Meshes on which trees do badly, or round badly: every box the same, a plane, long thin triangles, a grid, and a
/// grid far away.
fn adversarial() -> Vec<Soup> {
    let soup = |n: u32| (0..n).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect::<Vec<_>>();
    let corner = [Vec3::zeros(), Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 1.0, 1.0)];
    let coincident = (0..150).map(|p| corner[p % 3]).collect();
    let flat = (0..240).map(|p| Vec3::new(noise(2 * p, 3), noise(2 * p + 1, 3), 0.25)).collect();
    let thin = (0..240).map(|p| {
        let (line, end) = ((p / 3) as f64 * 0.01, (p % 3) as f64);
        Vec3::new(line + 1e-9 * end * end, end * 50.0, noise(p / 3, 4))
    });
    let grid = |offset: f64| {
        (0..400)
            .map(|p| Vec3::new((p / 20) as f64, (p % 20) as f64, 0.0).add_scalar(offset))
            .collect::<Vec<_>>()
    };
    vec![
        ("coincident", coincident, soup(50)),
        ("flat", flat, soup(80)),
        ("thin", thin.collect(), soup(80)),
        ("grid", grid(0.0), peers::sheet(20, 0)),
        ("far grid", grid(1e8), peers::sheet(20, 0)),
        ("very far grid", grid(1e15), peers::sheet(20, 0)),
    ]
}

#[test]
fn no_pair_is_missed_on_adversarial_meshes() {
    for (name, rest, triangles) in adversarial() {
        let mut builder = CollisionMeshBuilder::new(&rest);
        builder.add_object(CollisionObject::new(triangles));
        let mesh = builder.build().unwrap();
        let mut broad = BroadPhase::new(&mesh);
        let mut found = Candidates::default();
        // On grids, boxes inflated by a half touch exactly: rounding outwards must keep them.
        for inflation in [0.0, 1e-9, 0.5, 0.75] {
            broad.candidates(&mesh, &rest, &rest, inflation, &mut found).unwrap();
            assert_holds(
                &found,
                &brute_force(&mesh, &rest, &rest, inflation),
                &format!("{name}, {inflation:e}"),
            );
        }
    }
}

/// Distance 2 r in exact arithmetic, at coordinates where x + r rounds: the pair must be found.
#[test]
fn pairs_at_exactly_twice_the_inflation_are_found_whatever_the_rounding() {
    let rest = [Vec3::zeros(), Vec3::new(1.0, 0.0, 0.0)];
    let mut builder = CollisionMeshBuilder::new(&rest);
    let points = CollisionObject { points: vec![0, 1], ..Default::default() };
    builder.add_object(points.with_thickness(1.0));
    let mesh = builder.build().unwrap();
    let mut broad = BroadPhase::new(&mesh);
    let mut found = Candidates::default();
    for k in 0..4000 {
        // A distance whose sum with the place is exact, so that the true distance is known.
        let place = (noise(2 * k, 9) - 0.5) * 2.0_f64.powi((k % 80) as i32 - 40);
        let other = place + noise(2 * k + 1, 9) * 2.0_f64.powi((k % 37) as i32 - 30);
        let gap = other - place;
        if place + gap != other || other - gap != place {
            continue;
        }
        let x = [Vec3::repeat(place), Vec3::repeat(other)];
        broad.candidates(&mesh, &x, &x, 0.5 * gap, &mut found).unwrap();
        assert_eq!(found.point_points, [[0, 1]], "{place:e} and {other:e}");
    }
}

#[test]
fn a_tree_that_was_refitted_or_built_anew_answers_the_same() {
    let scene = cloth(20);
    let mesh = one_object(&scene);
    let mut broad = BroadPhase::new(&mesh);
    let (mut found, mut anew) = (Candidates::default(), Candidates::default());
    for k in 0..12 {
        // From a small stir to a heap without any order.
        let stir = 1e-4 * 3.0_f64.powi(k);
        let at = |(p, x): (usize, &Vec3)| {
            x + Vec3::from(std::array::from_fn::<f64, 3, _>(|c| noise(3 * p + c, k as u64) - 0.5)) * stir
        };
        let x: Vec<Vec3> = scene.start.iter().enumerate().map(at).collect();
        broad.candidates(&mesh, &x, &x, 1e-3, &mut found).unwrap();
        BroadPhase::new(&mesh).candidates(&mesh, &x, &x, 1e-3, &mut anew).unwrap();
        assert_same(&found, &anew, &format!("stirred by {stir:e}"));
        if k % 4 == 0 {
            assert_same(&found, &brute_force(&mesh, &x, &x, 1e-3), &format!("stirred by {stir:e}"));
        }
    }
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let scene = cloth(60);
    let mesh = one_object(&scene);
    let find = |threads| {
        with_threads(threads, || {
            let mut found = Candidates::default();
            BroadPhase::new(&mesh).candidates(&mesh, &scene.start, &scene.end, 1e-3, &mut found).unwrap();
            found
        })
    };
    let one = find(1);
    assert!(one.edge_edges.len() > 10_000);
    for threads in [2, 3, 8] {
        assert_same(&find(threads), &one, &format!("{threads} threads"));
    }
}

#[test]
fn candidates_cover_every_way_within_their_margin() {
    let (mesh, x0, x1) = random_mesh(91, 1.0, 0.4);
    let mut broad = BroadPhase::new(&mesh);
    let (radius, margin) = (0.02, 0.03);
    let mut found = Candidates::default();
    assert!(!found.covers(&mesh, &x0, &x0, 0.0), "nothing was searched for");
    broad.candidates(&mesh, &x0, &x1, radius + margin, &mut found).unwrap();
    let (mut covered, mut other) = (0, Candidates::default());
    for k in 0..60 {
        // Somewhere on the way, and up to 1.2 margins beside it.
        let beside = 0.02 * f64::from(k) * margin;
        let at = |(p, (a, b)): (usize, (&Vec3, &Vec3))| {
            let shift =
                Vec3::from(std::array::from_fn::<f64, 3, _>(|c| 2.0 * noise(3 * p + c, k as u64) - 1.0));
            a + (b - a) * noise(p, 77 + k as u64) + shift * beside
        };
        let y: Vec<Vec3> = x0.iter().zip(&x1).enumerate().map(at).collect();
        assert!(
            beside > 0.999 * margin || found.covers(&mesh, &y, &x1, radius),
            "moved {beside} of {margin}"
        );
        if found.covers(&mesh, &y, &x1, radius) {
            covered += 1;
            broad.candidates(&mesh, &y, &x1, radius, &mut other).unwrap();
            assert_holds(&found, &other, "covered");
        }
    }
    assert!((49..60).contains(&covered), "{covered} of 60 are covered");
    let mut broken = x0.clone();
    broken[3].y = f64::NAN;
    assert!(!found.covers(&mesh, &broken, &x1, radius) && !found.covers(&mesh, &x0, &x1, f64::NAN));
}

#[test]
fn edges_and_triangles_are_those_of_brute_force() {
    let (mesh, x, _) = random_mesh(5, 1.0, 0.5);
    let found = BroadPhase::new(&mesh).edge_triangles(&mesh, &x).unwrap();
    let mut expected = Vec::new();
    for (e, edge) in (0..).zip(mesh.edges()) {
        for (t, triangle) in (0..).zip(mesh.triangles()) {
            let ((al, ah), (bl, bh)) = (bounds(edge, &x, &x, 0.0), bounds(triangle, &x, &x, 0.0));
            let overlap = (0..3).all(|k| al[k] <= bh[k] && bl[k] <= ah[k]);
            if overlap && !edge.iter().any(|p| triangle.contains(p)) {
                expected.push([e, t]);
            }
        }
    }
    assert!(expected.len() > 100);
    assert_eq!(found, expected);
}

#[test]
fn positions_and_inflations_that_are_none_are_refused_and_candidates_stay() {
    let (mesh, x, _) = random_mesh(6, 1.0, 0.5);
    let mut broad = BroadPhase::new(&mesh);
    let mut found = Candidates::default();
    broad.candidates(&mesh, &x, &x, 0.1, &mut found).unwrap();
    let before = found.clone();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for point in [0, 77] {
            let mut broken = x.clone();
            broken[point].z = bad;
            for (a, b) in [(&broken, &x), (&x, &broken)] {
                let error = broad.candidates(&mesh, a, b, 0.1, &mut found).unwrap_err();
                assert!(matches!(error, ContactError::NonFinite { point: p, .. } if p == point), "{error}");
            }
            assert!(broad.edge_triangles(&mesh, &broken).is_err());
        }
        assert!(matches!(
            broad.candidates(&mesh, &x, &x, bad, &mut found),
            Err(ContactError::BadInflation { .. })
        ));
    }
    assert!(matches!(
        broad.candidates(&mesh, &x, &x, -1e-9, &mut found),
        Err(ContactError::BadInflation { .. })
    ));
    assert_same(&found, &before, "after refusals");
    assert!(found.covers(&mesh, &x, &x, 0.1), "the boxes stay, too");
}

#[test]
fn a_mesh_without_features_has_no_candidates() {
    for count in [0, 3] {
        let mesh = CollisionMeshBuilder::new(&vec![Vec3::zeros(); count]).build().unwrap();
        let x = vec![Vec3::zeros(); count];
        let mut found = Candidates::default();
        let mut broad = BroadPhase::new(&mesh);
        broad.candidates(&mesh, &x, &x, 1.0, &mut found).unwrap();
        assert!(found.is_empty() && broad.edge_triangles(&mesh, &x).unwrap().is_empty());
    }
}

/// Every point of a cloth of this many points at nearly the same place: all boxes overlap.
#[test]
fn a_collapsed_scene_is_refused_with_the_count_whatever_the_number_of_threads() {
    let scene = cloth(30);
    let mesh = one_object(&scene);
    let collapsed: Vec<Vec3> = scene.start.iter().map(|x| x * 1e-9).collect();
    let features = scene.start.len() + mesh.edges().len() + scene.triangles.len();
    for threads in [1, 2, 3, 8] {
        with_threads(threads, || {
            let mut broad = BroadPhase::new(&mesh).with_largest_count(200_000);
            let mut found = Candidates::default();
            broad.candidates(&mesh, &scene.start, &scene.start, 5e-4, &mut found).unwrap();
            let error = broad.candidates(&mesh, &collapsed, &collapsed, 1e-3, &mut found).unwrap_err();
            assert_eq!(error, ContactError::TooManyCandidates { limit: 200_000, features });
            assert!(found.is_empty() && !found.covers(&mesh, &scene.start, &scene.start, 0.0));
            // It is as good as new.
            broad.candidates(&mesh, &scene.start, &scene.start, 5e-4, &mut found).unwrap();
            let mut anew = Candidates::default();
            BroadPhase::new(&mesh).candidates(&mesh, &scene.start, &scene.start, 5e-4, &mut anew).unwrap();
            assert_same(&found, &anew, "after a refusal");
        });
    }
}

#[test]
fn a_limit_that_is_just_reached_refuses_nothing() {
    let scene = cloth(10);
    let mesh = one_object(&scene);
    let mut all = Candidates::default();
    BroadPhase::new(&mesh).candidates(&mesh, &scene.start, &scene.start, 5e-4, &mut all).unwrap();
    let most = all.edge_edges.len().max(all.point_triangles.len());
    let mut found = Candidates::default();
    let search = |limit: usize, found: &mut Candidates| {
        let mut broad = BroadPhase::new(&mesh).with_largest_count(limit);
        broad.candidates(&mesh, &scene.start, &scene.start, 5e-4, found)
    };
    search(most, &mut found).unwrap();
    assert_same(&found, &all, "at the limit");
    assert!(search(most - 1, &mut found).is_err());
}
