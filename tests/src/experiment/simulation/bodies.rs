//! A scene's meshes and materials as bodies of tetrahedra.

use super::refused;
use crate::experiment::ExperimentError;
use crate::experiment::solid::elastic_term;
use crate::experiment::solid::element::RestShapes;
use crate::experiment::solid::material::{Stress, stress, von_mises};
use crate::scene::SceneFile;
use crate::scene::physics::{Law, Mesh, MeshSource};
use crate::scene::quantity::{Finite, Positive};
use mechanics_core::mesh::io::msh;
use mechanics_core::mesh::{BoxSplit, Surface, TetMesh, ball, block, cylinder};
use mechanics_core::potential::Potential;
use mechanics_core::tensor::Vec3;
use std::ops::Range;
use std::path::Path;

/// All bodies of a scene; the points of body after body are one list.
pub(crate) struct Bodies {
    bodies: Vec<Body>,
    mesh: TetMesh,
    surface: Surface,
}

/// A body: a mesh of one material.
pub(crate) struct Body {
    /// The mesh's name in the scene.
    pub(crate) name: String,
    /// Its own mesh at rest.
    pub(crate) mesh: TetMesh,
    /// Its points in the list of all.
    pub(crate) points: Range<usize>,
    /// [kg/m³]
    pub(crate) density: f64,
    law: Law,
    rest: RestShapes,
    stress: Stress,
}

/// The deformation of every tetrahedron.
pub(crate) struct CellFields {
    /// det F [1].
    pub(crate) volume_ratio: Vec<f64>,
    /// Of the Cauchy stress [Pa].
    pub(crate) von_mises: Vec<f64>,
    /// Which body, from 0.
    pub(crate) body: Vec<i32>,
}

impl Bodies {
    /// Makes or reads all meshes of a scene whose file is in `folder`.
    pub(crate) fn new(scene: &SceneFile, folder: &Path) -> Result<Self, ExperimentError> {
        let mut bodies: Vec<Body> = Vec::new();
        let mut start = 0;
        for (index, mesh) in scene.meshes.iter().enumerate() {
            let body = Body::new(index, mesh, scene, folder, start)?;
            start = body.points.end;
            bodies.push(body);
        }
        let mut mesh = TetMesh::new(Vec::new(), Vec::new()).map_err(ExperimentError::stopped)?;
        for (index, body) in bodies.iter().enumerate() {
            mesh.append(&body.mesh).map_err(|error| refused(format!("meshes.{index}"), error))?;
        }
        let surface = Surface::of_tets(&mesh).map_err(|error| refused("meshes", error))?;
        Ok(Self { bodies, mesh, surface })
    }

    /// The bodies, in the scene's order.
    pub(crate) fn each(&self) -> &[Body] {
        &self.bodies
    }

    /// All points and tetrahedra at rest.
    pub(crate) fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// Their boundary.
    pub(crate) fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The elastic energies.
    pub(crate) fn terms(&self) -> Result<Vec<Box<dyn Potential>>, ExperimentError> {
        let term = |body: &Body| {
            let name = format!("elasticity of {}", body.name);
            elastic_term(&name, &body.law, &body.mesh, body.points.start as u32)
                .map_err(ExperimentError::stopped)
        };
        self.bodies.iter().map(term).collect()
    }

    /// Deformation and stress with all points at `x`.
    pub(crate) fn cell_fields(&self, x: &[Vec3]) -> CellFields {
        let mut fields = CellFields { volume_ratio: Vec::new(), von_mises: Vec::new(), body: Vec::new() };
        for (index, body) in self.bodies.iter().enumerate() {
            let x = &x[body.points.clone()];
            for (cell, nodes) in body.mesh.cells().iter().enumerate() {
                let f = body.rest.deformation_gradient(cell, &nodes.map(|node| x[node as usize]));
                fields.volume_ratio.push(f.determinant());
                fields.von_mises.push(von_mises(&(body.stress)(&f), &f));
                fields.body.push(index as i32);
            }
        }
        fields
    }
}

