//! Scene files: what is accepted, what is refused, and that a refusal shows where, what, and what is allowed.

// In a test a panic is the report; the lint spares only functions marked as tests.
#![allow(clippy::unwrap_used)]

#[path = "scene/fuzz.rs"]
mod fuzz;
#[path = "../../crates/mechanics-core/tests/fuzz/fuzzing.rs"]
mod fuzzing;

use std::path::{Path, PathBuf};
use validation::scene::physics::{Integration, LinearSolver};
use validation::scene::{Scene, SceneError, schema};

/// A hyperelastic static problem as a person would write it.
const BAR: &str = r#"[[meshes]]
name = "bar"
material = "rubber"
source = { box = { size_m = [1.0, 0.1, 0.1], cells = [10, 1, 1] } }

[[materials]]
name = "rubber"
density_kg_m3 = 1100
law = { stable-neo-hookean = { young_modulus_pa = 1e6, poisson_ratio = 0.45 } }

[[boundary]]
mesh = "bar"
select = { plane = { point_m = [0, 0, 0], normal = [-1, 0, 0], within_m = 1e-9 } }
motion = { fixed = { axes = ["x", "y", "z"] } }

[[loads]]
gravity = { acceleration_m_s2 = [0, 0, -9.81] }

[integration.static]
load_steps = 1

[solver]
linear = "cholesky"
tolerance_m = 1e-9
max_iterations = 50

[output]
frame_every = 1
formats = ["vtu", "png"]
"#;

const CLAIM: &str = r#"
[validation]
title = "A bar that bends under its weight"
claim = "It survives."
reference = { kind = "invariants", citation = "none" }
suites = ["stress"]
methods = ["cholesky", "pcg-incomplete-cholesky"]
method_sets = "solver.linear"
time_limit_s = 60

[validation.ladder]
name = "tolerance"
unit = "m"
values = [1e-3, 1e-6]
sets = "solver.tolerance_m"

[validation.invariants]
"smallest det F" = { above = 0 }
"#;

fn path() -> PathBuf {
    Path::new("/scenes/lagrangian/bar.toml").to_owned()
}

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse(&path(), text.to_owned())
}

fn error(text: &str) -> String {
    match parse(text) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => error.to_string(),
    }
}

/// The line, from one, on which `text` says `part`.
fn line_of(text: &str, part: &str) -> usize {
    text.lines().position(|line| line.contains(part)).expect("the text says so") + 1
}

