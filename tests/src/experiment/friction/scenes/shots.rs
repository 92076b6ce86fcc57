//! Pictures of a scene at several times.

use crate::experiment::{ExperimentError, Outcome, Point};
use crate::picture::{Camera, ColourMap, Decoration, Field, FieldValues, Lens, Scene3, Size, render};
use crate::record::Picture;
use mechanics_core::tensor::Vec3;

const SIZE: Size = Size { width: 800, height: 500 };

/// The pictures of a run, where pictures are wanted.
pub(super) struct Shots<'a> {
    at: &'a Point<'a>,
    camera: Camera,
    triangles: Vec<[usize; 3]>,
    taken: Vec<Picture>,
}

impl<'a> Shots<'a> {
    /// Pictures of these triangles, looked at from this direction.
    pub(super) fn new<'t>(
        at: &'a Point<'a>,
        towards: [f64; 3],
        skins: impl IntoIterator<Item = &'t [[u32; 3]]>,
    ) -> Self {
        let camera = Camera { towards, lens: Lens::Perspective(20.0), ..Camera::default() };
        let triangles = skins.into_iter().flatten().map(|t| t.map(|p| p as usize)).collect();
        Self { at, camera, triangles, taken: Vec::new() }
    }

    /// Takes a picture, coloured by a field (its name, its unit, its value for each point).
    pub(super) fn take(
        &mut self,
        x: &[Vec3],
        (name, unit, value): (&str, &str, impl Fn(usize) -> f64),
        when: &str,
    ) -> Result<(), ExperimentError> {
        let Some((folder, stem)) = self.at.frames else { return Ok(()) };
        let scene = Scene3 {
            positions: x.iter().map(|&x| x.into()).collect(),
            triangles: self.triangles.clone(),
            field: Some(Field {
                name: name.to_owned(),
                unit: unit.to_owned(),
                values: FieldValues::Positions((0..x.len()).map(value).collect()),
                range: None,
                map: ColourMap::default(),
            }),
            decorations: vec![Decoration::Axes, Decoration::Edges],
            ..Scene3::default()
        };
        let path = format!("{stem}-{}.png", self.taken.len());
        render(&scene, &self.camera, SIZE).save_png(&folder.join(&path)).map_err(ExperimentError::stopped)?;
        let caption = format!("{when}, {name}: {}", self.at.title());
        self.taken.push(Picture { path, caption });
        Ok(())
    }

    /// `outcome` with the pictures.
    pub(super) fn add_to(self, mut outcome: Outcome) -> Outcome {
        outcome.pictures.extend(self.taken);
        outcome
    }
}
