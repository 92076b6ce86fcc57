//! The front door of the workspace: `cargo xtask COMMAND`.
//!
//! It links no solver, so it compiles in seconds and physics never runs in a debug build by accident.

// A command-line program talks on its standard streams.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod tidy;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const USAGE: &str = "\
cargo xtask COMMAND

  tidy      check the architecture's invariants; one `file:line: what and why` each, exit 1 if any is broken
  ci        run .ci/run, the gate that every change passes
  bench     measure the kernels of mechanics-core; further arguments go to `cargo bench -p mechanics-core`
  validate  speed against error over the validation scenes; `cargo xtask validate --help` has the options
  merge     join the reports of several shards of `validate`
  run       run one scene file
  guide     print docs/VALIDATION.md: what every scene claims
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
            ("bench", rest) => bench(&root, rest),
            ("validate" | "merge" | "run" | "guide" | "schema", _) => validation(&root, &arguments),
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

fn bench(root: &Path, rest: &[String]) -> ExitCode {
    spawn(Command::new(env!("CARGO")).args(["bench", "-p", "mechanics-core"]).args(rest).current_dir(root))
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
