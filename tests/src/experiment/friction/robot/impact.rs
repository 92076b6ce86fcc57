//! An elastic ball that hits a plate: Hertz's impact, and what friction makes of a blow at an angle.

use super::{friction, mass_mean};
use crate::experiment::contact::particle::{SCHEMES, scheme};
use crate::experiment::contact::portrait::pictured;
use crate::experiment::contact::world::{Material, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, NonNegative, Positive};
use ipc_contact::collision_mesh::{CollisionObject, HalfSpace, SelfContact};
use ipc_contact::contact::ContactOptions;
use ipc_contact::contact_set::Weighting;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::{Lagging, StepperOptions};
use mechanics_core::mesh::{TetMesh, ball};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use nalgebra::Rotation3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// A steel ball of radius 10 mm (E = 200 GPa, ν = 0.3, 7800 kg/m³) hits a half-space. Its cells are finer at the lowest point, by a
/// Möbius transformation of the ball. Area-weighted contact. The ladder is the step (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BallImpact {
    /// Towards the plate (m/s).
    speed_m_s: Positive,
    /// Along the plate (m/s).
    tangential_speed_m_s: NonNegative,
    /// Without friction where it is zero.
    friction_coefficient: NonNegative,
    /// Parts into which an edge of the icosahedron is cut.
    frequency: Count,
    /// How far the centre of the mesh is moved up, in parts of the radius: cells at the lowest point are (1 − s)/(1 + s) times as
    /// large.
    focus: NonNegative,
    /// The distance at which contact begins, in parts of Hertz's largest indentation.
    activation: Positive,
}

const RADIUS: f64 = 0.01;
const STEEL: Material = Material { young: 2e11, poisson: 0.3, density: 7800.0 };
/// The force, in parts of Hertz's largest, between whose passages the time of contact is taken.
const LEVEL: f64 = 0.05;
/// Time of contact, largest indentation 1 and speed 1: 2 ∫₀¹ ds/√(1 − s^(5/2)).
const DURATION: f64 = 2.943_275_184;
/// Of its speed along the plate, that friction is smoothed below.
const STICK: f64 = 1e-4;

/// What Hertz's law says of the impact of a ball of mass m.
struct Hertz {
    indentation: f64,
    force: f64,
    /// Largest pressure (Pa).
    peak: f64,
    /// How long the force is above [`LEVEL`] of its maximum (s).
    duration: f64,
}

impl Hertz {
    /// K. L. Johnson, *Contact Mechanics*, 1985, section 11.4: δ* = (15 m v²/(16 √R E*))^(2/5), t = 2.94 δ*/v.
    fn new(mass: f64, speed: f64) -> Self {
        let modulus = STEEL.young / (1.0 - STEEL.poisson * STEEL.poisson);
        let indentation = (15.0 * mass * speed * speed / (16.0 * RADIUS.sqrt() * modulus)).powf(0.4);
        let force = 4.0 / 3.0 * modulus * RADIUS.sqrt() * indentation.powf(1.5);
        let peak = 1.5 * force / (PI * RADIUS * indentation);
        // From the first touch to the level: the speed is √(1 − s^(5/2)) of the first one.
        let end = LEVEL.powf(2.0 / 3.0);
        let parts = 1000;
        let rise = (0..parts).map(|i| {
            let s = end * (f64::from(i) + 0.5) / f64::from(parts);
            end / f64::from(parts) / (1.0 - s.powf(2.5)).sqrt()
        });
        let duration = (DURATION - 2.0 * rise.sum::<f64>()) * indentation / speed;
        Self { indentation, force, peak, duration }
    }
}

/// A ball with a vertex as its lowest point, about which cells are finer.
fn focused_ball(frequency: u32, focus: f64) -> Result<TetMesh, ExperimentError> {
    let mut mesh = ball(1.0, frequency).map_err(ExperimentError::stopped)?;
    let depth = |x: &Vec3| if x.norm() > 0.999 { x.z } else { 0.0 };
    let lowest = mesh.points().iter().min_by(|a, b| depth(a).total_cmp(&depth(b)));
    let lowest = *lowest.unwrap_or(&Vec3::z());
    let turn = Rotation3::rotation_between(&lowest, &-Vec3::z()).unwrap_or_else(Rotation3::identity);
    mesh.rotate(&turn).map_err(ExperimentError::stopped)?;
    let to = Vec3::z() * focus;
    // It maps the ball onto itself, with angles as they are: A. F. Beardon, The Geometry of Discrete Groups, 1983, section 3.4.
    let moebius = |x: &Vec3| {
        let away = x - to;
        let (square, own) = (focus * focus, x.norm_squared());
        (away * (1.0 - square) - to * away.norm_squared()) / (1.0 + own * square - 2.0 * x.dot(&to))
    };
    mesh.map_points(|x| moebius(x) * RADIUS).map_err(ExperimentError::stopped)?;
    Ok(mesh)
}

/// The lower part of the surface: what touches.
fn sole(mesh: &TetMesh) -> Result<CollisionObject, ExperimentError> {
    let mut object = CollisionObject::of_tets(mesh, 0).map_err(ExperimentError::stopped)?;
    object.triangles.retain(|t| t.iter().all(|&p| mesh.points()[p as usize].z < -0.8 * RADIUS));
    Ok(object.with_self_contact(SelfContact::Excluded))
}

