//! Reference trajectories: JSON files with 32 digits a number, each with its parameters, start and samples.

use crate::experiment::{ExperimentError, Point};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// A trajectory of high precision.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Reference {
    /// The system's parameters by name; none where the file states them otherwise.
    #[serde(default)]
    params: BTreeMap<String, f64>,
    /// Coordinates at the start.
    pub(super) q0: Vec<f64>,
    /// Velocities at the start.
    pub(super) qdot0: Vec<f64>,
    /// max |δx(T)| / |δx(0)| over small changes δx(0) of the start, for sensitive systems.
    #[serde(default, rename = "perturbation_growth_to_T")]
    pub(super) growth: Option<f64>,
    /// Where the motion is known.
    pub(super) samples: Vec<Sample>,
}

/// The motion at one time.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Sample {
    /// Time (s).
    pub(super) t: f64,
    /// Coordinates.
    #[serde(deserialize_with = "numbers")]
    pub(super) q: Vec<f64>,
    /// Velocities.
    #[serde(deserialize_with = "numbers")]
    pub(super) qdot: Vec<f64>,
}

/// A reference trajectory that cannot be used.
#[derive(Debug, thiserror::Error)]
pub(super) enum ReferenceError {
    /// It is not what its format says.
    #[error("reference trajectory {file}: {source}")]
    Format { file: String, source: serde_json::Error },
    /// A parameter is missing.
    #[error("the reference trajectory has no parameter `{name}`")]
    Parameter { name: String },
    /// A length is wrong.
    #[error("the reference trajectory has {found} coordinates, the system has {expected}")]
    Dimension { found: usize, expected: usize },
}

impl Reference {
    /// The file at `path` relative to the scene's folder.
    pub(super) fn read(at: &Point<'_>, path: &str) -> Result<Self, ExperimentError> {
        read_json(at.folder, path)
    }

    /// The parameter called `name`.
    pub(super) fn parameter(&self, name: &str) -> Result<f64, ExperimentError> {
        let missing = || ExperimentError::stopped(ReferenceError::Parameter { name: name.to_owned() });
        self.params.get(name).copied().ok_or_else(missing)
    }

    /// Coordinates and velocities at the start.
    pub(super) fn start<const N: usize>(&self) -> Result<([f64; N], [f64; N]), ExperimentError> {
        let array = |values: &[f64]| {
            values.try_into().map_err(|_| {
                ExperimentError::stopped(ReferenceError::Dimension { found: values.len(), expected: N })
            })
        };
        Ok((array(&self.q0)?, array(&self.qdot0)?))
    }
}

/// A JSON file at `path` relative to `folder`.
pub(super) fn read_json<T: serde::de::DeserializeOwned>(
    folder: &Path,
    path: &str,
) -> Result<T, ExperimentError> {
    let file = folder.join(path);
    let text =
        std::fs::read_to_string(&file).map_err(|source| ExperimentError::Read { path: file, source })?;
    serde_json::from_str(&text)
        .map_err(|source| ExperimentError::stopped(ReferenceError::Format { file: path.to_owned(), source }))
}

/// Numbers that are written as text, because JSON's readers would round them early.
pub(super) fn numbers<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    let texts = Vec::<String>::deserialize(deserializer)?;
    texts.iter().map(|text| text.parse().map_err(serde::de::Error::custom)).collect()
}

/// As [`numbers`], a single one.
pub(super) fn number<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
}
