//! Rules over the text of source files.

use super::Finding;
use super::policy::{EMPTY_NAMES, FILE_LINES, FILE_MODULES, Place, WALLS, Wall};
use super::source::{line_of, words};
use super::workspace::{File, Workspace};
use std::collections::BTreeMap;

/// A finding for every word of the solver crates' code that `forbidden` gives a reason against.
fn forbidden_words(workspace: &Workspace, forbidden: impl Fn(&File, &str) -> Option<String>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (file, code) in workspace.solver_code() {
        for (position, word) in words(&code) {
            if let Some(message) = forbidden(file, word) {
                findings.push(Finding::error(&file.path, line_of(&code, position), message));
            }
        }
    }
    findings
}

/// A walled dependency is named in one file, so that it can be replaced there.
pub(super) fn walls(workspace: &Workspace) -> Vec<Finding> {
    WALLS.iter().flat_map(|wall| wall_breaches(workspace, wall)).collect()
}

fn wall_breaches(workspace: &Workspace, wall: &Wall) -> Vec<Finding> {
    // The first mention in each file, by crate.
    let mut mentions: BTreeMap<&str, Vec<(&File, usize)>> = BTreeMap::new();
    for (file, source) in workspace.sources().filter(|(file, _)| file.is_solver_source()) {
        let mention = words(&source.code).find(|(position, word)| {
            word.starts_with(wall.prefix) && !continues_path(&source.code[..*position])
        });
        if let (Some((position, _)), Some(folder)) = (mention, file.crate_folder()) {
            mentions.entry(folder).or_default().push((file, line_of(&source.code, position)));
        }
    }
    let mut findings = Vec::new();
    for files in mentions.values() {
        let allowed = |file: &File| match wall.place {
            Place::OneFileUnder(place) => file.path.starts_with(place),
            Place::OneFilePerCrate => true,
        };
        let door = files.iter().find(|(file, _)| allowed(file)).map(|(file, _)| file.path.as_str());
        for (file, line) in files.iter().filter(|(file, _)| Some(file.path.as_str()) != door) {
            let message = match (door, &wall.place) {
                (Some(door), _) => format!("`{}` is named in {door} already, and only there", wall.prefix),
                (None, Place::OneFileUnder(place)) => {
                    format!("`{}` may be named in {place} only", wall.prefix)
                }
                (None, Place::OneFilePerCrate) => continue,
            };
            findings.push(Finding::error(&file.path, *line, message));
        }
    }
    findings
}

/// Whether the code `before` a word makes it a later part of a path: `Par::rayon` names no crate, `::rayon` does.
fn continues_path(before: &str) -> bool {
    before
        .strip_suffix("::")
        .is_some_and(|path| path.ends_with(|last: char| last.is_alphanumeric() || "_>".contains(last)))
}

/// A long file hides its structure.
pub(super) fn file_length(workspace: &Workspace) -> Vec<Finding> {
    let (limit, second_look) = FILE_LINES;
    workspace
        .sources()
        .filter_map(|(file, _)| {
            let lines = file.text.lines().count();
            let message = format!("{lines} lines, the limit is {limit}");
            match lines {
                _ if lines > limit => Some(Finding::error(&file.path, lines, message)),
                _ if lines > second_look => Some(Finding::warning(&file.path, lines, message)),
                _ => None,
            }
        })
        .collect()
}

/// rustc checks that public items are documented, unless it is told not to.
pub(super) fn documented(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (file, source) in workspace.sources().filter(|(file, _)| file.path.contains("/src/")) {
        for (position, _) in words(&source.code).filter(|(_, word)| *word == "missing_docs") {
            let message = "every public item is documented: no module lifts the lint `missing_docs`";
            findings.push(Finding::error(&file.path, line_of(&source.code, position), message));
        }
    }
    findings
}

/// A note to do something later is an issue, or it is forgotten.
pub(super) fn to_do(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (file, source) in workspace.sources() {
        for (position, word) in words(&source.comments) {
            let marked = matches!(word, "TODO" | "FIXME" | "XXX" | "HACK");
            if marked && !names_issue(&source.comments[position + word.len()..]) {
                let message = format!("{word} without an issue: write `{word}(#12)`, or do it now");
                findings.push(Finding::error(&file.path, line_of(&source.comments, position), message));
            }
        }
    }
    findings
}

