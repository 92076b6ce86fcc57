//! The section of one scene: claim, truth, checks, plots, pictures and every run.

use super::pictures::Pictures;
use super::{anchor, plot_anchor};
use crate::record::{Check, Line, Row, SceneRecord, Target, Verdict};
use crate::report::digest::{completed, exit_text, verdict_word};
use crate::report::guide::reference_word;
use crate::report::plot::{Plot, convergence, work_precision};
use crate::report::text::{bracketed, bytes, cut, duration, escaped, one_line, shortest, typeset};
use std::collections::BTreeSet;

/// The section; open from the start when the scene did not pass.
pub(super) fn section(scene: &SceneRecord, pictures: &Pictures) -> String {
    let word = verdict_word(&scene.verdict);
    let open = if scene.verdict == Verdict::Failed { " open" } else { "" };
    let mut out = format!(
        "<details class=\"scene\" id=\"{}\"{open}><summary><span class=\"pill {word}\">{word}</span> \
         <span class=\"title\">{}</span> <code>{}</code></summary>\n<div class=\"body\">\n",
        anchor(&scene.name),
        escaped(&one_line(&scene.title)),
        escaped(&one_line(&scene.name)),
    );
    if let Verdict::Skipped { reason } = &scene.verdict {
        out += &format!("<p class=\"reason\">Skipped: {}</p>\n", escaped(reason));
    }
    out += &truth(scene);
    out += &plots(scene);
    if !scene.pictures.is_empty() {
        let figures: String = scene.pictures.iter().map(|picture| pictures.figure(picture)).collect();
        out += &format!("<div class=\"pair\">{figures}</div>\n");
    }
    out += &checks(scene);
    out += &runs(scene);
    if !scene.log.is_empty() {
        out += &format!("<p class=\"quiet\">Log: <code>{}</code></p>\n", escaped(&scene.log));
    }
    out + "<p class=\"quiet\"><a href=\"#scenes\">Back to all scenes</a></p>\n</div></details>\n"
}

fn truth(scene: &SceneRecord) -> String {
    let mut out = format!("<p class=\"claim\">{}</p>\n", escaped(&scene.claim));
    if !scene.formula.trim().is_empty() {
        out += &format!("<pre class=\"formula\">{}</pre>\n", escaped(scene.formula.trim()));
    }
    let measures: Vec<String> = scene
        .measures
        .iter()
        .map(|measure| {
            let own = Target {
                bound: measure.bound,
                order: measure.order,
                order_tolerance: measure.order_tolerance,
            };
            let of_method =
                |(method, target): (&String, &Target)| format!(" ({method}{})", target_words(target));
            let methods: String = measure.methods.iter().map(of_method).collect();
            let unit = bracketed(&measure.unit);
            format!("{}{unit}{}{methods}", one_line(&measure.name), target_words(&own))
        })
        .collect();
    let ladder = format!("{}{}", one_line(&scene.ladder.name), bracketed(&scene.ladder.unit));
    let kind = reference_word(scene.reference.kind);
    out += &format!("<dl>\n<dt>Reference</dt><dd>{kind}: {}</dd>\n", escaped(&scene.reference.citation));
    if !measures.is_empty() {
        out += &format!("<dt>Measured</dt><dd>{}</dd>\n", escaped(&measures.join("; ")));
    }
    out + &format!("<dt>Ladder</dt><dd>{}</dd>\n</dl>\n", escaped(&ladder))
}

fn target_words(target: &Target) -> String {
    let bound = target.bound.map(|bound| format!(", at most {}", shortest(bound))).unwrap_or_default();
    let order = target.order.map(|order| format!(", expected order {order}")).unwrap_or_default();
    let band = target.order_tolerance.filter(|_| target.order.is_some());
    let band = band.map(|band| format!(" ± {band}")).unwrap_or_default();
    format!("{bound}{order}{band}")
}

fn plots(scene: &SceneRecord) -> String {
    let convergences = scene.measures.iter().filter_map(|measure| convergence(scene, measure));
    let work =
        work_precision(scene).map(|plot| figure(&plot, &format!(" id=\"{}\"", plot_anchor(&scene.name))));
    let drawn: String = work.into_iter().chain(convergences.map(|plot| figure(&plot, ""))).collect();
    if drawn.is_empty() { drawn } else { format!("<div class=\"pair\">{drawn}</div>\n") }
}

fn figure(plot: &Plot, id: &str) -> String {
    format!("<figure class=\"plot\"{id}><div class=\"scroll\">{}</div></figure>\n", plot.inline_svg())
}

fn checks(scene: &SceneRecord) -> String {
    if scene.checks.is_empty() {
        return String::new();
    }
    let item = |check: &Check| {
        let word = verdict_word(&check.verdict);
        let reason = match &check.verdict {
            Verdict::Skipped { reason } => format!(" Skipped: {}", escaped(reason)),
            _ => String::new(),
        };
        format!(
            "<li><span class=\"pill {word}\">{word}</span> <b>{}</b> {}{reason}</li>\n",
            escaped(&one_line(&check.name)),
            escaped(&check.detail)
        )
    };
    let items: String = scene.checks.iter().map(item).collect();
    format!("<h4>Checks</h4>\n<ul class=\"checks\">\n{items}</ul>\n")
}

