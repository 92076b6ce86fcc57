//! The suite's own check: an experiment whose result is known and which misbehaves on demand, so that every exit
//! code can be tested end to end.

use super::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::{NonNegative, Positive};
use schemars::JsonSchema;
use serde::Deserialize;
use std::time::Duration;

/// A synthetic error `scale · ladder^order`, and how the run ends.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Selftest {
    /// How it behaves.
    mode: Mode,
    /// The exponent.
    #[serde(default)]
    order: Option<NonNegative>,
    /// The exponent of the method `second`, where it is another one.
    #[serde(default)]
    second_order: Option<NonNegative>,
    /// At larger values of the ladder the error is not yet the power.
    #[serde(default)]
    asymptotic_from: Option<Positive>,
    /// The factor.
    #[serde(default)]
    scale: Option<Positive>,
    /// How long a run takes [s].
    #[serde(default)]
    duration_s: Option<NonNegative>,
    /// The iterations it reports.
    #[serde(default)]
    iterations: Option<NonNegative>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Mode {
    /// The error it should have.
    Ok,
    /// An error that does not shrink along the ladder.
    Wrong,
    /// A panic.
    Panic,
    /// A run that never ends.
    Hang,
    /// The process aborts, as on a stack overflow.
    Abort,
    /// A result that depends on the number of threads.
    ThreadDependent,
    /// A result that is not a number.
    Nan,
    /// A result that differs from run to run.
    Random,
    /// A typed error.
    Error,
}

#[derive(Debug, thiserror::Error)]
#[error("selftest: no convergence at element {element}, residual {residual_n} N")]
struct Stopped {
    element: usize,
    residual_n: f64,
}

impl Experiment for Selftest {
    fn methods(&self) -> &'static [&'static str] {
        &["first", "second"]
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let scale = self.scale.map_or(1.0, Positive::value);
        let own = self.second_order.filter(|_| at.method == "second");
        let order = own.or(self.order).map_or(2.0, NonNegative::value);
        let mut error = scale * at.ladder.powf(order);
        if self.asymptotic_from.is_some_and(|from| at.ladder > from.value()) {
            error = scale;
        }
        clock.time(|| {
            std::thread::sleep(Duration::from_secs_f64(self.duration_s.map_or(0.0, NonNegative::value)))
        });
        match self.mode {
            Mode::Ok => {}
            Mode::Wrong => error = scale,
            Mode::Panic => panic!("selftest: index 7 is out of range"),
            Mode::Hang => loop {
                std::thread::sleep(Duration::from_secs(1));
            },
            Mode::Abort => std::process::abort(),
            Mode::ThreadDependent => error *= 1.0 + at.threads as f64 * f64::EPSILON,
            Mode::Nan => error = f64::NAN,
            Mode::Random => {
                error *= 1.0 + f64::from(std::process::id()) * f64::EPSILON * elapsed_nanoseconds()
            }
            Mode::Error => return Err(ExperimentError::stopped(Stopped { element: 12, residual_n: 0.5 })),
        }
        Ok(Outcome::default()
            .error("error", error)
            .count("iterations", self.iterations.map_or(3.0, NonNegative::value) as u64)
            .invariant("distance", 0.25 * at.ladder)
            .state(error.to_bits()))
    }
}

fn elapsed_nanoseconds() -> f64 {
    std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(1.0, |d| f64::from(d.subsec_nanos()))
}
