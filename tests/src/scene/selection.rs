//! Which scenes of a folder run: by suite, name, crate and shard.

use super::validation::Suite;
use super::{Scene, SceneError};
use std::path::{Path, PathBuf};

/// What was asked for.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Only scenes of this suite.
    pub suite: Option<Suite>,
    /// Only scenes whose name matches one of these patterns (`*` any text, `?` any character); all when empty.
    pub patterns: Vec<String>,
    /// Only scenes of these crates; all when empty.
    pub crates: Vec<String>,
}

/// All validation scenes `root/<crate>/*.toml`, in name order.
///
/// # Errors
/// When the folder or one of the scenes cannot be read.
pub fn read_all(root: &Path) -> Result<Vec<Scene>, SceneError> {
    let mut scenes = Vec::new();
    for folder in sorted_entries(root)?.into_iter().filter(|entry| entry.is_dir()) {
        for path in sorted_entries(&folder)? {
            if path.extension().is_some_and(|extension| extension == "toml") {
                scenes.push(Scene::read(&path)?);
            }
        }
    }
    scenes.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(scenes)
}

fn sorted_entries(folder: &Path) -> Result<Vec<PathBuf>, SceneError> {
    let fails = |source| SceneError::Folder { path: folder.to_owned(), source };
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(fails)? {
        entries.push(entry.map_err(fails)?.path());
    }
    entries.sort();
    Ok(entries)
}

/// The scenes that were asked for, in name order.
///
/// # Errors
/// When a pattern or a crate matches no scene at all.
pub fn select(scenes: Vec<Scene>, selection: &Selection) -> Result<Vec<Scene>, SceneError> {
    let names: Vec<String> = scenes.iter().map(|scene| scene.name.clone()).collect();
    let unknown =
        |pattern: &str| SceneError::UnknownScene { pattern: pattern.to_owned(), known: names.join(", ") };
    for pattern in &selection.patterns {
        if !names.iter().any(|name| matches(pattern, name)) {
            return Err(unknown(pattern));
        }
    }
    for crate_name in &selection.crates {
        if !scenes.iter().any(|scene| scene.crate_name() == crate_name) {
            return Err(unknown(&format!("{crate_name}/*")));
        }
    }
    let wanted = |scene: &Scene| {
        let Some(validation) = &scene.file.validation else { return false };
        selection.suite.is_none_or(|suite| validation.suites.contains(&suite))
            && (selection.patterns.is_empty() || selection.patterns.iter().any(|p| matches(p, &scene.name)))
            && (selection.crates.is_empty() || selection.crates.iter().any(|c| c == scene.crate_name()))
    };
    Ok(scenes.into_iter().filter(wanted).collect())
}

/// A part of the scenes: shard `index` (from one) of `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parsed {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err(format!("`{text}` is not a shard: must be i/n with 1 ≤ i ≤ n, such as 2/4")),
        }
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl Shard {
    /// Every `count`-th of the items, beginning with number `index`: the shards of a list are disjoint and
    /// together are the list.
    pub fn of<T>(self, items: Vec<T>) -> Vec<T> {
        items.into_iter().skip(self.index - 1).step_by(self.count).collect()
    }
}

/// Whether a name matches a pattern in which `*` stands for any text and `?` for any one character.
fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    // reachable[i]: the pattern so far can match the first i characters of the name.
    let mut reachable: Vec<bool> = (0..=name.len()).map(|i| i == 0).collect();
    for symbol in pattern {
        if symbol == '*' {
            for i in 1..reachable.len() {
                reachable[i] |= reachable[i - 1];
            }
            continue;
        }
        for i in (1..reachable.len()).rev() {
            reachable[i] = reachable[i - 1] && (symbol == '?' || symbol == name[i - 1]);
        }
        reachable[0] = false;
    }
    reachable[name.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_whole_names() {
        for (pattern, name) in [
            ("*", ""),
            ("core/*", "core/svd"),
            ("*svd*", "core/svd"),
            ("c?re/s*d", "core/svd"),
            ("core/svd", "core/svd"),
        ] {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in
            [("core", "core/svd"), ("?", ""), ("core/*x", "core/svd"), ("", "a"), ("svd", "core/svd")]
        {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }

    #[test]
    fn shards_are_disjoint_and_complete() {
        for count in 1..6 {
            let mut all: Vec<usize> = (1..=count)
                .flat_map(|i| format!("{i}/{count}").parse::<Shard>().expect("a shard").of((0..13).collect()))
                .collect();
            all.sort_unstable();
            assert_eq!(all, (0..13).collect::<Vec<_>>());
        }
        for wrong in ["0/2", "3/2", "1", "a/b", "1/0", "-1/2", ""] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
