//! Which splats there are, which of them are matter, and where the simulation has them.

use super::refused;
use crate::experiment::ExperimentError;
use crate::experiment::splats::surface::{Cover, cover};
use crate::scene::quantity::{Finite, Positive, Vector};
use crate::scene::splats::{Particles, Placement, Region, SplatScene, Tiles, Up};
use gaussian_deform::select::{self, Criteria};
use gaussian_deform::similarity::Similarity;
use gaussian_deform::{Splat, Splats, file};
use mechanics_core::mesh::BoundingBox;
use mechanics_core::tensor::{Mat3, Vec3};
use std::path::Path;

/// A scene of splats and its matter.
pub(super) struct Matter {
    /// All splats, in the file's coordinates.
    pub(super) splats: Splats<f32>,
    /// Those that are matter, ascending.
    pub(super) list: Vec<u32>,
    /// From the file's coordinates to those of the simulation.
    pub(super) place: Similarity,
    /// The box of the matter's means in the simulation \[m\].
    pub(super) bounds: BoundingBox,
}

/// Opacity below which splats are no matter, where a scene does not say.
const OPACITY: f64 = 0.02;
/// Share of the splats that are beyond each side of an automatic region.
const TRIM: f64 = 0.02;

impl Matter {
    /// Of a scene whose file is in `folder`; `meshes` is the box of what moves the splats, if it is not particles \[m\].
    ///
    /// # Errors
    /// Splats that cannot be read, a region without matter, matter without extent.
    pub(super) fn new(
        given: &SplatScene,
        folder: &Path,
        meshes: Option<BoundingBox>,
    ) -> Result<Self, ExperimentError> {
        let (mut splats, name) = read(given, folder)?;
        let opacity = given.opacity.map_or(OPACITY, |opacity| opacity.value());
        let nothing = |key: &str, error: &dyn std::fmt::Display| refused(key, format!("{name}: {error}"));
        let region = match &given.region {
            Region::Auto => {
                let bulk = select::bulk(&splats, opacity, TRIM).map_err(|e| nothing("splats.opacity", &e))?;
                select::Region::Box(bulk)
            }
            other => region(other),
        };
        let list = select::select(&splats, &Criteria { region, opacity })
            .map_err(|error| nothing("splats.region", &error))?;
        let means = select::means(&splats, &list);
        let place = place(given, &means, meshes)?;
        let moved: Vec<Vec3> = means.iter().map(|x| place.point(x)).collect();
        let bounds = BoundingBox::of(&moved).ok_or_else(|| refused("splats.region", "no matter"))?;
        if let Some(Particles { floor, .. }) = &given.particles
            && let Some(tiles) = &floor.tiles
        {
            add_tiles(&mut splats, tiles, &place);
        }
        Ok(Self { splats, list, place, bounds })
    }
}

/// The splats, and what to call them.
fn read(given: &SplatScene, folder: &Path) -> Result<(Splats<f32>, String), ExperimentError> {
    let (splats, name) = match (&given.file, &given.surface) {
        (Some(path), None) => {
            let found = file::read_file(folder.join(path)).map_err(|error| refused("splats.file", error))?;
            (found, path.clone())
        }
        (None, Some(surface)) => {
            let mesh = surface.shape.mesh(folder)?;
            let up = direction(given.up);
            let splats = cover(&mesh, &Cover { spacing: surface.spacing_m.value(), up, ..Cover::default() });
            (splats.cast(), "the surface".to_owned())
        }
        _ => return Err(refused("splats", "needs either `file` or `surface`")),
    };
    splats.check().map_err(|error| refused("splats.file", format!("{name}: {error}")))?;
    Ok((splats, name))
}

/// A part of space as the crate has it; the automatic one is everywhere.
pub(super) fn region(given: &Region) -> select::Region {
    match given {
        Region::Auto | Region::Everywhere => select::Region::Everywhere,
        Region::Box { min, max } => select::Region::Box(BoundingBox { min: vector(min), max: vector(max) }),
        Region::OrientedBox { centre, half_sides, rotation_rad } => select::Region::OrientedBox {
            centre: vector(centre),
            half_sides: Vec3::from(half_sides.map(Positive::value)),
            rotation: nalgebra::Rotation3::from_scaled_axis(vector(rotation_rad)).into_inner(),
        },
    }
}