#[test]
fn a_static_problem_written_by_hand_is_read() {
    let scene = parse(&format!("{BAR}{CLAIM}")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((scene.name.as_str(), scene.crate_name()), ("lagrangian/bar", "lagrangian"));
    assert_eq!(scene.file.meshes.len(), 1);
    assert!(
        matches!(scene.file.integration, Some(Integration::Static { load_steps }) if load_steps.value() == 1)
    );
    assert_eq!(scene.file.materials[0].density_kg_m3.value(), 1100.0);
}

#[test]
fn ladder_and_method_change_exactly_their_keys() {
    let scene = parse(&format!("{BAR}{CLAIM}")).unwrap_or_else(|error| panic!("{error}"));
    let at = scene.at(1e-6, "pcg-incomplete-cholesky").unwrap_or_else(|error| panic!("{error}"));
    let solver = at.solver.clone().expect("a solver");
    assert_eq!((solver.tolerance_m.value(), solver.linear), (1e-6, LinearSolver::PcgIncompleteCholesky));
    let mut back = at;
    back.solver = scene.file.solver.clone();
    assert_eq!(serde_json::to_value(&back).expect("JSON"), serde_json::to_value(&scene.file).expect("JSON"));
}

#[test]
fn a_value_out_of_range_shows_file_line_value_and_what_is_allowed() {
    for (good, bad, words) in [
        ("density_kg_m3 = 1100", "density_kg_m3 = -3", "-3 is not allowed: must be a finite number > 0"),
        ("poisson_ratio = 0.45", "poisson_ratio = 0.5", "0.5 is not allowed: must be above -1 and below 0.5"),
        ("cells = [10, 1, 1]", "cells = [10, 0, 1]", "0 is not allowed: must be a whole number ≥ 1"),
        ("cells = [10, 1, 1]", "cells = [10, 1.5, 1]", "1.5 is not allowed"),
        ("cells = [10, 1, 1]", "cells = [10, 1]", "array of length 3"),
        ("max_iterations = 50", "max_iterations = \"many\"", "invalid type: string \"many\""),
        ("tolerance_m = 1e-9", "tolerance_m = nan", "NaN is not allowed"),
        ("acceleration_m_s2 = [0, 0, -9.81]", "acceleration_m_s2 = [0, 0, -inf]", "-inf is not allowed"),
    ] {
        let text = BAR.replace(good, bad);
        let message = error(&text);
        let place = format!("/scenes/lagrangian/bar.toml:{}:", line_of(&text, bad));
        assert!(message.starts_with(&place), "{bad}: {message}");
        assert!(message.contains(words) && message.contains(bad), "{bad}: {message}");
    }
}

#[test]
fn unknown_names_are_refused_with_the_known_ones() {
    for (good, bad, words) in [
        // A wrong unit is an unknown key.
        ("young_modulus_pa = 1e6", "young_modulus_mpa = 1", "expected `young_modulus_pa` or `poisson_ratio`"),
        ("density_kg_m3", "density_g_cm3", "a quantity's unit is part of its key"),
        ("box = {", "cube = {", "expected one of"),
        ("linear = \"cholesky\"", "linear = \"lu\"", "`pcg-block-jacobi`"),
        ("axes = [\"x\", \"y\", \"z\"]", "axes = [\"w\"]", "unknown variant `w`"),
        ("[solver]", "[weather]", "unknown field `weather`"),
        ("material = \"rubber\"", "material = \"steel\"", "there is no material `steel`; there are: rubber"),
        ("mesh = \"bar\"", "mesh = \"rod\"", "there is no mesh `rod`; there are: bar"),
    ] {
        let text = BAR.replace(good, bad);
        let message = error(&text);
        assert!(message.contains(&format!("bar.toml:{}:", line_of(&text, bad))), "{bad}: {message}");
        assert!(message.contains(words), "{bad}: {message}");
    }
}

#[test]
fn parts_that_are_missing_or_do_not_fit_are_named() {
    let without = |start: &str, end: &str| {
        let text = format!("{BAR}{CLAIM}");
        let from = text.find(start).expect("the text has it");
        let to =
            if end.is_empty() { text.len() } else { from + text[from..].find(end).expect("and its end") };
        format!("{}{}", &text[..from], &text[to..])
    };
    let claimed = |good: &str, bad: &str| format!("{BAR}{CLAIM}").replace(good, bad);
    for (text, words) in [
        (String::new(), "nothing to run"),
        (without("[integration.static]", "[solver]"), "`integration`: missing; one of `static`"),
        (without("[solver]", "[output]"), "`solver`: missing"),
        (
            claimed(
                "box = { size_m = [1.0, 0.1, 0.1], cells = [10, 1, 1] }",
                "file = { path = \"none.obj\" }",
            ),
            "there is no file /scenes/lagrangian/none.obj",
        ),
        (claimed("normal = [-1, 0, 0]", "normal = [0, 0, 0]"), "must not be zero"),
        (claimed("values = [1e-3, 1e-6]", "values = [1e-3, 1e-6, 1e-4]"), "only rise or only fall"),
        (claimed("values = [1e-3, 1e-6]", "values = []"), "at least one value"),
        (claimed("sets = \"solver.tolerance_m\"", "sets = \"solver.nothing\""), "the scene has no such key"),
        (
            claimed("sets = \"solver.tolerance_m\"", "sets = \"solver.max_iterations\""),
            "0.001 is not allowed",
        ),
        (claimed("\"pcg-incomplete-cholesky\"]", "\"magic\"]"), "unknown variant `magic`"),
        (
            claimed("method_sets = \"solver.linear\"\n", ""),
            "there is no method `cholesky`; there are: simulation",
        ),
        (claimed("kind = \"invariants\"", "kind = \"analytic\""), "needs at least one measure"),
        (claimed("{ above = 0 }", "{}"), "needs `min`, `max` or `above`"),
        (without("[validation.invariants]", ""), "at least one invariant"),
        (format!("{BAR}{CLAIM}").replace("suites", "sweets"), "unknown field `sweets`"),
        (BAR.replace("[[meshes]]", "[[meshes]"), "bar.toml:1:"),
    ] {
        let message = error(&text);
        assert!(message.contains(words), "{words}: {message}");
    }
}

#[test]
fn an_experiment_s_parameters_are_checked_in_their_place() {
    let text =
        "# one\n[experiment]\nname = \"selftest\"\n\n[experiment.parameters]\nmode = \"ok\"\nscale = -1\n";
    let message = error(text);
    assert!(message.contains("bar.toml:7:9: -1 is not allowed: must be a finite number > 0"), "{message}");
    let message = error(&text.replace("scale = -1", "size = 1"));
    assert!(message.contains("bar.toml:7:1: unknown field `size`"), "{message}");
    for (value, words) in [
        ("1979-05-27", "bar.toml:7:9: no parameter is a date"),
        ("99999999999999999999", "bar.toml:7:9: invalid type: integer `99999999999999999999`"),
        ("1e999", "bar.toml:7:9: floating-point number overflowed"),
        ("\"one\"", "bar.toml:7:9: invalid type: string \"one\", expected f64"),
    ] {
        let message = error(&text.replace("-1", value));
        assert!(message.contains(words), "{value}: {message}");
    }
    let message = error("[experiment]\nname = \"selftest\"\n");
    assert!(message.contains("missing field `mode`"), "{message}");
    let message = error("[experiment]\nname = \"nothing\"\n");
    assert!(
        message.contains("bar.toml:2:8: `experiment.name`: there is no experiment `nothing`"),
        "{message}"
    );
    assert!(message.contains("selftest"), "{message}");
}

#[test]
fn the_committed_schema_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema/scene.schema.json");
    let current = format!("{}\n", serde_json::to_string_pretty(&schema()).expect("JSON"));
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == current, "{} is out of date: `cargo xtask schema > {0}` renews it", path.display());
}

#[test]
fn the_schema_knows_experiments_and_ranges() {
    let schema = schema();
    let experiments = schema["$defs"]["ExperimentChoice"]["oneOf"].as_array().expect("a list");
    assert!(experiments.iter().any(|entry| entry["properties"]["name"]["const"] == "selftest"));
    let density = &schema["$defs"]["Material"]["properties"]["density_kg_m3"];
    assert_eq!((density["exclusiveMinimum"].as_i64(), density["type"].as_str()), (Some(0), Some("number")));
    assert_eq!(schema["additionalProperties"], false);
}

#[test]
fn every_committed_scene_can_be_read() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    for root in ["scenes", "tests/selftest"] {
        let scenes =
            validation::scene::selection::read_all(&package.join(root)).unwrap_or_else(|e| panic!("{e}"));
        assert!(!scenes.is_empty(), "{root}");
    }
}
