//! Arbitrary bytes give a scene or a typed error, and cost memory and time in proportion to their number: the committed scenes, mutated.
//!
//! As the readers of meshes are tried in mechanics-core. `FUZZ_SECONDS` sets the time (0.5 if unset); `FUZZ_SEED` another sequence. A failing input is written to the
//! temporary folder; it belongs into tests/tests/scene/corpus as `regression_…` when the bug is mended.

use crate::fuzzing;
use std::path::{Path, PathBuf};
use validation::scene::Scene;

/// What has been read can be run at every point of its ladder: reading has made sure of it.
fn read(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    match Scene::parse(&scenes().join("lagrangian/fuzz.toml"), text.to_owned()) {
        Ok(scene) => {
            let Some(validation) = &scene.file.validation else { return true };
            let (value, method) = (validation.ladder.values.last(), validation.methods.first());
            value.zip(method).is_none_or(|(value, method)| scene.at(value.value(), method).is_ok())
        }
        // Whoever reads the error must be able to.
        Err(error) => error.to_string().is_empty(),
    }
}

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// Bytes of memory for each byte of input, and for an empty one: a tree of the document and the scene itself, both twice while values are put in.
const MEMORY_FACTOR: isize = 1000;
const MEMORY_BASE: isize = 1_000_000;

fn feed(bytes: &[u8]) -> bool {
    fuzzing::feed("scene", read, bytes, MEMORY_BASE + MEMORY_FACTOR * bytes.len() as isize)
}

/// Every committed scene, and what once broke the reader.
fn corpus() -> Vec<(PathBuf, Vec<u8>)> {
    let folders = fuzzing::files(&scenes()).into_iter().filter(|path| path.is_dir());
    let regressions = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scene/corpus");
    let folders = folders.chain([regressions].into_iter().filter(|path| path.is_dir()));
    let files = folders.flat_map(|folder| fuzzing::files(&folder));
    let scenes = files.filter(|path| path.extension().is_some_and(|ending| ending == "toml"));
    scenes.map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

#[test]
fn corpus_replays() {
    for (path, bytes) in corpus() {
        let valid = feed(&bytes);
        assert!(valid || fuzzing::is_regression(&path), "{} is no longer read", path.display());
    }
}

#[test]
fn prefixes_of_scenes_are_survived() {
    // Every scene at some places, so that all tables are cut somewhere.
    for (number, (_, bytes)) in corpus().into_iter().enumerate() {
        for length in (number % 61..bytes.len()).step_by(61) {
            feed(&bytes[..length]);
        }
    }
}

/// Depth, length, and numbers that ask for much.
#[test]
fn large_hostile_scenes_take_linear_time() {
    let scenes = corpus().into_iter().map(|(_, bytes)| String::from_utf8(bytes).unwrap());
    let claim = scenes.into_iter().find(|scene| scene.contains("\nvalues = [")).unwrap();
    let ladder = claim.find("\nvalues = [").unwrap() + "\nvalues = [".len();
    let long: String = (1..3000).rev().map(|value| format!("{value}, ")).collect();
    let mut many = claim.clone();
    many.insert_str(ladder, &long);
    for text in [
        "[".repeat(1_000_000),
        format!("a = {}", "[".repeat(1_000_000)),
        format!("a = {}", "{a=".repeat(300_000)),
        "a.".repeat(500_000),
        format!("{} = 1", vec!["a"; 500_000].join(".")),
        "[[meshes]]\n".repeat(90_000),
        "#".repeat(1_000_000),
        format!("a = \"{}\"", "\\u0041".repeat(150_000)),
        many,
    ] {
        feed(text.as_bytes());
    }
}

#[test]
fn mutations_are_survived() {
    let corpus: Vec<Vec<u8>> = corpus().into_iter().map(|(_, bytes)| bytes).collect();
    fuzzing::mutations_are_survived("scene", &corpus, feed);
}