fn names_issue(rest: &str) -> bool {
    rest.strip_prefix("(#").is_some_and(|number| number.starts_with(|first: char| first.is_ascii_digit()))
}

/// A solver crate reports through its return values: a caller may have no terminal, or another use for it.
pub(super) fn printing(workspace: &Workspace) -> Vec<Finding> {
    const MACROS: &[&str] = &["print", "println", "eprint", "eprintln", "dbg"];
    let mut findings = Vec::new();
    for (file, code) in workspace.solver_code() {
        for (position, word) in words(&code) {
            let called = code[position + word.len()..].starts_with('!');
            if called && MACROS.contains(&word) {
                let message = format!("a solver crate never prints ({word}!): return it in a report");
                findings.push(Finding::error(&file.path, line_of(&code, position), message));
            }
        }
    }
    findings
}

/// A solver crate touches no files, but in the modules whose business that is.
pub(super) fn files(workspace: &Workspace) -> Vec<Finding> {
    forbidden_words(workspace, |file, word| {
        let touches = matches!(word, "fs" | "File" | "OpenOptions");
        let allowed = FILE_MODULES.iter().any(|module| file.path.starts_with(module));
        (touches && !allowed)
            .then(|| format!("`{word}`: files are read and written in {} only", FILE_MODULES.join(", ")))
    })
}

/// The order of a hash map changes from run to run, and sums in that order with it.
pub(super) fn hash_maps(workspace: &Workspace) -> Vec<Finding> {
    forbidden_words(workspace, |_, word| {
        let hashed = matches!(word, "HashMap" | "HashSet" | "hash_map" | "hash_set");
        hashed.then(|| format!("{word}: its order differs from run to run; sort, or use a BTree collection"))
    })
}

/// What threads tell each other through atomics depends on their timing.
pub(super) fn atomics(workspace: &Workspace) -> Vec<Finding> {
    forbidden_words(workspace, |_, word| {
        let atomic = word.strip_prefix("Atomic").is_some_and(|kind| kind.starts_with(char::is_uppercase));
        atomic.then(|| {
            format!("{word}: results may not depend on the timing of threads; map, then reduce in order")
        })
    })
}

/// Unsafe code stands in the few modules whose measured kernels need it.
pub(super) fn unsafe_blocks(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (file, source) in workspace.sources() {
        let places: Vec<usize> = words(&source.code)
            .filter(|(_, word)| matches!(*word, "unsafe" | "unsafe_code"))
            .map(|(position, _)| line_of(&source.code, position))
            .collect();
        if let Some(first) = places.first() {
            let message = format!(
                "unsafe code ({} mentions): only a measured kernel may, and stands on the list of exceptions with its \
                 reason",
                places.len()
            );
            findings.push(Finding::error(&file.path, *first, message));
        }
    }
    findings
}

/// A test that does not run protects nothing.
pub(super) fn ignored_tests(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (file, source) in workspace.sources() {
        for (position, _) in source.code.match_indices("#[ignore") {
            let message = "no test is ignored: one that lacks something prints SKIPPED and the reason";
            findings.push(Finding::error(&file.path, line_of(&source.code, position), message));
        }
    }
    findings
}

/// A module is named after what it holds.
pub(super) fn module_names(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (file, source) in workspace.sources() {
        let stem = file.path.rsplit('/').next().unwrap_or_default().trim_end_matches(".rs");
        let folder = file.path.rsplit('/').nth(1).unwrap_or_default();
        for name in [stem, folder].into_iter().filter(|name| EMPTY_NAMES.contains(name) || *name == "mod") {
            findings.push(Finding::error(
                &file.path,
                1,
                format!("`{name}` says nothing: name the module's content"),
            ));
        }
        let mut previous = "";
        for (position, word) in words(&source.code) {
            if previous == "mod" && EMPTY_NAMES.contains(&word) {
                let message = format!("`mod {word}` says nothing: name its content");
                findings.push(Finding::error(&file.path, line_of(&source.code, position), message));
            }
            previous = word;
        }
    }
    findings
}