pub(super) fn vector(given: &Vector) -> Vec3 {
    Vec3::from(given.map(Finite::value))
}

pub(super) fn direction(up: Up) -> Vec3 {
    match up {
        Up::PlusX => Vec3::x(),
        Up::MinusX => -Vec3::x(),
        Up::PlusY => Vec3::y(),
        Up::MinusY => -Vec3::y(),
        Up::PlusZ => Vec3::z(),
        Up::MinusZ => -Vec3::z(),
    }
}

/// The shortest rotation that brings an axis to z.
fn upright(up: Up) -> Mat3 {
    match up {
        Up::PlusZ => Mat3::identity(),
        Up::MinusZ => Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0)),
        Up::PlusX => Mat3::new(0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0),
        Up::MinusX => Mat3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0),
        Up::PlusY => Mat3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0),
        Up::MinusY => Mat3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0),
    }
}

/// Where the simulation has the matter's means.
fn place(
    given: &SplatScene,
    means: &[Vec3],
    meshes: Option<BoundingBox>,
) -> Result<Similarity, ExperimentError> {
    let rotation = upright(given.up);
    let failed = |error| {
        refused(
            "splats.placement",
            format!("{error}; the matter's splats need to be spread over some length"),
        )
    };
    let turned: Vec<Vec3> = means.iter().map(|x| rotation * x).collect();
    let bounds = BoundingBox::of(&turned).ok_or_else(|| refused("splats.region", "no matter"))?;
    let on_floor = |size: f64, height: f64| {
        let scale = size / bounds.size().max();
        let foot = Vec3::new(bounds.centre().x, bounds.centre().y, bounds.min.z);
        Similarity::new(scale, rotation, Vec3::z() * height - foot * scale).map_err(failed)
    };
    match (given.placement, meshes) {
        (Some(Placement::OnFloor { size_m, height_m }), _) => on_floor(size_m.value(), height_m.value()),
        (Some(Placement::Exact { scale_m, translation_m }), _) => {
            Similarity::new(scale_m.value(), rotation, vector(&translation_m)).map_err(failed)
        }
        (None, None) => on_floor(1.0, 0.0),
        (None, Some(meshes)) => {
            let scale = (0..3)
                .map(|k| meshes.size()[k] / bounds.size()[k])
                .filter(|scale| scale.is_finite())
                .fold(f64::INFINITY, f64::min);
            let shift = meshes.centre() - bounds.centre() * scale;
            Similarity::new(scale, rotation, shift).map_err(failed)
        }
    }
}

/// Standard deviation of a floor's splat in units of their distance: so that they overlap without a gap.
const FLOOR_DEVIATION: f64 = 0.7;
/// Splats along the side of a tile.
const SPLATS_A_TILE: i64 = 4;
/// Grey of the two kinds of tiles.
const GREYS: [f64; 2] = [0.55, 0.8];

/// Flat splats at the top of the floor, which are no matter; at the end, so that all others keep their numbers.
fn add_tiles(splats: &mut Splats<f32>, tiles: &Tiles, place: &Similarity) {
    // What a colour's constant coefficient is multiplied by, √(1/4π).
    const CONSTANT: f64 = 0.282_094_791_773_878_14;
    let (side, count) = (tiles.size_m.value(), tiles.count.value() as i64);
    let spacing = side / SPLATS_A_TILE as f64;
    let deviations = Vec3::new(FLOOR_DEVIATION, FLOOR_DEVIATION, 0.02) * spacing;
    let axes = place.rotation().transpose() * Mat3::from_diagonal(&deviations) / place.scale();
    let mut harmonics = vec![0.0; splats.degree().stride()];
    let channel = splats.degree().coefficients();
    for i in 0..count * SPLATS_A_TILE {
        for j in 0..count * SPLATS_A_TILE {
            let along = |k: i64| (k as f64 + 0.5) * spacing - 0.5 * count as f64 * side;
            let mean = place.point_back(&Vec3::new(along(i), along(j), -0.03 * spacing));
            let kind = (i / SPLATS_A_TILE + j / SPLATS_A_TILE) % 2;
            let grey = (GREYS[kind as usize] - 0.5) / CONSTANT;
            (0..3).for_each(|c| harmonics[c * channel] = grey as f32);
            splats.push(Splat { mean: mean.cast(), axes: axes.cast(), opacity: 0.95, harmonics: &harmonics });
        }
    }
}
