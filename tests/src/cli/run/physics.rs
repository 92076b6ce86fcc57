//! `run` of a scene's physical part: steps of load or time, frames, checkpoints, and a folder that appears whole or not at all.

use super::super::arguments::RunOptions;
use super::super::{CliError, print};
use super::folder::{Draft, check_replaceable, checkpoint_path};
use super::{failure, formats};
use crate::experiment::ExperimentError;
use crate::experiment::simulation::{CheckpointFault, Course, Recorder, Step, TimeStep};
use crate::runner::output;
use crate::scene::physics::Format;
use crate::scene::{Scene, SceneFile};
use lagrangian::stepper::TermReport;
use std::path::Path;
use std::time::{Duration, Instant};

/// What is written where a scene does not say.
const FORMATS: [Format; 3] = [Format::Vtu, Format::Png, Format::Gif];

/// Runs the physical part `file` of `scene` into `folder`.
pub(super) fn run(
    scene: &Scene,
    file: &SceneFile,
    options: &RunOptions,
    folder: &Path,
) -> Result<u8, CliError> {
    let failed = |error: ExperimentError| failure(scene, error);
    let misfit = |fault: CheckpointFault| failed(ExperimentError::stopped(fault));
    check_replaceable(folder)?;
    let scene_folder = scene.path.parent().unwrap_or(Path::new("."));
    let begin = Instant::now();
    let mut course = Course::new(file, scene_folder).map_err(failed)?;
    if let Some(checkpoint) = &options.resume {
        course.read_checkpoint(file, checkpoint).map_err(misfit)?;
    }
    let draft = Draft::new(folder)?;
    let formats = formats(options, file, &FORMATS);
    let every = file.output.as_ref().map_or(1, |output| output.frame_every.value());
    let mut recorder = Recorder::new(&draft.path, formats, &course, every);
    let last = options.steps.map_or(course.steps(), |steps| course.steps().min(course.done() + steps));
    recorder.add_frame(&course).map_err(failed)?;
    let mut steps = Vec::new();
    while course.done() < last {
        let step = course.advance().map_err(failed)?;
        let number = step.number();
        recorder.add_row(&step);
        if number % every == 0 || number == last {
            recorder.add_frame(&course).map_err(failed)?;
        }
        if options.checkpoint_every.is_some_and(|every| number % every == 0) {
            course.write_checkpoint(file, &checkpoint_path(folder, number)?).map_err(misfit)?;
        }
        steps.push(step);
    }
    recorder.finish(course.bodies()).map_err(failed)?;
    let summary = summary(scene, &course, &steps, begin.elapsed().as_secs_f64());
    output::write_file(&draft.path.join("summary.txt"), summary.as_bytes())
        .map_err(output::OutputError::from)?;
    draft.publish(folder)?;
    print(&format!("{summary}files         {}\n", folder.display()))?;
    Ok(0)
}

fn summary(scene: &Scene, course: &Course, steps: &[Step], seconds: f64) -> String {
    let mesh = course.bodies().mesh();
    let sum = |count: fn(&Step) -> u64| steps.iter().map(count).sum::<u64>();
    let kind = if matches!(steps.first(), Some(Step::Time(_))) { "time steps " } else { "load steps " };
    let mut text = format!(
        "scene         {}\nmesh          {} points, {} tetrahedra, {} unknowns\n{kind}   {} of {}\n\
         Newton        {} iterations, {} halvings, {} factorisations\ntime          {seconds:.3} s\n",
        scene.name,
        mesh.points().len(),
        mesh.cells().len(),
        course.unknowns(),
        course.done(),
        course.steps(),
        sum(|step| step.newton().iterations),
        sum(|step| step.newton().halvings),
        sum(|step| step.newton().factorisations),
    );
    match steps.last() {
        Some(Step::Load(last)) => {
            text += &format!(
                "energy        {:.6e} J\nresidual      {:.3e} N\nsmallest detF {:.6}\n\
                 displacement  {:.6e} m at most\n",
                last.energy, last.residual, last.smallest_volume_ratio, last.largest_displacement
            );
        }
        Some(Step::Time(last)) => {
            let all = steps.iter().map(Step::smallest_volume_ratio).fold(f64::INFINITY, f64::min);
            text += &format!(
                "simulated     {:.6} s\nenergy        {:.6e} J kinetic, {:.6e} J elastic, {:.6e} J of loads\n\
                 contact       {} pairs, {:.6e} J; {} searches and {} queries of pairs in all steps\nmomentum      {:.6e} {:.6e} {:.6e} kg m/s\n\
                 smallest detF {all:.6} in all steps\ndisplacement  {:.6e} m at most\n",
                last.time,
                last.kinetic,
                last.elastic,
                last.load,
                last.contacts,
                last.contact,
                timed(steps).map(|step| step.contact_searches).sum::<u64>(),
                timed(steps).map(|step| step.detection_queries).sum::<u64>(),
                last.momentum.x,
                last.momentum.y,
                last.momentum.z,
                last.largest_displacement
            );
            text += &format!("terms         {}\n", terms(steps));
        }
        None => {}
    }
    text
}

fn timed(steps: &[Step]) -> impl Iterator<Item = &TimeStep> {
    steps.iter().filter_map(|step| match step {
        Step::Time(step) => Some(step),
        Step::Load(_) => None,
    })
}

/// The terms of the incremental potential and what each of them cost: what a scene does not name is not among them.
fn terms(steps: &[Step]) -> String {
    let mut costs: Vec<(&str, Duration)> = Vec::new();
    for TermReport { name, times } in timed(steps).flat_map(|step| &step.report.terms) {
        let cost = times.value + times.gradient + times.hessian + times.limit_step + times.freeze;
        match costs.iter_mut().find(|(known, _)| known == name) {
            Some((_, sum)) => *sum += cost,
            None => costs.push((name, cost)),
        }
    }
    let each: Vec<String> =
        costs.iter().map(|(name, cost)| format!("{name} {:.3} s", cost.as_secs_f64())).collect();
    each.join(", ")
}
