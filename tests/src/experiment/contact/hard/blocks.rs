//! Two blocks that fall onto each other and the floor, with one parameter driven to extremes.

use super::{GRAVITY, contact, detection, jitter, stepping};
use crate::experiment::contact::portrait::outcome_of;
use crate::experiment::contact::watch::Watch;
use crate::experiment::contact::world::{Material, SolidLaw, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Count;
use ipc_contact::collision_mesh::{CollisionObject, HalfSpace};
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Two cubes of 0.1 m, E = 1e5 Pa, 1000 kg/m³, one 2 mm above the other and that 2 mm above a half-space, thrown down at 1 m/s:
/// h = 0.01 s, d̂ = 1 mm; the ladder is the one of these that is varied.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TwoBlocks {
    /// What the ladder is.
    varied: Varied,
    /// How many steps are made.
    steps: Count,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Varied {
    /// The distance at which contact begins (m).
    ActivationDistance,
    /// The step (s).
    Step,
    /// The Young's modulus of the upper block over that of the lower one, of which the softer has 1e5 Pa.
    StiffnessRatio,
}

const SIDE: f64 = 0.1;
const GAP: f64 = 2e-3;
const CELLS: u32 = 3;
/// About the largest force on a point of the impact: the momentum of both blocks in a step, shared by the lower one's 16 (N).
const LOAD: f64 = 10.0;

impl Experiment for TwoBlocks {
    fn methods(&self) -> &'static [&'static str] {
        &["additive", "interval", "stated-load"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (mut activation, mut step, mut ratio) = (1e-3, 0.01, 1.0);
        match self.varied {
            Varied::ActivationDistance => activation = at.ladder,
            Varied::Step => step = at.ladder,
            Varied::StiffnessRatio => ratio = at.ladder,
        }
        let soft = Material { young: 1e5, poisson: 0.4, density: 1000.0 };
        let lower = Material { young: soft.young * (1.0 / ratio).max(1.0), ..soft };
        let upper = Material { young: soft.young * ratio.max(1.0), ..soft };
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier);
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        let mut bodies = Vec::new();
        for (number, material) in [(0, lower), (1, upper)] {
            let shift = jitter(at.seed + at.seed.min(1) * 100 * number, 0.01 * SIDE);
            let low = Vec3::new(shift.x, shift.y, GAP + (SIDE + GAP) * number as f64);
            let mesh = block(&low, &(low + Vec3::repeat(SIDE)), [CELLS; 3], BoxSplit::Six)
                .map_err(ExperimentError::stopped)?;
            let points = builder.add_solid(&mesh, material, Vec3::new(0.0, 0.0, -1.0))?;
            let skin = CollisionObject::of_tets(&mesh, points.start).map_err(ExperimentError::stopped)?;
            bodies.push((points, skin.triangles));
        }
        let mut options = ContactOptions {
            detection: detection(at.method),
            ..contact(activation, soft, SIDE / f64::from(CELLS))
        };
        if at.method == "stated-load" {
            options.stiffness = Stiffness::adaptive(Scale::Load(LOAD));
        }
        // A velocity, of which a long step makes more than a short one.
        let tolerance = 1e-3 * (0.01 / step).min(1.0);
        let mut world = builder.build(GRAVITY, options, stepping(tolerance))?;
        let count = world.state.position.len();
        let (upper, lower) = (&bodies[1], &bodies[0]);
        world.watches = vec![
            Watch::outside(upper.1.clone(), count, lower.0.clone())?,
            Watch::outside(lower.1.clone(), count, upper.0.clone())?,
        ];
        for _ in 0..self.steps.value() {
            world.step(step, clock)?;
        }
        outcome_of(&world, at)
    }
}
