//! A disk that spins on the floor until friction has stopped it.

use super::surfaces::{GRAVITY, add_particles, friction, on_plane, stepping};
use crate::experiment::contact::particle::{SCHEMES, scheme};
use crate::experiment::contact::world::{World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{Count, Positive};
use lagrangian::element::Springs;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

/// What spins.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SpinningShape {
    /// Points on a circle.
    Ring,
    /// Points on circles, each of which stands for as much of a disk.
    Disk,
}

/// Points of equal weight in stiff springs spin on the plane; the ladder is whichever of step (s) and circles is not stated: for
/// circles the width of one in parts of the radius. A spring lies in the plane and carries no weight, so the pressure is uniform.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpinningDisk {
    shape: SpinningShape,
    radius_m: Positive,
    angular_velocity_1_s: Positive,
    friction_coefficient: Positive,
    /// Where friction reaches all of its bound (m/s).
    stick_velocity_m_s: Positive,
    /// √(k/m) of a spring and a point (1/s).
    spring_frequency_1_s: Positive,
    /// Step (s).
    step_s: Option<Positive>,
    /// Circles of a disk.
    circles: Option<Count>,
}

/// Friction's deceleration is constant until the disk stops. So is it measured when this part of the spin is left: then even the innermost
/// points still slide faster than εᵥ.
const LEFT: f64 = 0.05;
/// Points of a ring.
const RING: usize = 12;

/// Places of points, and the springs between them.
struct Net {
    places: Vec<[f64; 2]>,
    edges: Vec<[u32; 2]>,
}

impl Net {
    fn ring(radius: f64) -> Self {
        let place = |k: usize| circle(radius, k, RING);
        let n = RING as u32;
        // To both neighbours, and across: a ring of springs alone would fold.
        let edges = (0..n).map(|k| [k, (k + 1) % n]).chain((0..n / 2).map(|k| [k, k + n / 2]));
        let second = (0..n).map(|k| [k, (k + 2) % n]);
        Self { places: (0..RING).map(place).collect(), edges: edges.chain(second).collect() }
    }

    /// Circle j of n stands for the ring between (j − 1) R/n and j R/n with 3 (2j − 1) points: equal areas.
    fn disk(radius: f64, circles: usize) -> Self {
        let (mut places, mut edges): (Vec<[f64; 2]>, Vec<[u32; 2]>) = (Vec::new(), Vec::new());
        let mut inner = 0..0;
        for j in 1..=circles {
            let (count, first) = (3 * (2 * j - 1), places.len());
            places.extend((0..count).map(|k| circle(radius * (j as f64 - 0.5) / circles as f64, k, count)));
            for k in 0..count {
                let own = (first + k) as u32;
                edges.push([own, (first + (k + 1) % count) as u32]);
                edges.extend(nearest_two(&places, inner.clone(), first + k).map(|p| [p, own]));
            }
            inner = first..places.len();
        }
        Self { places, edges }
    }
}

fn circle(radius: f64, k: usize, count: usize) -> [f64; 2] {
    let (sine, cosine) = (TAU * k as f64 / count as f64).sin_cos();
    [radius * cosine, radius * sine]
}

/// The two of `among` that are nearest to a place; none of none.
fn nearest_two(places: &[[f64; 2]], among: std::ops::Range<usize>, of: usize) -> impl Iterator<Item = u32> {
    let square = |p: usize| (0..2).map(|i| (places[p][i] - places[of][i]).powi(2)).sum::<f64>();
    let mut all: Vec<usize> = among.collect();
    all.sort_by(|&a, &b| square(a).total_cmp(&square(b)).then(a.cmp(&b)));
    all.into_iter().take(2).map(|p| p as u32)
}

impl SpinningDisk {
    fn world(&self, net: &Net, method: &str) -> Result<World, ExperimentError> {
        let mu = self.friction_coefficient.value();
        let law = friction(mu, mu, self.stick_velocity_m_s.value())?;
        let mut builder = WorldBuilder::default().with_friction(law);
        let mass = 1.0 / net.places.len() as f64;
        add_particles(&mut builder, &net.places, mass, Vec3::zeros());
        let stiffness = mass * self.spring_frequency_1_s.value().powi(2);
        let springs = Springs::term("springs", stiffness, builder.rest(), net.edges.clone());
        builder.add_term(springs.map_err(ExperimentError::stopped)?);
        let options = stepping(1e-9, scheme(method));
        let mut world = on_plane(builder, Vec3::z() * -GRAVITY, mass * GRAVITY, options)?;
        let spin = Vec3::z() * self.angular_velocity_1_s.value();
        let velocity = world.state.position.iter().map(|x| spin.cross(x));
        world.state.velocity = velocity.collect();
        Ok(world)
    }

    /// ω₀ times moment of inertia over moment of friction: until the exact law has stopped the points as they stand, and the shape.
    fn stopping_times(&self, net: &Net) -> [f64; 2] {
        let radii = || net.places.iter().map(|[x, y]| x.hypot(*y));
        let of_points = radii().map(|r| r * r).sum::<f64>() / radii().sum::<f64>();
        let of_shape = match self.shape {
            SpinningShape::Ring => self.radius_m.value(),
            SpinningShape::Disk => 0.75 * self.radius_m.value(),
        };
        let deceleration = self.friction_coefficient.value() * GRAVITY;
        [of_points, of_shape].map(|length| self.angular_velocity_1_s.value() * length / deceleration)
    }
}

impl Experiment for SpinningDisk {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let radius = self.radius_m.value();
        let net = match self.shape {
            SpinningShape::Ring => Net::ring(radius),
            SpinningShape::Disk => {
                Net::disk(radius, self.circles.map_or((1.0 / at.ladder).round() as usize, Count::value))
            }
        };
        let h = self.step_s.map_or(at.ladder, Positive::value);
        let mut world = self.world(&net, at.method)?;
        let [of_points, of_shape] = self.stopping_times(&net);
        let spin = |world: &World| {
            let (mass, state) = (world.stepper.mass(), &world.state);
            mass.angular_momentum(&state.position, &state.velocity, &Vec3::zeros()).z
        };
        let start = spin(&world);
        let (mut before, mut now) = (1.0, 1.0);
        while now > LEFT && world.state.time < 2.0 * of_points {
            world.step(h, clock)?;
            (before, now) = (now, spin(&world) / start);
        }
        let crossing = world.state.time - h * (LEFT - now) / (before - now);
        let found = crossing / (1.0 - LEFT);
        let drift = world.stepper.mass().linear_momentum(&world.state.velocity).xy().norm();
        Ok(world
            .outcome()
            .error("stopping time", (found / of_shape - 1.0).abs())
            .error("stopping time of the points", (found / of_points - 1.0).abs())
            .invariant("drift (m/s)", drift)
            .invariant("stopping time (s)", found))
    }
}
