//! The committed baseline: what every scene gave when it was last accepted.
//!
//! Errors and orders gate everywhere: an error may be at most [`ERROR_BAND`] above its baseline plus the measure's
//! stated floor, an order at most [`ORDER_BAND`] below its baseline. Counts and state hashes gate exactly where the
//! machine's fingerprint (processor features, toolchain, profile) is that of the baseline; elsewhere counts may
//! differ by [`COUNT_BAND`] and hashes only inform. A wall time never gates: above [`TIME_BAND`] times its baseline
//! it is mentioned.

use crate::record::{Check, CheckKind, Exit, Line, ObservedOrder, Report, Row, SceneRecord, Verdict};
use crate::runner::output::{OutputError, write_file};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Allowed relative growth of an error.
pub const ERROR_BAND: f64 = 0.05;
/// Allowed fall of an observed order.
pub const ORDER_BAND: f64 = 0.1;
/// Allowed relative difference of a count on another machine; one more or less is always allowed there.
pub const COUNT_BAND: f64 = 0.1;
/// A wall time above this multiple of its baseline is mentioned.
pub const TIME_BAND: f64 = 1.5;

const VERSION: u32 = 1;

/// The baseline of all scenes.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    version: u32,
    scenes: BTreeMap<String, SceneBaseline>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneBaseline {
    /// The machine it was taken on, by [`crate::record::Environment::fingerprint`].
    fingerprint: String,
    /// The same for people.
    machine: String,
    lines: BTreeMap<String, LineBaseline>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LineBaseline {
    orders: BTreeMap<String, OrderBaseline>,
    rows: Vec<RowBaseline>,
}

/// An order and how many points it was fitted to: orders over other points are not compared.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OrderBaseline {
    order: f64,
    points: usize,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RowBaseline {
    ladder: f64,
    errors: BTreeMap<String, f64>,
    counts: BTreeMap<String, u64>,
    state_hash: String,
    seconds: f64,
}

impl Default for Baseline {
    fn default() -> Self {
        Self { version: VERSION, scenes: BTreeMap::new() }
    }
}

impl Baseline {
    /// Reads a baseline file.
    ///
    /// # Errors
    /// When it cannot be read or is none.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| OutputError::Read { path: path.to_owned(), source })?;
        let format = |reason: String| OutputError::Format { path: path.to_owned(), reason };
        let baseline: Self = serde_json::from_str(&text).map_err(|error| format(error.to_string()))?;
        if baseline.version == VERSION {
            Ok(baseline)
        } else {
            Err(format(format!("version {}, this program reads {VERSION}", baseline.version)))
        }
    }

    /// Writes the file.
    ///
    /// # Errors
    /// When it cannot be written; the old file is still there then.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|error| OutputError::Format { path: path.to_owned(), reason: error.to_string() })?;
        text.push('\n');
        Ok(write_file(path, text.as_bytes())?)
    }

    /// Takes over every scene of a report whose own checks hold; the others keep what they had. Answers the names
    /// of scenes that were not taken over.
    pub fn update(&mut self, report: &Report) -> Vec<String> {
        let mut refused = Vec::new();
        for scene in &report.scenes {
            let failed =
                |check: &Check| check.verdict == Verdict::Failed && check.kind != CheckKind::Baseline;
            if matches!(scene.verdict, Verdict::Skipped { .. }) || scene.checks.iter().any(failed) {
                refused.push(scene.name.clone());
                continue;
            }
            let environment = &report.environment;
            let entry = SceneBaseline {
                fingerprint: environment.fingerprint.clone(),
                machine: format!("{}, {}", environment.processor, environment.compiler),
                lines: scene.lines.iter().map(|line| (line.label.clone(), line_baseline(line))).collect(),
            };
            self.scenes.insert(scene.name.clone(), entry);
        }
        refused
    }

    /// Compares a scene with its baseline; `floor` gives the stated round-off floor of a line in a measure.
    pub fn compare(
        &self,
        scene: &SceneRecord,
        fingerprint: &str,
        floor: &dyn Fn(&str, &str) -> f64,
    ) -> Vec<Check> {
        let Some(expected) = self.scenes.get(&scene.name) else {
            return vec![skipped("baseline", "the scene is not in the baseline")];
        };
        let machine = if expected.fingerprint == fingerprint { Machine::Same } else { Machine::Other };
        let mut checks = Vec::new();
        for line in &scene.lines {
            let name = format!("{}: baseline", line.label);
            checks.push(match expected.lines.get(&line.label) {
                None => skipped(&name, "the method is not in the baseline"),
                Some(expected) => {
                    let floor = |measure: &str| floor(&line.label, measure);
                    compare_line(&name, line, expected, machine, &floor)
                }
            });
        }
        checks
    }
}

