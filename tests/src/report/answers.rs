//! What accuracy costs: the choices that a user has, answered from the rows of this very report.
//!
//! Each choice has scenes whose methods are its alternatives; the first of them that passed is taken. In it the error that is asked for is the smallest of
//! 1, 2, 5 · 10ⁿ that more than half of its methods reach (two at least), so that neither the roughest method nor the finest ladder decides alone. The cheapest run with
//! at most that error wins; what it is compared with are the cheapest such runs of the other methods. A scene that failed, or did not run, answers nothing.

use super::digest::{compared_rows, completed, cost, cost_name};
use super::text::{duration, one_line, significant, superscript, typeset};
use crate::record::{Line, Measure, Row, SceneRecord, Verdict};

/// A choice that a user has.
struct Choice {
    /// The question.
    question: &'static str,
    /// What answers it: one clause each.
    parts: &'static [Part],
}

/// Scenes whose methods are the alternatives, the most telling first.
struct Part {
    scenes: &'static [&'static str],
    /// What the winner is told to use besides time: a count, by another one.
    uses: Option<Uses>,
}

/// A count by another, in words.
struct Uses {
    count: &'static str,
    by: &'static str,
    words: &'static str,
}

const fn part(scenes: &'static [&'static str]) -> Part {
    Part { scenes, uses: None }
}

const CHOICES: [Choice; 5] = [
    Choice {
        question: "Which integrator?",
        parts: &[
            part(&["lagrangian/double-pendulum-regular", "lagrangian/pendulum-large"]),
            part(&["lagrangian/motion-manufactured", "lagrangian/bar-standing-wave"]),
        ],
    },
    Choice {
        question: "Which element?",
        parts: &[part(&["lagrangian/cantilever-tet", "mpm-core/cantilever-fem-mpm"])],
    },
    Choice {
        question: "Which particles: kernel, transfer, precision?",
        parts: &[part(&["mpm-core/work-precision", "mpm-core/vortex", "mpm-core/axis-aligned"])],
    },
    Choice {
        question: "Which collision detection, which projection?",
        parts: &[part(&["ipc-contact/ccd-methods"]), part(&["ipc-contact/projection"])],
    },
    Choice {
        question: "How many samples per splat?",
        parts: &[Part {
            scenes: &["gaussian-deform/samples"],
            uses: Some(Uses { count: "samples", by: "splats", words: "samples a splat" }),
        }],
    },
];

/// The names of all scenes that choices name.
pub fn asked_scenes() -> impl Iterator<Item = &'static str> {
    CHOICES.iter().flat_map(|choice| choice.parts).flat_map(|part| part.scenes).copied()
}

/// The answer to one choice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The question.
    pub question: &'static str,
    /// One clause a scene.
    pub clauses: Vec<Clause>,
}

/// What one scene says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Clause {
    /// The scene.
    pub scene: String,
    /// Its title.
    pub title: String,
    /// The rest of the sentence, which follows the title.
    pub words: String,
}

/// The answers that these scenes give, in the order of the choices.
pub fn answers(scenes: &[SceneRecord]) -> Vec<Answer> {
    let clause = |part: &Part| {
        let passed = |name: &&str| {
            scenes.iter().find(|scene| scene.name == **name && scene.verdict == Verdict::Passed)
        };
        part.scenes.iter().filter_map(passed).find_map(|scene| clause(scene, part))
    };
    let answer = |choice: &Choice| Answer {
        question: choice.question,
        clauses: choice.parts.iter().filter_map(clause).collect(),
    };
    CHOICES.iter().map(answer).filter(|answer| !answer.clauses.is_empty()).collect()
}

/// A method's part in the comparison.
struct Contender<'a> {
    label: &'a str,
    /// The smallest error of a completed run.
    best: f64,
    /// The cheapest run that is exact enough.
    run: Option<&'a Row>,
}

