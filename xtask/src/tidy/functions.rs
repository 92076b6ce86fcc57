//! Rules over functions.

use super::Finding;
use super::policy::FUNCTION_LINES;
use super::source::{closing, item_end, line_of, words};
use super::workspace::Workspace;

/// Where a function's parts are in the code of its file.
struct Function<'a> {
    name: &'a str,
    /// The position of `fn`.
    start: usize,
    /// Between the parentheses.
    parameters: &'a str,
    /// Between the braces; empty for a declaration.
    body: &'a str,
}

fn functions(code: &str) -> Vec<Function<'_>> {
    let mut found = Vec::new();
    let mut after_fn = None;
    for (position, word) in words(code) {
        if let Some(start) = after_fn.take() {
            // `fn(f64) -> f64` is a type: its word follows behind a parenthesis.
            let gap = code[start + 2..position].trim();
            if gap.is_empty() || gap == "$" {
                found.extend(function(code, start, position, word));
            }
        }
        if word == "fn" {
            after_fn = Some(position);
        }
    }
    found
}

fn function<'a>(code: &'a str, start: usize, name_start: usize, name: &'a str) -> Option<Function<'a>> {
    let open = after_generics(code, name_start + name.len());
    if code.as_bytes().get(open) != Some(&b'(') {
        return None;
    }
    let close = closing(code, open);
    let end = item_end(code, close);
    let body_start = close + code[close..end].find('{').map_or(end - close, |found| found + 1);
    let body = code.get(body_start..end.saturating_sub(1)).unwrap_or("");
    let parameters = code.get(open + 1..close.saturating_sub(1)).unwrap_or("");
    Some(Function { name, start, parameters, body })
}

/// The first position behind `start` that is neither blank nor inside `<…>`.
fn after_generics(code: &str, start: usize) -> usize {
    let bytes = code.as_bytes();
    let mut depth = 0;
    let mut i = start;
    while i < bytes.len() {
        match bytes[i] {
            b'<' => depth += 1,
            b'>' if bytes[i - 1] != b'-' => depth -= 1,
            byte if depth == 0 && !byte.is_ascii_whitespace() => break,
            _ => {}
        }
        i += 1;
    }
    i
}

/// A function that does not fit on a screen or two does more than one thing.
pub(super) fn length(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (file, source) in workspace.sources() {
        for function in functions(&source.code) {
            let lines = function.body.lines().filter(|line| !line.trim().is_empty()).count();
            if lines > FUNCTION_LINES {
                let message = format!("`{}` has {lines} lines, the limit is {FUNCTION_LINES}", function.name);
                findings.push(Finding::error(&file.path, line_of(&source.code, function.start), message));
            }
        }
    }
    findings
}

/// At a call, `true` says nothing; a variant of an enum does.
pub(super) fn bool_parameters(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (file, code) in workspace.solver_code() {
        for function in functions(&code) {
            if is_public(&code[..function.start]) && parameters_of(function.parameters).any(is_bool) {
                let message = format!("`{}` takes a bool: give the choice a name, as an enum", function.name);
                findings.push(Finding::error(&file.path, line_of(&code, function.start), message));
            }
        }
    }
    findings
}

/// Whether the qualifiers that `before` ends with include `pub`.
fn is_public(before: &str) -> bool {
    let item = before.rfind(['{', '}', ';']).map_or(before, |end| &before[end + 1..]);
    words(item).any(|(_, word)| word == "pub")
}

fn parameters_of(parameters: &str) -> impl Iterator<Item = &str> {
    let mut depth = 0;
    parameters.split(move |character| {
        match character {
            '(' | '[' | '{' | '<' => depth += 1,
            ')' | ']' | '}' | '>' => depth -= 1,
            _ => {}
        }
        character == ',' && depth <= 0
    })
}

fn is_bool(parameter: &str) -> bool {
    parameter.split_once(':').is_some_and(|(_, kind)| kind.trim().trim_start_matches(['&', ' ']) == "bool")
}
