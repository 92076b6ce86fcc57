//! Where splats are looked at from, and what is seen.

use super::matter::{Matter, direction, vector};
use super::refused;
use crate::experiment::ExperimentError;
use crate::picture::{Image, splat_image};
use crate::scene::quantity::{Count, Finite, Positive, Share};
use crate::scene::splats::{DrawMode, SplatCamera, SplatScene};
use gaussian_deform::Splats;
use gaussian_deform::camera::{Camera, NamedCamera, Orbit, cameras_from_json};
use gaussian_deform::raster::{Mode, Picture, Settings, render_into};
use mechanics_core::tensor::Vec3;
use std::path::Path;

/// A camera, standing or going around, and how it draws.
pub(super) struct View {
    place: Place,
    size: [usize; 2],
    settings: Settings,
    picture: Picture<f32>,
}

enum Place {
    Standing(Camera),
    /// An orbit at the start, and how fast the camera goes around \[rad/s\].
    Around(Orbit, f64),
}

/// Pixels of a picture, where a scene does not say.
const SIZE: [usize; 2] = [480, 480];

impl View {
    /// The view of a scene whose file is in `folder`.
    ///
    /// # Errors
    /// A camera that cannot be, or whose eye is inside a splat.
    pub(super) fn new(given: &SplatScene, folder: &Path, matter: &Matter) -> Result<Self, ExperimentError> {
        let camera = given.camera.clone().unwrap_or_default();
        let size = camera.size_px.map(|size| size.map(Count::value));
        let place = match &camera.file {
            Some(path) => Place::Standing(from_file(&camera, &folder.join(path), size)?),
            None => {
                let turn = camera.turn_rad_s.map_or(0.0, Finite::value);
                Place::Around(orbit(given, &camera, matter), turn)
            }
        };
        let size = match &place {
            Place::Standing(camera) => [camera.width(), camera.height()],
            Place::Around(..) => size.unwrap_or(SIZE),
        };
        let mode = match camera.mode {
            DrawMode::Exact => Mode::Exact,
            DrawMode::Tight => Mode::Tight,
        };
        let background = camera.background.map_or([1.0; 3], |colour| colour.map(Share::value));
        let settings = Settings { mode, background, ..Settings::default() };
        let view = Self { place, size, settings, picture: Picture::empty() };
        let start = view.camera(0.0)?;
        start.require_outside(&matter.splats, 1.0).map_err(|error| refused("splats.camera", error))?;
        Ok(view)
    }

    /// The camera at `time` \[s\].
    fn camera(&self, time: f64) -> Result<Camera, ExperimentError> {
        match &self.place {
            Place::Standing(camera) => Ok(camera.clone()),
            Place::Around(orbit, turn) => {
                let orbit = Orbit { azimuth: orbit.azimuth + turn * time, ..*orbit };
                Camera::on_orbit(self.size, &orbit).map_err(|error| refused("splats.camera", error))
            }
        }
    }

    /// The picture of `splats` at `time` \[s\].
    pub(super) fn draw(&mut self, splats: &Splats<f32>, time: f64) -> Result<Image, ExperimentError> {
        let camera = self.camera(time)?;
        render_into(splats, &camera, &self.settings, &mut self.picture).map_err(ExperimentError::stopped)?;
        Ok(splat_image(&self.picture, ""))
    }
}

fn orbit(given: &SplatScene, camera: &SplatCamera, matter: &Matter) -> Orbit {
    let number = |given: Option<Finite>, default: f64| given.map_or(default, Finite::value);
    let middle = matter.bounds.centre();
    let target = camera.target_m.map_or(Vec3::new(middle.x, middle.y, 0.5 * middle.z), |x| vector(&x));
    let diagonal = matter.bounds.size().norm() / matter.place.scale();
    Orbit {
        target: matter.place.point_back(&target),
        distance: camera.distance.map_or(2.0, Positive::value) * diagonal,
        azimuth: number(camera.azimuth_rad, 0.6),
        elevation: number(camera.elevation_rad, 0.25),
        up: direction(given.up),
        field_of_view: camera.field_of_view_rad.map_or(0.7, Positive::value),
    }
}

/// A camera of a cameras.json.
fn from_file(given: &SplatCamera, path: &Path, size: Option<[usize; 2]>) -> Result<Camera, ExperimentError> {
    let failed =
        |error: &dyn std::fmt::Display| refused("splats.camera.file", format!("{}: {error}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|error| failed(&error))?;
    let cameras = cameras_from_json(&text).map_err(|error| failed(&error))?;
    let wanted = |camera: &&NamedCamera| given.picture.as_ref().is_none_or(|name| camera.name == *name);
    let found = cameras.iter().find(wanted).ok_or_else(|| match &given.picture {
        Some(name) => {
            let names: Vec<&str> = cameras.iter().take(20).map(|camera| camera.name.as_str()).collect();
            refused(
                "splats.camera.picture",
                format!("no camera has `{name}`; there are: {}", names.join(", ")),
            )
        }
        None => failed(&"there is no camera in the file"),
    })?;
    match size {
        Some(size) => found.camera.resized(size).map_err(|error| refused("splats.camera.size_px", error)),
        None => Ok(found.camera.clone()),
    }
}
