//! Pictures of bodies, coloured by how far their points moved, or how fast they move.

use super::Bodies;
use super::course::{Course, Shade};
use crate::picture::{
    Bounds, Camera, ColourMap, Decoration, Field, FieldValues, Image, Scene3, Size, render,
};
use mechanics_core::tensor::Vec3;

const SIZE: Size = Size { width: 800, height: 500 };

/// A state that is drawn.
pub(super) struct Snapshot {
    positions: Vec<Vec3>,
    shade: Shade,
    caption: String,
    floor: Option<f64>,
}

impl Snapshot {
    /// The state of `course` now.
    pub(super) fn of(course: &Course) -> Self {
        Self {
            positions: course.positions().to_vec(),
            shade: course.shade(),
            caption: course.caption(),
            floor: course.floor(),
        }
    }
}

/// What all pictures of a film share, so that they can be compared: what the camera frames and the range of colours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    bounds: Option<Bounds>,
    largest: f64,
}

impl Frame {
    /// A frame that holds the surface of `bodies` in every one of the given states.
    pub(super) fn of<'a>(bodies: &Bodies, snapshots: impl Iterator<Item = &'a Snapshot> + Clone) -> Self {
        let used = bodies.surface().source_points();
        let points = snapshots
            .clone()
            .flat_map(|snapshot| used.iter().map(|&point| snapshot.positions[point as usize].into()));
        let values = snapshots.flat_map(|snapshot| snapshot.shade.values.iter().copied());
        Self { bounds: Bounds::of(points), largest: values.fold(0.0, f64::max) }
    }
}

/// The surface of `bodies` as it is in `snapshot`.
pub(super) fn draw(bodies: &Bodies, snapshot: &Snapshot, frame: Frame) -> Image {
    let surface = bodies.surface();
    let source = |corner: u32| surface.source_points()[corner as usize] as usize;
    let mut decorations = vec![Decoration::Axes, Decoration::Edges];
    decorations.extend(snapshot.floor.map(Decoration::Ground));
    let scene = Scene3 {
        positions: snapshot.positions.iter().map(|&x| x.into()).collect(),
        triangles: surface.triangles().iter().map(|triangle| triangle.map(source)).collect(),
        field: Some(Field {
            name: snapshot.shade.name.to_owned(),
            unit: snapshot.shade.unit.to_owned(),
            values: FieldValues::Positions(snapshot.shade.values.clone()),
            range: Some((0.0, frame.largest)),
            map: ColourMap::default(),
        }),
        decorations,
        caption: snapshot.caption.clone(),
        ..Scene3::default()
    };
    let camera = frame.bounds.map_or_else(Camera::default, |bounds| Camera::default().framing(bounds));
    render(&scene, &camera, SIZE)
}

/// One picture of the state of `course`.
pub(super) fn still(course: &Course) -> Image {
    let snapshot = Snapshot { caption: String::new(), ..Snapshot::of(course) };
    draw(course.bodies(), &snapshot, Frame::of(course.bodies(), std::iter::once(&snapshot)))
}
