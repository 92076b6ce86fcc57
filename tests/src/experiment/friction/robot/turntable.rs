//! A ball that rolls on a turntable.

use super::friction;
use crate::experiment::contact::forms::{crossing, pull};
use crate::experiment::contact::particle::scheme;
use crate::experiment::contact::portrait::pictured;
use crate::experiment::contact::world::{World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use ipc_contact::collision_mesh::{CollisionObject, SelfContact};
use ipc_contact::contact::{BarrierForm, ContactOptions};
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::stepper::{Lagging, StepperOptions};
use mechanics_core::mesh::sphere;
use mechanics_core::newton::NewtonOptions;
use mechanics_core::tensor::Vec3;
use nalgebra::Rotation3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// A nearly rigid ball of 1 kg and radius 50 mm, with 2/5 of its mass in the middle and 3/5 on its surface so that its moment of inertia is that of a
/// homogeneous ball, rolls on a disk that turns with Ω about the z axis. By pure rolling its centre goes round a circle with 2/7 Ω,
/// wherever it starts. The ladder is the step times the speed at which the ball turns (rad).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Turntable {
    /// Ω (rad/s).
    speed_rad_s: Positive,
    /// From the axis to the middle of the circle, and the circle's radius (m).
    eccentricity_m: Positive,
    circle_m: Positive,
    /// The part of the circle that is rolled.
    turns: Positive,
    /// μ.
    friction_coefficient: Positive,
    /// εᵥ (m/s).
    stick_velocity_m_s: Positive,
    /// The distance at which contact begins (m).
    activation_distance_m: Positive,
    /// Parts into which an edge of the icosahedron is cut.
    frequency: Count,
}

const RADIUS: f64 = 0.05;
const GRAVITY: f64 = 9.81;
const FORM: BarrierForm = BarrierForm::SquaredDistance;
/// From the axis to the corners of the disk, one triangle, which is larger than where the ball goes (m).
const WIDTH: f64 = 2.0;
const YOUNG: f64 = 1e9;

struct Table {
    world: World,
    disk: Range<u32>,
    /// The ball's centre, a point with mass.
    centre: u32,
}

impl Turntable {
    /// Velocity and angular velocity at the start, at the end of the circle's radius along x: rolling, and spinning with the disk.
    fn motion(&self) -> [Vec3; 2] {
        let disk = Vec3::z() * self.speed_rad_s.value();
        let from_axis = Vec3::x() * (self.eccentricity_m.value() + self.circle_m.value());
        let velocity = disk.cross(&Vec3::x()) * (2.0 / 7.0 * self.circle_m.value());
        // v − R ω × z = Ω × r: the lowest point moves with the disk.
        let rolling = Vec3::z().cross(&(velocity - disk.cross(&from_axis))) / RADIUS;
        [velocity, rolling + disk]
    }

    fn table(&self, method: &str) -> Result<Table, ExperimentError> {
        let mut surface = sphere(RADIUS, self.frequency.value() as u32).map_err(ExperimentError::stopped)?;
        // No two of its points at the same height.
        let turn = Rotation3::from_euler_angles(0.3, 0.2, 0.1);
        surface.rotate(&turn).map_err(ExperimentError::stopped)?;
        let activation = self.activation_distance_m.value();
        let count = surface.points().len();
        let lowest = surface.points().iter().map(|x| x.z).fold(0.0, f64::min);
        let stiffness = Stiffness::fixed(Scale::Load(GRAVITY / 3.0));
        let kappa = GRAVITY / 3.0 / pull(FORM, activation, 0.5 * activation);
        // Where the points' forces balance the weight.
        let gap = crossing(activation, |gap| {
            let of = |x: &Vec3| kappa * pull(FORM, activation, x.z - lowest + gap);
            surface.points().iter().map(of).sum::<f64>() - GRAVITY
        });
        let start = Vec3::new(self.eccentricity_m.value() + self.circle_m.value(), 0.0, gap - lowest);
        let mut points: Vec<Vec3> = surface.points().iter().map(|x| x + start).collect();
        points.push(start);
        let mut masses = vec![0.6 / count as f64; count];
        masses.push(0.4);
        let [velocity, spin] = self.motion();

        let options = friction(self.friction_coefficient.value(), self.stick_velocity_m_s.value())?;
        let mut builder = WorldBuilder::default().with_friction(options);
        let at = |x: &Vec3| velocity + spin.cross(&(x - start));
        let ball = builder.add_affine_body(&points, &masses, YOUNG, at, |first| {
            CollisionObject { points: (first..first + count as u32).collect(), ..CollisionObject::default() }
                .with_thickness(1e-3)
                .with_self_contact(SelfContact::Excluded)
        })?;
        let corner = |k: f64| Vec3::new((TAU * k / 3.0).cos(), (TAU * k / 3.0).sin(), 0.0) * WIDTH;
        let disk = builder.add_obstacle(&[0.0, 1.0, 2.0].map(corner), |first| {
            CollisionObject::new(vec![[first, first + 1, first + 2]])
        });
        let newton = NewtonOptions { tolerance: 1e-9, ..NewtonOptions::default() };
        let options = StepperOptions {
            newton,
            scheme: scheme(method),
            lagging: Lagging::Until(50),
            ..StepperOptions::default()
        };
        let contact = ContactOptions::new(activation, stiffness);
        let mut world = builder.build(Vec3::new(0.0, 0.0, -GRAVITY), contact, options)?;
        for point in disk.clone() {
            let x = world.state.position[point as usize];
            world.state.velocity[point as usize] = Vec3::z().cross(&x) * self.speed_rad_s.value();
        }
        Ok(Table { world, disk, centre: ball.start + count as u32 })
    }
}

