//! Rules over the pages of documentation.

use super::Finding;
use super::source::words;
use super::workspace::{File, Workspace};
use std::collections::BTreeSet;

/// A link of a page.
struct Link<'a> {
    line: usize,
    text: &'a str,
    /// What it points to, without the part after `#`.
    target: &'a str,
    /// The part after `#`, or nothing.
    anchor: &'a str,
}

impl Link<'_> {
    /// Whether it points into the source, to the item that it names: [`Type::item`](file.rs).
    fn item(&self) -> Option<&str> {
        let name = self.text.strip_prefix('`')?.strip_suffix('`')?;
        self.target.ends_with(".rs").then_some(name)
    }
}

/// The lines of a page that are not in a fence, with their numbers; the first line of a fence is among them.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut fenced = false;
    text.lines().enumerate().filter_map(move |(index, line)| {
        let fence = line.trim_start().starts_with("```");
        let shown = !fenced;
        fenced ^= fence;
        shown.then_some((index + 1, line))
    })
}

fn links(text: &str) -> Vec<Link<'_>> {
    let mut found = Vec::new();
    for (line, content) in prose(text) {
        for (middle, _) in content.match_indices("](") {
            let start = content[..middle].rfind('[').map_or(0, |bracket| bracket + 1);
            let Some(length) = content[middle + 2..].find(')') else { continue };
            let target = &content[middle + 2..middle + 2 + length];
            let (target, anchor) = target.split_once('#').unwrap_or((target, ""));
            found.push(Link { line, text: &content[start..middle], target, anchor });
        }
    }
    found
}

/// `target` as a path from the top of the workspace, when a page in `folder` links to it.
fn resolved(folder: &str, target: &str) -> Option<String> {
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    for part in target.split('/').filter(|part| !matches!(*part, "" | ".")) {
        match part {
            ".." => drop(parts.pop()?),
            _ => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

fn pages(workspace: &Workspace) -> impl Iterator<Item = &File> {
    workspace.files.iter().filter(|file| file.path.ends_with(".md"))
}

/// What a page points to is there: the file, the heading, and in a source file the item that the link names.
pub(super) fn broken_links(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for page in pages(workspace) {
        let folder = page.path.rsplit_once('/').map_or("", |(folder, _)| folder);
        for link in links(&page.text).iter().filter(|link| !link.target.contains(':')) {
            if let Some(message) = fault(workspace, page, folder, link) {
                findings.push(Finding::error(&page.path, link.line, message));
            }
        }
    }
    findings
}

fn fault(workspace: &Workspace, page: &File, folder: &str, link: &Link<'_>) -> Option<String> {
    let path = if link.target.is_empty() { Some(page.path.clone()) } else { resolved(folder, link.target) };
    let Some(path) = path.filter(|path| workspace.has(path)) else {
        return Some(format!("the link to `{}` leads nowhere", link.target));
    };
    let file = workspace.files.iter().find(|file| file.path == path)?;
    if path.ends_with(".md") && !link.anchor.is_empty() && !has_heading(&file.text, link.anchor) {
        return Some(format!("{path} has no heading `#{}`", link.anchor));
    }
    let (name, source) = (link.item()?, file.source.as_ref()?);
    (!defines(&source.code, name)).then(|| format!("{path} does not define `{name}`"))
}

/// Whether a heading has the anchor that GitHub gives it: lower case, blanks to hyphens, no punctuation.
fn has_heading(text: &str, anchor: &str) -> bool {
    prose(text).filter_map(|(_, line)| line.strip_prefix('#')).any(|line| {
        let title = line.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
        title.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_')).eq(anchor.chars())
    })
}

/// Whether the code has an item of this name. Of `Type::item` both words must occur, for variants, fields and methods are written
/// in many ways; a lone name must follow the keyword of a definition.
fn defines(code: &str, name: &str) -> bool {
    const KEYWORDS: &[&str] =
        &["const", "enum", "fn", "macro_rules", "mod", "static", "struct", "trait", "type"];
    let plain = |part: &str| part.split('<').next().unwrap_or_default().trim_end_matches("()").to_owned();
    let parts: Vec<String> = name.split("::").map(plain).collect();
    if let [alone] = parts.as_slice() {
        let mut previous = "";
        return words(code).any(|(_, word)| {
            let defined = word == alone && KEYWORDS.contains(&previous);
            previous = word;
            defined
        });
    }
    parts.iter().all(|part| words(code).any(|(_, word)| word == part))
}

/// Every equation of a page of theory says where it is in the code, before the next heading at the latest.
pub(super) fn equations(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for page in pages(workspace).filter(|page| page.path.starts_with("docs/theory/")) {
        let mut open = None;
        let mut close = |open: &mut Option<usize>| {
            if let Some(line) = open.take() {
                let message = "no link to the code after this equation: say what implements it";
                findings.push(Finding::error(&page.path, line, message));
            }
        };
        for (number, line) in prose(&page.text) {
            if line.starts_with('#') {
                close(&mut open);
            } else if line.starts_with("```math") {
                open = open.or(Some(number));
            } else if line.contains(".rs)") {
                open = None;
            }
        }
        close(&mut open);
    }
    findings
}

/// Every scene that is validated stands in the gallery.
pub(super) fn gallery(workspace: &Workspace) -> Vec<Finding> {
    let page = workspace.files.iter().find(|file| file.path == "docs/GALLERY.md");
    let shown = |path: &str| page.is_some_and(|page| page.text.contains(&format!("(../{path})")));
    let scenes = workspace.files.iter().filter(|file| file.path.starts_with("tests/scenes/"));
    scenes
        .filter(|scene| scene.text.lines().any(|line| line.trim() == "[validation]") && !shown(&scene.path))
        .map(|scene| {
            Finding::error(&scene.path, 1, "not in docs/GALLERY.md: `cargo xtask gallery` makes it anew")
        })
        .collect()
}

/// Every name that the notation gives for code, in the second column of its tables, is one of the solver crates.
pub(super) fn notation(workspace: &Workspace) -> Vec<Finding> {
    let Some(page) = workspace.files.iter().find(|file| file.path == "docs/NOTATION.md") else {
        return Vec::new();
    };
    let solvers = workspace.sources().filter(|(file, _)| file.is_solver_source());
    let known: BTreeSet<&str> =
        solvers.flat_map(|(_, source)| words(&source.code).map(|(_, word)| word)).collect();
    let mut findings = Vec::new();
    for (number, line) in prose(&page.text).filter(|(_, line)| line.starts_with('|')) {
        let row = line.replace("\\|", "  ");
        let spans = row.split('|').nth(2).unwrap_or_default().split('`').skip(1).step_by(2);
        for (_, name) in spans.flat_map(words).filter(|(_, name)| !known.contains(name)) {
            findings.push(Finding::error(&page.path, number, format!("no solver crate has `{name}`")));
        }
    }
    findings
}
