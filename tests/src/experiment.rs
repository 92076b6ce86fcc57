//! Experiments: the Rust functions that scenes run.
//!
//! An experiment is a struct whose fields are the `[experiment.parameters]` of a scene file, with an
//! [`Experiment`] impl that runs one ladder point of one method and says what came out. It becomes available to
//! scene files by one line in [`registry`]. Everything else (repeats, processes, time limits, threads, checks,
//! baselines, reports) is the runner's.

mod across;
mod bodies;
mod clock;
mod contact;
mod friction;
mod hard_cases;
pub mod killed;
mod laws;
mod motion;
mod particles;
mod pictures;
mod point_laws;
mod random;
mod readers;
pub mod registry;
mod selftest;
pub(crate) mod simulation;
mod soak;
mod solid;
pub(crate) mod splat_motion;
pub(crate) mod splats;
mod svd;
mod thin_bodies;

pub use clock::Clock;

use crate::record::Picture;
use crate::scene::SceneFile;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Work that a scene can run.
pub trait Experiment: Send + Sync {
    /// The methods it knows: the lines of its work–precision plot.
    fn methods(&self) -> &'static [&'static str];

    /// Runs one point and says what came out. The same point must give the same bits every time; `clock` gets the
    /// work's wall time, and times the whole call if the experiment does not use it.
    ///
    /// # Errors
    /// Whatever stopped the work. The row is then a failed one, with the error's words.
    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError>;
}

/// What an experiment is to run.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a> {
    /// The scene, with the ladder's value and the method put where the scene says.
    pub scene: &'a SceneFile,
    /// The scene file's folder, where its mesh files are.
    pub folder: &'a Path,
    /// The ladder's value.
    pub ladder: f64,
    /// The method, one of [`Experiment::methods`].
    pub method: &'a str,
    /// The seed of a hard case; 0 where the scene has no seeds.
    pub seed: u64,
    /// Threads; parallel work through `mechanics_core::parallel` uses them by itself.
    pub threads: usize,
    /// Where pictures may be written, if they are wanted: a folder and the file stem to use.
    pub frames: Option<(&'a Path, &'a str)>,
}

/// What came out of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Errors by measure name; the scene picks the ones it declares.
    pub errors: BTreeMap<String, f64>,
    /// Counts by name.
    pub counts: BTreeMap<String, u64>,
    /// Invariants by name.
    pub invariants: BTreeMap<String, f64>,
    /// Simulated time (s), where time goes on.
    pub simulated_seconds: Option<f64>,
    /// Hash of the final state, where there is one.
    pub state_hash: Option<u64>,
    /// Pictures written, paths relative to the folder of [`Point::frames`].
    pub pictures: Vec<Picture>,
}

impl Outcome {
    /// With an error measure.
    pub fn error(mut self, measure: &str, value: f64) -> Self {
        self.errors.insert(measure.to_owned(), value);
        self
    }

    /// With a count.
    pub fn count(mut self, name: &str, count: u64) -> Self {
        self.counts.insert(name.to_owned(), count);
        self
    }

    /// With an invariant.
    pub fn invariant(mut self, name: &str, value: f64) -> Self {
        self.invariants.insert(name.to_owned(), value);
        self
    }

    /// With the hash of the final state.
    pub fn state(mut self, hash: u64) -> Self {
        self.state_hash = Some(hash);
        self
    }
}

/// What stopped an experiment.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// A solver's or a reader's own error.
    #[error(transparent)]
    Stopped(Box<dyn std::error::Error + Send + Sync>),
    /// The scene asks for something that no crate here offers yet.
    #[error("`{feature}` is not available yet; available: {available}")]
    NotAvailable {
        /// What it asks for.
        feature: String,
        /// What there is.
        available: &'static str,
    },
    /// The scene asks for something that cannot be done.
    #[error("`{key}`: {reason}")]
    Refused {
        /// The key that asks for it.
        key: String,
        /// Why not, and what is allowed.
        reason: String,
    },
    /// A file could not be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file could not be written.
    #[error("{}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl ExperimentError {
    /// A solver's or a reader's error.
    pub fn stopped(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Stopped(Box::new(error))
    }
}
