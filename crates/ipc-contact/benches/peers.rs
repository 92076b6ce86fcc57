//! Every stage of contact on the scenes of another system, and that system on the same scenes in the same run: times,
//! ratios, bars, and the values that both must agree in.
//!
//!     IPCTK_PYTHON=/tmp/ipctk-venv/bin/python PEERS_DIR=… cargo bench -p ipc-contact --bench peers [-- SCENE …]
//!
//! `IPCTK_PYTHON` names a Python with ipctk 1.6.1, numpy and scipy (`python3 -m venv VENV && VENV/bin/pip install
//! ipctk==1.6.1 numpy scipy`), `PEERS_DIR` the folder with `bench_ipctk.py`. Without them the ratios say SKIPPED. Ours
//! is measured before and after the other, and the times of both halves count, so that a slow moment of the machine shows.

#![allow(clippy::print_stdout, reason = "a benchmark prints")]

#[path = "peers/checks.rs"]
#[allow(unreachable_pub, reason = "a part of this bench")]
mod checks;
#[path = "../tests/scenes/peers.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with tests")]
mod peers;
#[path = "peers/stages.rs"]
#[allow(unreachable_pub, reason = "a part of this bench")]
mod stages;

#[path = "../../mechanics-core/benches/timing/timing.rs"]
mod timing;

use mechanics_core::parallel::with_threads;
use peers::PeerScene;
use serde_json::Value;
use stages::{Stage, Stages};
use std::path::PathBuf;
use std::process::Command;
use timing::calibration;

/// Repeats of each stage, before and after the other system.
const REPEATS: usize = 7;

/// What the other system measured, or why it did not.
type Peer = Result<Value, String>;

/// A scene's name, and how to make it.
type Known = (&'static str, fn() -> PeerScene);

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let known: [Known; 4] = [
        ("cloth100", || peers::cloth(100)),
        ("spheres3", || peers::spheres(3)),
        ("cloth200", || peers::cloth(200)),
        ("cloth300", || peers::cloth(300)),
    ];
    for (k, (name, scene)) in known.into_iter().enumerate() {
        if asked.iter().any(|a| a == name) || (asked.is_empty() && k < 2) {
            compare(name, &scene());
        }
    }
}

fn compare(name: &str, scene: &PeerScene) {
    println!("\n{name}; calibration {:.3} ns a dependent multiplication and addition", calibration());
    let mut stages = Stages::new(scene);
    let mut one = with_threads(1, || stages.measure(REPEATS));
    let peer = run_peer(name);
    for (stage, again) in one.iter_mut().zip(with_threads(1, || stages.measure(REPEATS))) {
        stage.milliseconds.extend(again.milliseconds);
    }
    let two = with_threads(2, || stages.measure(REPEATS));
    println!("calibration {:.3} ns", calibration());
    checks::print(name, &mut stages, &peer);
    print_times(&one, &two, &peer);
}

fn run_peer(scene: &str) -> Peer {
    let variable = |name: &str| std::env::var(name).map_err(|_| format!("{name} is not set"));
    let (python, folder) = (variable("IPCTK_PYTHON")?, PathBuf::from(variable("PEERS_DIR")?));
    let results = std::env::temp_dir().join(format!("peers-{}", std::process::id()));
    let output = Command::new(python)
        .args(["bench_ipctk.py", scene, "1", "5"])
        .current_dir(folder)
        .env("RESULTS_DIR", &results)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .map_err(|error| error.to_string())?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    let file = results.join(format!("ipctk_{scene}_1threads.json"));
    let text = std::fs::read_to_string(file).map_err(|error| error.to_string())?;
    serde_json::from_str(&text).map_err(|error| error.to_string())
}

/// The sum of the other system's times for the keys that begin so; the second is of medians, the first of minima.
fn peer_times(peer: &Value, keys: &[&str]) -> Option<[f64; 2]> {
    let table = peer.as_object()?;
    keys.iter().try_fold([0.0; 2], |sum, key| {
        let (_, times) = table.iter().find(|(name, times)| name.starts_with(key) && times.is_object())?;
        let [least, median] = ["min_ms", "median_ms"].map(|field| times[field].as_f64());
        Some([sum[0] + least?, sum[1] + median?])
    })
}

fn print_times(one: &[Stage], two: &[Stage], peer: &Peer) {
    println!(
        "  {:46} {:>9} {:>9} {:>9} {:>9} {:>15} {:>6} {:>11}",
        "one thread, ms", "ours min", "median", "ipctk min", "median", "ratio min/med", "bar", "two threads"
    );
    for (stage, two) in one.iter().zip(two) {
        let [least, median] = stage.summary();
        let other = peer.as_ref().ok().and_then(|peer| peer_times(peer, stage.peer_keys));
        let (theirs, ratio) = match other {
            Some([l, m]) => (format!("{l:9.2} {m:9.2}"), format!("{:7.3} {:7.3}", least / l, median / m)),
            None if stage.peer_keys.is_empty() => (format!("{:>19}", "–"), format!("{:>15}", "–")),
            None => (format!("{:>19}", "SKIPPED"), format!("{:>15}", "SKIPPED")),
        };
        let bar = stage.bar.map_or(String::from("–"), |bar| format!("{bar}"));
        let speed_up = median / two.summary()[1];
        println!("  {:46} {least:9.2} {median:9.2} {theirs} {ratio} {bar:>6} {speed_up:10.2}×", stage.name);
    }
    if let Err(reason) = peer {
        println!("  SKIPPED, the comparison with ipctk: {reason}");
    }
}
