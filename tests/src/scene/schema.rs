//! The JSON Schema of scene files, by which editors complete and check them.

use super::SceneFile;
use crate::experiment::registry;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

/// The schema of a scene file: that of [`SceneFile`], where `[experiment]` is one of the registered experiments
/// with its own parameters.
pub fn schema() -> Value {
    let mut generator = SchemaSettings::draft2020_12().into_generator();
    let experiments: Vec<Value> = registry::entries()
        .iter()
        .map(|entry| {
            json!({
                "type": "object",
                "description": entry.summary,
                "properties": {
                    "name": { "const": entry.name },
                    "parameters": entry.schema(&mut generator),
                },
                "required": ["name"],
                "additionalProperties": false,
            })
        })
        .collect();
    let mut schema = generator.into_root_schema_for::<SceneFile>().to_value();
    schema["$defs"]["ExperimentChoice"] = json!({
        "description": "A registered experiment and its parameters.",
        "oneOf": experiments,
    });
    schema["title"] = json!("Scene");
    schema
}
