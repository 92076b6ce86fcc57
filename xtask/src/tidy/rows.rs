//! Rows of modules: what `docs/ARCHITECTURE.md` draws inside of a crate is what its code does.

use super::Finding;
use super::source::{closing, line_of, words};
use super::workspace::{File, Workspace};
use std::collections::BTreeMap;

const PAGE: &str = "docs/ARCHITECTURE.md";

/// What begins the section of a crate.
const SECTION: &str = "## Inside ";

/// Where a section begins and what it says of a crate.
struct Section<'a> {
    line: usize,
    name: &'a str,
    text: &'a str,
}

impl<'a> Section<'a> {
    fn all(page: &'a str) -> impl Iterator<Item = Self> {
        page.match_indices(SECTION).map(|(start, _)| {
            let text = &page[start + SECTION.len()..];
            let text = text.find("\n## ").map_or(text, |end| &text[..end]);
            let name = text.lines().next().unwrap_or_default().trim();
            Section { line: line_of(page, start), name, text }
        })
    }

    /// The number of the row that names a module first, from the bottom up.
    fn rows(&self) -> BTreeMap<&'a str, usize> {
        let mut rows = BTreeMap::new();
        for (number, line) in self.text.lines().filter(|line| line.starts_with("| `")).enumerate() {
            for name in quoted(line.split('|').nth(1).unwrap_or_default()) {
                rows.entry(name).or_insert(number);
            }
        }
        rows
    }
}

/// The first words of what stands in backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2).filter_map(|code| words(code).next().map(|(_, word)| word))
}

/// A module uses only what stands in its own row or above it, and the section of its crate names it.
pub(super) fn rows(workspace: &Workspace) -> Vec<Finding> {
    let Some(page) = workspace.files.iter().find(|file| file.path == PAGE) else { return Vec::new() };
    let mut findings = Vec::new();
    for section in Section::all(&page.text) {
        let source = format!("crates/{}/src/", section.name);
        let rows = section.rows();
        for file in workspace.files.iter().filter(|file| file.path.starts_with(&source)) {
            let path = &file.path[source.len()..];
            let module = path.split(['/', '.']).next().unwrap_or_default();
            match rows.get(module) {
                Some(row) => findings.extend(lookups(file, *row, &rows)),
                None if path.contains('/') || matches!(module, "lib" | "error") => {}
                None if quoted(section.text).any(|name| name == module) => {}
                None => {
                    let message =
                        format!("the section of {} does not name its module `{module}`", section.name);
                    findings.push(Finding::error(PAGE, section.line, message));
                }
            }
        }
    }
    findings
}

/// Where a file of a module in this row uses modules of rows below.
fn lookups(file: &File, row: usize, rows: &BTreeMap<&str, usize>) -> Vec<Finding> {
    let Some(code) = file.source.as_ref().map(|source| source.code_without_tests()) else {
        return Vec::new();
    };
    used(&code)
        .into_iter()
        .filter(|(_, module)| rows.get(module).is_some_and(|other| *other > row))
        .map(|(position, module)| {
            let message = format!("`{module}` stands below in {PAGE}: move what is needed, or the row");
            Finding::error(&file.path, line_of(&code, position), message)
        })
        .collect()
}

/// What follows `crate::`, each name of a list in braces too.
fn used(code: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    for (position, _) in words(code).filter(|(_, word)| *word == "crate") {
        let after = position + "crate::".len();
        let Some(rest) = code[position..].strip_prefix("crate::") else { continue };
        if !rest.starts_with('{') {
            found.extend(words(rest).next().map(|(_, word)| (after, word)));
            continue;
        }
        let list = &code[after..closing(code, after)];
        let mut depth = 0;
        let mut begins = false;
        for (at, byte) in list.bytes().enumerate() {
            match byte {
                b'{' => (depth, begins) = (depth + 1, depth == 0),
                b'}' => depth -= 1,
                b',' => begins = depth == 1,
                _ if begins && !byte.is_ascii_whitespace() => {
                    found.extend(words(&list[at..]).next().map(|(_, word)| (after + at, word)));
                    begins = false;
                }
                _ => {}
            }
        }
    }
    found
}
