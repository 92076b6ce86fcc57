//! One row in a process of its own: the child's side.

use super::environment::peak_memory_bytes;
use crate::experiment::{Clock, ExperimentError, Outcome, Point};
use crate::record::{Exit, Picture, Row, TermCost};
use crate::scene::{Scene, SceneError};
use mechanics_core::parallel;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What a child process is to run: a method at a ladder point with a number of threads.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Job {
    /// The scene file.
    pub scene: PathBuf,
    /// The method.
    pub method: String,
    /// The ladder's value.
    pub ladder: f64,
    /// The seed of a hard case.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// Runs that are timed.
    pub repeats: usize,
    /// Where pictures go, if they are wanted: folder and file stem.
    pub frames: Option<(PathBuf, String)>,
}

/// What a child process answers.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct JobResult {
    /// The row.
    pub row: Row,
    /// Pictures written.
    pub pictures: Vec<Picture>,
}

/// What stops a repeated run.
#[derive(Debug, thiserror::Error)]
enum RunError {
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    #[error("two runs of the same point differ: {what}")]
    NotRepeatable { what: String },
    #[error("`{name}` is not finite: {value}")]
    NotFinite { name: String, value: f64 },
    #[error("the experiment reports no `{name}`, which the scene measures; it reports: {reported}")]
    Missing { name: String, reported: String },
}

struct Timed {
    outcome: Outcome,
    terms: Vec<TermCost>,
    times: Vec<f64>,
}

impl Job {
    /// Runs the job; a panic is caught and becomes a crashed row.
    ///
    /// # Errors
    /// When the scene cannot be read.
    pub fn run(&self) -> Result<JobResult, SceneError> {
        let scene = Scene::read(&self.scene)?;
        let file = scene.at(self.ladder, &self.method)?;
        let folder = self.scene.parent().unwrap_or(Path::new("."));
        let point = Point {
            scene: &file,
            folder,
            ladder: self.ladder,
            method: &self.method,
            seed: self.seed,
            threads: self.threads,
            frames: self.frames.as_ref().map(|(folder, stem)| (folder.as_path(), stem.as_str())),
        };
        let work = AssertUnwindSafe(|| parallel::with_threads(self.threads, || self.repeat(&scene, &point)));
        Ok(match catch_unwind(work) {
            Ok(Ok(timed)) => self.completed(timed),
            Ok(Err(error)) => self.stopped(Exit::Failed { message: error.to_string() }),
            Err(panic) => self.stopped(Exit::Crashed { message: panic_message(panic.as_ref()) }),
        })
    }

    /// Runs the point once to warm up when it is to be timed more than once, then the timed repeats; all of them
    /// must agree in every bit.
    fn repeat(&self, scene: &Scene, point: &Point<'_>) -> Result<Timed, RunError> {
        let once = || {
            let mut clock = Clock::default();
            let start = Instant::now();
            let outcome = scene.experiment.run(point, &mut clock)?;
            let seconds = clock.work().unwrap_or_else(|| start.elapsed()).as_secs_f64();
            Ok::<_, RunError>((outcome, clock, seconds))
        };
        if self.repeats > 1 {
            once()?;
        }
        let (outcome, clock, seconds) = once()?;
        let outcome = selected(scene, outcome)?;
        let mut times = vec![seconds];
        for _ in 1..self.repeats {
            let (again, _, seconds) = once()?;
            require_same(&outcome, &selected(scene, again)?)?;
            times.push(seconds);
        }
        let cost =
            |(name, cost): &(String, Duration)| TermCost { name: name.clone(), seconds: cost.as_secs_f64() };
        Ok(Timed { outcome, terms: clock.terms().iter().map(cost).collect(), times })
    }

    fn completed(&self, timed: Timed) -> JobResult {
        let Timed { outcome, terms, mut times } = timed;
        times.sort_by(f64::total_cmp);
        let row = Row {
            errors: outcome.errors,
            seconds: median(&times),
            seconds_spread: times[times.len() - 1] - times[0],
            simulated_seconds: outcome.simulated_seconds,
            counts: outcome.counts,
            invariants: outcome.invariants,
            terms,
            peak_memory_bytes: peak_memory_bytes(),
            state_hash: outcome.state_hash.map(|hash| format!("{hash:016x}")).unwrap_or_default(),
            repeats: times.len(),
            ..self.empty_row(Exit::Completed)
        };
        JobResult { row, pictures: outcome.pictures }
    }

    fn stopped(&self, exit: Exit) -> JobResult {
        let row = Row { peak_memory_bytes: peak_memory_bytes(), ..self.empty_row(exit) };
        JobResult { row, pictures: Vec::new() }
    }

    /// A row without results.
    pub fn empty_row(&self, exit: Exit) -> Row {
        Row {
            ladder: self.ladder,
            threads: self.threads,
            errors: BTreeMap::new(),
            seconds: 0.0,
            seconds_spread: 0.0,
            simulated_seconds: None,
            repeats: 0,
            counts: BTreeMap::new(),
            invariants: BTreeMap::new(),
            terms: Vec::new(),
            peak_memory_bytes: 0,
            state_hash: String::new(),
            exit,
        }
    }
}

/// The outcome with the measures that the scene declares, all finite.
fn selected(scene: &Scene, mut outcome: Outcome) -> Result<Outcome, RunError> {
    if let Some(validation) = &scene.file.validation {
        for measure in &validation.measures {
            if !outcome.errors.contains_key(&measure.name) {
                let reported = outcome.errors.keys().cloned().collect::<Vec<_>>().join(", ");
                return Err(RunError::Missing { name: measure.name.clone(), reported });
            }
        }
        outcome.errors.retain(|name, _| validation.measures.iter().any(|measure| &measure.name == name));
    }
    match outcome.errors.iter().chain(&outcome.invariants).find(|(_, value)| !value.is_finite()) {
        Some((name, &value)) => Err(RunError::NotFinite { name: name.clone(), value }),
        None => Ok(outcome),
    }
}

fn require_same(first: &Outcome, again: &Outcome) -> Result<(), RunError> {
    let differs = |what: &str, a: String, b: String| {
        if a == b { Ok(()) } else { Err(RunError::NotRepeatable { what: format!("{what} {a}, then {b}") }) }
    };
    differs("errors", format!("{:?}", first.errors), format!("{:?}", again.errors))?;
    differs("counts", format!("{:?}", first.counts), format!("{:?}", again.counts))?;
    differs("invariants", format!("{:?}", first.invariants), format!("{:?}", again.invariants))?;
    differs("state", format!("{:x?}", first.state_hash), format!("{:x?}", again.state_hash))
}

/// The median of sorted, non-empty values.
fn median(sorted: &[f64]) -> f64 {
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) }
}

fn panic_message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "a panic without words".to_owned())
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn the_median_of_an_even_count_is_between_the_middle_two() {
        assert_eq!(median(&[1.0]), 1.0);
        assert_eq!(median(&[1.0, 2.0, 10.0]), 2.0);
        assert_eq!(median(&[1.0, 2.0, 4.0, 10.0]), 3.0);
    }
}
