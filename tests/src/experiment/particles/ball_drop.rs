//! An elastic ball that bounces off a floor, by finite elements with barrier contact and by particles.

use super::method::Method;
use super::portrait::{Portrait, pictured};
use super::solver::{Elasticity, Matter, Solver};
use crate::experiment::contact::portrait::pictured as pictured_mesh;
use crate::experiment::contact::world::{Material, SolidLaw, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use ipc_contact::collision_mesh::{CollisionObject, HalfSpace};
use ipc_contact::contact::ContactOptions;
use ipc_contact::contact_set::Weighting;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::{StepperOptions, TimeScheme};
use mechanics_core::mesh::ball;
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use mpm_core::sampling::{Pattern, sample_shape};
use mpm_core::{Boundary, Samples, Shape, Surface, Totals};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// A neo-Hookean ball of radius R = 0.1 m, E = 1e5 Pa, ν = 0.3, 1000 kg/m³, hits a smooth floor; the ladder is the size of cells or elements by R.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BouncingBall {
    /// How fast (m/s).
    speed_m_s: Positive,
}

const RADIUS: f64 = 0.1;
const YOUNG: f64 = 1e5;
const POISSON: f64 = 0.3;
const DENSITY: f64 = 1000.0;
const ELEMENTS: &str = "linear elements, BDF2";
/// Of the time of contact, for elements of the size R; it goes with their size.
const STEPS: f64 = 8.0;
/// The force, in parts of Hertz's largest, between whose passages the time of contact is taken.
const LEVEL: f64 = 0.05;
/// Time of contact, largest indentation 1 and speed 1: 2 ∫₀¹ ds/√(1 − s^(5/2)).
const DURATION: f64 = 2.943_275_184;

static NAMES: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| std::iter::once(ELEMENTS).chain(Method::names().iter().copied()).collect());

/// Hertz's impact: K. L. Johnson, *Contact Mechanics*, 1985, section 11.4.
struct Impact {
    speed: f64,
    mass: f64,
    indentation: f64,
    force: f64,
    /// How long the force is above [`LEVEL`] of its maximum (s).
    duration: f64,
}

impl Impact {
    /// δ* = (15 m v²/(16 √R E*))^(2/5), F = 4/3 E* √R δ*^(3/2), t = 2.94 δ*/v.
    fn of(speed: f64) -> Self {
        let mass = 4.0 / 3.0 * PI * RADIUS.powi(3) * DENSITY;
        let modulus = YOUNG / (1.0 - POISSON * POISSON);
        let indentation = (15.0 * mass * speed * speed / (16.0 * RADIUS.sqrt() * modulus)).powf(0.4);
        let force = 4.0 / 3.0 * modulus * RADIUS.sqrt() * indentation.powf(1.5);
        // From the first touch to the level: the speed is √(1 − s^(5/2)) of the first one.
        let end = LEVEL.powf(2.0 / 3.0);
        let rise = (0..1000).map(|i| {
            let s = end * (f64::from(i) + 0.5) / 1000.0;
            end / 1000.0 / (1.0 - s.powf(2.5)).sqrt()
        });
        let duration = (DURATION - 2.0 * rise.sum::<f64>()) * indentation / speed;
        Self { speed, mass, indentation, force, duration }
    }

    /// Errors of an impact with these upward momenta at these times.
    fn judged(&self, outcome: Outcome, course: &[[f64; 2]]) -> Outcome {
        // Forces at the middles of steps.
        let force: Vec<[f64; 2]> = course
            .windows(2)
            .map(|pair| {
                let [[t0, p0], [t1, p1]] = [pair[0], pair[1]];
                [0.5 * (t0 + t1), (p1 - p0) / (t1 - t0)]
            })
            .collect();
        let level = LEVEL * self.force;
        let crossing = |pair: &[[f64; 2]]| {
            let [[t0, f0], [t1, f1]] = [pair[0], pair[1]];
            t0 + (t1 - t0) * (level - f0) / (f1 - f0)
        };
        let up = force.windows(2).find(|pair| pair[0][1] < level && pair[1][1] >= level);
        let down = force.windows(2).rev().find(|pair| pair[0][1] >= level && pair[1][1] < level);
        let time = up.zip(down).map_or(f64::NAN, |(up, down)| crossing(down) - crossing(up));
        let largest = force.iter().fold(0.0_f64, |most, f| most.max(f[1]));
        let end = course.last().map_or(f64::NAN, |last| last[1]) / (self.mass * self.speed);
        outcome
            .error("contact time", (time / self.duration - 1.0).abs())
            .error("restitution", (end - 1.0).abs())
            .error("largest force", (largest / self.force - 1.0).abs())
            .invariant("contact time by Hertz's", time / self.duration)
            .invariant("coefficient of restitution", end)
            .invariant("largest force by Hertz's", largest / self.force)
    }

    /// Until the ball has left \[s\], from a height of `gap`.
    fn end(&self, gap: f64) -> f64 {
        1.4 * self.duration + 2.0 * gap / self.speed
    }
}

