//! What a run of the suite found: the one description that the runner writes and every report reads.
//!
//! `report.json` is a [`Report`] as it stands here; its JSON Schema is committed beside the scenes. All numbers are
//! finite: a measure that came out infinite or NaN is a row whose [`Exit`] says so, not a value.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The version of this description; raised when a field changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 1;

/// Everything that one run of the suite found.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Report {
    /// [`SCHEMA_VERSION`] of the writer.
    pub schema_version: u32,
    /// The suite that ran: `quick`, `full`, `stress`, or `scenes` where they were picked by name.
    pub suite: String,
    /// The command line, so that the run can be repeated.
    pub command: Vec<String>,
    /// When it started, seconds since 1970 (UTC).
    pub started_unix_seconds: u64,
    /// How long it took (s).
    pub seconds: f64,
    /// Whether it was interrupted before all scenes ran.
    pub interrupted: bool,
    /// The shard this is, `i/n`, or `None` for the whole.
    pub shard: Option<String>,
    /// Where it ran.
    pub environment: Environment,
    /// One record a scene, in name order.
    pub scenes: Vec<SceneRecord>,
}

/// The machine and program that produced a [`Report`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    /// Hash of CPU features and toolchain: exact counts and state hashes are compared only where it is equal.
    pub fingerprint: String,
    /// The processor's name.
    pub processor: String,
    /// Its SIMD features that matter to the kernels, sorted.
    pub processor_features: Vec<String>,
    /// Cores offered to this process.
    pub cores: usize,
    /// Total memory (bytes).
    pub memory_bytes: u64,
    /// Operating system and kernel.
    pub system: String,
    /// `rustc --version` of the build.
    pub compiler: String,
    /// The build profile.
    pub profile: String,
    /// The commit, `-dirty` appended when the tree had changes, empty outside a checkout.
    pub commit: String,
}

/// What one scene claims and what came out.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneRecord {
    /// The scene's name: `crate/file-stem`.
    pub name: String,
    /// The crate it validates.
    pub crate_name: String,
    /// A short human title.
    pub title: String,
    /// One paragraph: what is claimed.
    pub claim: String,
    /// The closed form or statement compared with, in plain text; may be empty.
    pub formula: String,
    /// The truth.
    pub reference: Reference,
    /// What is measured.
    pub measures: Vec<Measure>,
    /// What the ladder varies: `h`, `Δx`, `tolerance`, ….
    pub ladder: Quantity,
    /// One work–precision line a method.
    pub lines: Vec<Line>,
    /// Every check made on this scene.
    pub checks: Vec<Check>,
    /// The scene's verdict.
    pub verdict: Verdict,
    /// Pictures and films, paths relative to the report's folder.
    pub pictures: Vec<Picture>,
    /// Path of the scene's log, relative to the report's folder; empty when there is none.
    pub log: String,
}

/// Where the truth comes from.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// What kind of truth it is.
    pub kind: ReferenceKind,
    /// Author, year, equation or file.
    pub citation: String,
}

/// Kinds of truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReferenceKind {
    /// A closed form.
    Analytic,
    /// A chosen solution whose load was computed from it.
    Manufactured,
    /// A published number.
    Published,
    /// An independent computation with many more digits.
    HighPrecision,
    /// The limit of the scene's own ladder.
    Richardson,
    /// Another program.
    External,
    /// No reference: invariants only (hard cases).
    Invariants,
}

/// A named quantity with its unit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// Its unit; `1` for a ratio.
    pub unit: String,
}

/// One error measure of a scene. The first measure of a scene is the one its work–precision plot shows.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// The key in [`Row::errors`].
    pub name: String,
    /// Its unit; `1` for a relative error.
    pub unit: String,
    /// The largest value allowed at the finest point of each line, if there is one.
    pub bound: Option<f64>,
    /// The expected order in the ladder's quantity, if there is one.
    pub order: Option<f64>,
    /// How far the observed order may be from the expected one.
    pub order_tolerance: Option<f64>,
    /// What is expected of single methods, where it differs.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub methods: BTreeMap<String, Target>,
}

