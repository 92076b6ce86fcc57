//! A mass on a belt, held by a spring: it sticks until the spring pulls it off, slips back, and sticks again.

use super::surfaces::{GRAVITY, add_particles, friction, on_plane, stepping};
use crate::experiment::contact::particle::{SCHEMES, scheme};
use crate::experiment::contact::world::{World, WorldBuilder};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use ipc_friction::surface_motion::SurfaceMotion;
use lagrangian::element::Attachments;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::TAU;

/// A particle of 1 kg on a belt, on a spring; the ladder is the step h (s).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StickSlip {
    /// How fast the belt runs (m/s).
    belt_speed_m_s: Positive,
    /// Of the spring (N/m).
    stiffness_n_m: Positive,
    /// μ_s.
    static_coefficient: Positive,
    /// μ_k.
    kinetic_coefficient: Positive,
    /// Stick velocity in parts of the step (m/s²).
    stick_velocity_over_step_m_s2: Positive,
    /// For how long (s).
    duration_s: Positive,
}

/// The exact law, from event to event.
///
/// *Stick*: x = x₀ + V t, until k x = μ_s m g at x_s. *Slip*, from x_s with the speed V: the belt is faster than the mass, so friction is μ_k m g
/// forward, and with x_k = μ_k m g/k, A = x_s − x_k, ω² = k/m, φ = ω t: x = x_k + A cos φ + (V/ω) sin φ. The speed
/// −A ω sin φ + V cos φ is V again where tan ½φ = −A ω/V, that is at φ = 2π − 2 arctan(A ω/V), and there x = x_k − A: the mass sticks for
/// 2A/V, until it is at x_s.
struct Exact {
    speed: f64,
    frequency: f64,
    slip_from: f64,
    centre: f64,
}

impl Exact {
    fn amplitude(&self) -> f64 {
        self.slip_from - self.centre
    }

    fn slip_time(&self) -> f64 {
        (TAU - 2.0 * (self.amplitude() * self.frequency / self.speed).atan()) / self.frequency
    }

    fn period(&self) -> f64 {
        2.0 * self.amplitude() / self.speed + self.slip_time()
    }

    /// Where the mass is that stood still on the belt at x = 0.
    fn position(&self, t: f64) -> f64 {
        let first_slip = self.slip_from / self.speed;
        if t < first_slip {
            return self.speed * t;
        }
        let since = (t - first_slip) % self.period();
        if since > self.slip_time() {
            return self.centre - self.amplitude() + self.speed * (since - self.slip_time());
        }
        let (sine, cosine) = (self.frequency * since).sin_cos();
        self.centre + self.amplitude() * cosine + self.speed / self.frequency * sine
    }
}

impl StickSlip {
    fn exact(&self) -> Exact {
        let stiffness = self.stiffness_n_m.value();
        Exact {
            speed: self.belt_speed_m_s.value(),
            frequency: stiffness.sqrt(),
            slip_from: self.static_coefficient.value() * GRAVITY / stiffness,
            centre: self.kinetic_coefficient.value() * GRAVITY / stiffness,
        }
    }

    fn world(&self, h: f64, method: &str) -> Result<World, ExperimentError> {
        let stick_velocity = self.stick_velocity_over_step_m_s2.value() * h;
        let belt = Vec3::x() * self.belt_speed_m_s.value();
        let law =
            friction(self.static_coefficient.value(), self.kinetic_coefficient.value(), stick_velocity)?;
        let law = law.with_half_space_motion(0, SurfaceMotion::sliding(belt));
        let mut builder = WorldBuilder::default().with_friction(law);
        let point = add_particles(&mut builder, &[[0.0, 0.0]], 1.0, belt).start;
        let rest = builder.rest()[point as usize];
        let spring = Attachments::term("spring", self.stiffness_n_m.value(), &[point], vec![rest]);
        builder.add_term(spring.map_err(ExperimentError::stopped)?);
        on_plane(builder, Vec3::z() * -GRAVITY, GRAVITY, stepping(1e-10, scheme(method)))
    }
}

impl Experiment for StickSlip {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let (h, exact) = (at.ladder, self.exact());
        let mut world = self.world(h, at.method)?;
        let (mut worst, mut crossings) = (0.0_f64, Vec::new());
        let mut before = 0.0;
        for step in 1..=(self.duration_s.value() / h).round() as u64 {
            world.step(h, clock)?;
            let x = world.state.position[0].x;
            let t = step as f64 * h;
            worst = worst.max((x - exact.position(t)).abs());
            // On the belt, forwards through the middle: motion is uniform there, so a straight line finds the time.
            if before < exact.centre && x >= exact.centre {
                crossings.push(t - h * (x - exact.centre) / (x - before));
            }
            before = x;
        }
        let [Some(first), Some(last)] = [crossings.first(), crossings.last()] else {
            return Ok(world.outcome());
        };
        let period = (last - first) / (crossings.len() - 1) as f64;
        Ok(world
            .outcome()
            .count("cycles", crossings.len() as u64 - 1)
            .error("position", worst / exact.slip_from)
            .error("period", (period / exact.period() - 1.0).abs())
            .invariant("period (s)", period))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_form_is_continuous_and_ends_each_slip_with_the_speed_of_the_belt() {
        let exact = Exact { speed: 0.1, frequency: 10.0, slip_from: 0.04905, centre: 0.02943 };
        let (first, tiny) = (exact.slip_from / exact.speed, 1e-7);
        let slope = |t: f64| (exact.position(t + tiny) - exact.position(t - tiny)) / (2.0 * tiny);
        for cycle in 0..4 {
            let slip = first + f64::from(cycle) * exact.period();
            for event in [slip, slip + exact.slip_time()] {
                assert!((exact.position(event + tiny) - exact.position(event - tiny)).abs() < 1e-7);
                assert!((slope(event - 2.0 * tiny) - exact.speed).abs() < 1e-4);
            }
            // In slip, x'' = −ω² (x − x_k).
            let (t, d) = (slip + 0.4 * exact.slip_time(), 1e-4);
            let second = (exact.position(t + d) - 2.0 * exact.position(t) + exact.position(t - d)) / (d * d);
            assert!((second + 100.0 * (exact.position(t) - exact.centre)).abs() < 1e-4);
        }
    }
}
