//! `run` of a scene of splats: frames for editors of splats, pictures, films.

use super::super::arguments::RunOptions;
use super::super::{CliError, note, print};
use super::folder::{Draft, check_replaceable, checkpoint_path};
use super::{failure, formats};
use crate::experiment::ExperimentError;
use crate::experiment::splat_motion::{SplatRun, SplatStep};
use crate::picture::{Film, Mp4};
use crate::runner::output;
use crate::scene::physics::Format;
use crate::scene::{Scene, SceneFile};
use gaussian_deform::file::sequence::write_frame;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What is written where a scene does not say.
const FORMATS: [Format; 4] = [Format::Ply, Format::Png, Format::Gif, Format::Mp4];

/// Runs the splats of `file`, which is of `scene`, into `folder`.
pub(super) fn run(
    scene: &Scene,
    file: &SceneFile,
    options: &RunOptions,
    folder: &Path,
) -> Result<u8, CliError> {
    let failed = |error: ExperimentError| failure(scene, error);
    let formats = formats(options, file, &FORMATS);
    if let Some(format) = formats.iter().find(|format| matches!(format, Format::Vtu | Format::Obj)) {
        let reason = format!("splats are written as ply, png, gif and mp4, not as {format:?}");
        return Err(failed(ExperimentError::Refused { key: "output.formats".to_owned(), reason }));
    }
    check_replaceable(folder)?;
    let scene_folder = scene.path.parent().unwrap_or(Path::new("."));
    let begin = Instant::now();
    let mut run = SplatRun::new(file, scene_folder).map_err(failed)?;
    if let Some(checkpoint) = &options.resume {
        run.read_checkpoint(file, checkpoint).map_err(|fault| failed(ExperimentError::stopped(fault)))?;
    }
    let draft = Draft::new(folder)?;
    let every = file.output.as_ref().map_or(1, |output| output.frame_every.value());
    let mut gallery = Gallery::new(&draft.path, formats, &run, every);
    let last = options.steps.map_or(run.steps(), |steps| run.steps().min(run.done() + steps));
    gallery.add_frame(&mut run).map_err(failed)?;
    while run.done() < last {
        gallery.add_step(run.advance().map_err(failed)?);
        let number = run.done();
        if number % every == 0 || number == last {
            gallery.add_frame(&mut run).map_err(failed)?;
            note(&format!(
                "frame {} of {}, {:.1} s",
                number / every + 1,
                last / every + 1,
                begin.elapsed().as_secs_f64()
            ));
        }
        if options.checkpoint_every.is_some_and(|every| number % every == 0) {
            run.write_checkpoint(file, &checkpoint_path(folder, number)?)
                .map_err(|fault| failed(ExperimentError::stopped(fault)))?;
        }
    }
    let summary = gallery.finish(scene, &run, begin).map_err(failed)?;
    draft.publish(folder)?;
    print(&format!("{summary}files         {}\n", folder.display()))?;
    Ok(0)
}

/// What a run leaves in its folder.
struct Gallery<'a> {
    folder: PathBuf,
    formats: &'a [Format],
    film: Film,
    table: String,
    every: usize,
    frames: usize,
    last: Option<SplatStep>,
    steps: u64,
    /// Of simulating, of carrying and writing splats, of drawing them.
    times: [Duration; 3],
}

impl<'a> Gallery<'a> {
    fn new(folder: &Path, formats: &'a [Format], run: &SplatRun, every: usize) -> Self {
        Self {
            folder: folder.to_owned(),
            formats,
            film: Film::new(run.seconds_a_frame(every)),
            table: format!("{}\n", run.head()),
            every,
            frames: 0,
            last: None,
            steps: 0,
            times: [Duration::ZERO; 3],
        }
    }

    fn wants(&self, formats: &[Format]) -> bool {
        self.formats.iter().any(|format| formats.contains(format))
    }

    fn add_step(&mut self, step: SplatStep) {
        self.table.push_str(&step.row());
        self.table.push('\n');
        if let SplatStep::Particles(step) = &step {
            self.steps += step.steps;
            self.times[0] += step.wall;
        }
        self.last = Some(step);
    }

    /// Writes the splats as they are now, and draws them.
    fn add_frame(&mut self, run: &mut SplatRun) -> Result<(), ExperimentError> {
        // Numbers go on where a run is resumed.
        let number = run.done().div_ceil(self.every) + 1;
        let frames = self.folder.join("frames");
        let begin = Instant::now();
        run.carry()?;
        if self.wants(&[Format::Ply]) {
            write_frame(&*run.frame(), &frames, number).map_err(ExperimentError::stopped)?;
        }
        let carried = begin.elapsed();
        if self.wants(&[Format::Png, Format::Gif, Format::Mp4]) {
            let image = run.draw()?;
            if self.wants(&[Format::Png]) {
                let path = frames.join(format!("frame_{number:04}.png"));
                image.save_png(&path).map_err(ExperimentError::stopped)?;
            }
            self.film.push(image).map_err(ExperimentError::stopped)?;
        }
        self.times[1] += carried;
        self.times[2] += begin.elapsed() - carried;
        self.frames += 1;
        Ok(())
    }

    /// Writes what needs all frames; answers the summary.
    fn finish(self, scene: &Scene, run: &SplatRun, begin: Instant) -> Result<String, ExperimentError> {
        let written = |path: &str, text: &str| {
            output::write_file(&self.folder.join(path), text.as_bytes()).map_err(ExperimentError::stopped)
        };
        if self.wants(&[Format::Gif]) {
            self.film.save_gif(&self.folder.join("film.gif")).map_err(ExperimentError::stopped)?;
        }
        let mut mp4 = "";
        if self.wants(&[Format::Mp4]) {
            let path = self.folder.join("film.mp4");
            if self.film.save_mp4(&path).map_err(ExperimentError::stopped)? == Mp4::NoFfmpeg {
                mp4 = "film.mp4      not written: there is no ffmpeg\n";
            }
        }
        written("diagnostics.csv", &self.table)?;
        let mut summary = self.summary(scene, run);
        summary += mp4;
        // Writing to a string does not fail.
        let _ = writeln!(summary, "time          {:.3} s", begin.elapsed().as_secs_f64());
        written("summary.txt", &summary)?;
        Ok(summary)
    }

    fn summary(&self, scene: &Scene, run: &SplatRun) -> String {
        let transport = run.transport();
        let mut text = format!(
            "scene         {}\nsplats        {}, {} of them matter\n",
            scene.name,
            transport.rest().count(),
            transport.matter().len()
        );
        if let Some(made) = run.made() {
            let _ = writeln!(
                text,
                "particles     {}, {} of them filling; nodes {:.4} m apart\nclamped       {} splats, in filling",
                made.particles, made.filling, made.spacing, made.clamped
            );
        }
        let _ = writeln!(text, "frames        {}, to {:.4} s", self.frames, run.time());
        if let Some(SplatStep::Particles(last)) = &self.last {
            let [simulated, carried, drawn] = self.times.map(|time| time.as_secs_f64());
            let _ = writeln!(
                text,
                "steps         {}\nenergy        {:.6e} J kinetic, {:.6e} J stored, {:.6e} J of weight\n\
                 smallest detF {:.6}\ninside out    {} splats at most\n\
                 of the time   {simulated:.2} s simulating, {carried:.2} s carrying and writing, {drawn:.2} s drawing",
                self.steps,
                last.kinetic,
                last.stored,
                last.weight,
                last.smallest_volume_ratio,
                run.inverted()
            );
        }
        text
    }
}
