//! Pictures of bodies in contact.

use super::world::World;
use crate::experiment::{ExperimentError, Outcome, Point};
use crate::picture::{Camera, ColourMap, Decoration, Field, FieldValues, Scene3, Size, render};
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
    let caption = caption_of(at, field.0);
    captioned(outcome, at, x, triangles, field, &caption)
}

/// The same with a caption.
pub(in crate::experiment) fn captioned(
    outcome: Outcome,
    at: &Point<'_>,
    x: &[Vec3],
    triangles: &[[u32; 3]],
    field: (&str, &str, Vec<f64>),
    caption: &str,
) -> Result<Outcome, ExperimentError> {
    let geometry =
        || Scene3 { triangles: triangles.iter().map(|points| numbers(*points)).collect(), ..at_points(x) };
    drawn(outcome, at, geometry, field, caption)
}

/// What was counted of `world`, with a picture of it.
pub(in crate::experiment) fn outcome_of(world: &World, at: &Point<'_>) -> Result<Outcome, ExperimentError> {
    world_pictured(world.outcome(), world, at)
}

/// `outcome` with a picture of all in `world` that may touch, coloured by speed, if pictures are wanted.
pub(in crate::experiment) fn world_pictured(
    outcome: Outcome,
    world: &World,
    at: &Point<'_>,
) -> Result<Outcome, ExperimentError> {
    let mesh = world.contact.mesh();
    let geometry = || Scene3 {
        triangles: mesh.triangles().iter().map(|points| numbers(*points)).collect(),
        segments: mesh.loose_edges().iter().map(|&edge| numbers(mesh.edges()[edge as usize])).collect(),
        points: mesh.loose_points().iter().map(|&point| point as usize).collect(),
        ..at_points(&world.state.position)
    };
    let speeds = world.state.velocity.iter().map(|v| v.norm()).collect();
    drawn(outcome, at, geometry, ("speed", "m/s", speeds), &caption_of(at, "speed"))
}

fn caption_of(at: &Point<'_>, field: &str) -> String {
    format!("{field}: {}", at.title())
}

fn numbers<const N: usize>(points: [u32; N]) -> [usize; N] {
    points.map(|point| point as usize)
}

fn at_points(x: &[Vec3]) -> Scene3 {
    Scene3 { positions: x.iter().map(|&x| x.into()).collect(), ..Scene3::default() }
}

fn drawn(
    outcome: Outcome,
    at: &Point<'_>,
    geometry: impl FnOnce() -> Scene3,
    (name, unit, values): (&str, &str, Vec<f64>),
    caption: &str,
) -> Result<Outcome, ExperimentError> {
    outcome.pictured(at, caption, || {
        let scene = Scene3 {
            field: Some(Field {
                name: name.to_owned(),
                unit: unit.to_owned(),
                values: FieldValues::Positions(values),
                range: None,
                map: ColourMap::default(),
            }),
            decorations: vec![Decoration::Axes, Decoration::Edges],
            ..geometry()
        };
        Ok(render(&scene, &Camera::default(), SIZE))
    })
}