/// The table of every run, one column a name that occurs.
fn runs(scene: &SceneRecord) -> String {
    let rows = || scene.lines.iter().flat_map(|line| line.rows.iter().map(move |row| (line, row)));
    if rows().next().is_none() {
        return String::new();
    }
    let columns = Columns::of(scene);
    let heads = columns.heads(&(one_line(&scene.ladder.name) + &bracketed(&scene.ladder.unit)));
    let heads: String = heads
        .iter()
        .map(|(name, kind)| {
            let name = escaped(name);
            format!("<th scope=\"col\" class=\"{kind}\" aria-sort=\"none\"><button type=\"button\">{name}</button></th>")
        })
        .collect();
    let body: String = rows().map(|(line, row)| run(line, row, &columns)).collect();
    format!(
        "<h4>Runs</h4>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Runs\">\
         <table class=\"sortable dense\"><thead><tr>{heads}</tr></thead><tbody>\n{body}</tbody></table></div>\n"
    )
}

struct Columns<'a> {
    errors: BTreeSet<&'a str>,
    counts: BTreeSet<&'a str>,
    invariants: BTreeSet<&'a str>,
    has_terms: bool,
}

impl<'a> Columns<'a> {
    fn of(scene: &'a SceneRecord) -> Self {
        let rows = || scene.lines.iter().flat_map(|line| &line.rows);
        Self {
            errors: rows().flat_map(|row| row.errors.keys()).map(String::as_str).collect(),
            counts: rows().flat_map(|row| row.counts.keys()).map(String::as_str).collect(),
            invariants: rows().flat_map(|row| row.invariants.keys()).map(String::as_str).collect(),
            has_terms: rows().any(|row| !row.terms.is_empty()),
        }
    }

    /// Names and kinds of all columns.
    fn heads(&self, ladder: &str) -> Vec<(String, &'static str)> {
        let numbers = |names: &BTreeSet<&str>, before: &'static str| {
            names.iter().map(move |name| format!("{before}{}", one_line(name))).collect::<Vec<_>>()
        };
        let mut heads = vec![("Method".to_string(), "text")];
        let mut add = |names: Vec<String>| heads.extend(names.into_iter().map(|name| (name, "number")));
        add(vec![ladder.into(), "Threads".into()]);
        add(numbers(&self.errors, "Error: "));
        add(vec!["Time".into()]);
        add(numbers(&self.counts, ""));
        add(numbers(&self.invariants, ""));
        add(self.has_terms.then(|| "Terms".to_string()).into_iter().collect());
        add(vec!["Memory".into()]);
        heads.extend([("State".into(), "text"), ("Ended".into(), "text")]);
        heads
    }
}

fn run(line: &Line, row: &Row, columns: &Columns<'_>) -> String {
    let class = if completed(row) { "" } else { " class=\"failed\"" };
    let mut out = format!("<tr{class}><td>{}</td>", escaped(&one_line(&line.label)));
    out += &cell(Some(row.ladder), typeset(row.ladder));
    out += &cell(Some(row.threads as f64), row.threads.to_string());
    for name in &columns.errors {
        let value = row.errors.get(*name).copied();
        out += &cell(value, value.map(typeset).unwrap_or_default());
    }
    let spread =
        if row.repeats > 1 { format!(" ± {}", duration(row.seconds_spread / 2.0)) } else { String::new() };
    out += &cell(Some(row.seconds), duration(row.seconds) + &spread);
    for name in &columns.counts {
        let value = row.counts.get(*name);
        out += &cell(value.map(|count| *count as f64), value.map(u64::to_string).unwrap_or_default());
    }
    for name in &columns.invariants {
        let value = row.invariants.get(*name).copied();
        out += &cell(value, value.map(typeset).unwrap_or_default());
    }
    if columns.has_terms {
        let terms: Vec<String> = row
            .terms
            .iter()
            .map(|term| format!("{} {}", one_line(&term.name), duration(term.seconds)))
            .collect();
        out += &cell(Some(row.terms.iter().map(|term| term.seconds).sum()), terms.join(", "));
    }
    out += &cell(Some(row.peak_memory_bytes as f64), bytes(row.peak_memory_bytes));
    let hash = one_line(&row.state_hash);
    out += &format!("<td title=\"{}\"><code>{}</code></td>", escaped(&hash), escaped(&cut(&hash, 9)));
    out + &format!("<td>{}</td></tr>\n", escaped(&exit_text(&row.exit)))
}

fn cell(value: Option<f64>, words: String) -> String {
    let sort = value.map(|value| format!("{value:e}")).unwrap_or_default();
    let words = if words.is_empty() { "–".into() } else { escaped(&words) };
    format!("<td class=\"number\" data-sort=\"{sort}\">{words}</td>")
}
