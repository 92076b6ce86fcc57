//! Scenes of splats that the workspace makes itself: a closed surface covered with flat Gaussians.
//!
//! They are what a capture of a glossy, painted body would be: on the surface, flat, opaque, with colours that depend on the
//! direction of view, and nothing behind them. Unlike a capture they have a known inside.

use super::plain::Gaussian;
use crate::experiment::ExperimentError;
use crate::scene::quantity::Positive;
use gaussian_deform::camera::Camera;
use gaussian_deform::{Degree, Splat, Splats, harmonics};
use mechanics_core::mesh::{BoundingBox, TriMesh, io::obj, sphere, torus, triangle_area_vector};
use mechanics_core::tensor::{Mat3, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::path::Path;

/// A closed surface, its bounding box centred at the origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum ClosedSurface {
    /// An OBJ file; its path is relative to the scene file.
    File {
        /// Path of the file.
        path: String,
        /// Metres per unit of the file.
        scale_m: Positive,
    },
    /// A sphere.
    Sphere {
        /// Its radius (m).
        radius_m: Positive,
    },
    /// A torus around z.
    Torus {
        /// From the centre to the middle of the tube (m).
        major_radius_m: Positive,
        /// Of the tube (m).
        minor_radius_m: Positive,
    },
}

impl ClosedSurface {
    /// Its triangles, outwards; the scene file is in `folder`. Round surfaces have facets that miss them by less than 1e-3 of a radius.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn mesh(&self, folder: &Path) -> Result<TriMesh, ExperimentError> {
        let mut mesh = match self {
            Self::File { path, scale_m } => {
                let mut mesh = obj::read_file(folder.join(path)).map_err(ExperimentError::stopped)?;
                mesh.scale(scale_m.value()).map_err(ExperimentError::stopped)?;
                mesh
            }
            Self::Sphere { radius_m } => sphere(radius_m.value(), 32).map_err(ExperimentError::stopped)?,
            Self::Torus { major_radius_m, minor_radius_m } => {
                torus(major_radius_m.value(), minor_radius_m.value(), 192, 80)
                    .map_err(ExperimentError::stopped)?
            }
        };
        if let Some(bounds) = mesh.bounding_box() {
            mesh.translate(&-bounds.centre()).map_err(ExperimentError::stopped)?;
        }
        Ok(mesh)
    }
}

/// A closed surface and how it is covered with splats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PaintedSurface {
    surface: ClosedSurface,
    /// About one splat for the square of this (m).
    spacing_m: Positive,
}

impl PaintedSurface {
    /// The surface and its splats, of opacity 0.9 and degree 3; y is up.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn painted(&self, folder: &Path) -> Result<Painted, ExperimentError> {
        let mesh = self.surface.mesh(folder)?;
        let cover = Cover { spacing: self.spacing_m.value(), ..Cover::default() };
        let (splats, paints) = covered(&mesh, &cover);
        let bounds = mesh.bounding_box().ok_or_else(|| ExperimentError::Refused {
            key: "surface".to_owned(),
            reason: "the mesh has no points".to_owned(),
        })?;
        Ok(Painted { mesh, bounds, splats, paints })
    }
}

/// A surface, its splats, and what they look like in closed form.
pub(crate) struct Painted {
    pub(crate) mesh: TriMesh,
    pub(crate) bounds: BoundingBox,
    pub(crate) splats: Splats<f64>,
    /// By splat.
    pub(crate) paints: Vec<Paint>,
}

/// Where a splat has moved, in closed form.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) position: Vec3,
    /// F.
    pub(super) gradient: Mat3,
    /// R of F = R U.
    pub(super) rotation: Mat3,
}

impl Place {
    /// Where it was.
    pub(super) fn at_rest(position: &Vec3) -> Self {
        Self { position: *position, gradient: Mat3::identity(), rotation: Mat3::identity() }
    }
}

impl Painted {
    /// The splats as a camera sees them after a motion in closed form: no half-axes, no harmonics.
    pub(super) fn seen(&self, camera: &Camera, motion: impl Fn(&Vec3) -> Place) -> Vec<Gaussian> {
        let splats = &self.splats;
        let gaussian = |i: usize| {
            let Place { position, gradient, rotation } = motion(&splats.means()[i]);
            let axes = splats.axes()[i];
            let direction = (position - camera.eye()).normalize();
            Gaussian {
                mean: position,
                covariance: gradient * (axes * axes.transpose()) * gradient.transpose(),
                opacity: splats.opacities()[i],
                colour: self.paints[i].colour(&rotation, &direction),
            }
        };
        (0..splats.count()).map(gaussian).collect()
    }
}

