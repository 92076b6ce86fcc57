//! What can be asked for on the command line.

use crate::scene::physics;
use crate::scene::selection::Shard;
use crate::scene::validation::Suite;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

const EXIT_CODES: &str = "Exit codes: 0 all checks passed · 1 an accuracy, order or invariant check failed · 2 usage or \
    scene-file error · 3 only the baseline is not met · 4 results differ between thread counts · 5 a scene crashed \
    (the others still ran) · 130 interrupted (partial report written; --resume goes on)";

/// Speed against error, scene by scene.
#[derive(Debug, Parser)]
#[command(name = "validation", about, after_help = EXIT_CODES)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Runs validation scenes, judges them, and writes the report.
    #[command(after_help = EXIT_CODES)]
    Validate(Box<ValidateOptions>),
    /// Makes one report of the reports of several shards.
    #[command(after_help = EXIT_CODES)]
    Merge(MergeOptions),
    /// Runs one scene file.
    Run(RunOptions),
    /// Prints docs/VALIDATION.md: what each scene claims and how it is judged.
    Guide,
    /// Writes docs/GALLERY.md, and takes pictures for it from reports.
    Gallery(GalleryOptions),
    /// Prints the JSON Schema of scene files.
    Schema,
    /// How the suite starts itself, one row a process.
    #[command(hide = true)]
    Child { job: String },
}

// Flags of a command line are there or not.
#[allow(clippy::struct_excessive_bools)]
#[derive(Debug, Args)]
pub(crate) struct ValidateOptions {
    /// Which scenes, and how much of their ladders [default: quick; with --scene, whatever suite it is in].
    #[arg(long, value_enum)]
    pub(crate) suite: Option<Suite>,
    /// Only scenes whose name (crate/file) matches; `*` stands for any text.
    #[arg(long, value_name = "GLOB")]
    pub(crate) scene: Vec<String>,
    /// Only scenes of this crate.
    #[arg(long = "crate", value_name = "NAME")]
    pub(crate) crates: Vec<String>,
    /// At most N points of each ladder, the coarsest.
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub(crate) ladder: Option<usize>,
    /// Timed runs a row; with more than one there is a warm-up before them.
    #[arg(long, value_name = "R", value_parser = at_least_one)]
    pub(crate) repeat: Option<usize>,
    /// Numbers of threads; results must have the same bits for all of them.
    #[arg(long, value_name = "1,2", value_delimiter = ',', value_parser = at_least_one)]
    pub(crate) threads: Vec<usize>,
    /// No row starts later than this: 90s, 5m, 1h.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub(crate) time_budget: Option<Duration>,
    /// Part i of n of the selected scenes, for several machines; `merge` joins the reports.
    #[arg(long, value_name = "i/n")]
    pub(crate) shard: Option<Shard>,
    /// Takes over finished scenes of an earlier run with the same settings and program.
    #[arg(long, value_name = "DIR")]
    pub(crate) resume: Option<PathBuf>,
    /// The report's folder [default: target/validation, or that of --resume].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// The baseline to compare with, or `none` [default: tests/baseline.json with the committed scenes].
    #[arg(long, value_name = "FILE|none")]
    pub(crate) baseline: Option<PathBuf>,
    /// Takes the results of scenes that pass into the baseline.
    #[arg(long)]
    pub(crate) update_baseline: bool,
    /// What is printed.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    pub(crate) format: Format,
    /// Neither plots nor pictures.
    #[arg(long)]
    pub(crate) no_plots: bool,
    /// Opens the report in the browser.
    #[arg(long)]
    pub(crate) open: bool,
    /// Lists the selected scenes and runs none.
    #[arg(long)]
    pub(crate) list: bool,
    /// Tells what a scene claims and how it is judged, and runs none.
    #[arg(long, value_name = "SCENE")]
    pub(crate) explain: Option<String>,
    /// The folder of scenes, one subfolder a crate [default: the committed ones].
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct MergeOptions {
    /// Report folders of all shards.
    #[arg(required = true, value_name = "DIR")]
    pub(crate) reports: Vec<PathBuf>,
    /// The folder of the joined report [default: target/validation].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// What is printed.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    pub(crate) format: Format,
    /// No plot files.
    #[arg(long)]
    pub(crate) no_plots: bool,
}

#[derive(Debug, Args)]
pub(crate) struct GalleryOptions {
    /// Report folders to take pictures from; without any the page is made of the pictures that are there.
    #[arg(value_name = "DIR")]
    pub(crate) reports: Vec<PathBuf>,
    /// The folder of the page [default: the workspace's docs].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct RunOptions {
    /// The scene file.
    #[arg(value_name = "SCENE.toml")]
    pub(crate) scene: PathBuf,
    /// The folder for frames, diagnostics.csv and the summary; it appears when all is done, and replaces only that of
    /// an earlier run [default: target/run/SCENE].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// At most so many steps.
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub(crate) steps: Option<usize>,
    /// A checkpoint every N steps, in the folder DIR.checkpoints, which outlives a run that fails.
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub(crate) checkpoint_every: Option<usize>,
    /// Goes on from a checkpoint of the same problem; solver and output may differ.
    #[arg(long, value_name = "CHECKPOINT")]
    pub(crate) resume: Option<PathBuf>,
    /// The formats of frames, instead of what the scene says.
    #[arg(long, value_delimiter = ',', value_parser = frame_format)]
    pub(crate) export: Vec<physics::Format>,
}

/// What is printed on standard output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// A table.
    Human,
    /// The whole report.
    Json,
    /// What continuous-integration services read.
    Junit,
}

fn at_least_one(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err("must be a whole number ≥ 1".to_owned()),
    }
}

fn duration(text: &str) -> Result<Duration, String> {
    let wrong = || format!("`{text}` is not a time: must be a number with s, m or h, such as 90s");
    let (number, unit) = match text.strip_suffix(['s', 'm', 'h']) {
        Some(number) => (number, text.chars().last()),
        None => (text, Some('s')),
    };
    let factor = match unit {
        Some('m') => 60.0,
        Some('h') => 3600.0,
        _ => 1.0,
    };
    let seconds = number.parse::<f64>().map_err(|_| wrong())? * factor;
    Duration::try_from_secs_f64(seconds).map_err(|_| wrong())
}

fn frame_format(text: &str) -> Result<physics::Format, String> {
    use serde::Deserialize;
    use serde::de::IntoDeserializer;
    use serde::de::value::{Error, StrDeserializer};
    let name: StrDeserializer<'_, Error> = text.into_deserializer();
    physics::Format::deserialize(name).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_declaration_is_consistent() {
        use clap::CommandFactory;
        Arguments::command().debug_assert();
    }

    #[test]
    fn times_have_units() {
        assert_eq!(duration("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("1.5m"), Ok(Duration::from_secs(90)));
        assert_eq!(duration("1h"), Ok(Duration::from_secs(3600)));
        assert_eq!(duration("0"), Ok(Duration::ZERO));
        for wrong in ["", "s", "-1s", "5d", "NaN", "infs", "1e30h"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn formats_are_those_of_scene_files() {
        assert_eq!(frame_format("vtu"), Ok(physics::Format::Vtu));
        assert!(frame_format("bmp").is_err_and(|message| message.contains("expected one of")));
    }
}
