//! A block on an incline: it creeps as the smoothed law says, or slides as the exact one does.

use super::surfaces::{GRAVITY, creep, friction, particle_on_slope, stepping};
use crate::experiment::contact::particle::{SCHEMES, scheme};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{NonNegative, Positive};
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// Particles of 1 kg on slopes of all given angles, with all given coefficients; the ladder is whichever of step (s) and stick
/// velocity (m/s) is not stated.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BlocksOnInclines {
    /// How steep (degrees).
    angles_deg: Vec<Positive>,
    /// Coefficients of friction.
    friction_coefficients: Vec<NonNegative>,
    /// Step (s).
    step_s: Option<Positive>,
    /// Where friction reaches all of its bound (m/s).
    stick_velocity_m_s: Option<Positive>,
    /// How fast what slides is at first (m/s).
    first_speed_m_s: NonNegative,
    /// For how long it slides (s).
    duration_s: Positive,
}

/// The parts of an error.
#[derive(Default)]
struct Worst {
    /// Of what sticks: relative to the closed form.
    creep: f64,
    /// Of what sticks (m/s).
    speed: f64,
    /// Of what slides, relative.
    way: f64,
    sticking: u64,
    sliding: u64,
    last: Option<Outcome>,
}

/// One slope.
struct Slope<'a> {
    angle: f64,
    mu: f64,
    h: f64,
    stick_velocity: f64,
    method: &'a str,
}

impl Slope<'_> {
    /// Runs a particle that sticks, until its speed is that of its creep.
    fn stick(&self, worst: &mut Worst, clock: &mut Clock) -> Result<(), ExperimentError> {
        let Self { angle, mu, h, stick_velocity, method } = *self;
        let options = stepping(1e-10 * stick_velocity, scheme(method));
        let law = friction(mu, mu, stick_velocity)?;
        let mut world = particle_on_slope(angle, law, options, Vec3::zeros())?;
        let part = angle.tan() / mu;
        // The rate at which what is not yet creep decays: λ dμ/dy over the mass.
        let rate = 2.0 * mu * GRAVITY * angle.cos() * (1.0 - part).sqrt() / stick_velocity;
        for _ in 0..30 + (25.0 / (rate * h)) as u64 {
            world.step(h, clock)?;
        }
        let (found, expected) = (world.state.velocity[0].x, creep(stick_velocity, part));
        worst.creep = worst.creep.max((found / expected - 1.0).abs());
        worst.speed = worst.speed.max(found);
        worst.sticking += 1;
        worst.last = Some(world.outcome());
        Ok(())
    }

    /// Runs a particle that slides.
    fn slide(
        &self,
        speed: f64,
        duration: f64,
        worst: &mut Worst,
        clock: &mut Clock,
    ) -> Result<(), ExperimentError> {
        let Self { angle, mu, h, stick_velocity, method } = *self;
        let law = friction(mu, mu, stick_velocity)?;
        let options = stepping(1e-11, scheme(method));
        let mut world = particle_on_slope(angle, law, options, Vec3::x() * speed)?;
        let steps = (duration / h).round() as u64;
        for _ in 0..steps {
            world.step(h, clock)?;
        }
        let t = steps as f64 * h;
        let exact = speed * t + 0.5 * GRAVITY * (angle.sin() - mu * angle.cos()) * t * t;
        worst.way = worst.way.max((world.state.position[0].x / exact - 1.0).abs());
        worst.sliding += 1;
        worst.last = Some(world.outcome());
        Ok(())
    }
}

impl Experiment for BlocksOnInclines {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let value = |stated: Option<Positive>| stated.map_or(at.ladder, Positive::value);
        let mut worst = Worst::default();
        for angle in &self.angles_deg {
            for mu in &self.friction_coefficients {
                let (angle, mu) = (angle.value().to_radians(), mu.value());
                let stick_velocity = value(self.stick_velocity_m_s);
                let slope = Slope { angle, mu, h: value(self.step_s), stick_velocity, method: at.method };
                if angle.tan() < mu {
                    slope.stick(&mut worst, clock)?;
                } else {
                    let (speed, duration) = (self.first_speed_m_s.value(), self.duration_s.value());
                    slope.slide(speed, duration, &mut worst, clock)?;
                }
            }
        }
        let outcome = worst.last.unwrap_or_default();
        Ok(outcome
            .error("creep", worst.creep)
            .error("creep speed", worst.speed)
            .error("way", worst.way)
            .count("sticking", worst.sticking)
            .count("sliding", worst.sliding))
    }
}
