//! Friction on the scenes of another system, that system on the same scenes in the same run, and what a second thread brings:
//! times, ratios, bars, and the values that both must agree in.
//!
//!     IPCTK_PYTHON=/tmp/ipctk-venv/bin/python PEERS_DIR=… cargo bench -p ipc-friction --bench peers [-- SCENE …]
//!
//! `IPCTK_PYTHON` names a Python with ipctk 1.6.1, numpy and scipy, `PEERS_DIR` the folder with `scenes.py`; without them only
//! ours is measured, and the ratios say SKIPPED. Ours is measured before and after the other. Normal forces are those of contact at the scene's
//! start with κ = 1; μ = 0.5, εᵥ = 1 mm/s, and the velocity is the way to the scene's end in one second.
//!
//! The other system leaves out edges that are nearly parallel, where contact's mollifier is at work; ours keeps them, with the normal force that
//! the mollifier leaves. Values are compared, and times of one thread taken, without them; the values of all are printed beside.
//!
//! # Measured
//! One thread, ratios of medians to ipctk's:
//!
//! | scene | pairs | value | gradient | both | Hessian, clamped, assembled | normal forces and pairs |
//! |---|---|---|---|---|---|---|
//! | `cloth100` | 78,210 | 0.36 | 0.21 | 0.22 | 0.012 (6.9 of 589 ms) | 1.05 |
//! | `spheres3` | 5,834 | 0.35 | 0.19 | 0.21 | 0.026 | 0.98 |
//!
//! Energy, gradient and Hessian agree to 8e-15 on both. A second thread brings 1.97× for the value on `cloth100`, 1.55× for the gradient, 1.74× for the Hessian and
//! 1.44× for normal forces; on `spheres3` 1.82× for the value, and scattered sums, which take less than half a millisecond, are slower with
//! it (gradient 0.88×, Hessian 0.58×).

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark prints")]

#[path = "../../ipc-contact/tests/scenes/peers.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with contact's tests and benches")]
mod peers;

use ipc_contact::collision_mesh::{CollisionMeshBuilder, CollisionObject};
use ipc_contact::contact::{BarrierContact, ContactOptions};
use ipc_contact::distance::EdgeEdgeMollifier;
use ipc_contact::normal_force::NormalForce;
use ipc_contact::stiffness::{Scale, Stiffness};
use ipc_friction::lagged::LaggedFriction;
use ipc_friction::law::{FrictionCoefficient, SmoothedCoulomb};
use mechanics_core::parallel::with_threads;
use mechanics_core::point_map::PointMap;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use mechanics_core::sparse::Assembly;
use mechanics_core::stage::{Coefficients, Scheme};
use mechanics_core::tensor::Vec3;
use peers::PeerScene;
use serde_json::Value;
use std::hint::black_box;
use std::process::Command;
use std::time::Instant;

/// Repeats of each stage, before and after the other system.
const REPEATS: usize = 9;
/// Interleaved pairs of runs with one thread and with two.
const PAIRS: usize = 11;
/// A run of a pair repeats its stage for about this long \[s\].
const RUN: f64 = 0.01;

/// What is timed: a name, the other system's keys that together are the same, the largest ratio we want.
const STAGES: [(&str, &[&str], Option<f64>); 6] = [
    ("normal forces and pairs", &["build_ms"], None),
    ("value", &["value_ms"], Some(0.6)),
    ("gradient", &["gradient_ms"], Some(0.6)),
    ("value and gradient", &["value_ms", "gradient_ms"], Some(0.6)),
    ("Hessian, not projected, assembled", &["hessian_ms"], None),
    ("Hessian, clamped, assembled", &["clamped_ms"], Some(0.1)),
];

/// A scene, its contact, and what its stages work on.
struct Work<'a> {
    scene: &'a PeerScene,
    contact: BarrierContact,
    friction: LaggedFriction,
    gradient: Vec<Vec3>,
    map: PointMap,
    assembly: Assembly,
}

/// Which pairs have friction.
#[derive(Clone, Copy, PartialEq)]
enum Keep {
    All,
    /// No nearly parallel edges.
    Unmollified,
}

