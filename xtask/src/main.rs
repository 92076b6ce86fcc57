//! The front door of the workspace: `cargo xtask COMMAND`.
//!
//! It links no solver, so it compiles in seconds and physics never runs in a debug build by accident.

// A command-line program talks on its standard streams.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod dependants;
mod tidy;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const USAGE: &str = "\
cargo xtask COMMAND

  tidy      check the architecture's invariants; one `file:line: what and why` each, exit 1 if any is broken
  ci        run .ci/run, the gate that every change passes
  dependants [--check] [CRATE…]
            build and run a program that depends on one solver crate alone, for each, from nothing, and say what that compiles and
            how long it takes; with --check as debug builds in one folder
  fuzz [S]  mutate what every reader of files reads, each for S seconds (60); a failing input is written to the temporary folder
  bench     measure the kernels of mechanics-core; further arguments go to `cargo bench -p mechanics-core`
  validate  speed against error over the validation scenes; `cargo xtask validate --help` has the options
  merge     join the reports of several shards of `validate`
  run       run one scene file
  guide     print docs/VALIDATION.md: what every scene claims
  gallery   write docs/GALLERY.md; with report folders, take pictures for it from there
  schema    print the JSON Schema of scene files, for editors";

/// Wrong usage.
const USAGE_ERROR: u8 = 2;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = workspace_root();
    match arguments.split_first() {
        Some((command, rest)) => match (command.as_str(), rest) {
            ("tidy", []) => tidy(&root),
            ("ci", []) => spawn(Command::new("bash").arg(".ci/run").current_dir(&root)),
            ("dependants", rest) => dependants(&root, rest),
            ("bench", rest) => bench(&root, rest),
            ("fuzz", []) => fuzz(&root, "60"),
            ("fuzz", [seconds]) if seconds.parse::<f64>().is_ok_and(|s| s > 0.0 && s.is_finite()) => {
                fuzz(&root, seconds)
            }
            ("validate" | "merge" | "run" | "guide" | "gallery" | "schema", _) => {
                validation(&root, &arguments)
            }
            ("help" | "--help" | "-h", _) => {
                println!("{USAGE}");
                ExitCode::SUCCESS
            }
            _ => usage_error(),
        },
        None => usage_error(),
    }
}

/// This package's manifest stands one folder below the workspace's. `cargo run` says where, also when the program
/// was built in another clone with the same target folder.
fn workspace_root() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR")
        .map_or_else(|| env!("CARGO_MANIFEST_DIR").into(), PathBuf::from);
    package.parent().unwrap_or(&package).to_owned()
}

fn tidy(root: &Path) -> ExitCode {
    let workspace = match tidy::Workspace::load(root) {
        Ok(workspace) => workspace,
        Err(error) => {
            eprintln!("tidy: cannot read the workspace: {error}");
            return ExitCode::from(USAGE_ERROR);
        }
    };
    let findings = tidy::check(&workspace, tidy::EXCEPTIONS);
    for finding in &findings {
        println!("{finding}");
    }
    let broken = findings.iter().filter(|finding| finding.severity == tidy::Severity::Error).count();
    println!(
        "tidy: {} rules over {} files: {broken} broken, {} warnings",
        tidy::rule_count(),
        workspace.files.len(),
        findings.len() - broken
    );
    ExitCode::from(u8::from(broken > 0))
}

fn dependants(root: &Path, arguments: &[String]) -> ExitCode {
    match dependants::run(root, arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            eprintln!("dependants: {fault}");
            ExitCode::FAILURE
        }
    }
}

fn bench(root: &Path, rest: &[String]) -> ExitCode {
    spawn(Command::new(env!("CARGO")).args(["bench", "-p", "mechanics-core"]).args(rest).current_dir(root))
}

/// The tests that hold the harnesses, one for each crate that reads files: meshes, checkpoints, splats and cameras, scenes.
const HARNESSES: [&str; 4] = ["mesh_fuzz", "ground_checkpoint", "file_fuzz", "scene"];

/// Runs the harnesses one after another, so that none takes another's time. They are built with the workspace's features, as all tests are.
fn fuzz(root: &Path, seconds: &str) -> ExitCode {
    let mut tests = Command::new(env!("CARGO"));
    tests.args(["test", "--workspace"]);
    tests.args(HARNESSES.into_iter().flat_map(|name| ["--test", name]));
    tests.args(["--", "mutations_are_survived", "arbitrary_damage", "corpus_replays"]);
    tests.args(["--test-threads", "1", "--nocapture"]);
    spawn(tests.env("FUZZ_SECONDS", seconds).current_dir(root))
}

/// Builds the program `validation` and hands over to it, with its arguments and its exit code. The profile is the one
/// that tests are built with, in which dependencies and our crates are optimised, so that faer is compiled once.
fn validation(root: &Path, arguments: &[String]) -> ExitCode {
    let mut build = Command::new(env!("CARGO"));
    build
        .args(["build", "--package", "validation", "--bin", "validation"])
        .args(["--message-format", "short"]);
    match build.current_dir(root).status() {
        Ok(status) if status.success() => {}
        // The build has said why. 1 would mean that a check failed.
        Ok(_) => return ExitCode::from(USAGE_ERROR),
        Err(error) => return cannot_start(&build, &error),
    }
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    hand_over(Command::new(target.join("debug/validation")).args(arguments))
}

/// Becomes the other program, so that signals and exit codes are its own.
#[cfg(unix)]
fn hand_over(command: &mut Command) -> ExitCode {
    use std::os::unix::process::CommandExt;
    let error = command.exec();
    cannot_start(command, &error)
}

/// Waits for the other program and answers its exit code.
#[cfg(not(unix))]
fn hand_over(command: &mut Command) -> ExitCode {
    match command.status() {
        Ok(status) => {
            status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from)
        }
        Err(error) => cannot_start(command, &error),
    }
}

fn cannot_start(command: &Command, error: &std::io::Error) -> ExitCode {
    eprintln!("cannot start {}: {error}", command.get_program().to_string_lossy());
    ExitCode::from(USAGE_ERROR)
}

fn spawn(command: &mut Command) -> ExitCode {
    match command.status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => cannot_start(command, &error),
    }
}

fn usage_error() -> ExitCode {
    eprintln!("{USAGE}");
    ExitCode::from(USAGE_ERROR)
}
