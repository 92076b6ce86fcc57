//! Every rule finds its planted violation, keeps quiet where nothing is wrong, and the real workspace is tidy.

use super::source::Source;
use super::workspace::{File, Workspace};
use super::{Exception, Finding, RULES, Severity, check};
use std::collections::BTreeSet;
use std::path::Path;

fn workspace(files: &[(&str, &str)]) -> Workspace {
    let files = files.iter().map(|(path, text)| File::new(path, text)).collect();
    Workspace { files, others: BTreeSet::new(), top_level: vec![], crate_folders: vec![] }
}

/// What one rule alone finds.
fn found(rule: &str, workspace: &Workspace) -> Vec<Finding> {
    let rule =
        RULES.iter().find(|known| known.name == rule).unwrap_or_else(|| panic!("there is no rule `{rule}`"));
    (rule.check)(workspace)
}

/// A rule, the file with the violation, and the line where it must be found.
struct Planted {
    rule: &'static str,
    path: &'static str,
    text: String,
    line: usize,
}

fn planted(rule: &'static str, path: &'static str, text: impl Into<String>, line: usize) -> Planted {
    Planted { rule, path, text: text.into(), line }
}

const CORE: &str = "crates/mechanics-core/src/newton.rs";

fn planted_violations() -> Vec<Planted> {
    let manifest =
        |name: &str, rest: &str| format!("[package]\nname = \"{name}\"\n{rest}\n[lints]\nworkspace = true\n");
    let lagrangian = "crates/lagrangian/Cargo.toml";
    let long_function = format!("fn long() {{\n{}}}\n", "    let x = 1;\n".repeat(101));
    vec![
        planted(
            "arrows",
            lagrangian,
            manifest("lagrangian", "[dependencies]\nipc-contact.workspace = true"),
            4,
        ),
        planted("arrows", lagrangian, manifest("lagrangian", "[dependencies.ipc-contact]\npath = \"x\""), 3),
        planted(
            "arrows",
            lagrangian,
            manifest(
                "lagrangian",
                "[target.'cfg(unix)'.dependencies]\nc = { package = \"ipc-contact\", path = \"x\" }",
            ),
            4,
        ),
        planted(
            "arrows",
            lagrangian,
            manifest("lagrangian", "[build-dependencies]\nmpm-core = { path = \"x\" }"),
            4,
        ),
        planted(
            "dependants",
            "tests/dependants/lagrangian/Cargo.toml",
            "[workspace]\n[dependencies]\nlagrangian = \"1\"\nnalgebra = \"1\"\n",
            2,
        ),
        planted(
            "dependants",
            "tests/dependants/lagrangian/Cargo.toml",
            "[dependencies]\nlagrangian = \"1\"\n",
            1,
        ),
        planted("arrows", "crates/new/Cargo.toml", manifest("new", ""), 2),
        planted("arrows", lagrangian, "[package\n", 1),
        planted(
            "heavy-dependencies",
            lagrangian,
            manifest("lagrangian", "[dependencies]\nfaer = \"0.24\""),
            4,
        ),
        planted("heavy-dependencies", lagrangian, manifest("lagrangian", "[dependencies]\nrayon = \"1\""), 4),
        planted("lints", lagrangian, "[package]\nname = \"lagrangian\"\n", 1),
        planted("lints", "Cargo.toml", "[workspace.lints.rust]\nmissing_docs = \"allow\"\n", 2),
        planted("walls", CORE, "//! faer\n\nuse faer::Mat;\n", 3),
        planted("walls", "crates/lagrangian/src/lib.rs", "use rayon::prelude::*;\n", 1),
        planted("walls", "crates/mechanics-core/src/lib.rs", "type M = ::faer_entity::M;\n", 1),
        planted("walls", "crates/lagrangian/src/lib.rs", "fn a() { ::rayon::join(b, c) }\n", 1),
        planted("file-length", CORE, "//\n".repeat(801), 801),
        planted("function-length", CORE, format!("\n{long_function}"), 2),
        planted(
            "function-length",
            "tests/src/lib.rs",
            long_function.replace("long()", "long<F: Fn() -> bool>(f: F)"),
            1,
        ),
        planted("bool-parameters", CORE, "impl A {\n    pub fn solve(&self, verbose: bool) {}\n}\n", 2),
        planted(
            "bool-parameters",
            CORE,
            "pub(crate) fn a<F: Fn(f64) -> bool>(\n    f: F,\n    flag: &bool,\n) {}\n",
            1,
        ),
        planted("documented", CORE, "\n#![allow(missing_docs)]\n", 2),
        planted("lifted-lints", CORE, "\n#[allow(clippy::unwrap_used)]\nfn a() {}\n", 2),
        planted("lifted-lints", CORE, "#![expect(clippy::too_many_lines)]\n", 1),
        planted("lints", "Cargo.toml", "[workspace.lints.rust]\nunsafe_code = \"warn\"\n", 2),
        planted("to-do", CORE, "fn a() {} // TODO: later\n", 1),
        planted("to-do", CORE, "/* one\n FIXME(nobody) */\n", 2),
        planted("printing", CORE, "fn a() {\n    println!(\"{}\", 1);\n}\n", 2),
        planted("printing", CORE, "fn a() { eprint!(\"\") }\n", 1),
        planted("printing", CORE, "\nfn a() { writeln!(std::io::stdout()); }\n", 2),
        planted("files", CORE, "use std::{\n    fs,\n};\n", 2),
        planted("files", "crates/lagrangian/src/checkpoint.rs", "use std::fs::File;\n", 1),
        planted("hash-maps", CORE, "use std::collections::HashMap;\n", 1),
        planted("atomics", CORE, "use std::sync::atomic::AtomicU64;\n", 1),
        planted("unsafe", CORE, "fn a() {\n    unsafe { b() }\n}\n", 2),
        planted("unsafe", CORE, "#![allow(unsafe_code)]\n", 1),
        planted("ignored-tests", "tests/src/lib.rs", "#[test]\n#[ignore = \"slow\"]\nfn a() {}\n", 2),
        planted("ignored-tests", "tests/src/lib.rs", "#[test]\n#[ ignore ]\nfn a() {}\n", 2),
        planted("ignored-tests", CORE, "#[cfg_attr(unix, ignore)]\n#[test]\nfn a() {}\n", 1),
        planted("module-names", "crates/lagrangian/src/utils.rs", "", 1),
        planted("module-names", "crates/lagrangian/src/helpers/sort.rs", "", 1),
        planted("module-names", "crates/lagrangian/src/rod/mod.rs", "", 1),
        planted("module-names", CORE, "\npub mod prelude {}\n", 2),
        planted("broken-links", "docs/NOTATION.md", "see\n[there](gone.md#a)\n", 2),
        planted("broken-links", "README.md", "# A b\n[here](#a-c), [there](#a-b)\n", 2),
        planted("notation", "docs/NOTATION.md", "| symbol | code |\n|---|---|\n| \\|x\\| | `gone` |\n", 3),
        planted("gallery", "tests/scenes/a/b.toml", "[experiment]\n[validation]\n", 1),
        planted("equations", "docs/theory/a.md", "# A\n```math\na\n```\nb\n## B\n[`c`](c.rs)\n", 2),
        planted("equations", "docs/theory/a.md", "[`c`](c.rs)\n```math\na\n```\n", 2),
    ]
}

