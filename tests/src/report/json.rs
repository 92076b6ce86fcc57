//! `report.json` and `env.json`, and the schema of the former.

use crate::record::{Report, SCHEMA_VERSION};
use std::path::{Path, PathBuf};

/// Why a `report.json` could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file is not there or not readable.
    #[error("cannot read {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is not a report.
    #[error("{} is not a report: {source}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column.
        source: serde_json::Error,
    },
    /// It is a report of another version.
    #[error("{} has schema version {found}, this program reads {SCHEMA_VERSION}", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u64,
    },
}

/// `report` as indented JSON.
///
/// # Errors
/// None for numbers that are finite, as the record promises; serde_json writes others as `null`, which does not read back.
pub fn report_json(report: &Report) -> Result<String, serde_json::Error> {
    serde_json::to_string_pretty(report).map(|text| text + "\n")
}

/// Where the report was made, as indented JSON.
///
/// # Errors
/// None in practice: the record holds nothing that JSON cannot hold.
pub fn environment_json(report: &Report) -> Result<String, serde_json::Error> {
    serde_json::to_string_pretty(&report.environment).map(|text| text + "\n")
}

/// The JSON Schema of `report.json`, committed as `tests/schema/report.schema.json`.
///
/// # Errors
/// None in practice.
pub fn report_schema() -> Result<String, serde_json::Error> {
    serde_json::to_string_pretty(&schemars::schema_for!(Report)).map(|text| text + "\n")
}

/// Reads a `report.json`. The version is looked at before the content, so that another version is named as such.
///
/// # Errors
/// [`ReadError`] with the file and, for content, line and column.
pub fn read_report(path: &Path) -> Result<Report, ReadError> {
    #[derive(serde::Deserialize)]
    struct Version {
        schema_version: u64,
    }
    let named = || path.to_owned();
    let content = |source| ReadError::Content { path: named(), source };
    let text = std::fs::read_to_string(path).map_err(|source| ReadError::File { path: named(), source })?;
    let found = serde_json::from_str::<Version>(&text).map_err(content)?.schema_version;
    if found != u64::from(SCHEMA_VERSION) {
        return Err(ReadError::Version { path: named(), found });
    }
    serde_json::from_str(&text).map_err(content)
}
