//! Houses of cards.

use super::shots::Shots;
use super::{Body, Fate, G, GRAVITY, Judgement, add_body, contact, friction, mismatch, stepping};
use crate::experiment::contact::world::{Material, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::HalfSpace;
use mechanics_core::mesh::{BoxSplit, TetMesh, block};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Cards of 0.1 m × 0.06 m × 2 mm, E = 1 GPa, ρ = 1000 kg/m³, that lean against each other on the floor; the ladder is μ
/// over the least that holds them.
///
/// # Statics
/// A card of weight W at θ from the vertical carries a weight V at its upper end, where its neighbour pushes with H: about its foot
/// H cos θ = (½ W + V) sin θ, and the floor gives N = W + V. So it stands for
///
/// μ ≥ (½ W + V)/(W + V) tan θ, for two cards alone ½ tan θ.
///
/// `storeys` has two tents side by side, a card across and a third tent on it: then V = ¾ W, three cards borne by four.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CardHouse {
    /// θ, of a card from the vertical (degrees).
    lean_degrees: Positive,
    /// h (s).
    step_s: Positive,
    /// How many steps are made, unless it has fallen before.
    steps: Count,
}

const LENGTH: f64 = 0.1;
const WIDTH: f64 = 0.06;
const THICKNESS: f64 = 2e-3;
const CARD: Material = Material { young: 1e9, poisson: 0.3, density: 1000.0 };
const ACTIVATION: f64 = 2e-4;
const GAP: f64 = 1e-4;
const STICK_VELOCITY: f64 = 1e-4;
/// What has sunk so far (m) has fallen.
const FALLEN: f64 = 0.02;
/// What has moved less (m) stands.
const STANDING: f64 = 2e-3;

/// A card: `place` says where a point is from its place along the card, in 0..1, and across its thickness, in −½..½.
fn card(place: impl Fn(f64, f64) -> [f64; 2]) -> Result<TetMesh, ExperimentError> {
    let low = Vec3::new(0.0, -0.5 * WIDTH, -0.5);
    let high = Vec3::new(1.0, 0.5 * WIDTH, 0.5);
    let mut mesh = block(&low, &high, [4, 2, 1], BoxSplit::Six).map_err(ExperimentError::stopped)?;
    mesh.map_points(|p| {
        let [x, z] = place(p.x, p.z);
        Vec3::new(x, p.y, z)
    })
    .map_err(ExperimentError::stopped)?;
    mesh.orient();
    Ok(mesh)
}

/// The two cards of a tent whose feet are at this height; their ends are cut level with the floor and upright where they meet.
fn tent(lean: f64, x: f64, z: f64) -> Result<[TetMesh; 2], ExperimentError> {
    let (s, c) = lean.sin_cos();
    let leaning = |side: f64| {
        card(move |along, across| {
            let foot = [-LENGTH * s + across * THICKNESS / c, 0.0];
            let head = [-0.5 * GAP, LENGTH * c - across * THICKNESS / s];
            let at = [0, 1].map(|i| foot[i] * (1.0 - along) + head[i] * along);
            [x + side * at[0], z + at[1]]
        })
    };
    Ok([leaning(1.0)?, leaning(-1.0)?])
}

/// The highest point of a mesh.
fn top(mesh: &TetMesh) -> f64 {
    mesh.points().iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max)
}

/// The cards of a house; the last is at its top.
fn house(method: &str, lean: f64) -> Result<Vec<TetMesh>, ExperimentError> {
    if method == "two-cards" {
        return Ok(tent(lean, 0.0, GAP)?.into());
    }
    let half = LENGTH * lean.sin() + THICKNESS;
    let mut cards: Vec<TetMesh> = tent(lean, -half, GAP)?.into();
    cards.extend(tent(lean, half, GAP)?);
    let floor = top(&cards[0]) + GAP;
    let reach = half + 4.0 * THICKNESS;
    cards.push(card(|along, across| [reach * (2.0 * along - 1.0), floor + (0.5 + across) * THICKNESS])?);
    cards.extend(tent(lean, 0.0, floor + THICKNESS + GAP)?);
    Ok(cards)
}

impl Experiment for CardHouse {
    fn methods(&self) -> &'static [&'static str] {
        &["two-cards", "storeys"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let lean = self.lean_degrees.value().to_radians();
        let borne = if at.method == "two-cards" { 0.0 } else { 0.75 };
        let least = (0.5 + borne) / (1.0 + borne) * lean.tan();
        let mu = at.ladder * least;
        let mut builder = WorldBuilder::default();
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: 0.0 });
        let cards = house(at.method, lean)?;
        let bodies: Vec<Body> =
            cards.iter().map(|mesh| add_body(&mut builder, mesh, CARD)).collect::<Result<_, _>>()?;
        let weight = CARD.density * LENGTH * WIDTH * THICKNESS * G;
        // A card stands on a row of six points.
        let load = weight * (1.0 + borne) / 6.0;
        let mut world = builder.with_friction(friction(mu, STICK_VELOCITY)?).build(
            GRAVITY,
            contact(ACTIVATION, load),
            stepping(1e-4),
        )?;
        let mut shots = Shots::new(at, [0.35, -1.0, 0.3], bodies.iter().map(|body| &body.skin[..]));
        let judgement = Judgement { keystone: &bodies[bodies.len() - 1], fallen: FALLEN, standing: STANDING };
        let steps = (self.steps.value(), self.step_s.value());
        let Fate { sunk, largest, stands } = judgement.watch(&mut world, steps, clock, &mut shots)?;
        let outcome = world
            .outcome()
            .error("largest displacement", largest)
            .invariant("verdict against statics", mismatch(at.ladder > 1.0, stands))
            .invariant("sunk (m)", sunk)
            .invariant("least μ by statics", least);
        Ok(shots.add_to(outcome))
    }
}
