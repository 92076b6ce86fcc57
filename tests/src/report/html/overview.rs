//! The first screens: a card a crate, and the table of all methods of all scenes.

use super::anchor;
use super::pictures::Pictures;
use crate::record::{Line, Report, SceneRecord};
use crate::report::digest::{
    Tally, brief, compared_rows, completed, cost, finest_error, order_text, showpiece, verdict_word,
};
use crate::report::plot::work_precision;
use crate::report::text::{bracketed, duration, escaped, one_line, typeset};
use std::collections::BTreeMap;

/// A card a crate: its verdict, its most telling work–precision plot and a picture.
pub(super) fn crates(report: &Report, pictures: &Pictures) -> String {
    let mut crates: BTreeMap<&str, Vec<&SceneRecord>> = BTreeMap::new();
    for scene in &report.scenes {
        crates.entry(&scene.crate_name).or_default().push(scene);
    }
    if crates.is_empty() {
        return String::new();
    }
    let cards: String = crates.iter().map(|(name, scenes)| card(name, scenes, pictures)).collect();
    format!("<section id=\"crates\"><h2>Crate by crate</h2>\n{cards}</section>\n")
}

fn card(name: &str, scenes: &[&SceneRecord], pictures: &Pictures) -> String {
    let tally = Tally::of(scenes.iter().copied());
    let mut figures = String::new();
    if let Some(scene) = showpiece(scenes.iter().copied())
        && let Some(plot) = work_precision(scene)
    {
        let title = format!("<a href=\"#{}\">{}</a>", anchor(&scene.name), escaped(&one_line(&scene.title)));
        let drawing = plot.inline_svg();
        figures += &format!(
            "<figure class=\"plot\"><div class=\"scroll\">{drawing}</div><figcaption>{title}</figcaption></figure>\n"
        );
    }
    if let Some(picture) = pictures.fullest(scenes.iter().flat_map(|scene| &scene.pictures)) {
        figures += &pictures.figure(picture);
    }
    format!(
        "<article class=\"card\"><h3>{} <span class=\"pill {}\">{}</span></h3>\n<div class=\"pair\">{figures}</div></article>\n",
        escaped(&one_line(name)),
        verdict_word(&tally.verdict()),
        brief(tally),
    )
}

const COLUMNS: [(&str, &str); 8] = [
    ("Verdict", "text"),
    ("Scene", "text"),
    ("Crate", "text"),
    ("Method", "text"),
    ("Points", "number"),
    ("Finest error", "number"),
    ("Order", "number"),
    ("Time at finest", "number"),
];

/// The table of all methods; its columns sort by a press of their heading.
pub(super) fn scenes_table(report: &Report) -> String {
    let heads: String = COLUMNS
        .iter()
        .map(|(name, kind)| {
            format!("<th scope=\"col\" class=\"{kind}\" aria-sort=\"none\"><button type=\"button\">{name}</button></th>")
        })
        .collect();
    let rows: String = report.scenes.iter().flat_map(scene_rows).collect();
    format!(
        "<section id=\"scenes\"><h2>All scenes and methods</h2>\n\
         <p class=\"quiet\">Press a heading to sort. Finest error: the first measure at the last completed point of the ladder; \
         time is that of the same run.</p>\n\
         <div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"All scenes and methods\">\
         <table class=\"sortable\"><thead><tr>{heads}</tr></thead><tbody>\n{rows}</tbody></table></div></section>\n"
    )
}

fn scene_rows(scene: &SceneRecord) -> Vec<String> {
    let word = verdict_word(&scene.verdict);
    // Failures first when sorted by verdict.
    let rank = ["failed", "skipped", "passed"].iter().position(|known| *known == word).unwrap_or(3);
    let lead = format!(
        "<td data-sort=\"{rank}\"><span class=\"pill {word}\">{word}</span></td>\
         <td><a href=\"#{}\">{}</a></td><td>{}</td>",
        anchor(&scene.name),
        escaped(&one_line(&scene.title)),
        escaped(&one_line(&scene.crate_name)),
    );
    if scene.lines.is_empty() {
        return vec![format!("<tr>{lead}<td>–</td>{}</tr>\n", number_cell(None, String::new()).repeat(4))];
    }
    scene.lines.iter().map(|line| format!("<tr>{lead}{}</tr>\n", line_cells(scene, line))).collect()
}

fn line_cells(scene: &SceneRecord, line: &Line) -> String {
    let done = line.rows.iter().filter(|row| completed(row)).count();
    let error = finest_error(scene, line);
    let unit = scene.measures.first().map(|measure| bracketed(&measure.unit)).unwrap_or_default();
    let order = line.orders.first().map(|order| order.order);
    let expected = line.orders.first().map(|order| order.expected);
    let order_words = match expected {
        Some(expected) if order.is_some() => format!("{} (theory {expected})", order_text(line)),
        _ => order_text(line),
    };
    let time = compared_rows(line).filter(|row| completed(row)).last().map(cost);
    format!(
        "<td>{}</td>{}{}{}{}",
        escaped(&one_line(&line.label)),
        number_cell(Some(done as f64), format!("{done}/{}", line.rows.len())),
        number_cell(error, error.map(|error| typeset(error) + &unit).unwrap_or_default()),
        number_cell(order, order_words),
        number_cell(time, time.map(duration).unwrap_or_default()),
    )
}

/// A cell that sorts by `value`; one without a value sorts last.
fn number_cell(value: Option<f64>, words: String) -> String {
    let sort = value.map(|value| format!(" data-sort=\"{value:e}\"")).unwrap_or(" data-sort=\"\"".into());
    let words = if words.is_empty() { "–".into() } else { escaped(&words) };
    format!("<td class=\"number\"{sort}>{words}</td>")
}
