//! Runs scenes: every row in a process of its own, every scene judged, everything in one [`Report`].
//!
//! A row is a method at a ladder point with a number of threads. It runs in a child process, so that a panic, an
//! abort or a run without end is a row and not the end of the suite, and so that its peak memory is its own.
//! Rows run one after the other: a time is only worth something on a quiet machine.

pub mod environment;
pub mod job;
pub mod output;
mod plan;
mod process;
pub mod progress;
mod resume;

pub use process::end_with_parent;

use crate::checks::Claim;
use crate::record::{
    Check, CheckKind, Exit, Line, Picture, Quantity, Report, SCHEMA_VERSION, SceneRecord, Verdict,
};
use crate::scene::Scene;
use crate::scene::selection::Shard;
use crate::scene::validation::Suite;
use output::{OutputError, file_stem};
use plan::{LineSpec, Plan};
use process::{Ended, Spawner};
use progress::Progress;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How scenes are run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The suite; it decides how much of each ladder is run.
    pub suite: Option<Suite>,
    /// At most so many ladder points, the coarsest.
    pub ladder_points: Option<usize>,
    /// Timed runs a row, instead of what scenes say.
    pub repeats: Option<usize>,
    /// Thread counts, instead of what scenes say.
    pub threads: Option<Vec<usize>>,
    /// No row starts later than this after the start.
    pub time_budget: Option<Duration>,
    /// The part of the scenes that this run is, for the report.
    pub shard: Option<Shard>,
    /// The output folder.
    pub output: PathBuf,
    /// What to do with scenes that the output folder already has results of.
    pub earlier: Earlier,
    /// Whether pictures are made.
    pub pictures: Pictures,
    /// The program that runs `child`.
    pub program: PathBuf,
    /// The command line, for the report.
    pub command: Vec<String>,
}

/// What to do with results of an earlier run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Earlier {
    /// Run again.
    Replace,
    /// Take over what the same scene gave under the same settings and program.
    Keep,
}

/// The folder of pictures within that of the report.
pub(crate) const FRAMES: &str = "frames";

/// Whether pictures are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pictures {
    /// They are.
    Made,
    /// They are not.
    Omitted,
}

/// A scene's own check against something outside the run, added to its checks.
pub type Comparison<'a> = dyn Fn(&SceneRecord) -> Vec<Check> + 'a;

struct Run<'a> {
    settings: &'a Settings,
    spawner: Spawner<'a>,
    start: Instant,
    identity: String,
}

/// Why a scene has not run to its end.
enum Stop {
    Interrupted,
    OutOfTime,
}

/// Runs scenes, judges them, and compares each with `baseline`.
///
/// # Errors
/// When the output folder cannot be written. Whatever happens inside a scene is part of the report.
pub fn run(
    scenes: &[Scene],
    settings: &Settings,
    baseline: &Comparison<'_>,
    interrupted: &AtomicBool,
    progress: impl FnOnce(usize) -> Progress,
) -> Result<Report, OutputError> {
    for folder in ["", "logs", "finished", "frames"] {
        output::make_folder(&settings.output.join(folder))?;
    }
    let environment = environment::describe();
    let plans: Vec<Plan<'_>> = scenes.iter().filter_map(|scene| Plan::new(scene, settings)).collect();
    let mut progress = progress(plans.iter().map(Plan::row_count).sum());
    let run = Run {
        settings,
        spawner: Spawner { program: settings.program.clone(), interrupted },
        start: Instant::now(),
        identity: resume::program_identity(&settings.program, &environment),
    };
    let started = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let mut records = Vec::new();
    for plan in &plans {
        records.push(run.scene(plan, baseline, &mut progress)?);
    }
    progress.end();
    Ok(Report {
        schema_version: SCHEMA_VERSION,
        suite: settings.suite.map_or_else(|| "scenes".to_owned(), |suite| suite.to_string()),
        command: settings.command.clone(),
        started_unix_seconds: started.as_secs(),
        seconds: run.start.elapsed().as_secs_f64(),
        interrupted: interrupted.load(Ordering::Relaxed),
        shard: settings.shard.map(|shard| shard.to_string()),
        environment,
        scenes: records,
    })
}