impl Body {
    fn new(
        index: usize,
        mesh: &Mesh,
        scene: &SceneFile,
        folder: &Path,
        start: usize,
    ) -> Result<Self, ExperimentError> {
        let key = format!("meshes.{index}");
        // The scene was checked: the material is there.
        let found = scene.materials.iter().position(|material| material.name == mesh.material);
        let number = found.ok_or_else(|| refused(format!("{key}.material"), "there is no such material"))?;
        let material = &scene.materials[number];
        let tets = placed(tetrahedra(&key, &mesh.source, folder)?, mesh)
            .map_err(|error| refused(key.as_str(), error))?;
        let rest = RestShapes::of(&tets).map_err(|error| refused(format!("{key}.source"), error))?;
        let stress =
            stress(&material.law).map_err(|error| refused(format!("materials.{number}.law"), error))?;
        Ok(Self {
            name: mesh.name.clone(),
            points: start..start + tets.points().len(),
            mesh: tets,
            density: material.density_kg_m3.value(),
            law: material.law.clone(),
            rest,
            stress,
        })
    }
}

/// The tetrahedra of a source, before they are moved. Points that no tetrahedron uses are left out: nothing would
/// determine where they go.
fn tetrahedra(key: &str, source: &MeshSource, folder: &Path) -> Result<TetMesh, ExperimentError> {
    let failed = |error: &dyn std::fmt::Display| refused(format!("{key}.source"), error);
    let cells = |length: Positive, edge: Positive| (length.value() / edge.value()).ceil().max(1.0) as u32;
    let surface = |kind: &str| {
        refused(
            format!("{key}.source.{kind}"),
            "a solid needs tetrahedra, this source makes none; use `file` with an \
            MSH file, `box`, `sphere` or `cylinder`",
        )
    };
    match source {
        MeshSource::File { path, scale_m } => {
            let path_key = format!("{key}.source.file.path");
            if !Path::new(path).extension().is_some_and(|e| e.eq_ignore_ascii_case("msh")) {
                return Err(refused(
                    path_key,
                    "a solid needs tetrahedra, which are read from MSH files only",
                ));
            }
            let file =
                msh::read_file(folder.join(path)).map_err(|error| refused(path_key.as_str(), error))?;
            let mut mesh = file.tet_mesh().map_err(|error| refused(path_key.as_str(), error))?;
            if mesh.cells().is_empty() {
                return Err(refused(path_key, "the file has no tetrahedra"));
            }
            mesh.remove_unreferenced();
            mesh.scale(scale_m.map_or(1.0, Positive::value)).map_err(|error| failed(&error))?;
            Ok(mesh)
        }
        MeshSource::Box { size_m, cells } => {
            let size = Vec3::from(size_m.map(Positive::value));
            let cells = cells.map(|count| count.value() as u32);
            block(&Vec3::zeros(), &size, cells, BoxSplit::Six).map_err(|error| failed(&error))
        }
        MeshSource::Sphere { radius_m, edge_m } => {
            ball(radius_m.value(), cells(*radius_m, *edge_m)).map_err(|error| failed(&error))
        }
        MeshSource::Cylinder { radius_m, height_m, edge_m } => {
            let (rings, layers) = (cells(*radius_m, *edge_m), cells(*height_m, *edge_m));
            cylinder(radius_m.value(), height_m.value(), rings, layers).map_err(|error| failed(&error))
        }
        MeshSource::Cloth { .. } => Err(surface("cloth")),
        MeshSource::Rod { .. } => Err(surface("rod")),
        MeshSource::HeightField { .. } => Err(surface("height-field")),
    }
}

/// The mesh turned and moved as the scene says: x ↦ x cos θ + k × x sin θ + k (k·x)(1 − cos θ), then translated.
fn placed(mut mesh: TetMesh, placement: &Mesh) -> Result<TetMesh, mechanics_core::mesh::MeshError> {
    let vector = |given: Option<[Finite; 3]>| given.map(|v| Vec3::from(v.map(Finite::value)));
    if let Some(rotation) = vector(placement.rotation_rad)
        && let Some(axis) = rotation.try_normalize(0.0)
    {
        let (sin, cos) = rotation.norm().sin_cos();
        mesh.map_points(|x| x * cos + axis.cross(x) * sin + axis * (axis.dot(x) * (1.0 - cos)))?;
    }
    if let Some(translation) = vector(placement.translation_m) {
        mesh.translate(&translation)?;
    }
    Ok(mesh)
}
