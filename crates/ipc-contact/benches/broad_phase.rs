//! Time to find candidates, against other ways to find them: parry's trees, sort and sweep, a hash grid. All answer the same
//! sorted pairs, which is checked.
//!
//! `cargo bench -p ipc-contact --bench broad_phase [-- REPEATS]`

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

#[path = "broad_phase/alternatives.rs"]
#[allow(unreachable_pub, reason = "a part of this bench")]
mod alternatives;
#[path = "../tests/scenes/peers.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with tests")]
mod peers;

use alternatives::{Boxes, Parry};
use ipc_contact::broad_phase::{BroadPhase, Candidates};
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject};
use mechanics_core::parallel::with_threads;
use peers::PeerScene;
use std::hint::black_box;
use std::time::Instant;

fn milliseconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
}

/// The same sum every time: tells how fast the machine is at the moment.
fn calibration() {
    let mut sum = 0.0_f64;
    for k in 0..2_000_000 {
        sum += 1.0 / (f64::from(k) + black_box(0.5));
    }
    black_box(sum);
}

fn one_object(scene: &PeerScene) -> CollisionMesh {
    let mut builder = CollisionMeshBuilder::new(&scene.start);
    builder.add_object(CollisionObject::new(scene.triangles.clone()));
    builder.build().expect("the scenes are valid")
}

/// Runs all cases in turn, many times, so that a slow moment of the machine falls on all of them; prints medians.
fn measure(cases: &mut [(&str, Box<dyn FnMut() -> f64 + Send + '_>)], repeats: usize) {
    let mut times = vec![Vec::new(); cases.len()];
    for _ in 0..repeats {
        for (case, times) in cases.iter_mut().zip(&mut times) {
            times.push(case.1());
        }
    }
    for (case, times) in cases.iter().zip(&mut times) {
        times.sort_by(f64::total_cmp);
        println!("  {:44} {:8.2} ms", case.0, times[times.len() / 2]);
    }
}

fn compare(name: &str, scene: &PeerScene, repeats: usize, only_ours: bool) {
    let mesh = one_object(scene);
    let (x0, x1, radius) = (&scene.start, &scene.end, 0.5 * scene.activation_distance);
    let boxes = || Boxes::new(&mesh, x0, x0, radius);
    let (mut refitted, mut swept, mut two) =
        (BroadPhase::new(&mesh), BroadPhase::new(&mesh), BroadPhase::new(&mesh));
    let mut found = Candidates::default();
    refitted.candidates(&mesh, x0, x0, radius, &mut found).expect("finite");
    let count = found.clone();
    println!(
        "\n{name}: {} point-triangle and {} edge-edge pairs",
        count.point_triangles.len(),
        count.edge_edges.len()
    );
    for other in [
        Parry::build(&boxes()).query(&mesh, &boxes()),
        alternatives::sweep(&mesh, &boxes()),
        alternatives::grid(&mesh, &boxes()),
    ] {
        assert!(other[0] == count.point_triangles && other[1] == count.edge_edges, "all find the same");
    }
    let (mut parry, mut parry_pairs) = (Parry::build(&boxes()), Parry::build(&boxes()));
    let mut cases: Vec<(&str, Box<dyn FnMut() -> f64 + Send>)> = vec![
        ("calibration", Box::new(|| milliseconds(calibration))),
        (
            "built anew, static",
            Box::new(|| {
                milliseconds(|| {
                    let mut found = Candidates::default();
                    BroadPhase::new(&mesh).candidates(&mesh, x0, x0, radius, &mut found).expect("finite");
                    black_box(&found);
                })
            }),
        ),
        (
            "refitted, static",
            Box::new(|| {
                let mut found = Candidates::default();
                milliseconds(|| refitted.candidates(&mesh, x0, x0, radius, &mut found).expect("finite"))
            }),
        ),
        (
            "refitted, swept",
            Box::new(|| {
                let mut found = Candidates::default();
                milliseconds(|| swept.candidates(&mesh, x0, x1, 0.0, &mut found).expect("finite"))
            }),
        ),
        (
            "refitted, static, two threads",
            Box::new(|| {
                let mut found = Candidates::default();
                with_threads(2, || {
                    milliseconds(|| two.candidates(&mesh, x0, x0, radius, &mut found).expect("finite"))
                })
            }),
        ),
        (
            "built anew, static, two threads",
            Box::new(|| {
                with_threads(2, || {
                    milliseconds(|| {
                        let mut found = Candidates::default();
                        BroadPhase::new(&mesh).candidates(&mesh, x0, x0, radius, &mut found).expect("finite");
                        black_box(&found);
                    })
                })
            }),
        ),
        (
            "parry, built anew, box by box",
            Box::new(|| {
                milliseconds(|| {
                    let boxes = boxes();
                    black_box(Parry::build(&boxes).query(&mesh, &boxes));
                })
            }),
        ),
        (
            "parry, refitted, box by box",
            Box::new(|| {
                milliseconds(|| {
                    let boxes = boxes();
                    parry.refit(&boxes);
                    black_box(parry.query(&mesh, &boxes));
                })
            }),
        ),
        (
            "parry, refitted, tree by tree",
            Box::new(|| {
                milliseconds(|| {
                    let boxes = boxes();
                    parry_pairs.refit(&boxes);
                    black_box(parry_pairs.query_pairs(&mesh, &boxes));
                })
            }),
        ),
        (
            "sort and sweep",
            Box::new(|| {
                milliseconds(|| {
                    black_box(alternatives::sweep(&mesh, &boxes()));
                })
            }),
        ),
        (
            "hash grid",
            Box::new(|| {
                milliseconds(|| {
                    black_box(alternatives::grid(&mesh, &boxes()));
                })
            }),
        ),
    ];
    cases.truncate(if only_ours { 4 } else { cases.len() });
    measure(&mut cases, repeats);
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let repeats = words.iter().find_map(|a| a.parse().ok()).unwrap_or(5);
    let scenes: [(&str, fn() -> PeerScene); 3] = [
        ("cloth100", || peers::cloth(100)),
        ("cloth200", || peers::cloth(200)),
        ("spheres3", || peers::spheres(3)),
    ];
    let named = |name: &str| words.iter().any(|w| w == name);
    let all = !scenes.iter().any(|(name, _)| named(name));
    for (name, scene) in scenes.iter().filter(|(name, _)| all || named(name)) {
        // Without the pool of one thread, the pool of the machine would be used.
        with_threads(1, || compare(name, &scene(), repeats, named("ours")));
    }
}
