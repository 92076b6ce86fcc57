//! Energy over very many steps.

use super::reference::Reference;
use super::{counted, methods};
use crate::experiment::{Clock, Experiment, ExperimentError, Outcome, Point};
use crate::scene::quantity::Positive;
use lagrangian::integrator::drive;
use lagrangian::systems::DoublePendulum;
use lagrangian::{EulerLagrange, Phase, System};
use mechanics_core::state::StateHash;
use schemars::JsonSchema;
use serde::Deserialize;
use std::ops::ControlFlow;

/// A double pendulum over very many steps; the ladder is their number.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LongEnergy {
    /// A JSON file with parameters and start, relative to the scene.
    reference: String,
    /// The step h (s).
    step_s: Positive,
}

/// States between two looks at the energy.
const STRIDE: u64 = 7;

impl Experiment for LongEnergy {
    fn methods(&self) -> &'static [&'static str] {
        methods::FIXED_STEP
    }

    fn run(&self, at: &Point<'_>, clock: &mut Clock) -> Result<Outcome, ExperimentError> {
        let reference = Reference::read(at, &self.reference)?;
        let p = |name: &str| reference.parameter(name);
        let pendulum = DoublePendulum::new([p("m1")?, p("m2")?], [p("l1")?, p("l2")?], p("g")?);
        let system = EulerLagrange::new(pendulum.map_err(ExperimentError::stopped)?);
        let (q, v) = reference.start::<2>()?;
        let energy = system.energy(0.0, &q, &v);
        let mut integrator = methods::fixed_step(&system, at.method)?;
        let mut phase = Phase::new(0.0, q, v);
        let steps = at.ladder.round() as u64;
        let (mut worst, mut first, mut last): (f64, f64, f64) = (0.0, 0.0, 0.0);
        let mut step = 0;
        let report = clock
            .time(|| {
                drive::advance(
                    &system,
                    integrator.as_mut(),
                    &mut phase,
                    self.step_s.value(),
                    steps,
                    |phase, _| {
                        step += 1;
                        if step % STRIDE == 0 {
                            let off = (system.energy(phase.time, &phase.q, &phase.v) / energy - 1.0).abs();
                            worst = worst.max(off);
                            if step <= steps / 10 {
                                first = first.max(off);
                            } else if step > steps - steps / 10 {
                                last = last.max(off);
                            }
                        }
                        ControlFlow::Continue(())
                    },
                )
            })
            .map_err(ExperimentError::stopped)?;
        let mut hash = StateHash::new();
        hash.add("q", &phase.q);
        hash.add("v", &phase.v);
        let mut outcome = Outcome::default()
            .error("energy", worst)
            // Below 1e-12 both tenths are as good as exact.
            .error("growth", last.max(1e-12) / first.max(1e-12) - 1.0)
            .state(hash.value());
        outcome.simulated_seconds = Some(phase.time);
        Ok(counted(outcome, &report))
    }
}