/// What is seen of the impact, step by step.
#[derive(Default)]
struct Record {
    force: Vec<f64>,
    energy: Vec<f64>,
}

impl Record {
    fn add(&mut self, world: &World) {
        self.force.push(world.contact.forces(&world.state.position).iter().map(|f| f.z).sum());
        let (others, contact) = world.potential_energy();
        self.energy.push(world.stepper.mass().kinetic_energy(&world.state.velocity) + others + contact);
    }

    /// How long the force was above `level` (N), in steps.
    fn duration(&self, level: f64) -> f64 {
        let force = &self.force;
        let crossing = |i: usize| i as f64 - 1.0 + (level - force[i - 1]) / (force[i] - force[i - 1]);
        let up = (1..force.len()).find(|&i| force[i - 1] < level && force[i] >= level);
        let down = (1..force.len()).rev().find(|&i| force[i - 1] >= level && force[i] < level);
        up.zip(down).map_or(f64::NAN, |(up, down)| crossing(down) - crossing(up))
    }
}

impl BallImpact {
    fn world(&self, mesh: &TetMesh, method: &str) -> Result<(World, Hertz), ExperimentError> {
        let (speed, along) = (self.speed_m_s.value(), self.tangential_speed_m_s.value());
        let hertz = Hertz::new(STEEL.density * mesh.volume(), speed);
        let activation = self.activation.value() * hertz.indentation;
        let mut builder = WorldBuilder::default();
        if self.friction_coefficient.value() > 0.0 {
            builder = builder.with_friction(friction(self.friction_coefficient.value(), STICK * along)?);
        }
        builder.add_solid_that_touches(mesh, STEEL, Vec3::new(along, 0.0, -speed), sole(mesh)?)?;
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: -RADIUS - activation });
        let stiffness = Stiffness::fixed(Scale::Load(hertz.peak));
        let contact =
            ContactOptions { weighting: Weighting::Area, ..ContactOptions::new(activation, stiffness) };
        let newton = NewtonOptions { tolerance: 1e-7 * speed, ..NewtonOptions::default() };
        let options = StepperOptions {
            newton,
            scheme: scheme(method),
            lagging: Lagging::Until(30),
            ..StepperOptions::default()
        };
        Ok((builder.build(Vec3::zeros(), contact, options)?, hertz))
    }
}

impl Experiment for BallImpact {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mesh = focused_ball(self.frequency.value() as u32, self.focus.value())?;
        let (mut world, hertz) = self.world(&mesh, at.method)?;
        let (speed, along, h) = (self.speed_m_s.value(), self.tangential_speed_m_s.value(), at.ladder);
        let points = 0..mesh.points().len() as u32;
        let activation = self.activation.value() * hertz.indentation;
        let steps = ((1.35 * hertz.duration + activation / speed) / h).ceil() as u64;
        let mut record = Record::default();
        record.add(&world);
        let (mut middle, mut highest) = (world.state.position.clone(), Vec::new());
        for _ in 0..steps {
            world.step(h, clock)?;
            record.add(&world);
            if record.force.iter().all(|f| *f <= record.force[record.force.len() - 1]) {
                middle.clone_from(&world.state.position);
                highest = world.contact.forces(&middle).iter().map(|f| f.z).collect();
            }
        }
        let velocity = mass_mean(&world, points, &world.state.velocity);
        let largest = record.force.iter().copied().fold(0.0, f64::max);
        let kept = record.energy[record.energy.len() - 1] / record.energy[0];
        let gained = record.energy.iter().map(|e| e / record.energy[0] - 1.0).fold(0.0, f64::max);
        let time = record.duration(LEVEL * hertz.force) * h;
        let mut outcome = world
            .outcome()
            .error("contact time", (time / hertz.duration - 1.0).abs())
            .error("restitution", (velocity.z / speed - 1.0).abs())
            .error("largest force", (largest / hertz.force - 1.0).abs())
            .error("energy", (kept - 1.0).abs())
            .invariant("contact time over Hertz's", time / hertz.duration)
            .invariant("coefficient of restitution", velocity.z / speed)
            .invariant("largest force over Hertz's", largest / hertz.force)
            .invariant("energy gained", gained)
            .invariant("force of contact at the end (N)", record.force[record.force.len() - 1]);
        if self.friction_coefficient.value() > 0.0 {
            let (lost, pushed) = (along - velocity.x, velocity.z + speed);
            let impulse = lost / (self.friction_coefficient.value() * pushed);
            outcome = outcome.error("impulse of friction", (impulse - 1.0).abs());
        }
        let areas = |i: usize| world.contact.mesh().point_area(i as u32);
        let pressures = highest.iter().enumerate().map(|(i, f)| if *f > 0.0 { f / areas(i) } else { 0.0 });
        let skin = CollisionObject::of_tets(&mesh, 0).map_err(ExperimentError::stopped)?.triangles;
        // Seen from below.
        let seen: Vec<Vec3> = middle.iter().map(|x| Vec3::new(x.x, -x.y, -x.z)).collect();
        pictured(outcome, at, &seen, &skin, ("contact pressure", "Pa", pressures.collect()))
    }
}
