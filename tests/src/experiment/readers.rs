//! Mesh readers on a real mesh: what is read is what stands in the file, and how long it takes.

use super::{Clock, Experiment, ExperimentError, Outcome, Point};
use mechanics_core::mesh::io::{MeshFileError, obj, ply};
use mechanics_core::mesh::{Surface, TriMesh};
use mechanics_core::state::StateHash;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::PathBuf;

/// An OBJ file of one `v` line a point, in each format; the ladder is how many copies of it stand side by side.
///
/// The truth is the text itself, its decimal numbers rounded to the nearest double by Rust's standard library.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MeshReaders {
    /// The file, relative to the scene's folder.
    path: PathBuf,
}

impl Experiment for MeshReaders {
    fn methods(&self) -> &'static [&'static str] {
        &["obj", "ply text", "ply binary"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let path = at.folder.join(&self.path);
        let text = std::fs::read_to_string(&path)
            .map_err(|source| ExperimentError::Read { path: path.clone(), source })?;
        let one = obj::read(text.as_bytes()).map_err(ExperimentError::stopped)?;
        let mut mesh = one.clone();
        for _ in 1..at.ladder as usize {
            mesh.append(&one).map_err(ExperimentError::stopped)?;
        }
        let bytes = written(&mesh, at.method).map_err(ExperimentError::stopped)?;
        let read = clock.time(|| if at.method == "obj" { obj::read(&bytes) } else { ply::read(&bytes) });
        let read = read.map_err(ExperimentError::stopped)?;
        let truth = points_of(&text);
        let expected = truth.iter().cycle().take(truth.len() * at.ladder as usize);
        let apart = read.points().iter().zip(expected).map(|(found, true_point)| (found - true_point).norm());
        let surface = Surface::of_triangles(&read);
        let mut hash = StateHash::new();
        hash.add_vectors("points", read.points());
        Ok(Outcome::default()
            .error("position", apart.fold(0.0, f64::max))
            .count("points", read.points().len() as u64)
            .count("triangles", read.triangles().len() as u64)
            .count("bytes", bytes.len() as u64)
            .invariant("points missing", truth.len() as f64 * at.ladder - read.points().len() as f64)
            .invariant("Euler characteristic a copy", surface.euler_characteristic() as f64 / at.ladder)
            .state(hash.value()))
    }
}

fn written(mesh: &TriMesh, method: &str) -> Result<Vec<u8>, MeshFileError> {
    let mut bytes = Vec::new();
    match method {
        "obj" => obj::write(mesh, &mut bytes)?,
        "ply text" => ply::write(mesh, ply::PlyEncoding::Ascii, &mut bytes)?,
        _ => ply::write(mesh, ply::PlyEncoding::Binary(ply::ByteOrder::LittleEndian), &mut bytes)?,
    }
    Ok(bytes)
}

/// The points of an OBJ text, by the plainest reading of it.
fn points_of(text: &str) -> Vec<Vec3> {
    let numbers = |line: &str| {
        let mut words = line.split_whitespace().skip(1).map(|word| word.parse().unwrap_or(f64::NAN));
        Vec3::from_fn(|_, _| words.next().unwrap_or(f64::NAN))
    };
    text.lines().filter(|line| line.starts_with("v ")).map(numbers).collect()
}
