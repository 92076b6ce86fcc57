//! Meshes as geometry knows them, without the collider's code: winding numbers and distances over all triangles, volumes under a level; trays; and
//! pictures of meshes among particles.

use crate::experiment::ExperimentError;
use crate::picture::{
    Bounds, Camera, Decoration, Field, FieldValues, Image, PointSize, Scene3, Size, render,
};
use mechanics_core::mesh::io::obj;
use mechanics_core::mesh::{BoxSplit, Surface, TetMesh, TriMesh, block};
use mechanics_core::tensor::Vec3;
use std::f64::consts::PI;
use std::path::Path;

/// A mesh with y upward, turned so that z is, `height` high, its middle at the origin.
pub(super) fn figure(path: &Path, height: f64) -> Result<TriMesh, ExperimentError> {
    let mut mesh = obj::read_file(path).map_err(ExperimentError::stopped)?;
    let bounds = mesh.bounding_box().ok_or_else(|| ExperimentError::Refused {
        key: "experiment.parameters.mesh".to_owned(),
        reason: "the mesh has no points".to_owned(),
    })?;
    let (middle, factor) = (bounds.centre(), height / bounds.size().y);
    mesh.map_points(|p| {
        let q = (p - middle) * factor;
        Vec3::new(q.x, -q.z, q.y)
    })
    .map_err(ExperimentError::stopped)?;
    Ok(mesh)
}

/// An open box with thick walls, free inside of ±`half` along x and y and above z = 0 up to `height`.
pub(super) fn tray(half: [f64; 2], height: f64) -> Result<TriMesh, ExperimentError> {
    let thick = half[0].max(half[1]);
    let cells = block(&Vec3::zeros(), &Vec3::new(3.0, 3.0, 2.0), [3, 3, 2], BoxSplit::default())
        .map_err(ExperimentError::stopped)?;
    let full = |tet: &usize| {
        let middle = cells.corners(*tet).iter().sum::<Vec3>() / 4.0;
        !((1.0..2.0).contains(&middle.x) && (1.0..2.0).contains(&middle.y) && middle.z > 1.0)
    };
    let kept = (0..cells.cells().len()).filter(full).map(|tet| cells.cells()[tet]).collect();
    let along = |x: f64, half: f64| [-half - thick, -half, half, half + thick][x.round() as usize];
    let place = |p: &Vec3| {
        let z = [-thick, 0.0, height][p.z.round() as usize];
        Vec3::new(along(p.x, half[0]), along(p.y, half[1]), z)
    };
    let points = cells.points().iter().map(place).collect();
    let solid = TetMesh::new(points, kept).map_err(ExperimentError::stopped)?;
    Ok(Surface::of_tets(&solid).map_err(ExperimentError::stopped)?.into_mesh())
}

/// How often a closed mesh winds around a place: Σ of the solid angles of its triangles by 4π.
///
/// # Reference
/// A. van Oosterom, J. Strackee, *The solid angle of a plane triangle*, IEEE Trans. Biomed. Eng. 30(2), 1983, equation 8.
pub(super) fn winding(mesh: &TriMesh, place: &Vec3) -> f64 {
    let angle = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - place);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    (0..mesh.triangles().len()).map(angle).sum::<f64>() / (4.0 * PI)
}

/// The distance of a place from all triangles \[m\].
fn distance(mesh: &TriMesh, place: &Vec3) -> f64 {
    let nearest = |triangle: usize| {
        let corners = mesh.corners(triangle);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
        let sides: [_; 3] = std::array::from_fn(|k| (corners[k], corners[(k + 1) % 3] - corners[k]));
        let over = sides.iter().all(|(start, edge)| normal.cross(edge).dot(&(place - start)) >= 0.0);
        if over {
            return normal.dot(&(place - corners[0])).abs();
        }
        let to_side = |(start, edge): &(Vec3, Vec3)| {
            let part = ((place - start).dot(edge) / edge.norm_squared()).clamp(0.0, 1.0);
            (start + edge * part - place).norm()
        };
        sides.iter().map(to_side).fold(f64::INFINITY, f64::min)
    };
    (0..mesh.triangles().len()).map(nearest).fold(f64::INFINITY, f64::min)
}

/// How many of the places are inside of a closed mesh, and how deep the deepest is \[m\].
pub(super) fn inside(mesh: &TriMesh, places: impl Iterator<Item = Vec3>) -> (u64, f64) {
    let Some(bounds) = mesh.bounding_box() else { return (0, 0.0) };
    let half = 0.5 * bounds.size();
    let within = |place: &Vec3| (0..3).all(|a| (place[a] - bounds.centre()[a]).abs() <= half[a]);
    places
        .filter(within)
        .filter(|place| winding(mesh, place) > 0.5)
        .fold((0, 0.0), |(count, deepest), place| (count + 1, f64::max(deepest, distance(mesh, &place))))
}

/// The volume of a closed mesh below z = `level` \[m³\]: the flux of (0, 0, −(level − z)₊), exactly.
pub(super) fn volume_below(mesh: &TriMesh, level: f64) -> f64 {
    let flux = |triangle: usize| {
        let corners = mesh.corners(triangle);
        let area = 0.5 * (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).z;
        -area * mean_above_zero(corners.map(|corner| level - corner.z))
    };
    (0..mesh.triangles().len()).map(flux).sum()
}

