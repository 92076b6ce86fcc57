//! The workspace as text.

use super::Finding;
use super::policy::{ARROWS, TOP_LEVEL};
use super::source::Source;
use std::collections::BTreeSet;
use std::io;
use std::path::Path;

/// One text file, its path relative to the workspace with forward slashes.
pub(crate) struct File {
    pub(crate) path: String,
    pub(crate) text: String,
    /// Present for Rust files.
    pub(crate) source: Option<Source>,
}

/// All that the rules look at.
pub(crate) struct Workspace {
    /// Rust files, manifests, scenes and pages, in the order of their paths.
    pub(crate) files: Vec<File>,
    /// All other files, and all folders.
    pub(crate) others: BTreeSet<String>,
    /// The names at the top.
    pub(crate) top_level: Vec<String>,
    /// The names in `crates/`.
    pub(crate) crate_folders: Vec<String>,
}

impl File {
    pub(crate) fn new(path: &str, text: &str) -> Self {
        let source = path.ends_with(".rs").then(|| Source::new(text));
        Self { path: path.to_owned(), text: text.to_owned(), source }
    }

    /// Whether this is code that a user of a solver crate runs: its `src`, without the modules that only its own
    /// tests see.
    pub(crate) fn is_solver_source(&self) -> bool {
        self.path.starts_with("crates/") && self.path.contains("/src/") && !self.path.ends_with("/tests.rs")
    }

    /// The folder of the crate that this file belongs to.
    pub(crate) fn crate_folder(&self) -> Option<&str> {
        self.path.strip_prefix("crates/")?.split('/').next()
    }
}

impl Workspace {
    /// Reads the workspace at `root`.
    pub(crate) fn load(root: &Path) -> io::Result<Self> {
        let (mut files, mut others) = (Vec::new(), BTreeSet::new());
        let top_level = names(root)?;
        for name in ["crates", "docs", "tests", "xtask"] {
            collect(root, name, &mut files, &mut others)?;
        }
        for name in top_level.iter().filter(|name| root.join(name).is_file()) {
            take(root, name, &mut files, &mut others)?;
        }
        files.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(Self { files, others, top_level, crate_folders: names(&root.join("crates"))? })
    }

    /// Whether there is such a file or folder.
    pub(crate) fn has(&self, path: &str) -> bool {
        self.others.contains(path) || self.files.iter().any(|file| file.path == path)
    }

    /// The Rust files.
    pub(crate) fn sources(&self) -> impl Iterator<Item = (&File, &Source)> {
        self.files.iter().filter_map(|file| Some((file, file.source.as_ref()?)))
    }

    /// The code of the solver crates, without their tests.
    pub(crate) fn solver_code(&self) -> impl Iterator<Item = (&File, String)> {
        self.sources()
            .filter(|(file, _)| file.is_solver_source())
            .map(|(file, source)| (file, source.code_without_tests()))
    }
}

fn collect(
    root: &Path,
    folder: &str,
    files: &mut Vec<File>,
    others: &mut BTreeSet<String>,
) -> io::Result<()> {
    others.insert(folder.to_owned());
    for name in names(&root.join(folder))? {
        let path = format!("{folder}/{name}");
        if !root.join(&path).is_dir() {
            take(root, &path, files, others)?;
        } else if name != "target" && !name.starts_with('.') {
            collect(root, &path, files, others)?;
        }
    }
    Ok(())
}

/// Reads what rules look into; of other files it is enough that they are there.
fn take(root: &Path, path: &str, files: &mut Vec<File>, others: &mut BTreeSet<String>) -> io::Result<()> {
    if [".rs", ".toml", ".md"].iter().any(|kind| path.ends_with(kind)) {
        files.push(File::new(path, &std::fs::read_to_string(root.join(path))?));
    } else {
        others.insert(path.to_owned());
    }
    Ok(())
}

fn names(folder: &Path) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// The top holds the designed entries and dotfiles only: a newcomer sees the whole plan at a glance.
pub(super) fn top_level(workspace: &Workspace) -> Vec<Finding> {
    workspace
        .top_level
        .iter()
        .filter(|name| !name.starts_with('.') && !TOP_LEVEL.contains(&name.as_str()))
        .map(|name| {
            Finding::error(name, 1, "the top level holds the designed entries and dotfiles only: move it")
        })
        .collect()
}

/// `crates/` holds the solver crates, flat, folder = crate name, each with a README.
pub(super) fn crate_folders(workspace: &Workspace) -> Vec<Finding> {
    let mut findings = Vec::new();
    for folder in &workspace.crate_folders {
        let path = format!("crates/{folder}");
        if !ARROWS.iter().any(|(name, _)| name == folder) {
            findings.push(Finding::error(&path, 1, "not a crate of the architecture: draw its arrows first"));
        }
        let readme = format!("{path}/README.md");
        let text =
            workspace.files.iter().find(|file| file.path == readme).map_or("", |file| file.text.as_str());
        if text.lines().filter(|line| !line.trim().is_empty()).count() < 2 {
            findings.push(Finding::error(
                &readme,
                1,
                "every crate says in its README what is and is not there",
            ));
        }
    }
    findings
}
