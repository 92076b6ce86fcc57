//! Time to find candidates, against other ways to find them: parry's trees, sort and sweep, a hash grid. All
//! answer the same sorted pairs, which is checked.
//!
//! `cargo bench -p ipc-contact --bench broad_phase [-- REPEATS] [cloth100|cloth200|spheres3] [ours]`

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
use mechanics_core::tensor::Vec3;
use peers::PeerScene;
use std::hint::black_box;
use std::time::Instant;

/// How long a piece of work took.
#[derive(Clone, Copy)]
struct Duration {
    wall: f64,
    on_processor: f64,
}

/// Time that this thread has been on a processor, in milliseconds, as the scheduler of Linux knows it (to a tick);
/// 0 elsewhere.
fn time_on_processor() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0) * 1e-6
}

fn milliseconds(work: impl FnOnce()) -> Duration {
    let (start, before) = (Instant::now(), time_on_processor());
    work();
    Duration { wall: start.elapsed().as_secs_f64() * 1e3, on_processor: time_on_processor() - before }
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

/// A measurement by name.
struct Case<'a> {
    name: &'static str,
    run: Box<dyn FnMut() -> Duration + Send + 'a>,
}

impl<'a> Case<'a> {
    fn new(name: &'static str, run: impl FnMut() -> Duration + Send + 'a) -> Self {
        Self { name, run: Box::new(run) }
    }
}

/// Runs all cases in turn, many times, so that a slow moment of the machine falls on all of them; prints medians
/// of the time by the clock, and means of the thread's own time, which a busy machine disturbs less. The ratio is
/// to the second case.
fn measure(cases: &mut [Case<'_>], repeats: usize) {
    let mut times = vec![Vec::new(); cases.len()];
    for _ in 0..repeats {
        for (case, times) in cases.iter_mut().zip(&mut times) {
            times.push((case.run)());
        }
    }
    times.iter_mut().for_each(|t| t.sort_by(|a, b| a.wall.total_cmp(&b.wall)));
    let own = |t: &[Duration]| t.iter().map(|t| t.on_processor).sum::<f64>() / repeats as f64;
    for (case, t) in cases.iter().zip(&times) {
        println!(
            "  {:36} {:8.2} ms (least {:.2}), own {:.2} ms, {:.2}x",
            case.name,
            t[repeats / 2].wall,
            t[0].wall,
            own(t),
            own(t) / own(&times[1])
        );
    }
}

/// A scene, its mesh, and the inflation of boxes for contact.
struct Subject {
    mesh: CollisionMesh,
    scene: PeerScene,
}

impl Subject {
    fn search(&self, broad: &mut BroadPhase, end: &[Vec3], inflation: f64, found: &mut Candidates) {
        broad.candidates(&self.mesh, &self.scene.start, end, inflation, found).expect("positions are finite");
    }

    fn radius(&self) -> f64 {
        0.5 * self.scene.activation_distance
    }

    fn boxes(&self) -> Boxes {
        Boxes::new(&self.mesh, &self.scene.start, &self.scene.start, self.radius())
    }

    /// A search that builds its trees.
    fn anew(&self) -> Duration {
        let mut found = Candidates::default();
        milliseconds(|| {
            self.search(&mut BroadPhase::new(&self.mesh), &self.scene.start, self.radius(), &mut found)
        })
    }

    /// Searches that refit theirs.
    fn refitted<'a>(&'a self, end: &'a [Vec3], inflation: f64) -> impl FnMut() -> Duration + Send + 'a {
        let (mut broad, mut found) = (BroadPhase::new(&self.mesh), Candidates::default());
        self.search(&mut broad, end, inflation, &mut found);
        move || milliseconds(|| self.search(&mut broad, end, inflation, &mut found))
    }

    fn ours(&self) -> Vec<Case<'_>> {
        let (start, end) = (&self.scene.start, &self.scene.end);
        let mut two = self.refitted(start, self.radius());
        vec![
            Case::new("calibration", || milliseconds(calibration)),
            Case::new("refitted, static", self.refitted(start, self.radius())),
            Case::new("refitted, swept", self.refitted(end, 0.0)),
            Case::new("built anew, static", || self.anew()),
            Case::new("refitted, static, two threads", move || with_threads(2, &mut two)),
            Case::new("built anew, static, two threads", || with_threads(2, || self.anew())),
        ]
    }

    fn others(&self) -> Vec<Case<'_>> {
        let (mut parry, mut pairs) = (Parry::build(&self.boxes()), Parry::build(&self.boxes()));
        let anew = || {
            milliseconds(|| {
                let boxes = self.boxes();
                black_box(Parry::build(&boxes).query(&self.mesh, &boxes));
            })
        };
        let box_by_box = move || {
            milliseconds(|| {
                let boxes = self.boxes();
                parry.refit(&boxes);
                black_box(parry.query(&self.mesh, &boxes));
            })
        };
        let tree_by_tree = move || {
            milliseconds(|| {
                let boxes = self.boxes();
                pairs.refit(&boxes);
                black_box(pairs.query_pairs(&self.mesh, &boxes));
            })
        };
        let sweep = || milliseconds(|| drop(black_box(alternatives::sweep(&self.mesh, &self.boxes()))));
        let grid = || milliseconds(|| drop(black_box(alternatives::grid(&self.mesh, &self.boxes()))));
        vec![
            Case::new("parry, built anew, box by box", anew),
            Case::new("parry, refitted, box by box", box_by_box),
            Case::new("parry, refitted, tree by tree", tree_by_tree),
            Case::new("sort and sweep", sweep),
            Case::new("hash grid", grid),
        ]
    }

    /// All ways must find the same.
    fn check(&self) -> Candidates {
        let mut ours = Candidates::default();
        self.search(&mut BroadPhase::new(&self.mesh), &self.scene.start, self.radius(), &mut ours);
        let boxes = self.boxes();
        let parry = Parry::build(&boxes);
        for other in [
            parry.query(&self.mesh, &boxes),
            parry.query_pairs(&self.mesh, &boxes),
            alternatives::sweep(&self.mesh, &boxes),
            alternatives::grid(&self.mesh, &boxes),
        ] {
            assert!(
                other[0] == ours.point_triangles && other[1] == ours.edge_edges,
                "all ways find the same"
            );
        }
        ours
    }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let repeats = words.iter().find_map(|a| a.parse().ok()).unwrap_or(11);
    let named = |name: &str| words.iter().any(|w| w == name);
    let names = ["cloth100", "cloth200", "spheres3"];
    let all = !names.iter().any(|name| named(name));
    for name in names.into_iter().filter(|name| all || named(name)) {
        let scene = match name {
            "cloth100" => peers::cloth(100),
            "cloth200" => peers::cloth(200),
            _ => peers::spheres(3),
        };
        let subject = Subject { mesh: one_object(&scene), scene };
        // Within a pool of one thread all parallel work runs on that thread.
        with_threads(1, || {
            let found = subject.check();
            let [faces, edges] = [&found.point_triangles, &found.edge_edges].map(Vec::len);
            println!("\n{name}: {faces} pairs of point and triangle, {edges} of edges");
            let mut cases = subject.ours();
            if !named("ours") {
                cases.extend(subject.others());
            }
            measure(&mut cases, repeats);
        });
    }
}
