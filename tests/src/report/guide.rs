//! `docs/VALIDATION.md`: what every scene claims and how to run it. Holds no result, so that it changes only with the scenes.

use super::text::{bracketed, counted, one_line, slug};
use crate::record::{Measure, ReferenceKind, SceneRecord, Target};
use std::collections::BTreeMap;

/// The guide to `scenes`, grouped by crate.
pub fn guide(scenes: &[SceneRecord]) -> String {
    let mut crates: BTreeMap<&str, Vec<&SceneRecord>> = BTreeMap::new();
    for scene in scenes {
        crates.entry(&scene.crate_name).or_default().push(scene);
    }
    let mut out = String::from(HEAD);
    let across = if crates.contains_key(WHOLE) { " and across them" } else { "" };
    let single = crates.keys().filter(|name| **name != WHOLE).count();
    out += &format!("{} in {}{across}.\n", counted(scenes.len(), "scene"), counted(single, "crate"));
    out.push('\n');
    for (name, scenes) in &crates {
        out += &format!("- [{}](#{}): {}\n", markdown(name), slug(name), counted(scenes.len(), "scene"));
    }
    for (name, scenes) in crates {
        out += &format!("\n## {}\n", markdown(name));
        scenes.iter().for_each(|scene| out += &section(scene));
    }
    out
}

/// Where a crate's name stands, of scenes that need several.
const WHOLE: &str = "whole";

const HEAD: &str = "# Validation\n\n\
    <!-- Generated from the scene files. Do not edit: change a scene and generate it again. -->\n\n\
    Every scene states a claim and compares the code with a source outside it.\n\n\
    | command | what runs |\n|---|---|\n\
    | `cargo xtask validate` | the quick suite: the coarse points of the most telling scenes, in two minutes |\n\
    | `cargo xtask validate --suite full` | all points of all scenes with a reference, in less than an hour |\n\
    | `cargo xtask validate --suite stress` | hard cases, without a reference: what must hold whatever happens |\n\
    | `cargo xtask validate --scene NAME` | one scene; `--explain NAME` tells what it is about |\n\n\
    Each ends with a table and `index.html` in the folder it names.\n\n";

fn section(scene: &SceneRecord) -> String {
    let mut out = format!("\n### {}\n\n", markdown(&scene.title));
    out += &format!("`{}`: {}\n\n", code(&scene.name), markdown(&scene.claim));
    if !scene.formula.trim().is_empty() {
        for line in scene.formula.trim().lines() {
            out += &format!("    {}\n", line.trim_end());
        }
        out.push('\n');
    }
    let kind = reference_word(scene.reference.kind);
    out += &format!("- Reference ({kind}): {}\n", markdown(&scene.reference.citation));
    for measure in &scene.measures {
        out += &format!("- Measure: {}\n", measure_text(measure, &scene.ladder.name));
    }
    let ladder = format!("{}{}", scene.ladder.name, bracketed(&scene.ladder.unit));
    out += &format!("- Ladder: {}\n", markdown(&ladder));
    let methods: Vec<String> = scene.lines.iter().map(|line| markdown(&line.label)).collect();
    if !methods.is_empty() {
        out += &format!("- Methods: {}\n", methods.join("; "));
    }
    out + &format!("- Run: `cargo xtask validate --scene {}`\n", code(&scene.name))
}

fn measure_text(measure: &Measure, ladder: &str) -> String {
    let mut out = format!("{}{}", markdown(&measure.name), markdown(&bracketed(&measure.unit)));
    let own = Target { bound: measure.bound, order: measure.order, order_tolerance: measure.order_tolerance };
    out += &target_text(&own, ladder);
    for (method, target) in &measure.methods {
        out += &format!("; {}{}", markdown(method), target_text(target, ladder));
    }
    out
}

fn target_text(target: &Target, ladder: &str) -> String {
    let mut out = String::new();
    if let Some(bound) = target.bound {
        out += &format!(", at most {bound:e} at the finest point");
    }
    if let Some(order) = target.order {
        out += &format!(", expected order {order}");
        if let Some(tolerance) = target.order_tolerance {
            out += &format!(" ± {tolerance}");
        }
        out += &format!(" in {}", markdown(ladder));
    }
    out
}

/// The word for a kind of reference, as scene files spell it.
pub(super) fn reference_word(kind: ReferenceKind) -> &'static str {
    match kind {
        ReferenceKind::Analytic => "analytic",
        ReferenceKind::Manufactured => "manufactured",
        ReferenceKind::Published => "published",
        ReferenceKind::HighPrecision => "high-precision",
        ReferenceKind::Richardson => "richardson",
        ReferenceKind::External => "external",
        ReferenceKind::Invariants => "invariants",
    }
}

/// Text that Markdown shows as it is: one line, its special characters escaped.
pub(super) fn markdown(text: &str) -> String {
    let mut out = String::new();
    for c in one_line(text).chars() {
        if "\\`*_[]<>&#|~$".contains(c) {
            out.push('\\');
        }
        out.push(c);
    }
    out
}

fn code(text: &str) -> String {
    one_line(text).replace('`', "'")
}
