//! The program `validation`; `cargo xtask validate` builds and starts it.

use clap::Parser;
use std::process::ExitCode;
use validation::cli::{Arguments, main as run};

fn main() -> ExitCode {
    run(Arguments::parse())
}
