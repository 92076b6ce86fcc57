//! What a step did.

use mechanics_core::newton::NewtonReport;
use mechanics_core::objective::TermTimes;
use std::time::Duration;

/// One term's part in a step.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TermReport {
    /// The term's name.
    pub name: String,
    /// Where its time went.
    pub times: TermTimes,
}

/// What is known of the stationary point that a minimisation ended at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Minimum {
    /// Nothing: it was not asked for, or the linear solver iterates and cannot tell.
    #[default]
    Unverified,
    /// The true Hessian is positive definite there by more than rounding, which is taken to be 1e-13 of every entry of its
    /// diagonal: a strict minimum.
    Strict,
    /// It is not: a saddle (a column pressed along its axis by more than its buckling load), a body that nothing holds, or a
    /// mechanism.
    NotDefinite,
}

/// What a step did: integers that repeat exactly, and times.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StepReport {
    /// Newton's counts and times, summed over all minimisations of the step.
    pub newton: NewtonReport,
    /// How often lagged data was refreshed and the minimum found anew; 1 without friction.
    pub lag_iterations: u64,
    /// Times that the equations with lagged data of the solution itself were solved, since lagging did not settle.
    pub settlings: u64,
    /// Minimisations in which scripted points were pulled towards their targets; 0 where they could jump there.
    pub pulls: u64,
    /// What is known of the stationary point found; asked for by [`equilibrium`](super::Stepper::equilibrium).
    pub minimum: Minimum,
    /// Times that the pattern of the Hessian changed.
    pub pattern_changes: u64,
    /// Blocks of 3×3 numbers stored of the Hessian last assembled: one for each point with unknowns, and one for each pair of
    /// them that an element has in common. Contact adds blocks where it acts, and none elsewhere.
    pub hessian_blocks: u64,
    /// Every term: inertia first, then those given, in their order.
    pub terms: Vec<TermReport>,
    /// The whole step, by the clock on the wall.
    pub time: Duration,
}

/// Adds the counts and times of `more`.
pub(super) fn add(total: &mut NewtonReport, more: &NewtonReport) {
    total.iterations += more.iterations;
    total.halvings += more.halvings;
    total.limited_steps += more.limited_steps;
    total.accepted_by_slope += more.accepted_by_slope;
    total.at_rounding += more.at_rounding;
    total.unsettled += more.unsettled;
    total.values += more.values;
    total.gradients += more.gradients;
    total.directions += more.directions;
    total.factorisations += more.factorisations;
    total.linear_iterations += more.linear_iterations;
    total.shifts += more.shifts;
    total.changes += more.changes;
    total.times.value += more.times.value;
    total.times.gradient += more.times.gradient;
    total.times.assembly += more.times.assembly;
    total.times.solve += more.times.solve;
    total.times.limit_step += more.times.limit_step;
    total.times.freeze += more.times.freeze;
}
