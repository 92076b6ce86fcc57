//! A rope around a fixed cylinder: the capstan equation.

use super::surfaces::{friction, stepping};
use crate::experiment::contact::world::{World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use ipc_contact::collision_mesh::{CollisionObject, SelfContact};
use ipc_contact::contact::ContactOptions;
use ipc_contact::stiffness::{Scale, Stiffness};
use lagrangian::element::DeadLoad;
use lagrangian::element::Springs;
use lagrangian::stepper::TimeScheme;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;

/// A rope of springs without weight hangs over a fixed cylinder: a load at one end, the other drawn down slowly. The ladder is the distance of
/// points, in parts of half of the circle.
///
/// The cylinder is exact: a segment on its axis with a minimum separation of the radius, and what touches it are the rope's points. At a point where the
/// rope turns by δ, with the tensions T and T′ before and after, balance across and along the bisector is N = (T + T′) sin ½δ and
/// μ N = (T′ − T) cos ½δ, hence T′/T = (1 + μ t)/(1 − μ t) with t = tan ½δ, whose logarithm is 2 artanh(μ t) = μ δ + O(δ³). The turns add up to the
/// angle of wrap φ, wherever the points are: T₂/T₁ = e^{μ φ} (1 + O(δ²)).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Capstan {
    radius_m: Positive,
    friction_coefficient: Positive,
    /// Where friction reaches all of its bound (m/s).
    stick_velocity_m_s: Positive,
    /// Where contact begins (m).
    activation_distance_m: Positive,
    /// The load at one end (N).
    load_n: Positive,
    /// Length that the load makes of a length (1).
    strain: Positive,
    /// How fast the other end is drawn (m/s).
    speed_m_s: Positive,
    /// For how long (s).
    duration_s: Positive,
    step_s: Positive,
}

/// What a point of the rope weighs in inertia (kg).
const MASS: f64 = 1e-4;

/// The rope: its points are 0 (the load) to `last` (the end that is drawn).
struct Rope {
    last: u32,
    segment: f64,
}

impl Capstan {
    /// Down one side, over the cylinder, down the other. Points are half a segment off the top.
    fn places(&self, along_half: usize) -> (Vec<Vec3>, f64) {
        let radius = self.radius_m.value() + 0.5 * self.activation_distance_m.value();
        let segment = PI * radius / along_half as f64;
        // Hangs far below what it is drawn by, so that the straight parts are vertical.
        let below = self.speed_m_s.value() * self.duration_s.value() + 4.0 * self.radius_m.value();
        let hanging = (below / segment).ceil() as usize;
        let place = |number: usize| {
            let arc = (number as f64 + 0.5 - hanging as f64) * segment;
            let angle = arc / radius;
            if angle < 0.0 {
                Vec3::new(-radius, 0.0, arc)
            } else if angle > PI {
                Vec3::new(radius, 0.0, PI * radius - arc)
            } else {
                Vec3::new(-radius * angle.cos(), 0.0, radius * angle.sin())
            }
        };
        ((0..along_half + 2 * hanging).map(place).collect(), segment)
    }

    fn world(&self, along_half: usize) -> Result<(World, Rope), ExperimentError> {
        let (places, segment) = self.places(along_half);
        let last = places.len() as u32 - 1;
        let mu = self.friction_coefficient.value();
        let law = friction(mu, mu, self.stick_velocity_m_s.value())?;
        let mut builder = WorldBuilder::default().with_friction(law);
        builder.add_masses(&places, MASS, Vec3::zeros(), |first| {
            let points = (first..=first + last).collect();
            let object = CollisionObject { points, ..CollisionObject::default() };
            object.with_thickness(segment).with_self_contact(SelfContact::Excluded)
        });
        let half = 4.0 * self.radius_m.value();
        builder.add_obstacle(&[Vec3::y() * -half, Vec3::y() * half], |first| {
            let segments = vec![[first, first + 1]];
            CollisionObject { segments, ..CollisionObject::default() }.with_thickness(segment)
        });
        let stiffness = self.load_n.value() / (self.strain.value() * segment);
        let edges = (0..last).map(|p| [p, p + 1]).collect();
        let springs = Springs::term("rope", stiffness, builder.rest(), edges);
        builder.add_term(springs.map_err(ExperimentError::stopped)?);
        let load = DeadLoad::new("load", vec![(0, Vec3::z() * -self.load_n.value())]);
        builder.add_term(load.map_err(ExperimentError::stopped)?);
        builder.script([last]);
        // A point with the load in the rope presses with about load times its turn.
        let pressed = Scale::Load(self.load_n.value() * PI / along_half as f64);
        let contact = ContactOptions {
            minimum_separation: self.radius_m.value(),
            ..ContactOptions::new(self.activation_distance_m.value(), Stiffness::fixed(pressed))
        };
        let options = stepping(1e-7, TimeScheme::BackwardEuler);
        Ok((builder.build(Vec3::zeros(), contact, options)?, Rope { last, segment }))
    }

    /// The tensions of the last and the first spring (N).
    fn tensions(&self, rope: &Rope, x: &[Vec3], rest: &[Vec3]) -> [f64; 2] {
        let stiffness = self.load_n.value() / (self.strain.value() * rope.segment);
        let length = |x: &[Vec3], p: u32| (x[p as usize + 1] - x[p as usize]).norm();
        [rope.last - 1, 0].map(|p| stiffness * (length(x, p) - length(rest, p)))
    }
}

impl Experiment for Capstan {
    fn methods(&self) -> &'static [&'static str] {
        &["points"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (mut world, rope) = self.world((1.0 / at.ladder).round() as usize)?;
        let rest = world.state.position.clone();
        let h = self.step_s.value();
        let way = Vec3::z() * -(self.speed_m_s.value() * h);
        let steps = (self.duration_s.value() / h).round() as u64;
        let (mut ratio, mut counted) = (0.0, 0.0);
        for step in 1..=steps {
            world.move_to(rope.last, rest[rope.last as usize] + way * step as f64)?;
            world.step(h, clock)?;
            // All of it moves by then.
            if 2 * step > steps {
                let [drawn, load] = self.tensions(&rope, &world.state.position, &rest);
                ratio += drawn / load;
                counted += 1.0;
            }
        }
        let ratio = ratio / counted;
        let expected = (self.friction_coefficient.value() * PI).exp();
        let sliding = world.friction_report.map_or(0.0, |report| (report.pairs - report.sticking) as f64);
        Ok(world
            .outcome()
            .error("ratio of tensions", (ratio / expected - 1.0).abs())
            .invariant("T₂/T₁", ratio)
            .invariant("points that slide", sliding))
    }
}
