//! Runs that are killed again and again, and resumed: they end in the bits of a run that nobody disturbed.

use super::random::Random;
use super::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::runner::environment::fnv1a;
use mechanics_core::checkpoint::{Checkpoint, CheckpointError};
use schemars::JsonSchema;
use serde::Deserialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// This program's `run` of a small scene is killed as `kill -9` does and resumed from its last checkpoint; the ladder is how often.
///
/// A method is the scene of that name in the folder `killed` beside the scene file. See [`Trial`].
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct KilledRuns {}

impl Experiment for KilledRuns {
    fn methods(&self) -> &'static [&'static str] {
        &["sliding-cube", "bent-bar", "falling-splats", "splats-on-tetrahedra"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let program = std::env::current_exe().map_err(ExperimentError::stopped)?;
        let scene = at.folder.join("killed").join(format!("{}.toml", at.method));
        let place = Place::new(std::env::temp_dir().join(format!("killed {}", std::process::id())))
            .map_err(ExperimentError::stopped)?;
        let trial = Trial {
            program: &program,
            scene: &scene,
            folder: &place.0,
            kills: at.ladder as u64,
            seed: at.seed,
        };
        let tally = clock.time(|| trial.run()).map_err(ExperimentError::stopped)?;
        // For the row's log: these depend on the machine's pace, so they are no counts, which must repeat. A closed log is no reason to stop.
        let _ = writeln!(std::io::stderr(), "{tally:?}");
        let outcome = Outcome::default()
            .error("runs with other bits at their end", tally.other_ends as f64)
            .error("unreadable checkpoints", tally.unreadable as f64)
            .count("kills", tally.kills);
        Ok(outcome.state(tally.end))
    }
}

/// A scene that `run` runs with a checkpoint after every step, once undisturbed, and then killed at random moments and resumed until there were
/// enough kills.
///
/// A moment is a number of checkpoints of that life of the process, 0 to 3, and a part of the time that the undisturbed run took for one more. So the kills hit the
/// start, steps, the writing of files and the end alike, at any speed of the machine. A run that is through before its moment comes is compared with the undisturbed one,
/// and another begins; it is no kill.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a> {
    /// The `validation` program.
    pub program: &'a Path,
    /// The scene.
    pub scene: &'a Path,
    /// A folder that is there, for runs.
    pub folder: &'a Path,
    /// How many kills.
    pub kills: u64,
    /// Other moments.
    pub seed: u64,
}

/// What many kills found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Kills that ended a living process.
    pub kills: u64,
    /// Runs that went to their end, killed in between or not; the undisturbed one is not among them.
    pub runs: u64,
    /// Runs whose last checkpoint, all of the state, is not that of the undisturbed run.
    pub other_ends: u64,
    /// Kills that left a half-written checkpoint behind, under another name than a checkpoint's.
    pub half_written: u64,
    /// Checkpoints that could not be read after a kill, counted after every kill.
    pub unreadable: u64,
    /// FNV-1a hash of the last checkpoint of the undisturbed run.
    pub end: u64,
}

/// What stops a trial.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// A process could not be started or waited for, or a folder not be used.
    #[error("{}: {source}", path.display())]
    System {
        /// The program or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A checkpoint of a run that was through cannot be read.
    #[error("{}: {source}", path.display())]
    Checkpoint {
        /// The checkpoint.
        path: PathBuf,
        /// Why.
        source: CheckpointError,
    },
    /// A run that was not killed failed.
    #[error("`{command}` failed after {kills} kills ({status}): {words}")]
    Failed {
        /// What was run.
        command: String,
        /// The kills so far.
        kills: u64,
        /// How it ended.
        status: std::process::ExitStatus,
        /// What it said.
        words: String,
    },
    /// A run that was through has left no checkpoint.
    #[error("`{command}` has left no checkpoint")]
    NoCheckpoint {
        /// What was run.
        command: String,
    },
}

impl Trial<'_> {
    /// Runs, kills and resumes.
    ///
    /// # Errors
    /// When a process cannot be started, when one fails that was not killed, or when one leaves no checkpoint. Other bits and unreadable checkpoints are in the
    /// [`Tally`].
    pub fn run(&self) -> Result<Tally, TrialError> {
        let undisturbed = Story::new(self, "undisturbed")?;
        let pace = undisturbed.pace()?;
        let expected = undisturbed.end()?;
        let mut tally = Tally { end: fnv1a(&expected), ..Tally::default() };
        let mut random = Random::new(self.seed);
        let mut story = Story::new(self, "run 0")?;
        while tally.kills < self.kills {
            let left = story.half_written();
            match story.live(&pace.moment(&story, &mut random), tally.kills)? {
                Life::Whole => {
                    tally.add_end(&story.end()?, &expected);
                    story = Story::new(self, &format!("run {}", tally.runs))?;
                }
                Life::Killed => {
                    tally.kills += 1;
                    tally.half_written += u64::from(story.half_written() > left);
                    tally.unreadable += story.unreadable();
                }
            }
        }
        story.finish(tally.kills)?;
        tally.add_end(&story.end()?, &expected);
        Ok(tally)
    }
}

impl Tally {
    fn add_end(&mut self, found: &[u8], expected: &[u8]) {
        self.runs += 1;
        self.other_ends += u64::from(found != expected);
    }
}

/// A folder that is removed in the end.
struct Place(PathBuf);

