//! The narrow phase: from candidates to the set of active pairs, on the peers' scenes.
//!
//! Prints medians of interleaved repeats, and beside them the time of a loop of divisions that calibrates the machine.
//! The reference library's narrow phase takes 1.3 µs a contact on the same scenes (`measured.md`).
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/scenes/peers.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with other tests and benches")]
mod peers;

#[path = "../../mechanics-core/benches/timing/timing.rs"]
mod timing;

use ipc_contact::broad_phase::{BroadPhase, Candidates};
use ipc_contact::collision_mesh::{CollisionMesh, CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact_set::{ContactSet, Weighting};
use mechanics_core::parallel::with_threads;
use peers::PeerScene;
use std::hint::black_box;
use std::time::Instant;
use timing::median;

struct Case {
    name: &'static str,
    scene: PeerScene,
    mesh: CollisionMesh,
    candidates: Candidates,
}

impl Case {
    fn new(name: &'static str, scene: PeerScene) -> Self {
        let mut builder = CollisionMeshBuilder::new(&scene.start);
        builder.add_object(CollisionObject::new(scene.triangles.clone()));
        let mesh = builder.build().unwrap();
        let (mut candidates, x) = (Candidates::default(), &scene.start);
        let inflation = 0.5 * scene.activation_distance;
        BroadPhase::new(&mesh).candidates(&mesh, x, x, inflation, &mut candidates).unwrap();
        Self { name, scene, mesh, candidates }
    }

    fn rebuild(&self, set: &mut ContactSet, weighting: Weighting) {
        let activation = self.scene.activation_distance.powi(2);
        set.rebuild(&self.mesh, &self.candidates, &self.scene.start, activation, weighting);
    }
}

fn seconds(work: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

/// Ten million dependent divisions.
fn calibrate() {
    let mut x = black_box(1.5_f64);
    for _ in 0..10_000_000 {
        x = 3.0 / x;
    }
    black_box(x);
}

fn main() {
    let repeats: usize = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(21);
    for case in [Case::new("cloth100", peers::cloth(100)), Case::new("spheres3", peers::spheres(3))] {
        let mut set = ContactSet::default();
        let mut times = [const { Vec::new() }; 4];
        for _ in 0..repeats {
            times[0].push(seconds(&mut calibrate));
            times[1].push(with_threads(1, || seconds(&mut || case.rebuild(&mut set, Weighting::Unit))));
            times[2].push(with_threads(1, || seconds(&mut || case.rebuild(&mut set, Weighting::Area))));
            times[3].push(with_threads(2, || seconds(&mut || case.rebuild(&mut set, Weighting::Unit))));
        }
        let [calibration, unit, area, two] = times.map(median);
        case.rebuild(&mut set, Weighting::Unit);
        let per = |time: f64, count: usize| 1e9 * time / count as f64;
        println!(
            "{}: {} candidates, {} contacts | unit {:.0} ns a contact, {:.0} ns a candidate | area {:.0} ns | \
             two threads {:.2}x | calibration {:.1} ms",
            case.name,
            case.candidates.len(),
            set.len(),
            per(unit, set.len()),
            per(unit, case.candidates.len()),
            per(area, set.len()),
            unit / two,
            1e3 * calibration,
        );
    }
}
