//! Values that both systems must agree in.

use crate::Peer;
use crate::stages::Stages;
use ipc_contact::intersection;
use mechanics_core::potential::Potential;
use mechanics_core::projection::Projection;
use serde_json::Value;

/// Prints ours beside the other's.
pub fn print(name: &str, stages: &mut Stages<'_>, peer: &Peer) {
    let theirs = |path: &[&str]| {
        let value = path.iter().try_fold(peer.as_ref().ok()?, |value, key| match key.parse::<usize>() {
            Ok(index) => value.get(index),
            Err(_) => value.get(key),
        });
        value.and_then(number)
    };
    let scene = stages.scene;
    println!("  {:46} {:>24} {:>24}", "values", "ours", "ipctk");
    let count = |what: &str, ours: usize, path: &[&str]| {
        let other = theirs(path);
        let verdict = match other {
            Some(other) if other == ours as f64 => "",
            Some(_) => "DIFFERS",
            None => "SKIPPED",
        };
        println!("  {what:46} {ours:24} {:>24} {verdict}", other.map_or(String::new(), |v| format!("{v}")));
    };
    let real = |what: &str, ours: f64, path: &[&str]| {
        let other = theirs(path);
        let (text, verdict) = match other {
            Some(other) => (
                format!("{other:e}"),
                format!("relative difference {:.1e}", (ours - other).abs() / other.abs()),
            ),
            None => (String::new(), "SKIPPED".to_owned()),
        };
        println!("  {what:46} {ours:24e} {text:>24} {verdict}");
    };
    count("candidates: points and triangles", stages.near.point_triangles.len(), &["cand_static_LBVH", "0"]);
    count("candidates: edges", stages.near.edge_edges.len(), &["cand_static_LBVH", "1"]);
    count(
        "candidates on the way: points and triangles",
        stages.swept.point_triangles.len(),
        &["cand_ccd_LBVH", "0"],
    );
    count("candidates on the way: edges", stages.swept.edge_edges.len(), &["cand_ccd_LBVH", "1"]);
    let counts = stages.contact.contact_counts(&scene.start);
    count("contacts: two points", counts.point_points, &["collisions", "vv"]);
    count("contacts: point and edge", counts.point_edges, &["collisions", "ev"]);
    count("contacts: two edges", counts.edge_edges, &["collisions", "ee"]);
    count("contacts: point and triangle", counts.point_triangles, &["collisions", "fv"]);
    real(
        "smallest distance",
        stages.contact.smallest_distance(&scene.start).unwrap_or(f64::NAN),
        &["min_dist"],
    );
    real("energy", stages.contact.value(&scene.start), &["B"]);
    let gradient = stages.gradient().iter().map(|g| g.norm_squared()).sum::<f64>().sqrt();
    real("norm of the gradient", gradient, &["B_gradnorm"]);
    for (what, projection, key) in [
        ("Frobenius norm of the Hessian", Projection::None, "H_fro"),
        ("the same, clamped", Projection::Clamp, "Hc_fro"),
    ] {
        let mut fresh = Stages::new(scene);
        real(what, fresh.hessian_norm(projection), &[key]);
    }
    let ours = stages.step_limit();
    for (what, key) in [("additive", "toi_Additive"), ("tight inclusion", "toi_TightInclusion")] {
        println!("  {:46} {ours:24} {:>24}", format!("free part of the way; {what}"), text(theirs(&[key])));
    }
    for (what, x, key) in [("start", &scene.start, "intersects_t0"), ("end", &scene.end, "intersects_t1")] {
        let found = intersection::check(&stages.mesh, x).map_or(0, |pairs| pairs.len());
        let other = peer.as_ref().ok().and_then(|peer| peer.get(key)?.as_bool());
        let verdict = match other {
            Some(other) if other == (found > 0) => "",
            Some(_) => "DIFFERS",
            None => "SKIPPED",
        };
        println!(
            "  {:46} {found:24} {:>24} {verdict}",
            format!("intersections at the {what} of {name}"),
            other.map_or(String::new(), |b| b.to_string())
        );
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_f64()
}

fn text(value: Option<f64>) -> String {
    value.map_or_else(|| "SKIPPED".to_owned(), |value| value.to_string())
}
