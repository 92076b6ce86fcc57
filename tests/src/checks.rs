//! Checks: what a scene claims against what its rows show.

pub mod order;

use crate::record::{Check, CheckKind, Exit, Line, Measure, ObservedOrder, Row, Target, Verdict};
use crate::scene::validation::{Bounds, Expectation, MeasureSpec, Validation};
use order::Sample;

/// A validation claim and how much of its ladder was run.
#[derive(Clone, Copy, Debug)]
pub struct Claim<'a> {
    /// The claim.
    pub validation: &'a Validation,
    /// The ladder points that were run, from the coarsest.
    pub points: usize,
}

impl Claim<'_> {
    /// The measures as the report shows them: with the bound that applies at the finest point that was run.
    pub fn measures(&self) -> Vec<Measure> {
        let target = |expected: &Expectation| Target {
            bound: self.bound(expected),
            order: expected.order.map(|order| order.value()),
            order_tolerance: expected.order_tolerance.map(|tolerance| tolerance.value()),
        };
        let measure = |spec: &MeasureSpec| {
            let Target { bound, order, order_tolerance } = target(&spec.expectation(""));
            let of = |method: &String| (method.clone(), target(&spec.expectation(method)));
            let methods = spec.methods.keys().map(of).collect();
            let (name, unit) = (spec.name.clone(), spec.unit.clone());
            Measure { name, unit, bound, order, order_tolerance, methods }
        };
        self.validation.measures.iter().map(measure).collect()
    }

    /// The bound at the finest point that was run; bounds are stated for the last point of the ladder and of its
    /// quick part, so a ladder cut elsewhere has none.
    fn bound(&self, expected: &Expectation) -> Option<f64> {
        let ladder = &self.validation.ladder;
        let bound = if self.points == ladder.values.len() {
            expected.bound
        } else if ladder.quick_points.is_some_and(|points| points.value() == self.points) {
            expected.quick_bound
        } else {
            None
        };
        bound.map(|bound| bound.value())
    }

    fn finest(&self) -> f64 {
        self.validation.ladder.values[self.points - 1].value()
    }

    /// Judges the lines and puts the observed orders into them.
    pub fn judge(&self, lines: &mut [Line]) -> Vec<Check> {
        let mut checks = Vec::new();
        for line in lines {
            checks.push(completion(line));
            for spec in &self.validation.measures {
                checks.extend(self.accuracy(line, spec));
                checks.extend(self.order(line, spec));
            }
            for (name, bounds) in &self.validation.invariants {
                checks.push(invariant(line, name, bounds));
            }
            checks.extend(threads(line));
        }
        checks
    }

    fn accuracy(&self, line: &Line, spec: &MeasureSpec) -> Option<Check> {
        let expected = spec.expectation(&line.label);
        expected.bound?;
        let name = format!("{} at the finest point", spec.name);
        let Some(bound) = self.bound(&expected) else {
            let reason =
                format!("the ladder was cut to {} points and the bound is stated for another", self.points);
            return Some(skipped(CheckKind::Accuracy, line, &name, reason));
        };
        let finest = self.finest();
        let at_finest = || line.rows.iter().filter(|row| row.ladder == finest);
        if at_finest().any(|row| row.exit != Exit::Completed) {
            return Some(not_completed(CheckKind::Accuracy, line, &name));
        }
        // A completed row has every measure of its scene.
        let errors = at_finest().map(|row| row.errors.get(&spec.name).copied().unwrap_or(f64::INFINITY));
        let worst = errors.fold(f64::NEG_INFINITY, f64::max);
        let detail = format!("{worst:.3e} {}, allowed {bound:.3e}", unit(&spec.unit));
        let verdict = if worst <= bound { Verdict::Passed } else { Verdict::Failed };
        Some(check(CheckKind::Accuracy, line, &name, verdict, detail.replace(" ,", ",")))
    }

    fn order(&self, line: &mut Line, spec: &MeasureSpec) -> Option<Check> {
        let expectation = spec.expectation(&line.label);
        let (expected, tolerance) = (expectation.order?.value(), expectation.order_tolerance?.value());
        let name = format!("order of {}", spec.name);
        let ladder: Vec<f64> = self.validation.ladder.values.iter().map(|value| value.value()).collect();
        let from = expectation.order_from.map_or(ladder[0], |from| from.value());
        let first = ladder.iter().position(|&value| value == from).unwrap_or(0);
        if self.points < first + 2 {
            let reason =
                format!("the order needs two ladder points from {from} on, and the ladder was cut before");
            return Some(skipped(CheckKind::Order, line, &name, reason));
        }
        let mut samples = samples(line, &spec.name);
        samples.retain(|sample| ladder[first..].contains(&sample.ladder));
        if samples.len() < 2 {
            return Some(not_completed(CheckKind::Order, line, &name));
        }
        let kept = order::above_floor(&samples, expectation.floor.map(|floor| floor.value()), expected);
        let Some(fit) = order::fit(&kept) else {
            let detail = format!(
                "{} of {} points are above the round-off floor; two are needed",
                kept.len(),
                samples.len()
            );
            return Some(check(CheckKind::Order, line, &name, Verdict::Failed, detail));
        };
        line.orders.push(ObservedOrder {
            measure: spec.name.clone(),
            order: fit.order,
            expected,
            half_width: fit.half_width,
            points: fit.points,
        });
        let detail = format!(
            "{:.2} ± {:.2} (95 %, {} of {} points), expected {expected} ± {tolerance}",
            fit.order,
            fit.half_width,
            fit.points,
            samples.len()
        );
        let verdict =
            if (fit.order - expected).abs() <= tolerance { Verdict::Passed } else { Verdict::Failed };
        Some(check(CheckKind::Order, line, &name, verdict, detail))
    }
}

