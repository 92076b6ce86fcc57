//! An elastic bar that swings about a line of held points, against the pendulum in one angle.

use super::swing::{METHODS, Swing, angles, exact_angles};
use crate::experiment::bodies::schemes::{Mover, Scheme};
use crate::experiment::bodies::solid::{Shape, Solid};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::picture::{Camera, ColourMap, Field, FieldValues, Lens, Scene3, Size, render};
use crate::scene::quantity::Positive;
use lagrangian::element::{DeadLoad, Mass, MassDistribution};
use lagrangian::stepper::{Stepper, StepperOptions};
use lagrangian::systems::Pendulum;
use mechanics_core::law::{Lame, Linear, StVenantKirchhoff};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::point_map::PointMap;
use mechanics_core::state::{State, StateHash};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A bar of 1 m × H × H, 1000 kg/m³, ν = 0, hangs from a line of points in the middle of its upper end and swings from rest for the time that the rigid bar takes to and fro.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PendulumBar {
    /// H (m).
    height_m: Positive,
    /// Where it starts, from below (rad).
    start_rad: Positive,
    /// What the ladder is.
    ladder: Ladder,
}

/// What the ladder is.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum Ladder {
    /// 1/E (1/Pa), with a step.
    Softness {
        /// By the time of a swing to and fro.
        step: Positive,
    },
    /// The step by the time of a swing to and fro, with a modulus.
    Step {
        /// E (Pa).
        young_modulus_pa: Positive,
    },
}

const DENSITY: f64 = 1000.0;
const GRAVITY: f64 = 9.81;
const LENGTH: f64 = 1.0;
/// Newton's method stops at this change \[m/s\].
const TOLERANCE: f64 = 1e-9;
const SIZE: Size = Size { width: 800, height: 500 };
/// How often the bar is drawn on half of its way.
const DRAWN: u64 = 8;

/// By what a method moves the bar.
fn shape(method: &str) -> Option<(Shape, &str)> {
    if let Some(scheme) = method.strip_prefix("ten-node elements, ") {
        return Some((Shape::TenNode, scheme));
    }
    method.strip_prefix("linear elements, ").map(|scheme| (Shape::Linear, scheme))
}

/// The bar and what it is as a pendulum.
struct Bar {
    solid: Solid,
    mass: Mass,
    held: Vec<(u32, Vec3)>,
    swing: Swing,
    /// Displacements K⁻¹ fᵢ at rest \[m\].
    bent: [Vec<Vec3>; 3],
}

/// What came of a swing.
struct Swung {
    /// After each step \[rad\].
    angles: Vec<f64>,
    /// Where the points were, now and then on the way down and up \[m\].
    seen: Vec<Vec<Vec3>>,
    outcome: Outcome,
}

/// x turned by `angle` from below, about y.
fn turned(x: &Vec3, angle: f64) -> Vec3 {
    let (sin, cos) = angle.sin_cos();
    Vec3::new(cos * x.x - sin * x.z, x.y, sin * x.x + cos * x.z)
}

/// X across the axis, and how it moves when it turns.
fn arms(points: &[Vec3]) -> (Vec<Vec3>, Vec<Vec3>) {
    points.iter().map(|x| (Vec3::new(x.x, 0.0, x.z), Vec3::new(-x.z, 0.0, x.x))).unzip()
}

fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

impl PendulumBar {
    fn bar(&self, shape: Shape, young: f64) -> Result<Bar, ExperimentError> {
        let height = self.height_m.value();
        // Equal distances of nodes; there must be nodes in the middle.
        let across = if shape == Shape::Linear { 2 } else { 1 };
        let along = (f64::from(across) * LENGTH / height).round() as u32;
        let half = 0.5 * height;
        let (low, high) = (Vec3::new(-half, -half, -LENGTH), Vec3::new(half, half, 0.0));
        let mesh =
            block(&low, &high, [across, across, along], BoxSplit::Six).map_err(ExperimentError::stopped)?;
        let lame = Lame::from_young_poisson(young, 0.0).map_err(ExperimentError::stopped)?;
        let solid = Solid::new(StVenantKirchhoff::new(lame), &mesh, shape)?;
        // Exact for turns, which are linear in X.
        let mass = solid.mass(DENSITY, MassDistribution::Consistent)?;
        let held = solid.held(|x| x.x.abs() < 1e-9 && x.z.abs() < 1e-9);
        let (arm, turn) = arms(&solid.points);
        let uniform = |way: Vec3| mass.momenta(&vec![way * GRAVITY; solid.points.len()]);
        let swinging = mass.momenta(&turn);
        let inertia = dot(&swinging, &turn);
        let moment = -dot(&uniform(Vec3::z()), &arm);
        let forces = [uniform(-Vec3::z()), uniform(-Vec3::x()), mass.momenta(&arm)].map(|mut force| {
            let part = dot(&force, &turn) / inertia;
            force.iter_mut().zip(&swinging).for_each(|(force, turning)| *force -= turning * part);
            force
        });
        let mut small = Solid::new(Linear::new(lame), &mesh, shape)?;
        let softest = 15.4 * (young * height * height / (12.0 * DENSITY)).sqrt() / (LENGTH * LENGTH);
        let mut given = |force: &[Vec3]| follow(&mut small, &mass, &held, force, 1e3 / softest);
        let bent = [given(&forces[0])?, given(&forces[1])?, given(&forces[2])?];
        let compliance = std::array::from_fn(|i| std::array::from_fn(|j| dot(&forces[i], &bent[j])));
        Ok(Bar { solid, mass, held, swing: Swing { inertia, moment, compliance }, bent })
    }

