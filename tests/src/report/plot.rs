//! The two plots of a scene: time against error, and error against the ladder.
//!
//! Both are log–log SVG drawings, 640 × 420 units, with text of 13 units. Colours are CSS variables (`--line-1` to
//! `--line-6`, `--ink`, `--faint`), so that the same drawing follows the theme of the page it is in.

mod axis;
mod marker;
mod place;
mod svg;

use super::digest::{compared_rows, completed, cost, cost_name, exit_text};
use super::text::{bracketed, counted, duration, one_line, significant};
use crate::record::{Line, Measure, Row, SceneRecord, Verdict};

/// At most this many lines are drawn; more cannot be told apart.
pub const MAX_LINES: usize = 6;

/// A log–log drawing.
#[derive(Clone, Debug)]
pub struct Plot {
    /// First line, bold: what is drawn, and which way is better.
    pub title: String,
    /// Second line: what was left out, what is not comparable; may be empty.
    pub note: String,
    /// What stands under the horizontal axis.
    pub x: String,
    /// What stands beside the vertical axis.
    pub y: String,
    /// The axis on which errors are: failed runs stand at its bad end, exact ones at its good end.
    pub error_axis: ErrorAxis,
    /// The lines.
    pub series: Vec<Series>,
    /// Expected order, drawn as a slope triangle.
    pub order: Option<f64>,
    /// Largest error allowed.
    pub bound: Option<f64>,
}

/// Which axis is the error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorAxis {
    /// Work–precision: error to the right.
    Horizontal,
    /// Convergence: error upwards.
    Vertical,
}

/// One method.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name, written beside the line.
    pub label: String,
    /// Its runs in ladder order.
    pub points: Vec<Point>,
}

/// One run.
#[derive(Clone, Debug)]
pub struct Point {
    /// Where it is on the horizontal axis; not positive or not finite where there is no such value.
    pub x: f64,
    /// Where it is on the vertical axis.
    pub y: f64,
    /// Whether it counts.
    pub state: PointState,
    /// What a pointer resting on it shows.
    pub detail: String,
}

/// Whether a run counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointState {
    /// A marker on the line.
    Completed,
    /// A hollow cross beside it.
    Failed,
}

impl Plot {
    /// The drawing for the inside of a page: it takes colours and fonts from there.
    pub fn inline_svg(&self) -> String {
        svg::drawing(self, "")
    }

    /// The drawing as a file of its own, with colours for light and dark.
    pub fn svg_file(&self) -> String {
        svg::drawing(self, svg::OWN_STYLE)
    }
}

/// Time against error of the first measure, one line a method. `None` when the scene has no measure or no run.
pub fn work_precision(scene: &SceneRecord) -> Option<Plot> {
    let measure = scene.measures.first()?;
    let cost_name = cost_name(scene);
    let point = |row: &Row| (error(row, measure), cost(row));
    let (series, note) = drawn_series(scene, measure, point)?;
    Some(Plot {
        title: "Time against error: left is more exact, down is faster".into(),
        note,
        x: format!("error: {}{}", one_line(&measure.name), bracketed(&measure.unit)),
        y: format!("{cost_name} [s]"),
        error_axis: ErrorAxis::Horizontal,
        series,
        order: None,
        bound: None,
    })
}

/// Error of `measure` against the ladder, one line a method, with the slope of the expected order. `None` when the scene
/// has no run.
pub fn convergence(scene: &SceneRecord, measure: &Measure) -> Option<Plot> {
    let point = |row: &Row| (row.ladder, error(row, measure));
    let (series, note) = drawn_series(scene, measure, point)?;
    let ladder = one_line(&scene.ladder.name);
    Some(Plot {
        title: format!("Error against {ladder}: down is more exact"),
        note,
        x: format!("{ladder}{}", bracketed(&scene.ladder.unit)),
        y: format!("error: {}{}", one_line(&measure.name), bracketed(&measure.unit)),
        error_axis: ErrorAxis::Vertical,
        series,
        order: measure.order.filter(|order| order.is_finite() && *order != 0.0),
        bound: measure.bound.filter(|bound| bound.is_finite() && *bound > 0.0),
    })
}

fn error(row: &Row, measure: &Measure) -> f64 {
    row.errors.get(&measure.name).copied().unwrap_or(f64::NAN)
}

fn drawn_series(
    scene: &SceneRecord,
    measure: &Measure,
    place: impl Fn(&Row) -> (f64, f64),
) -> Option<(Vec<Series>, String)> {
    if scene.lines.iter().all(|line| line.rows.is_empty()) {
        return None;
    }
    let chosen = chosen_lines(scene, measure);
    let series = chosen
        .iter()
        .map(|line| Series {
            label: one_line(&line.label),
            points: compared_rows(line).map(|row| drawn_point(scene, measure, row, place(row))).collect(),
        })
        .collect();
    Some((series, note(scene, chosen.len())))
}

fn drawn_point(scene: &SceneRecord, measure: &Measure, row: &Row, (x, y): (f64, f64)) -> Point {
    let state = if completed(row) { PointState::Completed } else { PointState::Failed };
    let mut detail = format!("{} = {}", one_line(&scene.ladder.name), significant(row.ladder));
    if let Some(&error) = row.errors.get(&measure.name) {
        detail +=
            &format!(", {} {}{}", one_line(&measure.name), significant(error), bracketed(&measure.unit));
    }
    detail += &format!(", {} ± {}", duration(row.seconds), duration(row.seconds_spread / 2.0));
    if state == PointState::Failed {
        detail += &format!(", {}", one_line(&exit_text(&row.exit)));
    }
    Point { x, y, state, detail }
}

/// All lines, or the [`MAX_LINES`] that own most of the best runs: those that no other run beats in both error and time.
fn chosen_lines<'a>(scene: &'a SceneRecord, measure: &Measure) -> Vec<&'a Line> {
    if scene.lines.len() <= MAX_LINES {
        return scene.lines.iter().collect();
    }
    let value = |row: &Row| (error(row, measure), cost(row));
    let all: Vec<(f64, f64)> =
        scene.lines.iter().flat_map(compared_rows).filter(|row| completed(row)).map(value).collect();
    let beaten = |(e, t): (f64, f64)| all.iter().any(|&(e2, t2)| e2 <= e && t2 <= t && (e2, t2) != (e, t));
    let best = |line: &Line| {
        compared_rows(line).filter(|row| completed(row)).map(value).filter(|&point| !beaten(point)).count()
    };
    let mut order: Vec<usize> = (0..scene.lines.len()).collect();
    order.sort_by_key(|&index| (std::cmp::Reverse(best(&scene.lines[index])), index));
    order.truncate(MAX_LINES);
    order.sort_unstable();
    order.into_iter().map(|index| &scene.lines[index]).collect()
}

fn note(scene: &SceneRecord, drawn: usize) -> String {
    let mut notes = Vec::new();
    if scene.verdict == Verdict::Failed {
        notes.push("checks of this scene failed: its times do not count".to_string());
    }
    if drawn < scene.lines.len() {
        notes.push(format!("the best {drawn} of {} methods; all are in the table", scene.lines.len()));
    }
    let threads = |line: &Line| line.rows.iter().map(|row| row.threads).min();
    let mut counts: Vec<usize> = scene.lines.iter().filter_map(threads).collect();
    counts.sort_unstable();
    counts.dedup();
    if let [threads] = counts[..] {
        notes.push(counted(threads, "thread"));
    }
    notes.join("; ")
}
