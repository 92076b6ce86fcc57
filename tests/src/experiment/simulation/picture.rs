//! Pictures of deformed bodies, coloured by how far their points moved.

use super::Bodies;
use crate::picture::{
    Bounds, Camera, ColourMap, Decoration, Field, FieldValues, Image, Scene3, Size, render,
};
use mechanics_core::tensor::Vec3;

const SIZE: Size = Size { width: 800, height: 500 };

/// What all pictures of a film share, so that they can be compared: what the camera frames and the range of colours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    bounds: Option<Bounds>,
    largest_displacement: f64,
}

impl Frame {
    /// A frame that holds the surface of `bodies` in every one of the given states.
    pub(super) fn of<'a>(bodies: &Bodies, states: impl Iterator<Item = &'a [Vec3]> + Clone) -> Self {
        let rest = bodies.mesh().points();
        let used = bodies.surface().source_points();
        let points = states.clone().flat_map(|x| used.iter().map(|&point| x[point as usize].into()));
        let displacements = states.flat_map(|x| x.iter().zip(rest).map(|(x, rest)| (x - rest).norm()));
        Self { bounds: Bounds::of(points), largest_displacement: displacements.fold(0.0, f64::max) }
    }
}

/// The surface of `bodies` with all points at `x`.
pub(super) fn draw(bodies: &Bodies, x: &[Vec3], frame: Frame, caption: String) -> Image {
    let surface = bodies.surface();
    let source = |corner: u32| surface.source_points()[corner as usize] as usize;
    let rest = bodies.mesh().points();
    let scene = Scene3 {
        positions: x.iter().map(|&x| x.into()).collect(),
        triangles: surface.triangles().iter().map(|triangle| triangle.map(source)).collect(),
        field: Some(Field {
            name: "displacement".to_owned(),
            unit: "m".to_owned(),
            values: FieldValues::Positions(x.iter().zip(rest).map(|(x, rest)| (x - rest).norm()).collect()),
            range: Some((0.0, frame.largest_displacement)),
            map: ColourMap::default(),
        }),
        decorations: vec![Decoration::Axes, Decoration::Edges],
        caption,
        ..Scene3::default()
    };
    let camera = frame.bounds.map_or_else(Camera::default, |bounds| Camera::default().framing(bounds));
    render(&scene, &camera, SIZE)
}

/// One picture of the state `x`.
pub(super) fn still(bodies: &Bodies, x: &[Vec3]) -> Image {
    let frame = Frame::of(bodies, std::iter::once(x));
    draw(bodies, x, frame, String::new())
}
