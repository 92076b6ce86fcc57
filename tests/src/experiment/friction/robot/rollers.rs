//! A soft bar between two rollers: drawn in where friction is strong enough, refused where not.

use super::{friction, mass_mean};
use crate::experiment::contact::portrait::pictured;
use crate::experiment::contact::world::{Material, SolidLaw, World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::{CollisionObject, SelfContact};
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::{Lagging, StepperOptions};
use mechanics_core::mesh::{BoxSplit, CylinderEnds, block, cylinder_surface};
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use nalgebra::Rotation3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// A bar 120 × 30 × 40 mm (E = 50 kPa, ν = 0, 1000 kg/m³) that drifts towards two rollers of radius 50 mm with a gap between them, which turn. No
/// gravity. The ladder is the step (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Rollers {
    /// Between the rollers, in parts of the bar's height; below one.
    gap: Positive,
    /// How fast the rollers' surfaces move (m/s).
    surface_speed_m_s: Positive,
    /// How fast the bar drifts (m/s).
    drift_m_s: Positive,
    /// μ in parts of the tangent of the angle of bite: of `drawn` and of `refused`.
    drawn: Positive,
    refused: Positive,
    /// A sixth of the points around a roller.
    rings: Count,
    /// The distance at which contact begins (m).
    activation_distance_m: Positive,
    /// εᵥ (m/s).
    stick_velocity_m_s: Positive,
    /// How long (s).
    duration_s: Positive,
}

const RADIUS: f64 = 0.05;
const LENGTH: f64 = 0.12;
const HEIGHT: f64 = 0.04;
const WIDTH: f64 = 0.03;
const FOAM: Material = Material { young: 5e4, poisson: 0.0, density: 1000.0 };

struct Machine {
    world: World,
    bar: Range<u32>,
    /// The lower one, and the upper one.
    rollers: [Range<u32>; 2],
    /// Height of the upper one's axis (m).
    axis: f64,
}

impl Rollers {
    /// The angle between the line of axes and where a roller meets an undeformed bar: cos α = 1 − Δ/(2R).
    fn angle_of_bite(&self) -> f64 {
        (1.0 - 0.5 * HEIGHT * (1.0 - self.gap.value()) / RADIUS).acos()
    }

    fn machine(&self, coefficient: f64) -> Result<Machine, ExperimentError> {
        let activation = self.activation_distance_m.value();
        let front = -RADIUS * self.angle_of_bite().sin() - 4.0 * activation;
        let (low, high) = (
            Vec3::new(front - LENGTH, -0.5 * WIDTH, -0.5 * HEIGHT),
            Vec3::new(front, 0.5 * WIDTH, 0.5 * HEIGHT),
        );
        let bar = block(&low, &high, [9, 2, 3], BoxSplit::Five).map_err(ExperimentError::stopped)?;
        let options = friction(coefficient, self.stick_velocity_m_s.value())?;
        let mut builder = WorldBuilder::of_law(SolidLaw::Barrier).with_friction(options);
        let bar = builder.add_solid(&bar, FOAM, Vec3::x() * self.drift_m_s.value())?;
        let axis = RADIUS + 0.5 * self.gap.value() * HEIGHT;
        let length = 1.5 * WIDTH;
        let mut add = |height: f64| {
            let mut mesh =
                cylinder_surface(RADIUS, length, self.rings.value() as u32, 2, CylinderEnds::Open)?;
            mesh.translate(&Vec3::new(0.0, 0.0, -0.5 * length))?;
            mesh.rotate(&Rotation3::from_axis_angle(&Vec3::x_axis(), FRAC_PI_2))?;
            mesh.translate(&Vec3::new(0.0, 0.0, height))?;
            Ok(builder.add_obstacle(mesh.points(), |first| {
                CollisionObject::of_mesh(&mesh, first).with_self_contact(SelfContact::Excluded)
            }))
        };
        let lower =
            add(-axis).map_err(|error: mechanics_core::mesh::MeshError| ExperimentError::stopped(error))?;
        let upper = add(axis).map_err(ExperimentError::stopped)?;
        // About what a point of the bar's surface carries.
        let load = FOAM.young * (1.0 - self.gap.value()) * LENGTH * WIDTH / 30.0;
        let contact = ContactOptions::new(activation, Stiffness::adaptive(Scale::Load(load)));
        let newton = NewtonOptions { tolerance: 1e-7, max_iterations: 500, ..NewtonOptions::default() };
        let options = StepperOptions { newton, lagging: Lagging::Until(100), ..StepperOptions::default() };
        let world = builder.build(Vec3::zeros(), contact, options)?;
        Ok(Machine { world, bar, rollers: [lower, upper], axis })
    }
}

impl Machine {
    /// Turns both rollers by an angle about their axes, so that the bar between them is drawn along x.
    fn turn(&mut self, angle: f64) -> Result<(), ExperimentError> {
        for (roller, side) in self.rollers.clone().into_iter().zip([-1.0, 1.0]) {
            let centre = Vec3::z() * (side * self.axis);
            let turn = Rotation3::from_axis_angle(&Vec3::y_axis(), -side * angle);
            for point in roller {
                let target = centre + turn * (self.world.state.position[point as usize] - centre);
                self.world.move_to(point, target)?;
            }
        }
        Ok(())
    }
}

impl Experiment for Rollers {
    fn methods(&self) -> &'static [&'static str] {
        &["drawn", "refused"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let bite = self.angle_of_bite();
        let part = if at.method == "drawn" { self.drawn } else { self.refused };
        let mut machine = self.machine(part.value() * bite.tan())?;
        let (h, speed) = (at.ladder, self.surface_speed_m_s.value());
        let angle = speed * h / RADIUS;
        let centre = |machine: &Machine| {
            mass_mean(&machine.world, machine.bar.clone(), &machine.world.state.position).x
        };
        let start = centre(&machine);
        // While the middle of the bar is near the line of axes.
        let (mut entered, mut left, mut furthest) = (None, None, start);
        let mut middle = machine.world.state.position.clone();
        for _ in 0..(self.duration_s.value() / h).round() as u64 {
            machine.turn(angle)?;
            machine.world.step(h, clock)?;
            let (x, t) = (centre(&machine), machine.world.state.time);
            furthest = furthest.max(x);
            if x < 0.0 {
                middle.clone_from(&machine.world.state.position);
            }
            if entered.is_none() && x > -0.25 * LENGTH {
                entered = Some((t, x));
            }
            if x < 0.25 * LENGTH {
                left = Some((t, x));
            }
        }
        let mut outcome = machine
            .world
            .outcome()
            .invariant("tangent of the angle of bite", bite.tan())
            .invariant("way of the bar (m)", centre(&machine) - start)
            .invariant("furthest (m)", furthest - start);
        if at.method == "drawn" {
            let mean = entered.zip(left).map_or(f64::NAN, |((t0, x0), (t1, x1))| (x1 - x0) / (t1 - t0));
            outcome = outcome
                .error("speed", (mean / speed - 1.0).abs())
                .invariant("speed over that of the rollers", mean / speed)
                .invariant("cosine of the angle of bite", bite.cos());
        }
        let speeds = machine.world.state.velocity.iter().map(|v| v.norm()).collect();
        pictured(outcome, at, &middle, machine.world.contact.mesh().triangles(), ("speed", "m/s", speeds))
    }
}