#[test]
fn every_planted_violation_is_found_where_it_is() {
    for Planted { rule, path, text, line } in planted_violations() {
        let findings = found(rule, &workspace(&[(path, &text)]));
        let hit = findings.iter().any(|finding| finding.path == path && finding.line == line);
        assert!(hit, "`{rule}` must find line {line} of {path}:\n{text}\nbut found {findings:?}");
        assert!(findings.iter().all(|finding| finding.severity == Severity::Error));
    }
}

#[test]
fn every_rule_has_a_planted_violation() {
    let mut tried: BTreeSet<&str> = planted_violations().iter().map(|planted| planted.rule).collect();
    // These look at folders or at two files, and have tests of their own below.
    tried.extend(["top-level", "crate-folders", "rows"]);
    let rules: BTreeSet<&str> = RULES.iter().map(|rule| rule.name).collect();
    assert_eq!(rules, tried);
}

#[test]
fn an_entry_that_is_not_designed_is_found_at_the_top() {
    let mut plan = workspace(&[]);
    plan.top_level = ["Cargo.toml", ".ci", "docs", "notes.txt"].map(str::to_owned).to_vec();
    let findings = found("top-level", &plan);
    assert_eq!(findings.iter().map(|finding| finding.path.as_str()).collect::<Vec<_>>(), ["notes.txt"]);
}

#[test]
fn a_crate_without_readme_or_plan_is_found() {
    let mut plan = workspace(&[
        ("crates/lagrangian/README.md", "# lagrangian\n\nNothing yet.\n"),
        ("crates/mpm-core/README.md", "# mpm-core\n"),
    ]);
    plan.crate_folders = ["lagrangian", "mpm-core", "fluid"].map(str::to_owned).to_vec();
    let findings = found("crate-folders", &plan);
    let paths: Vec<_> = findings.iter().map(|finding| finding.path.as_str()).collect();
    assert_eq!(paths, ["crates/mpm-core/README.md", "crates/fluid", "crates/fluid/README.md"]);
}