    /// E (Pa) and steps.
    fn rung(&self, ladder: f64) -> (f64, u64) {
        let (young, step) = match self.ladder {
            Ladder::Softness { step } => (1.0 / ladder, step.value()),
            Ladder::Step { young_modulus_pa } => (young_modulus_pa.value(), ladder),
        };
        (young, (1.0 / step).round() as u64)
    }

    /// fᵀK⁻¹f of the weight across a bar that hangs level, by Timoshenko's beam (shear factor 5/6): the moment is −m g s (1 − s)²/4, as in a chimney that falls.
    fn bending_of_beam(&self, young: f64) -> f64 {
        let height = self.height_m.value();
        let weight = DENSITY * height * height * GRAVITY;
        let bending = weight * weight * LENGTH.powi(5) / (1680.0 * young * height.powi(4) / 12.0);
        let shear = weight * weight * LENGTH.powi(3) / (120.0 * 5.0 / 6.0 * 0.5 * young * height * height);
        bending + shear
    }
}

/// K⁻¹ `force` of a linear body, without the turn that is free: (K + M/h²)⁻¹, one step of backward Euler, with a long h.
fn follow(
    solid: &mut Solid,
    mass: &Mass,
    held: &[(u32, Vec3)],
    force: &[Vec3],
    h: f64,
) -> Result<Vec<Vec3>, ExperimentError> {
    let load = DeadLoad::new("force", (0..).zip(force.iter().copied()).collect());
    let mut load = load.map_err(ExperimentError::stopped)?;
    let map = PointMap::with_fixed(solid.points.len(), held).map_err(ExperimentError::stopped)?;
    let newton = NewtonOptions { tolerance: 1e-12 / h, ..NewtonOptions::default() };
    let options = StepperOptions { newton, ..StepperOptions::default() };
    let mut stepper = Stepper::new(mass.clone(), map, options);
    let mut state = State::at_rest(solid.points.clone());
    stepper
        .step(&mut state, &mut [solid.elastic.as_mut(), &mut load], h)
        .map_err(ExperimentError::stopped)?;
    Ok(state.position.iter().zip(&solid.points).map(|(x, rest)| x - rest).collect())
}

impl Bar {
    /// Where the points are with the mean axes at `angle`, at rest: bent as their weight bends them there.
    fn start(&self, angle: f64) -> Vec<Vec3> {
        let (sin, cos) = angle.sin_cos();
        let rest = self.solid.points.iter().enumerate();
        rest.map(|(i, x)| turned(&(x + self.bent[0][i] * cos + self.bent[1][i] * sin), angle)).collect()
    }

    /// The angle of the mean axes.
    fn angle(&self, x: &[Vec3]) -> f64 {
        let (arm, turn) = arms(&self.solid.points);
        let momenta = self.mass.momenta(x);
        dot(&turn, &momenta).atan2(dot(&arm, &momenta))
    }

    /// Moves the bar by `steps` of `h` (s): its angles, and what it looked like on its way down and up.
    fn move_by(
        mut self,
        scheme: &str,
        (start, h, steps): (f64, f64, u64),
        clock: &mut Clock,
    ) -> Result<Swung, ExperimentError> {
        let map = PointMap::with_fixed(self.solid.points.len(), &self.held);
        let map = map.map_err(ExperimentError::stopped)?;
        let weight = DeadLoad::gravity(&self.mass, &(Vec3::z() * -GRAVITY));
        let mut weight = weight.map_err(ExperimentError::stopped)?;
        let mut mover = Mover::new(Scheme::named(scheme)?, self.mass.clone(), map, TOLERANCE)?;
        let mut state = State::at_rest(self.start(start));
        let (mut found, mut seen) = (vec![self.angle(&state.position)], vec![state.position.clone()]);
        let mut smallest = f64::INFINITY;
        for n in 1..=steps {
            let elastic = self.solid.elastic.as_mut();
            clock.time(|| mover.step(&mut state, &mut [elastic, &mut weight], h))?;
            found.push(self.angle(&state.position));
            if 2 * n <= steps && (n * 2 * DRAWN) % steps < 2 * DRAWN {
                seen.push(state.position.clone());
                smallest = smallest.min(self.solid.smallest_volume_ratio(&state.position));
            }
        }
        let outcome = Outcome::default().invariant("smallest volume ratio", smallest);
        Ok(Swung { angles: found, seen, outcome: mover.counted(outcome, &state, clock) })
    }
}

