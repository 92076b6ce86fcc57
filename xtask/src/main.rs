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
  validate  speed against error over the validation scenes: not there yet (issue 3)
  run       run one scene file: not there yet (issue 3)";

/// Wrong usage, or a command that is not there yet.
const USAGE_ERROR: u8 = 2;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let root = workspace_root();
    match arguments.split_first() {
        Some((command, rest)) => match (command.as_str(), rest) {
            ("tidy", []) => tidy(&root),
            ("ci", []) => spawn(Command::new("bash").arg(".ci/run").current_dir(&root)),
            ("bench", rest) => bench(&root, rest),
            ("validate", _) => not_there_yet("validate", "the validation suite (tests/) has no scenes"),
            ("run", _) => not_there_yet("run", "the scene format and its runner (tests/) are not written"),
            ("help" | "--help" | "-h", _) => {
                println!("{USAGE}");
                ExitCode::SUCCESS
            }
            _ => usage_error(),
        },
        None => usage_error(),
    }
}

/// This package's manifest stands one folder below the workspace's.
fn workspace_root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package).to_owned()
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

fn spawn(command: &mut Command) -> ExitCode {
    match command.status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("cannot start {}: {error}", command.get_program().to_string_lossy());
            ExitCode::from(USAGE_ERROR)
        }
    }
}

fn not_there_yet(command: &str, reason: &str) -> ExitCode {
    eprintln!("cargo xtask {command} does nothing yet: {reason}; issue 3 adds it.");
    ExitCode::from(USAGE_ERROR)
}

fn usage_error() -> ExitCode {
    eprintln!("{USAGE}");
    ExitCode::from(USAGE_ERROR)
}