#[test]
fn what_is_allowed_is_left_alone() {
    let parser = "crates/mechanics-core/src/mesh/io/obj.rs";
    let innocent = workspace(&[
        ("crates/mechanics-core/src/linear/supernodal.rs", "use faer::sparse;\nlet p = Par::rayon(2);\n"),
        ("crates/mechanics-core/src/parallel.rs", "use rayon::prelude::*;\n"),
        ("crates/ipc-contact/src/tree.rs", "use parry3d::bounding_volume::Aabb;\n"),
        ("crates/mpm-core/src/collider.rs", "use parry3d::shape::Cuboid;\n"),
        (
            CORE,
            "//! Not faer, rayon or HashMap: see `std::fs`. println!(\"{}\")\n/// unsafe\nfn a() { b(\"unsafe fs HashMap\") }\n",
        ),
        (
            "crates/mechanics-core/src/jet.rs",
            "// TODO(#12): more\nimpl S for f64 { fn select(mask: bool) {} }\n",
        ),
        (
            "crates/mechanics-core/src/mask.rs",
            "pub fn a(f: impl Fn(usize) -> bool, b: &[bool; 3]) -> bool { true }\n",
        ),
        (
            parser,
            "use std::fs;\n#[cfg(test)]\nmod tests {\n    use std::collections::HashMap;\n    fn a() { println!() }\n}\n",
        ),
        ("crates/mpm-core/src/scan.rs", "#[inline]\nfn ignore(ignore: u8) -> [u8; 1] { [ignore] }\n"),
        (
            "crates/mechanics-core/tests/print.rs",
            "#![allow(clippy::unwrap_used)]\nfn a() { println!(); std::fs::read(b); }\n",
        ),
        (
            "crates/ipc-friction/Cargo.toml",
            "[package]\nname = \"ipc-friction\"\n[dependencies]\nipc-contact.path = \"x\"\n\
             [dev-dependencies]\nlagrangian.path = \"x\"\n[lints]\nworkspace = true\n",
        ),
    ]);
    assert_eq!(check(&innocent, &[]), []);
}

#[test]
fn a_link_to_an_item_that_its_file_does_not_define_is_found() {
    let code = "//! Lost.\nenum Kind { One }\nfn found(lost: u8) {}\nmacro_rules! made { () => {} }\n";
    let link = |item: &str| format!("[`{item}`](../crates/lagrangian/src/a.rs)");
    for (item, broken) in [
        ("found", false),
        ("found()", false),
        ("Kind<3>", false),
        ("made", false),
        ("Kind::One", false),
        ("lost", true),
        ("Kind::Two", true),
    ] {
        let page = format!("{}\n```text\n{}\n```\n", link(item), link("in a fence"));
        let plan = workspace(&[("docs/a.md", &page), ("crates/lagrangian/src/a.rs", code)]);
        assert_eq!(found("broken-links", &plan).len(), usize::from(broken), "{item}");
    }
}

#[test]
fn a_second_file_behind_a_wall_is_found() {
    let two = workspace(&[
        ("crates/mechanics-core/src/linear/a.rs", "use faer::Mat;\n"),
        ("crates/mechanics-core/src/linear/b.rs", "\nuse faer::Mat;\n"),
        ("crates/ipc-contact/src/a.rs", "use parry3d::a;\n"),
        ("crates/ipc-contact/src/b.rs", "use parry3d_f64::b;\n"),
    ]);
    let findings = found("walls", &two);
    let places: Vec<_> = findings.iter().map(|finding| (finding.path.as_str(), finding.line)).collect();
    assert_eq!(places, [("crates/mechanics-core/src/linear/b.rs", 2), ("crates/ipc-contact/src/b.rs", 1)]);
}

#[test]
fn a_long_file_is_a_warning_before_it_is_an_error() {
    let findings = found("file-length", &workspace(&[(CORE, &"//\n".repeat(700))]));
    assert_eq!(findings.len(), 1);
    assert_eq!(findings[0].severity, Severity::Warning);
    assert_eq!(found("file-length", &workspace(&[(CORE, &"//\n".repeat(600))])), []);
}

#[test]
fn a_function_at_the_limit_passes_and_comments_do_not_count() {
    let body = format!("{}{}", "    let x = 1;\n".repeat(100), "    // why\n\n".repeat(50));
    let text = format!("fn a() -> [f64; 3]\nwhere\n    u8: Copy,\n{{\n{body}}}\nfn b() {{}}\n");
    assert_eq!(found("function-length", &workspace(&[(CORE, &text)])), []);
}

#[test]
fn an_exception_covers_its_rule_and_file_and_may_not_outlive_them() {
    let exception = |rule, path| Exception { rule, path, reason: "measured" };
    let plan = workspace(&[(CORE, "fn a() { unsafe { b() } }\n")]);
    assert_eq!(check(&plan, &[exception("unsafe", CORE)]), []);
    assert_eq!(check(&plan, &[exception("printing", CORE)]).len(), 2);
    let stale = check(&plan, &[exception("unsafe", CORE), exception("unsafe", "crates/gone.rs")]);
    assert_eq!(stale.len(), 1);
    assert!(stale[0].message.contains("crates/gone.rs"), "{}", stale[0]);
}