/// How a surface is covered with splats.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cover {
    /// About one splat for the square of this \[m\].
    pub(crate) spacing: f64,
    /// Of the harmonics; the highlight needs degree 3 to be whole.
    pub(crate) degree: Degree,
    /// The opacity of every splat.
    pub(crate) opacity: f64,
    /// The surface is striped across this direction and lit from there.
    pub(crate) up: Vec3,
}

impl Default for Cover {
    /// Splats of degree 3 every 2 cm, opacity 0.9, y upwards.
    fn default() -> Self {
        Self { spacing: 0.02, degree: Degree::Three, opacity: 0.9, up: Vec3::y() }
    }
}

/// Standard deviations of a splat in spacings: around the upward axis, up the surface, through it.
const DEVIATIONS: [f64; 3] = [0.8, 0.6, 0.06];
/// Stripes from the lowest to the highest point.
const STRIPES: f64 = 7.0;
/// Red, green, blue of the two kinds of stripes.
const PAINTS: [[f64; 3]; 2] = [[0.72, 0.30, 0.18], [0.80, 0.72, 0.55]];
/// Red, green, blue that the highlight adds in its middle.
const HIGHLIGHT: [f64; 3] = [0.40, 0.36, 0.30];
/// The highlight as a function of x = cos of the angle to its middle, (1 + x)(5x + 1)²/72, in Legendre polynomials P₀ to P₃: never negative, one in the middle.
const LOBE: [f64; 4] =
    [12.666_666_666_666_666 / 72.0, 26.0 / 72.0, 23.333_333_333_333_332 / 72.0, 10.0 / 72.0];

/// Splats on a surface: flat Gaussians in its tangential planes, striped, shaded, and with a highlight that moves over the
/// surface with the eye. The same surface gives the same splats.
pub(crate) fn cover(mesh: &TriMesh, cover: &Cover) -> Splats<f64> {
    covered(mesh, cover).0
}

/// Splats on a surface, and the closed form of what each looks like.
fn covered(mesh: &TriMesh, cover: &Cover) -> (Splats<f64>, Vec<Paint>) {
    let up = cover.up.normalize();
    let heights = mesh.points().iter().map(|x| x.dot(&up));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let places = spread(mesh, cover.spacing);
    let mut splats = Splats::with_capacity(cover.degree, places.len());
    let mut paints = Vec::with_capacity(places.len());
    for Dart { position, normal } in places {
        let height = (position.dot(&up) - low) / (high - low).max(f64::MIN_POSITIVE);
        let frame = tangent_frame(&normal, &up);
        let axes = frame * Mat3::from_diagonal(&(Vec3::from(DEVIATIONS) * cover.spacing));
        let paint = Paint::new(height, &normal, &up);
        let harmonics = paint.harmonics(cover.degree);
        splats.push(Splat { mean: position, axes, opacity: cover.opacity, harmonics: &harmonics });
        paints.push(paint);
    }
    (splats, paints)
}

/// What a splat looks like.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    /// Red, green, blue without the highlight.
    plain: [f64; 3],
    /// The direction from the eye to the splat in which the highlight is brightest; of length one.
    brightest: Vec3,
}

impl Paint {
    /// Striped by the height (from 0 to 1) on the surface, shaded by a lamp above, at the side and before, with a highlight where the surface mirrors the lamp.
    fn new(height: f64, normal: &Vec3, up: &Vec3) -> Self {
        let side = tangent_frame(up, &Vec3::z()).column(0).into_owned();
        let lamp = (up * 1.4 + side * 0.8 + side.cross(up) * 0.9).normalize();
        let stripe = 0.5 + 0.5 * (6.0 * (TAU * STRIPES * height).sin()).tanh();
        let shade = 0.6 + 0.4 * normal.dot(&lamp);
        let plain = [0, 1, 2].map(|k| shade * (PAINTS[0][k] * stripe + PAINTS[1][k] * (1.0 - stripe)));
        Self { plain, brightest: lamp - normal * (2.0 * normal.dot(&lamp)) }
    }

