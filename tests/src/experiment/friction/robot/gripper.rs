//! Two fingers lift a soft block by friction, or do not.

use super::hand::{Grasp, Hand};
use super::{friction, mass_mean};
use crate::experiment::contact::portrait::pictured;
use crate::experiment::contact::world::{Material, SolidLaw, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::{Lagging, StepperOptions};
use mechanics_core::mesh::{BoxSplit, block};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::Range;

/// A soft cube of 40 mm (E = 20 kPa, ν = 0, 1000 kg/m³) on a pedestal between two plates, which press it together, are lifted by
/// 30 mm and stay there for a second. The ladder is μ in parts of m g/(2N), where N is what the plates press with in a run without friction.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Gripper {
    /// The step (s).
    step_s: Positive,
    /// Cells along an edge of the cube.
    cells: Count,
    /// How far each plate presses (m).
    squeeze_m: Positive,
    /// The distance at which contact begins (m).
    activation_distance_m: Positive,
    /// εᵥ (m/s).
    stick_velocity_m_s: Positive,
}

const SIDE: f64 = 0.04;
const LIFT: f64 = 0.03;
const GRAVITY: f64 = 9.81;
const GEL: Material = Material { young: 2e4, poisson: 0.0, density: 1000.0 };
/// When the plates have closed, when they begin to lift, when they have lifted, and the end of the hold (s).
const CLOSED: f64 = 0.2;
const LIFTS: f64 = 0.4;
const LIFTED: f64 = 0.8;
const END: f64 = 1.8;
/// For how long speeds and forces are averaged: at the end of the hold, or of the first part of the lift (s).
const WINDOW: f64 = 0.1;

struct Grip {
    world: World,
    cube: Range<u32>,
    hand: Hand,
}

/// What the plates and the pedestal push with (N).
struct Reading {
    /// The mean of both plates, across them.
    grip: f64,
    /// Up, by friction on the plates.
    friction: f64,
    /// Up, by the pedestal.
    pedestal: f64,
}

impl Gripper {
    fn grip(&self, coefficient: f64) -> Result<Grip, ExperimentError> {
        let (cells, gap) = (self.cells.value() as u32, self.activation_distance_m.value());
        let half = 0.5 * SIDE;
        let cube =
            block(&Vec3::new(-half, -half, 0.0), &Vec3::new(half, half, SIDE), [cells; 3], BoxSplit::Five)
                .map_err(ExperimentError::stopped)?;
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier);
        if coefficient > 0.0 {
            builder = builder.with_friction(friction(coefficient, self.stick_velocity_m_s.value())?);
        }
        let cube = builder.add_solid(&cube, GEL, Vec3::zeros())?;
        let inner = half + gap;
        let (low, high) = (Vec3::new(inner, -0.03, -0.04), Vec3::new(inner + 0.005, 0.03, 0.06));
        let pedestal = [Vec3::new(-0.015, -0.015, -0.03), Vec3::new(0.015, 0.015, -gap)];
        let hand = Hand::add(&mut builder, [low, high], pedestal)?;
        // Half of what a point of the pressed face carries.
        let load = GEL.young * SIDE * SIDE * 2.0 * self.squeeze_m.value() / SIDE;
        let load = 0.5 * load / f64::from((cells + 1) * (cells + 1));
        let contact = ContactOptions::new(gap, Stiffness::fixed(Scale::Load(load)));
        let newton = NewtonOptions { tolerance: 1e-7, max_iterations: 500, ..NewtonOptions::default() };
        let options = StepperOptions { newton, lagging: Lagging::Until(50), ..StepperOptions::default() };
        let world = builder.build(Vec3::new(0.0, 0.0, -GRAVITY), contact, options)?;
        Ok(Grip { world, cube, hand })
    }

    fn grasp(&self) -> Grasp {
        Grasp { squeeze: self.squeeze_m.value(), closed: CLOSED, lift: LIFT, lifting: [LIFTS, LIFTED] }
    }
}

impl Grip {
    fn step(&mut self, gripper: &Gripper, clock: &mut Clock) -> Result<(), ExperimentError> {
        let h = gripper.step_s.value();
        let (t, grasp) = (self.world.state.time, gripper.grasp());
        self.hand.push(&mut self.world, grasp.way(t + h) - grasp.way(t))?;
        self.world.step(h, clock)?;
        Ok(())
    }

