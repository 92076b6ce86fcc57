//! What holds and loads a scene's bodies.

use super::bodies::{Bodies, Body};
use super::refused;
use crate::experiment::ExperimentError;
use crate::scene::SceneFile;
use crate::scene::physics::{Axis, InitialCondition, Load, Motion, Selector};
use crate::scene::quantity::{Finite, Positive, Vector};
use mechanics_core::mesh::{Surface, triangle_area_vector};
use mechanics_core::tensor::Vec3;
use std::collections::BTreeMap;

/// Held points and forces at the full load.
pub(crate) struct Conditions {
    /// Points and their displacements [m], in the order of the points.
    pub(crate) displacements: Vec<(u32, Vec3)>,
    /// One force a point [N].
    pub(crate) forces: Vec<Vec3>,
}

impl Conditions {
    /// The conditions of a scene on its bodies.
    pub(crate) fn new(scene: &SceneFile, bodies: &Bodies) -> Result<Self, ExperimentError> {
        let displacements = displacements(scene, bodies)?;
        let is_held =
            |body: &Body| displacements.keys().any(|&point| body.points.contains(&(point as usize)));
        if let Some(index) = bodies.each().iter().position(|body| !is_held(body)) {
            let reason = "no boundary condition holds a point of this mesh, so its equilibrium is not unique";
            return Err(refused(format!("meshes.{index}"), reason));
        }
        let mut forces = vec![Vec3::zeros(); bodies.mesh().points().len()];
        for (index, load) in scene.loads.iter().enumerate() {
            add_load(&format!("loads.{index}"), load, bodies, &mut forces)?;
        }
        Ok(Self {
            displacements: displacements.into_iter().map(|(point, (u, _))| (point, u)).collect(),
            forces,
        })
    }
}

/// Where the points start: at rest, or stretched about their centre of mass.
pub(crate) fn start(scene: &SceneFile, bodies: &Bodies) -> Result<Vec<Vec3>, ExperimentError> {
    let mut x = bodies.mesh().points().to_vec();
    for (index, initial) in scene.initial.iter().enumerate() {
        let InitialCondition { mesh, velocity_m_s, angular_velocity_rad_s, stretch } = initial;
        for (name, given) in
            [("velocity_m_s", velocity_m_s), ("angular_velocity_rad_s", angular_velocity_rad_s)]
        {
            if given.is_some() {
                return Err(refused(format!("initial.{index}.{name}"), "has no meaning in an equilibrium"));
            }
        }
        let body = named(bodies, mesh)?;
        if let (Some(stretch), Some(centre)) = (stretch, body.mesh.centroid()) {
            let stretch = Vec3::from(stretch.map(Positive::value));
            for x in &mut x[body.points.clone()] {
                *x = centre + (*x - centre).component_mul(&stretch);
            }
        }
    }
    Ok(x)
}

/// Each held point with its displacement [m] and the condition that says so.
fn displacements(
    scene: &SceneFile,
    bodies: &Bodies,
) -> Result<BTreeMap<u32, (Vec3, usize)>, ExperimentError> {
    let mut held: BTreeMap<u32, (Vec3, usize)> = BTreeMap::new();
    for (index, condition) in scene.boundary.iter().enumerate() {
        let key = format!("boundary.{index}");
        let displacement = displacement(&format!("{key}.motion"), &condition.motion)?;
        let body = named(bodies, &condition.mesh)?;
        for point in selected(&format!("{key}.select"), body, &condition.select)? {
            let point = (body.points.start + point) as u32;
            let (earlier, by) = *held.entry(point).or_insert((displacement, index));
            if earlier != displacement {
                let reason =
                    format!("moves point {point} otherwise than boundary condition {by} (from 0) does");
                return Err(refused(format!("{key}.motion"), reason));
            }
        }
    }
    Ok(held)
}

