//! Scene files: what they may say, reading them, and errors that show file, line, value and what is allowed.
//!
//! A scene is a TOML file. Its physical part ([`physics`]) names meshes, materials, conditions, integration, solver
//! and output; its `[experiment]` names a registered Rust function and its parameters, for work that is not the
//! motion of bodies (kernels, linear solvers, readers) or whose truth needs code; its `[validation]` part
//! ([`validation`]) states a claim and how it is judged. `tests/README.md` shows one of each.

mod consistency;
mod location;
pub mod physics;
pub mod quantity;
mod schema;
pub mod selection;
pub mod splats;
pub mod validation;

pub use schema::schema;

use crate::experiment::{Experiment, registry};
use physics::{
    BoundaryCondition, Contact, InitialCondition, Integration, Load, Material, Mesh, Output, Solver,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use splats::SplatScene;
use std::ops::Range;
use std::path::{Path, PathBuf};
use validation::Validation;

/// What a scene file says.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// A registered experiment; the physical part is simulated when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub experiment: Option<ExperimentChoice>,
    /// Meshes.
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    /// Materials.
    #[serde(default)]
    pub materials: Vec<Material>,
    /// Initial conditions; at rest when absent.
    #[serde(default)]
    pub initial: Vec<InitialCondition>,
    /// Conditions on the motion of points.
    #[serde(default)]
    pub boundary: Vec<BoundaryCondition>,
    /// Loads.
    #[serde(default)]
    pub loads: Vec<Load>,
    /// Contact; bodies pass through each other when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact: Option<Contact>,
    /// How time goes on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub integration: Option<Integration>,
    /// How the equations are solved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solver: Option<Solver>,
    /// Gaussian splats that move.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub splats: Option<SplatScene>,
    /// What is written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<Output>,
    /// What is claimed and how it is judged; a scene without it can be run, not validated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation: Option<Validation>,
}

/// A registered experiment and its parameters.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExperimentChoice {
    /// Its name in the registry.
    pub name: String,
    /// Its parameters; which they are depends on the experiment.
    #[serde(default)]
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub parameters: toml::Table,
}

/// A scene that was read and found consistent.
pub struct Scene {
    /// `folder/file-stem`: the crate it validates and its own name.
    pub name: String,
    /// The file.
    pub path: PathBuf,
    /// The file's text.
    pub text: String,
    /// What it says.
    pub file: SceneFile,
    /// The experiment it runs, parameters read.
    pub experiment: Box<dyn Experiment>,
}

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file says something that is not allowed.
    #[error("{}:{line}:{column}: {message}\n    {line} | {excerpt}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The line, from one.
        line: usize,
        /// The column, from one.
        column: usize,
        /// That line's text, which holds the value.
        excerpt: String,
        /// What is wrong and what is allowed.
        message: String,
    },
    /// A value of the ladder or a method's name does not fit the key that takes it.
    #[error("{}: with `{key}` set to {value}: {reason}", path.display())]
    Substitution {
        /// The file.
        path: PathBuf,
        /// The key that takes the value.
        key: String,
        /// The value.
        value: String,
        /// Why it does not fit.
        reason: String,
    },
    /// The folder of scenes cannot be listed.
    #[error("{}: no scenes can be read here: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Nothing has the name that was asked for.
    #[error("no scene matches `{pattern}`; there are: {known}")]
    UnknownScene {
        /// The name or pattern.
        pattern: String,
        /// The scenes there are.
        known: String,
    },
}

