//! What a second thread brings, stage by stage, on the peers' scenes.
//!
//!     cargo bench -p ipc-contact --bench threads [-- SCENE … STAGE …]
//!
//! Each pair of runs measures one thread and two threads one after the other, in pools that are awake; what is printed is the
//! median of the pairs' ratios. A stage named by the beginning of its name is measured alone. The bar is 1.7.

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

#[path = "../tests/scenes/peers.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with tests")]
mod peers;
#[path = "peers/stages.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with another bench")]
mod stages;

use mechanics_core::parallel::with_threads;
use peers::PeerScene;
use stages::Stages;
use std::time::Instant;

/// Pairs of runs.
const PAIRS: usize = 9;
/// A run repeats its stage for about this long \[s\].
const RUN: f64 = 0.01;

/// A scene's name, and how to make it.
type Known = (&'static str, fn() -> PeerScene);

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let known: [Known; 5] = [
        ("cloth100", || peers::cloth(100)),
        ("spheres3", || peers::spheres(3)),
        ("spheres2", || peers::spheres(2)),
        ("cloth30", || peers::cloth(30)),
        ("cloth15", || peers::cloth(15)),
    ];
    let is_scene = |name: &String| known.iter().any(|(scene, _)| scene == name);
    let wanted: Vec<&String> = asked.iter().filter(|name| !is_scene(name)).collect();
    for (name, scene) in known {
        if asked.iter().any(|a| a == name) || !asked.iter().any(is_scene) {
            compare(name, &scene(), &wanted);
        }
    }
}

fn compare(name: &str, scene: &PeerScene, wanted: &[&String]) {
    let mut stages = Stages::new(scene);
    println!("\n{name}: {} contacts", stages.set.len());
    let names: Vec<&str> = stages.measure(0).into_iter().map(|stage| stage.name).collect();
    for (stage, name) in names.into_iter().enumerate() {
        if !wanted.is_empty() && !wanted.iter().any(|wanted| name.starts_with(wanted.as_str())) {
            continue;
        }
        let mut pairs: Vec<[f64; 2]> = (0..PAIRS)
            .map(|_| [1, 2].map(|threads| with_threads(threads, || milliseconds(&mut stages, stage))))
            .collect();
        pairs.sort_by(|a, b| (a[0] / a[1]).total_cmp(&(b[0] / b[1])));
        let [least, most] = [0, PAIRS - 1].map(|k| pairs[k][0] / pairs[k][1]);
        let [one, two] = pairs[PAIRS / 2];
        println!("  {name:46} {one:9.3} ms {two:9.3} ms {:6.2}× ({least:.2} to {most:.2})", one / two);
    }
}

/// The mean time of a stage, in a pool that has run it before.
fn milliseconds(stages: &mut Stages<'_>, stage: usize) -> f64 {
    let warm = Instant::now();
    stages.run(stage);
    let repeats = (RUN / warm.elapsed().as_secs_f64()).ceil().clamp(1.0, 1e4);
    let start = Instant::now();
    for _ in 0..repeats as usize {
        stages.run(stage);
    }
    start.elapsed().as_secs_f64() * 1e3 / repeats
}