    /// The colour in a direction from the eye to the splat, of length one, when the splat has been turned; without any harmonics.
    pub(crate) fn colour(&self, rotation: &Mat3, direction: &Vec3) -> [f64; 3] {
        let x = (rotation * self.brightest).dot(direction);
        let highlight = (1.0 + x) * (5.0 * x + 1.0).powi(2) / 72.0;
        [0, 1, 2].map(|k| (self.plain[k] + HIGHLIGHT[k] * highlight).max(0.0))
    }

    /// The same as coefficients; below degree 3 what these bands hold of it.
    ///
    /// The highlight is Σ aₗ Pₗ(b·d), and by the addition theorem Pₗ(b·d) = 4π/(2l + 1) Σₘ Yₗₘ(b) Yₗₘ(d).
    fn harmonics(&self, degree: Degree) -> Vec<f64> {
        let brightest = harmonics::basis(degree, self.brightest.into());
        let constant = harmonics::basis(Degree::Zero, [0.0, 0.0, 1.0])[0];
        let mut coefficients = Vec::with_capacity(degree.stride());
        for channel in 0..3 {
            for k in 0..degree.coefficients() {
                let band = k.isqrt();
                let weight = HIGHLIGHT[channel] * LOBE[band] * 2.0 * TAU / (2 * band + 1) as f64;
                let base = if k == 0 { (self.plain[channel] - 0.5) / constant } else { 0.0 };
                coefficients.push(base + weight * brightest[k]);
            }
        }
        coefficients
    }
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
struct Dart {
    position: Vec3,
    /// Outwards, of length one.
    normal: Vec3,
}

/// Points of the surface, none nearer than 0.8 spacings to another one on the same side, and hardly room for another: darts that are thrown evenly, of
/// which those too near to an earlier one are taken back.
fn spread(mesh: &TriMesh, spacing: f64) -> Vec<Dart> {
    const DARTS: f64 = 12.0;
    let areas = mesh.areas();
    let sums: Vec<f64> = areas
        .iter()
        .scan(0.0, |sum, area| {
            *sum += area;
            Some(*sum)
        })
        .collect();
    let total = sums.last().copied().unwrap_or(0.0);
    let darts = (DARTS * total / (spacing * spacing)).ceil() as usize;
    let normals = point_normals(mesh);
    let mut placed = Sparse::new(0.8 * spacing, mesh);
    for dart in 0..darts {
        let share = (dart as f64 + 0.5) / darts as f64 * total;
        let triangle = sums.partition_point(|&sum| sum < share).min(areas.len() - 1);
        placed.add(dart_in(mesh, &normals, triangle, dart));
    }
    placed.places
}

/// The `dart`-th point of an even sequence in a triangle: the additive recurrence with steps 1/φ, 1/φ², φ³ = φ + 1 (Roberts 2018).
fn dart_in(mesh: &TriMesh, normals: &[Vec3], triangle: usize, dart: usize) -> Dart {
    let [mut u, mut v] =
        [0.754_877_666_246_692_7, 0.569_840_290_998_053_3].map(|step| (dart as f64 * step).fract());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    let corners = mesh.corners(triangle);
    let blend = |[a, b, c]: [Vec3; 3]| a * (1.0 - u - v) + b * u + c * v;
    let flat = triangle_area_vector(&corners).normalize();
    let smooth = blend(mesh.triangles()[triangle].map(|point| normals[point as usize]));
    let normal = smooth.try_normalize(1e-6).filter(|normal| normal.dot(&flat) > 0.1).unwrap_or(flat);
    Dart { position: blend(corners), normal }
}

/// Normals at the points of a surface: the mean of those of the triangles around by their area; zero where there is none.
fn point_normals(mesh: &TriMesh) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); mesh.points().len()];
    for (triangle, points) in mesh.triangles().iter().enumerate() {
        let area = triangle_area_vector(&mesh.corners(triangle));
        points.iter().for_each(|&point| normals[point as usize] += area);
    }
    normals.iter().map(|n| n.try_normalize(f64::MIN_POSITIVE).unwrap_or_default()).collect()
}

/// Places none of which is too near to another.
struct Sparse {
    distance: f64,
    places: Vec<Dart>,
    /// Cells of at least `distance` over the surface, each with the last place in it; and by place the one before it in its cell.
    low: Vec3,
    edge: f64,
    counts: [usize; 3],
    last: Vec<Option<u32>>,
    before: Vec<Option<u32>>,
}