fn displacement(key: &str, motion: &Motion) -> Result<Vec3, ExperimentError> {
    match motion {
        Motion::Fixed { axes } if [Axis::X, Axis::Y, Axis::Z].iter().all(|axis| axes.contains(axis)) => {
            Ok(Vec3::zeros())
        }
        Motion::Fixed { .. } => Err(refused(
            format!("{key}.fixed.axes"),
            "points can be held along all axes only, [\"x\", \"y\", \"z\"]; sliding along some is not available yet",
        )),
        Motion::Prescribed { displacement_m } => Ok(vector(displacement_m)),
        Motion::Moving { .. } => {
            Err(refused(format!("{key}.moving"), "an equilibrium has no velocity; use `prescribed`"))
        }
    }
}

fn add_load(key: &str, load: &Load, bodies: &Bodies, forces: &mut [Vec3]) -> Result<(), ExperimentError> {
    match load {
        Load::Gravity { acceleration_m_s2 } => {
            bodies.each().iter().for_each(|body| add_weight(body, &vector(acceleration_m_s2), forces));
        }
        Load::NodalForce { mesh, select, force_n } => {
            let body = named(bodies, mesh)?;
            for point in selected(&format!("{key}.nodal-force.select"), body, select)? {
                forces[body.points.start + point] += vector(force_n);
            }
        }
        Load::Traction { mesh, select, traction_pa } => {
            let body = named(bodies, mesh)?;
            let key = format!("{key}.traction.select");
            let points = selected(&key, body, select)?;
            if add_traction(body, &points, &vector(traction_pa), forces)? == 0 {
                return Err(refused(key, "selects no whole triangle of the mesh's boundary"));
            }
        }
    }
    Ok(())
}

/// The weight of linear tetrahedra: a quarter of each one's to each of its corners, which is exact.
fn add_weight(body: &Body, acceleration: &Vec3, forces: &mut [Vec3]) {
    for (cell, volume) in body.mesh.cells().iter().zip(body.mesh.volumes()) {
        for &node in cell {
            forces[body.points.start + node as usize] += acceleration * (0.25 * body.density * volume);
        }
    }
}

/// A third of each boundary triangle's force to each of its corners; answers how many triangles there are.
fn add_traction(
    body: &Body,
    points: &[usize],
    traction: &Vec3,
    forces: &mut [Vec3],
) -> Result<usize, ExperimentError> {
    let surface = Surface::of_tets(&body.mesh).map_err(ExperimentError::stopped)?;
    let mut loaded = 0;
    for triangle in surface.triangles() {
        let source = triangle.map(|corner| surface.source_points()[corner as usize] as usize);
        // `selected` answers in ascending order.
        if source.iter().all(|point| points.binary_search(point).is_ok()) {
            loaded += 1;
            let area = triangle_area_vector(&source.map(|point| body.mesh.points()[point])).norm();
            for point in source {
                forces[body.points.start + point] += traction * (area / 3.0);
            }
        }
    }
    Ok(loaded)
}

/// The points of a body, ascending, that a selector takes, by their rest positions.
fn selected(key: &str, body: &Body, select: &Selector) -> Result<Vec<usize>, ExperimentError> {
    let takes: Box<dyn Fn(&Vec3) -> bool> = match select {
        Selector::All {} => Box::new(|_| true),
        Selector::Box { min_m, max_m } => {
            let (min, max) = (vector(min_m), vector(max_m));
            Box::new(move |x| (0..3).all(|k| min[k] <= x[k] && x[k] <= max[k]))
        }
        Selector::Plane { point_m, normal, within_m } => {
            let (point, normal, within) = (vector(point_m), vector(normal).normalize(), within_m.value());
            Box::new(move |x| (x - point).dot(&normal) >= -within)
        }
    };
    let points: Vec<usize> =
        body.mesh.points().iter().enumerate().filter(|(_, x)| takes(x)).map(|(i, _)| i).collect();
    if points.is_empty() {
        return Err(refused(key, format!("selects no point of `{}`", body.name)));
    }
    Ok(points)
}

fn named<'a>(bodies: &'a Bodies, name: &str) -> Result<&'a Body, ExperimentError> {
    // The scene was checked: the mesh is there.
    let found = bodies.each().iter().find(|body| body.name == name);
    found.ok_or_else(|| refused("meshes", format!("there is no mesh `{name}`")))
}

fn vector(components: &Vector) -> Vec3 {
    Vec3::from(components.map(Finite::value))
}
