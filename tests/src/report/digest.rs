//! What a report comes to: counts, worst verdicts, and the few sentences that open the page.

use super::answers::asked_scenes;
use super::text::{counted, duration, one_line, significant};
use crate::record::{Exit, Line, Measure, Report, Row, SceneRecord, Verdict};

/// How many scenes passed, failed and were skipped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Scenes whose every judged check held.
    pub passed: usize,
    /// Scenes with a check that did not hold.
    pub failed: usize,
    /// Scenes that were not judged.
    pub skipped: usize,
}

impl Tally {
    /// Counts the verdicts of `scenes`.
    pub fn of<'a>(scenes: impl IntoIterator<Item = &'a SceneRecord>) -> Self {
        let mut tally = Self::default();
        for scene in scenes {
            match scene.verdict {
                Verdict::Passed => tally.passed += 1,
                Verdict::Failed => tally.failed += 1,
                Verdict::Skipped { .. } => tally.skipped += 1,
            }
        }
        tally
    }

    /// Failed when anything failed, passed when something passed, otherwise skipped.
    pub fn verdict(self) -> Verdict {
        match (self.failed, self.passed) {
            (0, 0) => Verdict::Skipped { reason: "nothing ran".into() },
            (0, _) => Verdict::Passed,
            _ => Verdict::Failed,
        }
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} passed, {} failed, {} skipped", self.passed, self.failed, self.skipped)
    }
}

/// The counts of `tally` that are not zero: `2 passed, 1 failed`.
pub(super) fn brief(tally: Tally) -> String {
    let counts = [(tally.passed, "passed"), (tally.failed, "failed"), (tally.skipped, "skipped")];
    let some = counts.iter().filter(|(count, _)| *count > 0);
    some.map(|(count, word)| format!("{count} {word}")).collect::<Vec<_>>().join(", ")
}

/// One word for a verdict, the same in every report.
pub(super) fn verdict_word(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Passed => "passed",
        Verdict::Failed => "failed",
        Verdict::Skipped { .. } => "skipped",
    }
}

/// How a row ended, in words.
pub(super) fn exit_text(exit: &Exit) -> String {
    match exit {
        Exit::Completed => "completed".into(),
        Exit::Failed { message } => format!("failed: {message}"),
        Exit::Crashed { message } => format!("crashed: {message}"),
        Exit::TimedOut { limit_seconds } => format!("stopped at its time limit of {limit_seconds} s"),
    }
}

/// The rows of `line` that ran with the fewest threads, in ladder order: the ones that plots and tables compare.
pub(super) fn compared_rows(line: &Line) -> impl Iterator<Item = &Row> {
    let fewest = line.rows.iter().map(|row| row.threads).min();
    line.rows.iter().filter(move |row| Some(row.threads) == fewest)
}

/// Whether the row ran to its end.
pub(super) fn completed(row: &Row) -> bool {
    row.exit == Exit::Completed
}

/// Error of the first measure at the last completed ladder point (ladders go from coarse to fine).
pub(super) fn finest_error(scene: &SceneRecord, line: &Line) -> Option<f64> {
    let measure = scene.measures.first()?;
    let row = compared_rows(line).filter(|row| completed(row)).last()?;
    row.errors.get(&measure.name).copied()
}

/// Observed order of the first measure that has one, `2.00 ±0.02`.
pub(super) fn order_text(line: &Line) -> String {
    match line.orders.first() {
        Some(order) if order.half_width > 0.0 => format!("{:.2} ±{:.2}", order.order, order.half_width),
        Some(order) => format!("{:.2}", order.order),
        None => String::new(),
    }
}

/// Time of a row as plots show it: per simulated second where the scene simulates time, else wall time \[s\].
pub(super) fn cost(row: &Row) -> f64 {
    match row.simulated_seconds {
        Some(simulated) if simulated > 0.0 => row.seconds / simulated,
        _ => row.seconds,
    }
}

/// The name of what [`cost`] answers.
pub(super) fn cost_name(scene: &SceneRecord) -> &'static str {
    let simulates = |row: &Row| row.simulated_seconds.is_some_and(|t| t > 0.0);
    match scene.lines.iter().flat_map(|line| &line.rows).any(simulates) {
        true => "time per simulated second",
        false => "wall time",
    }
}

/// The scene that shows most: of those that passed, one that answers a choice that users have ([`asked_scenes`]); among several the one whose
/// finest points cost most, because there the choice of a method matters most; the first of equals.
pub(super) fn showpiece<'a>(scenes: impl IntoIterator<Item = &'a SceneRecord>) -> Option<&'a SceneRecord> {
    let shown = |scene: &SceneRecord| -> usize {
        let Some(measure) = scene.measures.first() else { return 0 };
        let has_error = |row: &&Row| completed(row) && row.errors.contains_key(&measure.name);
        scene.lines.iter().map(|line| compared_rows(line).filter(has_error).count()).sum()
    };
    let finest_cost = |line: &Line| compared_rows(line).filter(|row| completed(row)).last().map_or(0.0, cost);
    let rank = |scene: &SceneRecord| {
        let asked = asked_scenes().any(|name| name == scene.name);
        (scene.verdict == Verdict::Passed, asked, scene.lines.iter().map(finest_cost).sum::<f64>())
    };
    let mut best: Option<&SceneRecord> = None;
    for scene in scenes.into_iter().filter(|scene| shown(scene) > 0) {
        if best.is_none_or(|chosen| rank(scene) > rank(chosen)) {
            best = Some(scene);
        }
    }
    best
}

