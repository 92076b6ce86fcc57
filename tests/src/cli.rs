//! The command line: what can be asked for, and its answers.

mod arguments;
mod run;
mod validate;

pub use arguments::Arguments;

use crate::runner::job::Job;
use crate::runner::output::OutputError;
use crate::scene::SceneError;
use arguments::{Command, GalleryOptions};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Wrong usage, a scene file that cannot be used, or an output folder that cannot be written.
pub const USAGE_ERROR: u8 = 2;

/// Why a command could not do its work.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// A scene cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The output folder, the baseline or an earlier result cannot be used.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A report cannot be written.
    #[error(transparent)]
    Report(#[from] crate::report::WriteError),
    /// A report of an earlier run cannot be read.
    #[error(transparent)]
    Read(#[from] crate::report::ReadError),
    /// The gallery cannot be made.
    #[error(transparent)]
    Gallery(#[from] crate::report::GalleryError),
    /// Reports do not belong together.
    #[error(transparent)]
    Merge(#[from] crate::report::MergeError),
    /// A value of a report cannot be written as JSON.
    #[error("the report cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The program cannot find itself.
    #[error("this program's own file cannot be found, and it runs each row in a process of its own: {0}")]
    Program(std::io::Error),
    /// The answer cannot be written.
    #[error("cannot write to standard output: {0}")]
    StandardOutput(std::io::Error),
    /// Nothing was selected.
    #[error("{asked} selects no scene of the {known} there are; `--list` shows them")]
    NothingSelected {
        /// What was asked for.
        asked: String,
        /// How many scenes there are.
        known: usize,
    },
    /// The scene cannot be run yet, or stopped.
    #[error("{scene}: {reason}")]
    Run {
        /// The scene.
        scene: String,
        /// Why.
        reason: String,
    },
    /// The output folder holds something that is not of an earlier run.
    #[error(
        "{} is not empty and holds `{}`, which no run has written: choose another folder with --out",
        folder.display(), file.display()
    )]
    Occupied {
        /// The folder.
        folder: PathBuf,
        /// The file in it.
        file: PathBuf,
    },
    /// A child process was started by hand.
    #[error("`child` is how this program starts itself: its argument is one JSON job ({0})")]
    Job(serde_json::Error),
}

/// Does what was asked for and answers the exit code.
pub fn main(arguments: Arguments) -> ExitCode {
    let answer = match arguments.command {
        Command::Validate(options) => validate::validate(&options),
        Command::Merge(options) => validate::merge(&options),
        Command::Run(options) => run::run(&options),
        Command::Guide => guide(),
        Command::Gallery(options) => gallery(&options),
        Command::Schema => schema(),
        Command::Child { job } => child(&job),
    };
    match answer {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            // Nothing is left to do when standard error is closed as well.
            let _ = writeln!(std::io::stderr(), "error: {error}");
            ExitCode::from(USAGE_ERROR)
        }
    }
}

fn print(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        // `validation … | head` has read enough.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(CliError::StandardOutput),
    }
}

fn note(text: &str) {
    // A closed standard error is no reason to stop.
    let _ = writeln!(std::io::stderr(), "{text}");
}

fn guide() -> Result<u8, CliError> {
    let scenes = crate::scene::selection::read_all(&validate::committed_scenes())?;
    print(&crate::report::guide(&crate::runner::claims(&scenes)))?;
    Ok(0)
}

fn gallery(options: &GalleryOptions) -> Result<u8, CliError> {
    let docs = options.out.clone().unwrap_or_else(validate::documentation);
    for folder in &options.reports {
        let report = crate::report::read_report(&folder.join("report.json"))?;
        crate::report::take_pictures(&report, folder, &docs)?;
    }
    let scenes = crate::scene::selection::read_all(&validate::committed_scenes())?;
    let page = crate::report::gallery(&crate::runner::claims(&scenes), &docs);
    crate::report::write_file(&docs.join("GALLERY.md"), page.as_bytes())?;
    Ok(0)
}

fn schema() -> Result<u8, CliError> {
    print(&format!("{}\n", serde_json::to_string_pretty(&crate::scene::schema())?))?;
    Ok(0)
}

fn child(job: &str) -> Result<u8, CliError> {
    crate::runner::end_with_parent();
    let job: Job = serde_json::from_str(job).map_err(CliError::Job)?;
    let result = job.run()?;
    print(&format!("\n{}\n", serde_json::to_string(&result)?))?;
    Ok(0)
}
