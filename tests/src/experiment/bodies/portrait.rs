//! Pictures of deformed solids.

use super::solid::Solid;
use crate::experiment::{ExperimentError, Outcome, Point};
use crate::picture::{Camera, ColourMap, Decoration, Field, FieldValues, Scene3, Size, render};
use crate::record::Picture;
use mechanics_core::tensor::Vec3;

const SIZE: Size = Size { width: 800, height: 500 };

/// `outcome` with a picture of `solid` with its nodes at `x`, coloured by displacement, if pictures are wanted.
pub(super) fn pictured(
    outcome: Outcome,
    at: &Point<'_>,
    solid: &Solid,
    x: &[Vec3],
    caption: &str,
) -> Result<Outcome, ExperimentError> {
    let Some((folder, stem)) = at.frames else { return Ok(outcome) };
    let displacements = x.iter().zip(&solid.points).map(|(x, rest)| (x - rest).norm());
    let scene = Scene3 {
        positions: x.iter().map(|&x| x.into()).collect(),
        triangles: solid.skin().into_iter().map(|triangle| triangle.map(|node| node as usize)).collect(),
        field: Some(Field {
            name: "displacement".to_owned(),
            unit: "m".to_owned(),
            values: FieldValues::Positions(displacements.collect()),
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
    let mut outcome = outcome;
    outcome.pictures.push(Picture { path, caption: caption.to_owned() });
    Ok(outcome)
}
