//! `rows.csv`: one line a run, for a spreadsheet or a data frame.

use super::digest::exit_text;
use crate::record::{Report, Row};
use std::collections::BTreeSet;

const FIXED: [&str; 17] = [
    "scene",
    "crate",
    "scene_verdict",
    "method",
    "ladder_name",
    "ladder_unit",
    "ladder",
    "threads",
    "exit",
    "message",
    "seconds",
    "seconds_spread",
    "simulated_seconds",
    "repeats",
    "peak_memory_bytes",
    "state_hash",
    "shard",
];

/// All rows of `report` as CSV (RFC 4180, first line the column names, UTF-8, lines end in CR LF).
///
/// After the fixed columns come `error:NAME`, `count:NAME`, `invariant:NAME` and `term_seconds:NAME` for every name that
/// occurs in the report, each group in name order; a cell is empty where a row has no such value. Numbers read back to
/// the same bits.
pub fn rows_csv(report: &Report) -> String {
    let columns = Columns::of(report);
    let mut out = record(FIXED.iter().map(|name| (*name).to_string()).chain(columns.names()));
    for scene in &report.scenes {
        for line in &scene.lines {
            for row in &line.rows {
                let fixed = [
                    scene.name.clone(),
                    scene.crate_name.clone(),
                    super::digest::verdict_word(&scene.verdict).into(),
                    line.label.clone(),
                    scene.ladder.name.clone(),
                    scene.ladder.unit.clone(),
                ];
                let shard = report.shard.clone().unwrap_or_default();
                out +=
                    &record(fixed.into_iter().chain(row_cells(row)).chain([shard]).chain(columns.cells(row)));
            }
        }
    }
    out
}

fn row_cells(row: &Row) -> [String; 10] {
    let exit = exit_text(&row.exit);
    let (kind, message) = exit.split_once(": ").unwrap_or((&exit, ""));
    [
        number(row.ladder),
        row.threads.to_string(),
        kind.split(' ').next().unwrap_or_default().into(),
        message.into(),
        number(row.seconds),
        number(row.seconds_spread),
        row.simulated_seconds.map(number).unwrap_or_default(),
        row.repeats.to_string(),
        row.peak_memory_bytes.to_string(),
        row.state_hash.clone(),
    ]
}

struct Columns<'a> {
    errors: BTreeSet<&'a str>,
    counts: BTreeSet<&'a str>,
    invariants: BTreeSet<&'a str>,
    terms: BTreeSet<&'a str>,
}

impl<'a> Columns<'a> {
    fn of(report: &'a Report) -> Self {
        let rows = || report.scenes.iter().flat_map(|scene| &scene.lines).flat_map(|line| &line.rows);
        Self {
            errors: rows().flat_map(|row| row.errors.keys()).map(String::as_str).collect(),
            counts: rows().flat_map(|row| row.counts.keys()).map(String::as_str).collect(),
            invariants: rows().flat_map(|row| row.invariants.keys()).map(String::as_str).collect(),
            terms: rows().flat_map(|row| &row.terms).map(|term| term.name.as_str()).collect(),
        }
    }

    fn names(&self) -> impl Iterator<Item = String> {
        let named = |group: &'static str| move |name: &&str| format!("{group}:{name}");
        let errors = self.errors.iter().map(named("error"));
        let counts = self.counts.iter().map(named("count"));
        let invariants = self.invariants.iter().map(named("invariant"));
        errors.chain(counts).chain(invariants).chain(self.terms.iter().map(named("term_seconds")))
    }

    fn cells(&self, row: &Row) -> impl Iterator<Item = String> {
        let value = |found: Option<&f64>| found.copied().map(number).unwrap_or_default();
        let term = |name: &&str| row.terms.iter().find(|term| term.name == *name).map(|term| &term.seconds);
        let errors = self.errors.iter().map(move |name| value(row.errors.get(*name)));
        let counts =
            self.counts.iter().map(|name| row.counts.get(*name).map(u64::to_string).unwrap_or_default());
        let invariants = self.invariants.iter().map(move |name| value(row.invariants.get(*name)));
        errors.chain(counts).chain(invariants).chain(self.terms.iter().map(move |name| value(term(name))))
    }
}

fn number(x: f64) -> String {
    let magnitude = x.abs();
    if magnitude == 0.0 || (1e-3..1e7).contains(&magnitude) { format!("{x}") } else { format!("{x:e}") }
}

fn record(cells: impl Iterator<Item = String>) -> String {
    let mut out = cells.map(|cell| quoted(&cell)).collect::<Vec<_>>().join(",");
    out += "\r\n";
    out
}

fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.into()
    }
}
