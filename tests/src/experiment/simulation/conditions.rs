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

/// What holds a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Held {
    /// It is displaced from rest by so much [m]: in proportion to the load, or at once where there is time.
    Displaced(Vec3),
    /// It moves from rest with this velocity [m/s].
    Moving(Vec3),
}

impl Held {
    /// Where a point that rests at `rest` is at `time` [s].
    pub(crate) fn at(self, rest: &Vec3, time: f64) -> Vec3 {
        match self {
            Self::Displaced(displacement) => rest + displacement,
            Self::Moving(velocity) => rest + velocity * time,
        }
    }

    /// Its velocity from the start on [m/s].
    pub(crate) fn velocity(self) -> Vec3 {
        match self {
            Self::Displaced(_) => Vec3::zeros(),
            Self::Moving(velocity) => velocity,
        }
    }
}

/// Held points and forces at the full load.
pub(crate) struct Conditions {
    /// Points and what holds them, in the order of the points.
    pub(crate) held: Vec<(u32, Held)>,
    /// One force a point [N].
    pub(crate) forces: Vec<Vec3>,
}

impl Conditions {
    /// The conditions of a scene on its bodies.
    pub(crate) fn new(scene: &SceneFile, bodies: &Bodies) -> Result<Self, ExperimentError> {
        let held = held(scene, bodies)?;
        let mut forces = vec![Vec3::zeros(); bodies.mesh().points().len()];
        for (index, load) in scene.loads.iter().enumerate() {
            add_load(&format!("loads.{index}"), load, bodies, &mut forces)?;
        }
        Ok(Self { held: held.into_iter().map(|(point, (held, _))| (point, held)).collect(), forces })
    }

    /// The displacements [m] of held points, of bodies that are to be in equilibrium: each must be held.
    pub(crate) fn displacements(
        &self,
        scene: &SceneFile,
        bodies: &Bodies,
    ) -> Result<Vec<(u32, Vec3)>, ExperimentError> {
        if let Some(index) = scene.boundary.iter().position(|b| matches!(b.motion, Motion::Moving { .. })) {
            let key = format!("boundary.{index}.motion.moving");
            return Err(refused(key, "an equilibrium has no velocity; use `prescribed`"));
        }
        let is_held =
            |body: &Body| self.held.iter().any(|(point, _)| body.points.contains(&(*point as usize)));
        if let Some(index) = bodies.each().iter().position(|body| !is_held(body)) {
            let reason = "no boundary condition holds a point of this mesh, so its equilibrium is not unique";
            return Err(refused(format!("meshes.{index}"), reason));
        }
        Ok(self.held.iter().map(|&(point, held)| (point, held.at(&Vec3::zeros(), 0.0))).collect())
    }
}

/// Where the points start: at rest, or stretched about their centre of mass.
pub(crate) fn start(scene: &SceneFile, bodies: &Bodies) -> Result<Vec<Vec3>, ExperimentError> {
    let mut x = bodies.mesh().points().to_vec();
    for initial in &scene.initial {
        let body = named(bodies, &initial.mesh)?;
        if let (Some(stretch), Some(centre)) = (initial.stretch, body.mesh.centroid()) {
            let stretch = Vec3::from(stretch.map(Positive::value));
            for x in &mut x[body.points.clone()] {
                *x = centre + (*x - centre).component_mul(&stretch);
            }
        }
    }
    Ok(x)
}

/// How fast points at `x` start: v + ω × (x − c), c the centre of mass of their body.
pub(crate) fn start_velocity(
    scene: &SceneFile,
    bodies: &Bodies,
    x: &[Vec3],
) -> Result<Vec<Vec3>, ExperimentError> {
    let mut v = vec![Vec3::zeros(); x.len()];
    for InitialCondition { mesh, velocity_m_s, angular_velocity_rad_s, .. } in &scene.initial {
        let body = named(bodies, mesh)?;
        let [velocity, spin] = [velocity_m_s, angular_velocity_rad_s]
            .map(|given| given.as_ref().map(vector).unwrap_or_default());
        let centre = body.mesh.centroid().unwrap_or_default();
        for point in body.points.clone() {
            v[point] += velocity + spin.cross(&(x[point] - centre));
        }
    }
    Ok(v)
}

/// Refuses velocities, which mean nothing in an equilibrium.
pub(crate) fn refuse_velocities(scene: &SceneFile) -> Result<(), ExperimentError> {
    for (index, initial) in scene.initial.iter().enumerate() {
        let given = [
            ("velocity_m_s", initial.velocity_m_s),
            ("angular_velocity_rad_s", initial.angular_velocity_rad_s),
        ];
        if let Some((name, _)) = given.into_iter().find(|(_, given)| given.is_some()) {
            return Err(refused(format!("initial.{index}.{name}"), "has no meaning in an equilibrium"));
        }
    }
    Ok(())
}

/// Each held point with what holds it and the condition that says so.
fn held(scene: &SceneFile, bodies: &Bodies) -> Result<BTreeMap<u32, (Held, usize)>, ExperimentError> {
    let mut held: BTreeMap<u32, (Held, usize)> = BTreeMap::new();
    for (index, condition) in scene.boundary.iter().enumerate() {
        let key = format!("boundary.{index}");
        let motion = motion(&format!("{key}.motion"), &condition.motion)?;
        let body = named(bodies, &condition.mesh)?;
        for point in selected(&format!("{key}.select"), body, &condition.select)? {
            let point = (body.points.start + point) as u32;
            let (earlier, by) = *held.entry(point).or_insert((motion, index));
            if earlier != motion {
                let reason =
                    format!("moves point {point} otherwise than boundary condition {by} (from 0) does");
                return Err(refused(format!("{key}.motion"), reason));
            }
        }
    }
    Ok(held)
}

fn motion(key: &str, motion: &Motion) -> Result<Held, ExperimentError> {
    match motion {
        Motion::Fixed { axes } if [Axis::X, Axis::Y, Axis::Z].iter().all(|axis| axes.contains(axis)) => {
            Ok(Held::Displaced(Vec3::zeros()))
        }
        Motion::Fixed { .. } => Err(refused(
            format!("{key}.fixed.axes"),
            "points can be held along all axes only, [\"x\", \"y\", \"z\"]; sliding along some is not available yet",
        )),
        Motion::Prescribed { displacement_m } => Ok(Held::Displaced(vector(displacement_m))),
        Motion::Moving { velocity_m_s } => Ok(Held::Moving(vector(velocity_m_s))),
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
