//! Pictures of bodies in contact.

use crate::experiment::{ExperimentError, Outcome, Point};
use crate::picture::{Camera, ColourMap, Decoration, Field, FieldValues, Scene3, Size, render};
use crate::record::Picture;
use mechanics_core::tensor::Vec3;

const SIZE: Size = Size { width: 800, height: 500 };

/// `outcome` with a picture of these triangles, coloured by a field (its name, its unit, a value for each point), if pictures are wanted.
pub(in crate::experiment) fn pictured(
    outcome: Outcome,
    at: &Point<'_>,
    x: &[Vec3],
    triangles: &[[u32; 3]],
    field: (&str, &str, Vec<f64>),
) -> Result<Outcome, ExperimentError> {
    let caption = format!("{} with {} at {:e}", field.0, at.method, at.ladder);
    captioned(outcome, at, x, triangles, field, caption)
}

/// The same with a caption.
pub(in crate::experiment) fn captioned(
    mut outcome: Outcome,
    at: &Point<'_>,
    x: &[Vec3],
    triangles: &[[u32; 3]],
    (name, unit, values): (&str, &str, Vec<f64>),
    caption: String,
) -> Result<Outcome, ExperimentError> {
    let Some((folder, stem)) = at.frames else { return Ok(outcome) };
    let scene = Scene3 {
        positions: x.iter().map(|&x| x.into()).collect(),
        triangles: triangles.iter().map(|triangle| triangle.map(|point| point as usize)).collect(),
        field: Some(Field {
            name: name.to_owned(),
            unit: unit.to_owned(),
            values: FieldValues::Positions(values),
            range: None,
            map: ColourMap::default(),
        }),
        decorations: vec![Decoration::Axes, Decoration::Edges],
        ..Scene3::default()
    };
    let path = format!("{stem}.png");
    render(&scene, &Camera::default(), SIZE)
        .save_png(&folder.join(&path))
        .map_err(ExperimentError::stopped)?;
    outcome.pictures.push(Picture { path, caption });
    Ok(outcome)
}