/// Whether a baseline was taken on a machine like this one.
#[derive(Clone, Copy, PartialEq)]
enum Machine {
    Same,
    Other,
}

fn line_baseline(line: &Line) -> LineBaseline {
    let first_threads = line.rows.first().map(|row| row.threads);
    let rows = line.rows.iter().filter(|row| Some(row.threads) == first_threads);
    LineBaseline {
        orders: line
            .orders
            .iter()
            .map(|fit| (fit.measure.clone(), OrderBaseline { order: fit.order, points: fit.points }))
            .collect(),
        rows: rows
            .map(|row| RowBaseline {
                ladder: row.ladder,
                errors: row.errors.clone(),
                counts: row.counts.clone(),
                state_hash: row.state_hash.clone(),
                seconds: row.seconds,
            })
            .collect(),
    }
}

/// One check a line: all that is worse than the baseline, and what is only to be mentioned.
fn compare_line(
    name: &str,
    line: &Line,
    expected: &LineBaseline,
    machine: Machine,
    floor: &dyn Fn(&str) -> f64,
) -> Check {
    let mut found = Findings::default();
    let mut compared = 0;
    for row in line.rows.iter().filter(|row| row.exit == Exit::Completed) {
        if let Some(expected) = expected.rows.iter().find(|expected| expected.ladder == row.ladder) {
            compare_row(row, expected, machine, floor, &mut found);
            compared += 1;
        }
    }
    for order in &line.orders {
        compare_order(order, expected, &mut found);
    }
    if compared == 0 && found.worse.is_empty() {
        return skipped(name, "none of its ladder points is in the baseline");
    }
    let verdict = if found.worse.is_empty() { Verdict::Passed } else { Verdict::Failed };
    Check { kind: CheckKind::Baseline, name: name.to_owned(), verdict, detail: found.sentence(compared) }
}

#[derive(Default)]
struct Findings {
    worse: Vec<String>,
    mentioned: Vec<String>,
}

impl Findings {
    fn sentence(self, compared: usize) -> String {
        let mut parts = self.worse;
        if parts.is_empty() {
            parts.push(format!("{compared} rows as before"));
        }
        parts.extend(self.mentioned.into_iter().map(|note| format!("(note: {note})")));
        parts.join("; ")
    }
}

fn compare_row(
    row: &Row,
    expected: &RowBaseline,
    machine: Machine,
    floor: &dyn Fn(&str) -> f64,
    found: &mut Findings,
) {
    let at = row.ladder;
    for (measure, &before) in &expected.errors {
        match row.errors.get(measure) {
            Some(&now) if now > before * (1.0 + ERROR_BAND) + floor(measure) => {
                found.worse.push(format!("{measure} at {at} is {now:.3e}, was {before:.3e}"));
            }
            Some(_) => {}
            None => found.worse.push(format!("{measure} at {at} is gone")),
        }
    }
    for (count, &before) in &expected.counts {
        let Some(&now) = row.counts.get(count) else {
            found.worse.push(format!("{count} at {at} is gone"));
            continue;
        };
        let band = (before as f64 * COUNT_BAND).max(1.0);
        let beyond = machine == Machine::Same && now != before || now.abs_diff(before) as f64 > band;
        if beyond {
            found.worse.push(format!("{count} at {at} is {now}, was {before}"));
        }
    }
    if row.state_hash != expected.state_hash {
        let note = format!("the state at {at} has other bits");
        match machine {
            Machine::Same => found.worse.push(note),
            Machine::Other => found.mentioned.push(format!("{note}, as on another machine it may")),
        }
    }
    if machine == Machine::Same && row.seconds > TIME_BAND * expected.seconds {
        found.mentioned.push(format!("{at} took {:.3e} s, was {:.3e} s", row.seconds, expected.seconds));
    }
}

fn compare_order(fit: &ObservedOrder, expected: &LineBaseline, found: &mut Findings) {
    let Some(before) = expected.orders.get(&fit.measure).filter(|before| before.points == fit.points) else {
        return;
    };
    if (fit.order - before.order).abs() > ORDER_BAND && fit.order.abs() < before.order.abs() {
        found.worse.push(format!("order of {} is {:.2}, was {:.2}", fit.measure, fit.order, before.order));
    }
}

fn skipped(name: &str, reason: &str) -> Check {
    Check {
        kind: CheckKind::Baseline,
        name: name.to_owned(),
        verdict: Verdict::Skipped { reason: reason.to_owned() },
        detail: reason.to_owned(),
    }
}