/// What one method is expected to reach in one measure.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// The largest value allowed at the finest point, if there is one.
    pub bound: Option<f64>,
    /// The expected order in the ladder's quantity, if there is one.
    pub order: Option<f64>,
    /// How far the observed order may be from the expected one.
    pub order_tolerance: Option<f64>,
}

/// One method's points along the ladder.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// The method, as the plot labels it.
    pub label: String,
    /// One row per ladder point and thread count.
    pub rows: Vec<Row>,
    /// Observed orders of convergence, one a measure that has an expected one.
    pub orders: Vec<ObservedOrder>,
}

/// An order of convergence fitted to a line.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObservedOrder {
    /// The measure.
    pub measure: String,
    /// The fitted slope of log error over log ladder value.
    pub order: f64,
    /// The expected one.
    pub expected: f64,
    /// Half-width of its 95 % confidence interval; 0 for two points.
    pub half_width: f64,
    /// How many points the fit used; those on the round-off floor are left out.
    pub points: usize,
}

/// One run: a method at a ladder point with a number of threads.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// The ladder's value, in the ladder's unit.
    pub ladder: f64,
    /// Threads used.
    pub threads: usize,
    /// Errors by measure name.
    pub errors: BTreeMap<String, f64>,
    /// Median wall time of the repeats (s).
    pub seconds: f64,
    /// Largest minus smallest wall time of the repeats (s).
    pub seconds_spread: f64,
    /// Simulated time (s); `None` for statics and kernels.
    pub simulated_seconds: Option<f64>,
    /// Repeats that were timed.
    pub repeats: usize,
    /// Counts by name: steps, Newton iterations, factorisations, contacts, ….
    pub counts: BTreeMap<String, u64>,
    /// Invariants by name: energy drift, smallest distance, worst det F, ….
    pub invariants: BTreeMap<String, f64>,
    /// Which terms were active, and what each cost (s).
    pub terms: Vec<TermCost>,
    /// Peak memory of the process (bytes).
    pub peak_memory_bytes: u64,
    /// Hash of the final state, sixteen hexadecimal digits; empty when there is no state.
    pub state_hash: String,
    /// How it ended.
    pub exit: Exit,
}

/// One active term and its cost.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TermCost {
    /// The term.
    pub name: String,
    /// Wall time spent in it (s).
    pub seconds: f64,
}

/// How a row ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Exit {
    /// It ran to its end.
    Completed,
    /// A typed error stopped it, or a measure was not finite.
    Failed {
        /// The error's own words.
        message: String,
    },
    /// It panicked or was killed by a signal.
    Crashed {
        /// The panic's words or the signal.
        message: String,
    },
    /// It ran over its time limit (s).
    TimedOut {
        /// The limit (s).
        limit_seconds: u64,
    },
}

/// One check on a scene.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// What kind of check: it decides the exit code.
    pub kind: CheckKind,
    /// What was checked, in a few words.
    pub name: String,
    /// Whether it held.
    pub verdict: Verdict,
    /// One sentence with the numbers: what came out and what was allowed.
    pub detail: String,
}

/// Kinds of checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CheckKind {
    /// An error against its bound.
    Accuracy,
    /// An observed order against the expected one.
    Order,
    /// An invariant.
    Invariant,
    /// Every row completed.
    Completion,
    /// State hashes are equal for every number of threads.
    Threads,
    /// The committed baseline.
    Baseline,
}

/// Passed, failed, or skipped with its reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Verdict {
    /// It held.
    Passed,
    /// It did not.
    Failed,
    /// It was not judged.
    Skipped {
        /// Why not.
        reason: String,
    },
}

/// A picture or film of a scene.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// Path relative to the report's folder; `.png` or `.gif`.
    pub path: String,
    /// What it shows.
    pub caption: String,
}
