//! A bunny that is pushed into sand and drawn through it.

use super::super::cloud::Cloud;
use super::super::method::Method;
use super::super::solver::Solver;
use super::obstacle::{Section, figure, inside, tray, volume_below};
use super::{Balance, GRAVITY, Space, add_pressed, space};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Film, Image};
use mechanics_core::law::Lame;
use mechanics_core::mesh::TriMesh;
use mechanics_core::tensor::Vec3;
use mpm_constitutive::plastic::{DruckerPrager, FrictionAngle};
use mpm_core::{Collider, RigidMotion, SolidMesh, Surface};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::PathBuf;
use std::time::Duration;

/// Dry sand at rest in a tray; a mesh with y upward, 0.2 m high, is pushed 0.1 m deep and then drawn 0.05 m along, at 1 m/s. The ladder is Δx (m).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BunnyInSand {
    /// A closed mesh in a file, relative to the scene's folder.
    mesh: PathBuf,
}

const DENSITY: f64 = 1600.0;
const YOUNG: f64 = 2e6;
const POISSON: f64 = 0.3;
const FRICTION_ANGLE: f64 = 0.6;
const FRICTION: f64 = 0.3;
/// Of the sand \[m\].
const HALF: f64 = 0.24;
const DEPTH: f64 = 0.18;
/// Of the bunny \[m\].
const HEIGHT: f64 = 0.2;
const CLEARANCE: f64 = 0.005;
const SPEED: f64 = 1.0;
/// Down and along \[m\].
const WAYS: [f64; 2] = [0.1 + CLEARANCE, 0.05];
/// Looks at what is inside of the bunny.
const LOOKS: usize = 4;
/// Steps at the end that are timed with the bunny and without.
const TIMED: usize = 8;
const FRAMES: usize = 20;

/// A run.
struct Bed {
    space: Space,
    /// Above its place.
    bunny: TriMesh,
    collider: usize,
    gap: f64,
    /// V₀ of the particles \[m³\].
    volumes: Vec<f64>,
}

impl Bed {
    /// Sand at rest in its weight, and a bunny above it that is `away` from its place.
    fn start(mesh: &TriMesh, method: Method, spacing: f64, away: f64) -> Result<Self, ExperimentError> {
        let mut space = space(method, spacing)?;
        let gap = spacing / method.along as f64;
        let counts = [2.0 * HALF, 2.0 * HALF, DEPTH].map(|side| (side / gap).round() as usize);
        let cloud = Cloud::cuboid([-HALF, -HALF, 0.0], [HALF, HALF, DEPTH], counts);
        let lame = Lame::from_young_poisson(YOUNG, POISSON).map_err(ExperimentError::stopped)?;
        // Hencky's law where nothing moves sideways: (λ + 2μ) ln F₃₃ = −ρ g times the depth.
        let stretch =
            |x: &[f64; 3]| (-DENSITY * GRAVITY * (DEPTH - x[2]) / (lame.lambda() + 2.0 * lame.mu())).exp();
        let angle = FrictionAngle::constant(FRICTION_ANGLE).map_err(ExperimentError::stopped)?;
        let sand = DruckerPrager::new(lame, angle, 0.0).map_err(ExperimentError::stopped)?;
        let volumes = add_pressed(&mut space, (sand, DENSITY), &cloud, stretch)?;
        let tray = SolidMesh::new(&tray([HALF; 2], 2.0 * DEPTH)?).map_err(ExperimentError::stopped)?;
        space
            .add_collider(Collider::at_rest(tray, Surface::Friction(FRICTION)))
            .map_err(ExperimentError::stopped)?;
        let mut bunny = mesh.clone();
        bunny
            .translate(&Vec3::new(away - 0.5 * WAYS[1], 0.0, DEPTH + CLEARANCE + 0.5 * HEIGHT))
            .map_err(ExperimentError::stopped)?;
        let solid = SolidMesh::new(&bunny).map_err(ExperimentError::stopped)?;
        let motion = RigidMotion::translation([0.0, 0.0, -SPEED]);
        let collider = space
            .add_collider(Collider::moving(solid, Surface::Friction(FRICTION), motion))
            .map_err(ExperimentError::stopped)?;
        Ok(Self { space, bunny, collider, gap, volumes })
    }

    /// The bunny where it is, by its motion.
    fn bunny(&self) -> Result<TriMesh, ExperimentError> {
        let time = self.space.time();
        let down = (SPEED * time).min(WAYS[0]);
        let along = (SPEED * time - WAYS[0]).max(0.0);
        let mut mesh = self.bunny.clone();
        mesh.translate(&Vec3::new(along, 0.0, -down)).map_err(ExperimentError::stopped)?;
        Ok(mesh)
    }

    /// One stable step that does not go beyond `until`.
    fn step(&mut self, until: f64, clock: &mut Clock) -> Result<(), ExperimentError> {
        let step = self.space.stable_step().min(until - self.space.time());
        clock.time(|| self.space.step(step)).map_err(ExperimentError::stopped)?;
        Ok(())
    }

    /// The sand above its old level \[m³\]: each particle is a piece of `gap` along z.
    fn raised(&self) -> f64 {
        let above = |x: &[f64; 3]| ((x[2] - DEPTH) / self.gap + 0.5).clamp(0.0, 1.0);
        self.gap.powi(3) * self.space.positions(0).iter().map(above).sum::<f64>()
    }

