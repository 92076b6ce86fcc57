//! A folded strip of cloth, pressed.

use super::{GRAVITY, contact, jitter, stepping};
use crate::experiment::contact::portrait::outcome_of;
use crate::experiment::contact::watch::Watch;
use crate::experiment::contact::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Count;
use ipc_contact::collision_mesh::{CollisionObject, HalfSpace, SelfContact};
use mechanics_core::mesh::{Diagonals, TriMesh, sheet};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A strip of cloth, flat at rest, 0.1 m wide and 0.2 mm thick, E = 1e6 Pa, 400 kg/m³, folded to and fro into layers of 0.1 m that
/// lie 4 mm apart on a half-space, pressed by a plate from above to a part of its height. The ladder is the step (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FoldedCloth {
    /// How many layers.
    layers: Count,
    /// How many steps are made; the plate comes down in the first four fifths of them.
    steps: Count,
}

const LENGTH: f64 = 0.1;
const RISE: f64 = 4e-3;
const CELLS: u32 = 4;
const ACTIVATION: f64 = 1e-3;
const CLOTH: Material = Material { young: 1e6, poisson: 0.3, density: 400.0 };
/// The height that the plate leaves for each layer (m).
const PRESSED: f64 = 1.5e-3;

struct Strip {
    flat: TriMesh,
    folded: Vec<Vec3>,
    /// Points inside of each layer.
    inner: Vec<Vec<u32>>,
    /// Triangles of each layer.
    triangles: Vec<Vec<[u32; 3]>>,
}

impl Strip {
    fn new(layers: u32, seed: u64) -> Result<Self, ExperimentError> {
        let columns = layers * (CELLS + 1) - 1;
        let mut flat = sheet([f64::from(columns), LENGTH], [columns, CELLS], Diagonals::Alternating)
            .map_err(ExperimentError::stopped)?;
        // The column of a point, still its x coordinate: which layer, and how far along it.
        let column = |x: f64| {
            let c = x.round() as u32;
            (c / (CELLS + 1), c % (CELLS + 1))
        };
        let along = |k: u32| LENGTH * f64::from(k) / f64::from(CELLS);
        let shift = jitter(seed, 1e-3);
        let fold = |p: &Vec3| {
            let (layer, k) = column(p.x);
            let x = if layer % 2 == 0 { along(k) } else { LENGTH - along(k) };
            let lean = f64::from(layer) / f64::from(layers);
            Vec3::new(x + shift.x * lean, p.y + shift.y * lean, RISE * (0.5 + f64::from(layer)))
        };
        let folded = flat.points().iter().map(fold).collect();
        let columns: Vec<(u32, u32)> = flat.points().iter().map(|p| column(p.x)).collect();
        let (mut inner, mut triangles) =
            (vec![Vec::new(); layers as usize], vec![Vec::new(); layers as usize]);
        for (point, (layer, k)) in (0..).zip(&columns) {
            if *k > 0 && *k < CELLS {
                inner[*layer as usize].push(point);
            }
        }
        for triangle in flat.triangles() {
            let [a, b, c] = triangle.map(|p| columns[p as usize].0);
            if a == b && b == c {
                triangles[a as usize].push(*triangle);
            }
        }
        flat.map_points(|p| {
            let (layer, k) = column(p.x);
            Vec3::new(f64::from(layer) * (LENGTH + RISE) + along(k), p.y, 0.0)
        })
        .map_err(ExperimentError::stopped)?;
        Ok(Self { flat, folded, inner, triangles })
    }
}

impl Experiment for FoldedCloth {
    fn methods(&self) -> &'static [&'static str] {
        &["additive", "interval"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let layers = self.layers.value() as u32;
        let strip = Strip::new(layers, at.seed)?;
        let mut builder = WorldBuilder::default();
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        builder.add_cloth(&strip.flat, 2e-4, CLOTH, Vec3::zeros())?;
        let top = RISE * (f64::from(layers) + 0.5);
        let mut plate =
            sheet([2.0 * LENGTH; 2], [3; 2], Diagonals::Alternating).map_err(ExperimentError::stopped)?;
        plate.translate(&Vec3::new(-0.5 * LENGTH, -0.5 * LENGTH, top)).map_err(ExperimentError::stopped)?;
        let plate_points = builder.add_obstacle(plate.points(), |first| {
            CollisionObject::of_mesh(&plate, first).with_self_contact(SelfContact::Excluded)
        });
        let mut world: World = builder.build(GRAVITY, contact(ACTIVATION, CLOTH, 2e-4), stepping(1e-3))?;
        world.state.position[..strip.folded.len()].copy_from_slice(&strip.folded);
        let count = world.state.position.len();
        for pair in 1..layers as usize {
            let below = strip.triangles[pair - 1].clone();
            world.watches.push(Watch::above(below, count, strip.inner[pair].iter().copied(), 1.0)?);
        }
        let steps = self.steps.value();
        let way = top - PRESSED * f64::from(layers);
        for step in 1..=steps {
            let part = (1.25 * step as f64 / steps as f64).min(1.0);
            for (point, rest) in plate_points.clone().zip(plate.points()) {
                world.move_to(point, rest - Vec3::new(0.0, 0.0, way * part))?;
            }
            world.step(at.ladder, clock)?;
        }
        outcome_of(&world, at)
    }
}
