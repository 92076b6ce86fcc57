//! Hard cases of elastic bodies: no reference, but what must hold whatever happens. A step that does not converge ends the
//! row with the solver's own words.

mod beam;
mod body;
mod cloth;
mod mat;
mod refused;
mod released;
mod settled;

pub(super) use beam::HardBeam;
pub(super) use cloth::HardCloth;
pub(super) use mat::WrungMat;
pub(super) use refused::RefusedStart;
pub(super) use released::ReleasedBlock;

use super::contact::portrait::pictured;
use super::{ExperimentError, Outcome, Point};
use lagrangian::stepper::StepReport;
use mechanics_core::state::State;

/// What a run of many steps took.
#[derive(Default)]
struct Effort {
    steps: u64,
    iterations: u64,
    most_iterations: u64,
    halvings: u64,
    shifts: u64,
}

impl Effort {
    fn add(&mut self, report: &StepReport) {
        self.steps += 1;
        self.iterations += report.newton.iterations;
        self.most_iterations = self.most_iterations.max(report.newton.iterations);
        self.halvings += report.newton.halvings;
        self.shifts += report.newton.shifts;
    }

    /// `outcome` with these counts, and with a picture of the last state of a surface, coloured by speed.
    fn finished(
        &self,
        outcome: Outcome,
        at: &Point<'_>,
        state: &State,
        surface: &[[u32; 3]],
    ) -> Result<Outcome, ExperimentError> {
        let speeds = state.velocity.iter().map(|v| v.norm()).collect();
        pictured(self.counted(outcome, state), at, &state.position, surface, ("speed", "m/s", speeds))
    }

    /// `outcome` with these counts and the hash of the last state.
    fn counted(&self, outcome: Outcome, state: &State) -> Outcome {
        let mut outcome = outcome
            .count("steps", self.steps)
            .count("Newton iterations", self.iterations)
            .count("halvings", self.halvings)
            .count("shifts", self.shifts)
            .invariant("most iterations in a step", self.most_iterations as f64)
            .state(state.hash());
        outcome.simulated_seconds = Some(state.time);
        outcome
    }
}