    /// The volume by which the sand is smaller than it was \[m³\].
    fn compressed(&self) -> f64 {
        let states = self.space.states(0);
        let now = self.volumes.iter().zip(&states).map(|(v, state)| v * state.volume_ratio).sum::<f64>();
        4.0 * HALF * HALF * DEPTH - now
    }

    /// How many particles are inside of the bunny, and how deep \[m\].
    fn inside(&self) -> Result<(u64, f64), ExperimentError> {
        Ok(inside(&self.bunny()?, self.space.positions(0).into_iter().map(Vec3::from)))
    }

    fn picture(&self, size: (usize, usize), method: &str) -> Result<Image, ExperimentError> {
        let (positions, velocities) = (self.space.positions(0), self.space.velocities(0));
        let values: Vec<f64> = velocities.iter().map(|v| Vec3::from(*v).norm()).collect();
        let section = Section {
            positions: &positions,
            values: &values,
            meshes: &[self.bunny()?],
            front: 0.0,
            radius: 0.5 * self.gap,
            field: ("speed", "m/s"),
            range: Some((0.0, SPEED)),
            towards: [0.25, -1.0, 0.35],
            frame: ([-HALF, 0.0, 0.0], [HALF, HALF, DEPTH + HEIGHT]),
            label: format!("{method}, t = {:.3} s", self.space.time()),
        };
        Ok(section.drawn(size))
    }
}

impl Experiment for BunnyInSand {
    fn methods(&self) -> &'static [&'static str] {
        Method::names()
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (method, spacing) = (Method::in_double(at.method, "sand")?, at.ladder);
        let mesh = figure(&at.folder.join(&self.mesh), HEIGHT)?;
        let mut bed = Bed::start(&mesh, method, spacing, 0.0)?;
        let mut balance = Balance::start(&bed.space);
        let times = [WAYS[0] / SPEED, (WAYS[0] + WAYS[1]) / SPEED];
        let (mut count, mut deepest, mut volumes) = (0, 0.0_f64, [0.0; 4]);
        let mut film = Film::new(4.0 / FRAMES as f64);
        for part in 0..LOOKS {
            let until = times[0] + (times[1] - times[0]) * part as f64 / (LOOKS - 1) as f64;
            while bed.space.time() < until {
                bed.step(until, clock)?;
                if bed.space.steps().is_multiple_of(16) {
                    balance.look(&bed.space, GRAVITY);
                }
                let frame = bed.space.time() / times[1] * FRAMES as f64;
                if at.frames.is_some() && frame >= film.frames().len() as f64 {
                    film.push(bed.picture((560, 350), at.method)?).map_err(ExperimentError::stopped)?;
                }
            }
            let (found, depth) = bed.inside()?;
            (count, deepest) = (count.max(found), deepest.max(depth));
            if part == 0 {
                let left = found as f64 * bed.gap.powi(3);
                volumes = [volume_below(&bed.bunny()?, DEPTH), bed.raised(), bed.compressed(), left];
                let along = RigidMotion::translation([SPEED, 0.0, 0.0]);
                bed.space.set_collider_motion(bed.collider, along).map_err(ExperimentError::stopped)?;
            }
        }
        balance.look(&bed.space, GRAVITY);
        let [submerged, raised, pressed, left] = volumes;
        let load = bed.space.collider_load(bed.collider).total.linear;
        let outcome = Outcome::default()
            .filmed(at, "cut through its middle, coloured by speed", &film)?
            .pictured(at, "at the end", || bed.picture((800, 500), at.method))?;
        time_collider(&mut bed, (&mesh, method, spacing), clock)?;
        let outcome = outcome
            .error("deepest particle in the bunny", deepest)
            .error("submerged volume that is nowhere", (1.0 - (raised + pressed + left) / submerged).abs())
            .error("volume of sand left in the bunny", left / submerged)
            .count("particles in the bunny", count)
            .invariant("raised by the submerged volume", raised / submerged)
            .invariant("compressed by the submerged volume", pressed / submerged)
            .invariant("deepest particle in the bunny (Δx)", deepest / spacing)
            .invariant("momentum that no force gave", balance.worst)
            .invariant("change of mass", balance.worst_mass)
            .invariant("impulse against the push", load.z)
            .invariant("impulse against the drag", -load.x);
        Ok(Solver::Double(bed.space).counted(outcome))
    }
}

/// Adds what the bunny costs: steps of the last state with it, and of the same with it far away.
fn time_collider(
    bed: &mut Bed,
    (mesh, method, spacing): (&TriMesh, Method, f64),
    clock: &mut Clock,
) -> Result<(), ExperimentError> {
    let mut without = Bed::start(mesh, method, spacing, 100.0)?;
    without.space.resume(bed.space.checkpoint()).map_err(ExperimentError::stopped)?;
    let [mut near, mut far, mut rest] = [0.0; 3];
    let checkpoint = bed.space.checkpoint();
    for _ in 0..TIMED {
        let step = 0.5 * bed.space.stable_step();
        bed.space.step_unchecked(step).map_err(ExperimentError::stopped)?;
        without.space.step_unchecked(step).map_err(ExperimentError::stopped)?;
        near += bed.space.stage_times().nodes;
        let stages = without.space.stage_times();
        far += stages.nodes;
        rest += stages.sort + stages.scatter + stages.nodes + stages.gather;
    }
    bed.space.resume(checkpoint).map_err(ExperimentError::stopped)?;
    let seconds = |x: f64| Duration::from_secs_f64(x.max(0.0));
    clock.add_term("8 steps: the bunny", seconds(near - far));
    clock.add_term("8 steps: all the rest", seconds(rest));
    Ok(())
}
