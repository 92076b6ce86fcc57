//! Hard cases with friction: no reference, but what must hold whatever happens. After every step nothing intersects by exact
//! predicates and nobody is on the wrong side of anything; lagging has settled (else the step is an error, but for the pairs that report it); where energy went is
//! accounted for.

use super::friction;
use crate::experiment::contact::hard::pairs::{HALF, MATERIAL, PAIRS, pair};
use crate::experiment::contact::hard::{GRAVITY, contact, jitter, stepping};
use crate::experiment::contact::portrait::{outcome_of, world_pictured};
use crate::experiment::contact::watch::Watch;
use crate::experiment::contact::world::{Material, SolidLaw, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::{CollisionObject, HalfSpace};
use lagrangian::stepper::{Lagging, StepperOptions};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Lag passes after which not having settled is an error.
const LAGS: u64 = 400;

fn lagging(tolerance: f64) -> StepperOptions {
    StepperOptions { lagging: Lagging::Until(LAGS), ..stepping(tolerance) }
}

/// A small elastic body, E = 1e5 Pa, 1000 kg/m³, 0.1 m high, that meets a fixed obstacle with 1 m/s, feature exactly on feature
/// (seed 0) or moved and turned by 10⁻¹⁻ˢ of its size (seed s): the pairs of ipc-contact, with friction. d̂ = 1 mm; μ = 0.5, h = 0.01 s and
/// εᵥ = 1 mm/s but for the one that the ladder is.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FrictionPair {
    /// What the ladder is.
    varied: Varied,
    /// For how long (s).
    duration_s: Positive,
    /// But for at least so many steps.
    fewest_steps: Count,
    /// What becomes of a step whose lagging does not settle.
    unsettled: Unsettled,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Unsettled {
    /// It is an error.
    Refused,
    /// It is taken as it is, and counted.
    Reported,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Varied {
    /// μ + 1.
    FrictionCoefficient,
    /// εᵥ (m/s).
    StickVelocity,
    /// h (s).
    Step,
}

impl Experiment for FrictionPair {
    fn methods(&self) -> &'static [&'static str] {
        PAIRS
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (mut coefficient, mut stick, mut h) = (0.5, 1e-3, 0.01);
        match self.varied {
            Varied::FrictionCoefficient => coefficient = at.ladder - 1.0,
            Varied::StickVelocity => stick = at.ladder,
            Varied::Step => h = at.ladder,
        }
        let mut pair = pair(at.method).map_err(ExperimentError::stopped)?;
        pair.place(at.method, at.seed).map_err(ExperimentError::stopped)?;
        let builder = WorldBuilder::of_law(SolidLaw::Barrier).with_friction(friction(coefficient, stick)?);
        // A hundredth of d̂ in a step, a tenth of εᵥ, and 1e-5 of the speed at which they meet: energy balances about a tenth as well.
        let tolerance = (1e-5 / h).min(0.1 * stick).min(1e-5);
        let mut stepping = lagging(tolerance);
        if self.unsettled == Unsettled::Reported {
            stepping.lagging = Lagging::AtMost(LAGS);
        }
        let mut world = pair.world(builder, contact(1e-3, MATERIAL, HALF), stepping)?;
        pair.allow_ways_around(&mut world, h)?;
        let steps = (self.duration_s.value() / h).ceil().max(self.fewest_steps.value() as f64);
        for _ in 0..steps as u64 {
            world.step(h, clock)?;
        }
        outcome_of(&world, at)
    }
}

/// A cube of 0.1 m is thrown at another that lies on a half-space, and slides on it; the ladder is the density of the upper one over that of
/// the lower one, of which the lighter has 1000 kg/m³. E = 1e5 Pa times the larger of both over 1000 kg/m³, so that weight crushes neither.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct HeavyOnLight {
    /// The step (s).
    step_s: Positive,
    /// How many are made.
    steps: Count,
    /// μ.
    friction_coefficient: Positive,
}

const SIDE: f64 = 0.1;
const CELLS: u32 = 2;
const SOFT: Material = Material { young: 1e5, poisson: 0.4, density: 1000.0 };

/// Adds a cube whose lowest corner is at `low`; answers its points and its surface.
fn add_cube(
    builder: &mut WorldBuilder,
    low: Vec3,
    material: Material,
    velocity: Vec3,
) -> Result<Cube, ExperimentError> {
    let mesh =
        block(&low, &low.add_scalar(SIDE), [CELLS; 3], BoxSplit::Six).map_err(ExperimentError::stopped)?;
    let points = builder.add_solid(&mesh, material, velocity)?;
    let skin = CollisionObject::of_tets(&mesh, points.start).map_err(ExperimentError::stopped)?;
    Ok(Cube { points, skin: skin.triangles })
}