/// Something inconsistent in a scene: the key at fault and what is wrong with it.
pub(crate) struct Inconsistency {
    pub(crate) key: String,
    pub(crate) message: String,
}

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    /// When the file cannot be read, has an unknown key, a value outside its range, or parts that do not fit
    /// together; the error shows file, line and column, the line itself, and what is allowed.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
        Self::parse(path, text)
    }

    /// Reads a scene from the text of a file; `path` gives it its name and the folder of its mesh files.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn parse(path: &Path, text: String) -> Result<Self, SceneError> {
        let file: SceneFile = toml::from_str(&text).map_err(|error| invalid_toml(path, &text, &error))?;
        let misfit = |fault: registry::Misfit| invalid_part(path, &text, fault.span, fault.message);
        let at_key = |fault: Inconsistency| invalid_at(path, &text, &fault);
        let experiment = match &file.experiment {
            Some(choice) => registry::find(&choice.name).map_err(at_key)?.read(&text).map_err(misfit)?,
            None => registry::simulation(),
        };
        let folder = path.parent().unwrap_or(Path::new("."));
        consistency::check(&file, experiment.as_ref(), folder).map_err(at_key)?;
        let scene = Self { name: name_of(path), path: path.to_owned(), text, file, experiment };
        scene.check_substitutions()?;
        Ok(scene)
    }

    /// The crate it validates: the folder its file is in.
    pub fn crate_name(&self) -> &str {
        self.name.split('/').next().unwrap_or_default()
    }

    /// The scene with the ladder's value and the method's name put where `ladder.sets` and `method_sets` say.
    ///
    /// # Errors
    /// When the value does not fit its key.
    pub fn at(&self, ladder: f64, method: &str) -> Result<SceneFile, SceneError> {
        let Some(validation) = &self.file.validation else { return Ok(self.file.clone()) };
        let mut text = self.text.clone();
        let substitutions = [
            (&validation.ladder.sets, format!("{ladder:?}")),
            (&validation.method_sets, toml::Value::from(method).to_string()),
        ];
        for (key, value) in substitutions {
            let Some(key) = key else { continue };
            let fails = |reason: String| SceneError::Substitution {
                path: self.path.clone(),
                key: key.clone(),
                value: value.clone(),
                reason,
            };
            text = location::replace_value(&text, key, &value)
                .ok_or_else(|| fails("the scene has no such key".to_owned()))?;
            toml::from_str::<SceneFile>(&text).map_err(|error| fails(error.message().to_owned()))?;
        }
        toml::from_str(&text).map_err(|error| invalid_toml(&self.path, &text, &error))
    }

    /// The error of a scene whose `key` asks for something that cannot be done.
    pub(crate) fn refusal(&self, key: String, message: String) -> SceneError {
        invalid_at(&self.path, &self.text, &Inconsistency { key, message })
    }

    fn check_substitutions(&self) -> Result<(), SceneError> {
        let Some(validation) = &self.file.validation else { return Ok(()) };
        if validation.ladder.sets.is_none() && validation.method_sets.is_none() {
            return Ok(());
        }
        for value in &validation.ladder.values {
            for method in &validation.methods {
                self.at(value.value(), method)?;
            }
        }
        Ok(())
    }
}

fn name_of(path: &Path) -> String {
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    format!("{}/{}", part(path.parent().and_then(Path::file_name)), part(path.file_stem()))
}

fn invalid_toml(path: &Path, text: &str, error: &toml::de::Error) -> SceneError {
    invalid_part(path, text, error.span(), error.message().to_owned())
}

fn invalid_part(path: &Path, text: &str, part: Option<Range<usize>>, mut message: String) -> SceneError {
    if message.starts_with("unknown field") {
        message.push_str(" (a quantity's unit is part of its key)");
    }
    invalid(path, text, part.map_or(0, |part| part.start), message)
}

fn invalid_at(path: &Path, text: &str, fault: &Inconsistency) -> SceneError {
    // A key that is missing is reported where the table that should hold it stands.
    let mut key = fault.key.as_str();
    let start = loop {
        if let Some(span) = location::span_of(text, key) {
            break span.start;
        }
        match key.rsplit_once('.') {
            Some((parent, _)) => key = parent,
            None => break 0,
        }
    };
    let message = if fault.key.is_empty() {
        fault.message.clone()
    } else {
        format!("`{}`: {}", fault.key, fault.message)
    };
    invalid(path, text, start, message)
}

fn invalid(path: &Path, text: &str, byte: usize, message: String) -> SceneError {
    let (line, column) = location::line_and_column(text, byte);
    let excerpt = text.lines().nth(line - 1).unwrap_or_default().trim_end().to_owned();
    SceneError::Invalid { path: path.to_owned(), line, column, excerpt, message }
}