#[test]
fn findings_print_as_places_that_an_editor_can_jump_to() {
    assert_eq!(Finding::error("a/b.rs", 7, "no").to_string(), "a/b.rs:7: no");
    assert_eq!(Finding::warning("a/b.rs", 7, "look").to_string(), "a/b.rs:7: warning: look");
}

#[test]
fn code_and_comments_are_told_apart() {
    let text = concat!(
        "a /* b /* c */ d */ e // f\n",
        "\"g // \\\" h\" i r#\"j \" k\"# l b'm' 'n' '\\'' '\\u{6f}' o\n",
        "fn p<'q>(r: &'q str) {} // é s\n",
        "br\"t\" u c\"v\" r#fn w 'é' x\n"
    );
    let source = Source::new(text);
    let words = |view: &str| super::source::words(view).map(|(_, word)| word.to_owned()).collect::<Vec<_>>();
    // The prefixes of literals stay as words; no rule is about them.
    let code =
        ["a", "e", "i", "l", "b", "o", "fn", "p", "q", "r", "q", "str", "b", "u", "c", "r", "fn", "w", "x"];
    assert_eq!(words(&source.code), code.map(str::to_owned));
    assert_eq!(words(&source.comments), ["b", "c", "d", "f", "s"].map(str::to_owned));
    assert_eq!(source.code.len(), text.len());
    assert_eq!(source.code.lines().count(), text.lines().count());
}

#[test]
fn an_unclosed_literal_or_comment_does_no_harm() {
    for text in ["\"a", "/* a", "r#\"a", "'", "'\\", "b'", "fn", "fn a(", "fn a<", "#[cfg(test)]", "\\", "é"]
    {
        let plan = workspace(&[(CORE, text)]);
        for rule in RULES {
            (rule.check)(&plan);
        }
    }
}

#[test]
fn the_workspace_is_tidy() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let workspace = Workspace::load(&root).expect("the workspace can be read");
    assert!(workspace.files.len() > 20, "the workspace has {} files", workspace.files.len());
    let findings = check(&workspace, super::EXCEPTIONS);
    let errors: Vec<String> = findings
        .iter()
        .filter(|finding| finding.severity == Severity::Error)
        .map(Finding::to_string)
        .collect();
    assert!(errors.is_empty(), "\n{}", errors.join("\n"));
}

#[test]
fn a_module_that_uses_what_stands_below_is_found() {
    let page = "## Inside mpm-core\n\n| `grid`, `kernel` | a |\n|---|---|\n| `body` (`travel`) | b |\n\n## Seams\n`late`\n";
    let body = "use crate::grid::Grid;\nuse crate::{kernel, late::Late};\n";
    let found_with = |grid: &str| {
        let files = [
            ("docs/ARCHITECTURE.md", page),
            ("crates/mpm-core/src/lib.rs", "mod body;\n"),
            ("crates/mpm-core/src/body.rs", body),
            ("crates/mpm-core/src/grid/field.rs", grid),
        ];
        let findings = found("rows", &workspace(&files));
        findings.into_iter().map(|finding| (finding.path, finding.line)).collect::<Vec<_>>()
    };
    let field = "crates/mpm-core/src/grid/field.rs".to_owned();
    assert_eq!(found_with("use crate::{MpmError, kernel::{Kernel, body}};\n"), []);
    assert_eq!(found_with("#[cfg(test)]\nmod tests {\n    use crate::body::Body;\n}\n"), []);
    assert_eq!(found_with("\nfn a(b: &crate::body::Body) {}\n"), [(field.clone(), 2)]);
    assert_eq!(found_with("use crate::{\n    kernel::{Kernel, Width},\n    body,\n};\n"), [(field, 3)]);
}

#[test]
fn a_module_that_its_section_does_not_name_is_found() {
    let files = [
        ("docs/ARCHITECTURE.md", "# A\n\n## Inside mpm-core\n\n| `grid` | a |\n\n`words` too.\n"),
        ("crates/mpm-core/src/error.rs", ""),
        ("crates/mpm-core/src/grid.rs", ""),
        ("crates/mpm-core/src/words.rs", ""),
        ("crates/mpm-core/src/grid/field.rs", ""),
        ("crates/mpm-core/src/unknown.rs", ""),
    ];
    let findings = found("rows", &workspace(&files));
    assert_eq!(findings.len(), 1);
    assert_eq!((findings[0].path.as_str(), findings[0].line), ("docs/ARCHITECTURE.md", 3));
    assert!(findings[0].message.contains("`unknown`"));
}