/// The largest difference.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

impl Experiment for PendulumBar {
    fn methods(&self) -> &'static [&'static str] {
        &[
            "linear elements, backward-euler",
            "linear elements, bdf2",
            "linear elements, newmark",
            "linear elements, implicit-midpoint",
            "ten-node elements, bdf2",
            "ten-node elements, newmark",
            "one angle, midpoint",
            "one angle, rk4",
            "one angle, gauss-legendre-4",
        ]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (young, steps) = self.rung(at.ladder);
        let elements = shape(at.method);
        let bar = self.bar(elements.map_or(Shape::TenNode, |(shape, _)| shape), young)?;
        let (swing, start) = (bar.swing, self.start_rad.value());
        let rigid = Pendulum::new(swing.inertia, 1.0, swing.moment / swing.inertia);
        let period = rigid.map_err(ExperimentError::stopped)?.swing_period(start);
        let h = period / steps as f64;
        let exact = |swing: Swing| exact_angles(swing, start, h, steps).map_err(ExperimentError::stopped);
        let (stiff, soft) = (exact(swing.rigid())?, exact(swing)?);
        // After a quarter of the period it is below, and fastest: there an error of the period is seen in first order.
        let quarter =
            exact_angles(swing.rigid(), start, 0.25 * period, 1).map_err(ExperimentError::stopped)?;
        let bending = swing.compliance[1][1] / self.bending_of_beam(young);
        let (outline, rest) = (bar.solid.skin(), bar.solid.points.clone());
        let Swung { angles: found, seen, mut outcome } = match elements {
            Some((_, scheme)) => bar.move_by(scheme, (start, h, steps), clock)?,
            None => {
                let mut outcome = Outcome::default();
                let method = METHODS.into_iter().find(|name| *name == at.method).unwrap_or(METHODS[0]);
                let found = clock.time(|| angles(swing, method, (start, h, steps), &mut outcome))?;
                let drawn = (0..=DRAWN).map(|k| (k * steps / (2 * DRAWN)) as usize);
                let seen = drawn.map(|n| rest.iter().map(|x| turned(x, found[n])).collect()).collect();
                let mut hash = StateHash::new();
                hash.add("angles", &found);
                Swung { angles: found, seen, outcome: outcome.state(hash.value()) }
            }
        };
        outcome.simulated_seconds = Some(period);
        let outcome = outcome
            .error("angle", apart(&found, &soft))
            .error("angle of the rigid bar", apart(&found, &stiff))
            .error("bending of a beam", (bending - 1.0).abs())
            .error("closed form of the period", quarter[1].abs())
            .invariant("elastic effect (rad)", apart(&soft, &stiff))
            .invariant("compliance by a beam's", bending);
        drawn(outcome, at, &seen, &outline)
    }
}

/// `outcome` with a picture of all places in one, if pictures are wanted.
fn drawn(
    outcome: Outcome,
    at: &Point<'_>,
    seen: &[Vec<Vec3>],
    outline: &[[u32; 3]],
) -> Result<Outcome, ExperimentError> {
    let mut scene = Scene3 { caption: format!("{}, half a swing", at.method), ..Scene3::default() };
    let mut order = Vec::new();
    for (number, x) in seen.iter().enumerate() {
        let first = scene.positions.len();
        scene.positions.extend(x.iter().map(|x| <[f64; 3]>::from(*x)));
        order.resize(scene.positions.len(), number as f64 / (2 * DRAWN) as f64);
        scene.triangles.extend(outline.iter().map(|triangle| triangle.map(|i| first + i as usize)));
    }
    scene.field = Some(Field {
        name: "time by that of a swing".to_owned(),
        unit: "1".to_owned(),
        values: FieldValues::Positions(order),
        range: None,
        map: ColourMap::default(),
    });
    let camera = Camera { towards: [0.0, -1.0, 0.0], lens: Lens::Orthographic, ..Camera::default() };
    outcome.pictured(at, &at.title(), || Ok(render(&scene, &camera, SIZE)))
}
