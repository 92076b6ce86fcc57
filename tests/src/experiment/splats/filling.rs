//! Filling of shells whose inside is known.

use super::inside::inside;
use super::surface::{ClosedSurface, Cover, cover};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Image, Size, colour_image};
use crate::scene::quantity::Positive;
use gaussian_deform::fill::{CellGrid, Direction, Filled, Parity, Rules, Source, fill};
use mechanics_core::mesh::TriMesh;
use mechanics_core::state::StateHash;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Closed surfaces covered with splats, and filled; the ladder is the length of a cell (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SplatFilling {
    sphere: ClosedSurface,
    torus: ClosedSurface,
    file: ClosedSurface,
    /// Distance of splats, in cells.
    spacing_cells: Positive,
    /// The smallest standard deviation that filling takes, in cells: what makes discs as thick as cells.
    thinnest_cells: Positive,
}

const METHODS: [&str; 6] = [
    "sphere, one ray",
    "sphere, six rays",
    "torus, one ray",
    "torus, six rays",
    "bunny, one ray",
    "bunny, six rays",
];

/// What there is in every cell.
struct Judged {
    /// Whether its centre is inside.
    truth: Vec<bool>,
    /// Whether there are particles.
    found: Vec<bool>,
    /// Whether all cells around are on the same side as it is.
    deep: Vec<bool>,
}

impl Experiment for SplatFilling {
    fn methods(&self) -> &'static [&'static str] {
        &METHODS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (body, rays) = at.method.split_once(", ").unwrap_or_default();
        let surface = match body {
            "sphere" => &self.sphere,
            "torus" => &self.torus,
            _ => &self.file,
        };
        let mesh = surface.mesh(at.folder)?;
        let splats = cover(
            &mesh,
            &Cover {
                spacing: self.spacing_cells.value() * at.ladder,
                degree: gaussian_deform::Degree::Zero,
                ..Cover::default()
            },
        );
        let source = |i: usize| Source {
            mean: splats.means()[i],
            axes: splats.axes()[i],
            opacity: splats.opacities()[i],
        };
        let sources: Vec<Source> = (0..splats.count()).map(source).collect();
        let grid = around(&mesh, at.ladder);
        let rules = Rules {
            parity: if rays == "one ray" { Parity::Along(Direction::PlusZ) } else { Parity::Majority },
            thinnest: self.thinnest_cells.value(),
            ..Rules::default()
        };
        let filled = clock.time(|| fill(&sources, &grid, &rules)).map_err(ExperimentError::stopped)?;
        let judged = Judged::new(&mesh, &grid, &sources, &filled);
        let inner = judged.truth.iter().filter(|inside| **inside).count() as f64;
        let count = |counts: &dyn Fn(usize) -> bool| (0..grid.cells()).filter(|&cell| counts(cell)).count();
        let wrong = |cell: usize| judged.truth[cell] != judged.found[cell];
        let far = count(&|cell| wrong(cell) && judged.deep[cell]);
        let volume = mesh.enclosed_volume();
        let mut hash = StateHash::new();
        hash.add_vectors("particles", &filled.positions);
        hash.add("volumes", &filled.volumes);
        let outcome = Outcome::default()
            .error("wrong cells by cells inside", count(&wrong) as f64 / inner)
            .error("wrong cells away from the surface by cells inside", far as f64 / inner)
            .error("volume too large", filled.volumes.iter().sum::<f64>() / volume - 1.0)
            .count("splats", sources.len() as u64)
            .count("cells", grid.cells() as u64)
            .count("new particles", filled.positions.len() as u64)
            .invariant("splats outside of the grid", filled.outside.len() as f64)
            .state(hash.value());
        let caption = format!("{}, cells of {} m: the middle slice", at.method, at.ladder);
        outcome.pictured(at, &caption, || Ok(slice(&judged, &grid, at.method)))
    }
}

/// Cells of a length around a body, two of them free on every side, placed without regard to it.
fn around(mesh: &TriMesh, cell: f64) -> CellGrid {
    let (low, size) = mesh.bounding_box().map_or_else(Default::default, |b| (b.min, b.size()));
    let counts = [0, 1, 2].map(|k| (size[k] / cell).ceil() as usize + 5);
    CellGrid { origin: low - Vec3::new(2.31, 2.17, 2.43) * cell, cell, counts }
}

impl Judged {
    fn new(mesh: &TriMesh, grid: &CellGrid, sources: &[Source], filled: &Filled) -> Self {
        let truth = inside(mesh, grid);
        let mut found = vec![false; grid.cells()];
        sources.iter().filter_map(|source| grid.cell_of(&source.mean)).for_each(|cell| found[cell] = true);
        filled.inner.iter().chain(&filled.topped_up).for_each(|&cell| found[cell as usize] = true);
        let deep = (0..grid.cells()).map(|cell| is_deep(&truth, grid, cell)).collect();
        Self { truth, found, deep }
    }
}

/// Whether all 26 neighbours of a cell are on its side; beyond the grid is outside.
fn is_deep(truth: &[bool], grid: &CellGrid, cell: usize) -> bool {
    let [i, j, k] = grid.indices(cell).map(|index| index as i64);
    let [a, b, c] = grid.counts.map(|count| count as i64);
    let side = |i: i64, j: i64, k: i64| {
        let within = (0..a).contains(&i) && (0..b).contains(&j) && (0..c).contains(&k);
        within && truth[((i * b + j) * c + k) as usize]
    };
    let here = truth[cell];
    (0..27).all(|n| side(i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1) == here)
}

/// The cells of the middle slice across z, y upwards: grey found and inside, white neither, light blue found where the surface passes though the centre is outside, light red not found there though it is inside; blue and red farther away.
fn slice(judged: &Judged, grid: &CellGrid, method: &str) -> Image {
    let [a, b, c] = grid.counts;
    let scale = (400 / a.max(b)).max(1);
    let size = Size { width: a * scale, height: b * scale };
    let colour = |pixel: usize| {
        let (i, j) = (pixel % size.width / scale, b - 1 - pixel / size.width / scale);
        let cell = (i * b + j) * c + c / 2;
        match (judged.truth[cell], judged.found[cell], judged.deep[cell]) {
            (true, true, true) => [0.62, 0.66, 0.62],
            (true, true, false) => [0.45, 0.50, 0.45],
            (false, false, _) => [1.0; 3],
            (false, true, false) => [0.60, 0.75, 0.95],
            (true, false, false) => [0.98, 0.70, 0.60],
            (false, true, true) => [0.0, 0.2, 0.9],
            (true, false, true) => [0.9, 0.0, 0.0],
        }
    };
    let colours: Vec<[f64; 3]> = (0..size.width * size.height).map(colour).collect();
    colour_image(size, &colours, method)
}
