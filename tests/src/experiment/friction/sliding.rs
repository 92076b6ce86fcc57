//! How far a block slides until it stops.

use super::surfaces::{GRAVITY, friction, particle_on_slope, stepping};
use crate::experiment::contact::particle::{SCHEMES, scheme};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::stepper::TimeScheme;
use mechanics_core::tensor::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;

/// A particle of 1 kg slides on the level until it stops; the ladder is whichever of step (s) and stick velocity (m/s) is not stated.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SlidingDistance {
    /// How fast it is at first (m/s).
    speed_m_s: Positive,
    friction_coefficient: Positive,
    /// Step (s).
    step_s: Option<Positive>,
    /// Where friction reaches all of its bound (m/s).
    stick_velocity_m_s: Option<Positive>,
}

/// The way under the exact law in the steps of a scheme, each solved by hand: friction takes at most all of the speed.
fn way_of_steps(scheme: TimeScheme, speed: f64, deceleration: f64, h: f64) -> f64 {
    let loss = deceleration * h;
    match scheme {
        TimeScheme::Bdf2 => bdf2(speed, loss, h),
        TimeScheme::Newmark => newmark(speed, loss, h),
        _ => {
            // v loses `loss` in each of k steps and is gone after the next.
            let k = (speed / loss).floor();
            h * (k * speed - 0.5 * loss * k * (k + 1.0))
        }
    }
}

/// What is left of a speed from which friction can take `bound`.
fn left(speed: f64, bound: f64) -> f64 {
    speed.signum() * (speed.abs() - bound).max(0.0)
}

fn bdf2(speed: f64, loss: f64, h: f64) -> f64 {
    let (mut v0, mut x0) = (speed, 0.0);
    let mut v = left(speed, loss);
    let mut x = h * v;
    for _ in 0..(2.0 * speed / loss) as u64 + 10 {
        let next = left((4.0 * v - v0) / 3.0, 2.0 / 3.0 * loss);
        let place = (4.0 * x - x0) / 3.0 + 2.0 / 3.0 * h * next;
        (v0, x0, v, x) = (v, x, next, place);
    }
    x
}

fn newmark(speed: f64, loss: f64, h: f64) -> f64 {
    // `a` is the acceleration times h.
    let (mut v, mut x, mut a) = (speed, 0.0, -loss);
    for _ in 0..(2.0 * speed / loss) as u64 + 10 {
        let free = v + 0.5 * a;
        let next = left(free, 0.5 * loss);
        x += 0.5 * h * (v + next);
        (v, a) = (next, 2.0 * (next - free));
    }
    x
}

impl Experiment for SlidingDistance {
    fn methods(&self) -> &'static [&'static str] {
        SCHEMES
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let value = |stated: Option<Positive>| stated.map_or(at.ladder, Positive::value);
        let (h, stick_velocity) = (value(self.step_s), value(self.stick_velocity_m_s));
        let (speed, mu) = (self.speed_m_s.value(), self.friction_coefficient.value());
        let deceleration = mu * GRAVITY;
        let scheme = scheme(at.method);
        let options = stepping(1e-11, scheme);
        let start = Vec3::new(0.6, 0.8, 0.0) * speed;
        let mut world = particle_on_slope(0.0, friction(mu, mu, stick_velocity)?, options, start)?;
        // What is left below εᵥ decays at the rate 2 μ g/εᵥ at last.
        let duration = speed / deceleration + 12.0 * stick_velocity / deceleration;
        for _ in 0..(duration / h).ceil() as u64 + 30 {
            world.step(h, clock)?;
        }
        let way = world.state.position[0].xy();
        let exact = speed * speed / (2.0 * deceleration);
        let smoothed = exact + stick_velocity * stick_velocity * (2.0_f64.ln() - 0.5) / deceleration;
        let of_steps = way_of_steps(scheme, speed, deceleration, h);
        let turned = (0.8 * way.x - 0.6 * way.y).abs() / exact;
        let relative = |expected: f64| (way.norm() / expected - 1.0).abs();
        Ok(world
            .outcome()
            .error("distance", relative(exact))
            .error("distance of the steps", relative(of_steps))
            .error("distance of the smoothed law", relative(smoothed))
            .invariant("way (m)", way.norm())
            .invariant("turned", turned)
            .invariant("last speed (m/s)", world.state.velocity[0].norm()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_steps_of_backward_euler_slide_0_0970_m() {
        let way = way_of_steps(TimeScheme::BackwardEuler, 1.0, 0.5 * 9.81, 0.01);
        assert!((way - 0.096995).abs() < 1e-9, "{way}");
    }

    #[test]
    fn the_ways_of_all_schemes_tend_to_that_of_the_exact_law() {
        let exact = 1.0 / 9.81;
        for (scheme, order) in
            [(TimeScheme::BackwardEuler, 1.0), (TimeScheme::Bdf2, 1.5), (TimeScheme::Newmark, 1.5)]
        {
            let error = |h: f64| (way_of_steps(scheme, 1.0, 0.5 * 9.81, h) - exact).abs();
            let fall = (error(1e-2) / error(1e-5)).log10() / 3.0;
            assert!(fall > order - 0.1, "{scheme:?} {fall}");
        }
    }
}
