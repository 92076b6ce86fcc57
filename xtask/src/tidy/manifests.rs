//! Rules over the manifests.

use super::Finding;
use super::policy::{ARROWS, DEPENDANTS, HEAVY_DEPENDENCIES};
use super::workspace::{File, Workspace};
use toml::{Table, Value};

/// A package's manifest and what its library is built with.
struct Manifest<'a> {
    file: &'a File,
    name: String,
    /// The packages of `[dependencies]` and `[build-dependencies]`, under every target.
    dependencies: Vec<String>,
    table: Table,
}

/// The manifests of the workspace's packages, and a finding for each file that is none.
fn manifests(workspace: &Workspace) -> (Vec<Manifest<'_>>, Vec<Finding>) {
    read(workspace.files.iter().filter(|file| !file.path.starts_with(DEPENDANTS)))
}

fn read<'a>(files: impl Iterator<Item = &'a File>) -> (Vec<Manifest<'a>>, Vec<Finding>) {
    let (mut manifests, mut findings) = (Vec::new(), Vec::new());
    for file in files.filter(|file| file.path.ends_with("/Cargo.toml")) {
        match file.text.parse::<Table>() {
            Ok(table) => manifests.push(manifest(file, table)),
            Err(error) => findings.push(Finding::error(&file.path, 1, format!("not a manifest: {error}"))),
        }
    }
    (manifests, findings)
}

fn manifest(file: &File, table: Table) -> Manifest<'_> {
    let name = table.get("package").and_then(|package| package.get("name")).and_then(Value::as_str);
    let name = name.unwrap_or_default().to_owned();
    let targets = table.get("target").and_then(Value::as_table).into_iter().flat_map(Table::values);
    let tables = std::iter::once(&table).chain(targets.filter_map(Value::as_table));
    let dependencies = tables.flat_map(dependencies_of).collect();
    Manifest { file, name, dependencies, table }
}

fn dependencies_of(table: &Table) -> Vec<String> {
    ["dependencies", "build-dependencies"]
        .iter()
        .filter_map(|kind| table.get(*kind)?.as_table())
        .flatten()
        .map(|(key, value)| {
            let renamed = value.get("package").and_then(Value::as_str);
            renamed.unwrap_or(key).to_owned()
        })
        .collect()
}

/// The line that names `word`, for pointing at it.
fn line_naming(text: &str, word: &str) -> usize {
    text.lines().position(|line| line.contains(word)).map_or(1, |line| line + 1)
}

/// Normal dependencies between the workspace's crates point only as drawn: each crate is usable alone, and sibling
/// families never see each other.
pub(super) fn arrows(workspace: &Workspace) -> Vec<Finding> {
    let (manifests, mut findings) = manifests(workspace);
    for Manifest { file, name, dependencies, .. } in &manifests {
        let Some((_, allowed)) = ARROWS.iter().find(|(crate_name, _)| crate_name == name) else {
            let message = format!("package `{name}` is not in the architecture: draw its arrows first");
            findings.push(Finding::error(&file.path, line_naming(&file.text, name), message));
            continue;
        };
        for dependency in dependencies {
            let ours = ARROWS.iter().any(|(crate_name, _)| crate_name == dependency);
            if ours && !allowed.contains(&dependency.as_str()) {
                let message = format!("`{name}` may not depend on `{dependency}`: no such arrow is drawn");
                findings.push(Finding::error(&file.path, line_naming(&file.text, dependency), message));
            }
        }
    }
    findings
}

/// Every solver crate has a program outside of the workspace that depends on it, and on nothing else.
pub(super) fn dependants(workspace: &Workspace) -> Vec<Finding> {
    let (manifests, mut findings) =
        read(workspace.files.iter().filter(|file| file.path.starts_with(DEPENDANTS)));
    for folder in &workspace.crate_folders {
        let path = format!("{DEPENDANTS}/{folder}/Cargo.toml");
        if !manifests.iter().any(|manifest| manifest.file.path == path) {
            let message = format!("`{folder}` has no dependant: a program that uses it and nothing else");
            findings.push(Finding::error(&path, 1, message));
        }
    }
    for Manifest { file, dependencies, table, .. } in &manifests {
        let folder = file.path.rsplit('/').nth(1).unwrap_or_default();
        if dependencies.iter().ne([folder]) {
            let message =
                format!("a dependant depends on the crate that its folder names, `{folder}`, alone");
            findings.push(Finding::error(&file.path, line_naming(&file.text, "[dependencies"), message));
        }
        if !table.contains_key("workspace") {
            let message = "a dependant is no member of the workspace: an empty [workspace] says so";
            findings.push(Finding::error(&file.path, 1, message));
        }
    }
    findings
}

/// A heavy dependency belongs to the crate that hides it behind a wall.
pub(super) fn heavy_dependencies(workspace: &Workspace) -> Vec<Finding> {
    let (manifests, _) = manifests(workspace);
    let mut findings = Vec::new();
    for Manifest { file, name, dependencies, .. } in &manifests {
        for (heavy, owners) in HEAVY_DEPENDENCIES {
            if dependencies.iter().any(|dependency| dependency == heavy) && !owners.contains(&name.as_str()) {
                let message =
                    format!("only {} may depend on `{heavy}`: use its interface", owners.join(", "));
                findings.push(Finding::error(&file.path, line_naming(&file.text, heavy), message));
            }
        }
    }
    findings
}

/// The lints that check what this program does not are on, and every package inherits them.
pub(super) fn lints(workspace: &Workspace) -> Vec<Finding> {
    const REQUIRED: &[(&str, &str)] = &[
        ("rust", "missing_docs"),
        ("rust", "unsafe_code"),
        ("clippy", "unwrap_used"),
        ("clippy", "too_many_lines"),
        ("clippy", "fn_params_excessive_bools"),
        ("clippy", "print_stdout"),
    ];
    let mut findings = Vec::new();
    if let Some(root) = workspace.files.iter().find(|file| file.path == "Cargo.toml") {
        let table = root.text.parse::<Table>().unwrap_or_default();
        let lints = table.get("workspace").and_then(|workspace| workspace.get("lints"));
        for (tool, lint) in REQUIRED {
            let lint_table = lints.and_then(|lints| lints.get(*tool)?.get(*lint));
            let level = lint_table.and_then(|lint| lint.get("level").unwrap_or(lint).as_str());
            // The gate turns warnings into errors; unsafe code is refused in every build.
            let on =
                matches!(level, Some("deny" | "forbid")) || (level == Some("warn") && *lint != "unsafe_code");
            if !on {
                let least = if *lint == "unsafe_code" { "deny" } else { "warn" };
                let message =
                    format!("the lint {tool}::{lint} must be on for the workspace, at least `{least}`");
                findings.push(Finding::error(&root.path, line_naming(&root.text, lint), message));
            }
        }
    }
    for Manifest { file, name, table, .. } in &manifests(workspace).0 {
        let inherits = table.get("lints").and_then(|lints| lints.get("workspace")).and_then(Value::as_bool);
        if inherits != Some(true) {
            let message = format!("`{name}` must inherit the workspace's lints: `[lints] workspace = true`");
            findings.push(Finding::error(&file.path, line_naming(&file.text, "[lints"), message));
        }
    }
    findings
}
