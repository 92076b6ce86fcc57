//! Counts. Those of iterations of the quick suite, as a snapshot: a change of algorithm shows in the review of a commit, also on
//! machines whose times cannot be compared. (The baseline gates errors, orders, hashes and every other count.) And those of what
//! does not run, because no scene names it: modules [`scenes`] and [`particles`].

// The whole file is test code.
#![allow(clippy::unwrap_used)]

#[path = "counts/particles.rs"]
mod particles;
#[path = "counts/scenes.rs"]
mod scenes;

use std::process::Command;

/// Newton iterations and factorisations, one line a row. Those of the conjugate gradients are left to the baseline: they may
/// move by one with the processor's rounding.
#[test]
fn newton_counts_of_the_quick_suite() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("report");
    let status = Command::new(env!("CARGO_BIN_EXE_validation"))
        .args([
            "validate",
            "--suite",
            "quick",
            "--crate",
            "mechanics-core",
            "--baseline",
            "none",
            "--no-plots",
        ])
        .args(["--repeat", "1", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    assert!(status.status.success(), "{}", String::from_utf8_lossy(&status.stdout));
    let report: validation::record::Report =
        serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap();
    let mut lines = Vec::new();
    for scene in &report.scenes {
        for line in &scene.lines {
            for row in &line.rows {
                if let (Some(iterations), Some(factorisations)) =
                    (row.counts.get("Newton iterations"), row.counts.get("factorisations"))
                {
                    lines.push(format!(
                        "{}, {}, {} = {:.4}: {iterations} iterations, {factorisations} factorisations",
                        scene.name, line.label, scene.ladder.name, row.ladder
                    ));
                }
            }
        }
    }
    insta::assert_snapshot!(lines.join("\n"));
}