    fn read(&self) -> Reading {
        let x = &self.world.state.position;
        let sum = |forces: &[Vec3], points: &Range<u32>| -> Vec3 {
            points.clone().map(|point| forces[point as usize]).sum()
        };
        let normal = self.world.contact.forces(x);
        let [left, right] = self.hand.fingers.each_ref().map(|finger| sum(&normal, finger));
        let mut reading = Reading {
            grip: 0.5 * (right.x - left.x),
            friction: 0.0,
            pedestal: -sum(&normal, &self.hand.pedestal).z,
        };
        if let Some(both) = self.world.contact.friction() {
            let forces = both.friction().forces(x);
            reading.friction = -self.hand.fingers.iter().map(|finger| sum(&forces, finger).z).sum::<f64>();
        }
        reading
    }

    /// The force of a bar of neo-Hookean material with ν = 0, as long as the cube is now between its two faces (N).
    fn force_of_bar(&self) -> f64 {
        let (x, rest) = (&self.world.state.position, self.world.contact.mesh().rest());
        let face = |side: f64| {
            let on = |i: &usize| (rest[*i].x - side * 0.5 * SIDE).abs() < 1e-9;
            let points: Vec<usize> = (self.cube.start as usize..self.cube.end as usize).filter(on).collect();
            points.iter().map(|&i| x[i].x).sum::<f64>() / points.len() as f64
        };
        let stretch = (face(1.0) - face(-1.0)) / SIDE;
        0.5 * GEL.young * SIDE * SIDE * (1.0 / stretch - stretch)
    }
}

impl Experiment for Gripper {
    fn methods(&self) -> &'static [&'static str] {
        &["holds", "slips"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut smooth = self.grip(0.0)?;
        while smooth.world.state.time < LIFTS - 1e-9 {
            smooth.step(self, clock)?;
        }
        let weight = smooth.world.stepper.mass().total() * GRAVITY;
        let coefficient = at.ladder * weight / (2.0 * smooth.read().grip);

        let mut grip = self.grip(coefficient)?;
        let h = self.step_s.value();
        // What slips is judged while the plates move by their full speed, what holds at the end.
        let until = if at.method == "holds" { END } else { 0.5 * (LIFTS + LIFTED) + 0.5 * WINDOW };
        let (mut mean, mut count) = (Reading { grip: 0.0, friction: 0.0, pedestal: 0.0 }, 0.0);
        let (mut before, mut height_before, mut sticking) = (0.0, 0.0, 1.0_f64);
        let height = |grip: &Grip| mass_mean(&grip.world, grip.cube.clone(), &grip.world.state.position).z;
        let start = height(&grip);
        while grip.world.state.time < until - 0.5 * h {
            if grip.world.state.time < until - WINDOW - 0.5 * h {
                (before, height_before) = (grip.world.state.time, height(&grip));
            } else {
                let now = grip.read();
                mean.grip += now.grip;
                mean.friction += now.friction;
                mean.pedestal += now.pedestal;
                count += 1.0;
                if let Some(report) = grip.world.friction_report {
                    sticking = sticking.min(report.sticking as f64 / (report.pairs as f64).max(1.0));
                }
            }
            grip.step(self, clock)?;
        }
        let (bound, force) = (2.0 * coefficient * mean.grip / count, mean.friction / count);
        let sinking = (height_before - height(&grip)) / (grip.world.state.time - before);
        let lifted = height(&grip) - start;
        let last = grip.read();
        let mut outcome = grip
            .world
            .outcome()
            .error("grip force", (last.grip / grip.force_of_bar() - 1.0).abs())
            .invariant("coefficient of friction", coefficient)
            .invariant("grip force (N)", last.grip)
            .invariant("2 μ N over the weight", bound / weight)
            .invariant("lifted (m)", lifted);
        outcome = if at.method == "holds" {
            let creep = self.stick_velocity_m_s.value() * (1.0 - (1.0 - weight / bound).max(0.0).sqrt());
            outcome
                .error("creep", (sinking / creep - 1.0).abs())
                .invariant("left behind (m)", LIFT - lifted)
                .invariant("sticking pairs (part)", sticking)
        } else {
            outcome
                .error("friction", (force / bound - 1.0).abs())
                .invariant("on the pedestal (part of the weight)", mean.pedestal / count / weight)
        };
        let x = &grip.world.state.position;
        let speeds = grip.world.contact.forces(x).iter().map(|f| f.norm()).collect();
        pictured(outcome, at, x, grip.world.contact.mesh().triangles(), ("force of contact", "N", speeds))
    }
}