/// The errors along the ladder, at the line's first thread count.
fn samples(line: &Line, measure: &str) -> Vec<Sample> {
    let Some(threads) = line.rows.first().map(|row| row.threads) else { return Vec::new() };
    line.rows
        .iter()
        .filter(|row| row.threads == threads)
        .filter_map(|row| Some(Sample { ladder: row.ladder, error: *row.errors.get(measure)? }))
        .collect()
}

fn completion(line: &Line) -> Check {
    let failed = line.rows.iter().find_map(|row| Some((row, stop_reason(&row.exit)?)));
    let total = line.rows.len();
    let completed = line.rows.iter().filter(|row| row.exit == Exit::Completed).count();
    let detail = match failed {
        None => format!("{total} of {total} rows completed"),
        Some((row, reason)) => {
            format!(
                "{completed} of {total} rows completed; at {} with {} threads: {reason}",
                row.ladder, row.threads
            )
        }
    };
    let verdict = if completed == total { Verdict::Passed } else { Verdict::Failed };
    check(CheckKind::Completion, line, "every row completes", verdict, detail)
}

/// Why a row did not complete.
pub fn stop_reason(exit: &Exit) -> Option<String> {
    match exit {
        Exit::Completed => None,
        Exit::Failed { message } => Some(message.clone()),
        Exit::Crashed { message } => Some(format!("crashed: {message}")),
        Exit::TimedOut { limit_seconds } => {
            Some(format!("still running after its limit of {limit_seconds} s"))
        }
    }
}

fn invariant(line: &Line, name: &str, bounds: &Bounds) -> Check {
    let outside = |value: f64| {
        bounds.min.is_some_and(|min| value < min.value())
            || bounds.max.is_some_and(|max| value > max.value())
            || bounds.above.is_some_and(|above| value <= above.value())
    };
    let completed = || line.rows.iter().filter(|row| row.exit == Exit::Completed);
    let values: Vec<f64> = completed().filter_map(|row| row.invariants.get(name).copied()).collect();
    if completed().next().is_none() {
        return not_completed(CheckKind::Invariant, line, name);
    }
    let allowed = describe(bounds);
    let (verdict, detail) = if values.len() < completed().count() {
        (Verdict::Failed, format!("not reported by every row; must be {allowed}"))
    } else if let Some(wrong) = values.iter().find(|&&value| outside(value)) {
        (Verdict::Failed, format!("{wrong:.6e}; must be {allowed}"))
    } else {
        let (low, high) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        (Verdict::Passed, format!("{low:.3e} to {high:.3e}; must be {allowed}"))
    };
    check(CheckKind::Invariant, line, name, verdict, detail)
}

/// The range in words.
pub fn describe(bounds: &Bounds) -> String {
    let parts = [("≥", bounds.min), ("≤", bounds.max), (">", bounds.above)];
    let parts: Vec<String> = parts
        .iter()
        .filter_map(|(sign, bound)| bound.map(|bound| format!("{sign} {}", bound.value())))
        .collect();
    parts.join(" and ")
}

/// Whether rows that differ only in the number of threads have the same state, errors and counts.
fn threads(line: &Line) -> Option<Check> {
    let first = line.rows.first()?;
    if line.rows.iter().all(|row| row.threads == first.threads) {
        return None;
    }
    let completed = |row: &&Row| row.exit == Exit::Completed;
    let differs = |a: &Row, b: &Row| {
        a.state_hash != b.state_hash
            || a.errors != b.errors
            || a.counts != b.counts
            || a.invariants != b.invariants
    };
    for row in line.rows.iter().filter(completed) {
        let twin = line.rows.iter().filter(completed).find(|twin| twin.ladder == row.ladder);
        if let Some(twin) = twin.filter(|twin| differs(twin, row)) {
            let detail = format!(
                "at {}: state {} with {} threads, {} with {}",
                row.ladder,
                shown(&twin.state_hash),
                twin.threads,
                shown(&row.state_hash),
                row.threads
            );
            return Some(check(
                CheckKind::Threads,
                line,
                "same bits for any number of threads",
                Verdict::Failed,
                detail,
            ));
        }
    }
    let detail = "states, errors, counts and invariants are equal".to_owned();
    Some(check(CheckKind::Threads, line, "same bits for any number of threads", Verdict::Passed, detail))
}

fn shown(hash: &str) -> &str {
    if hash.is_empty() { "without a hash" } else { hash }
}

/// A check that could not be made because rows did not complete; that they did not is a failed check of its own.
fn not_completed(kind: CheckKind, line: &Line, name: &str) -> Check {
    skipped(kind, line, name, "rows it needs did not complete".to_owned())
}

fn skipped(kind: CheckKind, line: &Line, name: &str, reason: String) -> Check {
    check(kind, line, name, Verdict::Skipped { reason: reason.clone() }, reason)
}

/// A unit as it is written behind a number; ratios have none.
fn unit(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

fn check(kind: CheckKind, line: &Line, name: &str, verdict: Verdict, detail: String) -> Check {
    Check { kind, name: format!("{}: {name}", line.label), verdict, detail }
}
