//! Elastic bodies and their time-stepper: frequencies, motion, equilibria and position-based dynamics, each against a
//! closed form or a solution made to be exact.

mod cantilever;
mod damping;
mod frequency;
mod manufactured;
mod portrait;
mod position_based;
pub(super) mod schemes;
pub(super) mod solid;
mod standing_wave;
mod torsion;

pub(super) use cantilever::Cantilever;
pub(super) use damping::NodalDamping;
pub(super) use frequency::{BarOfSprings, BarOfTetrahedra};
pub(super) use manufactured::ManufacturedMotion;
pub(super) use position_based::PositionBasedSteps;
pub(super) use standing_wave::StandingWave;
pub(super) use torsion::Torsion;

use crate::experiment::{Clock, Outcome};
use lagrangian::stepper::StepReport;

/// `outcome` with what an equilibrium took, and the clock with its terms.
fn counted(outcome: Outcome, report: &StepReport, clock: &mut Clock) -> Outcome {
    clock.add_term("assembly", report.newton.times.assembly);
    clock.add_term("linear solve", report.newton.times.solve);
    outcome
        .count("Newton iterations", report.newton.iterations)
        .count("factorisations", report.newton.factorisations)
}