/// The centre of the volume of a closed mesh, by the pyramids of its triangles over the origin \[m\].
pub(super) fn centre_of_volume(mesh: &TriMesh) -> Vec3 {
    let pyramid = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        (a.dot(&b.cross(&c)) / 6.0, (a + b + c) / 4.0)
    };
    let (volume, moment) = (0..mesh.triangles().len())
        .map(pyramid)
        .fold((0.0, Vec3::zeros()), |(sum, moment), (volume, middle)| {
            (sum + volume, moment + middle * volume)
        });
    moment / volume
}

/// The mean over a triangle of max(h, 0), where h is linear with these values at its corners.
fn mean_above_zero(h: [f64; 3]) -> f64 {
    // One corner of one sign cuts off a pyramid: h₁/3 on the part h₁²/((h₁ − h₂)(h₁ − h₃)).
    let pyramid = |one: f64, others: [f64; 2]| one.powi(3) / (3.0 * (one - others[0]) * (one - others[1]));
    let positive: Vec<f64> = h.into_iter().filter(|h| *h > 0.0).collect();
    let rest: Vec<f64> = h.into_iter().filter(|h| *h <= 0.0).collect();
    match (positive.as_slice(), rest.as_slice()) {
        ([], _) => 0.0,
        (&[a], &[b, c]) => pyramid(a, [b, c]),
        (&[a, b], &[c]) => (a + b + c) / 3.0 + pyramid(-c, [-a, -b]),
        _ => h.iter().sum::<f64>() / 3.0,
    }
}

/// Particles behind the plane y = `front`, coloured by a value each, and grey meshes.
pub(super) struct Section<'a> {
    pub(super) positions: &'a [[f64; 3]],
    pub(super) values: &'a [f64],
    pub(super) meshes: &'a [TriMesh],
    pub(super) front: f64,
    pub(super) radius: f64,
    pub(super) field: (&'static str, &'static str),
    pub(super) range: Option<(f64, f64)>,
    pub(super) towards: [f64; 3],
    pub(super) frame: ([f64; 3], [f64; 3]),
    pub(super) label: String,
}

impl Section<'_> {
    pub(super) fn drawn(&self, size: (usize, usize)) -> Image {
        let seen = (0..self.positions.len()).filter(|p| self.positions[*p][1] >= self.front);
        let mut scene = Scene3 {
            point_size: PointSize::World(self.radius),
            decorations: vec![Decoration::Axes],
            caption: self.label.clone(),
            ..Scene3::default()
        };
        let mut values = Vec::new();
        for particle in seen {
            scene.points.push(scene.positions.len());
            scene.positions.push(self.positions[particle]);
            values.push(self.values[particle]);
        }
        for mesh in self.meshes {
            let first = scene.positions.len();
            scene.positions.extend(mesh.points().iter().map(|p| <[f64; 3]>::from(*p)));
            scene.triangles.extend(mesh.triangles().iter().map(|t| t.map(|k| first + k as usize)));
            // Not a number: grey.
            values.resize(scene.positions.len(), f64::NAN);
        }
        let (name, unit) = self.field;
        scene.field = Some(Field {
            name: name.to_owned(),
            unit: unit.to_owned(),
            values: FieldValues::Positions(values),
            range: self.range,
            map: crate::picture::ColourMap::default(),
        });
        let (low, high) = self.frame;
        let camera = Camera { towards: self.towards, frame: Some(Bounds { low, high }), ..Camera::default() };
        render(&scene, &camera, Size { width: size.0, height: size.1 })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use super::*;
    use mechanics_core::mesh::sphere;

    #[test]
    fn geometry_is_that_of_balls_and_boxes() {
        let ball = sphere(1.0, 16).unwrap();
        for (x, around) in [(0.0, 1.0), (0.9, 1.0), (1.1, 0.0)] {
            assert!((winding(&ball, &Vec3::new(0.0, x, 0.0)) - around).abs() < 1e-12);
        }
        assert!((distance(&ball, &Vec3::new(0.0, 0.0, 3.0)) - 2.0).abs() < 1e-2);
        let places = [[0.0, 0.0, 0.5], [0.0, 0.9, 0.9], [0.7, 0.0, 0.0]].map(Vec3::from);
        let (count, deepest) = inside(&ball, places.into_iter());
        assert!(count == 2 && (deepest - 0.5).abs() < 1e-2, "{count} {deepest}");
        // A cap of height h has the volume πh²(1 − h/3) and the area 2πh, and facets are so far inside of the ball.
        let within = (4.0 / 3.0 * PI - ball.enclosed_volume()) / (4.0 * PI);
        for h in [0.3, 1.0, 1.6] {
            let cap = PI * h * h * (1.0 - h / 3.0) - 2.0 * PI * h * within;
            let error = volume_below(&ball, h - 1.0) / cap - 1.0;
            assert!(error.abs() < 2e-3, "{h}: {error:e}");
        }
        let mut moved = ball.clone();
        moved.translate(&Vec3::new(3.0, -2.0, 5.0)).unwrap();
        assert!((centre_of_volume(&moved) - Vec3::new(3.0, -2.0, 5.0)).norm() < 1e-12);
        let tray = tray([0.5, 0.25], 0.3).unwrap();
        let full = 2.0 * 1.5 * 0.8 - 1.0 * 0.5 * 0.3;
        assert!((tray.enclosed_volume() - full).abs() < 1e-12, "{}", tray.enclosed_volume());
        assert!((volume_below(&tray, 0.0) - 2.0 * 1.5 * 0.5).abs() < 1e-12);
        assert!((volume_below(&tray, 1.0) - full).abs() < 1e-12);
    }
}
