//! The architecture's invariants as checks.
//!
//! A [`Rule`] looks at the whole [`Workspace`] as text and reports [`Finding`]s. What the rules allow stands in
//! `policy.rs`, the exceptions with their reasons too. Every rule has a planted violation in `tests.rs`, so that
//! none can pass by looking at nothing; the same tests run all rules on the real workspace.

mod documents;
mod functions;
mod manifests;
mod policy;
mod rows;
mod source;
mod text_rules;
mod workspace;

#[cfg(test)]
mod tests;

pub(crate) use policy::{ARROWS, DEPENDANTS, EXCEPTIONS};
pub(crate) use workspace::Workspace;

use std::fmt;

/// Whether a finding fails the check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Severity {
    /// An invariant is broken.
    Error,
    /// Worth a second look.
    Warning,
}

/// One place where a rule is broken.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Finding {
    pub(crate) path: String,
    pub(crate) line: usize,
    pub(crate) severity: Severity,
    pub(crate) message: String,
}

impl Finding {
    fn error(path: &str, line: usize, message: impl Into<String>) -> Self {
        Self { path: path.to_owned(), line, severity: Severity::Error, message: message.into() }
    }

    fn warning(path: &str, line: usize, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(path, line, message) }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = if self.severity == Severity::Warning { "warning: " } else { "" };
        write!(formatter, "{}:{}: {severity}{}", self.path, self.line, self.message)
    }
}

/// One invariant.
pub(crate) struct Rule {
    pub(crate) name: &'static str,
    check: fn(&Workspace) -> Vec<Finding>,
}

/// A file that may break a rule, and why.
pub(crate) struct Exception {
    pub(crate) rule: &'static str,
    pub(crate) path: &'static str,
    pub(crate) reason: &'static str,
}

const RULES: &[Rule] = &[
    Rule { name: "arrows", check: manifests::arrows },
    Rule { name: "dependants", check: manifests::dependants },
    Rule { name: "heavy-dependencies", check: manifests::heavy_dependencies },
    Rule { name: "lints", check: manifests::lints },
    Rule { name: "walls", check: text_rules::walls },
    Rule { name: "file-length", check: text_rules::file_length },
    Rule { name: "function-length", check: functions::length },
    Rule { name: "bool-parameters", check: functions::bool_parameters },
    Rule { name: "documented", check: text_rules::documented },
    Rule { name: "lifted-lints", check: text_rules::lifted_lints },
    Rule { name: "to-do", check: text_rules::to_do },
    Rule { name: "printing", check: text_rules::printing },
    Rule { name: "files", check: text_rules::files },
    Rule { name: "hash-maps", check: text_rules::hash_maps },
    Rule { name: "atomics", check: text_rules::atomics },
    Rule { name: "unsafe", check: text_rules::unsafe_blocks },
    Rule { name: "ignored-tests", check: text_rules::ignored_tests },
    Rule { name: "module-names", check: text_rules::module_names },
    Rule { name: "rows", check: rows::rows },
    Rule { name: "broken-links", check: documents::broken_links },
    Rule { name: "equations", check: documents::equations },
    Rule { name: "gallery", check: documents::gallery },
    Rule { name: "notation", check: documents::notation },
    Rule { name: "top-level", check: workspace::top_level },
    Rule { name: "crate-folders", check: workspace::crate_folders },
];

pub(crate) fn rule_count() -> usize {
    RULES.len()
}

/// All findings that no exception covers, in the order of files and lines. An exception that covers nothing is a
/// finding itself: the list may not outlive its reasons.
pub(crate) fn check(workspace: &Workspace, exceptions: &[Exception]) -> Vec<Finding> {
    let mut used = vec![false; exceptions.len()];
    let mut findings = Vec::new();
    for rule in RULES {
        for finding in (rule.check)(workspace) {
            let excused = exceptions.iter().position(|e| e.rule == rule.name && e.path == finding.path);
            match excused {
                Some(k) => used[k] = true,
                None => findings.push(finding),
            }
        }
    }
    for (exception, used) in exceptions.iter().zip(used) {
        if !used {
            findings.push(stale(exception));
        }
    }
    findings.sort();
    findings
}

fn stale(exception: &Exception) -> Finding {
    let Exception { rule, path, reason } = exception;
    let message =
        format!("the exception of {path} from rule `{rule}` ({reason}) covers nothing any more: remove it");
    Finding::error("xtask/src/tidy/policy.rs", 1, message)
}