/// What scenes claim, their whole ladders in mind; nothing is run. Scenes that claim nothing are left out.
pub fn claims(scenes: &[Scene]) -> Vec<SceneRecord> {
    let settings = Settings {
        suite: None,
        ladder_points: None,
        repeats: None,
        threads: None,
        time_budget: None,
        shard: None,
        output: PathBuf::new(),
        earlier: Earlier::Replace,
        pictures: Pictures::Omitted,
        program: PathBuf::new(),
        command: Vec::new(),
    };
    let plans = scenes.iter().filter_map(|scene| Plan::new(scene, &settings));
    let record = |plan: Plan<'_>| {
        let line = |spec: &LineSpec| Line { label: spec.label.clone(), rows: Vec::new(), orders: Vec::new() };
        let claim = Claim { validation: plan.validation, points: plan.points };
        let verdict = Verdict::Skipped { reason: "only its claim was asked for".to_owned() };
        let lines = plan.lines.iter().map(line).collect();
        describe(&plan, &claim, lines, Vec::new(), verdict, Vec::new(), String::new())
    };
    plans.map(record).collect()
}

impl Run<'_> {
    /// One scene: taken over from an earlier run, or run row by row.
    fn scene(
        &self,
        plan: &Plan<'_>,
        baseline: &Comparison<'_>,
        progress: &mut Progress,
    ) -> Result<SceneRecord, OutputError> {
        let finished =
            self.settings.output.join("finished").join(format!("{}.json", file_stem(&plan.scene.name)));
        let key = resume::key(plan, &self.identity);
        let earlier = match self.settings.earlier {
            Earlier::Keep => resume::read(&finished, &key)?,
            Earlier::Replace => None,
        };
        let (mut record, rows_run) = match earlier {
            Some(record) => (record, 0),
            None => {
                let record = self.rows(plan, progress)?;
                if !matches!(record.verdict, Verdict::Skipped { .. }) {
                    resume::write(&finished, &key, &record)?;
                }
                let rows = record.lines.iter().map(|line| line.rows.len()).sum();
                (record, rows)
            }
        };
        if !matches!(record.verdict, Verdict::Skipped { .. }) {
            record.checks.extend(baseline(&record));
            record.verdict = verdict(&record.checks);
        }
        progress.scene_ended(&record, plan.row_count() - rows_run);
        Ok(record)
    }

    fn rows(&self, plan: &Plan<'_>, progress: &mut Progress) -> Result<SceneRecord, OutputError> {
        let log = format!("logs/{}.log", file_stem(&plan.scene.name));
        let log_path = self.settings.output.join(&log);
        output::write_file(&log_path, format!("{}\n", plan.scene.path.display()).as_bytes())?;
        let mut lines = Vec::new();
        let mut pictures = Vec::new();
        let mut stop = None;
        for spec in &plan.lines {
            let mut line = Line { label: spec.label.clone(), rows: Vec::new(), orders: Vec::new() };
            stop = self.line(plan, spec, &log_path, &mut line, &mut pictures, progress)?;
            if !line.rows.is_empty() {
                lines.push(line);
            }
            if stop.is_some() {
                break;
            }
        }
        let done: usize = lines.iter().map(|line| line.rows.len()).sum();
        let claim = Claim { validation: plan.validation, points: plan.points };
        let (checks, verdict) = match stop {
            None => {
                let checks = claim.judge(&mut lines);
                let verdict = verdict(&checks);
                (checks, verdict)
            }
            Some(stop) => {
                (Vec::new(), Verdict::Skipped { reason: self.stop_reason(&stop, done, plan.row_count()) })
            }
        };
        let log = if done > 0 { log } else { String::new() };
        Ok(describe(plan, &claim, lines, checks, verdict, pictures, log))
    }

    fn line(
        &self,
        plan: &Plan<'_>,
        spec: &LineSpec,
        log: &Path,
        line: &mut Line,
        pictures: &mut Vec<Picture>,
        progress: &mut Progress,
    ) -> Result<Option<Stop>, OutputError> {
        let mut too_slow: Option<f64> = None;
        for point in 0..plan.points {
            for &threads in &plan.threads {
                let job = plan.job(spec, point, threads, self.settings);
                if let Some(coarser) = too_slow {
                    let message = format!("not run: the coarser point {coarser} ran over its time limit");
                    line.rows.push(job.empty_row(Exit::Failed { message }));
                    progress.row_ended();
                    continue;
                }
                if let Some(stop) = self.must_stop() {
                    return Ok(Some(stop));
                }
                progress.row_starts(&plan.scene.name);
                let Ended::With(result) = self.spawner.run(&job, plan.time_limit(), log)? else {
                    return Ok(Some(Stop::Interrupted));
                };
                progress.row_ended();
                if matches!(result.row.exit, Exit::TimedOut { .. })
                    && threads == plan.threads[plan.threads.len() - 1]
                {
                    too_slow = Some(job.ladder);
                }
                // A row names its pictures relative to their own folder, a record relative to the report's.
                pictures.extend(
                    result
                        .pictures
                        .into_iter()
                        .map(|picture| Picture { path: format!("{FRAMES}/{}", picture.path), ..picture }),
                );
                line.rows.push(result.row);
            }
        }
        Ok(None)
    }

    fn must_stop(&self) -> Option<Stop> {
        if self.spawner.interrupted.load(Ordering::Relaxed) {
            return Some(Stop::Interrupted);
        }
        let budget = self.settings.time_budget?;
        (self.start.elapsed() >= budget).then_some(Stop::OutOfTime)
    }

    fn stop_reason(&self, stop: &Stop, done: usize, total: usize) -> String {
        let when =
            if done == 0 { "before it ran".to_owned() } else { format!("after {done} of {total} rows") };
        match stop {
            Stop::Interrupted => format!("interrupted {when}"),
            Stop::OutOfTime => {
                let budget = self.settings.time_budget.unwrap_or_default().as_secs_f64();
                format!("the time budget of {budget} s ended {when}")
            }
        }
    }
}

