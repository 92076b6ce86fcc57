//! Pictures of motion: where a point of the system has been, coloured by time, and the links at the end.

use crate::experiment::{ExperimentError, Outcome, Point};
use crate::picture::{Camera, ColourMap, Field, FieldValues, Image, Lens, PointSize, Scene3, Size, render};

const SIZE: Size = Size { width: 800, height: 500 };

/// Points of a system at one time, from the fixed one to the one that is followed, linked in this order.
pub(super) struct Linkage {
    /// When (s).
    pub(super) time: f64,
    /// The points; z is up.
    pub(super) points: Vec<[f64; 3]>,
}

/// How a motion is looked at.
#[derive(Clone, Copy)]
pub(super) enum Plane {
    /// From the front: the motion is in the plane y = 0.
    Upright,
    /// Obliquely.
    Space,
}

/// `outcome` with the path of the last point, if pictures are wanted and anything moved.
pub(super) fn pictured(
    outcome: Outcome,
    at: &Point<'_>,
    motion: &[Linkage],
    plane: Plane,
    caption: &str,
) -> Result<Outcome, ExperimentError> {
    let [.., last] = motion else { return Ok(outcome) };
    outcome.pictured(at, caption, || Ok(drawn(motion, last, plane, at.method)))
}

fn drawn(motion: &[Linkage], last: &Linkage, plane: Plane, method: &str) -> Image {
    let mut scene = Scene3 {
        positions: motion.iter().filter_map(|linkage| linkage.points.last().copied()).collect(),
        point_size: PointSize::Pixels(6.0),
        caption: format!("{method}, t = {} s", last.time),
        ..Scene3::default()
    };
    let mut times: Vec<f64> = motion.iter().map(|linkage| linkage.time).collect();
    scene.segments = (1..scene.positions.len()).map(|i| [i - 1, i]).collect();
    let first = scene.positions.len();
    for (i, &point) in last.points.iter().enumerate() {
        scene.positions.push(point);
        times.push(f64::NAN);
        scene.points.push(first + i);
        if i > 0 {
            scene.segments.push([first + i - 1, first + i]);
        }
    }
    scene.field = Some(Field {
        name: "time".to_owned(),
        unit: "s".to_owned(),
        values: FieldValues::Positions(times),
        range: None,
        map: ColourMap::default(),
    });
    let camera = match plane {
        Plane::Upright => Camera { towards: [0.0, -1.0, 0.0], lens: Lens::Orthographic, ..Camera::default() },
        Plane::Space => Camera::default(),
    };
    render(&scene, &camera, SIZE)
}
