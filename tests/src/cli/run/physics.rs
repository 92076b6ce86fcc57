//! `run` of a scene's physical part: load steps, frames, checkpoints, and a folder that appears whole or not at all.

use super::super::arguments::RunOptions;
use super::super::{CliError, print};
use crate::experiment::ExperimentError;
use crate::experiment::simulation::{CheckpointFault, FILES, LoadStep, LoadStepping, Recorder};
use crate::report::WriteError;
use crate::runner::output;
use crate::scene::physics::Format;
use crate::scene::{Scene, SceneFile};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What is written where a scene does not say.
const FORMATS: [Format; 3] = [Format::Vtu, Format::Png, Format::Gif];

/// Runs the physical part `file` of `scene` into `folder`.
pub(super) fn run(
    scene: &Scene,
    file: &SceneFile,
    options: &RunOptions,
    folder: &Path,
) -> Result<u8, CliError> {
    let failed = |error: ExperimentError| match error {
        ExperimentError::Refused { key, reason } => CliError::Scene(scene.refusal(key, reason)),
        other => CliError::Run { scene: scene.path.display().to_string(), reason: other.to_string() },
    };
    let misfit = |fault: CheckpointFault| failed(ExperimentError::stopped(fault));
    check_replaceable(folder)?;
    let scene_folder = scene.path.parent().unwrap_or(Path::new("."));
    let begin = Instant::now();
    let mut stepping = LoadStepping::new(file, scene_folder).map_err(failed)?;
    if let Some(checkpoint) = &options.resume {
        stepping.read_checkpoint(file, checkpoint).map_err(misfit)?;
    }
    let draft = Draft::new(folder)?;
    let formats = match (&options.export[..], &file.output) {
        ([], Some(output)) => &output.formats[..],
        ([], None) => &FORMATS,
        (asked, _) => asked,
    };
    let mut recorder = Recorder::new(&draft.path, formats);
    let first = stepping.done();
    let last = options.steps.map_or(stepping.load_steps(), |steps| stepping.load_steps().min(first + steps));
    let every = file.output.as_ref().map_or(1, |output| output.frame_every.value());
    let factor = first as f64 / stepping.load_steps() as f64;
    recorder.add_frame(stepping.bodies(), first, factor, stepping.positions()).map_err(failed)?;
    let mut steps = Vec::new();
    while stepping.done() < last {
        let step = stepping.advance().map_err(failed)?;
        recorder.add_row(&step);
        if step.number % every == 0 || step.number == last {
            recorder
                .add_frame(stepping.bodies(), step.number, step.load_factor, stepping.positions())
                .map_err(failed)?;
        }
        if options.checkpoint_every.is_some_and(|every| step.number % every == 0) {
            let path = checkpoint_path(folder, step.number)?;
            stepping.write_checkpoint(file, &path).map_err(misfit)?;
        }
        steps.push(step);
    }
    recorder.finish(stepping.bodies()).map_err(failed)?;
    let summary = summary(scene, &stepping, &steps, begin.elapsed().as_secs_f64());
    output::write_file(&draft.path.join("summary.txt"), summary.as_bytes())
        .map_err(output::OutputError::from)?;
    draft.publish(folder)?;
    print(&format!("{summary}files         {}\n", folder.display()))?;
    Ok(0)
}

/// Refuses to replace a folder with files that no run has written.
fn check_replaceable(folder: &Path) -> Result<(), CliError> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for entry in entries.flatten() {
        let name = entry.file_name();
        if !FILES.iter().any(|file| name == *file) {
            return Err(CliError::Occupied { folder: folder.to_owned(), file: name.into() });
        }
    }
    Ok(())
}

/// A folder beside the output folder that becomes it, or is removed.
struct Draft {
    path: PathBuf,
}

impl Draft {
    fn new(folder: &Path) -> Result<Self, CliError> {
        let path = beside(folder, &format!(".part.{}", std::process::id()));
        output::make_folder(&path)?;
        Ok(Self { path })
    }

    fn publish(self, folder: &Path) -> Result<(), CliError> {
        let replace = || {
            if folder.exists() {
                let old = beside(folder, &format!(".old.{}", std::process::id()));
                std::fs::rename(folder, &old)?;
                std::fs::rename(&self.path, folder).inspect_err(|_| {
                    // The first error is the one worth telling.
                    let _ = std::fs::rename(&old, folder);
                })?;
                return std::fs::remove_dir_all(&old);
            }
            std::fs::rename(&self.path, folder)
        };
        replace().map_err(|source| {
            output::OutputError::from(WriteError { path: folder.to_owned(), source }).into()
        })
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // After `publish` it is not there any more.
        let _ = std::fs::remove_dir_all(&self.path);
    }
}

/// Checkpoints stand beside the output folder, so that they outlive a run that fails.
fn checkpoint_path(folder: &Path, step: usize) -> Result<PathBuf, CliError> {
    let checkpoints = beside(folder, ".checkpoints");
    output::make_folder(&checkpoints)?;
    Ok(checkpoints.join(format!("step_{step:05}.checkpoint")))
}

fn beside(folder: &Path, ending: &str) -> PathBuf {
    let mut name = folder.file_name().unwrap_or_default().to_owned();
    name.push(ending);
    folder.with_file_name(name)
}

fn summary(scene: &Scene, stepping: &LoadStepping, steps: &[LoadStep], seconds: f64) -> String {
    let mesh = stepping.bodies().mesh();
    let sum = |count: fn(&LoadStep) -> u64| steps.iter().map(count).sum::<u64>();
    let mut text = format!(
        "scene         {}\nmesh          {} points, {} tetrahedra, {} unknowns\nload steps    {} of {}\n\
         Newton        {} iterations, {} halvings, {} factorisations\ntime          {seconds:.3} s\n",
        scene.name,
        mesh.points().len(),
        mesh.cells().len(),
        stepping.unknowns(),
        stepping.done(),
        stepping.load_steps(),
        sum(|step| step.report.iterations),
        sum(|step| step.report.halvings),
        sum(|step| step.report.factorisations),
    );
    if let Some(last) = steps.last() {
        text += &format!(
            "energy        {:.6e} J\nresidual      {:.3e} N\nsmallest detF {:.6}\ndisplacement  {:.6e} m at most\n",
            last.energy, last.residual, last.smallest_volume_ratio, last.largest_displacement
        );
    }
    text
}
