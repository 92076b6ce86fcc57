//! `index.html`: the whole report in one file that needs nothing else, not even a network.
//!
//! Verdict first, then five sentences, what accuracy costs, what failed, a picture and a plot a crate, a table that sorts, and one section a
//! scene. Everything that comes from a scene is escaped; scripts and styles are the two files beside this module.

mod overview;
mod pictures;
mod scene;

use super::answers::{Answer, Clause, answers};
use super::digest::{Tally, Trouble, TroubleKind, sentences, troubles};
use super::text::{bytes, duration, escaped, one_line, slug};
use crate::record::{Report, Verdict};
use pictures::Pictures;
use std::path::Path;

const STYLE: &str = include_str!("html/page.css");
const SCRIPT: &str = include_str!("html/page.js");

/// The page of `report`. Pictures are read from `folder`, to which their paths are relative, and embedded; one that is
/// missing is named in its place.
pub fn page(report: &Report, folder: &Path) -> String {
    let pictures = Pictures::of(folder);
    let mut out = head(report);
    out += &verdict(report);
    out += &summary(report);
    out += &accuracy(report);
    out += &omissions(report);
    out += &overview::crates(report, &pictures);
    out += &overview::scenes_table(report);
    out += "<section id=\"details\"><h2>Scene by scene</h2>\n";
    report.scenes.iter().for_each(|scene| out += &scene::section(scene, &pictures));
    out += "</section>\n";
    out += &environment(report);
    out + &format!("</main>\n<script>{SCRIPT}</script>\n</body>\n</html>\n")
}

/// Where a scene's section is on the page.
pub(crate) fn anchor(name: &str) -> String {
    format!("scene-{}", slug(name))
}

/// Where a scene's work–precision plot is on the page, inside its section.
fn plot_anchor(name: &str) -> String {
    format!("plot-{}", slug(name))
}

fn head(report: &Report) -> String {
    // A page without an icon of its own makes a browser ask for one; this one is empty.
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>Validation: {}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n",
        escaped(&Tally::of(&report.scenes).to_string())
    )
}

fn verdict(report: &Report) -> String {
    let tally = Tally::of(&report.scenes);
    let (class, words) = match tally.verdict() {
        Verdict::Failed if tally.failed == 1 => ("failed", "One scene failed".to_string()),
        Verdict::Failed => ("failed", format!("{} scenes failed", tally.failed)),
        Verdict::Passed if report.interrupted => ("skipped", "Interrupted: passed so far".to_string()),
        Verdict::Passed if tally.skipped > 0 => ("passed", "Everything that ran passed".to_string()),
        Verdict::Passed => ("passed", "Every scene passed".to_string()),
        Verdict::Skipped { .. } => ("skipped", "Nothing was judged".to_string()),
    };
    let tiles: String = [("passed", tally.passed), ("failed", tally.failed), ("skipped", tally.skipped)]
        .iter()
        .map(|(name, count)| {
            let quiet = if *count == 0 { "none" } else { name };
            format!("<li class=\"{quiet}\"><b>{count}</b> {name}</li>")
        })
        .collect();
    format!(
        "<header class=\"verdict {class}\">\n<p class=\"over\">Validation: speed against error</p>\n\
         <h1>{words}</h1>\n<ul class=\"tally\">{tiles}</ul>\n</header>\n"
    )
}

fn summary(report: &Report) -> String {
    let items: String =
        sentences(report).iter().map(|sentence| format!("<li>{}</li>\n", escaped(sentence))).collect();
    format!("<section id=\"summary\"><h2>What the figures show</h2>\n<ul>\n{items}</ul></section>\n")
}

/// The answers to what a user has to choose; nothing where no scene answers.
fn accuracy(report: &Report) -> String {
    let clause = |clause: &Clause| {
        let (link, title) = (plot_anchor(&clause.scene), escaped(&clause.title));
        format!("“<a href=\"#{link}\">{title}</a>”, {}", escaped(&clause.words))
    };
    let item = |answer: &Answer| {
        let clauses: Vec<String> = answer.clauses.iter().map(clause).collect();
        format!("<li><b>{}</b> In {}.</li>\n", escaped(answer.question), clauses.join("; in "))
    };
    let items: String = answers(&report.scenes).iter().map(item).collect();
    if items.is_empty() {
        return items;
    }
    format!("<section id=\"accuracy\"><h2>What accuracy costs</h2>\n<ul>\n{items}</ul></section>\n")
}

fn omissions(report: &Report) -> String {
    let found = troubles(report);
    if found.is_empty() {
        return String::new();
    }
    let items: String = found.iter().map(trouble_item).collect();
    format!("<section id=\"omissions\"><h2>Omissions and failures</h2>\n<ul>\n{items}</ul></section>\n")
}

fn trouble_item(trouble: &Trouble) -> String {
    let class = match trouble.kind {
        TroubleKind::Failure => "failed",
        TroubleKind::Omission => "skipped",
    };
    let link = |name: &String| format!("<a href=\"#{}\">{}</a>", anchor(name), escaped(&one_line(name)));
    let links: Vec<String> = trouble.scenes.iter().map(link).collect();
    let (links, what, reason) =
        (links.join(", "), escaped(&one_line(&trouble.what)), escaped(&trouble.reason));
    format!("<li class=\"{class}\">{links} <span>{what}</span><p>{reason}</p></li>\n")
}

fn environment(report: &Report) -> String {
    let machine = &report.environment;
    let or_unknown = |text: &str| if text.is_empty() { "unknown".to_string() } else { one_line(text) };
    let commit =
        if machine.commit.is_empty() { "outside a checkout".into() } else { one_line(&machine.commit) };
    let rows = [
        ("Command", one_line(&report.command.join(" "))),
        ("Started", format!("{} s after 1970-01-01 UTC", report.started_unix_seconds)),
        ("Took", duration(report.seconds)),
        (
            "Processor",
            format!(
                "{}, {} offered",
                or_unknown(&machine.processor),
                super::text::counted(machine.cores, "core")
            ),
        ),
        ("Features", or_unknown(&machine.processor_features.join(" "))),
        ("Memory", bytes(machine.memory_bytes)),
        ("System", or_unknown(&machine.system)),
        ("Compiler", format!("{}, profile {}", or_unknown(&machine.compiler), or_unknown(&machine.profile))),
        ("Commit", commit),
        ("Fingerprint", or_unknown(&machine.fingerprint)),
    ];
    let items: String =
        rows.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>\n", escaped(value))).collect();
    format!(
        "<section id=\"environment\"><h2>Where it ran</h2>\n<dl>\n{items}</dl>\n\
         <p class=\"quiet\">The same data: report.json, rows.csv, junit.xml, env.json and plots/ beside this file.</p></section>\n"
    )
}