impl<'a> Work<'a> {
    fn new(scene: &'a PeerScene, keep: Keep) -> Self {
        let mut builder = CollisionMeshBuilder::new(&scene.start);
        builder.add_object(CollisionObject::new(scene.triangles.clone()));
        let options = ContactOptions::new(scene.activation_distance, Stiffness::fixed(Scale::Kappa(1.0)));
        let contact = BarrierContact::new(builder.build().unwrap(), options).unwrap();
        let mut forces = contact.normal_forces(&scene.start);
        if keep == Keep::Unmollified {
            // Pairs of edges come last. Their weights do not tell them from a point and a triangle: a mollified pair may be
            // closest at an end of the second edge, and then the weights of the first are the negative ones.
            let edges = forces.split_off(forces.len() - contact.contact_counts(&scene.start).edge_edges);
            forces.extend(edges.into_iter().filter(|force| !is_mollified(force, &scene.start)));
        }
        let map = PointMap::identity(scene.start.len());
        Self {
            friction: friction(scene, &forces),
            gradient: vec![Vec3::zeros(); scene.start.len()],
            assembly: Assembly::new(&map),
            scene,
            contact,
            map,
        }
    }

    fn add_gradient(&mut self) {
        self.gradient.fill(Vec3::zeros());
        self.friction.add_gradient(&self.scene.end, &mut self.gradient);
        black_box(&self.gradient);
    }

    fn assemble(&mut self, projection: Projection) {
        let mut assembler = self.assembly.begin(&self.map);
        self.friction.add_hessian(&self.scene.end, projection, &mut assembler);
        black_box(assembler.finish());
    }

    fn run(&mut self, stage: usize) {
        match stage {
            0 => {
                black_box(friction(self.scene, &self.contact.normal_forces(&self.scene.start)));
            }
            1 => _ = black_box(self.friction.value(&self.scene.end)),
            2 => self.add_gradient(),
            3 => {
                black_box(self.friction.value(&self.scene.end));
                self.add_gradient();
            }
            4 => self.assemble(Projection::None),
            _ => self.assemble(Projection::Clamp),
        }
    }

    /// Milliseconds of every stage, `REPEATS` times, all stages in turn.
    fn measure(&mut self) -> Vec<Vec<f64>> {
        let mut times = vec![Vec::new(); STAGES.len()];
        (0..STAGES.len()).for_each(|stage| self.run(stage));
        for _ in 0..REPEATS {
            for (stage, times) in times.iter_mut().enumerate() {
                let start = Instant::now();
                self.run(stage);
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
        times
    }

    /// The mean time of a stage \[ms\], in a pool that has run it before.
    fn milliseconds(&mut self, stage: usize) -> f64 {
        let warm = Instant::now();
        self.run(stage);
        let repeats = (RUN / warm.elapsed().as_secs_f64()).ceil().clamp(1.0, 1e4);
        let start = Instant::now();
        (0..repeats as usize).for_each(|_| self.run(stage));
        start.elapsed().as_secs_f64() * 1e3 / repeats
    }

    fn gradient_norm(&mut self) -> f64 {
        self.add_gradient();
        self.gradient.iter().map(|g| g.norm_squared()).sum::<f64>().sqrt()
    }

    /// The Frobenius norm of the clamped Hessian. Its lower triangle is stored.
    fn hessian_norm(&mut self) -> f64 {
        self.assemble(Projection::Clamp);
        let matrix = self.assembly.matrix();
        let pattern = matrix.pattern();
        let squares = (0..pattern.columns()).flat_map(|column| {
            pattern.column(column).map(move |slot| {
                let count = if pattern.rows()[slot] as usize == column { 1.0 } else { 2.0 };
                count * matrix.blocks()[slot].norm_squared()
            })
        });
        squares.sum::<f64>().sqrt()
    }
}

/// Are these edges so nearly parallel that contact's mollifier is at work?
fn is_mollified(force: &NormalForce, x: &[Vec3]) -> bool {
    let &[a, b, c, d] = force.points() else { return false };
    let corners = [a, b, c, d].map(|point| x[point as usize]);
    EdgeEdgeMollifier::from_rest(&corners).is_active(&corners)
}

fn friction(scene: &PeerScene, forces: &[NormalForce]) -> LaggedFriction {
    let law = SmoothedCoulomb::new(1e-3).unwrap();
    let coefficients = vec![FrictionCoefficient::new(0.5).unwrap(); forces.len()];
    let coefficients_of_scheme = Coefficients { inertia: 1.0, velocity: 1.0 };
    let scheme = Scheme::new(coefficients_of_scheme, &scene.start, &scene.start);
    LaggedFriction::new(law, forces, &coefficients, &scheme).unwrap()
}

/// What the other system measured, or why it did not.
fn run_peer(scene: &str) -> Result<Value, String> {
    let variable = |name: &str| std::env::var(name).map_err(|_| format!("{name} is not set"));
    let (python, folder) = (variable("IPCTK_PYTHON")?, variable("PEERS_DIR")?);
    let output = Command::new(python)
        .args([concat!(env!("CARGO_MANIFEST_DIR"), "/benches/peers/ipctk_friction.py"), scene, "9"])
        .env("PYTHONPATH", folder)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .map_err(|error| error.to_string())?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())
}

/// The sums of the other system's least and median times for these keys \[ms\].
fn peer_times(peer: &Value, keys: &[&str]) -> Option<[f64; 2]> {
    keys.iter().try_fold([0.0; 2], |[least, median], key| {
        Some([least + peer[key][0].as_f64()?, median + peer[key][1].as_f64()?])
    })
}

fn least_and_median(mut times: Vec<f64>) -> [f64; 2] {
    times.sort_by(f64::total_cmp);
    [times[0], times[times.len() / 2]]
}

fn print_values(ours: &mut Work<'_>, same: &mut Work<'_>, peer: Option<&Value>) {
    let theirs = peer.map_or("SKIPPED".to_owned(), |peer| peer["pairs"].to_string());
    println!("  pairs: {}, compared {}, ipctk {theirs}", ours.friction.len(), same.friction.len());
    let both = |work: &mut Work<'_>| {
        [work.friction.value(&work.scene.end), work.gradient_norm(), work.hessian_norm()]
    };
    let (ours, same) = (both(ours), both(same));
    let whats =
        [("energy", "value"), ("norm of the gradient", "gradient"), ("norm of the Hessian", "clamped")];
    for (k, (what, key)) in whats.into_iter().enumerate() {
        let theirs = peer.and_then(|peer| peer[key].as_f64());
        let verdict = theirs.map_or("SKIPPED".to_owned(), |theirs| {
            format!("{theirs:e}; relative difference {:.1e}", (same[k] - theirs).abs() / theirs.abs())
        });
        println!("  {what:22} all {:e}, compared {:e}, ipctk {verdict}", ours[k], same[k]);
    }
}

