//! The table a run ends with on a terminal: at most 100 columns, readable without colour.

use super::digest::{Tally, compared_rows, completed, finest_error, order_text, troubles};
use super::text::{cut, cut_front, duration, one_line, significant, wrapped};
use crate::record::{Line, Report, SceneRecord, Verdict};

/// The widest line.
pub const WIDTH: usize = 100;

const HEADERS: [&str; 7] = ["verdict", "scene", "method", "points", "error", "order", "time"];
const SCENE: usize = 1;
const METHOD: usize = 2;

/// The table of `report`, one line a method, then what failed or was left out, and last `N passed, N failed, N skipped`.
pub fn table(report: &Report) -> String {
    let rows: Vec<[String; 7]> = report.scenes.iter().flat_map(scene_rows).collect();
    let widths = column_widths(&rows);
    let mut out = format!("{}\n", written(&HEADERS.map(String::from), &widths));
    out += &format!("{}\n", "-".repeat(widths.iter().sum::<usize>() + 2 * (widths.len() - 1)));
    for row in &rows {
        out += &format!("{}\n", written(row, &widths));
    }
    out += "\nerror: first measure at the finest completed point; order: observed (expected); time: of that point\n";
    out += &omissions(report);
    if report.interrupted {
        out += "\nInterrupted: the scenes that had not started are not in this table. --resume goes on.\n";
    }
    out += &format!("\n{}\n", Tally::of(&report.scenes));
    out
}

fn scene_rows(scene: &SceneRecord) -> Vec<[String; 7]> {
    let verdict = match &scene.verdict {
        Verdict::Passed => "ok",
        Verdict::Failed => "FAILED",
        Verdict::Skipped { .. } => "skipped",
    };
    let row = |rest: [String; 5]| {
        let [method, points, error, order, time] = rest;
        [verdict.into(), one_line(&scene.name), method, points, error, order, time]
    };
    if scene.lines.is_empty() {
        return vec![row(["-", "-", "-", "-", "-"].map(String::from))];
    }
    scene.lines.iter().map(|line| row(line_cells(scene, line))).collect()
}

fn line_cells(scene: &SceneRecord, line: &Line) -> [String; 5] {
    let done = line.rows.iter().filter(|row| completed(row)).count();
    let expected = line.orders.first().map(|order| order.expected);
    let order = match (order_text(line), expected) {
        (text, Some(expected)) if !text.is_empty() => format!("{text} ({expected})"),
        (text, _) if !text.is_empty() => text,
        _ => "-".into(),
    };
    let time = compared_rows(line).filter(|row| completed(row)).last();
    [
        one_line(&line.label),
        format!("{done}/{}", line.rows.len()),
        finest_error(scene, line).map_or("-".into(), significant),
        order,
        time.map_or("-".into(), |row| duration(row.seconds)),
    ]
}

/// As wide as their content; what does not fit into [`WIDTH`] is taken from the two columns of names.
fn column_widths(rows: &[[String; 7]]) -> [usize; 7] {
    let mut widths = HEADERS.map(str::len);
    for row in rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let gaps = 2 * (widths.len() - 1);
    for column in [METHOD, SCENE] {
        let excess = (widths.iter().sum::<usize>() + gaps).saturating_sub(WIDTH);
        let least = if column == METHOD { 18 } else { 12 };
        widths[column] = widths[column].saturating_sub(excess).max(least.min(widths[column]));
    }
    // Numbers are short by construction; this is for an order of 1e300.
    let excess = (widths.iter().sum::<usize>() + gaps).saturating_sub(WIDTH);
    widths[5] = widths[5].saturating_sub(excess);
    widths
}

fn written(cells: &[String; 7], widths: &[usize; 7]) -> String {
    let mut out = String::new();
    for (column, (cell, &width)) in cells.iter().zip(widths).enumerate() {
        // A scene's crate is the less telling part of its name.
        let cell = if column == SCENE { cut_front(cell, width) } else { cut(cell, width) };
        let pad = " ".repeat(width - cell.chars().count());
        let gap = if column == 0 { "" } else { "  " };
        // Names to the left, numbers to the right.
        out += &if column <= METHOD { format!("{gap}{cell}{pad}") } else { format!("{gap}{pad}{cell}") };
    }
    out.trim_end().into()
}

fn omissions(report: &Report) -> String {
    let found = troubles(report);
    if found.is_empty() {
        return String::new();
    }
    let mut out = String::from("\nomissions and failures\n");
    for trouble in found {
        for line in wrapped(&format!("{}: {}", trouble.scenes.join(", "), trouble.what), WIDTH - 2) {
            out += &format!("  {line}\n");
        }
        for line in wrapped(&trouble.reason, WIDTH - 6) {
            out += &format!("      {line}\n");
        }
    }
    out
}