impl BouncingBall {
    fn by_elements(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let impact = Impact::of(self.speed_m_s.value());
        let mesh = ball(RADIUS, (1.0 / at.ladder).round() as u32).map_err(ExperimentError::stopped)?;
        // The polyhedron is lighter than the ball.
        let density = impact.mass / mesh.volume();
        let activation = 0.02 * impact.indentation;
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier);
        let material = Material { young: YOUNG, poisson: POISSON, density };
        builder.add_solid(&mesh, material, -Vec3::z() * impact.speed)?;
        let lowest = mesh.points().iter().fold(0.0_f64, |low, x| low.min(x.z));
        // Some steps before it touches.
        let h = impact.duration / STEPS * at.ladder;
        let gap = 4.0 * impact.speed * h;
        builder.add_half_space(HalfSpace { normal: Vec3::z(), offset: lowest - activation - gap });
        let peak = 1.5 * impact.force / (PI * RADIUS * impact.indentation);
        let stiffness = Stiffness::fixed(Scale::Load(peak));
        let contact =
            ContactOptions { weighting: Weighting::Area, ..ContactOptions::new(activation, stiffness) };
        let newton = NewtonOptions { tolerance: 1e-6 * impact.speed, ..NewtonOptions::default() };
        let options = StepperOptions { newton, scheme: TimeScheme::Bdf2, ..StepperOptions::default() };
        let mut world = builder.build(Vec3::zeros(), contact, options)?;
        let momentum = |state: &[Vec3], world: &crate::experiment::contact::world::World| {
            world.stepper.mass().linear_momentum(state).z
        };
        let mut course = vec![[0.0, momentum(&world.state.velocity, &world)]];
        let mut flattest = (f64::INFINITY, world.state.position.clone());
        for _ in 0..(impact.end(gap) / h).ceil() as u64 {
            world.step(h, clock)?;
            course.push([world.state.time, momentum(&world.state.velocity, &world)]);
            let top = world.state.position.iter().fold(f64::NEG_INFINITY, |top, x| top.max(x.z));
            if top < flattest.0 {
                flattest = (top, world.state.position.clone());
            }
        }
        let outcome = impact.judged(world.outcome(), &course).count("points", mesh.points().len() as u64);
        let skin = CollisionObject::of_tets(&mesh, 0).map_err(ExperimentError::stopped)?.triangles;
        let sunk = flattest.1.iter().zip(mesh.points()).map(|(x, rest)| rest.z - x.z).collect();
        pictured_mesh(outcome, at, &flattest.1, &skin, ("sunk by", "m", sunk))
    }

    fn by_particles(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let method = Method::named(at.method)?;
        let impact = Impact::of(self.speed_m_s.value());
        let spacing = at.ladder * RADIUS;
        let gap = 2.0 * spacing;
        let shape = Shape::Ball { centre: [0.0, 0.0, RADIUS + gap], radius: RADIUS };
        let sampled = sample_shape(&shape, Pattern::regular(spacing, method.along as u32), 0)
            .map_err(ExperimentError::stopped)?;
        let velocities = vec![[0.0, 0.0, -impact.speed]; sampled.positions.len()];
        let matter = Matter::new(Elasticity::NeoHookean, (YOUNG, POISSON), DENSITY)?;
        let mut solver = Solver::new(method, spacing)?;
        let floor = Shape::HalfSpace { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
        solver.add_boundary(Boundary::at_rest(floor, Surface::Separating))?;
        let samples =
            Samples { positions: &sampled.positions, velocities: &velocities, volumes: &sampled.volumes };
        solver.add_body(&matter, samples)?;
        let energy = |totals: &Totals| totals.kinetic_energy + totals.affine_energy + totals.stored_energy;
        let mut totals = solver.totals(0);
        let start = energy(&totals);
        let mut course = vec![[0.0, totals.momentum.z]];
        let (mut growth, mut flattest) = (0.0_f64, (f64::INFINITY, Vec::new()));
        let end = impact.end(gap);
        while solver.time() < end {
            let step = solver.stable_step().min(end - solver.time());
            clock.time(|| solver.step(step)).map_err(ExperimentError::stopped)?;
            totals = solver.totals(0);
            growth = growth.max(energy(&totals) / start - 1.0);
            course.push([solver.time(), totals.momentum.z]);
            if at.frames.is_some() {
                let places = solver.positions(0);
                let top = places.iter().fold(f64::NEG_INFINITY, |top, x| top.max(x[2]));
                if top < flattest.0 {
                    flattest = (top, places);
                }
            }
        }
        let outcome = Outcome::default()
            .invariant("largest growth of energy", growth)
            .invariant("energy left", energy(&totals) / start);
        let outcome = solver.counted(impact.judged(outcome, &course));
        let (_, places) = flattest;
        pictured(outcome, at, "the ball at its flattest, cut through the middle", || {
            let (seen, values) = places
                .iter()
                .zip(&sampled.positions)
                .filter(|(_, rest)| rest[1] >= 0.0)
                .map(|(x, rest)| (*x, rest[2] - x[2]))
                .unzip();
            Portrait {
                positions: seen,
                values,
                radius: 0.3 * spacing,
                field: ("sunk by", "m"),
                label: at.method.to_owned(),
                ..Portrait::default()
            }
        })
    }
}

impl Experiment for BouncingBall {
    fn methods(&self) -> &'static [&'static str] {
        &NAMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        if at.method == ELEMENTS { self.by_elements(at, clock) } else { self.by_particles(at, clock) }
    }
}