impl Place {
    fn new(folder: PathBuf) -> Result<Self, TrialError> {
        std::fs::create_dir_all(&folder)
            .map_err(|source| TrialError::System { path: folder.clone(), source })?;
        Ok(Self(folder))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        // What cannot be removed stays among temporary files.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// How long an undisturbed run takes to its first checkpoint, from one to the next, and from the last to its end.
struct Pace {
    steps: usize,
    first: Duration,
    step: Duration,
    end: Duration,
}

impl Pace {
    fn moment(&self, story: &Story<'_>, random: &mut Random) -> Moment {
        let mut part = || 0.5 * (1.0 + random.symmetric());
        let left = self.steps.saturating_sub(story.checkpoints().len());
        let checkpoints = ((4.0 * part()) as usize).min(left);
        let next = match checkpoints {
            // All steps were made before: what is left is the way to the end.
            0 if left == 0 => 2 * (self.first + self.end),
            0 => self.first,
            all if all == left => self.end,
            _ => self.step,
        };
        Moment { checkpoints, wait: next.mul_f64(part()) }
    }
}

/// When a process is killed: so many checkpoints after its start, and a while later.
struct Moment {
    checkpoints: usize,
    wait: Duration,
}

/// How a process ended.
enum Life {
    Whole,
    Killed,
}

/// A run and its resumptions, in a folder of its own.
struct Story<'a> {
    trial: &'a Trial<'a>,
    place: Place,
}

impl<'a> Story<'a> {
    fn new(trial: &'a Trial<'a>, name: &str) -> Result<Self, TrialError> {
        Ok(Self { trial, place: Place::new(trial.folder.join(name))? })
    }

    /// The run from its begin, or from its last checkpoint on.
    fn command(&self) -> Command {
        let mut command = Command::new(self.trial.program);
        command.arg("run").arg(self.trial.scene).arg("--out").arg(self.place.0.join("out"));
        command.args(["--checkpoint-every", "1"]);
        if let Some(last) = self.checkpoints().last() {
            command.arg("--resume").arg(last);
        }
        command
    }

    fn start(&self) -> Result<Child, TrialError> {
        let mut command = self.command();
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().map_err(|source| self.system(source))
    }

    /// Starts the process and kills it at its moment.
    fn live(&self, moment: &Moment, kills: u64) -> Result<Life, TrialError> {
        let until = self.checkpoints().len() + moment.checkpoints;
        let mut child = self.start()?;
        while self.checkpoints().len() < until
            && child.try_wait().map_err(|source| self.system(source))?.is_none()
        {
            std::thread::sleep(Duration::from_micros(500));
        }
        std::thread::sleep(moment.wait);
        child.kill().map_err(|source| self.system(source))?;
        let output = child.wait_with_output().map_err(|source| self.system(source))?;
        // A process that was through before the signal came has its own exit code; one that was killed has none, but 1 on Windows.
        match output.status.code() {
            Some(0) => Ok(Life::Whole),
            None => Ok(Life::Killed),
            Some(1) if cfg!(windows) => Ok(Life::Killed),
            Some(_) => Err(self.failed(&output, kills)),
        }
    }

    fn finish(&self, kills: u64) -> Result<(), TrialError> {
        let output = self.start()?.wait_with_output().map_err(|source| self.system(source))?;
        if output.status.success() { Ok(()) } else { Err(self.failed(&output, kills)) }
    }

    /// Runs to the end and looks on.
    fn pace(&self) -> Result<Pace, TrialError> {
        let begin = Instant::now();
        let mut child = self.start()?;
        let (mut first, mut last) = (None, Duration::ZERO);
        let mut known = 0;
        while child.try_wait().map_err(|source| self.system(source))?.is_none() {
            let now = self.checkpoints().len();
            if now > known {
                known = now;
                last = begin.elapsed();
                first.get_or_insert(last);
            }
            std::thread::sleep(Duration::from_micros(500));
        }
        let whole = begin.elapsed();
        let output = child.wait_with_output().map_err(|source| self.system(source))?;
        if !output.status.success() {
            return Err(self.failed(&output, 0));
        }
        let steps = self.checkpoints().len();
        let first = first.unwrap_or(whole);
        let step = last.saturating_sub(first) / steps.max(2) as u32;
        Ok(Pace { steps, first, step, end: whole.saturating_sub(last) })
    }

    /// What one would resume from, oldest first.
    fn checkpoints(&self) -> Vec<PathBuf> {
        self.written("checkpoint")
    }

    /// Files that a killed writer has left.
    fn half_written(&self) -> usize {
        self.written("tmp").len()
    }

    /// Files beside the run's folder with an ending, in the order of steps.
    fn written(&self, ending: &str) -> Vec<PathBuf> {
        // The folder is not there before the first checkpoint.
        let Ok(entries) = std::fs::read_dir(self.place.0.join("out.checkpoints")) else { return Vec::new() };
        let paths = entries.flatten().map(|entry| entry.path());
        let mut paths: Vec<PathBuf> =
            paths.filter(|path| path.extension().is_some_and(|found| found == ending)).collect();
        paths.sort();
        paths
    }

    fn unreadable(&self) -> u64 {
        self.checkpoints().iter().filter(|path| Checkpoint::read(path).is_err()).count() as u64
    }

    /// The bytes of the last checkpoint: the whole state.
    fn end(&self) -> Result<Vec<u8>, TrialError> {
        let last = self.checkpoints().pop();
        let path =
            last.ok_or_else(|| TrialError::NoCheckpoint { command: format!("{:?}", self.command()) })?;
        if let Err(source) = Checkpoint::read(&path) {
            return Err(TrialError::Checkpoint { path, source });
        }
        std::fs::read(&path).map_err(|source| TrialError::System { path, source })
    }

    fn failed(&self, output: &Output, kills: u64) -> TrialError {
        TrialError::Failed {
            command: format!("{:?}", self.command()),
            kills,
            status: output.status,
            words: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    fn system(&self, source: std::io::Error) -> TrialError {
        TrialError::System { path: self.trial.program.to_owned(), source }
    }
}