fn clause(scene: &SceneRecord, part: &Part) -> Option<Clause> {
    let measure = scene.measures.first()?;
    let (target, contenders) = contest(scene, measure)?;
    let mut reached: Vec<(&str, &Row)> =
        contenders.iter().filter_map(|method| Some((method.label, method.run?))).collect();
    reached.sort_by(|a, b| cost(a.1).total_cmp(&cost(b.1)));
    let [(winner, run), (next, next_run), ..] = reached[..] else { return None };
    let (last, last_run) = reached[reached.len() - 1];
    let span = match cost_name(scene) {
        "wall time" => "",
        _ => " a simulated second",
    };
    let mut words = format!(
        "an error of {} in {}, which {} of {} methods reach, costs least with {}: {}{span}",
        amount(target, &measure.unit),
        one_line(&measure.name),
        reached.len(),
        contenders.len(),
        one_line(winner),
        duration(cost(run)),
    );
    if let Some(used) = part.uses.as_ref().and_then(|uses| used(run, uses)) {
        words += &format!(" and {used}");
    }
    let times = |other: &Row| significant(cost(other) / cost(run));
    words += &format!("; the next, {}, takes {} times that", one_line(next), times(next_run));
    if reached.len() > 2 {
        words += &format!(", the last, {}, {} times", one_line(last), times(last_run));
    }
    words += &beyond(&contenders, &measure.unit);
    let (name, title) = (scene.name.clone(), one_line(&scene.title));
    Some(Clause { scene: name, title, words })
}

/// The error to ask for, and the methods with the cheapest of their runs that are exact enough; `None` where there are not two to compare.
fn contest<'a>(scene: &'a SceneRecord, measure: &Measure) -> Option<(f64, Vec<Contender<'a>>)> {
    let runs = |line: &'a Line| {
        let errors = |row: &'a Row| Some((row, *row.errors.get(&measure.name)?));
        compared_rows(line).filter(|row| completed(row) && cost(row) > 0.0).filter_map(errors)
    };
    let best = |line: &'a Line| runs(line).map(|(_, error)| error).reduce(f64::min);
    let mut contenders: Vec<(Contender<'a>, &'a Line)> = scene
        .lines
        .iter()
        .filter_map(|line| Some((Contender { label: &line.label, best: best(line)?, run: None }, line)))
        .collect();
    let mut bests: Vec<f64> = contenders.iter().map(|(method, _)| method.best).collect();
    bests.sort_by(f64::total_cmp);
    let target = round_above(*bests.get((bests.len() / 2).max(1))?)?;
    for (method, line) in &mut contenders {
        let exact = runs(line).filter(|(_, error)| *error <= target);
        method.run = exact.map(|(row, _)| row).min_by(|a, b| cost(a).total_cmp(&cost(b)));
    }
    Some((target, contenders.into_iter().map(|(method, _)| method).collect()))
}

/// The smallest of 1, 2, 5 · 10ⁿ that is not below `error`; `None` for zero and what is not finite.
fn round_above(error: f64) -> Option<f64> {
    if !(error > 0.0 && error.is_finite()) {
        return None;
    }
    let decade = error.log10().floor() as i32;
    // From text, so that it is the number that a reader would write.
    let steps = (decade - 1..=decade + 1).flat_map(|n| [1, 2, 5].map(|digit| format!("{digit}e{n}")));
    steps.filter_map(|text| text.parse().ok()).find(|&round: &f64| round >= error)
}

fn amount(error: f64, unit: &str) -> String {
    with_unit(error, unit, rounded)
}

fn with_unit(error: f64, unit: &str, written: fn(f64) -> String) -> String {
    match unit {
        "1" | "" if error >= 0.99e-3 => format!("{} %", written(100.0 * error)),
        "1" | "" => written(error),
        unit => format!("{} {}", written(error), one_line(unit)),
    }
}

/// Two digits at most, a power of ten typeset.
fn rounded(x: f64) -> String {
    let scientific = format!("{x:.1e}");
    let value: f64 = scientific.parse().unwrap_or(x);
    match scientific.split_once('e') {
        Some((digits, exponent)) if !(1e-3..1e4).contains(&value) => {
            format!("{}·10{}", digits.trim_end_matches(".0"), superscript(exponent))
        }
        _ => format!("{value}"),
    }
}

fn used(run: &Row, uses: &Uses) -> Option<String> {
    let [count, by] = [uses.count, uses.by].map(|name| run.counts.get(name).map(|count| *count as f64));
    Some(format!("{} {}", rounded(count? / by?), uses.words))
}

/// How far those come that do not reach the error.
fn beyond(contenders: &[Contender<'_>], unit: &str) -> String {
    let short: Vec<&Contender<'_>> = contenders.iter().filter(|method| method.run.is_none()).collect();
    if short.is_empty() || short.len() > 2 {
        return String::new();
    }
    let each = |method: &&Contender<'_>| {
        format!("{} stops at {}", one_line(method.label), with_unit(method.best, unit, typeset))
    };
    format!(" ({})", short.iter().map(each).collect::<Vec<_>>().join(", "))
}
