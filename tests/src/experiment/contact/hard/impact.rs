//! Impacts so fast that a step goes far beyond what is hit.

use super::{contact, detection, jitter, stepping};
use crate::experiment::contact::portrait::{outcome_of, world_pictured};
use crate::experiment::contact::watch::Watch;
use crate::experiment::contact::world::{Limits, Material, SolidLaw, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::ContactError;
use ipc_contact::collision_mesh::CollisionObject;
use ipc_contact::contact::ContactOptions;
use mechanics_core::mesh::{BoxSplit, Diagonals, MeshError, TetMesh, TriMesh, ball, block, sheet};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::error::Error;
use std::ops::Range;

/// A body hits something thin so fast that it would be far behind it after the first step; the ladder is the step (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FastImpact {
    /// What hits what.
    case: Case,
    /// How fast (m/s).
    speed_m_s: Positive,
    /// How many steps are made.
    steps: Count,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Case {
    /// An elastic ball of radius 0.1 m and E = 2e8 Pa on a fixed sheet without thickness.
    BallOnFixedSheet,
    /// The same ball on a cloth 1 mm thick, E = 1e9 Pa, held at its rim.
    BallOnCloth,
    /// A soft box of side 0.2 m, E = 1e5 Pa, on a fixed plate 0.02 m thick.
    BoxOnPlate,
    /// A flat cloth on an equal, parallel one held at its rim, points above points.
    SheetOnSheet,
}

const ACTIVATION: f64 = 1e-3;
const BALL: Material = Material { young: 2e8, poisson: 0.3, density: 1000.0 };
const BOX: Material = Material { young: 1e5, poisson: 0.4, density: 1000.0 };
const CLOTH: Material = Material { young: 1e9, poisson: 0.3, density: 1000.0 };
const LIGHT_CLOTH: Material = Material { young: 1e6, poisson: 0.3, density: 500.0 };

/// A sheet of side `side` (m) in the plane z = 0 about the origin.
fn centred_sheet(side: f64, cells: u32) -> Result<TriMesh, MeshError> {
    let mut mesh = sheet([side; 2], [cells; 2], Diagonals::Alternating)?;
    mesh.translate(&Vec3::new(-0.5 * side, -0.5 * side, 0.0))?;
    Ok(mesh)
}

fn rim(mesh: &TriMesh, side: f64, first: u32) -> Vec<u32> {
    let is_rim = |x: &Vec3| x.x.abs().max(x.y.abs()) > 0.5 * side * (1.0 - 1e-9);
    (first..).zip(mesh.points()).filter(|(_, x)| is_rim(x)).map(|(p, _)| p).collect()
}

/// What is hit (its triangles), and what hits it.
struct Impact {
    builder: WorldBuilder,
    target: Vec<[u32; 3]>,
    body: Range<u32>,
    options: ContactOptions,
}

fn numbered(triangles: &[[u32; 3]], first: u32) -> Vec<[u32; 3]> {
    triangles.iter().map(|t| t.map(|p| p + first)).collect()
}

impl FastImpact {
    fn impact(&self, seed: u64) -> Result<Impact, ExperimentError> {
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier);
        let velocity = Vec3::new(0.0, 0.0, -self.speed_m_s.value());
        let shift = jitter(seed, 0.01);
        let start = |height: f64| Vec3::new(shift.x, shift.y, height);
        let raised = |mut mesh: TetMesh, height: f64| mesh.translate(&start(height)).map(|()| mesh);
        match self.case {
            Case::BallOnFixedSheet | Case::BallOnCloth => {
                let mesh = centred_sheet(1.0, 16).map_err(ExperimentError::stopped)?;
                let target = if self.case == Case::BallOnCloth {
                    let target = builder.add_cloth(&mesh, 1e-3, CLOTH, Vec3::zeros())?;
                    builder.script(rim(&mesh, 1.0, target.start));
                    target
                } else {
                    builder.add_obstacle(mesh.points(), |first| CollisionObject::of_mesh(&mesh, first))
                };
                let ball =
                    ball(0.1, 3).and_then(|mesh| raised(mesh, 0.15)).map_err(ExperimentError::stopped)?;
                let body = builder.add_solid(&ball, BALL, velocity)?;
                let target = numbered(mesh.triangles(), target.start);
                Ok(Impact { builder, target, body, options: contact(ACTIVATION, BALL, 0.05) })
            }
            Case::BoxOnPlate => {
                let (low, high) = (Vec3::new(-0.5, -0.5, -0.02), Vec3::new(0.5, 0.5, 0.0));
                let plate = block(&low, &high, [8, 8, 1], BoxSplit::Six)
                    .and_then(|mesh| Ok(mechanics_core::mesh::Surface::of_tets(&mesh)?.into_mesh()))
                    .map_err(ExperimentError::stopped)?;
                let target =
                    builder.add_obstacle(plate.points(), |first| CollisionObject::of_mesh(&plate, first));
                let (low, high) = (Vec3::new(-0.1, -0.1, 0.0), Vec3::new(0.1, 0.1, 0.2));
                let soft = block(&low, &high, [4; 3], BoxSplit::Six)
                    .and_then(|mesh| raised(mesh, 0.05))
                    .map_err(ExperimentError::stopped)?;
                let body = builder.add_solid(&soft, BOX, velocity)?;
                let target = numbered(plate.triangles(), target.start);
                Ok(Impact { builder, target, body, options: contact(ACTIVATION, BOX, 0.05) })
            }
            Case::SheetOnSheet => {
                let mut mesh = centred_sheet(0.5, 10).map_err(ExperimentError::stopped)?;
                let lower = builder.add_cloth(&mesh, 1e-3, LIGHT_CLOTH, Vec3::zeros())?;
                builder.script(rim(&mesh, 0.5, lower.start));
                let target = numbered(mesh.triangles(), lower.start);
                mesh.translate(&start(0.02)).map_err(ExperimentError::stopped)?;
                let body = builder.add_cloth(&mesh, 1e-3, LIGHT_CLOTH, velocity)?;
                // The membrane's stiffness is that of its thickness.
                Ok(Impact { builder, target, body, options: contact(ACTIVATION, LIGHT_CLOTH, 1e-3) })
            }
        }
    }

    fn world(&self, at: &Point<'_>) -> Result<World, ExperimentError> {
        let Impact { builder, target, body, options } = self.impact(at.seed)?;
        let options = ContactOptions { detection: detection(at.method), ..options };
        let mut world = builder.build(Vec3::zeros(), options, stepping(1e-3 * self.speed_m_s.value()))?;
        let count = world.state.position.len();
        world.watches = vec![Watch::above(target, count, body, 1e3)?];
        Ok(world)
    }

    /// Steps with the limits ignored until a check finds that something is wrong.
    fn unlimited(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut world = self.world(at)?;
        world.limits = Limits::Ignored;
        let (mut refused, mut detected_after) = (0, 0);
        for step in 1..=self.steps.value() {
            if let Err(error) = world.step(at.ladder, clock) {
                if !is_of_contact(&error) {
                    return Err(error);
                }
                refused = 1;
            }
            if refused == 1 || world.failures() != [0, 0] {
                detected_after = step;
                break;
            }
        }
        let [intersections, sides] = world.failures();
        let outcome = Outcome::default()
            .count("detected by refusal of a step", refused)
            .count("detected by exact checks", intersections)
            .count("detected by topological checks", sides)
            .count("step of the detection", detected_after as u64)
            .invariant("detected", f64::from(u8::from(detected_after > 0)));
        world_pictured(outcome, &world, at)
    }
}

/// Whether contact itself refused a step's positions: because they intersect, or are too close.
fn is_of_contact(error: &ExperimentError) -> bool {
    let ExperimentError::Stopped(error) = error else { return false };
    let mut cause: Option<&(dyn Error + 'static)> = Some(&**error);
    while let Some(error) = cause {
        if error.is::<ContactError>() {
            return true;
        }
        cause = error.source();
    }
    false
}

impl Experiment for FastImpact {
    fn methods(&self) -> &'static [&'static str] {
        &["additive", "interval", "unlimited"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        if at.method == "unlimited" {
            return self.unlimited(at, clock);
        }
        let mut world = self.world(at)?;
        for _ in 0..self.steps.value() {
            world.step(at.ladder, clock)?;
        }
        outcome_of(&world, at)
    }
}