impl Experiment for Turntable {
    fn methods(&self) -> &'static [&'static str] {
        &["backward-euler", "bdf2"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let mut table = self.table(at.method)?;
        let speed = self.speed_rad_s.value();
        let [_, spin] = self.motion();
        let duration = self.turns.value() * TAU / (2.0 / 7.0 * speed);
        let steps = (duration * spin.norm() / at.ladder).ceil();
        let h = duration / steps;
        let middle = Vec3::x() * self.eccentricity_m.value();
        let (mut angle, mut before, mut sway) = (0.0, 0.0_f64, 0.0_f64);
        let mut track = Vec::new();
        let corners: Vec<Vec3> =
            table.disk.clone().map(|point| table.world.state.position[point as usize]).collect();
        for step in 1..=steps as u64 {
            let turn = Rotation3::from_axis_angle(&Vec3::z_axis(), speed * h * step as f64);
            for (point, corner) in table.disk.clone().zip(&corners) {
                table.world.move_to(point, turn * corner)?;
            }
            table.world.step(h, clock)?;
            let centre = table.world.state.position[table.centre as usize];
            let arm = centre - middle;
            let now = arm.y.atan2(arm.x);
            angle += (now - before + PI).rem_euclid(TAU) - PI;
            before = now;
            sway = sway.max((arm.x.hypot(arm.y) / self.circle_m.value() - 1.0).abs());
            track.push(centre);
        }
        let exact = 2.0 / 7.0 * speed * duration;
        let end =
            Rotation3::from_axis_angle(&Vec3::z_axis(), exact) * (Vec3::x() * self.circle_m.value()) + middle;
        let last = table.world.state.position[table.centre as usize];
        let missed = (last.x - end.x).hypot(last.y - end.y);
        let outcome = table
            .world
            .outcome()
            .error("angular velocity", (angle / exact - 1.0).abs())
            .error("radius", sway)
            .error("position", missed / self.circle_m.value())
            .invariant("angular velocity over Ω", angle / duration / speed);
        let circle: Vec<Vec3> = (0..=200)
            .map(|k| {
                let turn = Rotation3::from_axis_angle(&Vec3::z_axis(), exact * f64::from(k) / 200.0);
                turn * (Vec3::x() * self.circle_m.value()) + middle
            })
            .collect();
        let every = (track.len() / 200).max(1);
        let track: Vec<Vec3> = track.into_iter().step_by(every).collect();
        let (mut x, mut triangles) = (Vec::new(), Vec::new());
        add_ribbon(&circle, [0.0, 0.004], &mut x, &mut triangles);
        add_ribbon(&track, [0.006, 0.012], &mut x, &mut triangles);
        let radii = x.iter().map(|x| (x - middle).xy().norm()).collect();
        let caption = ("distance from the middle", "m", radii);
        pictured(outcome, at, &x, &triangles, caption)
    }
}

/// A ribbon along a track, between these heights.
fn add_ribbon(track: &[Vec3], heights: [f64; 2], points: &mut Vec<Vec3>, triangles: &mut Vec<[u32; 3]>) {
    let first = points.len() as u32;
    points.extend(track.iter().flat_map(|x| heights.map(|height| Vec3::new(x.x, x.y, height))));
    let pieces = (0..track.len() as u32 - 1).flat_map(|k| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner| first + 2 * k + corner);
        [[a, c, b], [b, c, d]]
    });
    triangles.extend(pieces);
}
