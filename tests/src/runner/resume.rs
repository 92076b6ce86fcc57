//! Results of finished scenes in the output folder, so that a run can go on where another stopped.

use super::environment::fnv1a;
use super::output::{OutputError, write_file};
use super::plan::Plan;
use crate::record::{Environment, SceneRecord};
use serde::{Deserialize, Serialize};
use std::path::Path;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Finished {
    key: String,
    record: SceneRecord,
}

/// What must be the same for a result to be taken over: the program and the machine.
pub(crate) fn program_identity(program: &Path, environment: &Environment) -> String {
    // A program that cannot be read now cannot be started either; the run reports that.
    let hash = std::fs::read(program).map_or(0, |bytes| fnv1a(&bytes));
    format!("{hash:016x} {}", environment.fingerprint)
}

/// What must be the same for a scene's result to be taken over: the scene, the rows, the program, the machine.
pub(crate) fn key(plan: &Plan<'_>, identity: &str) -> String {
    let rows = format!("{} {:?} {}", plan.points, plan.threads, plan.repeats);
    format!("{:016x}", fnv1a(format!("{identity}\n{rows}\n{}", plan.scene.text).as_bytes()))
}

/// The result of an earlier run, if there is one and it has this key.
pub(crate) fn read(path: &Path, key: &str) -> Result<Option<SceneRecord>, OutputError> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(OutputError::Read { path: path.to_owned(), source }),
    };
    let finished: Finished = serde_json::from_str(&text)
        .map_err(|error| OutputError::Format { path: path.to_owned(), reason: error.to_string() })?;
    Ok((finished.key == key).then_some(finished.record))
}

/// Keeps a scene's result.
pub(crate) fn write(path: &Path, key: &str, record: &SceneRecord) -> Result<(), OutputError> {
    let finished = Finished { key: key.to_owned(), record: record.clone() };
    let text = serde_json::to_vec(&finished)
        .map_err(|error| OutputError::Format { path: path.to_owned(), reason: error.to_string() })?;
    Ok(write_file(path, &text)?)
}