/// The five sentences that open the page, made from the data.
pub fn sentences(report: &Report) -> [String; 5] {
    [
        counted_sentence(report),
        reading_sentence(report),
        cheapest_sentence(report),
        order_sentence(report),
        trouble_sentence(report),
    ]
}

fn counted_sentence(report: &Report) -> String {
    let state = if report.interrupted { ", interrupted before its end" } else { "" };
    let part = report.shard.as_ref().map(|shard| format!(", shard {}", one_line(shard))).unwrap_or_default();
    format!(
        "Of {}, {} (suite {}{part}, {}, {}{state}).",
        counted(report.scenes.len(), "scene"),
        Tally::of(&report.scenes),
        one_line(&report.suite),
        counted(report.environment.cores, "core"),
        duration(report.seconds),
    )
}

fn reading_sentence(report: &Report) -> String {
    let runs: usize = report.scenes.iter().flat_map(|scene| &scene.lines).map(|line| line.rows.len()).sum();
    format!(
        "Each marker in a plot is one of {}, its error against a source outside the code: further left is more exact, \
         further down is faster, so the best method is the lowest line at the error you need.",
        counted(runs, "run")
    )
}

fn cheapest_sentence(report: &Report) -> String {
    let passed = report.scenes.iter().filter(|scene| scene.verdict == Verdict::Passed);
    let Some(scene) = showpiece(passed) else {
        return "No scene passed with an error to show, so no method is called cheapest.".into();
    };
    let measure = &scene.measures[0];
    let found: Vec<String> = targets(scene, measure)
        .iter()
        .map(|&target| match cheapest(scene, measure, target) {
            Some((label, seconds)) => {
                format!(
                    "{} costs least with {} ({})",
                    target_text(target, &measure.unit),
                    one_line(label),
                    duration(seconds)
                )
            }
            None => format!("{} was not reached", target_text(target, &measure.unit)),
        })
        .collect();
    let (title, name) = (one_line(&scene.title), one_line(&measure.name));
    match found.is_empty() {
        true => format!("In “{title}” every run is exact in {name}."),
        false => format!("In “{title}”, an error in {name} of {}.", found.join(", ")),
    }
}

/// The errors worth asking for: 1 %, 0.1 % and 0.01 % where they tell runs apart, else three decades of those seen.
fn targets(scene: &SceneRecord, measure: &Measure) -> Vec<f64> {
    let errors: Vec<f64> = completed_errors(scene, measure).filter(|&error| error > 0.0).collect();
    let (Some(least), Some(most)) =
        (errors.iter().copied().reduce(f64::min), errors.iter().copied().reduce(f64::max))
    else {
        return Vec::new();
    };
    let percents = [1e-2, 1e-3, 1e-4];
    if measure.unit == "1" && percents.iter().any(|&target| least <= target && target <= most) {
        return percents.to_vec();
    }
    let (low, high) = (least.log10().ceil() as i32, most.log10().ceil() as i32);
    let mut decades = vec![high, (low + high).div_euclid(2), low];
    decades.dedup();
    decades.into_iter().map(|decade| 10f64.powi(decade)).collect()
}

fn target_text(target: f64, unit: &str) -> String {
    match unit {
        "1" | "" if target >= 0.99e-4 => format!("{} %", 100.0 * target),
        "1" | "" => format!("{target:e}"),
        unit => format!("{target:e} {}", one_line(unit)),
    }
}

fn completed_errors(scene: &SceneRecord, measure: &Measure) -> impl Iterator<Item = f64> {
    let rows = scene.lines.iter().flat_map(compared_rows).filter(|row| completed(row));
    rows.filter_map(|row| row.errors.get(&measure.name).copied())
}

/// The method that ran with an error of at most `target` in the least time.
fn cheapest<'a>(scene: &'a SceneRecord, measure: &Measure, target: f64) -> Option<(&'a str, f64)> {
    let good =
        |row: &&Row| completed(row) && row.errors.get(&measure.name).is_some_and(|&error| error <= target);
    let costs = scene
        .lines
        .iter()
        .flat_map(|line| compared_rows(line).filter(good).map(|row| (line.label.as_str(), cost(row))));
    costs.min_by(|a, b| a.1.total_cmp(&b.1))
}