fn describe(
    plan: &Plan<'_>,
    claim: &Claim<'_>,
    lines: Vec<Line>,
    checks: Vec<Check>,
    verdict: Verdict,
    pictures: Vec<Picture>,
    log: String,
) -> SceneRecord {
    let validation = plan.validation;
    SceneRecord {
        name: plan.scene.name.clone(),
        crate_name: plan.scene.crate_name().to_owned(),
        title: validation.title.clone(),
        claim: validation.claim.clone(),
        formula: validation.formula.clone(),
        reference: validation.reference.clone(),
        measures: claim.measures(),
        ladder: Quantity { name: validation.ladder.name.clone(), unit: validation.ladder.unit.clone() },
        lines,
        checks,
        verdict,
        pictures,
        log,
    }
}

/// A scene passes when none of its checks failed.
pub fn verdict(checks: &[Check]) -> Verdict {
    if checks.iter().any(|check| check.verdict == Verdict::Failed) {
        Verdict::Failed
    } else {
        Verdict::Passed
    }
}

/// The exit code of a run: the gravest thing that its report tells.
///
/// 0 all checks passed · 1 an accuracy, order, invariant or completion check failed · 3 only the baseline is not
/// met · 4 thread counts disagree · 5 a scene crashed · 130 interrupted.
pub fn exit_code(report: &Report) -> u8 {
    let failed = |wanted: &dyn Fn(CheckKind) -> bool| {
        let mut checks = report.scenes.iter().flat_map(|scene| &scene.checks);
        checks.any(|check| check.verdict == Verdict::Failed && wanted(check.kind))
    };
    let mut rows = report.scenes.iter().flat_map(|scene| &scene.lines).flat_map(|line| &line.rows);
    if report.interrupted {
        130
    } else if rows.any(|row| matches!(row.exit, Exit::Crashed { .. })) {
        5
    } else if failed(&|kind| kind == CheckKind::Threads) {
        4
    } else if failed(&|kind| kind != CheckKind::Baseline) {
        1
    } else if failed(&|kind| kind == CheckKind::Baseline) {
        3
    } else {
        0
    }
}
