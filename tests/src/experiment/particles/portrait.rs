//! Pictures of particles: balls of their size, coloured by a field, and lines to compare them with.

use crate::experiment::{ExperimentError, Outcome, Point};
use crate::picture::{
    Bounds, Camera, ColourMap, Field, FieldValues, Film, Image, Lens, PointSize, Scene3, Size, render,
};

const SIZE: Size = Size { width: 800, height: 500 };
/// Films are smaller: a page holds several.
const FILM_SIZE: Size = Size { width: 560, height: 350 };

/// What is seen of particles at one time.
#[derive(Clone, Debug, Default)]
pub(in crate::experiment) struct Portrait<const D: usize> {
    /// Where they are \[m\].
    pub(in crate::experiment) positions: Vec<[f64; D]>,
    /// A value each.
    pub(in crate::experiment) values: Vec<f64>,
    /// Of a particle's ball \[m\].
    pub(in crate::experiment) radius: f64,
    /// The field's name and unit.
    pub(in crate::experiment) field: (&'static str, &'static str),
    /// The values that colours span; their own range if absent.
    pub(in crate::experiment) range: Option<(f64, f64)>,
    /// Polylines, drawn grey: walls, exact places.
    pub(in crate::experiment) lines: Vec<Vec<[f64; D]>>,
    /// In the picture's corner.
    pub(in crate::experiment) label: String,
}

/// In the plane y is up; in space z.
fn embedded<const D: usize>(x: &[f64; D]) -> [f64; 3] {
    match D {
        2 => [x[0], 0.0, x[1]],
        _ => std::array::from_fn(|a| x[a]),
    }
}

impl<const D: usize> Portrait<D> {
    fn drawn(&self, size: Size, frame: Option<Bounds>) -> Image {
        let mut positions: Vec<[f64; 3]> = self.positions.iter().map(embedded).collect();
        let mut values = self.values.clone();
        let points = (0..positions.len()).collect();
        let mut segments = Vec::new();
        for line in &self.lines {
            let first = positions.len();
            segments.extend((1..line.len()).map(|k| [first + k - 1, first + k]));
            // Before the balls, towards the camera.
            positions.extend(line.iter().map(embedded).map(|[x, y, z]| [x, y - 1.5 * self.radius, z]));
            // Not a number: grey.
            values.resize(positions.len(), f64::NAN);
        }
        let (name, unit) = self.field;
        let scene = Scene3 {
            positions,
            points,
            point_size: PointSize::World(self.radius),
            segments,
            field: Some(Field {
                name: name.to_owned(),
                unit: unit.to_owned(),
                values: FieldValues::Positions(values),
                range: self.range,
                map: ColourMap::default(),
            }),
            caption: self.label.clone(),
            ..Scene3::default()
        };
        let camera = match D {
            2 => Camera { towards: [0.0, -1.0, 0.0], lens: Lens::Orthographic, frame, ..Camera::default() },
            _ => Camera { frame, ..Camera::default() },
        };
        render(&scene, &camera, size)
    }
}

/// `outcome` with a picture, if pictures are wanted; `portrait` is made only then.
pub(in crate::experiment) fn pictured<const D: usize>(
    outcome: Outcome,
    at: &Point<'_>,
    caption: &str,
    portrait: impl FnOnce() -> Portrait<D>,
) -> Result<Outcome, ExperimentError> {
    outcome.pictured(at, caption, || Ok(portrait().drawn(SIZE, None)))
}

/// `outcome` with a film of `seconds` in all, if there are frames: all in one box and one range of colours.
pub(in crate::experiment) fn filmed<const D: usize>(
    outcome: Outcome,
    at: &Point<'_>,
    caption: &str,
    (portraits, seconds): (&[Portrait<D>], f64),
) -> Result<Outcome, ExperimentError> {
    if at.frames.is_none() {
        return Ok(outcome);
    }
    let everything = portraits.iter().flat_map(|p| p.positions.iter().chain(p.lines.iter().flatten()));
    let frame = Bounds::of(everything.map(embedded));
    let mut film = Film::new(seconds / portraits.len().max(1) as f64);
    for portrait in portraits {
        film.push(portrait.drawn(FILM_SIZE, frame)).map_err(ExperimentError::stopped)?;
    }
    outcome.filmed(at, caption, &film)
}
