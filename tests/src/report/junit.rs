//! JUnit XML, which every continuous-integration server reads: one test case a scene.

use super::digest::{Tally, completed, exit_text};
use super::text::escaped;
use crate::record::{Exit, Report, SceneRecord, Verdict};
use std::collections::BTreeMap;

/// `report` as JUnit XML: a suite a crate, a case a scene, a `<failure>` for every check that failed, an `<error>` for
/// every crash.
pub fn junit(report: &Report) -> String {
    let mut crates: BTreeMap<&str, Vec<&SceneRecord>> = BTreeMap::new();
    for scene in &report.scenes {
        crates.entry(&scene.crate_name).or_default().push(scene);
    }
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let all: Vec<&SceneRecord> = report.scenes.iter().collect();
    out += &format!("<testsuites name=\"{}\"{}>\n", escaped(&report.suite), numbers(&all));
    for (name, scenes) in crates {
        out += &format!("  <testsuite name=\"{}\"{}>\n", escaped(name), numbers(&scenes));
        scenes.iter().for_each(|scene| out += &case(scene));
        out += "  </testsuite>\n";
    }
    out + "</testsuites>\n"
}

fn numbers(scenes: &[&SceneRecord]) -> String {
    let tally = Tally::of(scenes.iter().copied());
    let errors = scenes.iter().filter(|scene| is_error(scene)).count();
    format!(
        " tests=\"{}\" failures=\"{}\" errors=\"{errors}\" skipped=\"{}\" time=\"{:.6}\"",
        scenes.len(),
        tally.failed - errors,
        tally.skipped,
        scenes.iter().map(|scene| seconds(scene)).sum::<f64>(),
    )
}

/// Whether the scene failed with a crash; JUnit counts such a case under errors, not failures.
fn is_error(scene: &SceneRecord) -> bool {
    let crashed =
        scene.lines.iter().flat_map(|line| &line.rows).any(|row| matches!(row.exit, Exit::Crashed { .. }));
    scene.verdict == Verdict::Failed && crashed
}

fn seconds(scene: &SceneRecord) -> f64 {
    let rows = scene.lines.iter().flat_map(|line| &line.rows);
    rows.map(|row| row.seconds * row.repeats.max(1) as f64).sum()
}

fn case(scene: &SceneRecord) -> String {
    let (name, class) = (escaped(&scene.name), escaped(&scene.crate_name));
    let mut out =
        format!("    <testcase name=\"{name}\" classname=\"{class}\" time=\"{:.6}\">\n", seconds(scene));
    if let Verdict::Skipped { reason } = &scene.verdict {
        out += &format!("      <skipped message=\"{}\"/>\n", escaped(reason));
    }
    if scene.verdict == Verdict::Failed {
        let kind = if is_error(scene) { "error" } else { "failure" };
        let reasons = failures(scene);
        let message = reasons.first().cloned().unwrap_or_else(|| "its record names no failed check".into());
        let message = escaped(&message);
        out += &format!("      <{kind} message=\"{message}\">{}</{kind}>\n", escaped(&reasons.join("\n")));
    }
    out + "    </testcase>\n"
}

fn failures(scene: &SceneRecord) -> Vec<String> {
    let rows = scene.lines.iter().flat_map(|line| line.rows.iter().map(move |row| (line, row)));
    let stopped = rows.filter(|(_, row)| !completed(row)).map(|(line, row)| {
        format!("{} at {} = {}: {}", line.label, scene.ladder.name, row.ladder, exit_text(&row.exit))
    });
    let checks = scene.checks.iter().filter(|check| check.verdict == Verdict::Failed);
    checks.map(|check| format!("{}: {}", check.name, check.detail)).chain(stopped).collect()
}
