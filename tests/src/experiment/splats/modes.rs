//! Modes and precisions of the rasteriser: time against error.

use super::plain::{self, Rounding, Rules};
use super::portrait::camera_on;
use super::surface::{PaintedSurface, Place};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Size, colour_image, difference_image};
use crate::scene::quantity::Count;
use gaussian_deform::Splats;
use gaussian_deform::raster::{self, Mode, Picture, Settings};
use mechanics_core::lanes::Element;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// One scene in both modes and precisions; the ladder is the pixels along a side.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SplatPictureModes {
    painted: PaintedSurface,
    /// Pictures that are drawn and timed.
    pictures: Count,
}

const METHODS: [&str; 4] = ["exact f32", "tight f32", "exact f64", "tight f64"];
const BACKGROUND: [f64; 3] = [1.0; 3];

impl Experiment for SplatPictureModes {
    fn methods(&self) -> &'static [&'static str] {
        &METHODS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let painted = self.painted.painted(at.folder)?;
        let side = at.ladder as usize;
        let camera = camera_on(&painted.bounds, [side, side], Vec3::y(), (0.5, 0.25))
            .map_err(ExperimentError::stopped)?;
        let single = at.method.ends_with("f32");
        let mode = if at.method.starts_with("exact") { Mode::Exact } else { Mode::Tight };
        let settings = Settings { mode, background: BACKGROUND, ..Settings::default() };
        let found = if single {
            self.drawn(&painted.splats.cast::<f32>(), &camera, &settings, clock)?
        } else {
            self.drawn(&painted.splats, &camera, &settings, clock)?
        };
        let gaussians = painted.seen(&camera, Place::at_rest);
        let rounding = if single { Rounding::SINGLE } else { Rounding::DOUBLE };
        let truth = |rules| plain::draw(&gaussians, &camera, BACKGROUND, rules, &rounding);
        let (complete, ruled) = (truth(Rules::Complete), truth(Rules::Of(mode)));
        let whole = plain::difference(&found, &complete.colours, &complete.fragile);
        let by_rules = plain::difference(&found, &ruled.colours, &ruled.fragile);
        let mut hash = StateHash::new();
        hash.add("picture", found.as_flattened());
        let outcome = Outcome::default()
            .error("complete blending, root mean square", whole.root_mean_square)
            .error("the mode's own rules", by_rules.largest)
            .count("splats", painted.splats.count() as u64)
            .invariant("share of pixels at a threshold", by_rules.fragile)
            .state(hash.value());
        let caption = format!("{}, {side} × {side} pixels: less complete blending", at.method);
        outcome.pictured(at, &caption, || {
            let size = Size { width: side, height: side };
            let gain = "fifty times the difference to complete blending";
            let difference = difference_image(size, (&found, &complete.colours), 50.0, gain);
            Ok(colour_image(size, &found, at.method).beside(&[difference]))
        })
    }
}

impl SplatPictureModes {
    /// The colours, and the time of `pictures` of them.
    fn drawn<E: Element>(
        &self,
        splats: &Splats<E>,
        camera: &gaussian_deform::camera::Camera,
        settings: &Settings,
        clock: &mut Clock,
    ) -> Result<Vec<[f64; 3]>, ExperimentError> {
        let mut picture = Picture::empty();
        for _ in 0..self.pictures.value() {
            clock
                .time(|| raster::render_into(splats, camera, settings, &mut picture))
                .map_err(ExperimentError::stopped)?;
        }
        Ok(plain::colours(&picture))
    }
}
