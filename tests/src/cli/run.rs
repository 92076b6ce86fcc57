//! `run`: one scene file, validated or not.

mod folder;
mod physics;
mod splats;

use super::arguments::RunOptions;
use super::{CliError, print};
use crate::experiment::{Clock, ExperimentError, Point};
use crate::runner::output;
use crate::scene::physics::Format;
use crate::scene::{Scene, SceneFile};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(crate) fn run(options: &RunOptions) -> Result<u8, CliError> {
    let scene = Scene::read(&options.scene)?;
    let validation = scene.file.validation.as_ref();
    // A validation scene is run where its claim is judged: at the last point of its ladder.
    let ladder =
        validation.and_then(|validation| validation.ladder.values.last()).map_or(1.0, |value| value.value());
    let first = scene.experiment.methods().first().copied().unwrap_or_default();
    let method = validation.and_then(|validation| validation.methods.first()).map_or(first, String::as_str);
    let file = scene.at(ladder, method)?;
    let folder = options.out.clone().unwrap_or_else(|| default_output(&scene));
    match file.experiment {
        None if file.splats.is_some() => splats::run(&scene, &file, options, &folder),
        None => physics::run(&scene, &file, options, &folder),
        Some(_) => experiment(&scene, &file, options, (method, ladder), &folder),
    }
}

/// What stopped a scene, with the place in its file where that is what is wrong.
fn failure(scene: &Scene, error: ExperimentError) -> CliError {
    match error {
        ExperimentError::Refused { key, reason } => CliError::Scene(scene.refusal(key, reason)),
        other => CliError::Run { scene: scene.path.display().to_string(), reason: other.to_string() },
    }
}

/// What is written: as the command line says, or the scene, or as usual.
fn formats<'a>(options: &'a RunOptions, file: &'a SceneFile, usual: &'a [Format]) -> &'a [Format] {
    match (&options.export[..], &file.output) {
        ([], Some(output)) => &output.formats[..],
        ([], None) => usual,
        (asked, _) => asked,
    }
}

fn experiment(
    scene: &Scene,
    file: &SceneFile,
    options: &RunOptions,
    (method, ladder): (&str, f64),
    folder: &Path,
) -> Result<u8, CliError> {
    let stopped = |reason: String| CliError::Run { scene: scene.path.display().to_string(), reason };
    let unavailable = [
        ("--steps", options.steps.is_some()),
        ("--checkpoint-every", options.checkpoint_every.is_some()),
        ("--resume", options.resume.is_some()),
        ("--export", !options.export.is_empty()),
    ];
    if let Some((option, _)) = unavailable.iter().find(|(_, asked)| *asked) {
        return Err(stopped(format!("{option} has no effect on a scene with an `[experiment]`")));
    }
    output::make_folder(folder)?;
    let point = Point {
        scene: file,
        folder: options.scene.parent().unwrap_or(Path::new(".")),
        ladder,
        method,
        seed: 0,
        threads: std::thread::available_parallelism().map_or(1, usize::from),
        frames: Some((folder, "frame")),
    };
    let mut clock = Clock::default();
    let start = Instant::now();
    let outcome = scene.experiment.run(&point, &mut clock).map_err(|error| failure(scene, error))?;
    let seconds = clock.work().unwrap_or_else(|| start.elapsed()).as_secs_f64();
    let mut summary =
        format!("scene    {}\nmethod   {method} at {ladder}\ntime     {seconds:.3} s\n", scene.name);
    for (name, value) in outcome.errors.iter().chain(&outcome.invariants) {
        // Writing to a string does not fail.
        let _ = writeln!(summary, "{name:8} {value:.6e}");
    }
    for (name, count) in &outcome.counts {
        let _ = writeln!(summary, "{name:8} {count}");
    }
    output::write_file(&folder.join("summary.txt"), summary.as_bytes())?;
    print(&format!("{summary}files    {}\n", folder.display()))?;
    Ok(0)
}

fn default_output(scene: &Scene) -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let stem = scene.path.file_stem().unwrap_or_default();
    package.parent().unwrap_or(package).join("target/run").join(stem)
}
