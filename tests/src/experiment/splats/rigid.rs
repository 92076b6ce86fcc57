//! A rigid motion of a scene is the opposite motion of the camera.

use super::plain::{self, Rounding, Rules};
use super::portrait::camera_on;
use super::surface::{Painted, PaintedSurface, Place};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Size, difference_image, splat_image};
use crate::scene::quantity::{Count, Vector};
use gaussian_deform::Splats;
use gaussian_deform::camera::Camera;
use gaussian_deform::raster::{self, Mode, Picture, Settings};
use gaussian_deform::transport::{Colours, Transport};
use mechanics_core::lanes::Element;
use mechanics_core::samples::DeformationSamples;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::{Mat3, Vec3};
use nalgebra::Rotation3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A scene that is turned and shifted, seen by a camera that is turned and shifted with it; the ladder is the angle (rad).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SplatRigidMotion {
    painted: PaintedSurface,
    /// Around which the scene is turned; any length.
    axis: Vector,
    /// After that (m).
    shift_m: Vector,
    /// Pixels along a side of the picture.
    pixels: Count,
}

/// What is done by a method.
#[derive(Clone, Copy)]
struct Course {
    mode: Mode,
    colours: Colours,
    harmonics: Harmonics,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Harmonics {
    Moved,
    LeftBehind,
}

const METHODS: [&str; 6] =
    ["exact f64", "tight f64", "exact f32", "tight f32", "turned directions f32", "harmonics left behind"];

impl Course {
    fn of(method: &str) -> Self {
        Self {
            mode: if method.starts_with("exact") { Mode::Exact } else { Mode::Tight },
            colours: match method.starts_with("turned") {
                true => Colours::TurnDirections,
                false => Colours::RotateCoefficients,
            },
            harmonics: if method.ends_with("behind") { Harmonics::LeftBehind } else { Harmonics::Moved },
        }
    }

    fn settings(&self) -> Settings {
        Settings { mode: self.mode, background: BACKGROUND, ..Settings::default() }
    }
}

const BACKGROUND: [f64; 3] = [1.0; 3];

impl Experiment for SplatRigidMotion {
    fn methods(&self) -> &'static [&'static str] {
        &METHODS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let painted = self.painted.painted(at.folder)?;
        if at.method.ends_with("f32") {
            self.compared::<f32>(&painted, &Rounding::SINGLE, at, clock)
        } else {
            self.compared::<f64>(&painted, &Rounding::DOUBLE, at, clock)
        }
    }
}

impl SplatRigidMotion {
    fn compared<E: Element>(
        &self,
        painted: &Painted,
        rounding: &Rounding,
        at: &Point<'_>,
        clock: &mut Clock,
    ) -> Result<Outcome, ExperimentError> {
        let course = Course::of(at.method);
        let pixels = self.pixels.value();
        let camera = camera_on(&painted.bounds, [pixels, pixels], Vec3::y(), (0.5, 0.25))
            .map_err(ExperimentError::stopped)?;
        let vector = |v: Vector| Vec3::from(v.map(|x| x.value()));
        let axis = nalgebra::Unit::new_normalize(vector(self.axis));
        let rotation = Rotation3::from_axis_angle(&axis, at.ladder).into_inner();
        let shift = vector(self.shift_m);
        let there = camera.moved(&rotation, &shift).map_err(ExperimentError::stopped)?;
        let rest = painted.splats.cast::<E>();
        let draw = |splats: &Splats<E>, camera: &Camera| {
            raster::render(splats, camera, &course.settings()).map_err(ExperimentError::stopped)
        };
        let here = draw(&rest, &camera)?;
        let (moved, picture) = clock.time(|| {
            let moved = moved(&rest, &rotation, &shift, course.colours)?;
            let picture = draw(&moved, &there)?;
            Ok::<_, ExperimentError>((moved, picture))
        })?;
        let mut stale = moved.clone();
        stale.harmonics_mut().copy_from_slice(rest.harmonics());
        stale.set_orientations(None);
        let stale = draw(&stale, &there)?;
        let fragile = fragile_pixels(painted, &camera, course.mode, rounding);
        let from_here = |picture: &Picture<E>| {
            plain::difference(&plain::colours(picture), &plain::colours(&here), &fragile)
        };
        let left_behind = from_here(&stale);
        let shown = if course.harmonics == Harmonics::LeftBehind { &stale } else { &picture };
        let found = from_here(shown);
        let mut hash = StateHash::new();
        hash.add("picture", plain::colours(shown).as_flattened());
        let outcome = Outcome::default()
            .error("picture", found.largest)
            .error("picture with all pixels, root mean square", found.root_mean_square)
            .count("splats", rest.count() as u64)
            .invariant("share of pixels at a threshold", found.fragile)
            .invariant("what harmonics left behind show, by the angle", left_behind.largest / at.ladder)
            .state(hash.value());
        let caption = format!("{}: the scene and its camera turned by {} rad", at.method, at.ladder);
        outcome.pictured(at, &caption, || {
            let size = Size { width: pixels, height: pixels };
            let [a, b] = [&here, shown].map(plain::colours);
            let difference = difference_image(size, (&a, &b), 4.0, "four times the difference");
            Ok(splat_image(&here, "at rest")
                .beside(&[splat_image(shown, "moved, with the camera"), difference]))
        })
    }
}

/// The scene after x ↦ R x + t.
fn moved<E: Element>(
    rest: &Splats<E>,
    rotation: &Mat3,
    shift: &Vec3,
    colours: Colours,
) -> Result<Splats<E>, ExperimentError> {
    let all = (0..rest.count() as u32).collect();
    let mut transport = Transport::new(rest.clone(), all, colours).map_err(ExperimentError::stopped)?;
    let positions: Vec<Vec3> = rest.means().iter().map(|x| rotation * x.map(Into::into) + shift).collect();
    let gradients = vec![*rotation; positions.len()];
    transport.deform(DeformationSamples::new(&positions, &gradients)).map_err(ExperimentError::stopped)?;
    Ok(transport.frame().clone())
}

/// The pixels at which a decision is within rounding of the opposite one.
fn fragile_pixels(painted: &Painted, camera: &Camera, mode: Mode, rounding: &Rounding) -> Vec<bool> {
    let gaussians = painted.seen(camera, Place::at_rest);
    plain::draw(&gaussians, camera, BACKGROUND, Rules::Of(mode), rounding).fragile
}