struct Cube {
    points: std::ops::Range<u32>,
    skin: Vec<[u32; 3]>,
}

/// That no cube has a point of another inside.
fn watch(world: &mut World, cubes: &[Cube]) -> Result<(), ExperimentError> {
    let count = world.state.position.len();
    for (i, a) in cubes.iter().enumerate() {
        for (_, b) in cubes.iter().enumerate().filter(|(j, _)| *j != i) {
            world.watches.push(Watch::outside(a.skin.clone(), count, b.points.clone())?);
        }
    }
    Ok(())
}

impl Experiment for HeavyOnLight {
    fn methods(&self) -> &'static [&'static str] {
        &["additive"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let h = self.step_s.value();
        let larger = at.ladder.max(1.0 / at.ladder);
        let material = |ratio: f64| Material {
            young: SOFT.young * larger,
            density: SOFT.density * ratio.max(1.0),
            ..SOFT
        };
        let [lower, upper] = [1.0 / at.ladder, at.ladder].map(material);
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier)
            .with_friction(friction(self.friction_coefficient.value(), 1e-3)?);
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        let shift = jitter(at.seed, 0.01 * SIDE);
        let cubes = [
            add_cube(&mut builder, Vec3::new(0.0, 0.0, 2e-3), lower, Vec3::zeros())?,
            add_cube(
                &mut builder,
                Vec3::new(0.02 + shift.x, 0.01 + shift.y, SIDE + 4e-3),
                upper,
                Vec3::new(0.5, 0.0, -0.5),
            )?,
        ];
        let options = contact(1e-3, upper, SIDE / f64::from(CELLS));
        let mut world = builder.build(GRAVITY, options, lagging(1e-4))?;
        watch(&mut world, &cubes)?;
        for _ in 0..self.steps.value() {
            world.step(h, clock)?;
        }
        outcome_of(&world, at)
    }
}

/// A pyramid of six cubes of 0.1 m, three, two and one, on a slope: everything sticks. The ladder is εᵥ (m/s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StickingPile {
    /// The angle of the slope (°).
    slope_deg: Positive,
    /// μ.
    friction_coefficient: Positive,
    /// The step (s).
    step_s: Positive,
    /// For how long (s).
    duration_s: Positive,
}

impl Experiment for StickingPile {
    fn methods(&self) -> &'static [&'static str] {
        &["additive"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        const GAP: f64 = 4e-4;
        let (h, angle) = (self.step_s.value(), self.slope_deg.value().to_radians());
        let options = friction(self.friction_coefficient.value(), at.ladder)?;
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier).with_friction(options);
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        let mut cubes = Vec::new();
        for level in 0..3 {
            for place in 0..3 - level {
                let seed = at.seed + at.seed.min(1) * 100 * cubes.len() as u64;
                let shift = jitter(seed, 0.02 * SIDE);
                let x = (f64::from(place) + 0.5 * f64::from(level)) * 1.1 * SIDE;
                let low = Vec3::new(x + shift.x, shift.y, GAP + f64::from(level) * (SIDE + GAP));
                cubes.push(add_cube(&mut builder, low, SOFT, Vec3::zeros())?);
            }
        }
        let gravity = Vec3::new(angle.sin(), 0.0, -angle.cos()) * -GRAVITY.z;
        let options = contact(1e-3, SOFT, SIDE / f64::from(CELLS));
        let mut world = builder.build(gravity, options, lagging(0.01 * at.ladder))?;
        watch(&mut world, &cubes)?;
        let steps = (self.duration_s.value() / h).round() as u64;
        let (mut fewest, mut fastest) = (1.0_f64, 0.0_f64);
        for step in 0..steps {
            world.step(h, clock)?;
            // Once it has settled.
            if let Some(report) = world.friction_report
                && 2 * step >= steps
            {
                fewest = fewest.min(report.sticking as f64 / (report.pairs as f64).max(1.0));
                fastest = fastest.max(report.largest_slip);
            }
        }
        let outcome = world
            .outcome()
            .invariant("sticking pairs in the second half (part)", fewest)
            .invariant("fastest slip in the second half over εᵥ", fastest / at.ladder);
        world_pictured(outcome, &world, at)
    }
}
