//! Several shards of one suite made into one report.

use crate::record::{Report, SCHEMA_VERSION};

/// The whole that shards came to.
#[derive(Clone, Debug)]
pub struct Merged {
    /// All scenes of all shards, in name order. Its seconds are the sum over the shards, its environment is the first
    /// shard's; where the machines differ its fingerprint is empty, so that nothing is compared bit by bit.
    pub report: Report,
    /// What a reader of the merged report should know.
    pub warnings: Vec<MergeWarning>,
}

/// Something about the shards that does not stop a merge.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeWarning {
    /// Times and hashes of these shards cannot be compared.
    #[error(
        "shards ran on different machines or toolchains ({first} and {other}): their times are not comparable"
    )]
    FingerprintsDiffer {
        /// Fingerprint of the first report.
        first: String,
        /// The other fingerprint.
        other: String,
    },
    /// The shards validate different programs.
    #[error("shards are of different commits ({first} and {other})")]
    CommitsDiffer {
        /// Commit of the first report.
        first: String,
        /// The other commit.
        other: String,
    },
    /// A shard is missing.
    #[error("shard {missing}/{of} is missing: its scenes are not in the merged report")]
    ShardMissing {
        /// The number of the missing shard, from 1.
        missing: usize,
        /// How many there are.
        of: usize,
    },
    /// A shard did not finish.
    #[error("shard {shard} was interrupted: scenes may be missing")]
    Interrupted {
        /// Its name.
        shard: String,
    },
}

/// Why reports cannot be merged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MergeError {
    /// Nothing to merge.
    #[error("no reports were given; name the report.json of every shard")]
    Empty,
    /// Written by another version of the program.
    #[error(
        "report {index} has schema version {found}, this program reads {SCHEMA_VERSION}; run it again with this version"
    )]
    SchemaVersion {
        /// Which report, from 0.
        index: usize,
        /// Its version.
        found: u32,
    },
    /// Shards of different suites.
    #[error(
        "report {index} is of suite `{found}`, the first one of `{first}`; merge shards of one suite only"
    )]
    SuitesDiffer {
        /// Which report, from 0.
        index: usize,
        /// Its suite.
        found: String,
        /// The first report's suite.
        first: String,
    },
    /// The same scene twice.
    #[error(
        "scene `{name}` is in reports {first} and {second}; each scene belongs to one shard: was a file named twice?"
    )]
    DuplicateScene {
        /// The scene.
        name: String,
        /// One report it is in, from 0.
        first: usize,
        /// The other.
        second: usize,
    },
}

/// Merges the reports of shards into one.
///
/// # Errors
/// [`MergeError`] when there is none, when schema versions or suites differ, or when a scene occurs twice.
pub fn merge(reports: Vec<Report>) -> Result<Merged, MergeError> {
    let first = reports.first().ok_or(MergeError::Empty)?;
    check_same_suite(&reports, &first.suite)?;
    check_distinct_scenes(&reports)?;
    let warnings = warnings(&reports);
    let mixed = warnings.iter().any(|warning| matches!(warning, MergeWarning::FingerprintsDiffer { .. }));
    let mut whole = Report { shard: None, scenes: Vec::new(), seconds: 0.0, ..first.clone() };
    if mixed {
        whole.environment.fingerprint.clear();
    }
    for report in reports {
        whole.seconds += report.seconds;
        whole.interrupted |= report.interrupted;
        whole.started_unix_seconds = whole.started_unix_seconds.min(report.started_unix_seconds);
        whole.scenes.extend(report.scenes);
    }
    whole.scenes.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(Merged { report: whole, warnings })
}

fn check_same_suite(reports: &[Report], first: &str) -> Result<(), MergeError> {
    for (index, report) in reports.iter().enumerate() {
        if report.schema_version != SCHEMA_VERSION {
            return Err(MergeError::SchemaVersion { index, found: report.schema_version });
        }
        if report.suite != first {
            return Err(MergeError::SuitesDiffer { index, found: report.suite.clone(), first: first.into() });
        }
    }
    Ok(())
}

fn check_distinct_scenes(reports: &[Report]) -> Result<(), MergeError> {
    let mut owner = std::collections::BTreeMap::new();
    for (second, report) in reports.iter().enumerate() {
        for scene in &report.scenes {
            if let Some(first) = owner.insert(scene.name.as_str(), second) {
                return Err(MergeError::DuplicateScene { name: scene.name.clone(), first, second });
            }
        }
    }
    Ok(())
}

fn warnings(reports: &[Report]) -> Vec<MergeWarning> {
    let mut found = Vec::new();
    let environment = &reports[0].environment;
    for report in &reports[1..] {
        let (first, other) = (environment.fingerprint.clone(), report.environment.fingerprint.clone());
        if first != other {
            found.push(MergeWarning::FingerprintsDiffer { first, other });
        }
        let (first, other) = (environment.commit.clone(), report.environment.commit.clone());
        if first != other {
            found.push(MergeWarning::CommitsDiffer { first, other });
        }
    }
    for report in reports.iter().filter(|report| report.interrupted) {
        found.push(MergeWarning::Interrupted {
            shard: report.shard.clone().unwrap_or_else(|| "(whole)".into()),
        });
    }
    found.extend(missing_shards(reports));
    found
}

fn missing_shards(reports: &[Report]) -> Vec<MergeWarning> {
    let shards: Vec<(usize, usize)> = reports.iter().filter_map(shard_numbers).collect();
    let of = shards.iter().map(|shard| shard.1).max().unwrap_or(0);
    // A number of shards far above what was given is a slip of the pen, not a list to print.
    let missing = (1..=of.min(10_000)).filter(|&i| !shards.contains(&(i, of)));
    missing.map(|missing| MergeWarning::ShardMissing { missing, of }).collect()
}

fn shard_numbers(report: &Report) -> Option<(usize, usize)> {
    let (number, of) = report.shard.as_ref()?.split_once('/')?;
    Some((number.parse().ok()?, of.parse().ok()?))
}