fn order_sentence(report: &Report) -> String {
    let mut orders = Vec::new();
    for scene in &report.scenes {
        for line in &scene.lines {
            for observed in &line.orders {
                let expected = observed.expected;
                orders.push((observed.order - expected, observed.order, expected, scene, line));
            }
        }
    }
    let furthest = orders.iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    match furthest {
        None => "No scene has an expected order of convergence.".into(),
        Some((_, observed, expected, scene, line)) => format!(
            "Of {}, the furthest from its theory is {} in “{}”: {observed:.2} where {} is expected.",
            orders_text(orders.len()),
            one_line(&line.label),
            one_line(&scene.title),
            expected,
        ),
    }
}

fn orders_text(count: usize) -> String {
    if count == 1 {
        "1 observed order of convergence".into()
    } else {
        format!("{count} observed orders of convergence")
    }
}

fn trouble_sentence(report: &Report) -> String {
    let rows = report.scenes.iter().flat_map(|scene| &scene.lines).flat_map(|line| &line.rows);
    let stopped = rows.filter(|row| !completed(row)).count();
    let checks = report.scenes.iter().flat_map(|scene| &scene.checks);
    let failed = checks.filter(|check| check.verdict == Verdict::Failed).count();
    let skipped = Tally::of(&report.scenes).skipped;
    match stopped + failed + skipped {
        0 => "Nothing was left out: every run ended and every check held.".into(),
        _ => {
            let parts = [
                (stopped, counted(stopped, "run") + " did not end as meant"),
                (failed, counted(failed, "check") + " did not hold"),
                (skipped, counted(skipped, "scene") + " left out"),
            ];
            let some: Vec<String> = parts.into_iter().filter(|part| part.0 > 0).map(|part| part.1).collect();
            format!("{}: all listed under “Omissions and failures”.", some.join(", "))
        }
    }
}

/// Whether something went wrong or was left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TroubleKind {
    /// A check that did not hold, a run that did not end.
    Failure,
    /// Something that was not judged.
    Omission,
}

/// One thing that went wrong or was left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trouble {
    /// Which of both.
    pub kind: TroubleKind,
    /// The scenes it happened to, one unless it is the same in several.
    pub scenes: Vec<String>,
    /// Which check, runs or scene.
    pub what: String,
    /// The reason, in the words of whoever gave it.
    pub reason: String,
}

/// Everything that failed, stopped or was skipped: failures first, each kind in scene order. Runs of a method that ended in
/// the same way are one entry, and so are omissions that are the same in several scenes.
pub fn troubles(report: &Report) -> Vec<Trouble> {
    let mut found: Vec<Trouble> = Vec::new();
    for trouble in report.scenes.iter().flat_map(scene_troubles) {
        let same = |known: &&mut Trouble| {
            known.kind == TroubleKind::Omission
                && known.what == trouble.what
                && known.reason == trouble.reason
        };
        match found.iter_mut().find(same) {
            Some(known) => known.scenes.extend(trouble.scenes),
            None => found.push(trouble),
        }
    }
    found.sort_by_key(|trouble| trouble.kind);
    found
}

fn scene_troubles(scene: &SceneRecord) -> Vec<Trouble> {
    let trouble = |kind, what: String, reason: &str| Trouble {
        kind,
        scenes: vec![scene.name.clone()],
        what,
        reason: reason.into(),
    };
    let mut found = Vec::new();
    for check in scene.checks.iter().filter(|check| check.verdict == Verdict::Failed) {
        found.push(trouble(TroubleKind::Failure, format!("check failed: {}", check.name), &check.detail));
    }
    for line in &scene.lines {
        for (exit, rows) in stopped_rows(line) {
            let points: Vec<String> = rows.iter().map(|row| significant(row.ladder)).collect();
            let what = format!("{} at {} = {}", line.label, scene.ladder.name, points.join(", "));
            found.push(trouble(TroubleKind::Failure, what, &exit_text(exit)));
        }
    }
    for check in &scene.checks {
        if let Verdict::Skipped { reason } = &check.verdict {
            found.push(trouble(TroubleKind::Omission, format!("check skipped: {}", check.name), reason));
        }
    }
    match &scene.verdict {
        Verdict::Skipped { reason } => {
            found.push(trouble(TroubleKind::Omission, "scene skipped".into(), reason));
        }
        Verdict::Failed if found.iter().all(|trouble| trouble.kind == TroubleKind::Omission) => {
            let reason = "its record names no failed check";
            found.push(trouble(TroubleKind::Failure, "scene failed".into(), reason));
        }
        _ => {}
    }
    found
}

/// The rows of `line` that did not complete, grouped by how they ended.
fn stopped_rows(line: &Line) -> Vec<(&Exit, Vec<&Row>)> {
    let mut groups: Vec<(&Exit, Vec<&Row>)> = Vec::new();
    for row in line.rows.iter().filter(|row| !completed(row)) {
        match groups.iter_mut().find(|(exit, _)| **exit == row.exit) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((&row.exit, vec![row])),
        }
    }
    groups
}