impl Sparse {
    fn new(distance: f64, mesh: &TriMesh) -> Self {
        let (low, size) = mesh.bounding_box().map_or_else(Default::default, |b| (b.min, b.size()));
        // At most a million cells.
        let edge = distance.max(0.01 * size.amax());
        let counts = [0, 1, 2].map(|k| (size[k] / edge) as usize + 1);
        let last = vec![None; counts.iter().product()];
        Self { distance, places: Vec::new(), low, edge, counts, last, before: Vec::new() }
    }

    /// Adds a place unless another one is too near, whose normal points to the same side.
    fn add(&mut self, place: Dart) {
        let cell: [usize; 3] = [0, 1, 2].map(|k| {
            (((place.position[k] - self.low[k]) / self.edge).max(0.0) as usize).min(self.counts[k] - 1)
        });
        let around = |k: usize| cell[k].saturating_sub(1)..(cell[k] + 2).min(self.counts[k]);
        for i in around(0) {
            for j in around(1) {
                for k in around(2) {
                    if self.crowds([i, j, k], &place) {
                        return;
                    }
                }
            }
        }
        let number = self.number(cell);
        self.before.push(self.last[number]);
        self.last[number] = Some(self.places.len() as u32);
        self.places.push(place);
    }

    fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        (i * self.counts[1] + j) * self.counts[2] + k
    }

    /// Whether a place of a cell is too near.
    fn crowds(&self, cell: [usize; 3], place: &Dart) -> bool {
        let mut next = self.last[self.number(cell)];
        while let Some(other) = next {
            let Dart { position, normal } = &self.places[other as usize];
            if (position - place.position).norm_squared() < self.distance * self.distance
                && normal.dot(&place.normal) > 0.0
            {
                return true;
            }
            next = self.before[other as usize];
        }
        false
    }
}

/// Columns: around the upward axis, up the surface, outwards.
fn tangent_frame(normal: &Vec3, up: &Vec3) -> Mat3 {
    let around = [*up, Vec3::x(), Vec3::z()].map(|axis| axis.cross(normal));
    let first = around.into_iter().find_map(|axis| axis.try_normalize(0.05)).unwrap_or_default();
    Mat3::from_columns(&[first, normal.cross(&first), *normal])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a unit sphere, of another spacing.
    fn ball(spacing: f64, degree: Degree) -> Splats<f64> {
        cover(&sphere(1.0, 16).unwrap(), &Cover { spacing, degree, ..Cover::default() })
    }

    #[test]
    fn splats_lie_flat_on_the_surface_and_evenly() {
        let splats = ball(0.1, Degree::Zero);
        // Random sequential adsorption of discs fills 0.547 of the area (Feder 1980).
        let saturated = 4.0 * std::f64::consts::PI * 0.547 / (0.25 * std::f64::consts::PI * 0.08 * 0.08);
        let count = splats.count() as f64;
        assert!(count > 0.85 * saturated && count < 1.15 * saturated, "{count} for {saturated}");
        for (i, (mean, axes)) in splats.means().iter().zip(splats.axes()).enumerate() {
            let normal = axes.column(2).normalize();
            assert!((mean.norm() - 1.0).abs() < 0.01 && normal.dot(&mean.normalize()) > 0.99);
            assert!(axes.determinant() > 0.0);
            assert!(splats.means()[..i].iter().all(|other| (other - mean).norm() > 0.0799));
        }
    }

    /// The highlight, summed from harmonics, is the closed form, brightest from within the half-space of the normal.
    #[test]
    fn harmonics_show_the_closed_form() {
        let normal = Vec3::new(0.2, 0.9, -0.3).normalize();
        let paint = Paint::new(0.3, &normal, &Vec3::y());
        let harmonics = paint.harmonics(Degree::Three);
        for k in 0..200 {
            let z = 1.0 - (f64::from(k) + 0.5) / 100.0;
            let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
            let direction = Vec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z);
            let summed = harmonics::colour(Degree::Three, &harmonics, direction.into());
            for (a, b) in summed.iter().zip(paint.colour(&Mat3::identity(), &direction)) {
                assert!((a - b).abs() < 1e-14, "{direction}: {a} for {b}");
            }
        }
        assert!(paint.brightest.dot(&normal) < 0.0);
    }
}
