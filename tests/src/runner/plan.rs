//! Which rows a scene takes under the settings of a run.

use super::Settings;
use super::job::Job;
use super::output::file_stem;
use crate::runner::Pictures;
use crate::scene::Scene;
use crate::scene::quantity::Count;
use crate::scene::validation::{Suite, Validation};
use std::time::Duration;

/// The rows of a scene.
pub(crate) struct Plan<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) validation: &'a Validation,
    /// Ladder points, from the coarsest.
    pub(crate) points: usize,
    pub(crate) lines: Vec<LineSpec>,
    pub(crate) threads: Vec<usize>,
    pub(crate) repeats: usize,
}

/// One work–precision line.
pub(crate) struct LineSpec {
    pub(crate) label: String,
    pub(crate) method: String,
    pub(crate) seed: u64,
}

impl<'a> Plan<'a> {
    /// The plan; `None` for a scene that claims nothing.
    pub(crate) fn new(scene: &'a Scene, settings: &Settings) -> Option<Self> {
        let validation = scene.file.validation.as_ref()?;
        let mut points = validation.ladder.values.len();
        if settings.suite == Some(Suite::Quick) {
            points = validation.ladder.quick_points.map_or(points, Count::value);
        }
        points = points.min(settings.ladder_points.unwrap_or(points));
        let threads = settings.threads.clone();
        Some(Self {
            scene,
            validation,
            points,
            lines: lines(validation),
            threads: threads
                .unwrap_or_else(|| validation.threads.iter().map(|count| count.value()).collect()),
            repeats: settings.repeats.unwrap_or(validation.repeats.value()),
        })
    }

    pub(crate) fn row_count(&self) -> usize {
        self.points * self.lines.len() * self.threads.len()
    }

    pub(crate) fn time_limit(&self) -> Duration {
        Duration::from_secs_f64(self.validation.time_limit_s.value())
    }

    /// The job of a row; pictures are wanted of the finest point with the first number of threads.
    pub(crate) fn job(&self, line: &LineSpec, point: usize, threads: usize, settings: &Settings) -> Job {
        let pictured =
            settings.pictures == Pictures::Made && point + 1 == self.points && threads == self.threads[0];
        let stem = format!("{}__{}", file_stem(&self.scene.name), file_stem(&line.label).replace(' ', "-"));
        Job {
            scene: self.scene.path.clone(),
            method: line.method.clone(),
            ladder: self.validation.ladder.values[point].value(),
            seed: line.seed,
            threads,
            repeats: self.repeats,
            frames: pictured.then(|| (settings.output.join(super::FRAMES), stem)),
        }
    }
}

fn lines(validation: &Validation) -> Vec<LineSpec> {
    let line = |method: &String, seed: Option<u64>| LineSpec {
        label: seed.map_or_else(|| method.clone(), |seed| format!("{method}, seed {seed}")),
        method: method.clone(),
        seed: seed.unwrap_or(0),
    };
    let methods = validation.methods.iter();
    if validation.seeds.is_empty() {
        return methods.map(|method| line(method, None)).collect();
    }
    methods
        .flat_map(|method| validation.seeds.iter().map(move |seed| line(method, Some(seed.value()))))
        .collect()
}
