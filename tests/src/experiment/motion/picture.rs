//! Pictures of motion: where a point of the system has been, coloured by time, and the links at the end.

use crate::experiment::{ExperimentError, Point};
use crate::picture::{Camera, ColourMap, Field, FieldValues, Lens, PointSize, Scene3, Size, render};
use crate::record;
use std::path::PathBuf;

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

/// Draws the path of the last point into the row's folder; nothing where no pictures are wanted or nothing moved.
pub(super) fn draw(
    at: &Point<'_>,
    motion: &[Linkage],
    plane: Plane,
    caption: &str,
) -> Result<Vec<record::Picture>, ExperimentError> {
    let (Some((folder, stem)), [.., last]) = (at.frames, motion) else { return Ok(Vec::new()) };
    let mut scene = Scene3 {
        positions: motion.iter().filter_map(|linkage| linkage.points.last().copied()).collect(),
        point_size: PointSize::Pixels(6.0),
        caption: format!("{}, t = {} s", at.method, last.time),
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
    let path = PathBuf::from(format!("{stem}.png"));
    render(&scene, &camera, SIZE).save_png(&folder.join(&path)).map_err(ExperimentError::stopped)?;
    Ok(vec![record::Picture { path: path.to_string_lossy().into_owned(), caption: caption.to_owned() }])
}