fn print_times(ours: Vec<Vec<f64>>, peer: Option<&Value>) {
    println!(
        "  {:36} {:>9} {:>9} {:>9} {:>9} {:>15} {:>6}",
        "one thread, ms", "ours min", "median", "ipctk min", "median", "ratio min/med", "bar"
    );
    for ((name, keys, bar), times) in STAGES.into_iter().zip(ours) {
        let [least, median] = least_and_median(times);
        let theirs = peer.and_then(|peer| peer_times(peer, keys));
        let theirs = theirs.map_or("SKIPPED".to_owned(), |[l, m]| {
            format!("{l:9.2} {m:9.2} {:7.3} {:7.3}", least / l, median / m)
        });
        let bar = bar.map_or("–".to_owned(), |bar| bar.to_string());
        println!("  {name:36} {least:9.3} {median:9.3} {theirs} {bar:>6}");
    }
}

/// The median of interleaved pairs of runs with one thread and with two; the bar is 1.7.
fn print_threads(work: &mut Work<'_>) {
    for (stage, (name, ..)) in STAGES.into_iter().enumerate() {
        let pair = |_| [1, 2].map(|threads| with_threads(threads, || work.milliseconds(stage)));
        let mut pairs: Vec<[f64; 2]> = (0..PAIRS).map(pair).collect();
        pairs.sort_by(|a, b| (a[0] / a[1]).total_cmp(&(b[0] / b[1])));
        let [least, most] = [0, PAIRS - 1].map(|k| pairs[k][0] / pairs[k][1]);
        let [one, two] = pairs[PAIRS / 2];
        let ratio = one / two;
        println!("  {name:36} {one:9.3} ms {two:9.3} ms on two: {ratio:5.2}× ({least:.2} to {most:.2})");
    }
}

fn compare(name: &str, scene: &PeerScene) {
    println!("\n{name}");
    let [mut ours, mut same] = [Keep::All, Keep::Unmollified].map(|keep| Work::new(scene, keep));
    let mut times = with_threads(1, || same.measure());
    let peer = run_peer(name);
    for (stage, again) in times.iter_mut().zip(with_threads(1, || same.measure())) {
        stage.extend(again);
    }
    if let Err(reason) = &peer {
        println!("  SKIPPED, the comparison with ipctk: {reason}");
    }
    print_values(&mut ours, &mut same, peer.as_ref().ok());
    print_times(times, peer.as_ref().ok());
    print_threads(&mut ours);
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let scenes: [(&str, PeerScene); 2] = [("cloth100", peers::cloth(100)), ("spheres3", peers::spheres(3))];
    for (name, scene) in scenes {
        if asked.is_empty() || asked.iter().any(|a| a == name) {
            compare(name, &scene);
        }
    }
}
